//! Newton's method with the dense matrix of R', and what helps it from afar.

use super::{
    NewtonSolution,
    iteration::{Iterate, NewtonModel, NewtonSettings, ROUNDING_REGIME, iterate},
    natural_map::NaturalMap,
};
use crate::solver::NewtonStep;

/// Sweeps of relaxation after every trial step: with more than 30 unknowns they cost less than the factorisation for the step. Twice as
/// many at the start, whose zones nothing tells.
pub(super) const SWEEPS_PER_STEP: usize = 10;

/// A step that reduces ‖R‖ to this share lies in the range of fast convergence: two digits are more than sweeps win.
const FAST_DECREASE: f64 = 0.01;

/// The natural map with its derivative as a matrix, at unknowns (λ, α), and what helps from a start that may be far away.
struct DenseModel<'m, F> {
    map: &'m NaturalMap<'m>,
    /// Where the method begins once more after a stall; until then trial steps are relaxed.
    unrelaxed_start: Option<Vec<f64>>,
    safeguard: Option<F>,
    evaluations: usize,
}

/// Newton's method on any natural map from a good start; a stall ends it.
pub(in crate::solver) fn local_newton(
    map: &NaturalMap<'_>,
    start: Vec<f64>,
    settings: &NewtonSettings,
    observe: impl FnMut(usize, &NewtonStep),
) -> NewtonSolution {
    let mut model = DenseModel {
        map,
        unrelaxed_start: None,
        safeguard: None::<fn(&mut [f64])>,
        evaluations: 0,
    };
    let start = model.at(start);
    model.run(start, settings, observe)
}

/// From any start with relaxed trial steps until the residual stalls, and then once more without; after that, or where R' is singular,
/// the safeguard makes a better multiplier of the best one.
pub(super) fn globalised_newton(
    map: &NaturalMap<'_>,
    start: Vec<f64>,
    settings: &NewtonSettings,
    safeguard: impl FnMut(&mut [f64]),
    observe: impl FnMut(usize, &NewtonStep),
) -> NewtonSolution {
    let mut model = DenseModel {
        map,
        unrelaxed_start: Some(start.clone()),
        safeguard: Some(safeguard),
        evaluations: 0,
    };
    let mut first = model.at(start);
    if first.evaluation.norm.is_finite() && first.relative() > settings.tolerance {
        first = model.relaxed(first, 2 * SWEEPS_PER_STEP);
    }
    model.run(first, settings, observe)
}

impl<F: FnMut(&mut [f64])> DenseModel<'_, F> {
    fn run(
        mut self,
        start: Iterate<Vec<f64>>,
        settings: &NewtonSettings,
        observe: impl FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        let (stop, reached, history) = iterate(&mut self, start, settings, observe);
        NewtonSolution {
            stop,
            residual: reached.relative(),
            unknowns: reached.point,
            history,
            evaluations: self.evaluations,
        }
    }

    fn at(&mut self, unknowns: Vec<f64>) -> Iterate<Vec<f64>> {
        self.evaluations += 1;
        Iterate {
            size: self.map.size(&unknowns),
            evaluation: self.map.evaluate(&unknowns),
            point: unknowns,
        }
    }

    /// An iterate or its relaxation, whichever has the smaller ‖R‖.
    fn relaxed(&mut self, iterate: Iterate<Vec<f64>>, sweeps: usize) -> Iterate<Vec<f64>> {
        let mut unknowns = iterate.point.clone();
        self.map.relax(&mut unknowns, sweeps);
        self.evaluations += sweeps + 1;
        let relaxed = self.at(unknowns);
        if relaxed.evaluation.norm < iterate.evaluation.norm {
            relaxed
        } else {
            iterate
        }
    }
}

impl<F: FnMut(&mut [f64])> NewtonModel for DenseModel<'_, F> {
    type Point = Vec<f64>;

    fn direction(&mut self, from: &Iterate<Vec<f64>>) -> Option<(Vec<f64>, usize)> {
        self.map.newton_step(&from.evaluation)
    }

    fn trial(
        &mut self,
        from: &Iterate<Vec<f64>>,
        direction: &[f64],
        length: f64,
    ) -> Iterate<Vec<f64>> {
        let pairs = from.point.iter().zip(direction);
        let next = self.at(pairs.map(|(l, d)| l + length * d).collect());
        let is_plain = self.unrelaxed_start.is_none();
        if is_plain || next.evaluation.norm < FAST_DECREASE * from.evaluation.norm {
            return next;
        }
        self.relaxed(next, SWEEPS_PER_STEP)
    }

    /// Without friction and with contact springs steps are those of an active set method, which finds the zones of long beams by full steps
    /// alone: on the way gaps open that are larger than all at the solution.
    fn is_damped(&self) -> bool {
        self.map.dual.contact_springs.is_none() || self.map.dual.layout.n_pairs() > 0
    }

    fn is_at_rounding(&self, best: &Iterate<Vec<f64>>) -> bool {
        let relative = best.relative();
        relative < ROUNDING_REGIME || relative < self.map.rounding(&best.point, &best.evaluation)
    }

    fn restart(&mut self) -> Option<Iterate<Vec<f64>>> {
        let start = self.unrelaxed_start.take()?;
        Some(self.at(start))
    }

    fn safeguard(&mut self, best: &Iterate<Vec<f64>>) -> Option<Iterate<Vec<f64>>> {
        let mut safe = best.point.clone();
        self.safeguard.as_mut()?(&mut safe);
        Some(self.at(safe))
    }
}
