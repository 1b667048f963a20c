//! Iterative refinement: refined residuals, and the distance to the solution.

use super::within_ellipses;
use crate::{
    dual::ExplicitDual,
    linalg::{Doubled, Precision, difference, larger},
    solver::{
        NewtonSettings, NewtonSolution, NewtonStep, StartStrategy,
        conditions::Bound,
        newton::{
            FrictionGraph, NewtonDriver, local_newton, natural_map::NaturalMap,
            proximal::about_own_motion,
        },
        problem::{ContactBody, ContactSolve},
        tolerances::{NEWTON_MAX_STEPS, REFINEMENT_TARGET, ROUNDING_STALL_STEPS},
    },
};

/// Most rounds; each wins the digits that the conditioning of A and the precision of its factor leave.
const REFINEMENT_MAX_ROUNDS: usize = 16;

/// The displacement of λ in a round is wanted to this share of the last distance, where every digit takes steps of conjugate
/// gradients: S in single precision leaves a thousandth of the distance or so, and the displacement shall not be what decides.
const DISPLACEMENT_SHARE: f64 = 1e-5;

/// λ, how far it is from the solution, and the dual problem written about it.
pub(in crate::solver) struct Refined {
    /// λ in Pa and the rigid motions, `[n_unknowns]`.
    pub(in crate::solver) unknowns: Vec<f64>,
    /// A⁻¹(l − Bᵀλ) in m, to rounding.
    pub(in crate::solver) solved: Doubled,
    /// u of λ in m.
    pub(in crate::solver) displacement: Vec<f64>,
    /// Distance to the solution, relative as in [`ContactSolve::relative`].
    pub(in crate::solver) error: f64,
    /// The problem written about λ: its unknown is the correction of λ, and its right-hand side the refined gaps of λ.
    pub(in crate::solver) dual: ExplicitDual,
    /// Steps of Newton's method that it took.
    pub(in crate::solver) history: Vec<NewtonStep>,
    /// Applications of S, and one of A⁻¹ a round.
    pub(in crate::solver) applications: usize,
}

impl Refined {
    /// Whether λ lies in the zones of a solution.
    pub(in crate::solver) fn is_solution(&self) -> bool {
        self.error <= REFINEMENT_TARGET
    }
}

impl ContactSolve<'_> {
    /// Measures how far λ is from the solution, and comes closer until that is at most `tolerance` or
    /// rounding forbids it.
    ///
    /// In each round u = A⁻¹(l − Bᵀλ) is solved in more than working precision, the dual problem
    /// is written about λ with its gradient −(B u − gap), and Newton's method, measured by
    /// local stiffness, solves that. Its solution differs from the true one by what S is wrong, as
    /// a share of the distance from λ; so that distance is the error of λ. It needs no scale, while small
    /// residuals say little for bodies that nearly float.
    pub(in crate::solver) fn refined(
        &self,
        driver: &NewtonDriver<'_>,
        strategy: StartStrategy,
        unknowns: &[f64],
        tolerance: f64,
    ) -> Refined {
        let mut target = self.target(1.0);
        let mut best = self.about(driver, unknowns, None, target);
        let (mut history, mut applications) = (Vec::new(), 1);
        let mut last = [f64::INFINITY; 2];
        // Of displacements; a stall may be theirs where the face hardly moves beside the body.
        let mut loosest = f64::INFINITY;
        for _ in 0..REFINEMENT_MAX_ROUNDS {
            // Where no step is found from a corrected λ, the error is the one measured before that correction.
            let Some((found, distance)) = self.distance_to_solution(driver, &best, strategy) else {
                break;
            };
            let [error, bound_error] = distance;
            applications += found.evaluations + 1;
            history.extend(found.history);
            best.error = error;
            let [falls, bound_falls] = [0, 1].map(|k| distance[k] <= 0.5 * last[k]);
            let accurate = error <= tolerance;
            if accurate && (bound_error <= tolerance || !bound_falls) {
                if target > f64::EPSILON {
                    // Its displacement is solved again anyway: that of the closer λ then.
                    best.unknowns = found.unknowns;
                }
                break;
            }
            if !accurate && !falls {
                if target <= f64::EPSILON {
                    // Rounding: the last two errors are of one size.
                    best.error = error.max(last[0]);
                    break;
                }
                loosest = f64::EPSILON;
            }
            let start = Some(&best.solved);
            target = self.target(error).min(loosest);
            let next = self.about(driver, &found.unknowns, start, target);
            best = Refined { error, ..next };
            last = distance;
        }
        if target > f64::EPSILON {
            let (unknowns, start) = (&best.unknowns, Some(&best.solved));
            let last = self.about(driver, unknowns, start, f64::EPSILON);
            applications += 1;
            best = Refined {
                error: best.error,
                ..last
            };
        }
        Refined {
            history,
            applications,
            ..best
        }
    }

    /// The distance of λ to the solution; infinite where Newton's method finds none from there.
    pub(in crate::solver) fn error_of(&self, driver: &NewtonDriver<'_>, unknowns: &[f64]) -> f64 {
        let found = self.about(driver, unknowns, None, f64::EPSILON);
        let found = self.distance_to_solution(driver, &found, StartStrategy::Relaxed);
        found.map_or(f64::INFINITY, |(_, [error, _])| error)
    }

    /// The solution of the dual problem about λ, and its distance: relative as in [`ContactSolve::relative`], and relative to the
    /// semi-axes of the ellipses ([`within_ellipses`]), for where one coefficient of friction is a small part of the other, ‖λ_t‖ hides
    /// what happens along its axis. `None` where Newton's method does not find it from there.
    fn distance_to_solution(
        &self,
        driver: &NewtonDriver<'_>,
        near: &Refined,
        strategy: StartStrategy,
    ) -> Option<(NewtonSolution, [f64; 2])> {
        let NewtonDriver { local, bound, .. } = *driver;
        let steplengths = local.stiffness.clone();
        // One step at least: that is what measures the error. The first two at rounding that bring nothing end it: what is left then is
        // rounding of λ itself, which the next refined residual shows.
        let settings = NewtonSettings {
            tolerance: near.dual.rounding(),
            max_steps: NEWTON_MAX_STEPS,
            ..NewtonSettings::default()
        };
        let measured = NewtonSettings {
            least_steps: 1,
            rounding_steps: ROUNDING_STALL_STEPS - 1,
            ..settings.near_solution()
        };
        let newton_about = |dual: &ExplicitDual| {
            let map = NaturalMap::with_steplengths(dual, bound, steplengths.clone());
            let start = near.unknowns.clone();
            local_newton(&map, start, &measured, |_, _| {})
        };
        let mut found = newton_about(&near.dual);
        let has_free_motion = !found.stop.is_solution() && strategy == StartStrategy::ProximalPoint;
        if has_free_motion {
            // A motion is free within an interval.
            found = newton_about(&about_own_motion(&near.dual, local));
        }
        if let (false, StartStrategy::FrictionGraph, Bound::Coulomb(laws, law)) =
            (found.stop.is_solution(), strategy, bound)
            && let Some(graph) = FrictionGraph::new(driver.dual, laws, law, local)
        {
            // Rounding of a slip may be more than a rise of F is wide, and then no step of λ alone stays on it.
            found = graph.solve_near(&near.dual, &near.unknowns);
        }
        if let (false, Bound::Given(set)) = (found.stop.is_solution(), bound) {
            // A λ that is not far off may lie in zones from which Newton's steps wander off.
            let about = NewtonDriver {
                dual: &near.dual,
                ..*driver
            };
            found = about.interior_point(set, &settings, &mut |_, _| {});
        }
        if !found.stop.is_solution() {
            return None;
        }
        let map = NaturalMap::with_steplengths(&near.dual, bound, steplengths);
        let there = map.evaluate(&found.unknowns);
        let [here, reached] = [&near.unknowns, &found.unknowns].map(|x| near.dual.stresses(x));
        let step = difference(&reached, &here);
        let rounding = self.motion_rounding(&found.unknowns, &there, &local.stiffness);
        // The term's own force vanishes round by round, and slowly where little resists the motion: steps are shorter than the distance.
        let term_force = match has_free_motion {
            true => there.relative_to(map.size(&found.unknowns)),
            false => 0.0,
        };
        let error = self.relative(&step, &reached, &there);
        let error = larger(larger(error, rounding), term_force);
        let bound_error = within_ellipses(self.laws, &there, &step);
        Some((found, [error, bound_error]))
    }

    /// How accurate a displacement shall be, as a share of it, where the next λ is at a distance.
    fn target(&self, distance: f64) -> f64 {
        match self.body.precision() {
            Precision::Double => f64::EPSILON,
            Precision::Single => (DISPLACEMENT_SHARE * distance).max(f64::EPSILON),
        }
    }

    /// λ with its displacement, solved from that of another one to the share `target`, and the dual problem about it; the
    /// error is yet to be measured.
    pub(in crate::solver) fn about(
        &self,
        driver: &NewtonDriver<'_>,
        unknowns: &[f64],
        start: Option<&Doubled>,
        target: f64,
    ) -> Refined {
        let NewtonDriver { dual, local, .. } = *driver;
        // The face's own displacement is this share of the body's, at least.
        let target = target / local.rigid_compliance_ratio();
        let state = self.state_at(unknowns, start, target);
        let ContactBody { assembly, face } = self.body;
        let (surface, frame) = (face.surface, &face.interface.frame);
        let (u, dofs) = (&state.displacement, &assembly.primal.dofs);
        Refined {
            unknowns: state.unknowns,
            error: f64::INFINITY,
            dual: dual.about(unknowns, u, state.gap_residual, surface, frame, dofs),
            solved: state.solved,
            displacement: state.displacement,
            history: Vec::new(),
            applications: 1,
        }
    }
}
