//! A small format with every kind, and a stage writer for it.

use std::path::{Path, PathBuf};

use tempfile::TempDir;
use units::{Dimension, Units};

use crate::{
    DatasetSpec, EnumSpec, Extent, Home, IfMissing, Kind, Layout, Reader, RunFile, SparseMatrix,
    Stage, StageRecord, StageWriter, StoreError, StoredEnum, Transaction, stored_enum,
};

stored_enum! {
    /// A state.
    pub(super) enum Zone as "zone" {
        /// Apart.
        Open = 0 => "open",
        /// At rest.
        Stick = 1 => "stick",
        /// In motion.
        Slip = 2 => "slip",
    }
}

const NODES: Extent = Extent::Named("n_nodes");
const CELLS: Extent = Extent::Named("n_cells");
const ZONE: &EnumSpec = Zone::SPEC;

const MESH: &[DatasetSpec] = &[
    Stage::Mesh
        .row(
            "/mesh/coordinates",
            Kind::F64,
            &[NODES, Extent::Fixed(3)],
            Dimension::LENGTH,
            "Positions.",
        )
        .symbol("x")
        .compressed(),
    Stage::Mesh
        .row(
            "/mesh/cells",
            Kind::I64,
            &[CELLS, Extent::Fixed(4)],
            Dimension::Number,
            "Corners.",
        )
        .compressed(),
    Stage::Mesh.row(
        "/mesh/offsets",
        Kind::I64,
        &[Extent::Plus("n_cells", 1)],
        Dimension::Number,
        "Starts.",
    ),
    Stage::Mesh
        .row("/mesh/tags", Kind::U8, &[CELLS], Dimension::Number, "Tags.")
        .compressed(),
    Stage::Mesh.row(
        "/mesh/names",
        Kind::Text,
        &[Extent::Named("n_names")],
        Dimension::Number,
        "Names.",
    ),
    Stage::Mesh
        .row("/mesh/title", Kind::Text, &[], Dimension::Number, "Title.")
        .optional("a mesh may be unnamed"),
];

const SOLVE: &[DatasetSpec] = &[
    Stage::Solve.row(
        "/solve/zone",
        Kind::Enum(ZONE),
        &[NODES],
        Dimension::Number,
        "States.",
    ),
    Stage::Solve
        .row(
            "/solve/stiffness",
            Kind::CscMatrix,
            &[NODES, NODES],
            Dimension::STIFFNESS,
            "Stiffness.",
        )
        .symbol("A"),
    Stage::Solve
        .row(
            "/solve/coupling",
            Kind::CsrMatrix,
            &[CELLS, NODES],
            Dimension::Number,
            "Coupling.",
        )
        .compressed(),
    Stage::Solve.row(
        "/solve/energy",
        Kind::F64,
        &[],
        Dimension::Energy,
        "Energy.",
    ),
    Stage::Solve
        .row(
            "/solve/history/seconds",
            Kind::F64,
            &[Extent::Named("n_outer")],
            Dimension::Time,
            "Times.",
        )
        .volatile(),
];

/// The sample format.
pub(super) const SAMPLE: Layout = Layout {
    filetype: "sample run",
    linked_filetype: "sample stage",
    format_version: [1, 2],
    creator: "sample 0.1",
    units: Units::SI,
    tables: &[MESH, SOLVE],
    extents: &[
        ("n_nodes", "number of nodes"),
        ("n_cells", "number of cells"),
        ("n_names", "number of names"),
        ("n_outer", "number of outer iterations"),
    ],
};

pub(super) fn folder() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.h5");
    (folder, file)
}

pub(super) fn record() -> StageRecord {
    StageRecord {
        settings: "epsilon = 1e-4\n".into(),
        input_digest: "abc".into(),
        seconds: 0.25,
        threads: 2,
        date: "2026-01-02T03:04:05Z".into(),
    }
}

pub(super) fn coordinates(n_nodes: usize) -> Vec<f64> {
    (0..3 * n_nodes).map(|index| (index as f64).sin()).collect()
}

pub(super) fn write_mesh(
    mut writer: StageWriter<'_>,
    n_nodes: usize,
) -> Result<String, StoreError> {
    writer.write("/mesh/coordinates", &coordinates(n_nodes), &[n_nodes, 3])?;
    writer.write_indices("/mesh/cells", &[0, 1, 2, 3, 1, 2, 3, 4], &[2, 4])?;
    writer.write("/mesh/offsets", &[0_i64, 4, 8], &[3])?;
    writer.write("/mesh/tags", &[7_u8, 9], &[2])?;
    writer.write_texts("/mesh/names", &["clamp", "Öffnung", ""])?;
    writer.finish(&record())
}

pub(super) fn stiffness(n: usize) -> SparseMatrix {
    SparseMatrix {
        shape: [n, n],
        indptr: (0..=n).collect(),
        indices: (0..n).collect(),
        data: vec![2.5; n],
    }
}

pub(super) fn coupling(n: usize) -> SparseMatrix {
    SparseMatrix {
        shape: [2, n],
        indptr: vec![0, 2, 2],
        indices: vec![0, 3],
        data: vec![1.0, -1.0],
    }
}

pub(super) fn zones(n: usize) -> Vec<Zone> {
    (0..n)
        .map(|node| [Zone::Open, Zone::Stick, Zone::Slip][node % 3])
        .collect()
}

pub(super) fn write_solve(
    mut writer: StageWriter<'_>,
    n: usize,
    seconds: &[f64],
) -> Result<String, StoreError> {
    writer.write_enum("/solve/zone", &zones(n), &[n])?;
    writer.write_matrix("/solve/stiffness", stiffness(n).view())?;
    writer.write_matrix("/solve/coupling", coupling(n).view())?;
    writer.write("/solve/energy", &[-12.5], &[])?;
    writer.write("/solve/history/seconds", seconds, &[seconds.len()])?;
    writer.finish(&record())
}

pub(super) fn lock(file: &Path) -> Result<RunFile, StoreError> {
    RunFile::lock(file, SAMPLE, IfMissing::Create)
}

pub(super) fn save_mesh(file: &Path, n_nodes: usize) -> String {
    let lock = lock(file).unwrap();
    let mut transaction = Transaction::begin(&lock).unwrap();
    let digest = write_mesh(
        transaction.stage(Stage::Mesh, Home::RunFile).unwrap(),
        n_nodes,
    )
    .unwrap();
    transaction.commit().unwrap();
    digest
}

pub(super) fn save_solve(file: &Path, n_nodes: usize, seconds: &[f64]) -> String {
    let lock = lock(file).unwrap();
    let mut transaction = Transaction::begin(&lock).unwrap();
    let digest = write_solve(
        transaction.stage(Stage::Solve, Home::RunFile).unwrap(),
        n_nodes,
        seconds,
    )
    .unwrap();
    transaction.commit().unwrap();
    digest
}

pub(super) fn open(file: &Path) -> Result<Reader, StoreError> {
    Reader::open(file, SAMPLE)
}
