//! The table is obeyed by writers, and printed whole.

use units::Dimension;

use crate::sample::*;
use contact3d_runfile::{
    DatasetSpec, Extent, Group, GroupWriter, Kind, Layout, LayoutError, SparseView, StoreError,
    Transaction, schema_json, schema_page,
};

/// The error of one call on a writer of a group over a file with a grid of 5 nodes.
fn refused(
    group: Group,
    call: impl Fn(&mut GroupWriter<'_>) -> Result<(), StoreError>,
) -> LayoutError {
    let (_folder, file) = folder();
    save_grid(&file, 5);
    let run_file = lock(&file).unwrap();
    let mut transaction = Transaction::begin(&run_file).unwrap();
    let mut writer = transaction.group(group).unwrap();
    match call(&mut writer) {
        Err(StoreError::Internal(error)) => error,
        other => panic!("{other:?}"),
    }
}

#[test]
fn writers_refuse_what_the_table_does_not_allow() {
    let words = |group, call: &dyn Fn(&mut GroupWriter<'_>) -> Result<(), StoreError>| {
        refused(group, call).to_string()
    };
    let coordinates = |values: &[f64], shape: &[usize]| {
        words(GRID, &|writer| {
            writer.write("/grid/coordinates", values, shape)
        })
    };
    assert_eq!(
        words(GRID, &|writer| writer.write("/grid/colour", &[1.0], &[1])),
        "/grid/colour is not in the table"
    );
    assert_eq!(
        words(GRID, &|writer| writer.write("/field/energy", &[1.0], &[])),
        "/field/energy belongs to the group `field`, not to `grid`"
    );
    assert_eq!(
        words(GRID, &|writer| writer.write("/grid/cells", &[1.0], &[1, 4])),
        "/grid/cells holds i64, not f64"
    );
    assert_eq!(
        coordinates(&[1.0; 3], &[3]),
        "/grid/coordinates: expected shape [n_nodes, 3], found shape [3]"
    );
    assert_eq!(
        coordinates(&[1.0; 5], &[2, 3]),
        "/grid/coordinates: 5 values do not fill the shape [2, 3]"
    );
    let twice = refused(GRID, |writer| {
        writer.write("/grid/offsets", &[0_i64], &[1])?;
        writer.write("/grid/offsets", &[0_i64], &[1])
    });
    assert_eq!(
        twice,
        LayoutError::Twice {
            path: "/grid/offsets".into()
        }
    );
    let plus = refused(GRID, |writer| {
        writer.write("/grid/tags", &[0_u8; 2], &[2])?;
        writer.write("/grid/offsets", &[0_i64; 2], &[2])
    });
    assert!(
        plus.to_string()
            .contains("[n_cells + 1 where n_cells = 2 by /grid/tags]"),
        "{plus}"
    );
    let zero = words(GRID, &|writer| writer.write_texts("/grid/names", &["a\0b"]));
    assert!(
        zero.starts_with("/grid/names: text cannot be stored"),
        "{zero}"
    );
}

#[test]
fn sizes_agree_with_upstream_groups_and_within_a_dataset() {
    let upstream = refused(FIELD, |writer| {
        writer.write_enum("/field/zone", &states(6), &[6])
    });
    assert_eq!(
        upstream.to_string(),
        "/field/zone: expected shape [n_nodes where n_nodes = 5 by /grid/coordinates], found shape [6]"
    );
    let matrix = |path: &str, columns: usize| {
        let matrix = SparseView {
            shape: [5, columns],
            indptr: &[0; 7],
            indices: &[],
            data: &[],
        };
        refused(FIELD, |writer| writer.write_matrix(path, matrix)).to_string()
    };
    let large = matrix("/field/stiffness", 6);
    assert!(large.contains("found shape [5, 6]"), "{large}");
    let broken = matrix("/field/stiffness", 5);
    assert!(broken.contains("indptr has 7 values"), "{broken}");
    let number = matrix("/field/energy", 5);
    assert_eq!(number, "/field/energy holds f64, not csc_matrix");
}

#[test]
fn a_group_ends_with_all_its_required_datasets() {
    let (_folder, file) = folder();
    let run_file = lock(&file).unwrap();
    let mut transaction = Transaction::begin(&run_file).unwrap();
    let mut writer = transaction.group(GRID).unwrap();
    writer.write("/grid/tags", &[1_u8], &[1]).unwrap();
    let Err(StoreError::Internal(LayoutError::NotWritten { missing, .. })) =
        writer.finish(&record())
    else {
        panic!("a group without its datasets was finished")
    };
    assert_eq!(
        missing,
        [
            "/grid/coordinates",
            "/grid/cells",
            "/grid/offsets",
            "/grid/names"
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
        GRID.row(
            "/grid/a",
            Kind::F64,
            &[Extent::Named("n_a")],
            Dimension::Number,
            "",
        ),
        GRID.row("/grid/a", Kind::F64, &[], Dimension::Number, "A.")
            .optional(""),
        GRID.row("/field/b", Kind::CscMatrix, &[], Dimension::Number, "B."),
        GRID.row("/grid/a/c", Kind::F64, &[], Dimension::Number, "C."),
    ];
    const FIELD_ROW: &[DatasetSpec] =
        &[FIELD.row("/field/d", Kind::F64, &[], Dimension::Number, "D.")];
    let problems = Layout {
        groups: &[GRID, NOTES, GRID],
        tables: &[BAD, FIELD_ROW],
        extents: &[("n_b", "b")],
        ..SAMPLE
    }
    .problems();
    let all = problems.join("\n");
    for part in [
        "/grid: listed twice",
        "/field/d: its group is not listed",
        "/grid/a: listed twice",
        "/grid/a: has no meaning",
        "/grid/a: is optional without a reason",
        "/field/b: not below its group",
        "/field/b: has a rank its kind cannot have",
        "/grid/a: another dataset lies inside it",
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
        find("/grid/coordinates")["shape"],
        serde_json::json!(["n_nodes", 3])
    );
    assert_eq!(
        find("/grid/offsets")["shape"],
        serde_json::json!(["n_cells + 1"])
    );
    assert_eq!(find("/field/zone")["enum"]["members"]["slip"], 2);
    assert_eq!(
        find("/grid/title")["optional_because"],
        "a grid may be unnamed"
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
