use std::time::Instant;

use super::{FeasibleSet, InnerOutcome, Kprgp, StepCounts, operator_norm, vector::norm};
use crate::{
    contact::{FrictionField, nodal_slip},
    dual::{Assembly, DualOperator},
    mesh::ContactSurface,
    scene::{Frame, Friction, PrecisionControl, SolveSettings},
};

/// How a solve ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// The change of λ fell to ε.
    Converged,
    /// The outer loop ran out of steps.
    MaxOuterSteps,
    /// An inner problem ran out of actions of S.
    MaxInnerActions,
    /// A value was not finite.
    NumericalError,
}

/// One step k of Algorithm 4.1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OuterStep {
    /// err⁽ᵏ⁾ = ‖λ⁽ᵏ⁺¹⁾ − λ⁽ᵏ⁾‖ / ‖λ⁽ᵏ⁺¹⁾‖.
    pub change: f64,
    /// Inner tolerance ε_λ⁽ᵏ⁾ relative to ‖h‖.
    pub inner_tolerance: f64,
    /// Final ‖g̃‖ of the inner problem relative to ‖h‖.
    pub inner_residual: f64,
    /// Steps of KPRGP.
    pub steps: StepCounts,
    /// Actions of A⁻¹ in this step; the first step includes those that estimate ‖S‖.
    pub actions: usize,
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// The discrete solution and how it was reached.
#[derive(Debug, Clone)]
pub struct Solution {
    /// How the solve ended.
    pub status: Status,
    /// λ: m normal stresses λ_ν, then m pairs λ_t, `[3 n_panes]`, in Pa.
    pub multiplier: Vec<f64>,
    /// u over the free degrees of freedom, `[n_free]`, in m.
    pub displacement: Vec<f64>,
    /// φ = (|u_t1|, |u_t2|) of `displacement` at the contact nodes, in m.
    pub slip: Vec<[f64; 2]>,
    /// The slip bound g that the last inner problem used, `[n_panes]`, in Pa.
    pub slip_bound: Vec<f64>,
    /// The friction that the last inner problem used.
    pub friction: FrictionField,
    /// Steplength ᾱ of projected gradient steps, in Pa/m³.
    pub steplength: f64,
    /// One record per outer step.
    pub history: Vec<OuterStep>,
}

impl Solution {
    /// All actions of A⁻¹ (n_A).
    #[must_use]
    pub fn actions(&self) -> usize {
        self.history.iter().map(|step| step.actions).sum()
    }
}

/// The inner tolerances of HKL Remark 4.1.
struct Precision<'a> {
    settings: &'a SolveSettings,
    tolerance: f64,
}

impl<'a> Precision<'a> {
    fn new(settings: &'a SolveSettings) -> Self {
        Self {
            settings,
            tolerance: settings.r_tol / settings.c_fact,
        }
    }

    /// ε_λ⁽ᵏ⁾ from err⁽ᵏ⁻¹⁾, relative to ‖h‖.
    fn next(&mut self, last_change: f64) -> f64 {
        let s = self.settings;
        self.tolerance = match s.precision {
            PrecisionControl::Fixed => s.r_tol * s.epsilon,
            PrecisionControl::Adaptive => (s.r_tol * last_change).min(s.c_fact * self.tolerance),
        };
        self.tolerance
    }
}

/// What the friction law needs to know of the contact face.
pub struct ContactState<'a> {
    /// Γ_c and its panes.
    pub surface: &'a ContactSurface,
    /// The friction frame.
    pub frame: &'a Frame,
    /// The friction law.
    pub law: &'a Friction,
}

/// The method of successive approximations (HKL Algorithm 4.1) with KPRGP as inner solver.
///
/// `observe` is called after every outer step with its number and record.
pub fn successive_approximations(
    operator: &mut dyn DualOperator,
    assembly: &Assembly,
    contact: &ContactState<'_>,
    settings: &SolveSettings,
    mut observe: impl FnMut(usize, &OuterStep),
) -> Solution {
    let m = contact.surface.n_panes();
    let rhs_norm = norm(operator.rhs());
    let mut started = Instant::now();
    let mut actions_before = operator.actions();
    let steplength = match operator_norm(operator) {
        0.0 => 1.0,
        largest => 1.9 / largest,
    };
    let inner = Kprgp {
        steplength,
        gamma: settings.gamma,
        max_actions: settings.max_inner_actions,
    };
    let mut precision = Precision::new(settings);
    let mut change = 1.0;
    let no_slip = vec![[0.0; 2]; contact.surface.nodes.len()];
    let mut solution = Solution {
        status: Status::MaxOuterSteps,
        multiplier: vec![0.0; 3 * m],
        displacement: Vec::new(),
        friction: FrictionField::new(contact.law, contact.surface, &no_slip),
        slip: no_slip,
        slip_bound: vec![0.0; m],
        steplength,
        history: Vec::new(),
    };
    for k in 0..settings.max_outer_steps {
        if k > 0 {
            solution.slip_bound = solution.multiplier[..m].to_vec();
            solution.friction = FrictionField::new(contact.law, contact.surface, &solution.slip);
        }
        let set = FeasibleSet::new(&solution.slip_bound, &solution.friction);
        let tolerance = precision.next(change);
        let mut next = solution.multiplier.clone();
        set.project(&mut next);
        let outcome = inner.minimise(operator, &set, &mut next, tolerance * rhs_norm);
        change = relative_change(&next, &solution.multiplier);
        solution.multiplier = next;
        solution.displacement = operator.to_primal(&solution.multiplier);
        solution.slip = nodal_slip(
            contact.surface,
            contact.frame,
            &assembly.primal.dofs,
            &solution.displacement,
        );
        solution.history.push(OuterStep {
            change,
            inner_tolerance: tolerance,
            inner_residual: if rhs_norm > 0.0 {
                outcome.reduced_gradient / rhs_norm
            } else {
                0.0
            },
            steps: outcome.steps,
            actions: operator.actions() - actions_before,
            seconds: started.elapsed().as_secs_f64(),
        });
        actions_before = operator.actions();
        started = Instant::now();
        observe(k, &solution.history[k]);
        if let Some(status) = stop(&outcome, change, settings.epsilon) {
            solution.status = status;
            break;
        }
    }
    solution
}

/// ‖λ' − λ‖ / ‖λ'‖, and 0 when both vanish.
fn relative_change(next: &[f64], last: &[f64]) -> f64 {
    let difference: Vec<f64> = next.iter().zip(last).map(|(a, b)| a - b).collect();
    match (norm(&difference), norm(next)) {
        (0.0, _) => 0.0,
        (difference, size) => difference / size,
    }
}

fn stop(outcome: &InnerOutcome, change: f64, epsilon: f64) -> Option<Status> {
    if !change.is_finite() || !outcome.reduced_gradient.is_finite() {
        Some(Status::NumericalError)
    } else if !outcome.converged {
        Some(Status::MaxInnerActions)
    } else if change <= epsilon {
        Some(Status::Converged)
    } else {
        None
    }
}
