//! `/cases` of a sweep's summary file: settings and main results of every case.

use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named},
    Group, GroupWriter, Kind, Layout, Reader, StoreError,
};
use units::Dimension;

use super::{FormatError, Stage, read_index_vec, solve::read_outcome};

/// The table of a sweep, in a file of its own.
pub const GROUP: Group = Group::new("cases", "sweep");

/// Every dataset of a sweep's summary file.
pub const SWEEP_LAYOUT: Layout = Layout {
    filetype: "contact3d-pipe sweep",
    linked_filetype: "contact3d-pipe sweep stage",
    format_version: [1, 1],
    creator: super::LAYOUT.creator,
    units: super::LAYOUT.units,
    groups: &[GROUP],
    tables: &[TABLE],
    extents: &[
        (
            "n_cases",
            "cases: those of the plan in its order, then older ones",
        ),
        ("n_keys", "keys of all axes"),
    ],
};

/// The figures of a certificate, as `/post/certificate` names them.
pub const CERTIFICATE: [&str; 7] = [
    "equilibrium",
    "penetration",
    "adhesion",
    "complementarity",
    "friction_bound",
    "slip_direction",
    "fixed_point",
];

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
const VECTORS: &[Extent] = &[Named("n_cases"), Fixed(3)];

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
    GROUP.row(ZONE_COUNTS, Kind::I64, VECTORS, Dimension::Number, "Numbers of open, sticking and slipping panes."),
    GROUP.row(NORMAL_FORCE, Kind::F64, CASES, Dimension::FORCE, "Total normal contact force."),
    GROUP.row(TANGENTIAL_FORCE, Kind::F64, &[Named("n_cases"), Fixed(2)], Dimension::FORCE, "Sum of area times tangential multiplier along t1 and t2."),
    GROUP.row(CONTACT_FORCE, Kind::F64, VECTORS, Dimension::FORCE, "Force of the foundation on the body."),
    GROUP.row(LARGEST_PRESSURE, Kind::F64, CASES, Dimension::STRESS, "Largest normal multiplier."),
    GROUP.row(LARGEST_DISPLACEMENT, Kind::F64, VECTORS, Dimension::LENGTH, "Largest |u_x|, |u_y|, |u_z| of a node."),
    GROUP.row(STRAIN_ENERGY, Kind::F64, CASES, Dimension::Energy, "Strain energy."),
    GROUP.row(CERTIFICATE_FIGURES, Kind::F64, &[Named("n_cases"), Fixed(7)], Dimension::Number, "Equilibrium, penetration, adhesion, complementarity, friction bound, slip direction, fixed point, as in /post/certificate."),
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

/// The main results of a case; NaN for what its scene does not have.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseResults {
    /// How the solve ended.
    pub status: String,
    /// Which algorithm gave the answer.
    pub method: String,
    /// Outer steps, Newton steps, applications.
    pub counts: [i64; 3],
    /// Seconds of loads, solve and report.
    pub seconds: f64,
    /// Accuracy of the solve.
    pub accuracy: f64,
    /// Open, sticking, slipping panes.
    pub zones: [i64; 3],
    /// Normal force in N.
    pub normal_force: f64,
    /// Tangential forces in N.
    pub tangential_force: [f64; 2],
    /// Force of the foundation in N.
    pub contact_force: [f64; 3],
    /// Largest pressure in Pa.
    pub largest_pressure: f64,
    /// Largest displacement components in m.
    pub largest_displacement: [f64; 3],
    /// Strain energy in J.
    pub strain_energy: f64,
    /// The certificate's figures, in the order of [`CERTIFICATE`].
    pub certificate: [f64; 7],
    /// Digest of the solution.
    pub solve_digest: String,
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
    let n = rows.len();
    let texts = |text: fn(&CaseRow) -> &str| -> Vec<&str> { rows.iter().map(text).collect() };
    let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
    writer.write_texts(KEYS, &keys)?;
    writer.write_texts(ID, &texts(|r| &r.id))?;
    let planned: Vec<u8> = rows.iter().map(|r| u8::from(r.planned)).collect();
    writer.write(PLANNED, &planned, &[n])?;
    writer.write_texts(SETTINGS, &texts(|r| &r.settings))?;
    let values: Vec<f64> = rows.iter().flat_map(|r| r.setting_values.clone()).collect();
    writer.write(SETTING_VALUE, &values, &[n, keys.len()])?;
    writer.write_texts(STATUS, &texts(|r| &r.status))?;
    writer.write_texts(ERROR, &texts(|r| &r.error))?;
    writer.write_texts(
        METHOD,
        &texts(|r| r.results.as_ref().map_or("", |x| &x.method)),
    )?;
    writer.write_texts(
        SOLVE_DIGEST,
        &texts(|r| r.results.as_ref().map_or("", |x| &x.solve_digest)),
    )?;
    for (index, path) in [OUTER_STEPS, NEWTON_STEPS, APPLICATIONS]
        .into_iter()
        .enumerate()
    {
        let counts = rows
            .iter()
            .map(|r| r.results.as_ref().map_or(-1, |x| x.counts[index]));
        writer.write(path, &counts.collect::<Vec<i64>>(), &[n])?;
    }
    let zones = rows
        .iter()
        .flat_map(|r| r.results.as_ref().map_or([-1; 3], |x| x.zones));
    writer.write(ZONE_COUNTS, &zones.collect::<Vec<i64>>(), &[n, 3])?;
    write_measures(writer, rows)
}

fn write_measures(writer: &mut GroupWriter<'_>, rows: &[CaseRow]) -> Result<(), StoreError> {
    type Scalar = fn(&CaseResults) -> f64;
    let n = rows.len();
    let scalars: [(&str, Scalar); 5] = [
        (SECONDS, |x| x.seconds),
        (ACCURACY, |x| x.accuracy),
        (NORMAL_FORCE, |x| x.normal_force),
        (LARGEST_PRESSURE, |x| x.largest_pressure),
        (STRAIN_ENERGY, |x| x.strain_energy),
    ];
    for (path, measure) in scalars {
        let values = rows
            .iter()
            .map(|r| r.results.as_ref().map_or(f64::NAN, measure));
        writer.write(path, &values.collect::<Vec<f64>>(), &[n])?;
    }
    let mut vectors = |path: &str, width: usize, of: &dyn Fn(&CaseResults) -> Vec<f64>| {
        let none = vec![f64::NAN; width];
        let values = rows
            .iter()
            .flat_map(|r| r.results.as_ref().map_or(none.clone(), of));
        writer.write(path, &values.collect::<Vec<f64>>(), &[n, width])
    };
    vectors(TANGENTIAL_FORCE, 2, &|x| x.tangential_force.to_vec())?;
    vectors(CONTACT_FORCE, 3, &|x| x.contact_force.to_vec())?;
    vectors(LARGEST_DISPLACEMENT, 3, &|x| {
        x.largest_displacement.to_vec()
    })?;
    vectors(CERTIFICATE_FIGURES, 7, &|x| x.certificate.to_vec())
}

/// Reads the main results of a finished run file; `None` if it has no report yet.
///
/// # Errors
/// Missing or altered datasets.
pub fn read_case(reader: &Reader) -> Result<Option<CaseResults>, FormatError> {
    let whole = |stage: Stage| reader.whole_group(stage.group());
    let Some(load) = whole(Stage::Load)? else {
        return Ok(None);
    };
    let Some(solve) = whole(Stage::Solve)? else {
        return Ok(None);
    };
    let Some(post) = whole(Stage::Post)? else {
        return Ok(None);
    };
    let outcome = read_outcome(reader)?;
    let scalar = |path: &str| Ok::<f64, FormatError>(vector::<1>(reader, path)?[0]);
    let mut certificate = [f64::NAN; 7];
    for (value, name) in certificate.iter_mut().zip(CERTIFICATE) {
        *value = scalar(&format!("/post/certificate/{name}"))?;
    }
    let mut zones = [-1; 3];
    if reader.has("/post/zone_counts") {
        for (zone, count) in zones
            .iter_mut()
            .zip(read_index_vec(reader, "/post/zone_counts")?)
        {
            *zone = count as i64;
        }
    }
    Ok(Some(CaseResults {
        status: outcome.status,
        method: outcome.method,
        counts: outcome.counts.map(|count| count as i64),
        seconds: load.record.seconds + solve.record.seconds + post.record.seconds,
        accuracy: outcome.accuracy,
        zones,
        normal_force: scalar("/post/resultants/normal_force")?,
        tangential_force: vector(reader, "/post/resultants/tangential_force")?,
        contact_force: vector(reader, "/post/resultants/contact_force")?,
        largest_pressure: scalar("/post/resultants/largest_pressure")?,
        largest_displacement: vector(reader, "/post/resultants/largest_displacement")?,
        strain_energy: scalar("/post/resultants/strain_energy")?,
        certificate,
        solve_digest: solve.digest,
    }))
}

/// A vector of the report, NaN where the file does not have it or the solve failed for want of
/// numbers.
fn vector<const N: usize>(reader: &Reader, path: &str) -> Result<[f64; N], FormatError> {
    let mut vector = [f64::NAN; N];
    if reader.has(path) {
        for (target, value) in vector.iter_mut().zip(reader.read_vec::<f64>(path)?) {
            *target = value;
        }
    }
    Ok(vector)
}
