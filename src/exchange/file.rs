//! Files made beside their places.

use std::path::Path;

use contact3d::{linalg::CscMatrix, solver::DelassusProblem};
use fclib::Matrix;
use runfile::WrittenFile;

use crate::{output::OutputError, pipeline::StageError};

/// How the root of our files names this program.
pub(super) const PROGRAM: &str = crate::output::FCLIB_PROGRAM;

/// The bytes of such a file.
pub(super) fn bytes_of(written: &WrittenFile, target: &Path) -> Result<Vec<u8>, OutputError> {
    std::fs::read(written.path()).map_err(failed(target, "read the file just made"))
}

pub(super) fn failed<'a>(
    target: &'a Path,
    action: &'static str,
) -> impl FnOnce(std::io::Error) -> OutputError + 'a {
    move |source| OutputError::Io {
        file: target.to_owned(),
        action,
        source,
    }
}

pub(super) fn to_file(matrix: CscMatrix) -> Matrix {
    Matrix {
        rows: matrix.rows,
        columns: matrix.cols,
        starts: matrix.indptr,
        indices: matrix.indices,
        values: matrix.data,
    }
}

pub(super) fn to_problem(
    file: &Path,
    local: fclib::LocalProblem,
) -> Result<DelassusProblem, StageError> {
    let matrix = CscMatrix {
        rows: local.w.rows,
        cols: local.w.columns,
        indptr: local.w.starts,
        indices: local.w.indices,
        data: local.w.values,
    };
    let problem = DelassusProblem::new(matrix, local.q, local.mu);
    problem.map_err(|source| StageError::Delassus {
        file: file.to_owned(),
        source,
    })
}
