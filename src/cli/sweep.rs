//! `sweep` and its parts.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use clap::{Args, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};

use super::{
    arguments::{FigureArguments, MOST_THREADS, Output, gigabytes},
    exit::Exit,
    progress,
    terminal::{self, say},
};
use crate::{
    pipeline::{CASE_SERIES, SeriesFolder, StageError, memory_for_sweeps},
    sweep::{self, CSV_FILE, Event, Options, Outcome, Plan, SUMMARY_FILE},
    views::{Drawing, PictureFolder, draw_sweep},
};

/// Arguments of `sweep`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct SweepArguments {
    #[command(subcommand)]
    part: Option<SweepPart>,
    /// The sweep, a TOML file such as pipelines/sweep_friction.toml
    #[arg(required = true)]
    sweep: Option<PathBuf>,
    /// The folder of the run files and tables, created or continued
    #[arg(required = true)]
    folder: Option<PathBuf>,
    /// Cases run at the same time; one per thread by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    jobs: Option<u16>,
    /// Memory for assembled problems in gigabytes; three quarters of what is free by default
    #[arg(long, value_name = "GB", allow_negative_numbers = true, value_parser = gigabytes)]
    memory: Option<f64>,
    #[command(flatten)]
    figures: FigureArguments,
    /// Folder for the cases as series that ParaView plays, one for each mesh: cases_1.vtkhdf and so on
    #[arg(long, value_name = "FOLDER")]
    series: Option<PathBuf>,
    #[command(flatten)]
    options: CaseOptions,
}

/// A sweep file and the folder of its cases.
#[derive(Debug, Args)]
struct SweepFolder {
    /// The sweep, a TOML file such as pipelines/sweep_friction.toml
    sweep: PathBuf,
    /// The folder of the run files and tables, created or continued
    folder: PathBuf,
}

/// How cases are run.
#[derive(Debug, Args)]
struct CaseOptions {
    /// Try cases again that failed before
    #[arg(long)]
    retry_failed: bool,
    /// Copy the shared data into every run file instead of linking them
    #[arg(long)]
    self_contained: bool,
}

/// The parts of a sweep, for engines that run many machines.
#[derive(Debug, Subcommand)]
enum SweepPart {
    /// List the cases as JSON: name, run file, start, settings
    Plan(SweepFolder),
    /// Run one case
    RunCase {
        #[command(flatten)]
        place: SweepFolder,
        /// The name of the case, as `sweep plan` lists it
        id: String,
        #[command(flatten)]
        options: CaseOptions,
    },
    /// Write the tables of the cases that are done
    Summary {
        #[command(flatten)]
        place: SweepFolder,
        /// Folder for the cases as series that ParaView plays, one for each mesh: cases_1.vtkhdf and so on
        #[arg(long, value_name = "FOLDER")]
        series: Option<PathBuf>,
    },
}

/// `sweep` and its parts.
pub(super) fn sweep(
    arguments: &SweepArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    match &arguments.part {
        Some(SweepPart::Plan(place)) => plan(place),
        Some(SweepPart::RunCase { place, id, options }) => {
            run_case(place, id, &case_options(options, threads), output)
        }
        Some(SweepPart::Summary { place, series }) => summary(place, series.as_deref(), output),
        None => run_all(arguments, output, threads),
    }
}

fn plan(place: &SweepFolder) -> Result<Exit, StageError> {
    let plan = Plan::read(&place.sweep)?;
    terminal::json(&plan.json(&place.folder));
    Ok(Exit::Done)
}

fn summary(
    place: &SweepFolder,
    series: Option<&Path>,
    output: &Output,
) -> Result<Exit, StageError> {
    let plan = Plan::read(&place.sweep)?;
    fs::read_dir(&place.folder).map_err(|source| StageError::Io {
        action: "list the folder",
        file: place.folder.clone(),
        source,
    })?;
    let inputs = plan.inputs.clone();
    let pictures = PictureFolder::claim(&figures_folder(&place.folder), Drawing::Sweep, inputs)?;
    let series = SeriesFolder::claim(series, CASE_SERIES, &plan.inputs)?;
    sweep::write_summary(&plan, &place.folder)?;
    say(output, &format!("tables in {}", place.folder.display()));
    show(
        &plan,
        &place.folder,
        series.as_ref(),
        Some(&pictures),
        output,
    )?;
    if output.json {
        let tables = [SUMMARY_FILE, CSV_FILE].map(|name| place.folder.join(name));
        terminal::json(&serde_json::json!({ "written": tables }));
    }
    Ok(Exit::Done)
}

fn case_options(options: &CaseOptions, threads: usize) -> Options {
    Options {
        jobs: 1,
        threads,
        retry_failed: options.retry_failed,
        self_contained: options.self_contained,
        memory: u64::MAX,
    }
}

fn run_case(
    place: &SweepFolder,
    id: &str,
    options: &Options,
    output: &Output,
) -> Result<Exit, StageError> {
    let plan = Plan::read(&place.sweep)?;
    let event = sweep::run_case(&plan, &place.folder, id, options)?;
    say(output, &format!("case {id} {}", event.word()));
    if output.json {
        let error = match &event {
            Event::Failed(error) => Some(error),
            _ => None,
        };
        let event = serde_json::json!({ "case": id, "event": event.word(), "error": error });
        terminal::json(&event);
    }
    Ok(match event {
        Event::Kept | Event::Computed(_) => Exit::Done,
        Event::Failed(error) => {
            let case = plan.find(id).map(|index| plan.cases[index].in_words())?;
            terminal::message(&format!("error: {case}: {error}"));
            Exit::NotConverged
        }
        Event::Busy => {
            let busy = format!("error: case {id} is busy: another process is writing it");
            terminal::message(&busy);
            Exit::BadInput
        }
    })
}

fn run_all(whole: &SweepArguments, output: &Output, threads: usize) -> Result<Exit, StageError> {
    let (Some(sweep), Some(folder)) = (&whole.sweep, &whole.folder) else {
        return Ok(Exit::BadInput);
    };
    let plan = Plan::read(sweep)?;
    let usual = figures_folder(folder);
    let inputs = plan.inputs.clone();
    let pictures = whole.figures.claim(&usual, Drawing::Sweep, inputs)?;
    let series = whole.series.as_deref();
    let series = SeriesFolder::claim(series, CASE_SERIES, &plan.inputs)?;
    for warning in warnings(&plan) {
        say(output, &format!("warning: {warning}"));
    }
    let bar = progress_bar(plan.cases.len(), output);
    let options = Options {
        jobs: whole.jobs.map_or(threads, usize::from),
        memory: whole
            .memory
            .map_or_else(memory_for_sweeps, |gigabytes| (gigabytes * 1e9) as u64),
        ..case_options(&whole.options, threads)
    };
    progress::on_sweep(folder, 0, plan.cases.len());
    let outcome = sweep::run(&plan, folder, &options, &|index, event| {
        if let Event::Failed(error) = event {
            let line = format!("{} failed: {error}", plan.cases[index].in_words());
            bar.suspend(|| terminal::message(&line));
        }
        bar.inc(1);
        progress::on_sweep(folder, bar.position() as usize, plan.cases.len());
    });
    bar.finish_and_clear();
    let outcome = outcome?;
    report(&plan, folder, &outcome, output);
    show(&plan, folder, series.as_ref(), pictures.as_ref(), output)?;
    let unfinished = ["failed", "busy"].map(|word| outcome.count_of(word));
    Ok(Exit::of(
        unfinished == [0, 0] && outcome.not_converged.is_empty(),
    ))
}

/// Writes series, and charts of what varies, where they are wanted; the tables are stored by then.
fn show(
    plan: &Plan,
    folder: &Path,
    series: Option<&SeriesFolder>,
    pictures: Option<&PictureFolder>,
    output: &Output,
) -> Result<(), StageError> {
    if let Some(series) = series {
        let files = sweep::write_series(plan, folder, series)?;
        terminal::say_files(output, "series", &files, series.path());
    }
    if let Some(pictures) = pictures {
        let files = draw_sweep(folder, pictures).map_err(StageError::after_storing)?;
        if !files.is_empty() {
            terminal::say_files(output, "figures", &files, pictures.path());
        }
    }
    Ok(())
}

/// Where the charts of a sweep go by default.
fn figures_folder(folder: &Path) -> PathBuf {
    folder.join("figures")
}

/// What the scenes of the cases show, each warning once.
fn warnings(plan: &Plan) -> BTreeSet<String> {
    let cases = plan.cases.iter();
    let warnings = cases.flat_map(|case| case.scene.scene.warnings());
    warnings.map(|warning| warning.to_string()).collect()
}

/// Cases by their number in the plan with what is said of them, ten at most.
fn told(plan: &Plan, cases: &[(usize, String)]) -> String {
    const MOST: usize = 10;
    let lines = cases.iter().take(MOST);
    let lines =
        lines.map(|(number, words)| format!("\n  {}: {words}", plan.cases[*number].in_words()));
    match cases.len().saturating_sub(MOST) {
        0 => lines.collect(),
        more => lines.chain([format!("\n  and {more} more")]).collect(),
    }
}

fn report(plan: &Plan, folder: &Path, outcome: &Outcome, output: &Output) {
    let (not_converged, warnings) = (&outcome.not_converged, &outcome.warnings);
    let cases = plan.cases.len();
    let counts = ["computed", "kept", "failed", "busy"].map(|word| outcome.count_of(word));
    let [computed, kept, failed, busy] = counts;
    terminal::print(
        output,
        || {
            serde_json::json!({
                "cases": cases, "computed": computed, "kept": kept, "failed": failed,
                "busy": busy, "not_converged": not_converged.len(), "warnings": warnings.len(),
            })
        },
        || {
            format!(
                "{cases} cases: {computed} computed, {kept} kept, {failed} failed, {busy} busy elsewhere; \
                 {} not converged{}\n{}table {}",
                not_converged.len(),
                told(plan, not_converged),
                match warnings.len() {
                    0 => String::new(),
                    n => format!("{n} warnings of solutions{}\n", told(plan, warnings)),
                },
                folder.join(CSV_FILE).display()
            )
        },
    );
}

/// A bar with the time left on a terminal; elsewhere, and when quiet, nothing.
fn progress_bar(cases: usize, output: &Output) -> ProgressBar {
    if output.quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(cases as u64);
    let template = "{bar:40} {pos}/{len} cases, {elapsed} gone, {eta} left";
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}
