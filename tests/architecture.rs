//! Dependencies between the rooms of the crate point one way.

use std::{collections::BTreeSet, fs, path::Path};

/// The core: each room may use those before it, except where [`APART`] says otherwise.
const CORE: [&str; 11] = [
    "units",
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
];

/// Pairs of core rooms that know nothing of each other.
const APART: [(&str, &str); 2] = [("scene", "linalg"), ("stability", "accuracy")];

/// The rooms around the core, with the other such rooms that each may use, and whether it may use the core.
const AROUND: [(&str, &[&str], bool); 9] = [
    ("store", &["units"], false),
    ("output", &["store"], false),
    ("figures", &["units"], false),
    ("report", &[], false),
    ("format", &["store"], true),
    (
        "stages",
        &["store", "output", "figures", "report", "format"],
        true,
    ),
    ("sweep", &["store", "output", "format", "stages"], true),
    ("suite", &["store", "output", "format", "sweep"], true),
    (
        "cli",
        &["store", "output", "format", "stages", "sweep", "suite"],
        true,
    ),
];

/// Whether a room is in the tables.
fn is_room(name: &str) -> bool {
    CORE.contains(&name) || AROUND.iter().any(|(room, ..)| *room == name)
}

fn may_use(room: &str, used: &str) -> bool {
    let place = |name: &str| CORE.iter().position(|core| *core == name);
    if let Some(own) = place(room) {
        return place(used).is_some_and(|other| other < own) && !APART.contains(&(room, used));
    }
    AROUND.iter().any(|(around, others, core)| {
        *around == room && (others.contains(&used) || *core && place(used).is_some())
    })
}

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
    for room in CORE.into_iter().chain(AROUND.map(|(room, ..)| room)) {
        for text in sources(&source.join(room)) {
            for used in rooms_used(&text) {
                let allowed = used == room || !is_room(&used) || may_use(room, &used);
                assert!(allowed, "{room} may not use {used}");
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
            assert!(is_room(&name), "{name} is not in the tables");
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
