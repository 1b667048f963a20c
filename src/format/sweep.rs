//! `/cases` of a sweep's summary file: settings and main results of every case.

use runfile::{Extent, Extent::Named, Group, GroupWriter, Kind, Layout, Reader, StoreError};
use units::Dimension;

use super::{
    case::CaseResults,
    case_faces, extents,
    fields::{Table, fields},
};

/// The table of a sweep, in a file of its own.
pub const GROUP: Group = Group::new("cases", "sweep");

/// Every dataset of a sweep's summary file.
pub const SWEEP_LAYOUT: Layout = Layout {
    filetype: "contact3d-pipe sweep",
    linked_filetype: "contact3d-pipe sweep stage",
    format_version: [1, 3],
    sealed_since: [1, 2],
    creator: super::LAYOUT.creator,
    units: super::LAYOUT.units,
    groups: &[GROUP],
    tables: &[FIELDS.rows, case_faces::FIELDS.rows],
    extents: &[
        (
            "n_cases",
            "cases: those of the plan in its order, then older ones",
        ),
        ("n_keys", "keys of all axes"),
        (
            "n_case_faces",
            "contact faces of cases with several, each name once",
        ),
    ],
};

const SWEEP_FILE: &str = "/cases/sweep_file";
const KEYS: &str = "/cases/keys";
const ID: &str = "/cases/id";
const PLANNED: &str = "/cases/planned";

const CASES: &[Extent] = &[Named("n_cases")];
const VECTORS: &[Extent] = &[Named("n_cases"), extents::XYZ];

const FIELDS: Table<CaseRow> = fields! { CaseRow => GROUP;
    {Kind::Text} SWEEP_FILE, &[], Dimension::Number, "The sweep file, as seen from this folder.".optional("absent in tables of version 1.0").volatile();
    {Kind::Text} KEYS, &[Named("n_keys")], Dimension::Number, "Keys of the scene that the axes change.";
    (id) ID, CASES, Dimension::Number, "Name of the case; its run file is NAME.h5 in the same folder.";
    (planned) PLANNED, CASES, Dimension::Number, "1 for cases of the present axes, 0 for older ones in the folder.";
    (settings) "/cases/settings", CASES, Dimension::Number, "Values of the keys as a JSON object.";
    (setting_values) "/cases/setting_value", &[Named("n_cases"), Named("n_keys")], Dimension::Number, "Values of the keys in the scene's units; NaN where a value is no number.";
    (status) "/cases/status", CASES, Dimension::Number, "How the solve ended, as /solve/status says; failed for a case with an error, missing for one not yet run.";
    (error) "/cases/error", CASES, Dimension::Number, "The error of a failed case, else empty.";
    (results?.method) "/cases/method", CASES, Dimension::Number, "Algorithm that gave the answer, else empty.";
    (results?.counts[0]) "/cases/outer_steps", CASES, Dimension::Number, "Steps of successive approximations; -1 in this and other counts without a result.";
    (results?.counts[1]) "/cases/newton_steps", CASES, Dimension::Number, "Steps of Newton's method.";
    (results?.counts[2]) "/cases/applications", CASES, Dimension::Number, "Applications of the inverse stiffness matrix.".symbol("n_A").optional("named actions in tables before version 1.3");
    (results?.counts[2]) "/cases/actions", CASES, Dimension::Number, "The former name of applications.".symbol("n_A").when(("only in tables before version 1.3", |_| false));
    (results?.seconds) "/cases/seconds", CASES, Dimension::Time, "Wall-clock time of loads, solve and report.".volatile();
    (results?.accuracy) "/cases/accuracy", CASES, Dimension::Number, "As /solve/accuracy; NaN in this and the other measures without a result.";
    (results?.zones) "/cases/zone_counts", &[Named("n_cases"), extents::ZONES], Dimension::Number, "Numbers of open, sticking and slipping panes.";
    (results?.normal_force) "/cases/normal_force", CASES, Dimension::FORCE, "Total normal contact force.";
    (results?.tangential_force) "/cases/tangential_force", &[Named("n_cases"), extents::FRICTION_AXES], Dimension::FORCE, "Sum of area times tangential multiplier along t1 and t2.";
    (results?.contact_force) "/cases/contact_force", VECTORS, Dimension::FORCE, "Force of the foundation on the body.";
    (results?.largest_pressure) "/cases/largest_pressure", CASES, Dimension::STRESS, "Largest normal multiplier.";
    (results?.largest_displacement) "/cases/largest_displacement", VECTORS, Dimension::LENGTH, "Largest |u_x|, |u_y|, |u_z| of a node.";
    (results?.strain_energy) "/cases/strain_energy", CASES, Dimension::Energy, "Strain energy.";
    (results?.certificate) "/cases/certificate", &[Named("n_cases"), extents::CERTIFICATE_FIGURES], Dimension::Number, "Equilibrium, penetration, adhesion, complementarity, friction bound, slip direction, fixed point, as in /post/certificate.";
    (results?.solve_digest) "/cases/solve_digest", CASES, Dimension::Number, "Digest of the solution, else empty.";
};

/// One case of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseRow {
    /// Name of the case.
    pub id: String,
    /// Whether the present axes have it.
    pub planned: bool,
    /// Values of the keys as a JSON object.
    pub settings: String,
    /// The values that are numbers; NaN for others.
    pub setting_values: Vec<f64>,
    /// How the case ended.
    pub status: String,
    /// The error of a failed case.
    pub error: String,
    /// The results, where there are any.
    pub results: Option<CaseResults>,
}

/// Whose table a summary file holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableOwner {
    /// The sweep file, as seen from the folder; `None` in tables of version 1.0.
    pub sweep_file: Option<String>,
    /// All cases of the table.
    pub ids: Vec<String>,
    /// Those that the sweep planned when the table was written.
    pub planned: Vec<String>,
}

/// Reads whose table a summary file holds.
pub fn read_table_owner(reader: &Reader) -> Result<TableOwner, StoreError> {
    let ids = reader.read_texts(ID)?;
    let planned = reader.read_vec::<u8>(PLANNED)?;
    let planned = ids.iter().zip(planned).filter(|(_, planned)| *planned == 1);
    Ok(TableOwner {
        sweep_file: reader
            .has(SWEEP_FILE)
            .then(|| reader.read_text(SWEEP_FILE))
            .transpose()?,
        planned: planned.map(|(id, _)| id.clone()).collect(),
        ids,
    })
}

/// Writes the table of a sweep file, which is given as seen from the folder.
pub fn write(
    writer: &mut GroupWriter<'_>,
    sweep_file: Option<&str>,
    keys: &[String],
    rows: &[CaseRow],
) -> Result<(), StoreError> {
    if let Some(sweep_file) = sweep_file {
        writer.write_text(SWEEP_FILE, sweep_file)?;
    }
    let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
    writer.write_texts(KEYS, &keys)?;
    FIELDS.write_rows(writer, rows)?;
    let results = rows.iter().map(|row| row.results.as_ref());
    let faces = results.map(|results| results.map_or(&[][..], |results| &results.faces));
    case_faces::write(writer, &faces.collect::<Vec<_>>())
}
