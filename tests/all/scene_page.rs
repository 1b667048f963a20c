//! The pages of `docs/reference` name every key and word of scenes and sweeps, and their examples are such files.

use std::{collections::BTreeSet, fs, path::Path};

use contact3d::scene::{FUNCTIONS, LAW_VARIABLES, Scene};
use contact3d_pipe::SweepFile;
use serde_json::Value;

/// Pages whose examples are parts of scenes.
const SCENE_PAGES: [&str; 7] = [
    "scene", "body", "material", "supports", "contact", "history", "solver",
];

fn page(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/reference");
    fs::read_to_string(folder.join(name).with_extension("md")).expect("the page")
}

/// The blocks of TOML on a page.
fn examples(page: &str) -> impl Iterator<Item = &str> {
    let blocks = page.split("```toml\n").skip(1);
    blocks.filter_map(|rest| rest.split("```").next())
}

/// What stands in code marks: `a.b.c` also counts as a, b and c.
fn named(page: &str) -> BTreeSet<&str> {
    let marked = page.split('`').skip(1).step_by(2);
    marked
        .flat_map(|text| text.split('.').chain([text]))
        .collect()
}

/// The keys of all tables and the words of all enumerations below a part of the JSON Schema.
fn keys<'a>(schema: &'a Value, found: &mut BTreeSet<&'a str>) {
    match schema {
        Value::Object(object) => {
            let properties = object.get("properties").and_then(Value::as_object);
            found.extend(
                properties
                    .into_iter()
                    .flatten()
                    .map(|(key, _)| key.as_str()),
            );
            found.extend(object.get("const").and_then(Value::as_str));
            object.values().for_each(|part| keys(part, found));
        }
        Value::Array(items) => items.iter().for_each(|part| keys(part, found)),
        _ => {}
    }
}

#[test]
fn every_key_word_function_and_variable_is_on_a_page() {
    let [scene, sweep] = [Scene::json_schema(), SweepFile::json_schema()]
        .map(|schema| serde_json::from_str::<Value>(&schema).expect("JSON"));
    let mut wanted: BTreeSet<&str> = FUNCTIONS.iter().chain(LAW_VARIABLES).copied().collect();
    keys(&scene, &mut wanted);
    assert!(wanted.len() > 70, "the schema was searched: {wanted:?}");
    keys(&sweep, &mut wanted);
    let pages: String = SCENE_PAGES.into_iter().chain(["sweep"]).map(page).collect();
    let named = named(&pages);
    let missing: Vec<_> = wanted.difference(&named).collect();
    assert!(missing.is_empty(), "not in docs/reference: {missing:?}");
}

/// The parts that each example leaves out.
const REST: [(&str, &str); 5] = [
    ("title", "title = 'example'\n"),
    (
        "body",
        "[body]\nelement = 'P2'\n[body.brick]\nsize = [3.0, 1.0, 1.0]\ncells = [6, 2, 2]\n",
    ),
    (
        "material",
        "[material.isotropic]\nyoung_modulus = 1.0\npoisson_ratio = 0.3\n",
    ),
    ("clamp", "[[clamp]]\nface = 'x_min'\n"),
    ("contact", "[contact]\nface = 'z_min'\n"),
];

#[test]
fn every_example_is_part_of_a_scene() {
    let pages = SCENE_PAGES.map(page);
    let examples: Vec<&str> = pages.iter().flat_map(|page| examples(page)).collect();
    assert!(examples.len() >= 15);
    for example in examples {
        let given: toml::Table = example.parse().expect("TOML");
        let missing =
            |(key, text): &(&str, &'static str)| (!given.contains_key(*key)).then_some(*text);
        let rest: Vec<&str> = REST.iter().filter_map(missing).collect();
        // Keys without a table must come first.
        let scene = if given.contains_key("title") {
            format!("{example}\n{}", rest.concat())
        } else {
            format!("{}\n{example}", rest.concat())
        };
        Scene::parse("example", &scene).unwrap_or_else(|error| panic!("{error}:\n{scene}"));
    }
}

#[test]
fn the_example_of_a_sweep_is_one() {
    let page = page("sweep");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sweep.toml");
    for example in examples(&page) {
        fs::write(&path, example).unwrap();
        SweepFile::read(&path).unwrap_or_else(|error| panic!("{error}:\n{example}"));
    }
}
