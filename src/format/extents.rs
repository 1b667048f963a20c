//! Sizes that shapes name, and axes whose entries have names.

use runfile::{Axis, Extent};

/// The meaning of a size.
type Size = (&'static str, &'static str);

/// The global axes.
pub(super) const XYZ: Extent = Extent::Labelled(&Axis {
    name: "axis",
    labels: &["x", "y", "z"],
});

/// The axes of friction.
pub(super) const FRICTION_AXES: Extent = Extent::Labelled(&Axis {
    name: "friction_axis",
    labels: &["t1", "t2"],
});

/// The normal and the axes of friction.
pub(super) const CONTACT_AXES: Extent = Extent::Labelled(&Axis {
    name: "contact_axis",
    labels: &["nu", "t1", "t2"],
});

/// The components of a stress.
pub(super) const STRESS_COMPONENTS: Extent = Extent::Labelled(&Axis {
    name: "stress_component",
    labels: &["xx", "yy", "zz", "yz", "xz", "xy"],
});

/// What panes do.
pub(super) const ZONES: Extent = Extent::Labelled(&Axis {
    name: "zone",
    labels: &["open", "stick", "slip"],
});

/// The figures of a certificate.
pub(super) const CERTIFICATE_FIGURES: Extent = Extent::Labelled(&Axis {
    name: "figure",
    labels: &super::CERTIFICATE,
});

/// Where forces come from.
pub(super) const FORCE_SOURCES: Extent = Extent::Labelled(&Axis {
    name: "source",
    labels: &["contact", "applied", "clamp"],
});

const NODES: Size = ("n_nodes", "nodes of the mesh");
const KEYS: Size = ("n_keys", "keys of all axes of a sweep");
const CELLS: Size = (
    "n_cells",
    "VTK cells: the tetrahedra, then the contact triangles",
);
const CONNECTIVITY: Size = ("n_connectivity", "node references of all VTK cells");
const SERIES_STEPS: Size = ("n_series_steps", "steps of a series that ParaView plays");
const POINT_VALUES: Size = (
    "n_point_values",
    "values on points for ParaView: nodes, once for each step of a series",
);
const CELL_VALUES: Size = (
    "n_cell_values",
    "values on cells for ParaView: VTK cells, once for each step of a series",
);

pub(super) const OF_SERIES: &[Size] = &[
    NODES,
    CELLS,
    CONNECTIVITY,
    POINT_VALUES,
    CELL_VALUES,
    SERIES_STEPS,
    KEYS,
];

#[rustfmt::skip]
pub(super) const OF_RUN_FILES: &[Size] = &[
    NODES,
    ("n_tetrahedra", "tetrahedra of the mesh"),
    ("n_facets", "boundary triangles"),
    ("n_contact_nodes", "nodes on the contact face, held ones included"),
    ("n_contact_facets", "boundary triangles on the contact face"),
    ("n_panes", "panes m, the pieces on which multipliers are constant, or nodes that carry multipliers"),
    ("n_multipliers", "multipliers: m normal ones, then the tangential pairs of the panes with friction"),
    ("n_tangential", "tangential multipliers, two for each pane with friction"),
    ("n_contact_faces", "contact faces, where there are several"),
    ("n_friction_faces", "contact faces with friction, the first of all of them"),
    ("n_pane_facets", "contact triangles of faces with panes, all of them with one face"),
    ("n_friction_panes", "panes of contact faces with friction, the first of all panes"),
    ("n_friction_nodes", "nodes of contact faces with friction, the first of all contact nodes"),
    ("n_free", "free degrees of freedom, the dimension 3n of HKL section 4"),
    ("n_rigid_modes", "rigid motions that supports leave to contact, or hold weakly, 1 to 6"),
    ("n_null_space_motions", "rigid motions among these that neither contact nor supports feel"),
    ("n_supernodes", "supernodes of the Cholesky factor"),
    ("n_factor_rows", "row indices of all supernodes together"),
    ("n_factor_values", "coefficients stored for the Cholesky factor"),
    ("n_quantities", "quantities of the answer whose errors are estimated"),
    ("n_outer_steps", "steps of successive approximations"),
    ("n_newton_steps", "steps of Newton's method"),
    ("n_done_steps", "steps of successive approximations done before a checkpoint"),
    CELLS,
    CONNECTIVITY,
    POINT_VALUES,
    CELL_VALUES,
    SERIES_STEPS,
    ("n_levels", "nested meshes of the study of accuracy"),
    ("n_tetrahedron_sides", "sides of tetrahedra, each once"),
    ("n_adaptive_levels", "adaptive meshes that were solved"),
    ("n_refinements", "adaptive meshes beyond the first, solved or made"),
    ("n_cut_tetrahedra", "tetrahedra of all adaptive meshes that were cut"),
    ("n_start_multipliers", "multipliers of all adaptive meshes beyond the first"),
    ("n_increments", "increments of a load history that were solved"),
    ("n_history_quantities", "quantities whose errors are estimated in some increment"),
    ("n_forces", "clamps, springs, loads and contact faces of the scene"),
    ("n_paths", "paths of solutions"),
    ("n_path_points", "points of all paths of solutions"),
    ("n_path_multipliers", "multipliers of the problem whose solutions are followed"),
    ("n_switches", "changes of panes and nodes at all points of all paths"),
    ("n_solves", "accuracies asked of every method on every operator"),
];
