//! The command line.

use std::{
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use contact3d::scene::MOST_CELLS;

use super::{
    export::ExportKind,
    init::{InspectArguments, SceneKind},
    stability::StabilityArguments,
    studies::Study,
    sweep::SweepArguments,
};
use crate::{
    output::Inputs,
    pipeline::{AssemblyFile, StageError},
    views::{Drawing, PictureFolder, figures_folder},
};

/// Most threads, and most cases at work at the same time.
pub(super) const MOST_THREADS: i64 = 1024;

/// 3D elastostatic contact with orthotropic, solution-dependent Coulomb friction
///
/// Solves static contact of an elastic body on rigid obstacles. A scene (TOML) passes through
/// the stages mesh, assemble, load, solve and post, which share one HDF5 file. To start:
///
///   contact3d-pipe init block.toml
///   contact3d-pipe run block.toml block.h5
///   contact3d-pipe status block.h5
///
/// Results go to standard output, progress and messages to standard error.
///
/// Exit codes: 0 done, 1 not converged (all results stored), 2 bad or stale input, 3 internal error
/// or a standard output that cannot take the results, 130 interrupted.
#[derive(Debug, Parser)]
#[command(version, long_version = super::generated::version_words(), verbatim_doc_comment, disable_help_subcommand = true)]
pub struct Arguments {
    /// What to do
    #[command(subcommand)]
    pub command: Command,
    #[command(flatten)]
    pub output: Output,
    /// Number of threads; all processors by default
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    pub threads: Option<u16>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run all stages, each only if it is missing or stale
    Run(RunArguments),
    /// Make the mesh of a scene and store both
    Mesh {
        #[command(flatten)]
        scene: SceneArguments,
        /// The run file, created or updated
        file: PathBuf,
    },
    /// Assemble and factorise the elastic problem, and apply the loads
    Assemble {
        /// The run file
        file: PathBuf,
        /// Change a key of [assemble] in the stored scene, for example --set assemble.factor=\"single\"
        #[arg(long = "set", value_name = "KEY=VALUE")]
        overrides: Vec<String>,
        #[command(flatten)]
        assembly: AssemblyFileArguments,
        #[command(flatten)]
        engine: EngineArguments,
    },
    /// Solve the contact problem
    Solve {
        /// The run file
        file: PathBuf,
        /// Change a key of [solve] in the stored scene, for example --set solve.epsilon=1e-8
        #[arg(long = "set", value_name = "KEY=VALUE")]
        overrides: Vec<String>,
        #[command(flatten)]
        engine: EngineArguments,
    },
    /// Evaluate the solution: zones, stresses, resultants, certificate, pictures, ParaView
    Post {
        /// The run file
        file: PathBuf,
        #[command(flatten)]
        figures: FigureArguments,
    },
    /// Run many scenes that differ in a few keys, in parallel, with shared work
    Sweep(SweepArguments),
    /// Show which stages are fresh, stale or missing, their sizes, and the main results; of a sweep how its cases ended
    Status {
        /// The run file, or the folder of a sweep
        file: PathBuf,
    },
    /// Check every value of a run file against its digest, and every dataset against the table
    Check {
        /// The run file
        file: PathBuf,
    },
    /// Compute bounds of the law of friction of a scene and draw it, without a solve
    FrictionLaw {
        #[command(flatten)]
        scene: SceneArguments,
        #[command(flatten)]
        figures: FigureArguments,
    },
    #[command(flatten)]
    Study(Study),
    /// Measure how far a solution can be trusted: conditioning, other algorithms, other descriptions of the problem
    Stability(StabilityArguments),
    /// Write a report as one HTML page that needs no network
    Report {
        /// A run file, or the folder of a sweep
        input: PathBuf,
        /// The page to write
        #[arg(default_value = "report.html")]
        page: PathBuf,
        /// The body in 3D, with fields, increments, and panes at hand, by one script in the page
        #[arg(long)]
        interactive: bool,
    },
    /// Write a solved run file for ParaView and PyVista, or its contact problem as a file of FCLIB
    Export {
        /// A solved run file
        file: PathBuf,
        /// The file to write
        target: PathBuf,
        /// What it is to be
        #[arg(long, value_enum)]
        kind: ExportKind,
    },
    /// Write or check the schemas of run files and scenes
    Schema {
        /// Folder for the schemas
        #[arg(default_value = "schemas")]
        folder: PathBuf,
        /// Write nothing; fail when files there differ from what would be written, or one that people or editors read is missing
        #[arg(long)]
        check: bool,
    },
    /// Write a commented scene to start from
    Init {
        /// The scene to write; an existing file is not overwritten
        #[arg(default_value = "scene.toml")]
        scene: PathBuf,
        /// What to start from
        #[arg(long, value_enum, default_value_t = SceneKind::Brick)]
        kind: SceneKind,
    },
    /// Show what a mesh file holds: faces, parts, sizes, quality; and write a scene for it
    Inspect(InspectArguments),
    /// Print the completions of commands and options for a shell
    Completions {
        /// The shell; for bash: contact3d-pipe completions bash > ~/.local/share/bash-completion/completions/contact3d-pipe
        shell: Shell,
    },
    /// Print the help of a command, or a page of the reference: scene, body, material, contact, supports, history, solver, sweep, statuses
    Help {
        /// A command or a page
        topic: Vec<String>,
    },
    /// Write the manual pages of the program and of every command
    Man {
        /// Folder for the pages, for example ~/.local/share/man/man1
        #[arg(default_value = "man")]
        folder: PathBuf,
    },
}

/// A scene file and changes to it.
#[derive(Debug, Args)]
pub struct SceneArguments {
    /// The scene, a TOML file such as `init` writes
    pub scene: PathBuf,
    /// Change one key of the scene, for example --set body.brick.cells=[12,4,4]
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
}

/// Arguments of `run`.
#[derive(Debug, Args)]
pub struct RunArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    /// The run file, created or updated
    pub file: PathBuf,
    /// Refine the mesh until the estimated error in the energy norm is no larger, for example 1% or 0.01. A single brick on
    /// flat ground then starts from a coarse mesh of its own, not from its cells, with quadratic elements unless the scene names `body.element`
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = super::adaptive::share)]
    pub(super) error: Option<f64>,
    /// Refine it for a quantity instead, relative to its value: normal_force, tangential_force, strain_energy,
    /// peak_displacement, largest_pressure, largest_von_mises, contact_area, stick_area, or a table of TOML as
    /// '{ mean_pressure = { box = [[0, 0, 0], [1, 1, 0]] } }'
    #[arg(long, value_name = "QUANTITY")]
    pub(super) quantity: Option<String>,
    /// Start no mesh that is forecast to end later than this many seconds after the command began
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = seconds)]
    pub(super) budget: Option<f64>,
    #[command(flatten)]
    pub(super) figures: FigureArguments,
    #[command(flatten)]
    pub(super) assembly: AssemblyFileArguments,
    #[command(flatten)]
    pub(super) engine: EngineArguments,
}

impl RunArguments {
    /// When the budget of a command that began at some time is spent; `None` without one, or where no clock reaches it.
    pub(super) fn deadline(&self, began: Instant) -> Option<Instant> {
        let budget = Duration::try_from_secs_f64(self.budget?).ok()?;
        began.checked_add(budget)
    }
}

/// Who holds the factor.
#[derive(Debug, Args)]
pub struct EngineArguments {
    /// Let another program hold the Cholesky factor, perhaps on several machines, such as 'mpirun -n 4 contact3d-mumps' (folder engines of
    /// the sources); it is not stored
    #[arg(long, value_name = "COMMAND")]
    pub(super) engine: Option<String>,
}

/// Where the assembled data go.
#[derive(Debug, Args)]
pub struct AssemblyFileArguments {
    /// Keep large assembled data in the run file too, not in assemble-DIGEST.h5 beside it
    #[arg(long)]
    self_contained: bool,
    /// Keep assembled data of any size in assemble-DIGEST.h5 beside the run file, so that later commits copy nothing
    #[arg(long, conflicts_with = "self_contained")]
    linked: bool,
}

impl AssemblyFileArguments {
    pub(super) fn choice(&self) -> AssemblyFile {
        match [self.self_contained, self.linked] {
            [true, _] => AssemblyFile::SelfContained,
            [false, true] => AssemblyFile::Linked,
            [false, false] => AssemblyFile::BySize,
        }
    }
}

/// Where pictures go.
#[derive(Debug, Args)]
pub struct FigureArguments {
    /// Folder for the pictures, in place of the usual one
    #[arg(long, value_name = "FOLDER")]
    pub figures: Option<PathBuf>,
    /// Draw no pictures
    #[arg(long, conflicts_with = "figures")]
    pub no_figures: bool,
}

impl FigureArguments {
    /// The folder for the pictures of a run file.
    pub(super) fn folder(&self, run_file: &Path) -> PathBuf {
        let given = self.figures.clone();
        given.unwrap_or_else(|| figures_folder(run_file))
    }

    /// That folder, looked at before anything is stored; `None` where no pictures are wanted.
    pub(super) fn beside(
        &self,
        run_file: &Path,
        drawing: Drawing,
        mut inputs: Inputs,
    ) -> Result<Option<PictureFolder>, StageError> {
        inputs.add(run_file);
        self.claim(&figures_folder(run_file), drawing, inputs)
    }

    /// The usual folder or the one that was asked for, as [`Self::beside`].
    pub(super) fn claim(
        &self,
        usual: &Path,
        drawing: Drawing,
        inputs: Inputs,
    ) -> Result<Option<PictureFolder>, StageError> {
        if self.no_figures {
            return Ok(None);
        }
        let folder = self.figures.as_deref().unwrap_or(usual);
        Ok(Some(PictureFolder::claim(folder, drawing, inputs)?))
    }
}

/// Cells along an edge, as many as a brick may have.
pub(super) fn n_div(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 1..=MOST_CELLS) => Ok(count),
        _ => Err(format!("expected a whole number from 1 to {MOST_CELLS}")),
    }
}

/// Seconds of a budget, up to thirty years.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    number_within(text, [1e-3, 1e9], "seconds")
}

/// Gigabytes of memory, from one byte on: one problem is held whatever the limit.
pub(super) fn gigabytes(text: &str) -> Result<f64, String> {
    number_within(text, [1e-9, 1e6], "gigabytes")
}

fn number_within(text: &str, [least, most]: [f64; 2], unit: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        _ => Err(format!("expected {unit} from {least:e} to {most:e}")),
    }
}

/// What to print, and where.
#[derive(Debug, Clone, Copy, Args)]
pub struct Output {
    /// Print only errors
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Print all results, and what each stage does
    #[arg(long, short, global = true)]
    pub verbose: bool,
    /// Print the results as JSON on standard output
    #[arg(long, global = true)]
    pub json: bool,
}

impl Arguments {
    /// Threads to use.
    pub fn thread_count(&self) -> usize {
        let available = || std::thread::available_parallelism().map_or(1, usize::from);
        self.threads.map_or_else(available, usize::from)
    }
}
