//! Why a scene has no usable mesh.

use thiserror::Error;

use super::GmshError;
use crate::scene::Invalid;

/// Why a scene has no usable mesh.
#[derive(Debug, Error)]
pub enum MeshError {
    /// The scene asks for what the mesh does not have.
    #[error(transparent)]
    Scene(#[from] Invalid),
    /// The mesh file.
    #[error(transparent)]
    Gmsh(#[from] GmshError),
}
