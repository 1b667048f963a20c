//! The table of datasets is sound, and the schemas are generated from it.

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
        ("run_file.md", schema_page(&LAYOUT)),
        ("scene.json", Scene::json_schema()),
        ("sweep.json", SweepFile::json_schema()),
    ] {
        let stored = std::fs::read_to_string(folder.join(name)).unwrap_or_default();
        assert!(
            stored == text,
            "schemas/{name} is stale; run `contact3d-pipe schema`"
        );
    }
}

/// Those that only programs read are not in the repository.
#[test]
fn schemas_of_all_files_are_valid() {
    for layout in [LAYOUT, SWEEP_LAYOUT, SERIES_LAYOUT, STABILITY_LAYOUT] {
        let schema: serde_json::Value = serde_json::from_str(&schema_json(&layout)).expect("JSON");
        assert_eq!(schema["filetype"], layout.filetype);
        let rows = schema["datasets"].as_array().expect("datasets");
        assert_eq!(rows.len(), layout.datasets().count());
        for row in rows {
            for key in ["path", "stage", "type", "unit", "description"] {
                assert!(
                    row[key].as_str().is_some_and(|text| !text.is_empty()),
                    "{row}"
                );
            }
            let stages = schema["stages"].as_array().expect("stages");
            let stage = format!("/{}", row["stage"].as_str().unwrap_or_default());
            assert!(stages.iter().any(|known| *known == stage.as_str()), "{row}");
            let extents = row["shape"].as_array().expect("a shape").iter();
            for name in extents.filter_map(|extent| extent.as_str()) {
                let name = name.split(' ').next().unwrap_or_default();
                assert!(schema["extents"][name].is_string(), "{row}");
            }
        }
    }
}

/// JSON Schema reads a limit beside the type of a number, not beside that of the list or table that holds it.
#[test]
fn limits_of_the_scene_stand_beside_numbers() {
    let schema: serde_json::Value = serde_json::from_str(&Scene::json_schema()).expect("JSON");
    let item = |key: &str| schema.pointer(&format!("/$defs/{key}")).expect(key).clone();
    assert_eq!(item("Brick/properties/size/items/exclusiveMinimum"), 0);
    assert_eq!(item("Brick/properties/cells/items/minimum"), 1);
    assert_eq!(item("Grid/properties/value/items/items/minimum"), 1e-100);
    assert_eq!(
        item("Coefficient/oneOf/0/properties/constant/minimum"),
        1e-100
    );
    assert!(
        schema
            .pointer("/$defs/Brick/properties/size/exclusiveMinimum")
            .is_none()
    );
}
