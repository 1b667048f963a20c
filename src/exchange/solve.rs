//! The problem of a file, solved.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use contact3d::dual::Need;
use contact3d::linalg::CscMatrix;
use contact3d::solver::{
    DelassusMethod, DelassusProblem, DelassusSettings, DelassusSolution, MOST_DENSE_CONTACTS,
    Obstruction, solve_delassus,
};
use fclib::{Array, FclibSolution};
use runfile::{FileState, StoreError, WholeFile};

use super::{PROGRAM, put};
use crate::{
    output::{self, Inputs, OutputKind},
    pipeline::{StageError, admit_memory},
};

/// Bytes for each entry of the dense matrices of Newton's method: W itself, its factor twice, the matrix of a step.
const BYTES_PER_ENTRY: u64 = 5 * 8;

/// Memory to read a matrix for each byte of the file's arrays, 12 an entry: those arrays, entries with long indices, once more to sort
/// them, W by columns, its transpose.
const BYTES_PER_BYTE: u64 = 8;

/// Where the solution goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SolutionFile {
    /// It is only printed.
    Nowhere,
    /// A copy of the file.
    Copy(PathBuf),
    /// The file itself, whose solution it replaces.
    InPlace,
}

/// What came of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct FclibAnswer {
    /// Number of contacts.
    pub contacts: usize,
    /// Stored entries of W.
    pub entries: usize,
    /// Forces, and how good they are.
    pub solution: DelassusSolution,
    /// Error of the solution that the file had; `None` where it had none.
    pub error_before: Option<f64>,
    /// Seconds of the solve.
    pub seconds: f64,
}

/// Solves the local problem of a file and stores the solution where it is wanted, converged or not.
///
/// # Errors
/// A file that holds no problem in 3D that can be solved, too little memory, an output that the guard refuses.
pub fn solve_file(
    file: &Path,
    target: &SolutionFile,
    settings: &DelassusSettings,
) -> Result<FclibAnswer, StageError> {
    let inputs = Inputs::of([file]);
    if let SolutionFile::Copy(path) = target {
        output::admit(path, OutputKind::Fclib, &inputs)?;
    }
    let state = FileState::of(file);
    admit_memory(Need {
        step: "reading the problem",
        memory: fclib::declared_bytes(file)?.saturating_mul(BYTES_PER_BYTE),
        stored: 0,
    })?;
    let local = fclib::read_local(file)?;
    if local.space_dimension != 3 {
        return Err(StageError::Unfit {
            file: file.to_owned(),
            reason: "/fclib_local/spacedim: expected 3, found 2; only problems in 3D are solved"
                .into(),
        });
    }
    let matrix = CscMatrix {
        rows: local.w.rows,
        cols: local.w.columns,
        indptr: local.w.starts,
        indices: local.w.indices,
        data: local.w.values,
    };
    let problem = DelassusProblem::new(matrix, local.q, local.mu);
    let problem = problem.map_err(|source| StageError::Delassus {
        file: file.to_owned(),
        source,
    })?;
    admit(&problem, settings.method)?;
    let size = problem.offset().len();
    let before = fclib::read_solution(file, size)?;
    let error_before = before.map(|before| problem.error(&before.r));
    let started = Instant::now();
    let solution = solve_delassus(&problem, settings);
    let answer = FclibAnswer {
        contacts: problem.n_contacts(),
        entries: problem.matrix().data.len(),
        solution,
        error_before,
        seconds: started.elapsed().as_secs_f64(),
    };
    // The solution is that of the file as it was read.
    if *target != SolutionFile::Nowhere && FileState::of(file) != state {
        let file = file.to_owned();
        return Err(StoreError::Changed { file }.into());
    }
    store(file, target, &answer.solution, &inputs)?;
    Ok(answer)
}

fn admit(problem: &DelassusProblem, method: DelassusMethod) -> Result<(), StageError> {
    let contacts = problem.n_contacts();
    let is_dense = match method {
        DelassusMethod::Auto => contacts <= MOST_DENSE_CONTACTS && !problem.is_sparse(),
        DelassusMethod::Newton => !problem.is_sparse(),
        DelassusMethod::Gpcg | DelassusMethod::Nsgs => false,
    };
    let entries = (3 * contacts as u64).saturating_pow(2);
    let memory = entries.saturating_mul(if is_dense { BYTES_PER_ENTRY } else { 0 });
    admit_memory(Need {
        step: "Newton's method, whose matrices are dense as W is; --method gpcg and nsgs take no others",
        memory,
        stored: 0,
    })?;
    Ok(())
}

fn store(
    file: &Path,
    target: &SolutionFile,
    solution: &DelassusSolution,
    inputs: &Inputs,
) -> Result<(), StageError> {
    let path = match target {
        SolutionFile::Nowhere => return Ok(()),
        SolutionFile::Copy(path) => path.as_path(),
        SolutionFile::InPlace => file,
    };
    let obstruction = solution.separation.as_ref().map(|separation| Array {
        name: "obstruction",
        meaning: match separation.obstruction {
            Obstruction::Penetration => {
                "p >= 0 of normal forces with W p = 0 and p.q < 0: no forces keep all contacts from penetrating"
            }
            Obstruction::Sticking => {
                "p in the cones of friction with W p = 0 and p.q < 0: where its contacts stick, some penetrate"
            }
        },
        values: &separation.direction,
        columns: 1,
    });
    let solution = FclibSolution {
        v: None,
        u: solution.velocity.clone(),
        r: solution.force.clone(),
    };
    let written = WholeFile::filled(path, Some(file), |file| {
        fclib::remove_solution(file)?;
        fclib::write_solution(file, &solution)?;
        fclib::write_arrays(file, "solution", obstruction.as_slice())?;
        match target {
            SolutionFile::InPlace => Ok(()),
            SolutionFile::Copy(_) | SolutionFile::Nowhere => fclib::write_program(file, PROGRAM),
        }
    })?;
    if *target == SolutionFile::InPlace {
        return Ok(written.replace(path)?);
    }
    put(&written, path, inputs)?;
    Ok(())
}
