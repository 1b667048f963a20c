//! Files made beside their places.

use std::path::Path;

use contact3d::{linalg::CscMatrix, solver::DelassusProblem};
use fclib::{FclibError, Matrix, Solution};
use runfile::{StoreError, WholeFile, Written};

use crate::{output::OutputError, pipeline::StageError};

/// How the root of our files names this program.
pub(super) const PROGRAM: &str = crate::output::FCLIB_PROGRAM;

/// Ends a file of FCLIB; `is_same` reads it back and tells whether it holds what was to be written.
pub(super) fn proven(
    part: WholeFile,
    target: &Path,
    is_same: impl FnOnce(&Path) -> Result<bool, FclibError>,
) -> Result<Written, StageError> {
    part.close()?.proven(|path| match is_same(path)? {
        true => Ok(()),
        false => Err(StoreError::Unproven {
            file: target.to_owned(),
            reason: "arrays differ".to_owned(),
        }
        .into()),
    })
}

/// Whether two solutions are the same, bit for bit.
pub(super) fn is_solution(found: Option<Solution>, written: &Solution) -> bool {
    let bits = |values: &[f64]| {
        values
            .iter()
            .map(|value| value.to_bits())
            .collect::<Vec<_>>()
    };
    found.is_some_and(|found| {
        bits(&found.u) == bits(&written.u) && bits(&found.r) == bits(&written.r)
    })
}

/// The bytes of such a file.
pub(super) fn bytes_of(written: &Written, target: &Path) -> Result<Vec<u8>, OutputError> {
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
