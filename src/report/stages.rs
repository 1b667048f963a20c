//! The stages of a run file, and the main figures of its results.

use contact3d::scene::Scene;
use runfile::{Reader, StoreError};
use serde_json::json;
use units::Dimension;

use super::{
    Digits::{Fixed, Scientific},
    FigureTable, Figures,
    run::{largest_pressure, normal_force, strain_energy},
};
use crate::{
    format::{CaseResults, OutcomeWords},
    pipeline::{Freshness, StageState, StageTiming},
};

/// State, size and cost of each stage.
#[rustfmt::skip]
pub fn stages(reader: &Reader, scene: &Scene, states: &[StageState]) -> Result<FigureTable, StoreError> {
    let row = |state: &StageState| {
        let group = state.stage.group();
        let stored = state.stored.as_ref();
        let record = stored.map(|stored| &stored.record);
        let bytes = match stored {
            Some(_) => reader.group_bytes(group)?,
            None => 0,
        };
        let megabytes = bytes as f64 / 1e6;
        let linked = reader.linked_file(group);
        let mut figures = Figures::new(scene.units);
        figures.plain("stage", "stage", state.stage.word());
        figures.plain("state", "state", state.freshness.word());
        figures.number("", "MB", Fixed(3), stored.map(|_| megabytes));
        figures.add("seconds", "time", Dimension::Time, Fixed(3), record.map(|r| r.seconds));
        figures.plain("", "threads", record.map(|r| r.threads));
        figures.plain("", "date", record.map(|r| r.date.as_str()));
        let place = linked.as_ref().map(|(name, _)| format!("in {name}"));
        let why = match &state.freshness {
            Freshness::Stale(why) => Some(why.clone()),
            _ => None,
        };
        let remarks: Vec<String> = place.into_iter().chain(why).collect();
        figures.human_only("remarks", Some(remarks.join("; ")));
        figures.json_only("why", state.freshness.why());
        figures.json_only("bytes", bytes);
        let linked = linked.map(|(name, bytes)| json!({ "name": name, "bytes": bytes }));
        figures.json_only("linked_file", linked);
        figures.json_only("digest", stored.map(|stored| &stored.digest));
        Ok(figures)
    };
    let rows: Result<Vec<Figures>, StoreError> = states.iter().map(row).collect();
    Ok(FigureTable::new("", rows?))
}

/// What stages took that were performed just now.
pub fn performed(performed: &[StageTiming]) -> serde_json::Value {
    let row = |stage: &StageTiming| {
        json!({
            "stage": stage.stage.word(),
            "compute_seconds": stage.compute_seconds,
            "store_seconds": stage.store_seconds,
        })
    };
    performed.iter().map(row).collect()
}

/// The main figures of stored results.
pub fn summary(results: &CaseResults, scene: &Scene) -> Figures {
    let mut figures = Figures::new(scene.units);
    // Counts of a body without contact are -1.
    let has_contact = results.zones[0] >= 0;
    let of_contact = |figure: f64| has_contact.then_some(figure);
    let zones = has_contact.then_some(results.zones);
    let shown = zones.map(|zones| zones.map(|count| count.to_string()).join(", "));
    figures.described("zone_counts", "panes open, stick, slip", shown, zones);
    normal_force(&mut figures, of_contact(results.normal_force));
    largest_pressure(&mut figures, of_contact(results.largest_pressure));
    strain_energy(&mut figures, results.strain_energy);
    figures
}

/// How the solve ended; a history of a scene has `of` increments.
pub fn outcome(outcome: &OutcomeWords, scene: &Scene) -> Figures {
    let (status, solved, of) = (
        outcome.status.word(),
        outcome.status.is_solved(),
        scene.increments().len(),
    );
    let failed = if solved { "" } else { "FAILED: " };
    let mut figures = Figures::new(scene.units);
    figures.described("status", "solve", Some(format!("{failed}{status}")), status);
    figures.json_only("solved", solved);
    figures.plain("method", "method", outcome.method);
    figures.number("accuracy", "accuracy", Scientific(1), outcome.accuracy);
    if outcome.increments > 0 {
        let shown = format!("{} of {of}", outcome.increments);
        let increments = json!({ "solved": outcome.increments, "of": of });
        figures.described("increments", "increments", Some(shown), increments);
    }
    figures
}
