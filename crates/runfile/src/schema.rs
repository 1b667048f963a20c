//! The table of datasets as a JSON schema, and as a Markdown page for people.

use std::fmt::Write as _;

use serde_json::{Map, Value, json};
use units::{ForceUnit, LengthUnit, Units};

use crate::dimension;
use crate::dimension::DIMENSION_SCALES;
use crate::header::{FILE_DIGEST, GROUP_ATTRIBUTES, LINKED_GROUPS, ROOT_ATTRIBUTES};
use crate::layout::{DatasetSpec, Extent, Group, Kind, Layout, Presence, Storage};

/// The attributes every dataset and matrix group carries, with their meanings.
const DATASET_ATTRIBUTES: &[(&str, &str, &str)] = &[
    (
        "units",
        "text",
        "unit of the values, in the units of the stage",
    ),
    (
        "symbol",
        "text",
        "symbol of the quantity in the model, may be empty",
    ),
    ("description", "text", "meaning"),
];

/// The attributes a matrix group carries besides.
const MATRIX_ATTRIBUTES: &[(&str, &str, &str)] = &[
    ("shape", "i64[2]", "rows, columns"),
    ("encoding-type", "text", "csc_matrix or csr_matrix"),
    (
        "encoding-version",
        "text",
        "version of the AnnData encoding",
    ),
];

/// The members of a matrix group.
const MATRIX_MEMBERS: &[(&str, &str, &str)] = &[
    ("data", "f64", "values of the entries"),
    ("indices", "i64", "row (CSC) or column (CSR) of each entry"),
    (
        "indptr",
        "i64",
        "start of each column (CSC) or row (CSR), then the number of entries",
    ),
];

/// The table as a JSON document, ending with a newline.
///
/// The creator is left out: the schema changes with the format, not with the version of the
/// program.
#[must_use]
pub fn schema_json(layout: &Layout) -> String {
    let groups: Vec<_> = layout.groups().map(|group| format!("/{group}")).collect();
    let extents: Map<_, _> = layout
        .extents
        .iter()
        .map(|(name, meaning)| (name.to_string(), json!(meaning)))
        .collect();
    let document = json!({
        "filetype": layout.filetype,
        "format_version": layout.format_version,
        "root_attributes": triples(ROOT_ATTRIBUTES),
        "file_digest": FILE_DIGEST,
        "linked_filetype": layout.linked_filetype,
        "linked_stages": LINKED_GROUPS,
        "stages": groups,
        "stage_attributes": triples(GROUP_ATTRIBUTES),
        "length_units": LengthUnit::ALL.map(LengthUnit::word),
        "force_units": ForceUnit::ALL.map(ForceUnit::word),
        "dataset_attributes": triples(DATASET_ATTRIBUTES),
        "matrix_attributes": triples(MATRIX_ATTRIBUTES),
        "matrix_members": triples(MATRIX_MEMBERS),
        "dimension_scales": DIMENSION_SCALES,
        "extents": extents,
        "datasets": layout.datasets().map(dataset).collect::<Vec<_>>(),
    });
    format!("{document:#}\n")
}

fn triples(rows: &[(&str, &str, &str)]) -> Value {
    rows.iter()
        .map(|(name, kind, meaning)| json!({"name": name, "type": kind, "description": meaning}))
        .collect()
}

fn dataset(spec: &DatasetSpec) -> Value {
    let mut row = json!({
        "path": spec.path,
        "stage": spec.group.name(),
        "type": spec.kind.tag(),
        "shape": spec.shape.iter().map(extent).collect::<Vec<_>>(),
        "dimensions": dimension::names(spec.shape),
        "dimension": spec.dimension.to_string(),
        "unit": Units::SI.word(spec.dimension),
        "symbol": spec.symbol,
        "description": spec.description,
        "required": spec.presence == Presence::Required,
        "storage": match spec.storage { Storage::Plain => "plain", Storage::Compressed => "compressed" },
        "in_stage_digest": !spec.volatile,
    });
    if let Presence::Optional(reason) = spec.presence {
        row["optional_because"] = json!(reason);
    }
    let labelled = spec.shape.iter().filter_map(|extent| match extent {
        Extent::Labelled(axis) => Some((axis.name.to_owned(), json!(axis.labels))),
        Extent::Fixed(_) | Extent::Named(_) | Extent::Plus(..) => None,
    });
    let labels: Map<_, _> = labelled.collect();
    if !labels.is_empty() {
        row["labels"] = labels.into();
    }
    if let Kind::Enum(members) = spec.kind {
        let codes: Map<_, _> = members
            .members
            .iter()
            .map(|(name, code)| (name.to_string(), json!(code)))
            .collect();
        row["enum"] = json!({"name": members.name, "members": codes});
    }
    row
}

fn extent(extent: &Extent) -> Value {
    match extent {
        Extent::Fixed(size) => json!(size),
        Extent::Labelled(axis) => json!(axis.labels.len()),
        symbolic => json!(symbolic.to_string()),
    }
}

/// The table as a Markdown page: the file, its groups one by one, and the symbolic sizes.
#[must_use]
pub fn schema_page(layout: &Layout) -> String {
    let [major, minor] = layout.format_version;
    let mut page = format!(
        "# The run file\n\nGenerated from the table of datasets; do not edit.\n\nOne HDF5 file of type \
         `{}`, format version {major}.{minor}. Readers take the same major and any older minor version. \
         Units are words for force F and length L, here those of a scene that names none.\n\n",
        layout.filetype
    );
    attributes(&mut page, "Attributes of the root", ROOT_ATTRIBUTES);
    let _ = write!(page, "{FILE_DIGEST}\n\n");
    heading(&mut page, "Stages in files of their own");
    let filetype = layout.linked_filetype;
    let _ = write!(page, "{LINKED_GROUPS} Its file type is `{filetype}`.\n\n");
    for (title, rows) in [
        ("Attributes of every stage group", GROUP_ATTRIBUTES),
        ("Attributes of every dataset and matrix", DATASET_ATTRIBUTES),
        ("Further attributes of a matrix group", MATRIX_ATTRIBUTES),
        ("Members of a matrix group", MATRIX_MEMBERS),
    ] {
        attributes(&mut page, title, rows);
    }
    for group in layout.groups() {
        group_section(&mut page, layout, group);
    }
    let _ = write!(page, "## Names of axes\n\n{DIMENSION_SCALES}\n\n");
    page.push_str("## Sizes\n\n| Name | Meaning |\n|---|---|\n");
    for (name, meaning) in layout.extents {
        row(&mut page, &[format!("`{name}`"), cell(meaning)]);
    }
    page
}

fn attributes(page: &mut String, title: &str, rows: &[(&str, &str, &str)]) {
    heading(page, title);
    page.push_str("| Name | Type | Meaning |\n|---|---|---|\n");
    for (name, kind, meaning) in rows {
        row(page, &[format!("`{name}`"), cell(kind), cell(meaning)]);
    }
    page.push('\n');
}

fn group_section(page: &mut String, layout: &Layout, group: Group) {
    heading(page, &format!("`/{group}`"));
    page.push_str(
        "| Dataset | Symbol | Type | Shape | Dimension | Unit | Meaning |\n|---|---|---|---|---|---|---|\n",
    );
    for spec in layout.of_group(group) {
        let shape: Vec<_> = spec.shape.iter().map(ToString::to_string).collect();
        let shape = match shape.join(", ") {
            scalar if scalar.is_empty() => "scalar".into(),
            extents => format!("[{extents}]"),
        };
        let cells = [
            format!("`{}`", spec.name()),
            cell(spec.symbol),
            cell(&spec.kind.to_string()),
            shape,
            spec.dimension.to_string(),
            Units::SI.word(spec.dimension),
            meaning(spec),
        ];
        row(page, &cells);
    }
    page.push('\n');
}

fn meaning(spec: &DatasetSpec) -> String {
    let mut meaning = cell(spec.description);
    if let Presence::Optional(reason) = spec.presence {
        let _ = write!(meaning, " Optional: {}.", cell(reason));
    }
    if spec.storage == Storage::Compressed {
        meaning.push_str(if spec.kind.is_matrix() {
            " Indices compressed."
        } else {
            " Compressed."
        });
    }
    if spec.volatile {
        meaning.push_str(" Not in the digest of the stage.");
    }
    meaning
}

fn heading(page: &mut String, title: &str) {
    let _ = write!(page, "## {title}\n\n");
}

fn row(page: &mut String, cells: &[String]) {
    let _ = writeln!(page, "| {} |", cells.join(" | "));
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}
