//! `/solve/history`, `/solve/newton` and `/checkpoint`: what each step of the solvers did, and where successive approximations stand.

use contact3d::solver::{NewtonStep, OuterState, OuterStep};
use runfile::{DatasetSpec, Extent, Extent::Named, Group, GroupWriter, Reader, StoreError};
use units::Dimension;

use super::{
    FormatError, Stage, extents,
    fields::{Fields, fields, rows},
    sizes::length,
    solve,
};

/// How far an unfinished solve has come.
pub const CHECKPOINT: Group = Group::new("checkpoint", Stage::Solve.command());

const NEWTON: &[Extent] = &[Named("n_newton_steps")];
const OUTER: &[Extent] = &[Named("n_outer_steps")];
const DONE: &[Extent] = &[Named("n_done_steps")];

/// Successive approximations, in a place of a group.
macro_rules! outer_steps {
    ($group:expr, $place:literal, $steps:expr) => {
        fields! { OuterStep => $group;
            (change) concat!($place, "/change"), $steps, Dimension::Number, "Relative change of the multipliers in each outer step.".symbol("err");
            (inner_tolerance) concat!($place, "/inner_tolerance"), $steps, Dimension::Number, "Tolerance of each inner problem, relative to the norm of h.".symbol("epsilon_lambda");
            (inner_residual) concat!($place, "/inner_residual"), $steps, Dimension::Number, "Norm of the reduced gradient at the end of each inner problem, relative to the norm of h.";
            (steps.conjugate_gradient) concat!($place, "/conjugate_gradient_steps"), $steps, Dimension::Number, "Conjugate gradient steps.";
            (steps.expansion) concat!($place, "/expansion_steps"), $steps, Dimension::Number, "Expansion steps.";
            (steps.proportioning) concat!($place, "/proportioning_steps"), $steps, Dimension::Number, "Proportioning steps.";
            (applications) concat!($place, "/applications"), $steps, Dimension::Number, "Applications of the inverse stiffness matrix; the first step includes those that estimate the norm of S.";
            (seconds) concat!($place, "/seconds"), $steps, Dimension::Time, "Wall-clock time of each outer step.".volatile();
        }
    };
}

pub(super) const OUTER_STEPS: Fields<OuterStep> =
    outer_steps!(solve::GROUP, "/solve/history", OUTER);
pub(super) const DONE_STEPS: Fields<OuterStep> =
    outer_steps!(CHECKPOINT, "/checkpoint/history", DONE);

pub(super) const NEWTON_STEPS: Fields<NewtonStep> = fields! { NewtonStep => solve::GROUP;
    (residual) "/solve/newton/residual", NEWTON, Dimension::Number, "|R| / |lambda| after each Newton step.";
    (step_length) "/solve/newton/step_length", NEWTON, Dimension::Number, "Share of the Newton step taken.";
    (halvings) "/solve/newton/halvings", NEWTON, Dimension::Number, "Halvings of the step tried.";
    (zone_changes) "/solve/newton/zone_changes", NEWTON, Dimension::Number, "Panes that changed between open, stick and slip.";
    (free_unknowns) "/solve/newton/free_unknowns", NEWTON, Dimension::Number, "Unknowns of the dense linear system.";
    (fallback) "/solve/newton/fallback", NEWTON, Dimension::Number, "1 where the safeguard replaced Newton's step.";
    (seconds) "/solve/newton/seconds", NEWTON, Dimension::Time, "Wall-clock time of each Newton step.".volatile();
};

pub(super) const STATE: Fields<OuterState> = fields! { OuterState => CHECKPOINT;
    (multiplier) "/checkpoint/multiplier", &[Named("n_multipliers")], Dimension::STRESS, "Multipliers after the last step done: the normal ones, then the tangential pairs.".symbol("lambda").finite();
    (slip) "/checkpoint/slip", &[Named("n_contact_nodes"), extents::FRICTION_AXES], Dimension::LENGTH, "Absolute tangential displacements of the contact nodes.".symbol("phi").optional("absent unless friction follows the slip").finite();
    (tolerance) "/checkpoint/inner_tolerance", &[], Dimension::Number, "Tolerance of the last inner problem.".finite();
    (steplength) "/checkpoint/steplength", &[], Dimension::PER_DUAL, "Steplength of projected gradient steps.".symbol("alpha").finite();
    (law_evaluations) "/checkpoint/law_evaluations", &[], Dimension::Number, "Evaluations of the friction law so far.";
};

/// The rows of `DONE_STEPS`, whose meaning is that of `OUTER_STEPS`.
pub(super) const DONE_ROWS: &[DatasetSpec] = &{
    let mut rows = rows::<_, { DONE_STEPS.rows.len() }>(DONE_STEPS.fields);
    let mut k = 0;
    while k < rows.len() {
        rows[k].description = "As in /solve/history.";
        rows[k].symbol = "";
        k += 1;
    }
    rows
};

/// Numbers of steps of successive approximations and of Newton's method, by a column of each.
pub(super) fn counts(reader: &Reader) -> Result<[usize; 2], FormatError> {
    let [outer, newton] = [OUTER_STEPS.rows, NEWTON_STEPS.rows].map(|rows| rows[0].path);
    let counts = [
        length::<f64>(reader, outer)?,
        length::<f64>(reader, newton)?,
    ];
    Ok(counts.map(Option::unwrap_or_default))
}

/// Writes the state between two steps.
pub fn write_checkpoint(
    writer: &mut GroupWriter<'_>,
    state: &OuterState,
) -> Result<(), StoreError> {
    STATE.write_one(writer, state)?;
    DONE_STEPS.write_rows(writer, &state.history)
}

/// Reads the state between two steps.
pub fn read_checkpoint(reader: &Reader) -> Result<OuterState, FormatError> {
    let mut state = OuterState {
        history: DONE_STEPS.read_rows(reader, OuterStep::default)?,
        ..OuterState::default()
    };
    STATE.read_one(reader, &mut state, true)?;
    Ok(state)
}
