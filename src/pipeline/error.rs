//! Why a stage cannot be run, with what to do about it.

use std::path::PathBuf;

use contact3d::{
    ProblemError,
    dual::{AssemblyError, Shortage},
    mesh::GmshError,
    scene::{Invalid, SceneError},
    solver::{DelassusError, NeedsExplicit},
};
use fclib::FclibError;
use miette::Diagnostic;
use plots::FigureError;
use runfile::{Group, StoreError};
use thiserror::Error;

use crate::{
    format::{FormatError, Stage},
    output::OutputError,
};

/// Why a stage did not run.
#[derive(Debug, Error)]
pub enum StageError {
    /// The scene file.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The mesh file.
    #[error(transparent)]
    Mesh(#[from] GmshError),
    /// A setting given on the command line.
    #[error("{}: expected {}, found {}; {}", .0.key, .0.expected, .0.found, .0.help)]
    Setting(Invalid),
    /// The run file.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The datasets of the run file.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The stiffness matrix.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// A scene solved in memory, for the ladders of accuracy.
    #[error(transparent)]
    Unsolved(#[from] ProblemError),
    /// Too little memory or disk space for the mesh.
    #[error(transparent)]
    Shortage(#[from] Shortage),
    /// The method needs the dense dual operator.
    #[error(transparent)]
    NeedsExplicit(#[from] NeedsExplicit),
    /// A stage is not what was written.
    #[error("{}: `{}` cannot be used, {why}; `contact3d-pipe run` makes it again", file.display(), stage.word())]
    Damaged {
        /// The run file.
        file: PathBuf,
        /// The stage.
        stage: Stage,
        /// What is wrong with it.
        why: String,
    },
    /// An earlier stage is missing or stale.
    #[error("{}: `{}` needs a fresh `{}`, but {why}; run `contact3d-pipe {}` or `contact3d-pipe run` first", file.display(), stage.word(), upstream.word(), upstream.command())]
    NotReady {
        /// The run file.
        file: PathBuf,
        /// The stage that was asked for.
        stage: Stage,
        /// The stage it needs.
        upstream: Stage,
        /// What is wrong with that stage.
        why: String,
    },
    /// A folder that holds no sweep, or one that cannot be read.
    #[error("{}: {reason}; give a run file, or the folder of a sweep", file.display())]
    Sweep {
        /// The table of the sweep.
        file: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A picture could not be drawn or written.
    #[error("figure {}: {source}", file.display())]
    Figure {
        /// The picture's file.
        file: PathBuf,
        /// What went wrong.
        source: FigureError,
    },
    /// An output that is an input, or in the place of a file of another kind, or that cannot be
    /// written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The machine failed after a part of the work was stored.
    #[error(
        "{source}; {} and kept, the same command goes on from there",
        names(stored)
    )]
    Partly {
        /// The groups stored; empty for all that the command stores.
        stored: Vec<Group>,
        /// What failed.
        source: Box<StageError>,
    },
    /// A file of FCLIB.
    #[error(transparent)]
    Fclib(#[from] FclibError),
    /// A problem that files of FCLIB cannot hold, or that is not solved.
    #[error("{}: {reason}", file.display())]
    Unfit {
        /// The file.
        file: PathBuf,
        /// What does not fit, and what to do.
        reason: String,
    },
    /// Arrays of a file that make no frictional contact problem.
    #[error("{}: {source}", file.display())]
    Delassus {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        source: DelassusError,
    },
    /// A file that runs share cannot be removed, or the turn to make it not be had.
    #[error("cannot write {}: {source}; check the permissions of the folder", file.display())]
    Write {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}

/// What was stored, each stage once.
fn names(groups: &[Group]) -> String {
    let mut names: Vec<&str> = groups.iter().map(|group| group.name()).collect();
    names.dedup();
    match &names[..] {
        [] => "the results were stored before".to_owned(),
        [name] => format!("{name} was stored before"),
        names => format!("{} were stored before", names.join(", ")),
    }
}

impl StageError {
    /// The error with what to do about it, in one line.
    #[must_use]
    pub fn with_help(&self) -> String {
        let help = match self {
            Self::Scene(error) => error.help(),
            Self::Mesh(error) => error.help(),
            _ => None,
        };
        match help {
            Some(help) => format!("{self}; {help}"),
            None => self.to_string(),
        }
    }

    /// Whether the fault lies in the program rather than in its input.
    #[must_use]
    pub fn is_internal(&self) -> bool {
        match self {
            Self::Store(error) | Self::Format(FormatError::Store(error)) => error.is_internal(),
            Self::Figure { .. } => true,
            Self::Partly { source, .. } => source.is_internal(),
            _ => false,
        }
    }

    /// The same error once the results are stored.
    #[must_use]
    pub fn after_storing(self) -> Self {
        Self::Partly {
            stored: Vec::new(),
            source: Box::new(self),
        }
    }

    /// Whether something was stored all the same.
    #[must_use]
    pub fn is_after_storing(&self) -> bool {
        match self {
            Self::Store(error) => error.is_after_storing(),
            Self::Partly { .. } => true,
            _ => false,
        }
    }

    /// Whether the machine failed, such as a full disk, rather than the input being at fault.
    #[must_use]
    pub fn is_of_machine(&self) -> bool {
        match self {
            Self::Store(error) | Self::Format(FormatError::Store(error)) => {
                matches!(
                    error,
                    StoreError::Io { .. }
                        | StoreError::Hdf5 { .. }
                        | StoreError::Unproven { .. }
                        | StoreError::Unsynced { .. }
                )
            }
            Self::Output(error) => error.is_of_machine(),
            Self::Write { .. } => true,
            _ => false,
        }
    }
}
