//! `/branches`: paths of solutions in a parameter of the scene.

mod members;

use contact3d::branches::{
    Branches, Certificate, ParameterRange, Path, PathPoint, Switch, Undecided,
};
use runfile::{
    DatasetSpec, Extent,
    Extent::{Fixed, Named},
    Group, GroupWriter, Kind, Reader, StoreError, StoredEnum,
};
use units::Dimension;

use self::members::{
    StoredEnd, StoredOrigin, StoredPointKind, StoredSwitch, StoredUndecided, end, stored_end,
    stored_switch, switch,
};
use super::{
    FormatError, columns::Columns, read_finite_rows, read_finite_scalar, read_finite_vec,
    read_index_vec, require_below,
};
use crate::format::axes;

/// Paths of solutions; computed from the scene alone.
pub const GROUP: Group = Group::new("branches", "branches");

const KEY: &str = "/branches/key";
const RANGE: &str = "/branches/range";
const ALL: &str = "/branches/all";
const ENUMERATED: &str = "/branches/enumerated";
const CERTIFIED: &str = "/branches/certificate/proven";
const UNDECIDED: &str = "/branches/certificate/undecided";
const SOLUTIONS: &str = "/branches/certificate/n_solutions";
const STATES: &str = "/branches/certificate/n_states";
const BOXES: &str = "/branches/certificate/n_boxes";
const MARGIN: &str = "/branches/certificate/margin";
const LEAST_DETERMINANT: &str = "/branches/certificate/least_determinant";
const WIDTH: &str = "/branches/certificate/width";
const UNCERTAINTY: &str = "/branches/certificate/uncertainty";
const STRESS: &str = "/branches/stress_scale";
const LEFT_OUT: &str = "/branches/left_out";
const PENDING: &str = "/branches/pending";
const ORIGIN: &str = "/branches/path/origin";
const END: &str = "/branches/path/end";
const N_POINTS: &str = "/branches/path/n_points";
const PARAMETER: &str = "/branches/point/parameter";
const POINT_KIND: &str = "/branches/point/kind";
const DETERMINANT: &str = "/branches/point/determinant_sign";
const SPECTRAL_RADIUS: &str = "/branches/point/spectral_radius";
const ATTRACTING: &str = "/branches/point/attracting";
const RESIDUAL: &str = "/branches/point/residual";
const ZONES: &str = "/branches/point/zone_counts";
const NORMAL_FORCE: &str = "/branches/point/normal_force";
const TANGENTIAL_FORCE: &str = "/branches/point/tangential_force";
const LARGEST_PRESSURE: &str = "/branches/point/largest_pressure";
const MULTIPLIER: &str = "/branches/point/multiplier";
const SWITCH_POINT: &str = "/branches/switch/point";
const SWITCH_KIND: &str = "/branches/switch/kind";
const SWITCH_INDEX: &str = "/branches/switch/index";

const NOT_SEARCHED: &str =
    "absent where not all solutions were searched for, and in files of versions before";

const ENDS: &[Extent] = &[Fixed(2)];
const PATHS: &[Extent] = &[Named("n_paths")];
const POINTS: &[Extent] = &[Named("n_path_points")];
const POINT_PAIRS: &[Extent] = &[Named("n_path_points"), axes::FRICTION_AXES];
const POINT_ZONES: &[Extent] = &[Named("n_path_points"), axes::ZONES];
const POINT_MULTIPLIERS: &[Extent] = &[Named("n_path_points"), Named("n_path_multipliers")];
const SWITCHES: &[Extent] = &[Named("n_switches")];

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row(KEY, Kind::Text, &[], Dimension::Number, "The key of the scene that is the parameter."),
    GROUP.row(RANGE, Kind::F64, &[Fixed(2)], Dimension::Number, "Where the parameter begins and ends, in the unit of the key."),
    GROUP.row(ALL, Kind::U8, &[], Dimension::Number, "1 where all solutions were searched for at both ends of the range."),
    GROUP.row(ENUMERATED, Kind::U8, &[], Dimension::Number, "1 where at both ends of the range no solution is missing, by the proof in /branches/certificate."),
    GROUP.row(CERTIFIED, Kind::U8, ENDS, Dimension::Number, "1 at an end of the range whose solutions were enumerated: every choice of states was tried in intervals.").optional(NOT_SEARCHED),
    GROUP.row(UNDECIDED, Kind::Enum(StoredUndecided::SPEC), ENDS, Dimension::Number, "Why there is no proof; not_asked where there is one.").optional(NOT_SEARCHED),
    GROUP.row(SOLUTIONS, Kind::I64, ENDS, Dimension::Number, "How many solutions there are; 0 without a proof.").optional(NOT_SEARCHED),
    GROUP.row(STATES, Kind::I64, ENDS, Dimension::Number, "Choices of open, stick, and slip in half circles that were tried; 0 without a proof.").optional(NOT_SEARCHED),
    GROUP.row(BOXES, Kind::I64, ENDS, Dimension::Number, "Boxes of unknowns with no solution or exactly one, by arithmetic in intervals; 0 without a proof.").optional(NOT_SEARCHED),
    GROUP.row(MARGIN, Kind::F64, ENDS, Dimension::Number, "What is left at least of an inequality of the states of a solution; NaN without a proof.").optional(NOT_SEARCHED),
    GROUP.row(LEAST_DETERMINANT, Kind::F64, ENDS, Dimension::Number, "Least absolute determinant of the equations of slipping panes at a solution over the product of the lengths of their rows; NaN without a proof.").optional(NOT_SEARCHED),
    GROUP.row(WIDTH, Kind::F64, ENDS, Dimension::Number, "Widest interval in which a multiplier of a solution lies, over the largest multiplier; NaN without a proof.").optional(NOT_SEARCHED),
    GROUP.row(UNCERTAINTY, Kind::F64, ENDS, Dimension::Number, "What the dual operator, its right-hand side and slips may be wrong by, as a share of their size, for the proof to hold; NaN without a proof.").optional(NOT_SEARCHED),
    GROUP.row(STRESS, Kind::F64, &[], Dimension::STRESS, "Size of stresses that lengths of steps are measured by, a power of two.").symbol("Lambda"),
    GROUP.row(LEFT_OUT, Kind::I64, &[], Dimension::Number, "Half paths from branch points that were not followed, since there are so many."),
    GROUP.row(PENDING, Kind::Text, &[], Dimension::Number, "What is still to be followed, as JSON: where the path in hand stands, half paths that wait, known branch points.").optional("absent when all is followed"),
    GROUP.row(ORIGIN, Kind::Enum(StoredOrigin::SPEC), PATHS, Dimension::Number, "Where a path begins: at the solver's answer, at a solution that was searched for, at a branch point."),
    GROUP.row(END, Kind::Enum(StoredEnd::SPEC), PATHS, Dimension::Number, "Why a path ends."),
    GROUP.row(N_POINTS, Kind::I64, PATHS, Dimension::Number, "Points of a path, those of the first path first."),
    GROUP.row(PARAMETER, Kind::F64, POINTS, Dimension::Number, "The parameter, in the unit of the key.").symbol("gamma"),
    GROUP.row(POINT_KIND, Kind::Enum(StoredPointKind::SPEC), POINTS, Dimension::Number, "What is special about a point."),
    GROUP.row(DETERMINANT, Kind::I64, POINTS, Dimension::Number, "Sign of the determinant of Newton's matrix, on the side the path comes from; 0 at folds.").symbol("sign det R'"),
    GROUP.row(SPECTRAL_RADIUS, Kind::F64, POINTS, Dimension::Number, "Spectral radius of the derivative of the mapping Psi, on the side the path comes from; NaN where it has none.").symbol("rho(Psi')"),
    GROUP.row(ATTRACTING, Kind::U8, POINTS, Dimension::Number, "1 where the spectral radius is below 1: successive approximations converge from nearby."),
    GROUP.row(RESIDUAL, Kind::F64, POINTS, Dimension::Number, "Residual of the natural map over the multipliers, measured by local stiffness."),
    GROUP.row(ZONES, Kind::I64, POINT_ZONES, Dimension::Number, "Numbers of open, sticking and slipping panes, on the side the path comes from."),
    GROUP.row(NORMAL_FORCE, Kind::F64, POINTS, Dimension::FORCE, "Total normal contact force."),
    GROUP.row(TANGENTIAL_FORCE, Kind::F64, POINT_PAIRS, Dimension::FORCE, "Total tangential multiplier force along t1 and t2."),
    GROUP.row(LARGEST_PRESSURE, Kind::F64, POINTS, Dimension::STRESS, "Largest normal multiplier."),
    GROUP.row(MULTIPLIER, Kind::F64, POINT_MULTIPLIERS, Dimension::STRESS, "Multipliers: the normal ones, then the tangential pairs.").symbol("lambda"),
    GROUP.row(SWITCH_POINT, Kind::I64, SWITCHES, Dimension::Number, "The point at which a pane or a node changes."),
    GROUP.row(SWITCH_KIND, Kind::Enum(StoredSwitch::SPEC), SWITCHES, Dimension::Number, "What changes: a pane opens or closes, slips or sticks, reaches the pressure cap; the slip of a contact node changes its sign along an axis, or reaches a knot of a coefficient."),
    GROUP.row(SWITCH_INDEX, Kind::I64, SWITCHES, Dimension::Number, "The pane or the contact node."),
];

/// Writes all paths, finished or not.
///
/// # Errors
/// HDF5 failures.
pub fn write(writer: &mut GroupWriter<'_>, branches: &Branches) -> Result<(), StoreError> {
    let range = &branches.range;
    writer.write_text(KEY, &range.key)?;
    writer.write(RANGE, &[range.from, range.to], &[2])?;
    writer.write(ALL, &[u8::from(branches.all)], &[])?;
    let is_enumerated = branches.is_enumerated(0) && branches.is_enumerated(1);
    writer.write(ENUMERATED, &[u8::from(is_enumerated)], &[])?;
    if branches.all {
        write_certificates(writer, &branches.certificates)?;
    }
    writer.write(STRESS, &[branches.stress], &[])?;
    writer.write_indices(LEFT_OUT, &[branches.left_out], &[])?;
    if let Some(pending) = &branches.pending {
        let text = serde_json::to_string(pending).expect("fronts are finite numbers");
        writer.write_text(PENDING, &text)?;
    }
    let mut columns = Columns::new(writer, &branches.paths);
    columns.members(ORIGIN, |path| StoredOrigin::from(path.origin))?;
    columns.members(END, |path| stored_end(path.end))?;
    columns.counts(N_POINTS, |path| path.points.len())?;
    let points: Vec<&PathPoint> = branches
        .paths
        .iter()
        .flat_map(|path| &path.points)
        .collect();
    write_points(writer, &points)?;
    let switches: Vec<(usize, Switch)> = points
        .iter()
        .enumerate()
        .flat_map(|(k, point)| point.switches.iter().map(move |switch| (k, *switch)))
        .collect();
    let mut columns = Columns::new(writer, &switches);
    columns.counts(SWITCH_POINT, |(point, _)| *point)?;
    columns.members(SWITCH_KIND, |(_, switch)| stored_switch(*switch).0)?;
    columns.counts(SWITCH_INDEX, |(_, switch)| stored_switch(*switch).1)
}

fn write_certificates(
    writer: &mut GroupWriter<'_>,
    certificates: &[Result<Certificate, Undecided>; 2],
) -> Result<(), StoreError> {
    let mut columns = Columns::new(writer, certificates);
    columns.flags(CERTIFIED, Result::is_ok)?;
    columns.members(UNDECIDED, |all| {
        StoredUndecided::from(all.err().unwrap_or(Undecided::NotAsked))
    })?;
    columns.counts(SOLUTIONS, |all| all.map_or(0, |all| all.solutions))?;
    columns.counts(STATES, |all| all.map_or(0, |all| all.states))?;
    columns.counts(BOXES, |all| all.map_or(0, |all| all.boxes))?;
    columns.numbers(MARGIN, |all| all.map_or(f64::NAN, |all| all.margin))?;
    columns.numbers(LEAST_DETERMINANT, |all| {
        all.map_or(f64::NAN, |all| all.determinant)
    })?;
    columns.numbers(WIDTH, |all| all.map_or(f64::NAN, |all| all.width))?;
    columns.numbers(UNCERTAINTY, |all| {
        all.map_or(f64::NAN, |all| all.uncertainty)
    })
}

fn read_certificates(reader: &Reader) -> Result<[Result<Certificate, Undecided>; 2], FormatError> {
    if !reader.has(CERTIFIED) {
        return Ok([Err(Undecided::NotAsked); 2]);
    }
    let undecided = match reader.has(UNDECIDED) {
        true => {
            let stored = reader.read_enum::<StoredUndecided>(UNDECIDED)?;
            stored.iter().copied().collect()
        }
        false => vec![StoredUndecided::NotAsked; 2],
    };
    let proven = reader.read_vec::<u8>(CERTIFIED)?;
    let counts = [SOLUTIONS, STATES, BOXES].map(|path| read_index_vec(reader, path));
    let [solutions, states, boxes] = counts;
    let (solutions, states, boxes) = (solutions?, states?, boxes?);
    let margin: Vec<f64> = reader.read_vec(MARGIN)?;
    let determinant: Vec<f64> = reader.read_vec(LEAST_DETERMINANT)?;
    let width: Vec<f64> = reader.read_vec(WIDTH)?;
    let uncertainty: Vec<f64> = reader.read_vec(UNCERTAINTY)?;
    Ok([0, 1].map(|end| {
        if proven[end] == 0 {
            return Err(undecided[end].into());
        }
        Ok(Certificate {
            solutions: solutions[end],
            states: states[end],
            boxes: boxes[end],
            margin: margin[end],
            determinant: determinant[end],
            width: width[end],
            uncertainty: uncertainty[end],
        })
    }))
}

fn write_points(writer: &mut GroupWriter<'_>, points: &[&PathPoint]) -> Result<(), StoreError> {
    let mut columns = Columns::new(writer, points);
    columns.numbers(PARAMETER, |point| point.parameter)?;
    columns.members(POINT_KIND, |point| StoredPointKind::from(point.kind))?;
    columns.numbers(DETERMINANT, |point| i64::from(point.determinant))?;
    columns.numbers(SPECTRAL_RADIUS, |point| point.spectral_radius)?;
    columns.flags(ATTRACTING, |point| point.is_attracting())?;
    columns.numbers(RESIDUAL, |point| point.residual)?;
    columns.vectors(ZONES, |point| point.zones.map(|count| count as i64))?;
    columns.numbers(NORMAL_FORCE, |point| point.normal_force)?;
    columns.vectors(TANGENTIAL_FORCE, |point| point.tangential_force)?;
    columns.numbers(LARGEST_PRESSURE, |point| point.largest_pressure)?;
    let multipliers: Vec<f64> = points
        .iter()
        .flat_map(|p| p.multiplier.iter().copied())
        .collect();
    let width = points.first().map_or(0, |point| point.multiplier.len());
    writer.write(MULTIPLIER, &multipliers, &[points.len(), width])
}

/// Reads all paths, with what is still to be followed.
///
/// # Errors
/// Missing, altered or contradictory datasets.
pub fn read(reader: &Reader) -> Result<Branches, FormatError> {
    let range = read_finite_vec(reader, RANGE)?;
    let flag = |path: &str| -> Result<bool, StoreError> {
        Ok(reader
            .read_vec::<u8>(path)?
            .first()
            .is_some_and(|flag| *flag != 0))
    };
    let pending = match reader.has(PENDING) {
        false => None,
        true => {
            let text = reader.read_text(PENDING)?;
            let parsed = serde_json::from_str(&text);
            Some(parsed.map_err(|error| FormatError::Inconsistent {
                dataset: PENDING,
                reason: format!("expected fronts of paths as JSON, found {error}"),
            })?)
        }
    };
    let origins = reader.read_enum::<StoredOrigin>(ORIGIN)?;
    let ends = reader.read_enum::<StoredEnd>(END)?;
    let counts = read_index_vec(reader, N_POINTS)?;
    let mut points = read_points(reader)?;
    if counts.iter().sum::<usize>() != points.len() {
        return Err(FormatError::Inconsistent {
            dataset: N_POINTS,
            reason: format!("expected {} points in all, found others", points.len()),
        });
    }
    let paths = counts.iter().enumerate().map(|(k, count)| {
        let rest = points.split_off(*count);
        Path {
            origin: origins[k].into(),
            points: std::mem::replace(&mut points, rest),
            end: end(ends[k]),
        }
    });
    Ok(Branches {
        paths: paths.collect(),
        range: ParameterRange {
            key: reader.read_text(KEY)?,
            from: range[0],
            to: range[1],
        },
        all: flag(ALL)?,
        certificates: read_certificates(reader)?,
        stress: read_finite_scalar(reader, STRESS)?,
        left_out: read_index_vec(reader, LEFT_OUT)?
            .first()
            .copied()
            .unwrap_or(0),
        pending,
    })
}

fn read_points(reader: &Reader) -> Result<Vec<PathPoint>, FormatError> {
    let parameters = read_finite_vec(reader, PARAMETER)?;
    let kinds = reader.read_enum::<StoredPointKind>(POINT_KIND)?;
    let determinants: Vec<i64> = reader.read_vec(DETERMINANT)?;
    let radii: Vec<f64> = reader.read_vec(SPECTRAL_RADIUS)?;
    let residuals: Vec<f64> = reader.read_vec(RESIDUAL)?;
    let zones = read_index_vec(reader, ZONES)?;
    let normal = read_finite_vec(reader, NORMAL_FORCE)?;
    let tangential = read_finite_rows::<2>(reader, TANGENTIAL_FORCE)?;
    let pressures = read_finite_vec(reader, LARGEST_PRESSURE)?;
    let multipliers = read_finite_vec(reader, MULTIPLIER)?;
    let width = multipliers.len() / parameters.len().max(1);
    let mut switches = vec![Vec::new(); parameters.len()];
    let places = read_index_vec(reader, SWITCH_POINT)?;
    require_below(SWITCH_POINT, places.iter().copied(), parameters.len())?;
    let of_kind = reader.read_enum::<StoredSwitch>(SWITCH_KIND)?;
    let indices = read_index_vec(reader, SWITCH_INDEX)?;
    for ((place, kind), index) in places.iter().zip(&of_kind).zip(indices) {
        switches[*place].push(switch(*kind, index));
    }
    let points = (0..parameters.len()).map(|k| PathPoint {
        parameter: parameters[k],
        multiplier: multipliers[k * width..(k + 1) * width].to_vec(),
        kind: kinds[k].into(),
        switches: std::mem::take(&mut switches[k]),
        residual: residuals[k],
        determinant: i8::try_from(determinants[k].signum()).unwrap_or(0),
        spectral_radius: radii[k],
        zones: [zones[3 * k], zones[3 * k + 1], zones[3 * k + 2]],
        normal_force: normal[k],
        tangential_force: tangential[k],
        largest_pressure: pressures[k],
    });
    Ok(points.collect())
}
