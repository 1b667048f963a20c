//! Numbers of unknowns in a run file, as far as its usable stages fix them.

use runfile::Reader;

use super::{
    FormatError, Stage,
    assemble::RIGID_PINS,
    fields::{read_if_there, read_value},
    load::FORCE,
    mesh::{CONTACT_FACE_NODES, CONTACT_FACE_PANES, CONTACT_NODES, PANE_AREA},
    stored::Stored,
};

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
