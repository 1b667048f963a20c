//! `accuracy`: both studies, measured, stored, drawn and printed.

use std::path::PathBuf;

use clap::Args;
use contact3d::solver::Status;
use studies::accuracy::{Accuracy, AccuracySettings};

use super::{
    arguments::{FigureArguments, Output, SceneArguments, n_div, seconds},
    exit::Exit,
    progress, study, terminal,
};
use crate::{
    pipeline::{StageError, measure_accuracy},
    report,
    views::{Drawing, draw_accuracy},
};

/// Arguments of `accuracy`.
#[derive(Debug, Args)]
pub struct AccuracyArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    /// The run file, created or updated
    pub file: PathBuf,
    /// Smallest n_div of the meshes, the cells along the shortest edge; the scene's if that is less
    #[arg(long, value_name = "N_DIV", default_value_t = 4, value_parser = n_div)]
    pub coarsest: usize,
    /// n_div of the finest mesh, a multiple of the scene's; by default 4, 2 or 1 times that, up to 32
    #[arg(long, value_name = "N_DIV", value_parser = n_div)]
    pub finest: Option<usize>,
    /// Seconds for the solves of all methods; what would take longer is left out
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, allow_negative_numbers = true, value_parser = seconds)]
    pub budget: f64,
    #[command(flatten)]
    pub(super) figures: FigureArguments,
}

/// `accuracy`: runs both studies, stores and draws them, and says what they mean.
pub(super) fn accuracy(
    arguments: &AccuracyArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    let (scene, _, pictures) = study::begin(
        &arguments.scene,
        &arguments.file,
        &arguments.figures,
        Drawing::Accuracy,
    )?;
    let units = scene.scene.units;
    let settings = AccuracySettings {
        budget: arguments.budget,
        coarsest: arguments.coarsest,
        finest: arguments.finest,
    };
    let spinner = progress::spinner("accuracy", output);
    let measured = measure_accuracy(&arguments.file, scene, &settings, threads, &mut |step| {
        progress::show_study(&spinner, output, step);
    });
    spinner.finish_and_clear();
    let accuracy = measured?;
    study::finish(
        output,
        pictures.as_ref(),
        units,
        |folder| draw_accuracy(folder, &accuracy),
        || report::accuracy::json(&accuracy, units),
        || report::accuracy::text(&accuracy, units),
    )?;
    let is_complete = is_complete(&accuracy);
    if !is_complete {
        terminal::message(
            "NOT CONVERGED: the reference or a mesh of the study; its errors are not errors",
        );
    }
    Ok(Exit::of(is_complete))
}

/// Whether the reference and all meshes were solved.
fn is_complete(accuracy: &Accuracy) -> bool {
    let reference = accuracy.algebraic.iter().map(|l| l.reference_status);
    let studies = accuracy.discretisation.iter();
    let levels = studies.flat_map(|study| study.levels.iter().map(|level| level.status));
    reference.chain(levels).all(Status::is_solved)
}
