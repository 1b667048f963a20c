//! The table of datasets as a JSON schema and as a page.

use serde_json::{Map, Value, json};
use units::{ForceUnit, LengthUnit, Units};

use super::dimension::{self, DIMENSION_SCALES};
use super::header::{LINKED_GROUPS, ROOT_ATTRIBUTES};
use super::layout::{DatasetSpec, Extent, Kind, Presence, Storage};
use super::record::{GROUP_ATTRIBUTES, OPTIONAL_GROUP_ATTRIBUTES};
use super::table::Layout;

/// The attributes every dataset and matrix group carries, with their meanings.
pub(super) const DATASET_ATTRIBUTES: &[(&str, &str, &str)] = &[
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
    (
        "digest",
        "text",
        "BLAKE3 over kind, shape and little-endian values, checked on reading",
    ),
];

/// The attributes a matrix group carries besides.
pub(super) const MATRIX_ATTRIBUTES: &[(&str, &str, &str)] = &[
    ("shape", "i64[2]", "rows, columns"),
    ("encoding-type", "text", "csc_matrix or csr_matrix"),
    (
        "encoding-version",
        "text",
        "version of the AnnData encoding",
    ),
];

/// The members of a matrix group.
pub(super) const MATRIX_MEMBERS: &[(&str, &str, &str)] = &[
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
        "linked_filetype": layout.linked_filetype,
        "linked_stages": LINKED_GROUPS,
        "stages": groups,
        "stage_attributes": triples(GROUP_ATTRIBUTES),
        "optional_stage_attributes": triples(OPTIONAL_GROUP_ATTRIBUTES),
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
