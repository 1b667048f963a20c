//! Whether any contact forces hold a body that floats, before a solver looks for them.
//!
//! [`contact_cone`] has the mathematics: a body is a mechanism if the load does more work in a rigid motion than contact can oppose. There clamps
//! may press a face as hard as they like; in the elastic body supports and load may settle the pressure, and then friction has a limit
//! ([`friction_limit`]). Coefficients that follow the slip count with the largest value that they have anywhere, and a capped law both as
//! Coulomb's and as Tresca's, so that a proof is a proof for them, too.

mod contact_cone;
mod friction_limit;

use contact_cone::{ContactCone, FrictionResistance, PROOF_MARGIN};

use nalgebra::{DMatrix, DVector};

use super::PaneLaws;
use crate::{
    contact::{CoulombLaw, FrictionField, InterfaceFriction, LawBounds},
    dual::{Assembly, ExplicitDual, RigidEquilibrium},
    elasticity::DofMap,
    linalg::{add_scaled, dot},
    mesh::extents,
};

/// A rigid motion of largest component one, `[n_rows]`, that proves a body a mechanism: the load does more work in it than contact can oppose.
pub(super) fn mechanism(
    assembly: &Assembly,
    equilibrium: &RigidEquilibrium,
    laws: &PaneLaws,
) -> Option<Vec<[f64; 3]>> {
    let (dofs, load) = (&assembly.primal.dofs, &assembly.primal.load);
    let free = driven(&equilibrium.coupling.null_space_motions(), load);
    if let Some(proof) = free.and_then(|u| proof(dofs, &u, load)) {
        return Some(proof);
    }
    let motion = laws_to_test(laws).iter().find_map(|friction| {
        ContactCone::new(equilibrium, &laws.area, laws.layout, friction)?.mechanism()
    })?;
    let mut displacement = vec![0.0; load.len()];
    equilibrium.coupling.add_motion(&motion, &mut displacement);
    proof(dofs, &displacement, load)
}

/// A rigid motion of largest component one, `[n_rows]`, in which the load drags the body along its foundation whatever friction does.
pub(super) fn sliding_mechanism(
    assembly: &Assembly,
    dual: &ExplicitDual,
    laws: &PaneLaws,
) -> Option<Vec<[f64; 3]>> {
    let (equilibrium, law) = (dual.rigid.as_ref()?, laws.coulomb()?);
    let is_given = |pane| law.slip_bound(pane, 0.0) > 0.0;
    if (0..laws.layout.n_pairs()).any(is_given) {
        return None;
    }
    let coefficients = strongest_friction(law, laws);
    let motion = friction_limit::beyond_friction(dual, equilibrium, &laws.area, &coefficients)?;
    let (dofs, load) = (&assembly.primal.dofs, &assembly.primal.load);
    let mut displacement = vec![0.0; load.len()];
    equilibrium.coupling.add_rigid(&motion, &mut displacement);
    proof(dofs, &displacement, load)
}

/// A motion at all rows, of largest component one, in which a load works by more than rounding: without that it proves nothing.
fn proof(dofs: &DofMap, motion: &[f64], load: &[f64]) -> Option<Vec<[f64; 3]>> {
    let work = dot(motion, load);
    (work > PROOF_MARGIN * dofs.largest_work(motion, load)).then(|| in_space(dofs, motion))
}

/// The motions that neither contact nor supports resist, each of largest component one, `[n_null][n_rows]`.
pub(super) fn null_space_motions(
    assembly: &Assembly,
    equilibrium: &RigidEquilibrium,
) -> Vec<Vec<[f64; 3]>> {
    let motions = equilibrium.coupling.null_space_motions();
    let dofs = &assembly.primal.dofs;
    motions.iter().map(|u| in_space(dofs, u)).collect()
}

/// A motion of the free degrees of freedom at all rows, of largest component one.
fn in_space(dofs: &DofMap, motion: &[f64]) -> Vec<[f64; 3]> {
    let largest = motion.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let nodes = 0..dofs.dof.len();
    nodes
        .map(|node| dofs.change_at_node(node, motion).map(|v| v / largest))
        .collect()
}

/// Of some motions that in which a load works most for the squared displacements of the body; `None` where there are none, or the
/// load does not work at all.
fn driven(shapes: &[Vec<f64>], load: &[f64]) -> Option<Vec<f64>> {
    let n = shapes.len();
    let work = DVector::from_fn(n, |p, _| dot(&shapes[p], load));
    if work.iter().all(|w| *w == 0.0) {
        return None;
    }
    let gram = DMatrix::from_fn(n, n, |p, q| dot(&shapes[p], &shapes[q]));
    let weights = gram.cholesky()?.solve(&work);
    let mut driven = vec![0.0; load.len()];
    for (shape, weight) in shapes.iter().zip(&weights) {
        add_scaled(&mut driven, *weight, shape);
    }
    Some(driven)
}

/// What friction can oppose on each pane, by laws that admit at least as much as the scene's: a mechanism under any one of them is one of
/// the scene. A capped law admits less than Coulomb's and less than Tresca's, which makes two.
fn laws_to_test(laws: &PaneLaws) -> Vec<Vec<FrictionResistance>> {
    let mut tests: Vec<Vec<FrictionResistance>> = match &laws.friction {
        InterfaceFriction::Frictionless => vec![Vec::new()],
        InterfaceFriction::Tresca(semi_axes) => {
            vec![
                semi_axes
                    .iter()
                    .map(|axes| FrictionResistance::Tresca(*axes))
                    .collect(),
            ]
        }
        InterfaceFriction::Coulomb(law) => {
            let coefficients = strongest_friction(law, laws);
            let largest = |pane: usize| law.slip_bound(pane, f64::INFINITY);
            let is_given = |pane: usize| law.slip_bound(pane, 0.0) == largest(pane);
            let is_bounded = |pane: usize| largest(pane).is_finite();
            let with_bounds = |has_bound: &dyn Fn(usize) -> bool| {
                let panes = coefficients.iter().enumerate();
                let friction = |(pane, f): (usize, &[f64; 2])| match has_bound(pane) {
                    true => FrictionResistance::Tresca(f.map(|f| f * largest(pane))),
                    false => FrictionResistance::Coulomb(*f),
                };
                panes.map(friction).collect::<Vec<FrictionResistance>>()
            };
            let mut tests = vec![with_bounds(&is_given), with_bounds(&is_bounded)];
            tests.dedup();
            tests
        }
    };
    for friction in &mut tests {
        friction.resize(laws.n_panes(), FrictionResistance::None);
    }
    tests
}

/// F₁ and F₂ on the panes with friction: those of the law, and on faces where they follow the slip the largest that they have
/// anywhere.
fn strongest_friction(law: &CoulombLaw, laws: &PaneLaws) -> Vec<[f64; 2]> {
    let field = FrictionField::new(law, &laws.average, &[]);
    let panes = field.pane_inverse.iter();
    let mut strongest: Vec<[f64; 2]> = panes.map(|inverse| inverse.map(f64::recip)).collect();
    for face in law.faces().iter().filter(|face| face.law.depends_on_slip()) {
        // No slip of a solution is larger than the face.
        let extent = extents(&face.positions).into_iter().fold(0.0, f64::max);
        let largest = LawBounds::new(face, extent).largest.value;
        strongest[face.panes.clone()].fill([largest; 2]);
    }
    strongest
}
