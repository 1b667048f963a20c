//! Numbers of unknowns in a run file, as far as its usable stages fix them.

use runfile::Reader;

use super::{
    FormatError, Stage, assemble::RIGID_PINS, load::FORCE, mesh::CONTACT_NODES, mesh::PANE_AREA,
    read_index_vec,
};

/// Numbers of unknowns, as far as stages that can be used fix them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sizes {
    /// Free degrees of freedom.
    pub n_free: Option<usize>,
    /// Panes, or nodes that carry multipliers.
    pub n_panes: Option<usize>,
    /// Nodes on the contact face.
    pub n_contact_nodes: Option<usize>,
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
        n_panes: doubles(Stage::Mesh, PANE_AREA)?,
        n_contact_nodes: match has(Stage::Mesh, CONTACT_NODES) {
            true => Some(read_index_vec(reader, CONTACT_NODES)?.len()),
            false => None,
        },
        n_rigid_modes: match has(Stage::Assemble, RIGID_PINS) {
            true => Some(read_index_vec(reader, RIGID_PINS)?.len()),
            false => None,
        },
    })
}
