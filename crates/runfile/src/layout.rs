//! The vocabulary of the dataset table: groups, kinds, symbolic shapes, presence, storage.

use std::fmt;

use units::Dimension;

/// A group of the root that is written, and gets out of date, as one.
///
/// A program lists its groups in [`super::Layout::groups`], each after those it builds on. To its
/// users a group is a stage, which is what schemas call it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Group {
    name: &'static str,
    writer: &'static str,
}

impl Group {
    /// The group `/name`, which a user gets again by running `writer`.
    #[must_use]
    pub const fn new(name: &'static str, writer: &'static str) -> Self {
        Group { name, writer }
    }

    /// The name of the group, without the leading slash.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.name
    }

    /// What a user runs to have the group written again.
    #[must_use]
    pub const fn writer(self) -> &'static str {
        self.writer
    }

    /// A row of the table: a required, plainly stored dataset of this group, without symbol.
    #[must_use]
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
            group: self,
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

impl fmt::Display for Group {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
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
    /// IEEE single, little endian.
    F32,
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
    #[must_use]
    pub const fn tag(self) -> &'static str {
        match self {
            Kind::F64 => "f64",
            Kind::F32 => "f32",
            Kind::I64 => "i64",
            Kind::U8 => "u8",
            Kind::Text => "text",
            Kind::Enum(_) => "enum",
            Kind::CscMatrix => "csc_matrix",
            Kind::CsrMatrix => "csr_matrix",
        }
    }

    /// Whether the dataset is a group that holds a sparse matrix.
    #[must_use]
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
    /// Always as many as there are labels, each entry known by its own.
    Labelled(&'static Axis),
    /// A size of the problem, such as `n_nodes`, the same wherever the name stands.
    Named(&'static str),
    /// A named size plus a constant, such as the `n_cells + 1` offsets of `n_cells` lists.
    Plus(&'static str, usize),
}

/// An axis whose entries have names, such as x, y, z.
#[derive(Debug, PartialEq, Eq)]
pub struct Axis {
    /// What the axis is called.
    pub name: &'static str,
    /// One label for each entry.
    pub labels: &'static [&'static str],
}

impl Extent {
    /// The symbolic name in this extent, if there is one.
    #[must_use]
    pub const fn name(self) -> Option<&'static str> {
        match self {
            Extent::Fixed(_) | Extent::Labelled(_) => None,
            Extent::Named(name) | Extent::Plus(name, _) => Some(name),
        }
    }
}

impl fmt::Display for Extent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Extent::Fixed(size) => write!(f, "{size}"),
            Extent::Labelled(axis) => write!(f, "{}", axis.labels.len()),
            Extent::Named(name) => f.write_str(name),
            Extent::Plus(name, more) => write!(f, "{name} + {more}"),
        }
    }
}

/// Whether a finished group always holds a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// A finished group always holds it.
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
    /// The only group that writes it.
    pub group: Group,
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
    /// Timings and the like: written, but left out of the digest of the group.
    pub volatile: bool,
}

impl DatasetSpec {
    /// The same row with the symbol of the quantity.
    #[must_use]
    pub const fn symbol(self, symbol: &'static str) -> Self {
        DatasetSpec { symbol, ..self }
    }

    /// The same row, allowed to be missing for the stated reason.
    #[must_use]
    pub const fn optional(self, reason: &'static str) -> Self {
        DatasetSpec {
            presence: Presence::Optional(reason),
            ..self
        }
    }

    /// The same row, stored chunked, shuffled and gzipped.
    #[must_use]
    pub const fn compressed(self) -> Self {
        DatasetSpec {
            storage: Storage::Compressed,
            ..self
        }
    }

    /// The same row, left out of the digest of the group.
    #[must_use]
    pub const fn volatile(self) -> Self {
        DatasetSpec {
            volatile: true,
            ..self
        }
    }

    /// The path below the group of the group.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.path
            .strip_prefix('/')
            .and_then(|path| path.strip_prefix(self.group.name()))
            .and_then(|path| path.strip_prefix('/'))
            .unwrap_or(self.path)
    }
}
