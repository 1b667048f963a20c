//! `branches`: paths of solutions in a key of the scene, stored, drawn and printed.

use std::path::PathBuf;

use clap::Args;
use studies::branches::{Branches, ParameterRange};

use super::{
    arguments::{FigureArguments, Output, SceneArguments},
    exit::Exit,
    progress, study, terminal,
};
use crate::{
    pipeline::{BranchesTask, Followed, SeriesFolder, SeriesKind, StageError, follow_branches},
    report,
    views::{Drawing, draw_branches},
};

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
pub(super) fn branches(
    arguments: &BranchesArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    let (scene, inputs, pictures) = study::begin(
        &arguments.scene,
        &arguments.file,
        &arguments.figures,
        Drawing::Branches,
    )?;
    let units = scene.scene.units;
    let claim = |folder: &PathBuf| SeriesFolder::claim(folder, SeriesKind::Paths, &inputs);
    let series = arguments.series.as_ref().map(claim).transpose()?;
    let task = BranchesTask {
        range: ParameterRange {
            key: arguments.parameter.clone(),
            from: arguments.from,
            to: arguments.to,
        },
        all: arguments.all,
    };
    let spinner = progress::spinner("branches", output);
    let mut observe = |branches: &Branches| spinner.set_message(where_it_stands(branches));
    let followed = follow_branches(
        &arguments.file,
        scene,
        &task,
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
    study::finish(
        output,
        pictures.as_ref(),
        units,
        |folder| draw_branches(folder, &branches, units),
        || report::branches::json(&branches, units),
        || report::branches::text(&branches, units),
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
    if !branches.is_followed() {
        return Some("a path ends where Newton's method does not settle; see its end".to_owned());
    }
    branches.lacks().then(|| {
        "signs of det R' at an end of the range do not add up to 1, so a solution there is missing or not regular, and no other start leads to it; \
         move the end a little with --from or --to, or follow another key with --parameter".to_owned()
    })
}

fn where_it_stands(branches: &Branches) -> String {
    let last = branches.paths.last();
    let point = last.and_then(|path| path.points.last());
    let parameter = point.map_or(branches.range.from, |point| point.parameter);
    let points: usize = branches.paths.iter().map(|path| path.points.len()).sum();
    format!(
        "path {}, point {points}, {} = {parameter:.6}",
        branches.paths.len(),
        branches.range.key
    )
}
