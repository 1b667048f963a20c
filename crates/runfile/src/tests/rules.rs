//! The table is obeyed by writers, and printed whole.

use units::Dimension;

use super::sample::*;
use crate::{
    DatasetSpec, Extent, Home, Kind, Layout, LayoutError, SparseView, Stage, StageWriter,
    StoreError, Transaction, schema_json, schema_page,
};

/// The error of one call on a writer of a stage over a file with a mesh of 5 nodes.
fn refused(
    stage: Stage,
    call: impl Fn(&mut StageWriter<'_>) -> Result<(), StoreError>,
) -> LayoutError {
    let (_folder, file) = folder();
    save_mesh(&file, 5);
    let run_file = lock(&file).unwrap();
    let mut transaction = Transaction::begin(&run_file).unwrap();
    let mut writer = transaction.stage(stage, Home::RunFile).unwrap();
    match call(&mut writer) {
        Err(StoreError::Internal(error)) => error,
        other => panic!("{other:?}"),
    }
}

#[test]
fn writers_refuse_what_the_table_does_not_allow() {
    let unknown = refused(Stage::Mesh, |writer| {
        writer.write("/mesh/colour", &[1.0], &[1])
    });
    assert_eq!(
        unknown,
        LayoutError::Unknown {
            path: "/mesh/colour".into()
        }
    );
    let stage = refused(Stage::Mesh, |writer| {
        writer.write("/solve/energy", &[1.0], &[])
    });
    assert!(matches!(
        stage,
        LayoutError::Stage {
            owner: Stage::Solve,
            writing: Stage::Mesh,
            ..
        }
    ));
    let kind = refused(Stage::Mesh, |writer| {
        writer.write("/mesh/cells", &[1.0; 4], &[1, 4])
    });
    assert_eq!(kind.to_string(), "/mesh/cells holds i64, not f64");
    let rank = refused(Stage::Mesh, |writer| {
        writer.write("/mesh/coordinates", &[1.0; 3], &[3])
    });
    assert_eq!(
        rank.to_string(),
        "/mesh/coordinates: expected shape [n_nodes, 3], found shape [3]"
    );
    let length = refused(Stage::Mesh, |writer| {
        writer.write("/mesh/coordinates", &[1.0; 5], &[2, 3])
    });
    assert!(matches!(length, LayoutError::Length { found: 5, .. }));
    let twice = refused(Stage::Mesh, |writer| {
        writer.write("/mesh/offsets", &[0_i64], &[1])?;
        writer.write("/mesh/offsets", &[0_i64], &[1])
    });
    assert_eq!(
        twice,
        LayoutError::Twice {
            path: "/mesh/offsets".into()
        }
    );
    let plus = refused(Stage::Mesh, |writer| {
        writer.write("/mesh/tags", &[0_u8; 2], &[2])?;
        writer.write("/mesh/offsets", &[0_i64; 2], &[2])
    });
    assert!(
        plus.to_string()
            .contains("[n_cells + 1 where n_cells = 2 by /mesh/tags]"),
        "{plus}"
    );
    let zero = refused(Stage::Mesh, |writer| {
        writer.write_texts("/mesh/names", &["a\0b"])
    });
    assert!(matches!(zero, LayoutError::Value { .. }));
}

#[test]
fn sizes_agree_with_upstream_stages_and_within_a_dataset() {
    let upstream = refused(Stage::Solve, |writer| {
        writer.write_enum("/solve/zone", &zones(6), &[6])
    });
    assert_eq!(
        upstream.to_string(),
        "/solve/zone: expected shape [n_nodes where n_nodes = 5 by /mesh/coordinates], found shape [6]"
    );
    let matrix = SparseView {
        shape: [5, 6],
        indptr: &[0; 7],
        indices: &[],
        data: &[],
    };
    assert!(matches!(
        refused(Stage::Solve, |writer| writer
            .write_matrix("/solve/stiffness", matrix)),
        LayoutError::Shape { .. }
    ));
    let broken = SparseView {
        shape: [5, 5],
        indptr: &[0; 7],
        indices: &[],
        data: &[],
    };
    assert!(matches!(
        refused(Stage::Solve, |writer| writer
            .write_matrix("/solve/stiffness", broken)),
        LayoutError::Value { .. }
    ));
    let not_a_matrix = refused(Stage::Solve, |writer| {
        writer.write_matrix("/solve/energy", broken)
    });
    assert!(matches!(not_a_matrix, LayoutError::Kind { .. }));
}

#[test]
fn a_stage_ends_with_all_its_required_datasets() {
    let (_folder, file) = folder();
    let run_file = lock(&file).unwrap();
    let mut transaction = Transaction::begin(&run_file).unwrap();
    let mut writer = transaction.stage(Stage::Mesh, Home::RunFile).unwrap();
    writer.write("/mesh/tags", &[1_u8], &[1]).unwrap();
    let Err(StoreError::Internal(LayoutError::NotWritten { missing, .. })) =
        writer.finish(&record())
    else {
        panic!("a stage without its datasets was finished")
    };
    assert_eq!(
        missing,
        [
            "/mesh/coordinates",
            "/mesh/cells",
            "/mesh/offsets",
            "/mesh/names"
        ]
    );
    let unfinished = transaction.commit().unwrap_err();
    assert!(unfinished.is_internal());
    assert!(!file.exists());
}

#[test]
fn a_sound_table_has_no_problems_and_a_bad_one_has_each() {
    assert_eq!(SAMPLE.problems(), [""; 0]);
    const BAD: &[DatasetSpec] = &[
        Stage::Mesh.row(
            "/mesh/a",
            Kind::F64,
            &[Extent::Named("n_a")],
            Dimension::Number,
            "",
        ),
        Stage::Mesh
            .row("/mesh/a", Kind::F64, &[], Dimension::Number, "A.")
            .optional(""),
        Stage::Mesh.row("/solve/b", Kind::CscMatrix, &[], Dimension::Number, "B."),
        Stage::Mesh.row("/mesh/a/c", Kind::F64, &[], Dimension::Number, "C."),
    ];
    let problems = Layout {
        tables: &[BAD],
        extents: &[("n_b", "b")],
        ..SAMPLE
    }
    .problems();
    let all = problems.join("\n");
    for part in [
        "/mesh/a: listed twice",
        "/mesh/a: has no meaning",
        "/mesh/a: is optional without a reason",
        "/solve/b: not below the group of its stage",
        "/solve/b: has a rank its kind cannot have",
        "/mesh/a: another dataset lies inside it",
        "size n_a is not explained",
        "size n_b is explained but not used",
    ] {
        assert!(all.contains(part), "{part} is not among\n{all}");
    }
}

#[test]
fn schemas_hold_every_row() {
    let document: serde_json::Value = serde_json::from_str(&schema_json(&SAMPLE)).unwrap();
    let rows = document["datasets"].as_array().unwrap();
    assert_eq!(rows.len(), SAMPLE.datasets().count());
    let find = |path: &str| rows.iter().find(|row| row["path"] == path).unwrap();
    assert_eq!(
        find("/mesh/coordinates")["shape"],
        serde_json::json!(["n_nodes", 3])
    );
    assert_eq!(
        find("/mesh/offsets")["shape"],
        serde_json::json!(["n_cells + 1"])
    );
    assert_eq!(find("/solve/zone")["enum"]["members"]["slip"], 2);
    assert_eq!(
        find("/mesh/title")["optional_because"],
        "a mesh may be unnamed"
    );
    let page = schema_page(&SAMPLE);
    for spec in SAMPLE.datasets() {
        assert!(
            page.contains(&format!("| `{}` |", spec.name())),
            "{} is not on the page",
            spec.path
        );
    }
    assert!(page.contains("| `n_outer` | number of outer iterations |"));
}
