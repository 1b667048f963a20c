//! A load history in words and for programs.

use std::fmt::Write;

use contact3d::{history::StepRecord, scene::Scene};

/// Rows of increments that are printed; in a longer history only the ends of steps are.
const MOST_ROWS: usize = 60;

/// The increments as a table; empty without a history.
pub(super) fn table(scene: &Scene, records: &[StepRecord]) -> String {
    if records.is_empty() {
        return String::new();
    }
    let all = scene.increments().len();
    let units = scene.units;
    let mut text = format!(
        "load history: {} of {all} increments in {} steps\n  {:<22} {:>10} {:>17} {:>13} {:>13} {:>12} {:>12} {:>12}\n",
        records.len(),
        scene.steps.len(),
        "step",
        "time [s]",
        "open/stick/slip",
        format!("normal [{}]", units.force()),
        format!("friction [{}]", units.force()),
        format!("loads [{}]", units.energy()),
        format!("friction [{}]", units.energy()),
        format!("strain [{}]", units.energy()),
    );
    let [mut work, mut dissipated] = [0.0; 2];
    for (k, record) in records.iter().enumerate() {
        work += record.energies.load_work;
        dissipated += record.energies.dissipation;
        let is_shown =
            records.len() <= MOST_ROWS || record.increment.share >= 1.0 || k + 1 == records.len();
        if !is_shown {
            continue;
        }
        let [open, stick, slip] = record.zone_counts();
        let [normal, first, second] = record.multiplier_force;
        let _ = writeln!(
            text,
            "  {:<22} {:>10.4} {:>17} {:>13.5e} {:>13.5e} {work:>12.4e} {dissipated:>12.4e} {:>12.4e}{}",
            name(scene, record),
            record.increment.time,
            format!("{open}/{stick}/{slip}"),
            normal,
            first.hypot(second),
            record.energies.strain,
            match record.status.is_solved() {
                true => String::new(),
                false => format!("  {}", record.status.word()),
            }
        );
    }
    text + "  (works and dissipation since the beginning)\n"
}

/// The title of a step and the number of the increment.
fn name(scene: &Scene, record: &StepRecord) -> String {
    let step = &scene.steps[record.increment.step];
    let title = contact3d::scene::shown(&scene.step_title(record.increment.step));
    let short: String = title.chars().take(16).collect();
    match step.increments {
        1 => short,
        _ => format!("{short} {}", record.increment.number),
    }
}

/// The increments for programs.
pub(super) fn json(records: &[StepRecord]) -> serde_json::Value {
    let rows = records.iter().map(|record| {
        let energies = &record.energies;
        let [open, stick, slip] = record.zone_counts();
        serde_json::json!({
            "step": record.increment.step,
            "increment": record.increment.number,
            "time": record.increment.time,
            "status": record.status.word(),
            "accuracy": record.accuracy,
            "actions": record.applications,
            "certificate": record.certificate,
            "open": open,
            "stick": stick,
            "slip": slip,
            "applied_force": record.applied_force,
            "contact_force": record.contact_force,
            "clamp_force": record.clamp_force,
            "multiplier_force": record.multiplier_force,
            "loaded_displacement": record.loaded_displacement,
            "contact_displacement": record.contact_displacement,
            "strain_energy": energies.strain,
            "load_work": energies.load_work,
            "normal_work": energies.normal_work,
            "dissipation": energies.dissipation,
            "energy_imbalance": energies.imbalance,
        })
    });
    rows.collect()
}
