//! Whether any contact forces hold a body that floats.
//!
//! Forces that the laws of the contact face admit, λ ∈ K, can balance the load, Gᵀλ = e, unless a rigid motion q does work
//! against nothing: e·q > σ_K(G q), where the support function σ_K(w) = sup over λ ∈ K of λ·w is what contact can oppose
//! (separation of a convex set and a point; R. T. Rockafellar, *Convex Analysis*, Princeton 1970, theorem 13.1). On a pane with mean
//! displacements w:
//!
//! * without friction λ_ν ≥ 0, so σ = 0 where w_ν ≤ 0, else ∞;
//! * with Coulomb's law σ = 0 where w_ν + ‖F w_t‖ ≤ 0, else ∞: a cone of second order;
//! * with Tresca's law σ = |Rⁱ| ‖(a w_t1, b w_t2)‖ where w_ν ≤ 0, else ∞.
//!
//! Motions that supports resist, however weakly, need no contact force.
//!
//! Such a q is a proof. Clamps may press a face as hard as they like in this, but not in the elastic body: where that settles the pressure, friction
//! has a limit ([`friction_limit`]). That admissible forces exist is necessary for an equilibrium of a body that deforms and slides, but
//! decides nothing by itself: then the solver has the word. Coefficients that follow the slip count with the largest value that
//! they have anywhere, and a capped law as both Coulomb's and Tresca's, so that a proof is a proof for them, too.

mod friction_limit;
mod motion_program;

use motion_program::{MotionProgram, PaneTerm};

use nalgebra::{DMatrix, DVector};

use super::PaneLaws;
use crate::{
    contact::{CoulombLaw, FrictionField, InterfaceFriction, LawBounds},
    dual::{Assembly, Balance, ExplicitDual},
    elasticity::DofMap,
    linalg::{add_scaled, dot},
    mesh::extents,
};

/// Work of the load in a motion, as a share of the work that it would do if every node's force were along the node's displacement, from
/// which it counts: rounding of coordinates and sums, with room.
const FELT_WORK: f64 = 1e-10;

/// A rigid motion that nothing stops, of largest component one, `[n_nodes]`.
pub(super) fn unstopped_motion(
    assembly: &Assembly,
    balance: &Balance,
    laws: &PaneLaws,
) -> Option<Vec<[f64; 3]>> {
    let (dofs, load) = (&assembly.primal.dofs, &assembly.primal.load);
    if let Some(u) = driven(&balance.coupling.neutral_motions(), load)
        && is_driven(dofs, &u, load)
    {
        return Some(in_space(dofs, &u));
    }
    let motion = laws_to_test(laws).into_iter().find_map(|terms| {
        let program = MotionProgram::new(balance, &laws.area, laws.layout, terms);
        program?.unopposed()
    })?;
    let mut displacement = vec![0.0; load.len()];
    balance.coupling.add_motion(&motion, &mut displacement);
    is_driven(dofs, &displacement, load).then(|| in_space(dofs, &displacement))
}

/// A rigid motion of largest component one, `[n_nodes]`, that drags the body along its foundation whatever friction does.
pub(super) fn dragged_motion(
    assembly: &Assembly,
    dual: &ExplicitDual,
    laws: &PaneLaws,
) -> Option<Vec<[f64; 3]>> {
    let (balance, law) = (dual.balance.as_ref()?, laws.coulomb()?);
    let is_given = |pane| law.slip_bound(pane, 0.0) > 0.0;
    if (0..laws.layout.n_pairs()).any(is_given) {
        return None;
    }
    let coefficients = strongest_friction(law, laws);
    let motion = friction_limit::beyond_friction(dual, balance, &laws.area, &coefficients)?;
    let (dofs, load) = (&assembly.primal.dofs, &assembly.primal.load);
    let mut displacement = vec![0.0; load.len()];
    balance.coupling.add_rigid(&motion, &mut displacement);
    is_driven(dofs, &displacement, load).then(|| in_space(dofs, &displacement))
}

/// Whether a load works in a motion by more than rounding: without it no motion proves anything.
fn is_driven(dofs: &DofMap, motion: &[f64], load: &[f64]) -> bool {
    dot(motion, load) > FELT_WORK * dofs.largest_work(motion, load)
}

/// The motions that neither contact nor supports feel, each of largest component one, `[n_neutral][n_nodes]`.
pub(super) fn neutral_motions(assembly: &Assembly, balance: &Balance) -> Vec<Vec<[f64; 3]>> {
    let motions = balance.coupling.neutral_motions();
    let dofs = &assembly.primal.dofs;
    motions.iter().map(|u| in_space(dofs, u)).collect()
}

/// A motion of the free degrees of freedom at all nodes, of largest component one.
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

/// What each pane opposes, for laws whose admissible sets contain that of the scene.
fn laws_to_test(laws: &PaneLaws) -> Vec<Vec<PaneTerm>> {
    let mut tests: Vec<Vec<PaneTerm>> = match &laws.friction {
        InterfaceFriction::Frictionless => vec![Vec::new()],
        InterfaceFriction::Tresca(semi_axes) => {
            vec![
                semi_axes
                    .iter()
                    .map(|axes| PaneTerm::Bounded(*axes))
                    .collect(),
            ]
        }
        InterfaceFriction::Coulomb(law) => {
            let coefficients = strongest_friction(law, laws);
            let bound = |pane: usize, pressure: f64| law.slip_bound(pane, pressure);
            let is_given = |pane: usize| bound(pane, 0.0) == bound(pane, f64::INFINITY);
            let is_capped = |pane: usize| bound(pane, f64::INFINITY).is_finite();
            let bounded = |pane: usize, f: [f64; 2]| {
                PaneTerm::Bounded(f.map(|f| f * bound(pane, f64::INFINITY)))
            };
            let terms = |is_bounded: &dyn Fn(usize) -> bool| -> Vec<PaneTerm> {
                let panes = coefficients.iter().enumerate();
                let term = |(pane, f): (usize, &[f64; 2])| {
                    if is_bounded(pane) {
                        bounded(pane, *f)
                    } else {
                        PaneTerm::Cone(*f)
                    }
                };
                panes.map(term).collect()
            };
            let is_any_capped = (0..coefficients.len()).any(|i| is_capped(i) && !is_given(i));
            let capped = is_any_capped.then(|| terms(&is_capped));
            std::iter::once(terms(&is_given)).chain(capped).collect()
        }
    };
    for terms in &mut tests {
        terms.resize(laws.n_panes(), PaneTerm::Pressure);
    }
    tests
}

/// F₁ and F₂ on the panes with friction: those of the law, and on faces where they follow the slip the largest that they have
/// anywhere.
fn strongest_friction(law: &CoulombLaw, laws: &PaneLaws) -> Vec<[f64; 2]> {
    let field = FrictionField::new(law, &laws.average, &[]);
    let panes = field.pane_inverse.iter();
    let mut strongest: Vec<[f64; 2]> = panes.map(|inverse| inverse.map(f64::recip)).collect();
    for face in law
        .faces()
        .iter()
        .filter(|face| face.law().depends_on_slip())
    {
        // No slip of a solution is larger than the face.
        let extent = extents(face.positions()).into_iter().fold(0.0, f64::max);
        let largest = LawBounds::new(face, extent).largest.value;
        strongest[face.panes()].fill([largest; 2]);
    }
    strongest
}
