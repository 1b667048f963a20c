//! The body: a brick or a Gmsh file.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Brick, Measure, is_default};

/// The body Ω and the finite element of its displacement. Either `brick` or `gmsh` is given.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["brick"]}, {"required": ["gmsh"]}], "examples" = ["body.gmsh = { file = \"foot.msh\" }"]))]
pub struct Body {
    /// The finite element of the displacement.
    #[serde(default, skip_serializing_if = "is_default")]
    pub element: ElementOrder,
    /// The box (0, Lx) × (0, Ly) × (0, Lz) cut in cells of five tetrahedra each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brick: Option<Brick>,
    /// A tetrahedral mesh from a Gmsh file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gmsh: Option<GmshFile>,
}

impl From<Brick> for Body {
    fn from(brick: Brick) -> Self {
        Self {
            brick: Some(brick),
            ..Self::default()
        }
    }
}

impl From<GmshFile> for Body {
    fn from(file: GmshFile) -> Self {
        Self {
            gmsh: Some(file),
            ..Self::default()
        }
    }
}

/// The finite element of the displacement.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
pub enum ElementOrder {
    /// Linear tetrahedra, the paper's; panes of a brick are 2 × 2 cells.
    #[default]
    P1,
    /// Quadratic tetrahedra; panes of a brick are single cells. They take the fewest unknowns for an error, and hardly lock where ν is
    /// near 0.5.
    P2,
}

impl Body {
    /// The brick; `None` for other bodies. What needs a regular mesh or faces known by name (nested meshes,
    /// mirror images) asks for it.
    #[must_use]
    pub fn as_brick(&self) -> Option<&Brick> {
        self.brick.as_ref()
    }

    /// As [`Self::as_brick`], to change.
    #[must_use]
    pub fn as_brick_mut(&mut self) -> Option<&mut Brick> {
        self.brick.as_mut()
    }
}

impl ElementOrder {
    /// Cells of a brick along the edge of a pane.
    ///
    /// Every pane needs a node of its own in its inside, or S is nearly singular: with P1 the centre
    /// of 2 × 2 cells, with P2 the middle of a cell's diagonal.
    #[must_use]
    pub fn cells_per_pane(self) -> usize {
        match self {
            Self::P1 => 2,
            Self::P2 => 1,
        }
    }
}

/// A mesh file of Gmsh: format 4.1, or 2.2 in text. Physical surfaces name the faces, physical volumes the regions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GmshFile {
    /// Path of the .msh file, relative to the scene file.
    pub file: PathBuf,
    /// Length > 0 of the file's unit in m: 0.001 for a mesh in millimetres and a scene in metres.
    #[serde(default = "one")]
    #[schemars(extend("measures" = Measure::Length, "exclusiveMinimum" = 0))]
    pub unit: f64,
    /// BLAKE3 digest of the file. Filled in when the mesh is made; a scene that gives it is sure
    /// to use that very file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub digest: Option<String>,
}

fn one() -> f64 {
    1.0
}
