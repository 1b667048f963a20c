//! `/branches`: paths of solutions in a parameter of the scene.

use runfile::{
    Extent,
    Extent::{Fixed, Named},
    Group, GroupWriter, Kind, Reader, StoreError, StoredEnum,
};
use studies::branches::{Branches, Path, PathEnd, PathOrigin, PathPoint, PointKind, Switch};
use units::Dimension;

use super::{
    FormatError, extents,
    fields::{Fields, fields, read_value, write_value},
    require, require_below,
    stored::stored_as,
};

/// Paths of solutions; computed from the scene alone.
pub const GROUP: Group = Group::new("branches", "branches");

stored_as! {
    /// Where a path begins, as stored.
    StoredOrigin of PathOrigin as "path_origin" {
        Solver = 0 => "solver",
        Search = 1 => "search",
        BranchPoint = 2 => "branch_point",
    }
}

stored_as! {
    /// Why a path ends, as stored.
    StoredEnd of PathEnd as "path_end" {
        Range = 0 => "range",
        Closed = 1 => "closed",
        KnownPoint = 2 => "known_point",
        Degenerate = 3 => "degenerate",
        Stuck = 4 => "stuck",
        Uncertified = 5 => "uncertified",
        TooLong = 6 => "too_long",
    }
}

stored_as! {
    /// What is special about a point, as stored.
    StoredPointKind of PointKind as "path_point" {
        Start = 0 => "start",
        Regular = 1 => "regular",
        Kink = 2 => "kink",
        Fold = 3 => "fold",
        KinkFold = 4 => "kink_fold",
        BranchPoint = 5 => "branch_point",
        End = 6 => "end",
    }
}

runfile::stored_enum! {
    /// What changes at a point, as stored.
    enum StoredSwitch as "switch" {
        Opening = 0 => "opening",
        Slipping = 1 => "slipping",
        Cap = 2 => "cap",
        Reversal1 = 3 => "reversal_1",
        Reversal2 = 4 => "reversal_2",
        Knot1 = 5 => "knot_1",
        Knot2 = 6 => "knot_2",
    }
}

const N_POINTS: &str = "/branches/path/n_points";
const SWITCH_POINT: &str = "/branches/switch/point";
const SWITCH_KIND: &str = "/branches/switch/kind";
const SWITCH_INDEX: &str = "/branches/switch/index";

const PATHS: &[Extent] = &[Named("n_paths")];
const POINTS: &[Extent] = &[Named("n_path_points")];
const POINT_PAIRS: &[Extent] = &[Named("n_path_points"), extents::FRICTION_AXES];
const POINT_ZONES: &[Extent] = &[Named("n_path_points"), extents::ZONES];
const POINT_MULTIPLIERS: &[Extent] = &[Named("n_path_points"), Named("n_path_multipliers")];
const SWITCHES: &[Extent] = &[Named("n_switches")];

pub(super) const OF_SEARCH: Fields<Branches> = fields! { Branches => GROUP;
    (range.key) "/branches/key", &[], Dimension::Number, "The key of the scene that is the parameter.";
    [|branches| [branches.range.from, branches.range.to], |branches, [from, to]| (branches.range.from, branches.range.to) = (from, to)] "/branches/range", &[Fixed(2)], Dimension::Number, "Where the parameter begins and ends, in the unit of the key.".finite();
    (all) "/branches/all", &[], Dimension::Number, "1 where all solutions were searched for at both ends of the range.";
    (stress) "/branches/stress_scale", &[], Dimension::STRESS, "Size of stresses that lengths of steps are measured by, a power of two.".symbol("Lambda").finite();
    (left_out) "/branches/left_out", &[], Dimension::Number, "Half paths from branch points that were not followed, since there are so many.";
};

pub(super) const OF_PATHS: Fields<Path> = fields! { Path => GROUP;
    (origin) "/branches/path/origin", PATHS, Dimension::Number, "Where a path begins: at the solver's answer, at a solution that was searched for, at a branch point.";
    (end) "/branches/path/end", PATHS, Dimension::Number, "Why a path ends.";
    [|path| path.points.len()] N_POINTS, PATHS, Dimension::Number, "Points of a path, those of the first path first.";
};

pub(super) const OF_POINTS: Fields<PathPoint> = fields! { PathPoint => GROUP;
    (parameter) "/branches/point/parameter", POINTS, Dimension::Number, "The parameter, in the unit of the key.".symbol("gamma").finite();
    (kind) "/branches/point/kind", POINTS, Dimension::Number, "What is special about a point.";
    (determinant) "/branches/point/determinant_sign", POINTS, Dimension::Number, "Sign of the determinant of Newton's matrix, on the side the path comes from; 0 at folds.".symbol("sign det R'");
    (spectral_radius) "/branches/point/spectral_radius", POINTS, Dimension::Number, "Spectral radius of the derivative of the mapping Psi, on the side the path comes from; NaN where it has none.".symbol("rho(Psi')");
    [PathPoint::is_attracting] "/branches/point/attracting", POINTS, Dimension::Number, "1 where the spectral radius is below 1: successive approximations converge from nearby.";
    (residual) "/branches/point/residual", POINTS, Dimension::Number, "Residual of the natural map over the multipliers, measured by local stiffness.";
    (zones) "/branches/point/zone_counts", POINT_ZONES, Dimension::Number, "Numbers of open, sticking and slipping panes, on the side the path comes from.";
    (normal_force) "/branches/point/normal_force", POINTS, Dimension::FORCE, "Total normal contact force.".finite();
    (tangential_force) "/branches/point/tangential_force", POINT_PAIRS, Dimension::FORCE, "Total tangential multiplier force along t1 and t2.".finite();
    (largest_pressure) "/branches/point/largest_pressure", POINTS, Dimension::STRESS, "Largest normal multiplier.".finite();
    (multiplier) "/branches/point/multiplier", POINT_MULTIPLIERS, Dimension::STRESS, "Multipliers: the normal ones, then the tangential pairs.".symbol("lambda").finite();
    {Kind::I64} SWITCH_POINT, SWITCHES, Dimension::Number, "The point at which a pane or a node changes.";
    {Kind::Enum(StoredSwitch::SPEC)} SWITCH_KIND, SWITCHES, Dimension::Number, "What changes: a pane opens or closes, slips or sticks, reaches the pressure cap; the slip of a contact node changes its sign along an axis, or reaches a knot of a coefficient.";
    {Kind::I64} SWITCH_INDEX, SWITCHES, Dimension::Number, "The pane or the contact node.";
};

/// Writes all paths.
pub fn write(writer: &mut GroupWriter<'_>, branches: &Branches) -> Result<(), StoreError> {
    OF_SEARCH.write_one(writer, branches)?;
    OF_PATHS.write_rows(writer, &branches.paths)?;
    let points = branches.paths.iter().flat_map(|path| &path.points);
    OF_POINTS.write_rows(writer, points.clone())?;
    let (mut places, mut kinds, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for (place, point) in points.enumerate() {
        for (kind, index) in point.switches.iter().copied().map(stored_switch) {
            places.push(place);
            kinds.push(kind);
            indices.push(index);
        }
    }
    write_value(writer, SWITCH_POINT, &places)?;
    writer.write_enum(SWITCH_KIND, &kinds, &[kinds.len()])?;
    write_value(writer, SWITCH_INDEX, &indices)
}

/// Reads all paths.
pub fn read(reader: &Reader) -> Result<Branches, FormatError> {
    let mut branches = Branches {
        paths: read_paths(reader)?,
        ..Branches::default()
    };
    OF_SEARCH.read_one(reader, &mut branches, true)?;
    Ok(branches)
}

fn read_paths(reader: &Reader) -> Result<Vec<Path>, FormatError> {
    let mut paths = OF_PATHS.read_rows(reader, || Path {
        origin: PathOrigin::Solver,
        points: Vec::new(),
        end: PathEnd::TooLong,
    })?;
    let lengths: Vec<usize> = read_value(reader, N_POINTS)?;
    let points = read_points(reader)?;
    let n_points = points.len();
    require(lengths.iter().sum::<usize>() == n_points, N_POINTS, || {
        format!("expected {n_points} points in all, found others")
    })?;
    let mut points = points.into_iter();
    for (path, length) in paths.iter_mut().zip(lengths) {
        path.points = points.by_ref().take(length).collect();
    }
    Ok(paths)
}

fn read_points(reader: &Reader) -> Result<Vec<PathPoint>, FormatError> {
    let mut points = OF_POINTS.read_rows(reader, PathPoint::default)?;
    let places: Vec<usize> = read_value(reader, SWITCH_POINT)?;
    require_below(SWITCH_POINT, &places, points.len())?;
    let kinds = reader.read_enum::<StoredSwitch>(SWITCH_KIND)?;
    let indices: Vec<usize> = read_value(reader, SWITCH_INDEX)?;
    for ((place, kind), index) in places.into_iter().zip(&kinds).zip(indices) {
        points[place].switches.push(switch(*kind, index));
    }
    Ok(points)
}

fn stored_switch(switch: Switch) -> (StoredSwitch, usize) {
    match switch {
        Switch::Opening(pane) => (StoredSwitch::Opening, pane),
        Switch::Slipping(pane) => (StoredSwitch::Slipping, pane),
        Switch::Cap(pane) => (StoredSwitch::Cap, pane),
        Switch::Reversal(node, 0) => (StoredSwitch::Reversal1, node),
        Switch::Reversal(node, _) => (StoredSwitch::Reversal2, node),
        Switch::Knot(node, 0) => (StoredSwitch::Knot1, node),
        Switch::Knot(node, _) => (StoredSwitch::Knot2, node),
    }
}

fn switch(stored: StoredSwitch, index: usize) -> Switch {
    match stored {
        StoredSwitch::Opening => Switch::Opening(index),
        StoredSwitch::Slipping => Switch::Slipping(index),
        StoredSwitch::Cap => Switch::Cap(index),
        StoredSwitch::Reversal1 => Switch::Reversal(index, 0),
        StoredSwitch::Reversal2 => Switch::Reversal(index, 1),
        StoredSwitch::Knot1 => Switch::Knot(index, 0),
        StoredSwitch::Knot2 => Switch::Knot(index, 1),
    }
}
