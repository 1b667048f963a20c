//! `accuracy`, `bound` and `branches`: measured, stored, drawn and printed.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use clap::{Args, Subcommand};
use contact3d::{scene::SceneFile, solver::Status};
use indicatif::ProgressBar;
use serde_json::Value;
use studies::{
    accuracy::{Accuracy, AccuracySettings},
    branches::{Branches, ParameterRange},
};
use units::{Dimension, Units};

use super::{
    arguments::{FigureArguments, Output, SceneArguments, n_div, seconds},
    exit::Exit,
    override_scene, progress, terminal,
};
use crate::{
    output::Inputs,
    pipeline::{
        PATH_SERIES, SeriesFolder, StageError,
        studies::{Followed, bound_error, follow_branches, measure_accuracy},
    },
    report::{self, unit_words},
    views::{Drawing, PictureFolder, draw_accuracy, draw_branches},
};

/// The studies of a scene or its solution.
#[derive(Debug, Subcommand)]
pub enum Study {
    /// Measure the errors of solvers and meshes for a scene, and their costs
    Accuracy(AccuracyArguments),
    /// Prove an upper bound of the discretisation error of a solved run file
    Bound {
        /// The run file, solved
        file: PathBuf,
    },
    /// Follow solutions while one key of the scene changes: folds, branches, all solutions at one value
    Branches(BranchesArguments),
}

impl Study {
    /// Does what the command asks.
    pub(super) fn perform(&self, output: &Output, threads: usize) -> Result<Exit, StageError> {
        match self {
            Self::Accuracy(settings) => accuracy(settings, output, threads),
            Self::Bound { file } => bound(file, output, threads),
            Self::Branches(range) => branches(range, output, threads),
        }
    }
}

/// Arguments of `accuracy`.
#[derive(Debug, Args)]
pub struct AccuracyArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    /// The run file, created or updated
    pub file: PathBuf,
    /// Of a brick: smallest n_div of the meshes, the cells along the shortest edge, or the scene's if that is less; by default 4
    #[arg(long, value_name = "N_DIV", value_parser = n_div)]
    pub coarsest: Option<usize>,
    /// Of a brick: n_div of the finest mesh, a multiple of the scene's; by default 4, 2 or 1 times that, up to 32
    #[arg(long, value_name = "N_DIV", value_parser = n_div)]
    pub finest: Option<usize>,
    /// Of a mesh file or several bodies: most unknowns of the two finer meshes, by a forecast; by default 320000
    #[arg(long, value_name = "COUNT")]
    pub unknowns: Option<usize>,
    /// Seconds, half of them for the solves of all methods; what is forecast to take longer is left out; by default 10 for these solves alone
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = seconds)]
    pub budget: Option<f64>,
    #[command(flatten)]
    pub(super) figures: FigureArguments,
}

/// `accuracy`: runs both studies, stores and draws them, and says what they mean.
fn accuracy(
    arguments: &AccuracyArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    let (scene, _, pictures) = begin(
        &arguments.scene,
        &arguments.file,
        &arguments.figures,
        Drawing::Accuracy,
    )?;
    let shown = scene.scene.clone();
    let settings = AccuracySettings {
        budget: arguments.budget,
        coarsest: arguments.coarsest,
        finest: arguments.finest,
        unknowns: arguments.unknowns,
    };
    let spinner = progress::spinner("accuracy", output);
    let measured = measure_accuracy(&arguments.file, scene, &settings, threads, &mut |step| {
        progress::show_study(&spinner, output, step);
    });
    spinner.finish_and_clear();
    let accuracy = measured?;
    finish(
        output,
        pictures.as_ref(),
        shown.units,
        |folder| draw_accuracy(folder, &accuracy, shown.units),
        || report::studies::accuracy_json(&accuracy, &shown),
        || report::studies::accuracy_text(&accuracy, &shown),
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
    let levels = accuracy.discretisation.levels.iter();
    let levels = levels.map(|level| level.status);
    reference.chain(levels).all(Status::is_solved)
}

/// `bound`: computes, stores and prints.
fn bound(file: &Path, output: &Output, threads: usize) -> Result<Exit, StageError> {
    let spinner = progress::spinner("bound", output);
    let bounded = bound_error(file, threads);
    spinner.finish_and_clear();
    let (scene, bound, estimate) = bounded?;
    let figures = report::studies::bound(&bound, &scene, estimate);
    finish(
        output,
        None,
        scene.units,
        |_| Ok(Vec::new()),
        || figures.json(),
        || figures.text(0, 28),
    )?;
    Ok(Exit::Done)
}

/// Arguments of `branches`.
#[derive(Debug, Args)]
pub struct BranchesArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    /// The run file, created or updated
    pub file: PathBuf,
    /// The key of the scene that changes, a number such as friction.coefficient.constant or traction.0.value.2
    #[arg(long, value_name = "KEY")]
    pub parameter: String,
    /// Its value where paths begin
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    pub from: f64,
    /// Its value at the other end of the range
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    pub to: f64,
    /// Search for all solutions at both ends of the range, and follow each
    #[arg(long)]
    pub all: bool,
    /// Folder for the points of each path as a series that ParaView plays, path_1.vtkhdf and so on
    #[arg(long, value_name = "FOLDER")]
    pub series: Option<PathBuf>,
    #[command(flatten)]
    pub(super) figures: FigureArguments,
}

/// `branches`: follows the paths, stores and draws them, and lists their special points.
fn branches(
    arguments: &BranchesArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    let (scene, inputs, pictures) = begin(
        &arguments.scene,
        &arguments.file,
        &arguments.figures,
        Drawing::Branches,
    )?;
    let units = scene.scene.units;
    let series = SeriesFolder::claim(arguments.series.as_deref(), PATH_SERIES, &inputs)?;
    let range = ParameterRange {
        key: arguments.parameter.clone(),
        from: arguments.from,
        to: arguments.to,
    };
    let spinner = progress::spinner("branches", output);
    let began = Instant::now();
    let mut n_said = 0;
    let mut observe = |branches: &Branches, waiting: Option<usize>| {
        where_it_stands(branches, waiting, units, &spinner, began);
        if branches.paths.len() > n_said {
            n_said = branches.paths.len();
            spinner.suspend(|| terminal::say(output, &last_point(branches, units)));
        }
    };
    let followed = follow_branches(
        &arguments.file,
        scene,
        range,
        arguments.all,
        series.as_ref(),
        threads,
        &mut observe,
    );
    spinner.finish_and_clear();
    let Followed {
        branches,
        series: files,
    } = followed?;
    if let Some(folder) = &arguments.series {
        terminal::say_files(output, "series", &files, folder);
    }
    finish(
        output,
        pictures.as_ref(),
        units,
        |folder| draw_branches(folder, &branches, units),
        || report::studies::branches_json(&branches, units),
        || report::studies::branches_text(&branches, units),
    )?;
    let shortcoming = shortcoming(&branches);
    if let Some(reason) = &shortcoming {
        terminal::message(&format!("NOT CONVERGED: {reason}"));
    }
    Ok(Exit::of(shortcoming.is_none()))
}

/// Why the search did not end as it should; `None` where it did.
fn shortcoming(branches: &Branches) -> Option<String> {
    if branches.left_out > 0 {
        return Some(format!(
            "{} half paths from branch points are not followed; choose a smaller range",
            branches.left_out
        ));
    }
    let mut ends = (1..).zip(branches.paths.iter().map(|path| path.end));
    if let Some((path, end)) = ends.find(|(_, end)| end.is_early()) {
        let words = report::studies::end_words(end);
        return Some(format!(
            "path {path} does not reach the end of the range: {words}"
        ));
    }
    branches.is_incomplete().then(|| {
        "signs of det R' at an end of the range do not add up to 1, so a solution there is missing or not regular, and no other start leads to it; \
         move the end a little with --from or --to, or follow another key with --parameter".to_owned()
    })
}

/// The point that the last path has come to.
fn last_point(branches: &Branches, units: Units) -> String {
    let (n_paths, key) = (branches.paths.len(), &branches.range.key);
    let Some((path, point)) = (branches.paths.last()).and_then(|p| Some((p, p.points.last()?)))
    else {
        return "searching for solutions".to_owned();
    };
    format!(
        "path {n_paths}, point {}: {key} = {:.6}, normal force {:.6e}{}",
        path.points.len(),
        point.parameter,
        point.normal_force,
        units.of(Dimension::FORCE).beside()
    )
}

/// Lets a spinner say where paths stand, and how long the rest takes if each goes once through the range.
fn where_it_stands(
    branches: &Branches,
    waiting: Option<usize>,
    units: Units,
    spinner: &ProgressBar,
    began: Instant,
) {
    let n_paths = branches.paths.len();
    let Some(waiting) = waiting else {
        spinner.set_message("searching for solutions");
        return;
    };
    let points = branches.paths.last().map_or(&[][..], |path| &path.points);
    let ends = points.first().zip(points.last());
    let share = ends.map_or(0.0, |(first, last)| {
        let [first, last] = [first, last].map(|point| point.parameter);
        let goals = [branches.range.from, branches.range.to];
        let ahead = goals.map(|goal| (last - first) / (goal - first));
        let ahead = ahead.into_iter().filter(|share| share.is_finite());
        ahead.fold(0.0, f64::max).min(1.0)
    });
    let (done, of) = (n_paths as f64 - 1.0 + share, n_paths + waiting);
    let seconds = began.elapsed().as_secs_f64();
    let left = (done > 0.0).then(|| seconds * (of as f64 - done) / done);
    let words = last_point(branches, units);
    progress::piece(spinner, &words, [n_paths, of], left, Instant::now());
}

/// The scene, the files that belong to it, and the folder for pictures where these are wanted; everything that is to be written is
/// looked at before anything is measured.
fn begin(
    scene: &SceneArguments,
    run_file: &Path,
    figures: &FigureArguments,
    drawing: Drawing,
) -> Result<(SceneFile, Inputs, Option<PictureFolder>), StageError> {
    let (scene, inputs) = override_scene::read_with_inputs(scene)?;
    inputs.refuse(run_file)?;
    let pictures = figures.beside(run_file, drawing, inputs.clone())?;
    Ok((scene, inputs, pictures))
}

/// Draws into the folder, where one is wanted, says how many files came of it, and prints the results. These are stored by then.
fn finish(
    output: &Output,
    pictures: Option<&PictureFolder>,
    units: Units,
    draw: impl FnOnce(&PictureFolder) -> Result<Vec<PathBuf>, StageError>,
    json: impl FnOnce() -> Value,
    text: impl FnOnce() -> String,
) -> Result<(), StageError> {
    if let Some(pictures) = pictures {
        let files = draw(pictures).map_err(StageError::after_storing)?;
        terminal::say_files(output, "figures", &files, pictures.path());
    }
    let with_units = || {
        let mut json = json();
        json["units"] = unit_words(units);
        json
    };
    terminal::print(output, with_units, text);
    Ok(())
}
