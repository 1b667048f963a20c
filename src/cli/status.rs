//! `status` and `check`: which stages are fresh, stale or missing, and whether a file is as it was written and agrees with itself.

use std::path::Path;

use contact3d::adaptation::AdaptiveStatus;
use runfile::{Reader, RunFile};

use super::{
    arguments::Output,
    exit::Exit,
    terminal::{self, say},
};
use crate::{
    format::{self, LAYOUT, Stage},
    pipeline::{OpenRun, StageError, contradictions, read_results},
    report::{self, SolvedRun, unit_words},
    sweep,
    views::{read_sweep, sweep_table},
};

/// `status`: stages, sizes and main results, of a sweep how its cases ended; reads only and takes no lock. Sizes and results are those
/// of fresh stages.
pub(super) fn status(file: &Path, output: &Output) -> Result<Exit, StageError> {
    if sweep_table(file).exists() {
        return sweep_status(file, output);
    }
    let run = OpenRun::open(file)?;
    let (reader, scene) = (&run.reader, &run.input.scene);
    let is_fresh = |stage| run.is_fresh(stage);
    let results = is_fresh(Stage::Post).then(|| read_results(reader, &run.input));
    let results = results.transpose()?;
    let ended = run.levels.as_ref().map(|(_, status)| *status);
    let solved = results
        .as_ref()
        .map(|results| SolvedRun::new(scene, results).after_levels(ended));
    let outcome = is_fresh(Stage::Solve).then(|| format::read_outcome(reader));
    let outcome = outcome.transpose()?.map(|it| report::outcome(&it, scene));
    let features = report::features(scene, &format::read_sizes(reader, &is_fresh)?);
    let stages = report::stages(reader, scene, &run.states)?;
    let advice = format::read_advice(reader)?;
    let kept = run.unfinished_increments()?;
    let is_busy = RunFile::is_busy(file);
    let levels = run.levels.as_ref().zip(scene.adapt);
    let levels =
        levels.map(|((levels, _), adapt)| report::adaptation_table(scene, levels, adapt.error));
    if output.json {
        terminal::json(&serde_json::json!({
            "title": scene.title,
            "effects": features.json(),
            "stages": stages.json(),
            "outcome": outcome.map(|outcome| outcome.json()),
            "summary": solved.as_ref().map(|solved| solved.summary_with_warnings().words_json()),
            "results": solved.as_ref().map(|solved| solved.figures().json()),
            "advice": advice,
            "kept_increments": kept.len(),
            "is_busy": is_busy,
            "levels": levels.map(|levels| levels.json()),
            "units": unit_words(scene.units),
        }));
    } else {
        let mut text = format!("{}\n{}\n", file.display(), scene.shown_title());
        let summary = solved
            .map(|solved| solved.summary_with_warnings())
            .or(outcome);
        text += &summary.map_or_else(String::new, |summary| summary.text(2, 20));
        text += &stages.text();
        if let Some(last) = kept.last() {
            let (kept, all) = (kept.len(), scene.increments().len());
            let last = report::increment_in_words(scene, *last);
            text += &format!("{kept} of {all} increments are kept, the last {last}\n");
        }
        text += &levels.map_or_else(String::new, |levels| levels.text());
        let is_unfinished = !kept.is_empty() || ended == Some(AdaptiveStatus::Refining);
        text += match (is_busy, is_unfinished) {
            (true, _) => "a command is at work on this file\n",
            (false, true) => {
                "no command is at work on this file: the same `run` goes on from there\n"
            }
            (false, false) => "",
        };
        text += &format!("model features\n{}", features.text(2, 28));
        if let Some(advice) = &advice {
            text += &format!("  accuracy  {advice}\n");
        }
        terminal::result(&text);
    }
    Ok(Exit::Done)
}

/// How the cases of a sweep ended, and whether it is at work.
fn sweep_status(folder: &Path, output: &Output) -> Result<Exit, StageError> {
    let (table, is_busy) = (read_sweep(folder)?, sweep::is_busy(folder));
    if output.json {
        terminal::json(&serde_json::json!({
            "cases": table.n_cases, "status": table.counts(), "is_busy": is_busy,
        }));
    } else {
        let (shown, counts) = (folder.display(), table.counts_in_words());
        let next = match (is_busy, counts.contains("missing")) {
            (true, _) => "a sweep is at work in this folder",
            (false, true) => {
                "no sweep is at work in this folder: the same command goes on with it, `sweep summary` adds cases of its last seconds"
            }
            (false, false) => "no sweep is at work in this folder",
        };
        terminal::result(&format!(
            "{shown}\n  {counts}\n  {next}\n  `report {shown}` shows each case\n"
        ));
    }
    Ok(Exit::Done)
}

/// `check`: whether a file is as it was written, with the files that it links, and its arrays have the certificate and the status that
/// it states; reads only and takes no lock.
pub(super) fn check(file: &Path, output: &Output) -> Result<Exit, StageError> {
    let reader = Reader::open(file, LAYOUT)?;
    let mut problems: Vec<String> = reader.link_problems().map(|it| it.to_string()).collect();
    if problems.is_empty() {
        problems = contradictions(file)?;
    }
    if output.json {
        terminal::json(&serde_json::json!({ "problems": problems }));
    }
    for problem in &problems {
        terminal::message(&format!("error: {problem}"));
    }
    if problems.is_empty() {
        say(
            output,
            "every byte is as it was written, and the results agree with each other",
        );
        return Ok(Exit::Done);
    }
    Ok(Exit::BadInput)
}
