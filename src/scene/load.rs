use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Face;

/// A displacement component in the global axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Component {
    /// u_x.
    X,
    /// u_y.
    Y,
    /// u_z.
    Z,
}

/// Displacement components held at zero on a face.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Clamp {
    /// The held face.
    pub face: Face,
    /// The held components; all three when not given.
    #[serde(default = "all_components")]
    pub components: Vec<Component>,
}

fn all_components() -> Vec<Component> {
    vec![Component::X, Component::Y, Component::Z]
}

/// A constant surface traction σν = p.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Traction {
    /// The loaded face.
    pub face: Face,
    /// The traction vector p in Pa.
    pub value: [f64; 3],
}
