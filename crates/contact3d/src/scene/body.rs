//! The body: a brick or a Gmsh file.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Most cells of a brick along an edge.
pub const MOST_CELLS: usize = 4096;

/// The body Ω.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Body {
    /// The box (0, Lx) × (0, Ly) × (0, Lz) cut in equal cells of five tetrahedra each.
    Brick(Brick),
    /// A tetrahedral mesh from a Gmsh file.
    Gmsh(GmshFile),
}

impl Body {
    /// The brick; `None` for other bodies. What needs a regular mesh or faces known by name (nested meshes,
    /// mirror images) asks for it.
    #[must_use]
    pub fn as_brick(&self) -> Option<&Brick> {
        match self {
            Self::Brick(brick) => Some(brick),
            Self::Gmsh(_) => None,
        }
    }

    /// As [`Self::as_brick`], to change.
    #[must_use]
    pub fn as_brick_mut(&mut self) -> Option<&mut Brick> {
        match self {
            Self::Brick(brick) => Some(brick),
            Self::Gmsh(_) => None,
        }
    }

    /// The mesh file, whose physical groups name faces and regions; `None` for other bodies.
    #[must_use]
    pub fn mesh_file(&self) -> Option<&GmshFile> {
        match self {
            Self::Brick(_) => None,
            Self::Gmsh(file) => Some(file),
        }
    }

    /// As [`Self::mesh_file`], to change.
    #[must_use]
    pub fn mesh_file_mut(&mut self) -> Option<&mut GmshFile> {
        match self {
            Self::Brick(_) => None,
            Self::Gmsh(file) => Some(file),
        }
    }

    /// Multiplies all lengths of the body.
    pub fn scale(&mut self, factor: f64) {
        match self {
            Self::Brick(brick) => brick.size = brick.size.map(|l| l * factor),
            Self::Gmsh(file) => file.unit *= factor,
        }
    }
}

/// A box and its regular mesh (HKL §4).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Brick {
    /// Edge lengths [Lx, Ly, Lz] in m.
    pub size: [f64; 3],
    /// Numbers of cells [nx, ny, nz]; with panes, even along the two axes of the contact face.
    pub cells: [usize; 3],
}

/// A mesh file of Gmsh, format 2.2 or 4.1, text or binary. Physical surfaces name the faces,
/// physical volumes the regions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GmshFile {
    /// Path of the .msh file, relative to the scene file.
    pub file: PathBuf,
    /// Length of the file's unit in m.
    #[serde(default = "one")]
    pub unit: f64,
    /// BLAKE3 digest of the file. Filled in when the mesh is made; a scene that gives it is sure
    /// to use that very file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub digest: Option<String>,
}

fn one() -> f64 {
    1.0
}

/// A face of the brick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BrickFace {
    /// x = 0.
    XMin,
    /// x = Lx.
    XMax,
    /// y = 0.
    YMin,
    /// y = Ly.
    YMax,
    /// z = 0.
    ZMin,
    /// z = Lz.
    ZMax,
}

impl BrickFace {
    /// All faces, in the order of their numbers 0…5.
    pub const ALL: [Self; 6] = [
        Self::XMin,
        Self::XMax,
        Self::YMin,
        Self::YMax,
        Self::ZMin,
        Self::ZMax,
    ];

    /// The names used in scene files.
    pub const NAMES: [&str; 6] = ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"];

    /// The face of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let place = Self::NAMES.iter().position(|n| *n == name)?;
        Some(Self::ALL[place])
    }

    /// The coordinate axis the face is perpendicular to (0, 1, 2).
    #[must_use]
    pub fn axis(self) -> usize {
        self as usize / 2
    }

    /// Whether the face lies at the upper end of its axis.
    #[must_use]
    pub fn is_max(self) -> bool {
        self as usize % 2 == 1
    }
}
