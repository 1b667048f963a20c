use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The body Ω.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Body {
    /// The box (0, Lx) × (0, Ly) × (0, Lz) cut in equal cells of five tetrahedra each.
    Brick(Brick),
}

/// A box and its regular mesh (HKL §4).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Brick {
    /// Edge lengths [Lx, Ly, Lz] in m.
    pub size: [f64; 3],
    /// Numbers of cells [nx, ny, nz]; even along the two axes of the contact face.
    pub cells: [usize; 3],
}

/// A face of the brick.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Face {
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

impl Face {
    /// All faces, in the order of their stored numbers 0…5.
    pub const ALL: [Self; 6] = [
        Self::XMin,
        Self::XMax,
        Self::YMin,
        Self::YMax,
        Self::ZMin,
        Self::ZMax,
    ];

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

    /// The outward unit normal ν.
    #[must_use]
    pub fn normal(self) -> [f64; 3] {
        let mut normal = [0.0; 3];
        normal[self.axis()] = if self.is_max() { 1.0 } else { -1.0 };
        normal
    }

    /// The name used in scene files.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"][self as usize]
    }
}
