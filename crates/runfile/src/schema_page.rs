//! The table as a Markdown page for people.

use std::fmt::Write as _;

use units::Units;

use super::dimension::DIMENSION_SCALES;
use super::header::{LINKED_GROUPS, ROOT_ATTRIBUTES};
use super::layout::{DatasetSpec, Group, Kind, Presence, Storage};
use super::record::{GROUP_ATTRIBUTES, OPTIONAL_GROUP_ATTRIBUTES};
use super::schema::{DATASET_ATTRIBUTES, MATRIX_ATTRIBUTES, MATRIX_MEMBERS};
use super::table::Layout;

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
    heading(&mut page, "Stages in files of their own");
    let _ = write!(
        page,
        "{LINKED_GROUPS} Its file type is `{}`.\n\n",
        layout.linked_filetype
    );
    attributes(
        &mut page,
        "Attributes of every stage group",
        GROUP_ATTRIBUTES,
    );
    attributes(
        &mut page,
        "Further attribute of a stage group in other units than metres and newtons",
        OPTIONAL_GROUP_ATTRIBUTES,
    );
    attributes(
        &mut page,
        "Attributes of every dataset and matrix",
        DATASET_ATTRIBUTES,
    );
    attributes(
        &mut page,
        "Further attributes of a matrix group",
        MATRIX_ATTRIBUTES,
    );
    attributes(&mut page, "Members of a matrix group", MATRIX_MEMBERS);
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
        let shape = if shape.is_empty() {
            "scalar".into()
        } else {
            format!("[{}]", shape.join(", "))
        };
        let kind = match spec.kind {
            Kind::Enum(_) => cell(&spec.kind.to_string()),
            kind => kind.tag().into(),
        };
        let name = format!("`{}`", spec.name());
        row(
            page,
            &[
                name,
                cell(spec.symbol),
                kind,
                shape,
                spec.dimension.to_string(),
                Units::SI.word(spec.dimension),
                meaning(spec),
            ],
        );
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
