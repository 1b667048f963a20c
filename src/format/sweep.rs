//! `/cases` of a sweep's summary file: settings and main results of every case.

use runfile::{
    DatasetSpec, Extent, Extent::Named, Group, GroupWriter, Kind, Layout, Reader, StoreError,
};
use units::Dimension;

use super::{axes, case::CaseResults, case_faces, columns::Columns};

/// The table of a sweep, in a file of its own.
pub const GROUP: Group = Group::new("cases", "sweep");

/// Every dataset of a sweep's summary file.
pub const SWEEP_LAYOUT: Layout = Layout {
    filetype: "contact3d-pipe sweep",
    linked_filetype: "contact3d-pipe sweep stage",
    format_version: [1, 2],
    sealed_since: [1, 2],
    creator: super::LAYOUT.creator,
    units: super::LAYOUT.units,
    groups: &[GROUP],
    tables: &[TABLE, case_faces::TABLE],
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
const SETTINGS: &str = "/cases/settings";
const SETTING_VALUE: &str = "/cases/setting_value";
const STATUS: &str = "/cases/status";
const ERROR: &str = "/cases/error";
const METHOD: &str = "/cases/method";
const OUTER_STEPS: &str = "/cases/outer_steps";
const NEWTON_STEPS: &str = "/cases/newton_steps";
const APPLICATIONS: &str = "/cases/actions";
const SECONDS: &str = "/cases/seconds";
const ACCURACY: &str = "/cases/accuracy";
const ZONE_COUNTS: &str = "/cases/zone_counts";
const NORMAL_FORCE: &str = "/cases/normal_force";
const TANGENTIAL_FORCE: &str = "/cases/tangential_force";
const CONTACT_FORCE: &str = "/cases/contact_force";
const LARGEST_PRESSURE: &str = "/cases/largest_pressure";
const LARGEST_DISPLACEMENT: &str = "/cases/largest_displacement";
const STRAIN_ENERGY: &str = "/cases/strain_energy";
const CERTIFICATE_FIGURES: &str = "/cases/certificate";
const SOLVE_DIGEST: &str = "/cases/solve_digest";

const CASES: &[Extent] = &[Named("n_cases")];
const VECTORS: &[Extent] = &[Named("n_cases"), axes::XYZ];

#[rustfmt::skip]
const TABLE: &[DatasetSpec] = &[
    GROUP.row(SWEEP_FILE, Kind::Text, &[], Dimension::Number, "The sweep file, as seen from this folder.").optional("absent in tables of version 1.0").volatile(),
    GROUP.row(KEYS, Kind::Text, &[Named("n_keys")], Dimension::Number, "Keys of the scene that the axes change."),
    GROUP.row(ID, Kind::Text, CASES, Dimension::Number, "Name of the case; its run file is NAME.h5 in the same folder."),
    GROUP.row(PLANNED, Kind::U8, CASES, Dimension::Number, "1 for cases of the present axes, 0 for older ones in the folder."),
    GROUP.row(SETTINGS, Kind::Text, CASES, Dimension::Number, "Values of the keys as a JSON object."),
    GROUP.row(SETTING_VALUE, Kind::F64, &[Named("n_cases"), Named("n_keys")], Dimension::Number, "Values of the keys in the scene's units; NaN where a value is no number."),
    GROUP.row(STATUS, Kind::Text, CASES, Dimension::Number, "How the solve ended, as /solve/status says; failed for a case with an error, missing for one not yet run."),
    GROUP.row(ERROR, Kind::Text, CASES, Dimension::Number, "The error of a failed case, else empty."),
    GROUP.row(METHOD, Kind::Text, CASES, Dimension::Number, "Algorithm that gave the answer, else empty."),
    GROUP.row(OUTER_STEPS, Kind::I64, CASES, Dimension::Number, "Steps of successive approximations; -1 in this and other counts without a result."),
    GROUP.row(NEWTON_STEPS, Kind::I64, CASES, Dimension::Number, "Steps of Newton's method."),
    GROUP.row(APPLICATIONS, Kind::I64, CASES, Dimension::Number, "Applications of the inverse stiffness matrix.").symbol("n_A"),
    GROUP.row(SECONDS, Kind::F64, CASES, Dimension::Time, "Wall-clock time of loads, solve and report.").volatile(),
    GROUP.row(ACCURACY, Kind::F64, CASES, Dimension::Number, "As /solve/accuracy; NaN in this and the other measures without a result."),
    GROUP.row(ZONE_COUNTS, Kind::I64, &[Named("n_cases"), axes::ZONES], Dimension::Number, "Numbers of open, sticking and slipping panes."),
    GROUP.row(NORMAL_FORCE, Kind::F64, CASES, Dimension::FORCE, "Total normal contact force."),
    GROUP.row(TANGENTIAL_FORCE, Kind::F64, &[Named("n_cases"), axes::FRICTION_AXES], Dimension::FORCE, "Sum of area times tangential multiplier along t1 and t2."),
    GROUP.row(CONTACT_FORCE, Kind::F64, VECTORS, Dimension::FORCE, "Force of the foundation on the body."),
    GROUP.row(LARGEST_PRESSURE, Kind::F64, CASES, Dimension::STRESS, "Largest normal multiplier."),
    GROUP.row(LARGEST_DISPLACEMENT, Kind::F64, VECTORS, Dimension::LENGTH, "Largest |u_x|, |u_y|, |u_z| of a node."),
    GROUP.row(STRAIN_ENERGY, Kind::F64, CASES, Dimension::Energy, "Strain energy."),
    GROUP.row(CERTIFICATE_FIGURES, Kind::F64, &[Named("n_cases"), axes::CERTIFICATE_FIGURES], Dimension::Number, "Equilibrium, penetration, adhesion, complementarity, friction bound, slip direction, fixed point, as in /post/certificate."),
    GROUP.row(SOLVE_DIGEST, Kind::Text, CASES, Dimension::Number, "Digest of the solution, else empty."),
];

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
///
/// # Errors
/// Missing or altered datasets.
pub fn read_table_owner(reader: &Reader) -> Result<TableOwner, StoreError> {
    let ids = reader.read_texts(ID)?;
    let planned = reader.read_vec::<u8>(PLANNED)?;
    let planned = ids.iter().zip(planned).filter(|(_, planned)| *planned == 1);
    Ok(TableOwner {
        sweep_file: match reader.has(SWEEP_FILE) {
            true => Some(reader.read_text(SWEEP_FILE)?),
            false => None,
        },
        planned: planned.map(|(id, _)| id.clone()).collect(),
        ids,
    })
}

/// Writes the table of a sweep file, which is given as seen from the folder.
///
/// # Errors
/// HDF5 failures.
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
    let values: Vec<f64> = rows.iter().flat_map(|r| r.setting_values.clone()).collect();
    writer.write(SETTING_VALUE, &values, &[rows.len(), keys.len()])?;
    let mut columns = Columns::new(writer, rows);
    columns.texts(ID, |r| &r.id)?;
    columns.flags(PLANNED, |r| r.planned)?;
    columns.texts(SETTINGS, |r| &r.settings)?;
    columns.texts(STATUS, |r| &r.status)?;
    columns.texts(ERROR, |r| &r.error)?;
    let results: Vec<Option<&CaseResults>> = rows.iter().map(|r| r.results.as_ref()).collect();
    write_results(&mut Columns::new(writer, &results))?;
    let faces = results.iter().map(|r| r.map_or(&[][..], |x| &x.faces));
    case_faces::write(writer, &faces.collect::<Vec<_>>())
}

/// Writes the results of the cases; -1 and NaN where there are none.
fn write_results(columns: &mut Columns<'_, '_, Option<&CaseResults>>) -> Result<(), StoreError> {
    columns.texts(METHOD, |r| r.map_or("", |x| &x.method))?;
    columns.texts(SOLVE_DIGEST, |r| r.map_or("", |x| &x.solve_digest))?;
    for (index, path) in [OUTER_STEPS, NEWTON_STEPS, APPLICATIONS]
        .into_iter()
        .enumerate()
    {
        columns.numbers(path, |r| r.map_or(-1, |x| x.counts[index]))?;
    }
    columns.vectors(ZONE_COUNTS, |r| r.map_or([-1; 3], |x| x.zones))?;
    columns.numbers(SECONDS, |r| r.map_or(f64::NAN, |x| x.seconds))?;
    columns.numbers(ACCURACY, |r| r.map_or(f64::NAN, |x| x.accuracy))?;
    columns.numbers(NORMAL_FORCE, |r| r.map_or(f64::NAN, |x| x.normal_force))?;
    columns.numbers(LARGEST_PRESSURE, |r| {
        r.map_or(f64::NAN, |x| x.largest_pressure)
    })?;
    columns.numbers(STRAIN_ENERGY, |r| r.map_or(f64::NAN, |x| x.strain_energy))?;
    columns.vectors(TANGENTIAL_FORCE, |r| {
        r.map_or([f64::NAN; 2], |x| x.tangential_force)
    })?;
    columns.vectors(CONTACT_FORCE, |r| {
        r.map_or([f64::NAN; 3], |x| x.contact_force)
    })?;
    columns.vectors(LARGEST_DISPLACEMENT, |r| {
        r.map_or([f64::NAN; 3], |x| x.largest_displacement)
    })?;
    columns.vectors(CERTIFICATE_FIGURES, |r| {
        r.map_or([f64::NAN; 7], |x| x.certificate)
    })
}
