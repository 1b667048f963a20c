//! What the methods record of their steps.

use std::ops::AddAssign;

/// Steps of each kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StepCounts {
    /// Conjugate gradient steps inside the set.
    pub conjugate_gradient: usize,
    /// Steps to the boundary followed by a projected step along the free gradient.
    pub expansion: usize,
    /// Projected gradient steps that release active blocks.
    pub proportioning: usize,
}

impl AddAssign for StepCounts {
    fn add_assign(&mut self, other: Self) {
        self.conjugate_gradient += other.conjugate_gradient;
        self.expansion += other.expansion;
        self.proportioning += other.proportioning;
    }
}

/// One step k of Algorithm 4.1.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct OuterStep {
    /// err⁽ᵏ⁾ = ‖λ⁽ᵏ⁺¹⁾ − λ⁽ᵏ⁾‖ / ‖λ⁽ᵏ⁺¹⁾‖.
    pub change: f64,
    /// Inner tolerance ε_λ⁽ᵏ⁾ relative to ‖h‖; for Newton's method relative to ‖λ‖.
    pub inner_tolerance: f64,
    /// Final ‖g̃‖ of the inner problem relative to ‖h‖; for Newton's method ‖R‖ / ‖λ‖.
    pub inner_residual: f64,
    /// Steps of KPRGP or [`super::Gpcg`]; none for Newton's method.
    pub steps: StepCounts,
    /// Applications of A⁻¹ in this step; the first step includes those that estimate ‖S‖.
    pub applications: usize,
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// One step of Newton's method.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct NewtonStep {
    /// ‖R‖ / ‖λ‖ after the step.
    pub residual: f64,
    /// Share s of the step d in λ ← λ + s d.
    pub step_length: f64,
    /// Halvings tried.
    pub halvings: usize,
    /// Panes that changed between open, stick and slip.
    pub zone_changes: usize,
    /// Unknowns of the dense system.
    pub free_unknowns: usize,
    /// Whether a safeguard replaced Newton's step.
    pub fallback: bool,
    /// Share τ of the law in the law F₀^(1−τ) F^τ of the step: 1 unless the law was approached by
    /// continuation.
    pub law_share: f64,
    /// Wall-clock seconds.
    pub seconds: f64,
}
