//! Files that hold what ParaView opens and nothing else: a copy of what a run file has, the points of a path, the cases of a sweep.

use runfile::Layout;

use super::{
    path_series, sweep_series,
    vtkhdf::{self, GROUP},
    vtkhdf_once, vtkhdf_series,
};

/// Every dataset of such a file.
pub const SERIES_LAYOUT: Layout = Layout {
    filetype: "contact3d-pipe series",
    linked_filetype: "contact3d-pipe series stage",
    format_version: [1, 2],
    sealed_since: [1, 2],
    creator: super::LAYOUT.creator,
    units: super::LAYOUT.units,
    groups: &[GROUP],
    tables: &[
        vtkhdf::TABLE,
        vtkhdf_once::TABLE,
        vtkhdf_series::TABLE,
        path_series::TABLE,
        sweep_series::TABLE,
    ],
    extents: &[
        ("n_nodes", "nodes of the mesh"),
        super::CELLS_EXTENT,
        super::CONNECTIVITY_EXTENT,
        super::POINT_VALUES_EXTENT,
        super::CELL_VALUES_EXTENT,
        super::SERIES_STEPS_EXTENT,
        ("n_keys", "keys of all axes of a sweep"),
    ],
};
