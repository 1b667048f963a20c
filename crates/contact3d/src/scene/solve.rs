//! Settings of the stages assemble and solve.

use super::{Functional, ProblemPart, is_default};
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

/// Which algorithm solves the discrete contact problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Newton's method, by products where the dual operator is implicit; gradient methods and successive approximations where it finds nothing.
    #[default]
    Auto,
    /// Semismooth Newton for slip bound and friction at once; needs the explicit dual operator.
    Newton,
    /// Successive approximations (HKL Algorithm 4.1).
    FixedPoint,
}

/// What solves the problems with frozen slip bound and friction inside successive approximations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InnerSolver {
    /// Conjugate gradients with projections (the paper's).
    #[default]
    Kprgp,
    /// Gradient projection and conjugate gradients on faces, along curved ones too.
    Gpcg,
    /// Semismooth Newton; needs the explicit dual operator.
    Newton,
}

/// How the dual operator S = B A⁻¹ Bᵀ is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DualOperatorKind {
    /// Explicit when its memory is in proportion to that of the Cholesky factor.
    #[default]
    Auto,
    /// Two sparse triangular solves for each application (the paper's way).
    Implicit,
    /// A dense matrix.
    Explicit,
}

/// The precision of the Cholesky factor; answers are to double precision with either.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FactorPrecision {
    /// Single for large bodies, where measured contractions say that it serves; double otherwise.
    #[default]
    Auto,
    /// Half the memory; displacements by conjugate gradients, multipliers corrected by exact residuals.
    Single,
    /// Solves to rounding.
    Double,
}

/// Settings of the assemble stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AssembleSettings {
    /// How the dual operator is held.
    pub dual_operator: DualOperatorKind,
    /// The precision of the Cholesky factor, and of the dense dual operator made from it.
    #[serde(skip_serializing_if = "is_default")]
    pub factor: FactorPrecision,
}

/// Settings of the solve stage; those of Algorithm 4.1 have the paper's values as defaults.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SolveSettings {
    /// The algorithm.
    pub method: Method,
    /// Inner solver of method fixed-point; method auto chooses its own.
    pub inner: InnerSolver,
    /// Relative accuracy ε of the multipliers: the distance to the solution, measured by one more
    /// solution with exact residuals, is at most about ε. Successive approximations stop when
    /// ‖λ⁽ᵏ⁺¹⁾ − λ⁽ᵏ⁾‖ ≤ ε ‖λ⁽ᵏ⁺¹⁾‖ and are judged afterwards. When not given, 1e-4 with method
    /// fixed-point and 1e-12 otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub epsilon: Option<f64>,
    /// Precision control of the inner problems.
    pub precision: PrecisionControl,
    /// Ratio r_tol of inner to outer tolerance.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub r_tol: f64,
    /// Smallest decrease c_fact of the inner tolerance per outer step under adaptive control.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub c_fact: f64,
    /// Proportioning constant Γ > 0 of KPRGP.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub gamma: f64,
    /// Most outer steps.
    #[schemars(extend("minimum" = 1))]
    pub max_outer_steps: usize,
    /// Most applications of S in one inner problem of `kprgp` and `gpcg`.
    #[schemars(extend("minimum" = 1))]
    pub max_operator_applications: usize,
}

impl Default for SolveSettings {
    fn default() -> Self {
        Self {
            method: Method::default(),
            inner: InnerSolver::default(),
            epsilon: None,
            precision: PrecisionControl::default(),
            r_tol: 0.1,
            c_fact: 0.99,
            gamma: 1.0,
            max_outer_steps: 200,
            max_operator_applications: 1_000_000,
        }
    }
}

impl SolveSettings {
    /// ε, given or by default.
    #[must_use]
    pub fn epsilon(&self) -> f64 {
        self.epsilon.unwrap_or(match self.method {
            Method::FixedPoint => 1e-4,
            Method::Auto | Method::Newton => 1e-12,
        })
    }
}

/// The accuracy that the mesh is refined for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AdaptSettings {
    /// Wanted discretisation error ‖u − u_h‖_A / ‖u_h‖_A: `run` refines the mesh where the estimated error sits until
    /// the estimate is no larger. 0.01 is 1 %.
    #[schemars(extend("minimum" = SMALLEST_ERROR, "maximum" = 1))]
    pub error: f64,
    /// The mesh that refining starts from.
    #[serde(default, skip_serializing_if = "is_default")]
    pub start: FirstMesh,
    /// The quantity that the error is of, relative to its value; the energy norm of the displacement when not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("part" = ProblemPart::Solve))]
    pub of: Option<Functional>,
}

/// The mesh that refining starts from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FirstMesh {
    /// As few equal cells as show all that the scene says; the cells of the scene where it names planes, grading, a box, an
    /// obstacle, or formulas of place.
    #[default]
    Coarse,
    /// The mesh of the scene.
    Scene,
}

/// The smallest target: what double precision leaves of an energy norm.
pub const SMALLEST_ERROR: f64 = 1e-8;
