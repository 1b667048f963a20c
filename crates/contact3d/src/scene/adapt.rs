//! What an adaptive mesh is to reach.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The accuracy that the mesh is refined for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AdaptSettings {
    /// Wished discretisation error ‖u − u_h‖_A / ‖u_h‖_A: `run` cuts tetrahedra where the estimated error sits until
    /// the estimate is no larger. 0.01 is 1 %.
    pub error: f64,
}

/// The smallest wish: what double precision leaves of an energy norm.
pub(super) const SMALLEST_ERROR: f64 = 1e-8;
