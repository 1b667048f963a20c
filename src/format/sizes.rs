use super::{FormatError, load::FORCE, mesh::CONTACT_NODES, mesh::PANE_AREA, read_index_vec};
use crate::store::Reader;

/// Numbers of unknowns, as far as the stored stages fix them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sizes {
    /// Free degrees of freedom.
    pub n_free: Option<usize>,
    /// Panes, or nodes that carry multipliers.
    pub n_panes: Option<usize>,
    /// Nodes on the contact face.
    pub n_contact_nodes: Option<usize>,
}

/// Reads the numbers of unknowns of a file.
///
/// # Errors
/// Altered datasets.
pub fn read_sizes(reader: &Reader) -> Result<Sizes, FormatError> {
    let doubles = |path| -> Result<Option<usize>, FormatError> {
        Ok(match reader.has(path) {
            true => Some(reader.read_vec::<f64>(path)?.len()),
            false => None,
        })
    };
    Ok(Sizes {
        n_free: doubles(FORCE)?,
        n_panes: doubles(PANE_AREA)?,
        n_contact_nodes: match reader.has(CONTACT_NODES) {
            true => Some(read_index_vec(reader, CONTACT_NODES)?.len()),
            false => None,
        },
    })
}
