//! Why a problem cannot be posed or solved.

use thiserror::Error;

use crate::{
    dual::AssemblyError,
    mesh::{GmshError, MeshError},
    scene::{InvalidValue, SceneError},
    solver::NeedsExplicit,
};

/// Why a problem cannot be posed or solved.
#[derive(Debug, Error)]
pub enum ProblemError {
    /// A scene file.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A value of the scene or of the settings.
    #[error(transparent)]
    Invalid(#[from] InvalidValue),
    /// The mesh file.
    #[error(transparent)]
    Mesh(#[from] GmshError),
    /// The stiffness matrix.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// A solver setting that the operator does not allow.
    #[error(transparent)]
    NeedsExplicit(#[from] NeedsExplicit),
    /// A changed scene that the assembled operators do not fit.
    #[error(
        "{key}: expected as when the problem was assembled, found another; only loads, gap, law of friction and \
         settings of the solve may differ: assemble a problem of its own"
    )]
    OtherOperator {
        /// The key that differs.
        key: String,
    },
}

impl From<MeshError> for ProblemError {
    fn from(error: MeshError) -> Self {
        match error {
            MeshError::Scene(invalid) => Self::Invalid(invalid),
            MeshError::Gmsh(error) => Self::Mesh(error),
        }
    }
}
