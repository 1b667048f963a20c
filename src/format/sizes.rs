//! Numbers of unknowns in a run file, as far as its usable stages fix them.

use runfile::Reader;

use super::{
    FormatError, Stage,
    assemble::RIGID_PINS,
    fields::read_value,
    load::FORCE,
    mesh::{CONTACT_FACE_NODES, CONTACT_FACE_PANES, CONTACT_NODES, PANE_AREA},
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
    let length = |stage, path, of: Length| -> Result<Option<usize>, FormatError> {
        let is_there = is_usable(stage) && reader.has(path);
        is_there.then(|| of(reader, path)).transpose()
    };
    let faces = |path, all: Option<usize>| all.map(|all| of_faces(reader, path, all)).transpose();
    let panes = length(Stage::Mesh, PANE_AREA, n_numbers)?;
    let nodes = length(Stage::Mesh, CONTACT_NODES, n_indices)?;
    Ok(StageSizes {
        n_free: length(Stage::Load, FORCE, n_numbers)?,
        panes: faces(CONTACT_FACE_PANES, panes)?,
        contact_nodes: faces(CONTACT_FACE_NODES, nodes)?,
        n_rigid_modes: length(Stage::Assemble, RIGID_PINS, n_indices)?,
    })
}

type Length = fn(&Reader, &'static str) -> Result<usize, FormatError>;

fn n_numbers(reader: &Reader, path: &'static str) -> Result<usize, FormatError> {
    Ok(reader.read_vec::<f64>(path)?.len())
}

fn n_indices(reader: &Reader, path: &'static str) -> Result<usize, FormatError> {
    Ok(read_value::<Vec<usize>>(reader, path)?.len())
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
