//! `/solve`: multipliers, displacement, state of friction, history.

use super::{FormatError, read_finite_rows, read_finite_scalar, read_finite_vec, read_index_vec};
use crate::{
    contact::FrictionField,
    elasticity::DofMap,
    solver::{NewtonStep, OuterStep, Solution, SolvedBy, Status, StepCounts},
    store::{
        DatasetSpec, Extent,
        Extent::{Fixed, Named},
        Kind, Reader, Stage, StageWriter, StoreError, StoredEnum, stored_enum,
    },
};

stored_enum! {
    /// How a solve ended, as stored.
    enum StoredStatus as "status" {
        Converged = 0 => "converged",
        MaxOuterSteps = 1 => "max_outer_steps",
        MaxInnerActions = 2 => "max_inner_actions",
        NumericalError = 3 => "numerical_error",
        RoundingLimit = 4 => "rounding_limit",
        MaxNewtonSteps = 5 => "max_newton_steps",
    }
}

stored_enum! {
    /// Which algorithm gave the answer, as stored.
    enum StoredMethod as "method" {
        FixedPoint = 0 => "fixed_point",
        Newton = 1 => "newton",
    }
}

const STATUSES: [(StoredStatus, Status); 6] = [
    (StoredStatus::Converged, Status::Converged),
    (StoredStatus::MaxOuterSteps, Status::MaxOuterSteps),
    (StoredStatus::MaxInnerActions, Status::MaxInnerActions),
    (StoredStatus::NumericalError, Status::NumericalError),
    (StoredStatus::RoundingLimit, Status::RoundingLimit),
    (StoredStatus::MaxNewtonSteps, Status::MaxNewtonSteps),
];

const STATUS: &str = "/solve/status";
const MULTIPLIER_NORMAL: &str = "/solve/multiplier_normal";
const MULTIPLIER_TANGENTIAL: &str = "/solve/multiplier_tangential";
const DISPLACEMENT: &str = "/solve/displacement";
const SLIP: &str = "/solve/slip";
const SLIP_BOUND: &str = "/solve/slip_bound";
const FRICTION: &str = "/solve/friction";
const FRICTION_INVERSE: &str = "/solve/friction_inverse";
const STEPLENGTH: &str = "/solve/steplength";
const ACTIONS: &str = "/solve/actions";
const METHOD: &str = "/solve/method";
const ACCURACY: &str = "/solve/accuracy";
const MAPPING_CHANGE: &str = "/solve/mapping_change";
const NEWTON_RESIDUAL: &str = "/solve/newton/residual";
const NEWTON_STEP_LENGTH: &str = "/solve/newton/step_length";
const NEWTON_HALVINGS: &str = "/solve/newton/halvings";
const NEWTON_ZONE_CHANGES: &str = "/solve/newton/zone_changes";
const NEWTON_UNKNOWNS: &str = "/solve/newton/free_unknowns";
const NEWTON_FALLBACK: &str = "/solve/newton/fallback";
const NEWTON_SECONDS: &str = "/solve/newton/seconds";
const CHANGE: &str = "/solve/history/change";
const INNER_TOLERANCE: &str = "/solve/history/inner_tolerance";
const INNER_RESIDUAL: &str = "/solve/history/inner_residual";
const CG_STEPS: &str = "/solve/history/conjugate_gradient_steps";
const EXPANSION_STEPS: &str = "/solve/history/expansion_steps";
const PROPORTIONING_STEPS: &str = "/solve/history/proportioning_steps";
const STEP_ACTIONS: &str = "/solve/history/actions";
const SECONDS: &str = "/solve/history/seconds";

const PANES: &[Extent] = &[Named("n_panes")];
const PANE_PAIRS: &[Extent] = &[Named("n_panes"), Fixed(2)];
const STEPS: &[Extent] = &[Named("n_outer_steps")];
const NEWTON: &[Extent] = &[Named("n_newton_steps")];

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    Stage::Solve.row(STATUS, Kind::Enum(StoredStatus::SPEC), &[], "1", "How the solve ended; anything but converged is a failed solve."),
    Stage::Solve.row(MULTIPLIER_NORMAL, Kind::F64, PANES, "Pa", "Normal contact multiplier, the pressure on each pane.").symbol("lambda_nu"),
    Stage::Solve.row(MULTIPLIER_TANGENTIAL, Kind::F64, PANE_PAIRS, "Pa", "Tangential contact multipliers along t1 and t2.").symbol("lambda_t"),
    Stage::Solve.row(DISPLACEMENT, Kind::F64, &[Named("n_nodes"), Fixed(3)], "m", "Displacement of every node, zero where held.").symbol("u"),
    Stage::Solve.row(SLIP, Kind::F64, &[Named("n_contact_nodes"), Fixed(2)], "m", "Absolute tangential displacements |u_t1|, |u_t2| of the contact nodes.").symbol("phi"),
    Stage::Solve.row(SLIP_BOUND, Kind::F64, PANES, "Pa", "Slip bound of the last inner problem.").symbol("g"),
    Stage::Solve.row(FRICTION, Kind::F64, &[Named("n_contact_nodes"), Fixed(2)], "1", "Coefficients at the contact nodes in the last inner problem.").symbol("F_1, F_2"),
    Stage::Solve.row(FRICTION_INVERSE, Kind::F64, PANE_PAIRS, "1", "Diagonal of the inverse friction matrix averaged over each pane, in the last inner problem.").symbol("Fbar^-1"),
    Stage::Solve.row(STEPLENGTH, Kind::F64, &[], "Pa/m^3", "Steplength of projected gradient steps, 1.9 over the norm of the dual operator.").symbol("alpha"),
    Stage::Solve.row(ACTIONS, Kind::I64, &[], "1", "Actions of the inverse stiffness matrix in the whole solve.").symbol("n_A"),
    Stage::Solve.row(METHOD, Kind::Enum(StoredMethod::SPEC), &[], "1", "Algorithm that gave the answer; after a failed Newton solve it is fixed_point and both histories are there."),
    Stage::Solve.row(ACCURACY, Kind::F64, &[], "1", "Last relative change of successive approximations, or last relative residual of Newton's method."),
    Stage::Solve.row(MAPPING_CHANGE, Kind::F64, &[], "1", "|Psi(lambda) - lambda| / |lambda| for one evaluation of the paper's mapping.").optional("absent unless Newton's method gave the answer"),
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

/// Writes the solution.
///
/// # Errors
/// HDF5 failures.
pub fn write(
    writer: &mut StageWriter<'_>,
    solution: &Solution,
    dofs: &DofMap,
) -> Result<(), StoreError> {
    let m = solution.slip_bound.len();
    let status = STATUSES
        .iter()
        .find(|(_, status)| *status == solution.status);
    let status = status.map_or(StoredStatus::NumericalError, |(stored, _)| *stored);
    writer.write_enum(STATUS, &[status], &[])?;
    writer.write(MULTIPLIER_NORMAL, &solution.multiplier[..m], &[m])?;
    writer.write(MULTIPLIER_TANGENTIAL, &solution.multiplier[m..], &[m, 2])?;
    let displacement = dofs.to_nodes(&solution.displacement);
    writer.write(
        DISPLACEMENT,
        displacement.as_flattened(),
        &[displacement.len(), 3],
    )?;
    writer.write(
        SLIP,
        solution.slip.as_flattened(),
        &[solution.slip.len(), 2],
    )?;
    writer.write(SLIP_BOUND, &solution.slip_bound, &[m])?;
    let friction = &solution.friction;
    writer.write(
        FRICTION,
        friction.nodal.as_flattened(),
        &[friction.nodal.len(), 2],
    )?;
    writer.write(
        FRICTION_INVERSE,
        friction.pane_inverse.as_flattened(),
        &[m, 2],
    )?;
    writer.write(STEPLENGTH, &[solution.steplength], &[])?;
    writer.write_indices(ACTIONS, &[solution.actions], &[])?;
    let method = match solution.solved_by {
        SolvedBy::FixedPoint => StoredMethod::FixedPoint,
        SolvedBy::Newton => StoredMethod::Newton,
    };
    writer.write_enum(METHOD, &[method], &[])?;
    writer.write(ACCURACY, &[solution.accuracy], &[])?;
    if let Some(change) = solution.mapping_change {
        writer.write(MAPPING_CHANGE, &[change], &[])?;
    }
    write_newton(writer, &solution.newton)?;
    write_history(writer, &solution.history)
}

fn write_newton(writer: &mut StageWriter<'_>, steps: &[NewtonStep]) -> Result<(), StoreError> {
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

fn write_history(writer: &mut StageWriter<'_>, history: &[OuterStep]) -> Result<(), StoreError> {
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

/// Reads the solution.
///
/// # Errors
/// Missing, altered or contradictory datasets.
pub fn read(reader: &Reader, dofs: &DofMap) -> Result<Solution, FormatError> {
    let mut multiplier = reader.read_vec(MULTIPLIER_NORMAL)?;
    multiplier.extend(reader.read_vec::<f64>(MULTIPLIER_TANGENTIAL)?);
    let displacement: Vec<f64> = reader.read_vec(DISPLACEMENT)?;
    let stored = reader.read_enum::<StoredStatus>(STATUS)?;
    let status = STATUSES
        .iter()
        .find(|(status, _)| stored.first() == Some(status));
    Ok(Solution {
        status: status.map_or(Status::NumericalError, |(_, status)| *status),
        multiplier,
        displacement: dofs.to_free(displacement.as_chunks::<3>().0),
        slip: read_finite_rows(reader, SLIP)?,
        slip_bound: read_finite_vec(reader, SLIP_BOUND)?,
        friction: FrictionField {
            nodal: read_finite_rows(reader, FRICTION)?,
            pane_inverse: read_finite_rows(reader, FRICTION_INVERSE)?,
        },
        steplength: read_finite_scalar(reader, STEPLENGTH)?,
        solved_by: match reader.read_enum::<StoredMethod>(METHOD)?.first() {
            Some(StoredMethod::Newton) => SolvedBy::Newton,
            _ => SolvedBy::FixedPoint,
        },
        accuracy: reader
            .read_vec(ACCURACY)?
            .first()
            .copied()
            .unwrap_or(f64::NAN),
        mapping_change: match reader.has(MAPPING_CHANGE) {
            true => reader.read_vec(MAPPING_CHANGE)?.first().copied(),
            false => None,
        },
        history: read_history(reader)?,
        newton: read_newton(reader)?,
        actions: read_index_vec(reader, ACTIONS)?
            .first()
            .copied()
            .unwrap_or(0),
    })
}

fn read_newton(reader: &Reader) -> Result<Vec<NewtonStep>, FormatError> {
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

fn read_history(reader: &Reader) -> Result<Vec<OuterStep>, FormatError> {
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
