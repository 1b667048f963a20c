use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Face;

/// The contact face Γ_c above the rigid half-space.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// The face that may touch the foundation.
    pub face: Face,
    /// Initial gap d ≥ 0 between body and foundation in m.
    #[serde(default)]
    pub gap: f64,
    /// First principal axis t₁ of friction, a vector in the plane of the face; any length.
    /// Along x when not given (along y on faces x_min and x_max).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis_1: Option<[f64; 3]>,
}

/// The orthonormal frame (ν, t₁, t₂) of the contact face, with t₂ = t₁ × ν.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Outward unit normal ν.
    pub normal: [f64; 3],
    /// First principal axis of friction t₁.
    pub axis_1: [f64; 3],
    /// Second principal axis of friction t₂.
    pub axis_2: [f64; 3],
}

impl Contact {
    /// The friction frame of the face.
    #[must_use]
    pub fn frame(&self) -> Frame {
        let normal = Vector3::from(self.face.normal());
        let default = if self.face.axis() == 0 {
            Vector3::y()
        } else {
            Vector3::x()
        };
        let axis_1 = self
            .axis_1
            .map_or(default, |a| Vector3::from(a).normalize());
        let axis_2 = axis_1.cross(&normal);
        Frame {
            normal: normal.into(),
            axis_1: axis_1.into(),
            axis_2: axis_2.into(),
        }
    }
}

impl Frame {
    /// The components (u·ν, u·t₁, u·t₂) of a vector.
    #[must_use]
    pub fn components(&self, vector: [f64; 3]) -> [f64; 3] {
        let u = Vector3::from(vector);
        [self.normal, self.axis_1, self.axis_2].map(|axis| u.dot(&Vector3::from(axis)))
    }
}
