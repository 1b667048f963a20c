//! Words with which serde also reads what a schema lists.

use std::{
    fs,
    path::{Path, PathBuf},
};

use contact3d::scene::Scene;

/// All files of Rust below a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|end| end == "rs") {
            files.push(path);
        }
    }
    files
}

/// Scenes are checked against their schema first, so an alias that is not in it would be refused.
#[test]
fn every_alias_of_serde_is_in_the_schema() {
    let schema: serde_json::Value = serde_json::from_str(&Scene::json_schema()).unwrap();
    let mut listed = Vec::new();
    let mut rest = vec![&schema];
    while let Some(value) = rest.pop() {
        match value {
            serde_json::Value::Object(map) => {
                let aliases = map.get("aliases").and_then(|list| list.as_array());
                listed.extend(
                    aliases
                        .into_iter()
                        .flatten()
                        .filter_map(|word| word.as_str()),
                );
                rest.extend(map.values());
            }
            serde_json::Value::Array(items) => rest.extend(items),
            _ => {}
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = 0;
    for file in [root.join("src"), root.join("../units/src")]
        .iter()
        .flat_map(|f| sources(f))
    {
        let text = fs::read_to_string(&file).unwrap();
        for attribute in text.split("serde(").skip(1) {
            let attribute = attribute.split(")]").next().unwrap_or_default();
            for alias in attribute.split("alias = \"").skip(1) {
                let word = alias.split('"').next().unwrap_or_default();
                assert!(listed.contains(&word), "{word} of {}", file.display());
                found += 1;
            }
        }
    }
    assert!(found > 0, "aliases are found by their text");
}
