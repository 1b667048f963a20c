//! Why a Gmsh file cannot be used, with the place in the file.

use std::{fmt, path::PathBuf};

use miette::Diagnostic;
use thiserror::Error;

/// Where something stands in a mesh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FilePosition {
    /// Line of a text file, from 1.
    Line(usize),
    /// Byte of a binary file, from 0.
    Byte(usize),
}

impl fmt::Display for FilePosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// Why a Gmsh mesh cannot be used; element and node tags are those of the file.
#[derive(Debug, Error, Diagnostic)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum GmshError {
    /// The file cannot be read.
    #[error("cannot read the mesh {}: {source}", path.display())]
    #[diagnostic(help("the path counts from the folder of the scene file"))]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    /// The file is not the one the scene means.
    #[error("{}: expected the blake3 digest {expected}, found {found}", path.display())]
    #[diagnostic(help(
        "the mesh has changed since its digest was written down; check it and update the digest"
    ))]
    Digest {
        path: PathBuf,
        expected: String,
        found: String,
    },
    /// The unit of the file is no length.
    #[error("unit of the mesh: expected a positive length, found {found}")]
    #[diagnostic(help(
        "a mesh in millimetres has unit 0.001 in a scene in metres; coordinates times the unit must stay finite"
    ))]
    Unit { found: f64 },
    /// What is wrong in the file of this path.
    #[error("{}: {flaw}", path.display())]
    #[diagnostic(forward(flaw))]
    InFile { path: PathBuf, flaw: Box<GmshError> },

    /// A version other than 2.2 and 4.1.
    #[error("{place}: expected MSH format 4.1 or 2.2, found {found}")]
    #[diagnostic(help("save it again: gmsh part.geo -3 -format msh41 -o part.msh"))]
    Version { place: FilePosition, found: String },
    /// A binary encoding that is not read.
    #[error("{place}: expected text or little-endian binary with data of 8 bytes, found {found}")]
    #[diagnostic(help(
        "save it as text, without -bin: gmsh part.geo -3 -format msh41 -o part.msh"
    ))]
    Encoding { place: FilePosition, found: String },
    /// Not the grammar of the format.
    #[error("{place}: expected {expected}, found {found}")]
    #[diagnostic(help(
        "the file is damaged or not an MSH file; save it again: gmsh part.geo -3 -format msh41 -o part.msh"
    ))]
    Syntax {
        place: FilePosition,
        expected: String,
        found: String,
    },
    /// More items are declared than the rest of the file can hold.
    #[error(
        "{place}: expected at most {possible} {what} in the rest of the file, found the count {declared}"
    )]
    #[diagnostic(help(
        "the file is cut off or its counts are wrong; save it again: gmsh part.geo -3 -format msh41 -o part.msh"
    ))]
    Count {
        place: FilePosition,
        what: &'static str,
        declared: u64,
        possible: u64,
    },
    /// A section that every mesh has is not there.
    #[error("expected a section ${section}, found none")]
    #[diagnostic(help("the file is cut off or not an MSH file with nodes and elements"))]
    MissingSection { section: &'static str },
    /// A section that may stand once is there twice.
    #[error("{place}: expected one section ${section}, found a second one")]
    #[diagnostic(help("two meshes stand in one file; merge them in Gmsh and save once"))]
    RepeatedSection {
        place: FilePosition,
        section: &'static str,
    },

    /// Two groups of the same dimension have the same name.
    #[error("expected different names of the physical {kind}, found {name:?} twice")]
    #[diagnostic(help(
        "rename one; a group without a name is called by its number, and what is in no group is called \"unnamed\""
    ))]
    RepeatedName { kind: &'static str, name: String },
    /// A coordinate is infinite or not a number.
    #[error("{place}: node {node}: expected finite coordinates, found {found}")]
    #[diagnostic(help("mesh the geometry again"))]
    NotFinite {
        place: FilePosition,
        node: u64,
        found: f64,
    },
    /// Two nodes have the same tag.
    #[error("{place}: expected every node once, found node {node} again")]
    #[diagnostic(help("renumber the mesh in Gmsh: Mesh > Renumber, or RenumberMeshNodes"))]
    RepeatedTag { place: FilePosition, node: u64 },
    /// An element that is not a linear tetrahedron, triangle, line or point.
    #[error(
        "{place}: expected linear tetrahedra and triangles, found {name} (element type {code})"
    )]
    #[diagnostic(help(
        "only linear tetrahedra are used: mesh without Recombine and save with gmsh part.geo -3 -order 1"
    ))]
    ElementType {
        place: FilePosition,
        code: i64,
        name: &'static str,
    },
    /// Elements of an entity that is not listed.
    #[error(
        "{place}: expected an entity of $Entities, found entity {entity} of dimension {dimension}"
    )]
    #[diagnostic(help(
        "partitioned meshes are not read: save the mesh without partitions (Unpartition)"
    ))]
    UnknownEntity {
        place: FilePosition,
        dimension: i64,
        entity: i64,
    },
    /// An element uses a node that is not listed.
    #[error("{place}: element {element}: expected nodes of $Nodes, found node {node}")]
    #[diagnostic(help("the file is damaged; save it again"))]
    UnknownNode {
        place: FilePosition,
        element: u64,
        node: u64,
    },
    /// An element uses a node twice.
    #[error("{place}: element {element}: expected different nodes, found node {node} twice")]
    #[diagnostic(help("the element is degenerate; mesh the geometry again, or a little coarser"))]
    RepeatedNode {
        place: FilePosition,
        element: u64,
        node: u64,
    },

    /// There is no body.
    #[error("expected tetrahedra, found none")]
    #[diagnostic(help(
        "mesh the volume (gmsh -3); when there are physical groups, Gmsh saves only elements in them: add a Physical Volume"
    ))]
    NoTetrahedra,
    /// A tetrahedron has no volume.
    #[error(
        "{place}: tetrahedron {element}: expected a volume, found {ratio:.1e} of its longest edge cubed, which is rounding"
    )]
    #[diagnostic(help(
        "the tetrahedron is flat; optimise the mesh (gmsh -optimize) or mesh again"
    ))]
    Degenerate {
        place: FilePosition,
        element: u64,
        ratio: f64,
    },
    /// Some tetrahedra are inverted.
    #[error(
        "{place}: tetrahedron {element}: expected the orientation of the others, found it inverted ({inverted} of {total} are)"
    )]
    #[diagnostic(help(
        "the mesh folds over itself there; optimise it (gmsh -optimize) or mesh again"
    ))]
    Inverted {
        place: FilePosition,
        element: u64,
        inverted: usize,
        total: usize,
    },
    /// Two tetrahedra have the same nodes.
    #[error(
        "{place}: tetrahedron {second}: expected its own nodes, found those of tetrahedron {first}"
    )]
    #[diagnostic(help("a volume was meshed or saved twice; remove the copy (Coherence Mesh)"))]
    DuplicateTetrahedron {
        place: FilePosition,
        first: u64,
        second: u64,
    },
    /// Two tetrahedra lie on the same side of a common triangle.
    #[error(
        "{place}: tetrahedron {second}: expected no overlap, found tetrahedron {first} on the same side of triangle {triangle:?}"
    )]
    #[diagnostic(help(
        "volumes overlap; make them parts of each other with BooleanFragments and mesh again"
    ))]
    Overlap {
        place: FilePosition,
        first: u64,
        second: u64,
        triangle: [u64; 3],
    },
    /// Tetrahedra of the first and of the second order.
    #[error(
        "{place}: expected tetrahedra of one order, found tetrahedron {element} of another one"
    )]
    #[diagnostic(help(
        "mesh the whole body with one order: gmsh part.geo -3 -order 2 -format msh41 -o part.msh"
    ))]
    MixedOrders { place: FilePosition, element: u64 },
    /// An edge has two nodes in its middle.
    #[error(
        "{place}: tetrahedron {element}: expected the node {known} in the middle of the edge from {first} to {second}, as in another tetrahedron, found {found}"
    )]
    #[diagnostic(help(
        "parts that touch are not joined: use BooleanFragments or Coherence before meshing"
    ))]
    EdgeNode {
        place: FilePosition,
        element: u64,
        first: u64,
        second: u64,
        known: u64,
        found: u64,
    },
    /// A curved tetrahedron is turned inside out somewhere.
    #[error(
        "{place}: tetrahedron {element}: expected a positive Jacobian everywhere, found {ratio:.1e} times that of its corners"
    )]
    #[diagnostic(help(
        "curve the mesh with care: gmsh part.geo -3 -order 2 -optimize_ho -format msh41 -o part.msh, or refine it where sides bend"
    ))]
    Folded {
        place: FilePosition,
        element: u64,
        ratio: f64,
    },
    /// Distinct nodes of the boundary coincide.
    #[error(
        "nodes {first} and {second}: expected different places, found them in the same place {at:?}"
    )]
    #[diagnostic(help(
        "parts that touch are not joined: use BooleanFragments or Coherence before meshing, or Coherence Mesh after it"
    ))]
    CoincidentNodes {
        first: u64,
        second: u64,
        at: [f64; 3],
    },
    /// A node lies on a triangle of the boundary of which it is no corner.
    #[error(
        "node {node}: expected a conforming mesh, found it on boundary triangle {triangle:?} of tetrahedron {element}"
    )]
    #[diagnostic(help(
        "parts that touch are meshed apart: join them with BooleanFragments or Coherence before meshing"
    ))]
    HangingNode {
        node: u64,
        triangle: [u64; 3],
        element: u64,
    },
    /// The body is not one piece.
    #[error(
        "expected one body, found {pieces} pieces not joined by whole triangles: tetrahedron {first} is in the largest, tetrahedron {other} in the smallest ({smallest} of {total} tetrahedra)"
    )]
    #[diagnostic(help(
        "a piece could move alone: join the pieces (BooleanUnion, BooleanFragments) or keep one of them"
    ))]
    Pieces {
        pieces: usize,
        first: u64,
        other: u64,
        smallest: usize,
        total: usize,
    },

    /// A triangle is in two physical surfaces.
    #[error(
        "{place}: triangle {element}: expected one physical surface, found {first:?} and {second:?}"
    )]
    #[diagnostic(help("take the surface out of one of the two groups"))]
    TwoSurfaces {
        place: FilePosition,
        element: u64,
        first: String,
        second: String,
    },
    /// A tetrahedron is in two physical volumes.
    #[error(
        "{place}: tetrahedron {element}: expected one physical volume, found {first:?} and {second:?}"
    )]
    #[diagnostic(help("take the volume out of one of the two groups"))]
    TwoVolumes {
        place: FilePosition,
        element: u64,
        first: String,
        second: String,
    },
    /// A physical surface has no triangle on the boundary of the body.
    #[error(
        "{place}: physical surface {name:?}: expected triangles on the boundary of the body, found none among its {triangles} (triangle {element} is the first)"
    )]
    #[diagnostic(help(
        "the surface lies inside the body or off it; name an outer surface, and check that its volume is in a physical group"
    ))]
    NotOnBoundary {
        place: FilePosition,
        name: String,
        triangles: usize,
        element: u64,
    },
}
