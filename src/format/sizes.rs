//! Numbers of unknowns in a run file, as far as its usable stages fix them.

use runfile::Reader;

use super::{
    FormatError, Stage,
    assemble::RIGID_PINS,
    load::FORCE,
    mesh::{CONTACT_FACE_NODES, CONTACT_FACE_PANES, CONTACT_NODES, PANE_AREA},
    read_index_vec,
};

/// Numbers of unknowns, as far as stages that can be used fix them.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Sizes {
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
///
/// # Errors
/// Altered datasets.
pub fn read_sizes(
    reader: &Reader,
    is_usable: &dyn Fn(Stage) -> bool,
) -> Result<Sizes, FormatError> {
    let has = |stage, path| is_usable(stage) && reader.has(path);
    let doubles = |stage, path| -> Result<Option<usize>, FormatError> {
        Ok(match has(stage, path) {
            true => Some(reader.read_vec::<f64>(path)?.len()),
            false => None,
        })
    };
    Ok(Sizes {
        n_free: doubles(Stage::Load, FORCE)?,
        panes: match doubles(Stage::Mesh, PANE_AREA)? {
            Some(all) => Some(of_faces(reader, CONTACT_FACE_PANES, all)?),
            None => None,
        },
        contact_nodes: match has(Stage::Mesh, CONTACT_NODES) {
            true => {
                let all = read_index_vec(reader, CONTACT_NODES)?.len();
                Some(of_faces(reader, CONTACT_FACE_NODES, all)?)
            }
            false => None,
        },
        n_rigid_modes: match has(Stage::Assemble, RIGID_PINS) {
            true => Some(read_index_vec(reader, RIGID_PINS)?.len()),
            false => None,
        },
    })
}

/// The sizes of several faces, whose limits a dataset holds, or that of the only one.
fn of_faces(reader: &Reader, path: &str, all: usize) -> Result<Vec<usize>, FormatError> {
    if !reader.has(path) {
        return Ok(vec![all]);
    }
    let limits = read_index_vec(reader, path)?;
    let pairs = limits.windows(2);
    Ok(pairs.map(|pair| pair[1].saturating_sub(pair[0])).collect())
}
