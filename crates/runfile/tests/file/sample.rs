//! A small format with every kind, and a group writer for it.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;
use units::{Dimension, Units};

use contact3d_runfile::{
    DatasetSpec, EnumSpec, Extent, Group, GroupRecord, GroupWriter, IfMissing, Kind, Layout,
    Reader, RunFile, SparseMatrix, StoreError, StoredEnum, Transaction, stored_enum,
};

stored_enum! {
    /// A state.
    pub(crate) enum State as "state" {
        /// Apart.
        Open = 0 => "open",
        /// At rest.
        Stick = 1 => "stick",
        /// In motion.
        Slip = 2 => "slip",
    }
}

/// The temporary files of a folder.
pub(crate) fn hidden(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let is_hidden = |path: &PathBuf| path.to_string_lossy().contains(".part");
    paths.filter(is_hidden).collect()
}

/// A first group.
pub(crate) const GRID: Group = Group::new("grid", "draw");
/// A group that builds on the first.
pub(crate) const FIELD: Group = Group::new("field", "compute");
/// A group without datasets, described by attributes alone.
pub(crate) const NOTES: Group = Group::new("notes", "compute");

const NODES: Extent = Extent::Named("n_nodes");
const CELLS: Extent = Extent::Named("n_cells");
const STATE: &EnumSpec = State::SPEC;

const GRID_TABLE: &[DatasetSpec] = &[
    GRID.row(
        "/grid/coordinates",
        Kind::F64,
        &[NODES, Extent::Fixed(3)],
        Dimension::LENGTH,
        "Positions.",
    )
    .symbol("x")
    .compressed(),
    GRID.row(
        "/grid/cells",
        Kind::I64,
        &[CELLS, Extent::Fixed(4)],
        Dimension::Number,
        "Corners.",
    )
    .compressed(),
    GRID.row(
        "/grid/offsets",
        Kind::I64,
        &[Extent::Plus("n_cells", 1)],
        Dimension::Number,
        "Starts.",
    ),
    GRID.row("/grid/tags", Kind::U8, &[CELLS], Dimension::Number, "Tags.")
        .compressed(),
    GRID.row(
        "/grid/names",
        Kind::Text,
        &[Extent::Named("n_names")],
        Dimension::Number,
        "Names.",
    ),
    GRID.row("/grid/title", Kind::Text, &[], Dimension::Number, "Title.")
        .optional("a grid may be unnamed"),
];

const FIELD_TABLE: &[DatasetSpec] = &[
    FIELD.row(
        "/field/zone",
        Kind::Enum(STATE),
        &[NODES],
        Dimension::Number,
        "States.",
    ),
    FIELD
        .row(
            "/field/stiffness",
            Kind::CscMatrix,
            &[NODES, NODES],
            Dimension::STIFFNESS,
            "Stiffness.",
        )
        .symbol("A"),
    FIELD
        .row(
            "/field/coupling",
            Kind::CsrMatrix,
            &[CELLS, NODES],
            Dimension::Number,
            "Coupling.",
        )
        .compressed(),
    FIELD.row(
        "/field/energy",
        Kind::F64,
        &[],
        Dimension::Energy,
        "Energy.",
    ),
    FIELD
        .row(
            "/field/history/seconds",
            Kind::F64,
            &[Extent::Named("n_outer")],
            Dimension::Time,
            "Times.",
        )
        .volatile(),
];

/// The sample format.
pub(crate) const SAMPLE: Layout = Layout {
    filetype: "sample run",
    linked_filetype: "sample stage",
    format_version: [1, 2],
    creator: "sample 0.1",
    units: Units::SI,
    groups: &[GRID, FIELD, NOTES],
    tables: &[GRID_TABLE, FIELD_TABLE],
    extents: &[
        ("n_nodes", "number of nodes"),
        ("n_cells", "number of cells"),
        ("n_names", "number of names"),
        ("n_outer", "number of outer iterations"),
    ],
};

pub(crate) fn folder() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.h5");
    (folder, file)
}

pub(crate) fn record() -> GroupRecord {
    GroupRecord {
        settings: "epsilon = 1e-4\n".into(),
        input_digest: "abc".into(),
        seconds: 0.25,
        threads: 2,
        date: "2026-01-02T03:04:05Z".into(),
    }
}

pub(crate) fn coordinates(n_nodes: usize) -> Vec<f64> {
    (0..3 * n_nodes).map(|index| (index as f64).sin()).collect()
}

pub(crate) fn write_grid(
    mut writer: GroupWriter<'_>,
    n_nodes: usize,
) -> Result<String, StoreError> {
    writer.write("/grid/coordinates", &coordinates(n_nodes), &[n_nodes, 3])?;
    writer.write_indices("/grid/cells", &[0, 1, 2, 3, 1, 2, 3, 4], &[2, 4])?;
    writer.write("/grid/offsets", &[0_i64, 4, 8], &[3])?;
    writer.write("/grid/tags", &[7_u8, 9], &[2])?;
    writer.write_texts("/grid/names", &["clamp", "Öffnung", ""])?;
    writer.finish(&record())
}

pub(crate) fn stiffness(n: usize) -> SparseMatrix {
    SparseMatrix {
        shape: [n, n],
        indptr: (0..=n).collect(),
        indices: (0..n).collect(),
        data: vec![2.5; n],
    }
}

pub(crate) fn coupling(n: usize) -> SparseMatrix {
    SparseMatrix {
        shape: [2, n],
        indptr: vec![0, 2, 2],
        indices: vec![0, 3],
        data: vec![1.0, -1.0],
    }
}

pub(crate) fn states(n: usize) -> Vec<State> {
    (0..n)
        .map(|node| [State::Open, State::Stick, State::Slip][node % 3])
        .collect()
}

pub(crate) fn write_field(
    mut writer: GroupWriter<'_>,
    n: usize,
    seconds: &[f64],
) -> Result<String, StoreError> {
    writer.write_enum("/field/zone", &states(n), &[n])?;
    writer.write_matrix("/field/stiffness", stiffness(n).view())?;
    writer.write_matrix("/field/coupling", coupling(n).view())?;
    writer.write("/field/energy", &[-12.5], &[])?;
    writer.write("/field/history/seconds", seconds, &[seconds.len()])?;
    writer.finish(&record())
}

pub(crate) fn lock(file: &Path) -> Result<RunFile, StoreError> {
    RunFile::lock(file, SAMPLE, IfMissing::Create)
}

/// Changes a file in one step.
pub(crate) fn change<T>(file: &Path, change: impl FnOnce(&mut Transaction) -> T) -> T {
    let lock = lock(file).unwrap();
    let mut transaction = Transaction::begin(&lock).unwrap();
    let done = change(&mut transaction);
    transaction.commit().unwrap();
    done
}

pub(crate) fn save_grid(file: &Path, n_nodes: usize) -> String {
    change(file, |transaction| {
        write_grid(transaction.group(GRID).unwrap(), n_nodes).unwrap()
    })
}

pub(crate) fn save_field(file: &Path, n_nodes: usize, seconds: &[f64]) -> String {
    change(file, |transaction| {
        let writer = transaction.group(FIELD).unwrap();
        write_field(writer, n_nodes, seconds).unwrap()
    })
}

pub(crate) fn open(file: &Path) -> Result<Reader, StoreError> {
    Reader::open(file, SAMPLE)
}

/// The coordinates that a file holds.
pub(crate) fn coordinates_in(file: &Path) -> Vec<f64> {
    open(file).unwrap().read_vec("/grid/coordinates").unwrap()
}

/// The stiffness that a file holds.
pub(crate) fn stiffness_in(file: &Path) -> SparseMatrix {
    open(file).unwrap().read_matrix("/field/stiffness").unwrap()
}

/// Lets a file that was changed begin with the digest of its bytes, as if it had been written so.
pub(crate) fn fit_digest(file: &Path) {
    let mut bytes = fs::read(file).unwrap();
    let digest = blake3::hash(&bytes[512..]).to_hex();
    let line = bytes.split(|byte| *byte == b'\n').take(2);
    let start: usize = line.map(|line| line.len() + 1).sum();
    bytes[start..start + 64].copy_from_slice(digest.as_bytes());
    fs::write(file, bytes).unwrap();
}
