//! Iterative refinement: exact residuals, and the distance to the solution.

use super::error::within_ellipses;
use crate::{
    dual::{ExplicitDual, LocalStiffness},
    linalg::{Doubled, Precision, difference},
    solver::{
        NewtonSettings, NewtonSolution, NewtonStep,
        assessment::REFINEMENT_TARGET,
        conditions::Bound,
        newton::{natural_map::NaturalMap, newton_to_rounding, proximal::about_own_motion},
        problem::ContactSolve,
        strategy::{NEWTON_MAX_STEPS, NewtonDriver, StartStrategy},
    },
};

/// Most rounds; each wins the digits that the conditioning of A and the precision of its factor leave.
const REFINEMENT_MAX_ROUNDS: usize = 16;

/// The displacement of an answer in a round is wanted to this share of the last way, where every digit takes steps of conjugate
/// gradients: S in single precision leaves a thousandth of the way or so, and the displacement shall not be what decides.
const DISPLACEMENT_SHARE: f64 = 1e-5;

/// A dense contact problem with its local stiffness.
#[derive(Clone, Copy)]
pub(in crate::solver) struct DenseModel<'a> {
    /// S, h, G and the equilibrium of rigid-body motions.
    pub(in crate::solver) dual: &'a ExplicitDual,
    /// What residuals are measured by.
    pub(in crate::solver) local: &'a LocalStiffness,
    /// Where ellipses come from.
    pub(in crate::solver) bound: Bound<'a>,
}

/// An answer, how far it is from the solution, and the dual problem written about it.
pub(in crate::solver) struct Refined {
    /// λ, `[n_multipliers]`, in Pa.
    pub(in crate::solver) multiplier: Vec<f64>,
    /// A⁻¹(l − Bᵀλ) in m, to rounding.
    pub(in crate::solver) solved: Doubled,
    /// u of λ in m.
    pub(in crate::solver) displacement: Vec<f64>,
    /// Distance to the solution, relative as in [`super::judge::MultiplierSizes`].
    pub(in crate::solver) error: f64,
    /// S and G about λ.
    pub(in crate::solver) dual: ExplicitDual,
    /// Steps of Newton's method that it took.
    pub(in crate::solver) history: Vec<NewtonStep>,
    /// Applications of S, and one of A⁻¹ a round.
    pub(in crate::solver) applications: usize,
}

/// How far an answer is from the solution.
struct Discrepancy {
    /// Relative as in [`super::judge::MultiplierSizes`].
    error: f64,
    /// Relative to the semi-axes of the ellipses ([`within_ellipses`]): where one coefficient of
    /// friction is a small part of the other, ‖λ_t‖ hides what happens along its axis.
    bound_error: f64,
}

impl Discrepancy {
    const UNKNOWN: Self = Self {
        error: f64::INFINITY,
        bound_error: f64::INFINITY,
    };
}

impl Refined {
    /// Whether the answer lies in the zones of a solution.
    pub(in crate::solver) fn is_solution(&self) -> bool {
        self.error <= REFINEMENT_TARGET
    }

    /// Whether λ and u are numbers.
    pub(in crate::solver) fn is_finite(&self) -> bool {
        let mut values = self.multiplier.iter().chain(&self.displacement);
        values.all(|v| v.is_finite())
    }
}

impl ContactSolve<'_> {
    /// Measures how far λ is from the solution, and comes closer until that is at most `tolerance` or
    /// rounding forbids it.
    ///
    /// In each round u = A⁻¹(l − Bᵀλ) is solved in more than working precision, the dual problem
    /// is written about λ with its exact gradient −(B u − gap), and Newton's method, measured by
    /// local stiffness, solves that. Its solution differs from the true one by what S is wrong, as
    /// a share of the way from λ; so that way is the error of λ. It needs no scale, while small
    /// residuals say little for bodies that nearly float.
    pub(in crate::solver) fn refined(
        &self,
        model: &DenseModel<'_>,
        strategy: StartStrategy,
        multiplier: &[f64],
        tolerance: f64,
    ) -> Refined {
        let mut target = self.target(1.0);
        let mut best = self.exact(model, multiplier, None, target);
        let (mut history, mut applications) = (Vec::new(), 1);
        let mut last = Discrepancy::UNKNOWN;
        // Of displacements; a stall may be theirs where the face hardly moves beside the body.
        let mut loosest = f64::INFINITY;
        for _ in 0..REFINEMENT_MAX_ROUNDS {
            let Some((found, way)) = self.distance_to_solution(model, &best, strategy) else {
                break;
            };
            applications += found.evaluations + 1;
            history.extend(found.history);
            best.error = way.error;
            let falls = way.error <= 0.5 * last.error;
            let bound_falls = way.bound_error <= 0.5 * last.bound_error;
            let accurate = way.error <= tolerance;
            if accurate && (way.bound_error <= tolerance || !bound_falls) {
                if target > f64::EPSILON {
                    // Its displacement is solved again anyway: that of the closer answer then.
                    best.multiplier = found.multiplier;
                }
                break;
            }
            if !accurate && !falls {
                if target <= f64::EPSILON {
                    // Rounding: the errors of the last two answers are of one size.
                    best.error = way.error.max(last.error);
                    break;
                }
                loosest = f64::EPSILON;
            }
            let start = Some(&best.solved);
            target = self.target(way.error).min(loosest);
            let next = self.exact(model, &found.multiplier, start, target);
            let error = way.error;
            best = Refined { error, ..next };
            last = way;
        }
        if target > f64::EPSILON {
            let (multiplier, start) = (&best.multiplier, Some(&best.solved));
            let exact = self.exact(model, multiplier, start, f64::EPSILON);
            applications += 1;
            best = Refined {
                error: best.error,
                ..exact
            };
        }
        Refined {
            history,
            applications,
            ..best
        }
    }

    /// The distance of λ to the solution; infinite where Newton's method finds none from there.
    pub(in crate::solver) fn error_of(&self, model: &DenseModel<'_>, multiplier: &[f64]) -> f64 {
        let found = self.exact(model, multiplier, None, f64::EPSILON);
        let way = self.distance_to_solution(model, &found, StartStrategy::Relaxed);
        way.map_or(f64::INFINITY, |(_, way)| way.error)
    }

    /// The solution of the dual problem about an answer, and its relative distance; `None` where
    /// Newton's method does not find it from there.
    fn distance_to_solution(
        &self,
        model: &DenseModel<'_>,
        answer: &Refined,
        strategy: StartStrategy,
    ) -> Option<(NewtonSolution, Discrepancy)> {
        let DenseModel { local, bound, .. } = *model;
        let steplengths = local.stiffness.clone();
        let settings = NewtonSettings {
            tolerance: answer.dual.rounding(),
            max_steps: NEWTON_MAX_STEPS,
        };
        // One step at least: that is what measures the error.
        let newton_about = |dual: &ExplicitDual| {
            let map = NaturalMap::with_steplengths(dual, bound, steplengths.clone());
            newton_to_rounding(&map, answer.multiplier.clone(), &settings)
        };
        let mut found = newton_about(&answer.dual);
        let is_held = !found.is_solution() && strategy == StartStrategy::ProximalPoint;
        if is_held {
            // A motion is free within an interval.
            found = newton_about(&about_own_motion(&answer.dual, local));
        }
        if let (false, Bound::Frozen(set)) = (found.is_solution(), bound) {
            // An answer that is not far off may lie in zones from which Newton's steps wander off.
            let driver = NewtonDriver {
                dual: &answer.dual,
                bound,
                local,
                start: None,
            };
            found = driver.interior_point(set, &settings, &mut |_, _| {});
        }
        if !found.is_solution() {
            return None;
        }
        let map = NaturalMap::with_steplengths(&answer.dual, bound, steplengths);
        let there = map.evaluate(&found.multiplier);
        let sizes = self.sizes(&found.multiplier, &there);
        let way = difference(&found.multiplier, &answer.multiplier);
        let rounding = self.motion_rounding(&found.multiplier, &there, &local.stiffness);
        // The term's own force vanishes round by round, and slowly where little resists the motion: steps are shorter than the way.
        let held = if is_held {
            there.norm / map.size(&found.multiplier)
        } else {
            0.0
        };
        let way = Discrepancy {
            error: sizes.relative(self.laws, &way).max(rounding).max(held),
            bound_error: within_ellipses(self.laws, &there, &way),
        };
        Some((found, way))
    }

    /// How accurate a displacement shall be, as a share of it, where the next answer is some way off.
    fn target(&self, way: f64) -> f64 {
        match self.body.precision() {
            Precision::Double => f64::EPSILON,
            Precision::Single => (DISPLACEMENT_SHARE * way).max(f64::EPSILON),
        }
    }

    /// λ with its displacement, solved from that of another answer to the share `target`, and the dual problem about it; the
    /// error is yet to be measured.
    pub(in crate::solver) fn exact(
        &self,
        model: &DenseModel<'_>,
        multiplier: &[f64],
        start: Option<&Doubled>,
        target: f64,
    ) -> Refined {
        let DenseModel { dual, local, .. } = *model;
        // The face's own displacement is this share of the body's, at least.
        let target = target / local.rigid_compliance_ratio();
        let start = start.filter(|_| self.body.precision() == Precision::Single);
        let exact = self.body.exact(self.dual, multiplier, start, target);
        Refined {
            multiplier: multiplier.to_vec(),
            error: f64::INFINITY,
            dual: self.body.about(dual, multiplier, &exact),
            solved: exact.solved,
            displacement: exact.displacement,
            history: Vec::new(),
            applications: 1,
        }
    }
}
