//! The stages, and the run file's datasets: one table per group, each beside its reader and writer.
//!
//! Writers fail as HDF5 does, readers also where a dataset is missing or altered, or contradicts another.

mod accuracy;
mod adapt;
mod assemble;
mod bound;
mod branches;
mod cases;
mod extents;
mod fields;
mod increments;
mod load;
mod mesh;
mod post;
mod quantities;
mod result_fields;
mod scene;
mod series;
mod solve;
mod stability;
mod stored;
mod vtkhdf;

use thiserror::Error;

pub use accuracy::{
    GROUP as ACCURACY, read as read_accuracy, read_advice, write as write_accuracy,
};
pub use adapt::{GROUP as ADAPT, read as read_adaptation, write as write_adaptation};
pub use assemble::{
    read as read_assembly, read_coupling, read_primal, stored_bytes as assembly_bytes,
    write as write_assembly,
};
pub use bound::{GROUP as BOUND, read as read_bound, write as write_bound};
pub use branches::{GROUP as BRANCHES, read as read_branches, write as write_branches};
pub use cases::{
    CERTIFICATE, CaseRow, GROUP as CASES, SWEEP_LAYOUT, TableOwner, read_case, read_table_owner,
    write as write_cases,
};
pub use extents::{StageSizes, read_sizes};
pub use increments::{
    GROUP as HISTORY, n_increments, read as read_history, write as write_history,
};
pub use load::{read as read_loads, write as write_loads};
pub use mesh::{read as read_mesh, write as write_mesh};
pub use post::{read_certificate, read_estimate, write as write_report};
pub use quantities::{
    dimension as dimension_of_quantity, read as read_functionals, write as write_functionals,
};
pub use result_fields::{FieldPlace, FieldShape, FieldView, RESULT_FIELDS, ResultState, VTKHDF};
pub use scene::{
    GROUP as SCENE, get_key, holds as holds_scene, read as read_scene, set_key,
    table as scene_table, table_of_text as scene_table_of_text, text as scene_text,
    write as write_scene,
};
pub use series::{
    GridSeries, SERIES_LAYOUT, SeriesCase, begin_path_series, begin_sweep_series, field_paths,
    step_sweep_series,
};
pub use solve::{
    CHECKPOINT, OutcomeWords, read as read_solution, read_checkpoint, read_multiplier,
    read_outcome, write as write_solution, write_checkpoint,
};
pub use stability::{GROUP as STABILITY, STABILITY_LAYOUT, StabilityRow, write as write_stability};
pub use vtkhdf::write as write_vtkhdf;

use contact3d::{
    linalg::{CscMatrix, EngineError, PartsError},
    scene::SceneError,
};
use runfile::{Group, Layout, SparseMatrix, SparseView, StoreError};
use units::Units;

units::worded! {
    /// A step of the pipeline: it computes one group from those of the stages before it.
    ///
    /// What a run file holds besides (the scene, checkpoints, accuracy) is no stage.
    #[derive(PartialOrd, Ord, Hash)]
    pub enum Stage {
        /// Mesh, boundary and panes.
        Mesh = "mesh",
        /// Matrices and the factor.
        Assemble = "assemble",
        /// Loads and what follows from them linearly.
        Load = "load",
        /// Multipliers, displacement and history.
        Solve = "solve",
        /// Stresses, zones, resultants and the certificate; the same for ParaView.
        Post = "post",
    }
}

impl Stage {
    /// The command that runs the stage.
    #[must_use]
    pub const fn command(self) -> &'static str {
        match self {
            Self::Mesh => "mesh",
            Self::Assemble | Self::Load => "assemble",
            Self::Solve => "solve",
            Self::Post => "post",
        }
    }

    /// The group that the stage writes.
    #[must_use]
    pub const fn group(self) -> Group {
        match self {
            Self::Mesh => mesh::GROUP,
            Self::Assemble => assemble::GROUP,
            Self::Load => load::GROUP,
            Self::Solve => solve::GROUP,
            Self::Post => post::GROUP,
        }
    }
}

/// Every dataset of a run file.
pub const LAYOUT: Layout = Layout {
    filetype: "contact3d-pipe run",
    linked_filetype: "contact3d-pipe stage",
    format_version: [2, 0],
    creator: concat!("contact3d-pipe ", env!("CARGO_PKG_VERSION")),
    units: Units::SI,
    groups: &[
        scene::GROUP,
        mesh::GROUP,
        assemble::GROUP,
        load::GROUP,
        increments::GROUP,
        solve::GROUP,
        post::GROUP,
        VTKHDF,
        CHECKPOINT,
        accuracy::GROUP,
        adapt::GROUP,
        branches::GROUP,
        bound::GROUP,
    ],
    tables: &[
        scene::TABLE,
        mesh::BODY.rows,
        mesh::SURFACE.rows,
        mesh::QUALITY.rows,
        assemble::OPERATORS,
        assemble::SECONDS.rows,
        assemble::FACTOR.rows,
        load::TABLE,
        solve::FIELDS.rows,
        quantities::FIELDS.rows,
        solve::NEWTON_STEPS.rows,
        solve::OUTER_STEPS.rows,
        post::ON_THE_BODY.rows,
        post::FORCES.rows,
        post::TOOLS.rows,
        post::TOTALS.rows,
        vtkhdf::TABLE,
        result_fields::TABLE,
        vtkhdf::ONCE,
        series::TABLE,
        accuracy::ACCURACY.rows,
        accuracy::ALGEBRAIC.rows,
        accuracy::SOLVES.rows,
        accuracy::MESHES.rows,
        accuracy::TRENDS.rows,
        solve::STATE.rows,
        solve::DONE_ROWS,
        adapt::FIELDS.rows,
        branches::OF_SEARCH.rows,
        branches::OF_PATHS.rows,
        branches::OF_POINTS.rows,
        increments::INCREMENTS.rows,
        bound::FIELDS.rows,
        bound::SIDE_FORCES.rows,
        quantities::OF_INCREMENTS.rows,
    ],
    extents: extents::OF_RUN_FILES,
};

/// Why datasets cannot be written or turned back into a problem.
#[derive(Debug, Error)]
pub enum FormatError {
    /// The file itself.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The stored scene does not validate.
    #[error("the stored scene cannot be used; run `mesh` again with a scene file")]
    Scene(#[source] Box<SceneError>),
    /// Datasets contradict each other.
    #[error("{dataset}: {reason}; run the stage that writes it again")]
    Inconsistent {
        dataset: &'static str,
        reason: String,
    },
    /// The factor stayed with an engine.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The stored factor is damaged.
    #[error("/assemble/factor: {0}; run `assemble` again")]
    Factor(#[from] PartsError),
}

impl FormatError {
    /// What is wrong with a dataset beside the others.
    fn inconsistent(dataset: &'static str, reason: impl ToString) -> Self {
        let reason = reason.to_string();
        Self::Inconsistent { dataset, reason }
    }
}

/// Refuses a dataset that does not fit the others, for a reason.
fn require(
    fits: bool,
    dataset: &'static str,
    reason: impl FnOnce() -> String,
) -> Result<(), FormatError> {
    match fits {
        true => Ok(()),
        false => Err(FormatError::inconsistent(dataset, reason())),
    }
}

/// Refuses an index that is not below its bound.
fn require_below<'a>(
    dataset: &'static str,
    indices: impl IntoIterator<Item = &'a usize>,
    bound: usize,
) -> Result<(), FormatError> {
    let beyond = indices.into_iter().find(|index| **index >= bound);
    require(beyond.is_none(), dataset, || {
        let found = beyond.unwrap_or(&bound);
        format!("expected indices below {bound}, found {found}")
    })
}

/// A compressed-column matrix as the file's matrix.
fn columns(matrix: &CscMatrix) -> SparseView<'_> {
    SparseView {
        shape: [matrix.rows, matrix.cols],
        indptr: &matrix.indptr,
        indices: &matrix.indices,
        data: &matrix.data,
    }
}

/// The matrix of a file that is compressed by columns.
fn as_columns(matrix: SparseMatrix) -> CscMatrix {
    CscMatrix {
        rows: matrix.shape[0],
        cols: matrix.shape[1],
        indptr: matrix.indptr,
        indices: matrix.indices,
        data: matrix.data,
    }
}

/// The transpose of a compressed-column matrix, which is compressed by rows in the same arrays.
fn rows_of_transpose(transposed: &CscMatrix) -> SparseView<'_> {
    SparseView {
        shape: [transposed.cols, transposed.rows],
        ..columns(transposed)
    }
}
