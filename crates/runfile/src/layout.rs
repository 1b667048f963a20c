//! The table of a file format: its vocabulary, all its rows, and the rules that it must obey.

use std::collections::BTreeSet;
use std::fmt;

use units::{Dimension, Units};

/// A group of the root that is written, and gets out of date, as one.
///
/// A program lists its groups in [`crate::Layout::groups`], each after those it builds on. To its
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
    /// The named size in this extent, if there is one, and what is added to it.
    #[must_use]
    pub const fn named(self) -> Option<(&'static str, usize)> {
        match self {
            Extent::Fixed(_) | Extent::Labelled(_) => None,
            Extent::Named(name) => Some((name, 0)),
            Extent::Plus(name, more) => Some((name, more)),
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
    /// Chunked, shuffled and gzipped where they are more than 16 KiB: meshes and indices.
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

/// A file format: its identity and every dataset it knows.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Value of the root attribute `filetype`.
    pub filetype: &'static str,
    /// Value of the root attribute `filetype` of a file beside the run file that holds one group.
    pub linked_filetype: &'static str,
    /// Value of the root attribute `format_version`: major, minor.
    pub format_version: [i64; 2],
    /// Value of the root attribute `creator`: program and version.
    pub creator: &'static str,
    /// The groups a file of this format can hold, each after those it builds on.
    pub groups: &'static [Group],
    /// The rows of all groups.
    pub tables: &'static [&'static [DatasetSpec]],
    /// The units that numbers are written in.
    pub units: Units,
    /// Every symbolic size with its meaning.
    pub extents: &'static [(&'static str, &'static str)],
}

impl Layout {
    /// The same format for numbers in other units.
    #[must_use]
    pub const fn in_units(self, units: Units) -> Self {
        Layout { units, ..self }
    }

    /// Every group, each after those it builds on.
    pub fn groups(&self) -> impl Iterator<Item = Group> + use<> {
        self.groups.iter().copied()
    }

    /// The groups that a group may build on.
    pub(super) fn upstream_of(&self, group: Group) -> impl Iterator<Item = Group> + use<> {
        self.groups().take_while(move |other| *other != group)
    }

    /// Every row, in the order of the table.
    pub fn datasets(&self) -> impl Iterator<Item = &'static DatasetSpec> + use<> {
        self.tables.iter().flat_map(|table| table.iter())
    }

    /// The row of a path.
    #[must_use]
    pub fn find(&self, path: &str) -> Option<&'static DatasetSpec> {
        self.datasets().find(|spec| spec.path == path)
    }

    /// The rows of one group.
    pub fn of_group(&self, group: Group) -> impl Iterator<Item = &'static DatasetSpec> + use<> {
        self.datasets().filter(move |spec| spec.group == group)
    }

    /// Every breach of the rules of the table, one sentence each; empty for a sound table.
    ///
    /// Rules: groups are listed once; paths are unique, below their group, which is listed, and not
    /// inside one another; meanings are given; matrices have two extents and texts at most one;
    /// enumerations have distinct names and codes; every symbolic size is explained, and every
    /// explained one is used.
    #[must_use]
    pub fn problems(&self) -> Vec<String> {
        let mut problems = self.group_problems();
        let mut paths = BTreeSet::new();
        for spec in self.datasets() {
            if !paths.insert(spec.path) {
                problems.push(format!("{}: listed twice", spec.path));
            }
            problems.extend(
                row_problems(spec)
                    .into_iter()
                    .map(|problem| format!("{}: {problem}", spec.path)),
            );
        }
        for spec in self.datasets() {
            let inside = format!("{}/", spec.path);
            if self.datasets().any(|other| other.path.starts_with(&inside)) {
                problems.push(format!("{}: another dataset lies inside it", spec.path));
            }
        }
        problems.extend(self.extent_problems());
        problems
    }

    fn group_problems(&self) -> Vec<String> {
        let mut names = BTreeSet::new();
        let twice = self.groups().filter(|group| !names.insert(group.name()));
        let mut problems: Vec<_> = twice
            .map(|group| format!("/{group}: listed twice"))
            .collect();
        let is_listed = |spec: &&DatasetSpec| self.groups.contains(&spec.group);
        let strangers = self.datasets().filter(|spec| !is_listed(spec));
        problems.extend(strangers.map(|spec| format!("{}: its group is not listed", spec.path)));
        problems
    }

    fn extent_problems(&self) -> Vec<String> {
        let extents = self.datasets().flat_map(|spec| spec.shape);
        let used: BTreeSet<_> = extents.filter_map(|it| it.named()).map(|it| it.0).collect();
        let explained: BTreeSet<_> = self.extents.iter().map(|(name, _)| *name).collect();
        let problem = |name: &&str| {
            let what = if used.contains(name) {
                "not explained"
            } else {
                "explained but not used"
            };
            format!("size {name} is {what}")
        };
        used.symmetric_difference(&explained).map(problem).collect()
    }
}

fn row_problems(spec: &DatasetSpec) -> Vec<&'static str> {
    let rank_fits = match spec.kind {
        Kind::CscMatrix | Kind::CsrMatrix => spec.shape.len() == 2,
        Kind::Text => spec.shape.len() <= 1,
        _ => true,
    };
    let members_distinct = match spec.kind {
        Kind::Enum(members) => {
            let names: BTreeSet<_> = members.members.iter().map(|(name, _)| name).collect();
            let codes: BTreeSet<_> = members.members.iter().map(|(_, code)| code).collect();
            names.len() == members.members.len() && codes.len() == members.members.len()
        }
        _ => true,
    };
    [
        (
            spec.name() == spec.path || spec.name().is_empty(),
            "not below its group",
        ),
        (spec.description.is_empty(), "has no meaning"),
        (
            spec.presence == Presence::Optional(""),
            "is optional without a reason",
        ),
        (!rank_fits, "has a rank its kind cannot have"),
        (!members_distinct, "has members with equal names or codes"),
    ]
    .into_iter()
    .filter_map(|(broken, problem)| broken.then_some(problem))
    .collect()
}
