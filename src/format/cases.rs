//! `/cases` of a sweep's summary file: settings and main results of every case, read from its run file.

use contact3d::{adaptation::AdaptiveStatus, solver::Status};
use runfile::{
    Extent,
    Extent::{Fixed, Named},
    Group, GroupWriter, Kind, Layout, Reader, StoreError,
};
use units::Dimension;

use super::{
    FormatError, Stage, adapt, extents,
    fields::{Fields, fields, read_as, read_if_there, read_value, write_list, write_value},
    increments, mesh, post, quantities, scene,
    solve::read_outcome,
    stored::{Absent, Stored},
};

/// The table of a sweep, in a file of its own.
pub const GROUP: Group = Group::new("cases", "sweep");

/// Every dataset of a sweep's summary file.
pub const SWEEP_LAYOUT: Layout = Layout {
    filetype: "contact3d-pipe sweep",
    linked_filetype: "contact3d-pipe sweep stage",
    groups: &[GROUP],
    tables: &[FIELDS.rows, FACE_FIELDS.rows, QUANTITY_FIELDS.rows],
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
        (
            "n_case_quantities",
            "quantities with an error bar in some case, each name once",
        ),
    ],
    ..super::LAYOUT
};

const SWEEP_FILE: &str = "/cases/sweep_file";
const KEYS: &str = "/cases/keys";
const KEY_UNITS: &str = "/cases/key_unit";
const ID: &str = "/cases/id";
const PLANNED: &str = "/cases/planned";

const CASES: &[Extent] = &[Named("n_cases")];
const VECTORS: &[Extent] = &[Named("n_cases"), extents::XYZ];

const FIELDS: Fields<CaseRow> = fields! { CaseRow => GROUP;
    {Kind::Text} SWEEP_FILE, &[], Dimension::Number, "The sweep file, as seen from this folder.".volatile();
    {Kind::Text} KEYS, &[Named("n_keys")], Dimension::Number, "Keys of the scene that the axes change.";
    {Kind::Text} KEY_UNITS, &[Named("n_keys")], Dimension::Number, "Units of the values of these keys; 1 for numbers.";
    (id) ID, CASES, Dimension::Number, "Name of the case; its run file is NAME.h5 in the same folder.";
    (planned) PLANNED, CASES, Dimension::Number, "1 for cases of the present axes, 0 for older ones in the folder.";
    (settings) "/cases/settings", CASES, Dimension::Number, "Values of the keys as a JSON object.";
    (setting_values) "/cases/setting_value", &[Named("n_cases"), Named("n_keys")], Dimension::Number, "Values of the keys in the scene's units; NaN where a value is no number.";
    (status) "/cases/status", CASES, Dimension::Number, "How the solve ended, as /solve/status says; failed for a case with an error, missing for one not yet run.";
    (error) "/cases/error", CASES, Dimension::Number, "The error of a failed case, or why a case has no solution, else empty.";
    (results?.method) "/cases/method", CASES, Dimension::Number, "Algorithm that gave the answer, else empty.";
    (results?.counts[0]) "/cases/outer_steps", CASES, Dimension::Number, "Steps of successive approximations; -1 in this and other counts without a result.";
    (results?.counts[1]) "/cases/newton_steps", CASES, Dimension::Number, "Steps of Newton's method.";
    (results?.counts[2]) "/cases/applications", CASES, Dimension::Number, "Applications of the inverse stiffness matrix.".symbol("n_A");
    (results?.seconds) "/cases/seconds", CASES, Dimension::Time, "Wall-clock time of loads, solve and report.".volatile();
    (results?.accuracy) "/cases/accuracy", CASES, Dimension::Number, "As /solve/accuracy; NaN in this and the other measures without a result.";
    (results?.zones) "/cases/zone_counts", &[Named("n_cases"), extents::ZONES], Dimension::Number, "Numbers of open, sticking and slipping panes.";
    (results?.normal_force) "/cases/normal_force", CASES, Dimension::FORCE, "Total normal contact force.";
    (results?.tangential_force) "/cases/tangential_force", &[Named("n_cases"), extents::FRICTION_AXES], Dimension::FORCE, "Sum of area times tangential multiplier along t1 and t2.";
    (results?.friction_force) "/cases/friction_force", CASES, Dimension::FORCE, "Size of that sum; NaN also with several contact faces, whose axes differ.";
    (results?.contact_force) "/cases/contact_force", VECTORS, Dimension::FORCE, "Force of the foundation on the body.";
    (results?.largest_pressure) "/cases/largest_pressure", CASES, Dimension::STRESS, "Largest normal multiplier.";
    (results?.largest_von_mises) "/cases/largest_von_mises", CASES, Dimension::STRESS, "Largest von Mises stress of a node.";
    (results?.largest_displacement) "/cases/largest_displacement", CASES, Dimension::LENGTH, "Largest |u| of a node.";
    (results?.largest_displacement_along) "/cases/largest_displacement_along", VECTORS, Dimension::LENGTH, "Largest |u_x|, |u_y|, |u_z| of a node.";
    (results?.strain_energy) "/cases/strain_energy", CASES, Dimension::Energy, "Strain energy.";
    (results?.cycle_dissipation) "/cases/cycle_dissipation", CASES, Dimension::Energy, "Energy that friction took in the last cycle of a history; NaN where its loads do not return.";
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
    /// The sweep file, as seen from the folder.
    pub sweep_file: String,
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
        sweep_file: reader.read_text(SWEEP_FILE)?,
        planned: planned.map(|(id, _)| id.clone()).collect(),
        ids,
    })
}

/// Writes the table of a sweep file, which is given as seen from the folder; the keys come with the words of their units.
pub fn write(
    writer: &mut GroupWriter<'_>,
    sweep_file: &str,
    [keys, units]: [&[String]; 2],
    rows: &[CaseRow],
) -> Result<(), StoreError> {
    writer.write_text(SWEEP_FILE, sweep_file)?;
    write_list(writer, KEYS, keys)?;
    write_list(writer, KEY_UNITS, units)?;
    FIELDS.write_rows(writer, rows)?;
    let results = rows.iter().map(|row| row.results.as_ref());
    let faces = results.clone();
    let faces = faces.map(|results| results.map_or(&[][..], |results| &results.faces));
    let (names, cells) = by_name(&faces.collect::<Vec<_>>(), |face| &face.name);
    if !names.is_empty() {
        write_value(writer, FACE_NAMES, &names)?;
        FACE_FIELDS.write_rows(writer, &cells)?;
    }
    let found = results.map(|results| results.map_or(&[][..], |results| &results.quantities));
    let (names, cells) = by_name(&found.collect::<Vec<_>>(), |it| &it.name);
    if names.is_empty() {
        return Ok(());
    }
    let first = |name: &String| cells.iter().flatten().flatten().find(|it| it.name == *name);
    let units: Vec<String> = names
        .iter()
        .filter_map(first)
        .map(|it| it.unit.clone())
        .collect();
    write_value(writer, QUANTITY_NAMES, &names)?;
    write_value(writer, QUANTITY_UNITS, &units)?;
    QUANTITY_FIELDS.write_rows(writer, &cells)
}

/// All names, each once, and for each case what it has of each name.
fn by_name<T: Clone>(
    cases: &[&[T]],
    name: fn(&T) -> &String,
) -> (Vec<String>, Vec<Vec<Option<T>>>) {
    let mut names: Vec<String> = Vec::new();
    for it in cases.iter().copied().flatten() {
        if !names.contains(name(it)) {
            names.push(name(it).clone());
        }
    }
    let cells = cases.iter().map(|of_case| {
        let named = |wanted: &String| of_case.iter().find(|it| name(it) == wanted);
        names.iter().map(|name| named(name).cloned()).collect()
    });
    let cells = cells.collect();
    (names, cells)
}

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

/// The main results of a case; NaN for what its scene does not have.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseResults {
    /// How the solve ended.
    pub status: Status,
    /// Whether the target for the error is met; `None` without one.
    pub adaptation: Option<AdaptiveStatus>,
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
    /// Size of the tangential forces of one contact face in N.
    pub friction_force: f64,
    /// Force of the foundation in N.
    pub contact_force: [f64; 3],
    /// Largest pressure in Pa.
    pub largest_pressure: f64,
    /// Largest von Mises stress in Pa.
    pub largest_von_mises: f64,
    /// Largest displacement in m.
    pub largest_displacement: f64,
    /// Largest displacement components in m.
    pub largest_displacement_along: [f64; 3],
    /// Strain energy in J.
    pub strain_energy: f64,
    /// What friction took in the last cycle in J.
    pub cycle_dissipation: f64,
    /// What happens on each of several contact faces; empty for one.
    pub faces: Vec<CaseFace>,
    /// The quantities with error bars.
    pub quantities: Vec<CaseQuantity>,
    /// The certificate's figures, in the order of [`CERTIFICATE`].
    pub certificate: [f64; 7],
    /// Digest of the solution.
    pub solve_digest: String,
}

/// Reads the main results of a finished run file; `None` if it has no report yet. A case without a solution has a status, and no forces,
/// pressures and zones: what its solve came to last is no result.
pub fn read_case(reader: &Reader) -> Result<Option<CaseResults>, FormatError> {
    let whole = |stage: Stage| reader.group_record(stage.group());
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
    let is_solved = outcome.status.is_solved();
    let mut certificate = [f64::NAN; 7];
    for (value, name) in certificate
        .iter_mut()
        .zip(CERTIFICATE)
        .filter(|_| is_solved)
    {
        *value = post::read_certificate(reader, name)?.unwrap_or(f64::NAN);
    }
    let zones = match is_solved {
        true => read_if_there(reader, "/post/zone_counts")?,
        false => None,
    };
    let number = |path| resultant::<f64>(reader, path, is_solved);
    let vector = |path| resultant::<[f64; 3]>(reader, path, is_solved);
    let tangential = "/post/resultants/tangential_force";
    let tangential_force: [f64; 2] = resultant(reader, tangential, is_solved)?;
    Ok(Some(CaseResults {
        status: outcome.status,
        adaptation: adapt::read_status(reader)?,
        method: outcome.method.to_owned(),
        counts: outcome.counts.map(|count| count as i64),
        seconds: load.record.seconds + solve.record.seconds + post.record.seconds,
        accuracy: outcome.accuracy,
        zones: zones.unwrap_or([-1; 3]),
        normal_force: number("/post/resultants/normal_force")?,
        tangential_force,
        friction_force: tangential_force[0].hypot(tangential_force[1]),
        contact_force: vector("/post/resultants/contact_force")?,
        largest_pressure: number("/post/resultants/largest_pressure")?,
        largest_von_mises: number("/post/largest_von_mises/value")?,
        largest_displacement: number("/post/resultants/largest_displacement")?,
        largest_displacement_along: vector("/post/resultants/largest_displacement_along")?,
        strain_energy: number("/post/resultants/strain_energy")?,
        cycle_dissipation: cycle_dissipation(reader, is_solved)?.unwrap_or(f64::NAN),
        faces: match is_solved {
            true => read_faces(reader)?,
            false => Vec::new(),
        },
        quantities: read_quantities(reader)?,
        certificate,
        solve_digest: solve.digest,
    }))
}

/// What friction took in the last cycle of a history in J.
fn cycle_dissipation(reader: &Reader, is_solved: bool) -> Result<Option<f64>, FormatError> {
    if !is_solved || !reader.has(increments::DISSIPATION) {
        return Ok(None);
    }
    let steps = reader.read_vec::<i64>(increments::STEP)?;
    let dissipation = reader.read_vec::<f64>(increments::DISSIPATION)?;
    let scene = scene::read(reader, reader.path())?.scene;
    let last = steps.last().and_then(|last| usize::try_from(*last).ok());
    let cycle = last.and_then(|last| scene.cycle_until(last));
    Ok(cycle.map(|cycle| {
        let is_within = |step: &i64| usize::try_from(*step).is_ok_and(|step| cycle.contains(&step));
        let of_cycle = steps.iter().zip(&dissipation);
        let of_cycle = of_cycle.filter(|(step, _)| is_within(step));
        of_cycle.map(|(_, energy)| energy).sum()
    }))
}

/// A resultant of the report, NaN where the file does not have it or holds what an unsolved case came to.
fn resultant<V: Stored + Absent>(
    reader: &Reader,
    path: &'static str,
    is_solved: bool,
) -> Result<V, FormatError> {
    if is_solved && reader.has(path) {
        read_as(reader, path, true)
    } else {
        Ok(V::absent())
    }
}

const FACE_NAMES: &str = "/cases/face_names";

const FACES: &[Extent] = &[Named("n_cases"), Named("n_case_faces")];
const FACE_ZONES: &[Extent] = &[Named("n_cases"), Named("n_case_faces"), extents::ZONES];
const FACE_PAIRS: &[Extent] = &[Named("n_cases"), Named("n_case_faces"), Fixed(2)];
const ONE_FACE: &str = "absent where no case has several contact faces";

/// The faces of a case, in the order of the names.
const FACE_FIELDS: Fields<Vec<Option<CaseFace>>> = fields! { Vec<Option<CaseFace>> => GROUP;
    {Kind::Text} FACE_NAMES, &[Named("n_case_faces")], Dimension::Number, "Names of contact faces in cases with several, each once.".optional(ONE_FACE);
    [|faces| each(faces, |face| face.zones)] "/cases/face_zone_counts", FACE_ZONES, Dimension::Number, "Numbers of open, sticking and slipping panes of each face; -1 in cases without it.".optional(ONE_FACE);
    [|faces| each(faces, |face| face.normal_force)] "/cases/face_normal_force", FACES, Dimension::FORCE, "Total normal contact force of each face; NaN in cases without it.".optional(ONE_FACE);
    [|faces| each(faces, |face| face.tangential_force)] "/cases/face_tangential_force", FACE_PAIRS, Dimension::FORCE, "Sum of area times tangential multiplier along the t1 and t2 of each face; NaN without friction.".optional(ONE_FACE);
    [|faces| each(faces, |face| face.largest_pressure)] "/cases/face_largest_pressure", FACES, Dimension::STRESS, "Largest normal multiplier of each face.".optional(ONE_FACE);
};

/// One of several contact faces of a case; NaN for what its law does not have.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseFace {
    /// Its name.
    pub name: String,
    /// Open, sticking, slipping panes.
    pub zones: [i64; 3],
    /// Normal force in N.
    pub normal_force: f64,
    /// Tangential forces in N.
    pub tangential_force: [f64; 2],
    /// Largest pressure in Pa.
    pub largest_pressure: f64,
}

/// The faces of a finished run file with several, in the order of its results; none with one.
fn read_faces(reader: &Reader) -> Result<Vec<CaseFace>, FormatError> {
    if !reader.has(post::FACE_NORMAL_FORCE) {
        return Ok(Vec::new());
    }
    let names = reader.read_text(mesh::CONTACT_FACE_NAMES)?;
    let normal: Vec<f64> = reader.read_vec(post::FACE_NORMAL_FORCE)?;
    let pressure: Vec<f64> = reader.read_vec(post::FACE_LARGEST_PRESSURE)?;
    let zones: Vec<[i64; 3]> = read_value(reader, post::FACE_ZONE_COUNTS)?;
    // Faces with friction come first.
    let pairs: Option<Vec<[f64; 2]>> = read_if_there(reader, post::FACE_TANGENTIAL_FORCE)?;
    let pairs = pairs.unwrap_or_default();
    let numbers = normal.into_iter().zip(pressure).zip(zones);
    let faces = names.lines().zip(numbers).enumerate();
    Ok(faces
        .map(
            |(k, (name, ((normal_force, largest_pressure), zones)))| CaseFace {
                name: name.to_owned(),
                zones,
                normal_force,
                tangential_force: pairs.get(k).copied().unwrap_or([f64::NAN; 2]),
                largest_pressure,
            },
        )
        .collect())
}

/// A quantity with its error bar, of a case; NaN where it has none.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseQuantity {
    /// Its name.
    pub name: String,
    /// The word for its unit.
    pub unit: String,
    /// Its value.
    pub value: f64,
    /// The larger distance to an end of its range.
    pub error_bar: f64,
}

const QUANTITY_NAMES: &str = "/cases/quantity_names";
const QUANTITY_UNITS: &str = "/cases/quantity_units";
const QUANTITIES: &[Extent] = &[Named("n_case_quantities")];
const CASE_QUANTITIES: &[Extent] = &[Named("n_cases"), Named("n_case_quantities")];
const NO_QUANTITY: &str = "absent where no case has quantities with error bars";

/// The quantities of a case, in the order of the names.
const QUANTITY_FIELDS: Fields<Vec<Option<CaseQuantity>>> = fields! { Vec<Option<CaseQuantity>> => GROUP;
    {Kind::Text} QUANTITY_NAMES, QUANTITIES, Dimension::Number, "Quantities with an error bar in some case, as /solve/quantities names them.".optional(NO_QUANTITY);
    {Kind::Text} QUANTITY_UNITS, QUANTITIES, Dimension::Number, "The unit of each: of its value and error bar.".optional(NO_QUANTITY);
    [|found| each(found, |it| it.value)] "/cases/quantity", CASE_QUANTITIES, Dimension::Number, "Their values, each in its own unit; NaN in cases without it.".optional(NO_QUANTITY);
    [|found| each(found, |it| it.error_bar)] "/cases/error_bar", CASE_QUANTITIES, Dimension::Number, "Their error bars: the larger distance to an end of the range.".optional(NO_QUANTITY);
};

/// The quantities of a finished run file; none where it has no error bars.
fn read_quantities(reader: &Reader) -> Result<Vec<CaseQuantity>, FormatError> {
    let names: Option<Vec<String>> = read_if_there(reader, quantities::NAME)?;
    let Some(names) = names else {
        return Ok(Vec::new());
    };
    let units: Vec<String> = read_value(reader, quantities::UNIT)?;
    let values: Vec<f64> = read_value(reader, quantities::VALUE)?;
    let ranges: Vec<[f64; 2]> = read_value(reader, quantities::RANGE)?;
    let numbers = values.into_iter().zip(ranges);
    let rows = names.into_iter().zip(units).zip(numbers);
    let row =
        |((name, unit), (value, [low, high])): ((String, String), (f64, [f64; 2]))| CaseQuantity {
            name,
            unit,
            value,
            error_bar: (high - value).max(value - low),
        };
    Ok(rows.map(row).collect())
}

/// A figure of each face or quantity of a case, which may not have it.
fn each<T, V: Absent>(row: &[Option<T>], of: fn(&T) -> V) -> Vec<V> {
    let figures = row.iter().map(|it| it.as_ref().map(of));
    figures.map(|it| it.unwrap_or_else(V::absent)).collect()
}
