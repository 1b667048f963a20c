//! The body, a brick or a Gmsh file, and the meshes that refining starts from where a scene leaves them open.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{AdaptSettings, Brick, BrickFace, Contact, FirstMesh, Measure, Scene, is_default};

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

impl Scene {
    /// The scene with the mesh that refining starts from: where it [leaves its mesh open](Self::leaves_mesh_open), a brick gets as
    /// few cells as keep their shape: two along its shortest edge, four with panes of 2 × 2 cells.
    ///
    /// What is chosen stands in the scene, so choosing again changes nothing.
    #[must_use]
    pub fn with_first_mesh(mut self) -> Self {
        let element = self.body.element;
        if self.leaves_mesh_open()
            && let Some(brick) = self.body.as_brick_mut()
        {
            brick.cells = fewest_cells(brick, element);
        }
        self
    }

    /// The scene with other cells of its brick, which shrink towards the faces of clamps, loads and contact: at their edges
    /// stresses are singular or jump.
    #[must_use]
    pub fn with_graded_cells(mut self, cells: [usize; 3]) -> Self {
        let faces = self.named_faces().into_iter();
        let faces = faces.filter_map(|(_, name)| BrickFace::named(&name));
        if let Some(brick) = self.body.as_brick_mut() {
            let equal = Brick::new(brick.size, cells);
            // On the published problem at 24 × 8 × 8 cells the exponent 1.5 leaves 2.8 % of estimated error where equal cells
            // leave 4.1 %, and 2 as much as they.
            let towards = |brick: Brick, face| brick.with_grading(face, 1.5);
            *brick = faces.fold(equal, towards);
        }
        self
    }

    /// Whether the scene asks for an error, starts coarse, and equal cells of any size show all that it says.
    #[must_use]
    pub fn leaves_mesh_open(&self) -> bool {
        let starts_coarse = |adapt: AdaptSettings| adapt.start == FirstMesh::Coarse;
        self.adapt.is_some_and(starts_coarse) && self.is_shown_by_any_cells()
    }

    /// Whether equal cells of any size show all that the scene says.
    fn is_shown_by_any_cells(&self) -> bool {
        let is_whole_and_flat = |face: &Contact| face.obstacle.is_none() && face.corners.is_none();
        let has_equal_cells = |brick: &Brick| (0..3).all(|axis| brick.is_even(axis));
        self.body.as_brick().is_some_and(has_equal_cells)
            && self.contacts.iter().all(is_whole_and_flat)
            && self.regions.is_empty()
            && !self.clamps.iter().any(|clamp| clamp.corners.is_some())
            && !self.depends_on_place()
    }
}

/// The fewest cells of the shape that those of a brick have, `[nx, ny, nz]`: whole panes along every edge.
fn fewest_cells(brick: &Brick, element: ElementOrder) -> [usize; 3] {
    let pane = element.cells_per_pane();
    let shortest = brick.cells.into_iter().min().unwrap_or(1);
    let factor = shortest as f64 / (2 * pane) as f64;
    if factor <= 1.0 {
        return brick.cells;
    }
    // A count divided by what makes the smallest one 2 panes.
    let panes = |cells: usize| (cells as f64 / (factor * pane as f64)).round() as usize;
    brick.cells.map(|cells| pane * panes(cells))
}
