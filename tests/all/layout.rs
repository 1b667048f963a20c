//! The table of datasets is sound, and the schemas in the repository are generated from it.

use contact3d::scene::Scene;
use contact3d_pipe::{LAYOUT, SERIES_LAYOUT, STABILITY_LAYOUT, SWEEP_LAYOUT, SweepFile};
use runfile::{schema_json, schema_page};

#[test]
fn the_table_of_datasets_obeys_its_rules() {
    assert_eq!(LAYOUT.problems(), Vec::<String>::new());
    assert_eq!(SWEEP_LAYOUT.problems(), Vec::<String>::new());
    assert_eq!(SERIES_LAYOUT.problems(), Vec::<String>::new());
    assert_eq!(STABILITY_LAYOUT.problems(), Vec::<String>::new());
    assert!(LAYOUT.datasets().count() > 60);
}

#[test]
fn schemas_in_the_repository_are_up_to_date() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas");
    for (name, text) in [
        ("run_file.json", schema_json(&LAYOUT)),
        ("run_file.md", schema_page(&LAYOUT)),
        ("scene.json", Scene::json_schema()),
        ("series.json", schema_json(&SERIES_LAYOUT)),
        ("stability.json", schema_json(&STABILITY_LAYOUT)),
        ("sweep.json", SweepFile::json_schema()),
        ("sweep_summary.json", schema_json(&SWEEP_LAYOUT)),
    ] {
        let stored = std::fs::read_to_string(folder.join(name)).unwrap_or_default();
        assert!(
            stored == text,
            "schemas/{name} is stale; run `contact3d-pipe schema`"
        );
    }
}
