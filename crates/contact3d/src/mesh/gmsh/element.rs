//! The kinds of elements of a Gmsh file.

use super::{GmshError, Place};

/// A tetrahedron (K = 4) or triangle (K = 3) as it stands in the file.
#[derive(Debug)]
pub(super) struct Element<const K: usize> {
    pub(super) tag: u64,
    pub(super) place: Place,
    /// Node tags.
    pub(super) nodes: [u64; K],
    /// Index into the memberships.
    pub(super) membership: usize,
}

/// The kinds of elements that a mesh of linear tetrahedra has.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    Point,
    Line,
    Triangle,
    Tetrahedron,
}

impl Kind {
    /// The kind with a code of the format (Gmsh reference manual, MSH file format).
    pub(super) fn of_code(code: i64, place: Place) -> Result<Self, GmshError> {
        let name = match code {
            1 => return Ok(Self::Line),
            2 => return Ok(Self::Triangle),
            4 => return Ok(Self::Tetrahedron),
            15 => return Ok(Self::Point),
            3 => "quadrangles",
            5 => "hexahedra",
            6 => "prisms",
            7 => "pyramids",
            8 => "second-order lines",
            9 => "second-order triangles",
            10 | 16 => "second-order quadrangles",
            11 => "second-order tetrahedra",
            12 | 17 => "second-order hexahedra",
            13 | 18 => "second-order prisms",
            14 | 19 => "second-order pyramids",
            20..=28 => "higher-order lines or triangles",
            29..=31 => "higher-order tetrahedra",
            _ => "another kind",
        };
        Err(GmshError::ElementType { place, code, name })
    }

    pub(super) fn n_nodes(self) -> usize {
        match self {
            Self::Point => 1,
            Self::Line => 2,
            Self::Triangle => 3,
            Self::Tetrahedron => 4,
        }
    }
}
