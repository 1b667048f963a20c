//! The command `status`: which stages are fresh, stale, damaged or missing.

use contact3d::scene::ModelFeatures;
use runfile::Reader;
use units::Units;

use super::{
    arguments::{Output, StageArguments},
    exit::Exit,
    features,
    results_json::unit_words,
    terminal,
};
use crate::{
    format::{self, FormatError, LAYOUT, OutcomeWords, Stage},
    pipeline::{Freshness, StageError, StageState, states},
};

/// `status`: stages, sizes and main results; reads only and takes no lock. Sizes and results are those of fresh
/// stages; a damaged one is bad input.
pub(super) fn status(arguments: &StageArguments, output: &Output) -> Result<Exit, StageError> {
    let reader = Reader::open(&arguments.file, LAYOUT)?;
    let scene = format::read_scene(&reader, &arguments.file)?.scene;
    let states = states(&reader, &scene);
    let is_fresh = |stage| {
        let mut fresh = states.iter().filter(|s| s.freshness == Freshness::Fresh);
        fresh.any(|state| state.stage == stage)
    };
    let summary = match is_fresh(Stage::Post) {
        true => Some(format::read_summary(&reader)?),
        false => None,
    };
    let outcome = match is_fresh(Stage::Solve) {
        true => Some(format::read_outcome(&reader)?),
        false => None,
    };
    let increments = scene.increments().len();
    let features = ModelFeatures::of(&scene);
    let sizes = format::read_sizes(&reader, &is_fresh)?;
    let advice = format::read_advice(&reader)?;
    if output.json {
        let features = features::json(&features, &sizes);
        let mut status = json(&reader, &scene.title, features, &states, summary.as_ref())?;
        status["advice"] = advice.into();
        status["outcome"] = outcome
            .as_ref()
            .map(|outcome| outcome_json(outcome, increments))
            .into();
        status["units"] = unit_words(scene.units);
        terminal::json(&status);
    } else {
        let mut text = format!("{}\n{}\n", arguments.file.display(), scene.shown_title());
        for state in &states {
            text += &stage_line(&reader, state)?;
            text.push('\n');
        }
        text += &format!("model features\n{}", features::lines(&features, &sizes));
        if outcome.is_some() || summary.is_some() {
            text += "results\n";
        }
        if let Some(outcome) = &outcome {
            text += &outcome_line(outcome, increments);
        }
        if let Some(summary) = &summary {
            text += &summary_lines(summary, scene.units);
        }
        if let Some(advice) = &advice {
            text += &format!("  accuracy  {advice}\n");
        }
        terminal::result(&text);
    }
    let damaged = |state: &&StageState| matches!(state.freshness, Freshness::Damaged(_));
    let Some(state) = states.iter().find(damaged) else {
        return Ok(Exit::Done);
    };
    let (stage, why) = (state.stage.word(), state.freshness.why());
    terminal::message(&format!("error: `{stage}` cannot be used, {why}"));
    Ok(Exit::BadInput)
}

fn stage_line(reader: &Reader, state: &StageState) -> Result<String, FormatError> {
    let mut line = format!("  {:<9} {:<8}", state.stage.word(), state.freshness.word());
    if let Some(stored) = &state.stored {
        let megabytes = reader.group_bytes(state.stage.group())? as f64 / 1e6;
        let record = &stored.record;
        line += &format!(
            "{megabytes:>10.3} MB  {:>9.3} s  {} threads  {}",
            record.seconds, record.threads, record.date
        );
    }
    if let Some((name, _)) = reader.linked_file(state.stage.group()) {
        line += &format!("  in {name}");
    }
    if let Freshness::Stale(why) | Freshness::Damaged(why) = &state.freshness {
        line += &format!("  ({why})");
    }
    Ok(line)
}

/// How the solve ended; `all` increments make the history of a scene that has one.
fn outcome_line(outcome: &OutcomeWords, all: usize) -> String {
    let failed = match outcome.status.is_solved() {
        true => "",
        false => "FAILED: ",
    };
    let status = outcome.status.word();
    let (method, accuracy) = (outcome.method, outcome.accuracy);
    let increments = match outcome.increments {
        0 => String::new(),
        solved => format!(", {solved} of {all} increments"),
    };
    format!("  solve     {failed}{status} by {method}, accuracy {accuracy:.1e}{increments}\n")
}

fn outcome_json(outcome: &OutcomeWords, all: usize) -> serde_json::Value {
    let increments = Some(outcome.increments).filter(|solved| *solved > 0);
    serde_json::json!({
        "status": outcome.status.word(),
        "solved": outcome.status.is_solved(),
        "method": outcome.method,
        "accuracy": outcome.accuracy,
        "increments": increments.map(|solved| serde_json::json!({ "solved": solved, "of": all })),
    })
}

fn summary_lines(summary: &format::Summary, units: Units) -> String {
    let mut text = String::new();
    if let Some(contact) = &summary.contact {
        if let [open, stick, slip] = contact.zone_counts[..] {
            text += &format!("  panes     open {open}, stick {stick}, slip {slip}\n");
        }
        text += &format!(
            "  forces    normal {:.6e} {}, largest pressure {:.6e} {}\n",
            contact.normal_force,
            units.force(),
            contact.largest_pressure,
            units.stress()
        );
    }
    let energy = units.energy();
    text + &format!("  energy    {:.6e} {energy}\n", summary.strain_energy)
}

fn json(
    reader: &Reader,
    title: &str,
    features: serde_json::Value,
    states: &[StageState],
    summary: Option<&format::Summary>,
) -> Result<serde_json::Value, FormatError> {
    let mut stages = Vec::new();
    for state in states {
        let bytes = match &state.stored {
            Some(_) => reader.group_bytes(state.stage.group())?,
            None => 0,
        };
        stages.push(serde_json::json!({
            "stage": state.stage.word(),
            "state": state.freshness.word(),
            "why": state.freshness.why(),
            "bytes": bytes,
            "linked_file": reader.linked_file(state.stage.group()).map(|(name, bytes)| serde_json::json!({ "name": name, "bytes": bytes })),
            "digest": state.stored.as_ref().map(|s| &s.digest),
            "seconds": state.stored.as_ref().map(|s| s.record.seconds),
        }));
    }
    let results = summary.map(|s| {
        serde_json::json!({
            "zone_counts": s.contact.as_ref().map(|c| &c.zone_counts),
            "normal_force": s.contact.as_ref().map(|c| c.normal_force),
            "largest_pressure": s.contact.as_ref().map(|c| c.largest_pressure),
            "strain_energy": s.strain_energy,
        })
    });
    Ok(
        serde_json::json!({ "title": title, "effects": features, "stages": stages, "results": results }),
    )
}
