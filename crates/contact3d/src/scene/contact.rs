//! The contact face, its initial gap, its axes and the space of multipliers.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Obstacle, Quantity};

/// The contact face Γ_c and the rigid obstacle that it may touch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// The face that may touch the foundation or the obstacle; it must be flat where there is no obstacle.
    pub face: String,
    /// The rigid obstacle in the place of the foundation, which is the half-space behind the flat face.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub obstacle: Option<Obstacle>,
    /// Initial gap d ≥ 0 between body and foundation in m: a number, or an expression in x, y, z. It adds to the
    /// distance from an obstacle.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub gap: Quantity,
    /// First principal axis t₁ of friction, a vector of any length in the plane of the face:
    /// numbers, or expressions in x, y, z. Where normals vary it is projected on the tangent plane of each contact node.
    /// When not given, the global x axis projected on the face (the y axis on a face perpendicular to x).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis_1: Option<[Quantity; 3]>,
    /// Angle in degrees by which the default t₁ is turned towards t₂ = t₁ × ν, with ν the outward
    /// normal: counterclockwise seen from inside the body, on z_min from x towards y. A number, or
    /// an expression in x, y, z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle: Option<Quantity>,
    /// The space of the contact stresses.
    #[serde(default)]
    pub multipliers: MultiplierSpace,
    /// How the slips that coefficients of friction follow are made from displacements.
    #[serde(default, skip_serializing_if = "is_default")]
    pub slip_interpolation: SlipInterpolation,
}

fn is_default(interpolation: &SlipInterpolation) -> bool {
    *interpolation == SlipInterpolation::default()
}

/// The interpolation r_h of |u_t1| and |u_t2| on the contact face (HKL §3).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SlipInterpolation {
    /// Values at the nodes, as in HKL's experiments.
    #[default]
    Lagrange,
    /// Means over the triangles around each node (HKL (3.19)), as in their theory; for linear tetrahedra.
    Clement,
}

fn is_zero(quantity: &Quantity) -> bool {
    *quantity == Quantity::Constant(0.0)
}

/// The space L^H of the contact stresses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MultiplierSpace {
    /// Constant on panes, groups of triangles (FE2 of HKL §3).
    #[default]
    Panes,
    /// One value per contact node, with lumped integration (FE1 of HKL Remark 3.1): contact and
    /// friction hold for the forces and displacements of every node.
    Nodal,
}
