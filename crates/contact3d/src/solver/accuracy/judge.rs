//! How far an answer is from the solution, whichever method found it.

use super::{deviation::Sizes, polish::COARSEST};
use crate::{
    dual::{Balance, ExplicitDual, LocalStiffness},
    linalg::{Workspace, gmres, norm},
    solver::{
        Solution, Status,
        conditions::{Bound, Conditions},
        problem::DiscreteProblem,
    },
};

/// An answer is as accurate as promised when its error is at most this many times ε.
const ABOUT: f64 = 10.0;

/// An answer with a larger error has no digit to rely on: it is no answer.
const NO_DIGIT: f64 = 0.05;

/// Share of the residual that the linear system for the error may leave.
const LEFT: f64 = 1e-4;

/// Most applications of A⁻¹ for that.
const MOST_APPLICATIONS: usize = 300;

/// u is wanted with this share of rounding, so that the face's own displacement is left where the
/// body moves as a whole.
const REFINED: f64 = 1e-4 * f64::EPSILON;

impl DiscreteProblem<'_> {
    /// Holds the answer of a method that stops by its own rule against the distance to the solution:
    /// `converged` stays only where that is about ε, and an answer in other zones is none. The method's
    /// own counters stay as they are.
    pub(in crate::solver) fn judged(
        &self,
        explicit: Option<(&ExplicitDual, &LocalStiffness)>,
        bound: Bound<'_>,
        local_stiffness: Vec<f64>,
        mut solution: Solution,
    ) -> Solution {
        solution.local_stiffness = local_stiffness;
        if !solution.status.is_solved() {
            return solution;
        }
        let error = match explicit {
            Some((dual, local)) => self.error_of(dual, local, bound, &self.unknowns(&solution)),
            None => self.error_without_operator(bound, &solution),
        };
        // An answer without a digit is off by its own size.
        let error = if error <= 1.0 { error } else { 1.0 };
        solution.status = match solution.status {
            _ if error > NO_DIGIT => Status::Inaccurate,
            Status::Converged if error > ABOUT * self.settings.epsilon() => Status::Stopped,
            Status::RoundingLimit if error > COARSEST => Status::Stopped,
            status => status,
        };
        solution.accuracy = match solution.status {
            Status::RoundingLimit => error.max(solution.accuracy),
            _ => error,
        };
        solution
    }

    /// The error of λ where S is not dense: the step d with R'(λ) d = −R(λ) of the natural map with
    /// exact residuals and local stiffness, by GMRES; each product costs one application of A⁻¹.
    fn error_without_operator(&self, bound: Bound<'_>, solution: &Solution) -> f64 {
        let unknowns = &self.unknowns(solution);
        let mut steplengths = solution.local_stiffness.clone();
        let balance = self.dual.balance.as_ref();
        steplengths.extend(balance.into_iter().flat_map(Balance::steplengths));
        let conditions = Conditions::new(bound, self.dual.layout(), steplengths);
        let exact = self.body.exact(self.dual, unknowns, None, REFINED);
        let mut gradient: Vec<f64> = exact.closing.iter().map(|c| -c).collect();
        let (multiplier, motion) = self.dual.parts(unknowns);
        let excess = balance.map(|it| it.excess(multiplier, motion));
        gradient.extend(excess.into_iter().flatten());
        let slip = self.body.tangential(&exact.moved.displacement);
        let here = conditions.evaluate(unknowns, &gradient, &slip);
        // The motions count in units in which they cost as much as a stress.
        let size = steplength_of_motions(balance, &conditions.steplengths);
        let mut work = Workspace::default();
        let step = gmres(&here.residual, LEFT, MOST_APPLICATIONS, |v| {
            let (stresses, motions) = self.dual.parts(v);
            let motion: Vec<f64> = motions.iter().zip(&size).map(|(v, s)| v * s).collect();
            let (mut gradient, slips) = self.body.change(self.dual, stresses, &motion, &mut work);
            let carried = balance.map(|it| it.coupling.resultant_of(stresses, &motion));
            gradient.extend(carried.into_iter().flatten().map(|g| -g));
            conditions.derivative(&here, v, &gradient, &slips)
        });
        let sizes = Sizes::of(self.laws, multiplier, &here);
        sizes.relative(self.laws, &step)
    }
}

/// For each rigid motion the α in m that moves the panes by as much as one Pa does, 1 / ‖ρ G‖, or takes as much force of its support.
fn steplength_of_motions(balance: Option<&Balance>, steplengths: &[f64]) -> Vec<f64> {
    let Some(balance) = balance else {
        return Vec::new();
    };
    let coupling = &balance.coupling;
    let motions = coupling.integrals.iter().zip(&coupling.support);
    motions
        .zip(balance.steplengths())
        .map(|((g, support), rho)| {
            let moved: Vec<f64> = g.iter().zip(steplengths).map(|(g, rho)| g * rho).collect();
            norm(&moved).max(rho * support).recip()
        })
        .collect()
}
