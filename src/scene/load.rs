use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Quantity;

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

impl Component {
    /// The name used in scene files.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["x", "y", "z"][self as usize]
    }
}

/// Displacement components held at zero on a face.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Clamp {
    /// The held face: x_min … z_max of a brick, or a physical surface of a Gmsh file.
    pub face: String,
    /// The held components; all three when not given.
    #[serde(default = "all_components")]
    pub components: Vec<Component>,
}

fn all_components() -> Vec<Component> {
    vec![Component::X, Component::Y, Component::Z]
}

/// A surface traction σν = p.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Traction {
    /// The loaded face.
    pub face: String,
    /// The traction vector p in Pa: numbers, or expressions in x, y, z.
    pub value: [Quantity; 3],
}

/// A pressure σν = −p ν, which pushes into the body where positive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pressure {
    /// The loaded face.
    pub face: String,
    /// The pressure p in Pa: a number, or an expression in x, y, z.
    pub value: Quantity,
}

/// A force f per volume, such as weight.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyForce {
    /// The force vector f in N/m³: numbers, or expressions in x, y, z.
    pub value: [Quantity; 3],
}
