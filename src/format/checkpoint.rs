//! `/checkpoint`: successive approximations between two steps, so that a killed solve goes on.

use contact3d::solver::OuterState;
use runfile::{DatasetSpec, Extent, Extent::Named, Group, GroupWriter, Kind, Reader, StoreError};
use units::Dimension;

use super::{
    FormatError, Stage, axes, history, read_finite_rows, read_finite_scalar, read_finite_vec,
};
use super::{history::OuterPaths, read_index_vec};

/// How far an unfinished solve has come.
pub const GROUP: Group = Group::new("checkpoint", Stage::Solve.command());

const MULTIPLIER: &str = "/checkpoint/multiplier";
const SLIP: &str = "/checkpoint/slip";
const TOLERANCE: &str = "/checkpoint/inner_tolerance";
const STEPLENGTH: &str = "/checkpoint/steplength";
const LAW_EVALUATIONS: &str = "/checkpoint/law_evaluations";
const PROJECTIONS: &str = "/checkpoint/projections";
const STEPS: &[Extent] = &[Named("n_done_steps")];

const HISTORY: OuterPaths = OuterPaths {
    change: "/checkpoint/history/change",
    inner_tolerance: "/checkpoint/history/inner_tolerance",
    inner_residual: "/checkpoint/history/inner_residual",
    conjugate_gradient: "/checkpoint/history/conjugate_gradient_steps",
    expansion: "/checkpoint/history/expansion_steps",
    proportioning: "/checkpoint/history/proportioning_steps",
    applications: "/checkpoint/history/actions",
    seconds: "/checkpoint/history/seconds",
};

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row(MULTIPLIER, Kind::F64, &[Named("n_multipliers")], Dimension::STRESS, "Multipliers after the last step done: the normal ones, then the tangential pairs.").symbol("lambda"),
    GROUP.row(SLIP, Kind::F64, &[Named("n_contact_nodes"), axes::FRICTION_AXES], Dimension::LENGTH, "Absolute tangential displacements of the contact nodes.").symbol("phi").optional("absent unless friction follows the slip"),
    GROUP.row(TOLERANCE, Kind::F64, &[], Dimension::Number, "Tolerance of the last inner problem."),
    GROUP.row(STEPLENGTH, Kind::F64, &[], Dimension::PER_DUAL, "Steplength of projected gradient steps.").symbol("alpha"),
    GROUP.row(LAW_EVALUATIONS, Kind::I64, &[], Dimension::Number, "Evaluations of the friction law so far."),
    GROUP.row(PROJECTIONS, Kind::I64, &[], Dimension::Number, "Projections on an ellipse so far."),
    GROUP.row(HISTORY.change, Kind::F64, STEPS, Dimension::Number, "As in /solve/history."),
    GROUP.row(HISTORY.inner_tolerance, Kind::F64, STEPS, Dimension::Number, "As in /solve/history."),
    GROUP.row(HISTORY.inner_residual, Kind::F64, STEPS, Dimension::Number, "As in /solve/history."),
    GROUP.row(HISTORY.conjugate_gradient, Kind::I64, STEPS, Dimension::Number, "As in /solve/history."),
    GROUP.row(HISTORY.expansion, Kind::I64, STEPS, Dimension::Number, "As in /solve/history."),
    GROUP.row(HISTORY.proportioning, Kind::I64, STEPS, Dimension::Number, "As in /solve/history."),
    GROUP.row(HISTORY.applications, Kind::I64, STEPS, Dimension::Number, "As in /solve/history."),
    GROUP.row(HISTORY.seconds, Kind::F64, STEPS, Dimension::Time, "As in /solve/history.").volatile(),
];

/// Writes the state between two steps.
///
/// # Errors
/// HDF5 failures.
pub fn write(writer: &mut GroupWriter<'_>, state: &OuterState) -> Result<(), StoreError> {
    writer.write(MULTIPLIER, &state.multiplier, &[state.multiplier.len()])?;
    if let Some(slip) = &state.slip {
        writer.write(SLIP, slip.as_flattened(), &[slip.len(), 2])?;
    }
    writer.write(TOLERANCE, &[state.tolerance], &[])?;
    writer.write(STEPLENGTH, &[state.steplength], &[])?;
    writer.write_indices(LAW_EVALUATIONS, &[state.law_evaluations], &[])?;
    writer.write_indices(PROJECTIONS, &[state.projections], &[])?;
    history::write_outer(writer, &HISTORY, &state.history)
}

/// Reads the state between two steps.
///
/// # Errors
/// Missing or altered datasets.
pub fn read(reader: &Reader) -> Result<OuterState, FormatError> {
    let count = |path| -> Result<usize, FormatError> {
        Ok(read_index_vec(reader, path)?.first().copied().unwrap_or(0))
    };
    Ok(OuterState {
        multiplier: read_finite_vec(reader, MULTIPLIER)?,
        slip: match reader.has(SLIP) {
            true => Some(read_finite_rows(reader, SLIP)?),
            false => None,
        },
        tolerance: read_finite_scalar(reader, TOLERANCE)?,
        steplength: read_finite_scalar(reader, STEPLENGTH)?,
        history: history::read_outer(reader, &HISTORY)?,
        law_evaluations: count(LAW_EVALUATIONS)?,
        projections: count(PROJECTIONS)?,
    })
}
