//! `/solve`: multipliers, displacement, state of friction, history.

use super::{
    FormatError, history, read_finite_rows, read_finite_scalar, read_finite_vec, read_index_vec,
};
use crate::{
    contact::FrictionField,
    elasticity::DofMap,
    solver::{Solution, SolvedBy, Status},
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

const PANES: &[Extent] = &[Named("n_panes")];
const PANE_PAIRS: &[Extent] = &[Named("n_panes"), Fixed(2)];

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
    history::write_newton(writer, &solution.newton)?;
    history::write_outer(writer, &solution.history)
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
        history: history::read_outer(reader)?,
        newton: history::read_newton(reader)?,
        actions: read_index_vec(reader, ACTIONS)?
            .first()
            .copied()
            .unwrap_or(0),
    })
}
