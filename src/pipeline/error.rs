//! Why a stage cannot be run, with what to do about it.

use std::path::PathBuf;

use contact3d::{
    ProblemError,
    dual::{AssemblyError, InsufficientResource},
    mesh::GmshError,
    scene::{InvalidValue, SceneError},
};
use miette::Diagnostic;
use plots::PngError;
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
    #[error(transparent)]
    Setting(InvalidValue),
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
    InsufficientResource(#[from] InsufficientResource),
    /// An earlier stage is missing or stale.
    #[error("{}: `{}` needs a fresh `{}`, but {why}; run `contact3d-pipe {}` or `contact3d-pipe run` first", file.display(), stage.word(), upstream.word(), upstream.command())]
    NotReady {
        file: PathBuf,
        stage: Stage,
        upstream: Stage,
        why: String,
    },
    /// A file or folder of a sweep or a suite cannot be read or written.
    #[error("cannot {action} {}: {source}", file.display())]
    Io {
        action: &'static str,
        file: PathBuf,
        source: std::io::Error,
    },
    /// Bad input of a command that runs stages, such as a sweep.
    #[error(transparent)]
    Command(Box<dyn std::error::Error + Send + Sync>),
    /// The cases were run, but their tables cannot be written.
    #[error(
        "{0}; cases that are stored are kept, and `contact3d-pipe sweep summary` writes the tables"
    )]
    NotSummedUp(#[source] Box<StageError>),
    /// A picture could not be drawn or written.
    #[error("figure {}: {source}", file.display())]
    Figure { file: PathBuf, source: PngError },
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
        source: Box<StageError>,
    },
    /// A problem that files of FCLIB cannot hold, or that is not solved.
    #[error("{}: {reason}", file.display())]
    Unfit { file: PathBuf, reason: String },
    /// A file that runs share cannot be removed, or the turn to make it not be had.
    #[error("cannot write {}: {source}; check the permissions of the folder", file.display())]
    Write {
        file: PathBuf,
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
    pub fn is_internal(&self) -> bool {
        match self {
            Self::Store(error) | Self::Format(FormatError::Store(error)) => error.is_internal(),
            Self::Figure { .. } => true,
            Self::Partly { source, .. } => source.is_internal(),
            _ => false,
        }
    }

    /// The same error once the results are stored.
    pub fn after_storing(self) -> Self {
        Self::Partly {
            stored: Vec::new(),
            source: Box::new(self),
        }
    }

    /// Whether the work stopped midway and something was stored all the same. Pictures are no part of the work: a place that does
    /// not take them is bad input.
    pub fn is_after_storing(&self) -> bool {
        match self {
            Self::Store(error) => error.is_after_storing(),
            Self::Partly { source, .. } => !matches!(**source, Self::Output(_)),
            Self::NotSummedUp(_) => true,
            _ => false,
        }
    }

    /// Whether another program changed a file, or a file beside it, while this one was at work on it.
    pub fn is_of_other_programs(&self) -> bool {
        use StoreError::{Changed, Linked};
        matches!(
            self,
            Self::Store(Changed { .. } | Linked { .. })
                | Self::Format(FormatError::Store(Changed { .. } | Linked { .. }))
        )
    }

    /// Whether the machine failed, such as a full disk, rather than the input being at fault.
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
