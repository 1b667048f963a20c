//! The vocabulary of the dataset table: stages, kinds, symbolic shapes, presence, storage.

use std::fmt;

use units::Dimension;

/// A step of the pipeline; each owns one group of the file, in the order data flows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// The validated input, group `/scene`.
    Scene,
    /// Mesh, boundary and panes, group `/mesh`.
    Mesh,
    /// Matrices and the factor, group `/assemble`.
    Assemble,
    /// Loads and what follows from them linearly, group `/load`.
    Load,
    /// Multipliers, displacement and history, group `/solve`.
    Solve,
    /// Stresses, zones, resultants and the certificate, group `/post`.
    Post,
    /// The same results as ParaView reads them, group `/VTKHDF`.
    Vtk,
    /// How far an unfinished solve has come, group `/checkpoint`.
    Checkpoint,
    /// The table of a sweep, group `/cases` of a file of its own.
    Cases,
    /// Errors and costs of solvers and meshes, group `/accuracy`; computed from the scene alone.
    Accuracy,
    /// How far the answers of hard cases can be trusted, group `/stability` of a file of its own.
    Stability,
}

impl Stage {
    /// Every stage, upstream first.
    pub const ALL: [Stage; 11] = [
        Stage::Scene,
        Stage::Mesh,
        Stage::Assemble,
        Stage::Load,
        Stage::Solve,
        Stage::Post,
        Stage::Vtk,
        Stage::Checkpoint,
        Stage::Cases,
        Stage::Accuracy,
        Stage::Stability,
    ];

    /// The name of the group this stage owns, without the leading slash.
    pub const fn group(self) -> &'static str {
        match self {
            Stage::Scene => "scene",
            Stage::Mesh => "mesh",
            Stage::Assemble => "assemble",
            Stage::Load => "load",
            Stage::Solve => "solve",
            Stage::Post => "post",
            Stage::Vtk => "VTKHDF",
            Stage::Checkpoint => "checkpoint",
            Stage::Cases => "cases",
            Stage::Accuracy => "accuracy",
            Stage::Stability => "stability",
        }
    }

    /// A row of the table: a required, plainly stored dataset of this stage without symbol.
    pub const fn row(
        self,
        path: &'static str,
        kind: Kind,
        shape: &'static [Extent],
        dimension: Dimension,
        description: &'static str,
    ) -> DatasetSpec {
        DatasetSpec {
            path,
            stage: self,
            kind,
            shape,
            dimension,
            symbol: "",
            description,
            presence: Presence::Required,
            storage: Storage::Plain,
            volatile: false,
        }
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.group())
    }
}

/// The members of an HDF5 enumeration over `u8`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EnumSpec {
    /// What the enumeration is called in the schema.
    pub name: &'static str,
    /// Member names and codes as they stand in the file.
    pub members: &'static [(&'static str, u8)],
}

/// The type of a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// IEEE double, little endian.
    F64,
    /// 64-bit signed integer, little endian.
    I64,
    /// 8-bit unsigned integer.
    U8,
    /// Variable-length UTF-8 string.
    Text,
    /// HDF5 enumeration over `u8`.
    Enum(&'static EnumSpec),
    /// Group `{data, indices, indptr}` of a matrix compressed by columns.
    CscMatrix,
    /// Group `{data, indices, indptr}` of a matrix compressed by rows.
    CsrMatrix,
}

impl Kind {
    /// The word that names this kind in digests and schemas.
    pub const fn tag(self) -> &'static str {
        match self {
            Kind::F64 => "f64",
            Kind::I64 => "i64",
            Kind::U8 => "u8",
            Kind::Text => "text",
            Kind::Enum(_) => "enum",
            Kind::CscMatrix => "csc_matrix",
            Kind::CsrMatrix => "csr_matrix",
        }
    }

    /// Whether the dataset is a group that holds a sparse matrix.
    pub const fn is_matrix(self) -> bool {
        matches!(self, Kind::CscMatrix | Kind::CsrMatrix)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Kind::Enum(spec) => {
                write!(f, "enum {} {{", spec.name)?;
                for (index, (name, code)) in spec.members.iter().enumerate() {
                    let comma = if index == 0 { "" } else { ", " };
                    write!(f, "{comma}{name} = {code}")?;
                }
                f.write_str("}")
            }
            kind => f.write_str(kind.tag()),
        }
    }
}

/// One extent of a shape: a number, or a size of the problem known by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// Always this many.
    Fixed(usize),
    /// A size of the problem, such as `n_nodes`, the same wherever the name stands.
    Named(&'static str),
    /// A named size plus a constant, such as the `n_cells + 1` offsets of `n_cells` lists.
    Plus(&'static str, usize),
}

impl Extent {
    /// The symbolic name in this extent, if there is one.
    pub const fn name(self) -> Option<&'static str> {
        match self {
            Extent::Fixed(_) => None,
            Extent::Named(name) | Extent::Plus(name, _) => Some(name),
        }
    }
}

impl fmt::Display for Extent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Extent::Fixed(size) => write!(f, "{size}"),
            Extent::Named(name) => f.write_str(name),
            Extent::Plus(name, more) => write!(f, "{name} + {more}"),
        }
    }
}

/// Whether a finished stage always holds a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// A finished stage always holds it.
    Required,
    /// It may be missing, for the stated reason.
    Optional(&'static str),
}

/// How the bytes of a dataset lie in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// Contiguous: large factors and small vectors.
    Plain,
    /// Chunked, shuffled and gzipped: meshes and indices.
    Compressed,
}

/// One row of the table: everything that is promised about a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DatasetSpec {
    /// Absolute path, such as `/mesh/coordinates`.
    pub path: &'static str,
    /// The only stage that writes it.
    pub stage: Stage,
    /// Type of the values.
    pub kind: Kind,
    /// Symbolic shape; empty for a scalar; rows and columns for a matrix.
    pub shape: &'static [Extent],
    /// What the values are measured in; the units of the file make the word of it.
    pub dimension: Dimension,
    /// Symbol of the quantity in the model, empty if it has none.
    pub symbol: &'static str,
    /// Meaning in one sentence.
    pub description: &'static str,
    /// Whether it may be missing.
    pub presence: Presence,
    /// How its bytes lie in the file.
    pub storage: Storage,
    /// Timings and the like: written, but left out of the digest of the stage.
    pub volatile: bool,
}

impl DatasetSpec {
    /// The same row with the symbol of the quantity.
    pub const fn symbol(self, symbol: &'static str) -> Self {
        DatasetSpec { symbol, ..self }
    }

    /// The same row, allowed to be missing for the stated reason.
    pub const fn optional(self, reason: &'static str) -> Self {
        DatasetSpec {
            presence: Presence::Optional(reason),
            ..self
        }
    }

    /// The same row, stored chunked, shuffled and gzipped.
    pub const fn compressed(self) -> Self {
        DatasetSpec {
            storage: Storage::Compressed,
            ..self
        }
    }

    /// The same row, left out of the digest of the stage.
    pub const fn volatile(self) -> Self {
        DatasetSpec {
            volatile: true,
            ..self
        }
    }

    /// The path below the group of the stage.
    pub fn name(&self) -> &'static str {
        self.path
            .strip_prefix('/')
            .and_then(|path| path.strip_prefix(self.stage.group()))
            .and_then(|path| path.strip_prefix('/'))
            .unwrap_or(self.path)
    }
}
