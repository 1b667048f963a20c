//! `/solve/history` and `/solve/newton`: what each step of the solvers did.

use super::{FormatError, read_index_vec};
use crate::{
    solver::{NewtonStep, OuterStep, StepCounts},
    store::{DatasetSpec, Extent, Extent::Named, Kind, Reader, Stage, StageWriter, StoreError},
};

const CHANGE: &str = "/solve/history/change";
const INNER_TOLERANCE: &str = "/solve/history/inner_tolerance";
const INNER_RESIDUAL: &str = "/solve/history/inner_residual";
const CG_STEPS: &str = "/solve/history/conjugate_gradient_steps";
const EXPANSION_STEPS: &str = "/solve/history/expansion_steps";
const PROPORTIONING_STEPS: &str = "/solve/history/proportioning_steps";
const STEP_ACTIONS: &str = "/solve/history/actions";
const SECONDS: &str = "/solve/history/seconds";
const NEWTON_RESIDUAL: &str = "/solve/newton/residual";
const NEWTON_STEP_LENGTH: &str = "/solve/newton/step_length";
const NEWTON_HALVINGS: &str = "/solve/newton/halvings";
const NEWTON_ZONE_CHANGES: &str = "/solve/newton/zone_changes";
const NEWTON_UNKNOWNS: &str = "/solve/newton/free_unknowns";
const NEWTON_FALLBACK: &str = "/solve/newton/fallback";
const NEWTON_SECONDS: &str = "/solve/newton/seconds";
const STEPS: &[Extent] = &[Named("n_outer_steps")];
const NEWTON: &[Extent] = &[Named("n_newton_steps")];

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    Stage::Solve.row(NEWTON_RESIDUAL, Kind::F64, NEWTON, "1", "|R| / |lambda| after each Newton step."),
    Stage::Solve.row(NEWTON_STEP_LENGTH, Kind::F64, NEWTON, "1", "Share of the Newton step taken."),
    Stage::Solve.row(NEWTON_HALVINGS, Kind::I64, NEWTON, "1", "Halvings of the step tried."),
    Stage::Solve.row(NEWTON_ZONE_CHANGES, Kind::I64, NEWTON, "1", "Panes that changed between open, stick and slip."),
    Stage::Solve.row(NEWTON_UNKNOWNS, Kind::I64, NEWTON, "1", "Unknowns of the dense linear system."),
    Stage::Solve.row(NEWTON_FALLBACK, Kind::U8, NEWTON, "1", "1 where the safeguard replaced Newton's step."),
    Stage::Solve.row(NEWTON_SECONDS, Kind::F64, NEWTON, "s", "Wall-clock time of each Newton step.").volatile(),
    Stage::Solve.row(CHANGE, Kind::F64, STEPS, "1", "Relative change of the multipliers in each outer step.").symbol("err"),
    Stage::Solve.row(INNER_TOLERANCE, Kind::F64, STEPS, "1", "Tolerance of each inner problem, relative to the norm of h.").symbol("epsilon_lambda"),
    Stage::Solve.row(INNER_RESIDUAL, Kind::F64, STEPS, "1", "Norm of the reduced gradient at the end of each inner problem, relative to the norm of h."),
    Stage::Solve.row(CG_STEPS, Kind::I64, STEPS, "1", "Conjugate gradient steps."),
    Stage::Solve.row(EXPANSION_STEPS, Kind::I64, STEPS, "1", "Expansion steps."),
    Stage::Solve.row(PROPORTIONING_STEPS, Kind::I64, STEPS, "1", "Proportioning steps."),
    Stage::Solve.row(STEP_ACTIONS, Kind::I64, STEPS, "1", "Actions of the inverse stiffness matrix; the first step includes those that estimate the norm of S."),
    Stage::Solve.row(SECONDS, Kind::F64, STEPS, "s", "Wall-clock time of each outer step.").volatile(),
];

/// Writes one record per Newton step.
pub(super) fn write_newton(
    writer: &mut StageWriter<'_>,
    steps: &[NewtonStep],
) -> Result<(), StoreError> {
    type Measure = fn(&NewtonStep) -> f64;
    type Count = fn(&NewtonStep) -> usize;
    let measures: [(&str, Measure); 3] = [
        (NEWTON_RESIDUAL, |s| s.residual),
        (NEWTON_STEP_LENGTH, |s| s.step_length),
        (NEWTON_SECONDS, |s| s.seconds),
    ];
    for (path, measure) in measures {
        let values: Vec<f64> = steps.iter().map(measure).collect();
        writer.write(path, &values, &[values.len()])?;
    }
    let counts: [(&str, Count); 3] = [
        (NEWTON_HALVINGS, |s| s.halvings),
        (NEWTON_ZONE_CHANGES, |s| s.zone_changes),
        (NEWTON_UNKNOWNS, |s| s.free_unknowns),
    ];
    for (path, count) in counts {
        let values: Vec<usize> = steps.iter().map(count).collect();
        writer.write_indices(path, &values, &[values.len()])?;
    }
    let fallbacks: Vec<u8> = steps.iter().map(|s| u8::from(s.fallback)).collect();
    writer.write(NEWTON_FALLBACK, &fallbacks, &[fallbacks.len()])
}

/// Writes one record per step of successive approximations.
pub(super) fn write_outer(
    writer: &mut StageWriter<'_>,
    history: &[OuterStep],
) -> Result<(), StoreError> {
    type Measure = fn(&OuterStep) -> f64;
    type Count = fn(&OuterStep) -> usize;
    let measures: [(&str, Measure); 4] = [
        (CHANGE, |s| s.change),
        (INNER_TOLERANCE, |s| s.inner_tolerance),
        (INNER_RESIDUAL, |s| s.inner_residual),
        (SECONDS, |s| s.seconds),
    ];
    for (path, measure) in measures {
        let values: Vec<f64> = history.iter().map(measure).collect();
        writer.write(path, &values, &[values.len()])?;
    }
    let counts: [(&str, Count); 4] = [
        (CG_STEPS, |s| s.steps.conjugate_gradient),
        (EXPANSION_STEPS, |s| s.steps.expansion),
        (PROPORTIONING_STEPS, |s| s.steps.proportioning),
        (STEP_ACTIONS, |s| s.actions),
    ];
    for (path, count) in counts {
        let values: Vec<usize> = history.iter().map(count).collect();
        writer.write_indices(path, &values, &[values.len()])?;
    }
    Ok(())
}

/// Reads the records of Newton steps.
pub(super) fn read_newton(reader: &Reader) -> Result<Vec<NewtonStep>, FormatError> {
    let residual: Vec<f64> = reader.read_vec(NEWTON_RESIDUAL)?;
    let step_length: Vec<f64> = reader.read_vec(NEWTON_STEP_LENGTH)?;
    let seconds: Vec<f64> = reader.read_vec(NEWTON_SECONDS)?;
    let halvings = read_index_vec(reader, NEWTON_HALVINGS)?;
    let zone_changes = read_index_vec(reader, NEWTON_ZONE_CHANGES)?;
    let free_unknowns = read_index_vec(reader, NEWTON_UNKNOWNS)?;
    let fallback: Vec<u8> = reader.read_vec(NEWTON_FALLBACK)?;
    let steps = (0..residual.len()).map(|k| NewtonStep {
        residual: residual[k],
        step_length: step_length[k],
        halvings: halvings[k],
        zone_changes: zone_changes[k],
        free_unknowns: free_unknowns[k],
        fallback: fallback[k] != 0,
        seconds: seconds[k],
    });
    Ok(steps.collect())
}

/// Reads the records of successive approximations.
pub(super) fn read_outer(reader: &Reader) -> Result<Vec<OuterStep>, FormatError> {
    let changes: Vec<f64> = reader.read_vec(CHANGE)?;
    let tolerances: Vec<f64> = reader.read_vec(INNER_TOLERANCE)?;
    let residuals: Vec<f64> = reader.read_vec(INNER_RESIDUAL)?;
    let seconds: Vec<f64> = reader.read_vec(SECONDS)?;
    let actions = read_index_vec(reader, STEP_ACTIONS)?;
    let conjugate_gradient = read_index_vec(reader, CG_STEPS)?;
    let expansion = read_index_vec(reader, EXPANSION_STEPS)?;
    let proportioning = read_index_vec(reader, PROPORTIONING_STEPS)?;
    let steps = (0..changes.len()).map(|k| OuterStep {
        change: changes[k],
        inner_tolerance: tolerances[k],
        inner_residual: residuals[k],
        steps: StepCounts {
            conjugate_gradient: conjugate_gradient[k],
            expansion: expansion[k],
            proportioning: proportioning[k],
        },
        actions: actions[k],
        seconds: seconds[k],
    });
    Ok(steps.collect())
}
