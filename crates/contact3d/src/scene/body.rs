//! The body: a brick or a Gmsh file.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Brick, Measure, is_default};

/// The body Ω and the finite element of its displacement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "BodyTable", into = "BodyTable")]
#[schemars(with = "BodyTable")]
pub struct Body {
    /// Where the tetrahedra come from.
    pub shape: Shape,
    /// The element.
    pub element: ElementOrder,
}

/// Where the tetrahedra of a body come from.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// The box (0, Lx) × (0, Ly) × (0, Lz) cut in cells of five tetrahedra each.
    Brick(Brick),
    /// A tetrahedral mesh from a Gmsh file.
    Gmsh(GmshFile),
}

/// A body as a scene file writes it: `element`, and either `brick` or `gmsh`.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["brick"]}, {"required": ["gmsh"]}], "examples" = ["body.gmsh = { file = \"foot.msh\" }"]))]
struct BodyTable {
    /// The finite element of the displacement.
    #[serde(default, skip_serializing_if = "is_default")]
    element: ElementChoice,
    /// The box (0, Lx) × (0, Ly) × (0, Lz) cut in cells of five tetrahedra each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    brick: Option<Brick>,
    /// A tetrahedral mesh from a Gmsh file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    gmsh: Option<GmshFile>,
}

impl TryFrom<BodyTable> for Body {
    type Error = String;

    fn try_from(table: BodyTable) -> Result<Self, String> {
        let shape = match (table.brick, table.gmsh) {
            (Some(brick), None) => Shape::Brick(brick),
            (None, Some(gmsh)) => Shape::Gmsh(gmsh),
            (None, None) | (Some(_), Some(_)) => {
                return Err("expected exactly one of brick, gmsh".into());
            }
        };
        Ok(Self {
            shape,
            element: match table.element {
                ElementChoice::P1 => ElementOrder::P1,
                ElementChoice::P2 | ElementChoice::Auto => ElementOrder::P2,
            },
        })
    }
}

impl From<Body> for BodyTable {
    fn from(body: Body) -> Self {
        let (brick, gmsh) = match body.shape {
            Shape::Brick(brick) => (Some(brick), None),
            Shape::Gmsh(gmsh) => (None, Some(gmsh)),
        };
        Self {
            element: match body.element {
                ElementOrder::P1 => ElementChoice::P1,
                ElementOrder::P2 => ElementChoice::P2,
            },
            brick,
            gmsh,
        }
    }
}

impl From<Brick> for Body {
    fn from(brick: Brick) -> Self {
        Shape::Brick(brick).into()
    }
}

impl From<Shape> for Body {
    fn from(shape: Shape) -> Self {
        Self {
            shape,
            element: ElementOrder::default(),
        }
    }
}

/// The element as a scene file writes it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
enum ElementChoice {
    /// Linear tetrahedra, the paper's; panes of a brick are 2 × 2 cells.
    #[default]
    P1,
    /// Quadratic tetrahedra; panes of a brick are single cells.
    P2,
    /// Quadratic tetrahedra: they take the fewest unknowns for an error, and hardly lock where ν is near 0.5.
    #[serde(rename = "auto")]
    Auto,
}

/// The finite element of the displacement.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum ElementOrder {
    /// Linear tetrahedra, the paper's; panes of a brick are 2 × 2 cells.
    #[default]
    P1,
    /// Quadratic tetrahedra; panes of a brick are single cells.
    P2,
}

impl Body {
    /// The brick; `None` for other bodies. What needs a regular mesh or faces known by name (nested meshes,
    /// mirror images) asks for it.
    #[must_use]
    pub fn as_brick(&self) -> Option<&Brick> {
        match &self.shape {
            Shape::Brick(brick) => Some(brick),
            Shape::Gmsh(_) => None,
        }
    }

    /// As [`Self::as_brick`], to change.
    #[must_use]
    pub fn as_brick_mut(&mut self) -> Option<&mut Brick> {
        match &mut self.shape {
            Shape::Brick(brick) => Some(brick),
            Shape::Gmsh(_) => None,
        }
    }

    /// The mesh file, whose physical groups name faces and regions; `None` for other bodies.
    #[must_use]
    pub fn mesh_file(&self) -> Option<&GmshFile> {
        match &self.shape {
            Shape::Brick(_) => None,
            Shape::Gmsh(file) => Some(file),
        }
    }

    /// As [`Self::mesh_file`], to change.
    #[must_use]
    pub fn mesh_file_mut(&mut self) -> Option<&mut GmshFile> {
        match &mut self.shape {
            Shape::Brick(_) => None,
            Shape::Gmsh(file) => Some(file),
        }
    }

    /// Multiplies all lengths of the body.
    pub fn scale(&mut self, factor: f64) {
        match &mut self.shape {
            Shape::Brick(brick) => brick.scale(factor),
            Shape::Gmsh(file) => file.unit *= factor,
        }
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

/// A mesh file of Gmsh, format 2.2 or 4.1, text or binary. Physical surfaces name the faces,
/// physical volumes the regions.
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
