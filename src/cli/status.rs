//! The command `status`: which stages are fresh, stale, damaged or missing.

use runfile::Reader;

use super::{
    arguments::{Output, StageArguments},
    exit::Exit,
    terminal,
};
use crate::{
    format::{self, LAYOUT, Stage},
    pipeline::{Freshness, StageError, require_undamaged, states},
    report::{self, unit_words},
    views::sweep_table,
};

/// `status`: stages, sizes and main results; reads only and takes no lock. Sizes and results are those of fresh
/// stages; a damaged one is bad input.
pub(super) fn status(arguments: &StageArguments, output: &Output) -> Result<Exit, StageError> {
    if sweep_table(&arguments.file).exists() {
        let folder = arguments.file.display();
        return Err(StageError::Unfit {
            file: arguments.file.clone(),
            reason: format!(
                "this is the folder of a sweep: `report {folder}` shows its cases, and the same `sweep` command goes on with it"
            ),
        });
    }
    let reader = Reader::open(&arguments.file, LAYOUT)?;
    let scene = format::read_scene(&reader, &arguments.file)?.scene;
    let states = states(&reader, &scene);
    let is_fresh = |stage| {
        let mut fresh = states.iter().filter(|s| s.freshness == Freshness::Fresh);
        fresh.any(|state| state.stage == stage)
    };
    let summary = is_fresh(Stage::Post).then(|| format::read_summary(&reader));
    let summary = summary.transpose()?;
    let summary = summary.map(|summary| report::summary(&summary, &scene));
    let outcome = is_fresh(Stage::Solve).then(|| format::read_outcome(&reader));
    let outcome = outcome.transpose()?;
    let outcome = outcome.map(|outcome| report::outcome(&outcome, &scene));
    let features = report::features(&scene, &format::read_sizes(&reader, &is_fresh)?);
    let stages = report::stages(&reader, &scene, &states)?;
    let advice = format::read_advice(&reader)?;
    if output.json {
        terminal::json(&serde_json::json!({
            "title": scene.title,
            "effects": features.json(),
            "stages": stages.json(),
            "outcome": outcome.map(|outcome| outcome.json()),
            "results": summary.map(|summary| summary.json()),
            "advice": advice,
            "units": unit_words(scene.units),
        }));
    } else {
        let mut text = format!("{}\n{}", arguments.file.display(), scene.shown_title());
        text += &stages.text();
        text += &format!("model features\n{}", features.text(2, 28));
        if outcome.is_some() || summary.is_some() {
            text += "results\n";
        }
        for figures in [&outcome, &summary].into_iter().flatten() {
            text += &figures.text(2, 28);
        }
        if let Some(advice) = &advice {
            text += &format!("  accuracy  {advice}\n");
        }
        terminal::result(&text);
    }
    // What can be said of the file is said.
    Ok(match require_undamaged(&arguments.file, &states) {
        Ok(()) => Exit::Done,
        Err(error) => {
            terminal::message(&format!("error: {error}"));
            Exit::BadInput
        }
    })
}
