use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the inner problems of Algorithm 4.1 are stopped (HKL Remark 4.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PrecisionControl {
    /// (a) ε_λ = r_tol · ε in every outer step.
    Fixed,
    /// (b) ε_λ⁽ᵏ⁾ = min(r_tol · err⁽ᵏ⁻¹⁾, c_fact · ε_λ⁽ᵏ⁻¹⁾).
    #[default]
    Adaptive,
}

/// Settings of the solve stage; the defaults are the paper's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SolveSettings {
    /// Stop when ‖λ⁽ᵏ⁺¹⁾ − λ⁽ᵏ⁾‖ ≤ ε ‖λ⁽ᵏ⁺¹⁾‖.
    pub epsilon: f64,
    /// Precision control of the inner problems.
    pub precision: PrecisionControl,
    /// Ratio r_tol of inner to outer tolerance.
    pub r_tol: f64,
    /// Smallest decrease c_fact of the inner tolerance per outer step under adaptive control.
    pub c_fact: f64,
    /// Proportioning constant Γ of KPRGP.
    pub gamma: f64,
    /// Most outer steps.
    pub max_outer_steps: usize,
    /// Most actions of S in one inner problem.
    pub max_inner_actions: usize,
}

impl Default for SolveSettings {
    fn default() -> Self {
        Self {
            epsilon: 1e-4,
            precision: PrecisionControl::default(),
            r_tol: 0.1,
            c_fact: 0.99,
            gamma: 1.0,
            max_outer_steps: 200,
            max_inner_actions: 1_000_000,
        }
    }
}
