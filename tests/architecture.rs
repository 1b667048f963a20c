//! Dependencies between the rooms of the crate point one way.

use std::{collections::BTreeSet, fs, path::Path};

/// Each room with the rooms it may use.
const ALLOWED: [(&str, &[&str]); 18] = [
    ("linalg", &[]),
    ("scene", &[]),
    ("mesh", &["linalg", "scene"]),
    ("elasticity", &["linalg", "scene", "mesh"]),
    ("contact", &["linalg", "scene", "mesh", "elasticity"]),
    (
        "dual",
        &["linalg", "scene", "mesh", "elasticity", "contact"],
    ),
    (
        "solver",
        &["linalg", "scene", "mesh", "elasticity", "contact", "dual"],
    ),
    (
        "post",
        &[
            "linalg",
            "scene",
            "mesh",
            "elasticity",
            "contact",
            "dual",
            "solver",
        ],
    ),
    (
        "accuracy",
        &[
            "linalg",
            "scene",
            "mesh",
            "elasticity",
            "contact",
            "dual",
            "solver",
            "post",
        ],
    ),
    (
        "stability",
        &[
            "linalg",
            "scene",
            "mesh",
            "elasticity",
            "contact",
            "dual",
            "solver",
            "post",
        ],
    ),
    ("store", &[]),
    ("figures", &[]),
    ("report", &[]),
    (
        "format",
        &[
            "linalg",
            "scene",
            "mesh",
            "elasticity",
            "contact",
            "dual",
            "solver",
            "post",
            "accuracy",
            "stability",
            "store",
        ],
    ),
    (
        "stages",
        &[
            "linalg",
            "scene",
            "mesh",
            "elasticity",
            "contact",
            "dual",
            "solver",
            "post",
            "accuracy",
            "store",
            "figures",
            "report",
            "format",
        ],
    ),
    ("sweep", &["scene", "solver", "store", "format", "stages"]),
    ("suite", &["scene", "stability", "store", "format", "sweep"]),
    (
        "cli",
        &[
            "scene",
            "mesh",
            "contact",
            "dual",
            "solver",
            "post",
            "accuracy",
            "stability",
            "store",
            "format",
            "stages",
            "sweep",
            "suite",
        ],
    ),
];

fn sources(folder: &Path) -> Vec<String> {
    let mut texts = Vec::new();
    for entry in fs::read_dir(folder).expect("readable source folder") {
        let path = entry.expect("directory entry").path();
        if path.is_dir() {
            texts.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            texts.push(fs::read_to_string(&path).expect("readable source"));
        }
    }
    texts
}

/// The rooms named as `crate::room` anywhere, or inside a braced `use crate::{…}`.
fn rooms_used(text: &str) -> BTreeSet<String> {
    let mut rooms = BTreeSet::new();
    for after in text.split("crate::").skip(1) {
        if let Some(list) = after.strip_prefix('{') {
            let mut depth = 0;
            for item in list.split_inclusive([',', '{', '}']) {
                let name = item.trim().trim_end_matches([',', '{', '}']);
                if depth == 0 {
                    rooms.extend(name.split("::").next().map(|s| s.trim().to_owned()));
                }
                match item.chars().last() {
                    Some('{') => depth += 1,
                    Some('}') if depth == 0 => break,
                    Some('}') => depth -= 1,
                    _ => {}
                }
            }
        } else {
            rooms.extend(
                after
                    .split(|c: char| !c.is_alphanumeric() && c != '_')
                    .next()
                    .map(str::to_owned),
            );
        }
    }
    rooms
}

#[test]
fn rooms_use_only_rooms_before_them() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let names: BTreeSet<&str> = ALLOWED.iter().map(|(room, _)| *room).collect();
    for (room, allowed) in ALLOWED {
        for text in sources(&source.join(room)) {
            for used in rooms_used(&text) {
                let known = names.contains(used.as_str()) && used != room;
                assert!(
                    !known || allowed.contains(&used.as_str()),
                    "{room} may not use {used}"
                );
            }
        }
    }
}

#[test]
fn every_room_is_listed() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for entry in fs::read_dir(source).expect("readable source folder") {
        let path = entry.expect("directory entry").path();
        if path.is_dir() {
            let name = path
                .file_name()
                .and_then(|n| n.to_str())
                .expect("plain name")
                .to_owned();
            assert!(
                ALLOWED.iter().any(|(room, _)| *room == name),
                "{name} is not in the table"
            );
        }
    }
}

#[test]
fn the_scanner_sees_every_form_of_use() {
    let text = "use crate::{\n    mesh::{Mesh, Quality},\n    store::Stage,\n};\nuse crate::dual;\n crate::post::f();";
    let expected = ["dual", "mesh", "post", "store"].map(str::to_owned);
    assert_eq!(
        rooms_used(text)
            .into_iter()
            .filter(|r| !r.is_empty())
            .collect::<Vec<_>>(),
        expected
    );
}
