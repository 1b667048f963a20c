//! The run file's datasets: one table per stage, each beside its reader and writer.

mod accuracy;
mod adapt;
mod assemble;
mod axes;
mod branches;
mod case;
mod case_faces;
mod checkpoint;
mod columns;
mod enumeration;
mod history;
mod load;
mod load_history;
mod mesh;
mod outcome;
mod path_series;
mod post;
mod scene;
mod series;
mod sizes;
mod solve;
mod stability;
mod stage;
mod sweep;
mod sweep_series;
mod theory;
mod vtkhdf;
mod vtkhdf_check;
mod vtkhdf_once;
mod vtkhdf_series;
mod vtkhdf_stored;

use thiserror::Error;

pub use accuracy::{
    GROUP as ACCURACY, read as read_accuracy, read_advice, write as write_accuracy,
};
pub use adapt::{GROUP as ADAPT, read as read_adaptation, write as write_adaptation};
pub use assemble::{
    read as read_assembly, read_coupling, read_primal, stored_bytes as assembly_bytes,
    write as write_assembly,
};
pub use branches::{GROUP as BRANCHES, read as read_branches, write as write_branches};
pub use case::{CERTIFICATE, CaseResults, read_case};
pub use case_faces::CaseFace;
pub use checkpoint::{GROUP as CHECKPOINT, read as read_checkpoint, write as write_checkpoint};
pub use load::{read as read_loads, write as write_loads};
pub use load_history::{
    GROUP as HISTORY, check as check_history, read as read_history, write as write_history,
};
pub use mesh::{read as read_mesh, write as write_mesh};
pub use path_series::begin as begin_path_series;
pub use post::{ContactSummary, Summary, read_certificate, read_summary, write as write_report};
pub use scene::{
    GROUP as SCENE, read as read_scene, table as scene_table, table_of_text as scene_table_of_text,
    text as scene_text, write as write_scene,
};
pub use series::SERIES_LAYOUT;
pub use sizes::{Sizes, read_sizes};
pub use solve::{read as read_solution, read_multiplier, write as write_solution};
pub use stability::{GROUP as STABILITY, STABILITY_LAYOUT, StabilityRow, write as write_stability};
pub use stage::Stage;
pub use sweep::{
    CaseRow, GROUP as CASES, SWEEP_LAYOUT, TableOwner, read_table_owner, write as write_cases,
};
pub use sweep_series::{SeriesCase, begin as begin_sweep_series, step as step_sweep_series};
pub use theory::{GROUP as THEORY, read as read_theory, write as write_theory};
pub use vtkhdf::{GROUP as VTKHDF, GridValues, write as write_vtkhdf};
pub use vtkhdf_check::{check as check_vtkhdf, problems};
pub use vtkhdf_series::Series;
pub use vtkhdf_stored::field_paths;

use contact3d::{
    linalg::{CscMatrix, PartsError},
    scene::SceneError,
};
use runfile::{Layout, Reader, SparseView, StoreError};
use units::Units;

/// Sizes of what ParaView reads, in run files and in files of series.
const CELLS_EXTENT: (&str, &str) = (
    "n_cells",
    "VTK cells: the tetrahedra, then the contact triangles",
);
const CONNECTIVITY_EXTENT: (&str, &str) = ("n_connectivity", "node references of all VTK cells");
const POINT_VALUES_EXTENT: (&str, &str) = (
    "n_point_values",
    "values on points for ParaView: nodes, once for each step of a series",
);
const CELL_VALUES_EXTENT: (&str, &str) = (
    "n_cell_values",
    "values on cells for ParaView: VTK cells, once for each step of a series",
);
const SERIES_STEPS_EXTENT: (&str, &str) =
    ("n_series_steps", "steps of a series that ParaView plays");

/// Every dataset of a run file.
pub const LAYOUT: Layout = Layout {
    filetype: "contact3d-pipe run",
    linked_filetype: "contact3d-pipe stage",
    format_version: [1, 8],
    sealed_since: [1, 8],
    creator: concat!("contact3d-pipe ", env!("CARGO_PKG_VERSION")),
    units: Units::SI,
    groups: &[
        scene::GROUP,
        mesh::GROUP,
        assemble::GROUP,
        load::GROUP,
        load_history::GROUP,
        solve::GROUP,
        post::GROUP,
        vtkhdf::GROUP,
        checkpoint::GROUP,
        accuracy::GROUP,
        adapt::GROUP,
        theory::GROUP,
        branches::GROUP,
    ],
    tables: &[
        scene::TABLE,
        mesh::TABLE,
        assemble::TABLE,
        load::TABLE,
        solve::TABLE,
        history::TABLE,
        post::TABLE,
        vtkhdf::TABLE,
        vtkhdf_once::TABLE,
        vtkhdf_series::TABLE,
        accuracy::TABLE,
        accuracy::RUNGS_TABLE,
        accuracy::LEVELS_TABLE,
        accuracy::WAYS_TABLE,
        checkpoint::TABLE,
        adapt::TABLE,
        theory::TABLE,
        theory::LEVELS_TABLE,
        theory::NORMS_TABLE,
        theory::ROWS_TABLE,
        branches::TABLE,
        load_history::TABLE,
    ],
    extents: &[
        ("n_nodes", "nodes of the mesh"),
        ("n_tetrahedra", "tetrahedra of the mesh"),
        ("n_facets", "boundary triangles"),
        (
            "n_contact_nodes",
            "nodes on the contact face, held ones included",
        ),
        ("n_contact_facets", "boundary triangles on the contact face"),
        (
            "n_panes",
            "panes m, the pieces on which multipliers are constant, or nodes that carry multipliers",
        ),
        (
            "n_multipliers",
            "multipliers: m normal ones, then the tangential pairs of the panes with friction",
        ),
        (
            "n_tangential",
            "tangential multipliers, two for each pane with friction",
        ),
        ("n_contact_faces", "contact faces, where there are several"),
        (
            "n_friction_faces",
            "contact faces with friction, the first of all of them",
        ),
        (
            "n_pane_facets",
            "contact triangles of faces with panes, all of them with one face",
        ),
        (
            "n_friction_panes",
            "panes of contact faces with friction, the first of all panes",
        ),
        (
            "n_friction_nodes",
            "nodes of contact faces with friction, the first of all contact nodes",
        ),
        (
            "n_free",
            "free degrees of freedom, the dimension 3n of HKL section 4",
        ),
        (
            "n_rigid_modes",
            "rigid motions that supports leave to contact, or hold weakly, 1 to 6",
        ),
        (
            "n_neutral_motions",
            "rigid motions among these that neither contact nor supports feel",
        ),
        ("n_supernodes", "supernodes of the Cholesky factor"),
        ("n_factor_rows", "row indices of all supernodes together"),
        (
            "n_factor_values",
            "coefficients stored for the Cholesky factor",
        ),
        ("n_outer_steps", "steps of successive approximations"),
        ("n_newton_steps", "steps of Newton's method"),
        (
            "n_done_steps",
            "steps of successive approximations done before a checkpoint",
        ),
        CELLS_EXTENT,
        CONNECTIVITY_EXTENT,
        POINT_VALUES_EXTENT,
        CELL_VALUES_EXTENT,
        SERIES_STEPS_EXTENT,
        ("n_levels", "nested meshes of the accuracy ladder"),
        (
            "n_way_levels",
            "meshes of all ways to accuracy, and the reference",
        ),
        ("n_theory_levels", "nested meshes of the theory, or one"),
        ("n_trial_spaces", "spaces of multipliers on all of them"),
        ("n_scales", "scales of the law on all of them"),
        ("n_adaptive_levels", "adaptive meshes that were solved"),
        (
            "n_refinements",
            "adaptive meshes beyond the first, solved or made",
        ),
        (
            "n_cut_tetrahedra",
            "tetrahedra of all adaptive meshes that were cut",
        ),
        (
            "n_start_multipliers",
            "multipliers of all adaptive meshes beyond the first",
        ),
        (
            "n_increments",
            "increments of a load history that were solved",
        ),
        (
            "n_forces",
            "clamps, springs, loads and contact faces of the scene",
        ),
        ("n_paths", "paths of solutions"),
        ("n_path_points", "points of all paths of solutions"),
        (
            "n_path_multipliers",
            "multipliers of the problem whose solutions are followed",
        ),
        (
            "n_switches",
            "changes of panes and nodes at all points of all paths",
        ),
        (
            "n_rungs",
            "accuracies asked of every method on every operator",
        ),
    ],
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
        /// Path of the dataset.
        dataset: &'static str,
        /// What was expected and found.
        reason: String,
    },
    /// The stored factor is damaged.
    #[error("/assemble/factor: {0}; run `assemble` again")]
    Factor(#[from] PartsError),
}

/// Refuses an index that is not below its bound.
fn require_below(
    dataset: &'static str,
    mut indices: impl Iterator<Item = usize>,
    bound: usize,
) -> Result<(), FormatError> {
    match indices.find(|&index| index >= bound) {
        None => Ok(()),
        Some(index) => Err(FormatError::Inconsistent {
            dataset,
            reason: format!("expected indices below {bound}, found {index}"),
        }),
    }
}

/// Reads an index dataset of shape `[n]` or, flattened, `[n, k]`.
fn read_index_vec(reader: &Reader, path: &str) -> Result<Vec<usize>, StoreError> {
    Ok(reader.read_indices(path)?.into_raw_vec_and_offset().0)
}

/// Reads a finite dataset, flattened.
fn read_finite_vec(reader: &Reader, path: &str) -> Result<Vec<f64>, StoreError> {
    Ok(reader.read_finite_f64(path)?.into_raw_vec_and_offset().0)
}

/// Reads a dataset of shape `[n, K]`.
fn read_finite_rows<const K: usize>(
    reader: &Reader,
    path: &str,
) -> Result<Vec<[f64; K]>, StoreError> {
    Ok(read_finite_vec(reader, path)?.as_chunks::<K>().0.to_vec())
}

/// Reads a dataset with one value, which a failed solve may have left infinite or no number.
fn read_scalar(reader: &Reader, path: &'static str) -> Result<f64, FormatError> {
    one_value(path, &reader.read_vec(path)?)
}

fn one_value(path: &'static str, values: &[f64]) -> Result<f64, FormatError> {
    values
        .first()
        .copied()
        .ok_or_else(|| FormatError::Inconsistent {
            dataset: path,
            reason: "expected one value, found none".into(),
        })
}

/// Reads a dataset with one value.
fn read_finite_scalar(reader: &Reader, path: &'static str) -> Result<f64, FormatError> {
    one_value(path, &read_finite_vec(reader, path)?)
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

/// The transpose of a compressed-column matrix, which is compressed by rows in the same arrays.
fn rows_of_transpose(transposed: &CscMatrix) -> SparseView<'_> {
    SparseView {
        shape: [transposed.cols, transposed.rows],
        ..columns(transposed)
    }
}
