//! Newton's method with the dense matrix of R', and what helps it from afar.

use super::{
    NewtonSolution,
    iteration::{NewtonModel, NewtonSettings, ROUNDING_ZONE, StoppingRule, iterate},
    natural_map::NaturalMap,
};
use crate::solver::{
    NewtonStep,
    conditions::Evaluation,
    tolerances::{ROUNDING_STALL_STEPS, STAGNATION_STEPS},
};

/// Sweeps of relaxation after every trial step; twice as many at the start, whose zones nothing tells.
pub(super) const SWEEPS_PER_STEP: usize = 10;

/// A step that reduces ‖R‖ to this share lies in the range of fast convergence: nothing to relax.
const FAST_DECREASE: f64 = 0.01;

/// A multiplier, with the motions of a body that floats, and its residual.
struct DenseIterate {
    unknowns: Vec<f64>,
    /// ‖λ‖, beside the stresses that weak supports take off the face.
    size: f64,
    evaluation: Evaluation,
}

/// The natural map with its derivative as a matrix.
struct DenseModel<'m, 'f> {
    map: &'m NaturalMap<'m>,
    globalisation: Option<Globalisation<'f>>,
    evaluations: usize,
}

/// What helps from a start that may be far away: sweeps of relaxation, after a stall the start without them, and then a safeguard.
struct Globalisation<'f> {
    start: Vec<f64>,
    relaxes: bool,
    safeguard: &'f mut dyn FnMut(&[f64]) -> Vec<f64>,
}

/// Newton's method on any natural map from a good start; a stall ends it.
pub(in crate::solver) fn newton_from(
    map: &NaturalMap<'_>,
    start: Vec<f64>,
    rule: &StoppingRule,
    observe: impl FnMut(usize, &NewtonStep),
) -> NewtonSolution {
    let mut model = DenseModel {
        map,
        globalisation: None,
        evaluations: 0,
    };
    let start = model.at(start);
    model.run(start, rule, observe)
}

/// From any start with relaxed trial steps until the residual stalls, and then once more without; after that, or where R' is singular,
/// the safeguard makes a better multiplier of the best one.
pub(super) fn from_afar(
    map: &NaturalMap<'_>,
    start: Vec<f64>,
    settings: &NewtonSettings,
    least_steps: usize,
    safeguard: &mut dyn FnMut(&[f64]) -> Vec<f64>,
    observe: impl FnMut(usize, &NewtonStep),
) -> NewtonSolution {
    let mut model = DenseModel {
        map,
        globalisation: Some(Globalisation {
            start: start.clone(),
            relaxes: true,
            safeguard,
        }),
        evaluations: 0,
    };
    let mut first = model.at(start);
    if first.evaluation.norm.is_finite() && model.relative(&first) > settings.tolerance {
        first = model.relaxed(first, 2 * SWEEPS_PER_STEP);
    }
    let rule = StoppingRule {
        settings: *settings,
        least_steps,
        stagnation_steps: STAGNATION_STEPS,
        rounding_steps: ROUNDING_STALL_STEPS,
    };
    model.run(first, &rule, observe)
}

impl DenseModel<'_, '_> {
    fn run(
        mut self,
        start: DenseIterate,
        rule: &StoppingRule,
        observe: impl FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        let found = iterate(&mut self, start, rule, observe);
        NewtonSolution {
            stop: found.stop,
            residual: self.relative(&found.iterate),
            unknowns: found.iterate.unknowns,
            history: found.history,
            evaluations: self.evaluations,
        }
    }

    fn at(&mut self, unknowns: Vec<f64>) -> DenseIterate {
        self.evaluations += 1;
        DenseIterate {
            size: self.map.size(&unknowns),
            evaluation: self.map.evaluate(&unknowns),
            unknowns,
        }
    }

    /// An iterate or its relaxation, whichever has the smaller ‖R‖.
    fn relaxed(&mut self, iterate: DenseIterate, sweeps: usize) -> DenseIterate {
        let mut unknowns = iterate.unknowns.clone();
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

impl NewtonModel for DenseModel<'_, '_> {
    type Iterate = DenseIterate;

    fn evaluation<'i>(&self, iterate: &'i DenseIterate) -> &'i Evaluation {
        &iterate.evaluation
    }

    fn relative(&self, iterate: &DenseIterate) -> f64 {
        iterate.evaluation.relative_to(iterate.size)
    }

    fn direction(&mut self, from: &DenseIterate) -> Option<(Vec<f64>, usize)> {
        self.map.newton_step(&from.evaluation)
    }

    fn trial(&mut self, from: &DenseIterate, direction: &[f64], length: f64) -> DenseIterate {
        let pairs = from.unknowns.iter().zip(direction);
        let next = self.at(pairs.map(|(l, d)| l + length * d).collect());
        let relaxes = self.globalisation.as_ref().is_some_and(|it| it.relaxes);
        if !relaxes || next.evaluation.norm < FAST_DECREASE * from.evaluation.norm {
            return next;
        }
        self.relaxed(next, SWEEPS_PER_STEP)
    }

    fn is_at_rounding(&self, best: &DenseIterate) -> bool {
        let relative = self.relative(best);
        relative < ROUNDING_ZONE || relative < self.map.rounding(&best.unknowns, &best.evaluation)
    }

    fn restart(&mut self) -> Option<DenseIterate> {
        let globalisation = self.globalisation.as_mut()?;
        let start = globalisation.relaxes.then(|| globalisation.start.clone());
        globalisation.relaxes = false;
        start.map(|start| self.at(start))
    }

    fn safeguard(&mut self, best: &DenseIterate) -> Option<DenseIterate> {
        let globalisation = self.globalisation.as_mut()?;
        let safe = (globalisation.safeguard)(&best.unknowns);
        Some(self.at(safe))
    }
}
