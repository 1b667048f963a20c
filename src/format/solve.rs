//! `/solve`: multipliers, displacement, state of friction, history.

use contact3d::{
    contact::FrictionField,
    elasticity::DofMap,
    solver::{CoulombState, LocalMapping, Solution, Status},
};
use runfile::{
    DatasetSpec, Extent, Extent::Named, Group, GroupWriter, Kind, Reader, StoreError, StoredEnum,
};
use units::Dimension;

use super::{
    FormatError, Stage,
    assemble::RIGID,
    axes,
    enumeration::read_member,
    history,
    outcome::{StoredMethod, StoredStatus},
    read_finite_vec, read_index_vec,
};

/// Multipliers, displacement and history.
pub(super) const GROUP: Group = Group::new("solve", Stage::Solve.command());

pub(super) const STATUS: &str = "/solve/status";
const MULTIPLIER_NORMAL: &str = "/solve/multiplier_normal";
const MULTIPLIER_TANGENTIAL: &str = "/solve/multiplier_tangential";
const DISPLACEMENT: &str = "/solve/displacement";
const STRAINING: &str = "/solve/straining_displacement";
const RIGID_MOTION: &str = "/solve/rigid_motion";
const UNSTOPPED_MOTION: &str = "/solve/unstopped_motion";
const NEUTRAL_MOTIONS: &str = "/solve/neutral_motions";
const SLIP: &str = "/solve/slip";
const SLIP_BOUND: &str = "/solve/slip_bound";
const FRICTION: &str = "/solve/friction";
const FRICTION_INVERSE: &str = "/solve/friction_inverse";
const STEPLENGTH: &str = "/solve/steplength";
const LOCAL_STIFFNESS_NORMAL: &str = "/solve/local_stiffness_normal";
const LOCAL_STIFFNESS_TANGENTIAL: &str = "/solve/local_stiffness_tangential";
pub(super) const APPLICATIONS: &str = "/solve/actions";
pub(super) const METHOD: &str = "/solve/method";
pub(super) const ACCURACY: &str = "/solve/accuracy";
const MAPPING_CHANGE: &str = "/solve/mapping_change";
const SPECTRAL_RADIUS: &str = "/solve/spectral_radius";
const DETERMINANT: &str = "/solve/determinant_sign";
const FOLD_DISTANCE: &str = "/solve/fold_distance";
const LAW_EVALUATIONS: &str = "/solve/law_evaluations";
const PROJECTIONS: &str = "/solve/projections";
pub(super) const HISTORY_DIGEST: &str = "/solve/history_digest";

const NO_CONTACT: &str = "absent without contact";
const NO_COULOMB: &str = "absent without Coulomb friction";

const NO_LINEARISATION: &str = "absent unless a solution with Coulomb friction was found with the dense operator, and before format 1.7";

const PANES: &[Extent] = &[Named("n_panes")];
const PANE_PAIRS: &[Extent] = &[Named("n_friction_panes"), axes::FRICTION_AXES];

#[rustfmt::skip]
pub(super) const TABLE: &[DatasetSpec] = &[
    GROUP.row(STATUS, Kind::Enum(StoredStatus::SPEC), &[], Dimension::Number, "How the solve ended: converged to epsilon; rounding_limit and stopped (by the rule of its method) near the solution, as far as accuracy says; anything else is a failed solve."),
    GROUP.row(MULTIPLIER_NORMAL, Kind::F64, PANES, Dimension::STRESS, "Normal contact multiplier, the pressure on each pane.").symbol("lambda_nu").optional(NO_CONTACT),
    GROUP.row(MULTIPLIER_TANGENTIAL, Kind::F64, PANE_PAIRS, Dimension::STRESS, "Tangential contact multipliers along t1 and t2.").symbol("lambda_t").optional("absent without friction"),
    GROUP.row(DISPLACEMENT, Kind::F64, &[Named("n_nodes"), axes::XYZ], Dimension::LENGTH, "Displacement of every node, that of its clamp where held.").symbol("u"),
    GROUP.row(STRAINING, Kind::F64, &[Named("n_nodes"), axes::XYZ], Dimension::LENGTH, "The displacement without the rigid motions that weak springs let go far: what strains the body, which rounding of a long way would hide.").optional("absent where no weak spring holds the body, and before format 1.8"),
    GROUP.row(RIGID_MOTION, Kind::F64, &[RIGID], Dimension::LENGTH, "Rigid motions of a body that only contact or weak springs hold: the part R alpha of the displacement beside that of a body whose pins rest; zero without equilibrium.").symbol("alpha").optional("absent where supports hold the body"),
    GROUP.row(UNSTOPPED_MOTION, Kind::F64, &[Named("n_nodes"), axes::XYZ], Dimension::Number, "Rigid motion in which the load works and which no admissible contact force opposes, of largest component one.").symbol("q").optional("absent unless there is no equilibrium"),
    GROUP.row(NEUTRAL_MOTIONS, Kind::F64, &[Named("n_neutral_motions"), Named("n_nodes"), axes::XYZ], Dimension::Number, "Rigid motions that neither contact nor supports feel, each of largest component one; the displacement has none of them.").optional("absent where every rigid motion is felt, and before format 1.8"),
    GROUP.row(SLIP, Kind::F64, &[Named("n_contact_nodes"), axes::FRICTION_AXES], Dimension::LENGTH, "Slips that the friction follows at the contact nodes: |u_t1| and |u_t2|, or their means around each node with contact.slip_interpolation = clement.").symbol("phi").optional("absent unless friction follows the slip"),
    GROUP.row(SLIP_BOUND, Kind::F64, &[Named("n_friction_panes")], Dimension::STRESS, "Slip bound of the last inner problem.").symbol("g").optional(NO_COULOMB),
    GROUP.row(FRICTION, Kind::F64, &[Named("n_friction_nodes"), axes::FRICTION_AXES], Dimension::Number, "Coefficients at the contact nodes in the last inner problem.").symbol("F_1, F_2").optional(NO_COULOMB),
    GROUP.row(FRICTION_INVERSE, Kind::F64, PANE_PAIRS, Dimension::Number, "Diagonal of the inverse friction matrix averaged over each pane, in the last inner problem.").symbol("Fbar^-1").optional(NO_COULOMB),
    GROUP.row(STEPLENGTH, Kind::F64, &[], Dimension::PER_DUAL, "Steplength of projected gradient steps, 1.9 over the norm of the dual operator.").symbol("alpha").optional(NO_CONTACT),
    GROUP.row(LOCAL_STIFFNESS_NORMAL, Kind::F64, PANES, Dimension::PER_DUAL, "Stiffness of each pane along the normal while the others do not move, that residuals are measured by.").symbol("rho_nu").optional("absent without contact, and before format 1.4"),
    GROUP.row(LOCAL_STIFFNESS_TANGENTIAL, Kind::F64, PANE_PAIRS, Dimension::PER_DUAL, "The same along t1 and t2: one for both where both can move.").symbol("rho_t").optional("absent without friction, and before format 1.4"),
    GROUP.row(APPLICATIONS, Kind::I64, &[], Dimension::Number, "Applications of the inverse stiffness matrix in the whole solve.").symbol("n_A"),
    GROUP.row(METHOD, Kind::Enum(StoredMethod::SPEC), &[], Dimension::Number, "Algorithm that gave the answer: minimisation without friction or with a given slip bound, direct without contact; after a failed Newton solve it is fixed_point and both histories are there."),
    GROUP.row(ACCURACY, Kind::F64, &[], Dimension::Number, "Relative error of the multipliers, measured by one more solution from them with exact residuals; the last relative change of successive approximations that did not end."),
    GROUP.row(MAPPING_CHANGE, Kind::F64, &[], Dimension::Number, "|Psi(lambda) - lambda| / |lambda| for one evaluation of the paper's mapping.").optional("absent unless Newton's method gave the answer"),
    GROUP.row(SPECTRAL_RADIUS, Kind::F64, &[], Dimension::Number, "Spectral radius of the derivative of the mapping Psi at the solution: successive approximations converge to it from nearby where it is below 1.").symbol("rho(Psi')").optional(NO_LINEARISATION),
    GROUP.row(DETERMINANT, Kind::I64, &[], Dimension::Number, "Sign of the determinant of Newton's matrix at the solution; the signs of all solutions add up to 1, so where it is -1 there are others.").symbol("sign det R'").optional(NO_LINEARISATION),
    GROUP.row(FOLD_DISTANCE, Kind::F64, &[], Dimension::Number, "Least |1 - mu| over the eigenvalues mu of the derivative of Psi at the solution: 0 where Newton's matrix is singular, as in a fold where two solutions meet.").symbol("min |1 - mu|").optional(NO_LINEARISATION),
    GROUP.row(LAW_EVALUATIONS, Kind::I64, &[], Dimension::Number, "Evaluations of the friction law at a node."),
    GROUP.row(PROJECTIONS, Kind::I64, &[], Dimension::Number, "Projections on an ellipse."),
    GROUP.row(HISTORY_DIGEST, Kind::Text, &[], Dimension::Number, "Digest of /history, whose last increment this is.").optional("absent without a load history"),
];

/// Writes the solution; that of a load history belongs to a `/history` with some digest.
///
/// # Errors
/// HDF5 failures.
pub fn write(
    writer: &mut GroupWriter<'_>,
    solution: &Solution,
    n_panes: usize,
    dofs: &DofMap,
    history_digest: Option<&str>,
) -> Result<(), StoreError> {
    if let Some(digest) = history_digest {
        writer.write_text(HISTORY_DIGEST, digest)?;
    }
    writer.write_enum(STATUS, &[StoredStatus::from(solution.status)], &[])?;
    if n_panes > 0 {
        let (normal, tangential) = solution.multiplier.split_at(n_panes);
        writer.write(MULTIPLIER_NORMAL, normal, &[n_panes])?;
        if !tangential.is_empty() {
            writer.write(
                MULTIPLIER_TANGENTIAL,
                tangential,
                &[tangential.len() / 2, 2],
            )?;
        }
        writer.write(STEPLENGTH, &[solution.steplength], &[])?;
        if let Some((normal, tangential)) = solution.local_stiffness.split_at_checked(n_panes) {
            writer.write(LOCAL_STIFFNESS_NORMAL, normal, &[n_panes])?;
            if !tangential.is_empty() {
                let shape = [tangential.len() / 2, 2];
                writer.write(LOCAL_STIFFNESS_TANGENTIAL, tangential, &shape)?;
            }
        }
    }
    let displacement = dofs.to_nodes(&solution.displacement);
    writer.write(
        DISPLACEMENT,
        displacement.as_flattened(),
        &[displacement.len(), 3],
    )?;
    if !solution.straining.is_empty() {
        let straining = dofs.to_nodes(&solution.straining);
        writer.write(STRAINING, straining.as_flattened(), &[straining.len(), 3])?;
    }
    if !solution.rigid_motion.is_empty() {
        let motion = &solution.rigid_motion;
        writer.write(RIGID_MOTION, motion, &[motion.len()])?;
    }
    if let Some(motion) = &solution.unstopped_motion {
        writer.write(UNSTOPPED_MOTION, motion.as_flattened(), &[motion.len(), 3])?;
    }
    if !solution.neutral_motions.is_empty() {
        let shape = [solution.neutral_motions.len(), displacement.len(), 3];
        let motions = solution.neutral_motions.concat();
        writer.write(NEUTRAL_MOTIONS, motions.as_flattened(), &shape)?;
    }
    if let Some(slip) = &solution.slip {
        writer.write(SLIP, slip.as_flattened(), &[slip.len(), 2])?;
    }
    if let Some(state) = &solution.coulomb {
        write_coulomb(writer, state)?;
    }
    writer.write_indices(APPLICATIONS, &[solution.applications], &[])?;
    writer.write_enum(METHOD, &[StoredMethod::from(solution.solved_by)], &[])?;
    writer.write(ACCURACY, &[solution.accuracy], &[])?;
    if let Some(change) = solution.mapping_change {
        writer.write(MAPPING_CHANGE, &[change], &[])?;
    }
    if let Some(local) = &solution.local_mapping {
        writer.write(SPECTRAL_RADIUS, &[local.spectral_radius], &[])?;
        writer.write(DETERMINANT, &[i64::from(local.determinant)], &[])?;
        writer.write(FOLD_DISTANCE, &[local.fold_distance], &[])?;
    }
    writer.write_indices(LAW_EVALUATIONS, &[solution.law_evaluations], &[])?;
    writer.write_indices(PROJECTIONS, &[solution.projections], &[])?;
    history::write_newton(writer, &solution.newton)?;
    history::write_outer(writer, &history::HISTORY, &solution.history)
}

fn write_coulomb(writer: &mut GroupWriter<'_>, state: &CoulombState) -> Result<(), StoreError> {
    let friction = &state.friction;
    writer.write(SLIP_BOUND, &state.slip_bound, &[state.slip_bound.len()])?;
    writer.write(
        FRICTION,
        friction.nodal.as_flattened(),
        &[friction.nodal.len(), 2],
    )?;
    writer.write(
        FRICTION_INVERSE,
        friction.pane_inverse.as_flattened(),
        &[friction.pane_inverse.len(), 2],
    )
}

/// Reads the solution.
///
/// # Errors
/// Missing, altered or contradictory datasets.
pub fn read(reader: &Reader, dofs: &DofMap) -> Result<Solution, FormatError> {
    let (status, multiplier) = read_multiplier(reader)?;
    let displacement = read_measured(reader, DISPLACEMENT, status)?;
    let count = |path| -> Result<usize, FormatError> {
        Ok(read_index_vec(reader, path)?.first().copied().unwrap_or(0))
    };
    Ok(Solution {
        status,
        solved_by: read_member::<StoredMethod>(reader, METHOD)?.into(),
        accuracy: read_measured(reader, ACCURACY, status)?
            .first()
            .copied()
            .unwrap_or(f64::NAN),
        mapping_change: match reader.has(MAPPING_CHANGE) {
            true => reader.read_vec(MAPPING_CHANGE)?.first().copied(),
            false => None,
        },
        local_mapping: read_local_mapping(reader)?,
        multiplier,
        straining: match reader.has(STRAINING) {
            true => {
                let nodal = read_measured(reader, STRAINING, status)?;
                dofs.to_free(nodal.as_chunks::<3>().0)
            }
            false => Vec::new(),
        },
        rigid_motion: match reader.has(RIGID_MOTION) {
            true => read_measured(reader, RIGID_MOTION, status)?,
            false => Vec::new(),
        },
        unstopped_motion: match reader.has(UNSTOPPED_MOTION) {
            true => {
                let nodal = read_finite_vec(reader, UNSTOPPED_MOTION)?;
                Some(nodal.as_chunks::<3>().0.to_vec())
            }
            false => None,
        },
        neutral_motions: match reader.has(NEUTRAL_MOTIONS) {
            true => {
                let nodal = read_finite_vec(reader, NEUTRAL_MOTIONS)?;
                let motions = nodal.as_chunks::<3>().0.chunks_exact(dofs.dof.len().max(1));
                motions.map(<[_]>::to_vec).collect()
            }
            false => Vec::new(),
        },
        displacement: dofs.to_free(displacement.as_chunks::<3>().0),
        slip: match reader.has(SLIP) {
            true => Some(read_measured_rows(reader, SLIP, status)?),
            false => None,
        },
        coulomb: match reader.has(SLIP_BOUND) {
            true => Some(read_coulomb(reader, status)?),
            false => None,
        },
        steplength: match reader.has(STEPLENGTH) {
            true => read_measured(reader, STEPLENGTH, status)?
                .first()
                .copied()
                .unwrap_or(f64::NAN),
            false => 0.0,
        },
        local_stiffness: read_local_stiffness(reader)?,
        history: history::read_outer(reader, &history::HISTORY)?,
        newton: history::read_newton(reader)?,
        applications: count(APPLICATIONS)?,
        law_evaluations: count(LAW_EVALUATIONS)?,
        projections: count(PROJECTIONS)?,
    })
}

fn read_local_mapping(reader: &Reader) -> Result<Option<LocalMapping>, FormatError> {
    if !reader.has(SPECTRAL_RADIUS) {
        return Ok(None);
    }
    let radius: Option<f64> = reader.read_vec(SPECTRAL_RADIUS)?.first().copied();
    let sign: Option<i64> = reader.read_vec(DETERMINANT)?.first().copied();
    let distance: Option<f64> = match reader.has(FOLD_DISTANCE) {
        true => reader.read_vec(FOLD_DISTANCE)?.first().copied(),
        false => None,
    };
    Ok(Some(LocalMapping {
        spectral_radius: radius.unwrap_or(f64::NAN),
        determinant: sign.map_or(0, |sign| sign.signum() as i8),
        fold_distance: distance.unwrap_or(f64::NAN),
    }))
}

/// The stiffness of each pane; empty where a file has none.
fn read_local_stiffness(reader: &Reader) -> Result<Vec<f64>, FormatError> {
    let mut stiffness = Vec::new();
    for path in [LOCAL_STIFFNESS_NORMAL, LOCAL_STIFFNESS_TANGENTIAL] {
        if reader.has(path) {
            stiffness.extend(read_finite_vec(reader, path)?);
        }
    }
    Ok(stiffness)
}

/// Reads the multipliers alone, and how the solve ended.
///
/// # Errors
/// Missing or altered datasets.
pub fn read_multiplier(reader: &Reader) -> Result<(Status, Vec<f64>), FormatError> {
    let status = read_member::<StoredStatus>(reader, STATUS)?.into();
    let mut multiplier = Vec::new();
    for path in [MULTIPLIER_NORMAL, MULTIPLIER_TANGENTIAL] {
        if reader.has(path) {
            multiplier.extend(read_measured(reader, path, status)?);
        }
    }
    Ok((status, multiplier))
}

/// Reads what a solve found: finite numbers, unless it ended for want of them.
fn read_measured(reader: &Reader, path: &str, status: Status) -> Result<Vec<f64>, FormatError> {
    Ok(match status {
        Status::NumericalError => reader.read_vec(path)?,
        Status::Converged
        | Status::MaxOuterSteps
        | Status::MaxInnerApplications
        | Status::RoundingLimit
        | Status::MaxNewtonSteps
        | Status::Cycling
        | Status::Stopped
        | Status::Inaccurate
        | Status::NoEquilibrium => read_finite_vec(reader, path)?,
    })
}

/// As [`read_measured`], a dataset of shape `[n, 2]`.
fn read_measured_rows(
    reader: &Reader,
    path: &str,
    status: Status,
) -> Result<Vec<[f64; 2]>, FormatError> {
    let flat = read_measured(reader, path, status)?;
    Ok(flat.as_chunks::<2>().0.to_vec())
}

fn read_coulomb(reader: &Reader, status: Status) -> Result<CoulombState, FormatError> {
    Ok(CoulombState {
        slip_bound: read_measured(reader, SLIP_BOUND, status)?,
        friction: FrictionField {
            nodal: read_measured_rows(reader, FRICTION, status)?,
            pane_inverse: read_measured_rows(reader, FRICTION_INVERSE, status)?,
        },
    })
}
