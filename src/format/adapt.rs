//! `/adapt`: the levels of an adaptive mesh, and what the next one is made of.

use contact3d::{
    adaptation::{Adaptation, AdaptiveLevel, AdaptiveStatus},
    mesh::RefinedLevel,
};
use runfile::{Extent, Extent::Named, Group, GroupWriter, Kind, Reader, StoreError, StoredEnum};
use units::Dimension;

use super::{
    FormatError, Stage,
    fields::{Fields, fields, read_finite, read_if_there, read_value, write_value},
    stored::{Stored, stored_as},
};

/// The levels of an adaptive mesh.
pub const GROUP: Group = Group::new("adapt", Stage::Mesh.command());

stored_as! {
    /// How an adaptive computation stands, as stored.
    StoredAdaptiveStatus of AdaptiveStatus as "adaptive_status" {
        Refining = 0 => "refining",
        Met = 1 => "met",
        NotConverged = 2 => "not_converged",
        TooLarge = 3 => "too_large",
        Stalled = 4 => "stalled",
        OverBudget = 5 => "over_budget",
        NotEstimated = 6 => "not_estimated",
        Unbounded = 7 => "unbounded",
    }
}

const STATUS: &str = "/adapt/status";
const CELLS: &str = "/adapt/cells";
const CUTS: &str = "/adapt/cuts";
const N_CUTS: &str = "/adapt/n_cuts";
const START: &str = "/adapt/start";
const N_START: &str = "/adapt/n_start";

const LEVELS: &[Extent] = &[Named("n_adaptive_levels")];
const REFINEMENTS: &[Extent] = &[Named("n_refinements")];

pub(super) const FIELDS: Fields<AdaptiveLevel> = fields! { AdaptiveLevel => GROUP;
    {Kind::Enum(StoredAdaptiveStatus::SPEC)} STATUS, &[], Dimension::Number, "How the levels stand with the error that the scene asks for.";
    (n_tetrahedra) "/adapt/levels/n_tetrahedra", LEVELS, Dimension::Number, "Tetrahedra.";
    (n_free) "/adapt/levels/n_free", LEVELS, Dimension::Number, "Free degrees of freedom.";
    (n_multipliers) "/adapt/levels/n_multipliers", LEVELS, Dimension::Number, "Multipliers.";
    (n_closed) "/adapt/levels/n_closed_panes", LEVELS, Dimension::Number, "Panes in contact, of a load history in its last increment.";
    (estimated_error) "/adapt/levels/estimated_error", LEVELS, Dimension::Number, "Estimated discretisation error over |u|_A; of a mesh that is refined for a quantity (adapt.of), the estimated error of that over its value.";
    (nan value) "/adapt/levels/value", LEVELS, Dimension::Number, "Value of the quantity that the mesh is refined for (adapt.of), in its unit; NaN where it is refined for the energy norm, and of a load history.";
    (status) "/adapt/levels/status", LEVELS, Dimension::Number, "How the solve ended.";
    (seconds) "/adapt/levels/seconds", LEVELS, Dimension::Time, "Wall-clock time of mesh, assembly, solve and evaluation.".volatile();
    {Kind::I64} CELLS, &[Named("n_refinements"), Extent::Fixed(3)], Dimension::Number, "Cells along the edges of a brick that was meshed anew for a level, 0 where the level before was cut.".optional("absent where every level was cut");
    {Kind::I64} N_CUTS, REFINEMENTS, Dimension::Number, "Tetrahedra of each level that was cut, the entries of `cuts` that are its own.";
    {Kind::U8} CUTS, &[Named("n_cut_tetrahedra")], Dimension::Number, "How often each tetrahedron of a level was to be cut in two to make the next one; level after level.".compressed();
    {Kind::I64} N_START, REFINEMENTS, Dimension::Number, "Multipliers of each level that was made, the entries of `start` that are its own.";
    {Kind::F64} START, &[Named("n_start_multipliers")], Dimension::STRESS, "Multipliers that each refined level starts from; level after level.".symbol("lambda");
};

/// Writes the levels done and the cuts that follow.
pub fn write(
    writer: &mut GroupWriter<'_>,
    adaptation: &Adaptation,
    status: AdaptiveStatus,
) -> Result<(), StoreError> {
    write_value(writer, STATUS, &status)?;
    FIELDS.write_rows(writer, &adaptation.levels)?;
    let levels = &adaptation.refinement;
    let cells = levels.iter().map(|level| match level {
        RefinedLevel::Cells(cells) => *cells,
        RefinedLevel::Cuts(_) => [0; 3],
    });
    let cells: Vec<[usize; 3]> = cells.collect();
    if cells.iter().any(|cells| *cells != [0; 3]) {
        write_value(writer, CELLS, &cells)?;
    }
    let cuts = levels.iter().map(|level| match level {
        RefinedLevel::Cells(_) => Vec::new(),
        RefinedLevel::Cuts(cuts) => cuts.clone(),
    });
    write_lists(writer, [N_CUTS, CUTS], &cuts.collect::<Vec<_>>())?;
    write_lists(writer, [N_START, START], &adaptation.starts)
}

/// Writes lists one after the other, and how long each is.
fn write_lists<V: Stored>(
    writer: &mut GroupWriter<'_>,
    [lengths, values]: [&str; 2],
    lists: &[Vec<V>],
) -> Result<(), StoreError> {
    let each: Vec<usize> = lists.iter().map(Vec::len).collect();
    write_value(writer, lengths, &each)?;
    write_value(writer, values, &lists.concat())
}

/// Reads the levels done, with how they stood.
pub fn read(reader: &Reader) -> Result<(Adaptation, AdaptiveStatus), FormatError> {
    let cuts = divided(read_value(reader, N_CUTS)?, read_value(reader, CUTS)?);
    let cells: Option<Vec<[usize; 3]>> = read_if_there(reader, CELLS)?;
    let cells = cells.unwrap_or_else(|| vec![[0; 3]; cuts.len()]);
    let levels = cells.into_iter().zip(cuts).map(|level| match level {
        ([0, 0, 0], cuts) => RefinedLevel::Cuts(cuts),
        (cells, _) => RefinedLevel::Cells(cells),
    });
    let adaptation = Adaptation {
        levels: FIELDS.read_rows(reader, AdaptiveLevel::default)?,
        refinement: levels.collect(),
        starts: divided(read_value(reader, N_START)?, read_finite(reader, START)?),
    };
    Ok((adaptation, read_value(reader, STATUS)?))
}

/// How the levels stand; `None` in a file without any.
pub fn read_status(reader: &Reader) -> Result<Option<AdaptiveStatus>, FormatError> {
    read_if_there(reader, STATUS)
}

/// Consecutive parts of some lengths.
fn divided<T>(lengths: Vec<usize>, mut values: Vec<T>) -> Vec<Vec<T>> {
    let part = |length: usize| {
        let rest = values.split_off(length.min(values.len()));
        std::mem::replace(&mut values, rest)
    };
    lengths.into_iter().map(part).collect()
}
