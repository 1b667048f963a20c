//! Why a scene has no usable mesh.

use thiserror::Error;

use super::GmshError;
use crate::scene::Invalid;

/// Why a scene has no usable mesh.
#[derive(Debug, Error)]
pub enum MeshError {
    /// The scene asks for what the mesh does not have.
    #[error("{}: expected {}, found {}; {}", .0.key, .0.expected, .0.found, .0.help)]
    Scene(Invalid),
    /// The mesh file.
    #[error(transparent)]
    Gmsh(#[from] GmshError),
}

impl From<Invalid> for MeshError {
    fn from(invalid: Invalid) -> Self {
        Self::Scene(invalid)
    }
}
