use super::{NewtonStep, StepCounts};
use crate::{
    contact::FrictionField,
    mesh::ContactSurface,
    scene::{Frame, Friction},
};

/// How a solve ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// The accuracy ε was reached.
    Converged,
    /// The outer loop ran out of steps.
    MaxOuterSteps,
    /// An inner problem ran out of actions of S, or of Newton steps.
    MaxInnerActions,
    /// A value was not finite.
    NumericalError,
    /// Rounding forbids ε; the accuracy reached is the best there is.
    RoundingLimit,
    /// Newton's method ran out of steps.
    MaxNewtonSteps,
}

/// Which algorithm gave the answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SolvedBy {
    /// Successive approximations.
    FixedPoint,
    /// Semismooth Newton.
    Newton,
}

/// One step k of Algorithm 4.1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OuterStep {
    /// err⁽ᵏ⁾ = ‖λ⁽ᵏ⁺¹⁾ − λ⁽ᵏ⁾‖ / ‖λ⁽ᵏ⁺¹⁾‖.
    pub change: f64,
    /// Inner tolerance ε_λ⁽ᵏ⁾ relative to ‖h‖; for Newton's method relative to ‖λ‖.
    pub inner_tolerance: f64,
    /// Final ‖g̃‖ of the inner problem relative to ‖h‖; for Newton's method ‖R‖ / ‖λ‖.
    pub inner_residual: f64,
    /// Steps of KPRGP or [`super::Gpcg`]; none for Newton's method.
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
    /// Which algorithm gave the answer.
    pub solved_by: SolvedBy,
    /// The last change err of successive approximations, or ‖R‖ / ‖λ‖ of Newton's method.
    pub accuracy: f64,
    /// ‖Ψ(λ) − λ‖ / ‖λ‖ for the paper's mapping Ψ, where it was evaluated.
    pub mapping_change: Option<f64>,
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
    /// One record per step of successive approximations.
    pub history: Vec<OuterStep>,
    /// One record per step of Newton's method.
    pub newton: Vec<NewtonStep>,
    /// Actions of A⁻¹, or of the dense S in its place (n_A).
    pub actions: usize,
}

/// What the friction law needs to know of the contact face.
#[derive(Debug, Clone, Copy)]
pub struct ContactState<'a> {
    /// Γ_c and its panes.
    pub surface: &'a ContactSurface,
    /// The friction frame.
    pub frame: &'a Frame,
    /// The friction law.
    pub law: &'a Friction,
}
