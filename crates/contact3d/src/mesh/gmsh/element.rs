//! The kinds of elements of a Gmsh file.

use super::{GmshError, Place};

/// A tetrahedron (K = 4) or triangle (K = 3) as it stands in the file, by its corners.
#[derive(Debug)]
pub(super) struct Element<const K: usize> {
    pub(super) tag: u64,
    pub(super) place: Place,
    /// Node tags of the corners.
    pub(super) nodes: [u64; K],
    /// Index into the memberships.
    pub(super) membership: usize,
}

/// The kinds of elements that a mesh of linear or quadratic tetrahedra has.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    Point,
    Line(Order),
    Triangle(Order),
    Tetrahedron(Order),
}

/// Whether elements have nodes in the middle of their edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    First,
    Second,
}

/// Most nodes of an element that is read.
pub(super) const MOST_NODES: usize = 10;

/// The mid-edge nodes of a second-order tetrahedron in our order; the format swaps the last two.
pub(super) const MIDDLES: [usize; 6] = [4, 5, 6, 7, 9, 8];

impl Kind {
    /// The kind with a code of the format (Gmsh reference manual, MSH file format).
    pub(super) fn of_code(code: i64, place: Place) -> Result<Self, GmshError> {
        let name = match code {
            1 => return Ok(Self::Line(Order::First)),
            2 => return Ok(Self::Triangle(Order::First)),
            4 => return Ok(Self::Tetrahedron(Order::First)),
            8 => return Ok(Self::Line(Order::Second)),
            9 => return Ok(Self::Triangle(Order::Second)),
            11 => return Ok(Self::Tetrahedron(Order::Second)),
            15 => return Ok(Self::Point),
            3 => "quadrangles",
            5 => "hexahedra",
            6 => "prisms",
            7 => "pyramids",
            10 | 16 => "second-order quadrangles",
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
            Self::Line(Order::First) => 2,
            Self::Line(Order::Second) | Self::Triangle(Order::First) => 3,
            Self::Triangle(Order::Second) => 6,
            Self::Tetrahedron(Order::First) => 4,
            Self::Tetrahedron(Order::Second) => 10,
        }
    }
}
