//! Sizes that shapes name, axes whose entries have names, and numbers of unknowns in a run file.

use runfile::{Axis, Extent, Reader};

use super::{
    FormatError, Stage,
    assemble::RIGID_PINS,
    fields::{read_if_there, read_value},
    load::FORCE,
    mesh::{CONTACT_FACE_NODES, CONTACT_FACE_PANES, CONTACT_NODES, PANE_AREA},
    stored::Stored,
};

/// Axes whose places have names.
macro_rules! labelled {
    ($($(#[$doc:meta])* $axis:ident, $name:literal: $labels:expr;)+) => {$(
        $(#[$doc])*
        pub(super) const $axis: Extent = Extent::Labelled(&Axis { name: $name, labels: &$labels });
    )+};
}

labelled! {
    /// The global axes.
    XYZ, "axis": ["x", "y", "z"];
    /// The axes of friction.
    FRICTION_AXES, "friction_axis": ["t1", "t2"];
    /// The normal and the axes of friction.
    CONTACT_AXES, "contact_axis": ["nu", "t1", "t2"];
    /// The components of a stress.
    STRESS_COMPONENTS, "stress_component": ["xx", "yy", "zz", "yz", "xz", "xy"];
    /// What panes do.
    ZONES, "zone": ["open", "stick", "slip"];
    /// The figures of a certificate.
    CERTIFICATE_FIGURES, "figure": super::CERTIFICATE;
    /// Where forces come from.
    FORCE_SOURCES, "source": ["contact", "applied", "clamp"];
}

const NODES: (&str, &str) = ("n_nodes", "nodes of the mesh");
const KEYS: (&str, &str) = ("n_keys", "keys of all axes of a sweep");
const POINTS: (&str, &str) = (
    "n_points",
    "points for ParaView: nodes, and those where materials meet once for each of them",
);
const CELLS: (&str, &str) = (
    "n_cells",
    "VTK cells: the tetrahedra, then the contact triangles",
);
const CONNECTIVITY: (&str, &str) = ("n_connectivity", "node references of all VTK cells");
const SERIES_STEPS: (&str, &str) = ("n_series_steps", "steps of a series that ParaView plays");
const POINT_VALUES: (&str, &str) = (
    "n_point_values",
    "values on points for ParaView: nodes, once for each step of a series",
);
const CELL_VALUES: (&str, &str) = (
    "n_cell_values",
    "values on cells for ParaView: VTK cells, once for each step of a series",
);

pub(super) const OF_SERIES: &[(&str, &str)] = &[
    POINTS,
    CELLS,
    CONNECTIVITY,
    POINT_VALUES,
    CELL_VALUES,
    SERIES_STEPS,
    KEYS,
];

#[rustfmt::skip]
pub(super) const OF_RUN_FILES: &[(&str, &str)] = &[
    NODES,
    ("n_tools", "rigid tools"),
    ("n_tool_rows", "two for each tool: the displacement of its point, and its turn times its arm"),
    ("n_tied_nodes", "nodes of faces that are bonded to tools"),
    ("n_joints", "pairs of glued faces"),
    ("n_glued_nodes", "nodes that follow those of a face that theirs is glued to"),
    ("n_rows", "nodes of the mesh, then the rows of the tools"),
    ("n_material_nodes", "nodes of the mesh, and those where materials meet once for each of them"),
    ("n_tetrahedra", "tetrahedra of the mesh"),
    ("n_facets", "boundary triangles"),
    ("n_contact_nodes", "nodes on the contact face, held ones included"),
    ("n_contact_facets", "boundary triangles on the contact face"),
    ("n_panes", "panes m, the pieces on which multipliers are constant, or nodes that carry multipliers"),
    ("n_multipliers", "multipliers: m normal ones, then the tangential pairs of the panes with friction"),
    ("n_tangential", "tangential multipliers, two for each pane with friction"),
    ("n_contact_faces", "contact faces, where there are several"),
    ("n_bodies", "bodies, where there are several"),
    ("n_obstacle_points", "corners of the triangles of obstacles"),
    ("n_obstacle_triangles", "triangles of obstacles"),
    ("n_opposite", "pairs of a contact node and a node of another body that both belong to a pane"),
    ("n_friction_faces", "contact faces with friction, the first of all of them"),
    ("n_pane_facets", "contact triangles of faces with panes, all of them with one face"),
    ("n_friction_panes", "panes of contact faces with friction, the first of all panes"),
    ("n_friction_nodes", "nodes of contact faces with friction, the first of all contact nodes"),
    ("n_free", "free degrees of freedom, the dimension 3n of HKL section 4"),
    ("n_rigid_modes", "rigid motions that supports leave to contact, or hold weakly, 1 to 6, and free motions of tools"),
    ("n_null_space_motions", "rigid motions among these that neither contact nor supports feel"),
    ("n_supernodes", "supernodes of the Cholesky factor"),
    ("n_factor_rows", "row indices of all supernodes together"),
    ("n_factor_values", "coefficients stored for the Cholesky factor"),
    ("n_quantities", "quantities of the answer whose errors are estimated"),
    ("n_outer_steps", "steps of successive approximations"),
    ("n_newton_steps", "steps of Newton's method"),
    ("n_done_steps", "steps of successive approximations done before a checkpoint"),
    POINTS,
    CELLS,
    CONNECTIVITY,
    POINT_VALUES,
    CELL_VALUES,
    SERIES_STEPS,
    ("n_levels", "nested meshes of the study of accuracy"),
    ("n_accuracy_quantities", "quantities of these meshes"),
    ("n_tetrahedron_sides", "sides of tetrahedra, each once"),
    ("n_adaptive_levels", "adaptive meshes that were solved"),
    ("n_refinements", "adaptive meshes beyond the first, solved or made"),
    ("n_cut_tetrahedra", "tetrahedra of all adaptive meshes that were cut"),
    ("n_start_multipliers", "multipliers of all adaptive meshes beyond the first"),
    ("n_increments", "increments of a load history that were solved"),
    ("n_history_quantities", "quantities whose errors are estimated in some increment"),
    ("n_forces", "clamps, springs, loads, tools bonded to faces and contact faces of the scene"),
    ("n_paths", "paths of solutions"),
    ("n_path_points", "points of all paths of solutions"),
    ("n_path_multipliers", "multipliers of the problem whose solutions are followed"),
    ("n_switches", "changes of panes and nodes at all points of all paths"),
    ("n_solves", "accuracies asked of every method on every operator"),
];

/// Numbers of unknowns, as far as stages that can be used fix them.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct StageSizes {
    /// Free degrees of freedom.
    pub n_free: Option<usize>,
    /// Panes, or nodes that carry multipliers, of each contact face in the order of their multipliers.
    pub panes: Option<Vec<usize>>,
    /// Nodes on each contact face.
    pub contact_nodes: Option<Vec<usize>>,
    /// Rigid motions that supports leave to contact; `None` for none.
    pub n_rigid_modes: Option<usize>,
}

/// Reads the numbers of unknowns of a file from the stages that can be used.
pub fn read_sizes(
    reader: &Reader,
    is_usable: &dyn Fn(Stage) -> bool,
) -> Result<StageSizes, FormatError> {
    let mut sizes = StageSizes::default();
    if is_usable(Stage::Mesh) {
        let faces = |path, all| of_faces(reader, path, all);
        let panes = length::<f64>(reader, PANE_AREA)?;
        sizes.panes = panes.map(|n| faces(CONTACT_FACE_PANES, n)).transpose()?;
        let nodes = length::<usize>(reader, CONTACT_NODES)?;
        sizes.contact_nodes = nodes.map(|n| faces(CONTACT_FACE_NODES, n)).transpose()?;
    }
    if is_usable(Stage::Assemble) {
        sizes.n_rigid_modes = length::<usize>(reader, RIGID_PINS)?;
    }
    if is_usable(Stage::Load) {
        sizes.n_free = length::<f64>(reader, FORCE)?;
    }
    Ok(sizes)
}

/// The number of rows of a dataset; `None` where a file does not have it.
pub(super) fn length<V: Stored>(
    reader: &Reader,
    path: &'static str,
) -> Result<Option<usize>, FormatError> {
    let rows: Option<Vec<V>> = read_if_there(reader, path)?;
    Ok(rows.map(|rows| rows.len()))
}

/// The sizes of several faces, whose limits a dataset holds, or that of the only one.
fn of_faces(reader: &Reader, path: &'static str, all: usize) -> Result<Vec<usize>, FormatError> {
    if !reader.has(path) {
        return Ok(vec![all]);
    }
    let limits: Vec<usize> = read_value(reader, path)?;
    let pairs = limits.windows(2);
    Ok(pairs.map(|pair| pair[1].saturating_sub(pair[0])).collect())
}
