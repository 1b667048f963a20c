use thiserror::Error;

use crate::{
    dual::AssemblyError,
    mesh::{GmshError, MeshError},
    scene::Invalid,
    solver::NeedsExplicit,
};

/// Why a scene cannot be solved.
#[derive(Debug, Error)]
pub enum SolveSceneError {
    /// A value of the scene or of the settings.
    #[error("{}: expected {}, found {}; {}", .0.key, .0.expected, .0.found, .0.help)]
    Invalid(Invalid),
    /// The mesh file.
    #[error(transparent)]
    Mesh(#[from] GmshError),
    /// The stiffness matrix.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// A solver setting that the operator does not allow.
    #[error(transparent)]
    NeedsExplicit(#[from] NeedsExplicit),
}

impl From<Invalid> for SolveSceneError {
    fn from(invalid: Invalid) -> Self {
        Self::Invalid(invalid)
    }
}

impl From<MeshError> for SolveSceneError {
    fn from(error: MeshError) -> Self {
        match error {
            MeshError::Scene(invalid) => Self::Invalid(invalid),
            MeshError::Gmsh(error) => Self::Mesh(error),
        }
    }
}
