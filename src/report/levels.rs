//! The increments of a load history and the levels of an adaptive mesh.

use contact3d::{
    adaptation::{Adaptation, RefinedLevels},
    history::{HistoryErrors, StepRecord},
    scene::{ContactFeatures, Increment, Scene, escape_control},
};
use serde_json::{Value, json};
use units::Dimension;

use super::{
    Digits::Fixed,
    FigureTable, Figures, SolvedRun,
    answer::{name_of_quantity, quantities_json},
    estimated_percent, percent,
    run::tools_json,
};
use crate::format::dimension_of_quantity as dimension;

/// A time that shares of steps add up to, with four digits.
pub fn shown_time(time: f64) -> String {
    units::rounded(time, 4).to_string()
}

impl SolvedRun<'_> {
    /// The increments, with works and dissipation since their step began for people and of each for programs.
    #[rustfmt::skip]
    pub fn increments(&self) -> FigureTable {
        let (scene, records) = (self.scene, self.increments);
        let [mut work, mut normal_work, mut dissipated, mut lost] = [0.0; 4];
        let mut step = 0;
        let errors = HistoryErrors::new(records, None).map(|errors| errors.relative);
        let faces = self.rows_of_faces();
        let rows = records.iter().enumerate().map(|(k, record)| {
            let energies = &record.energies;
            if record.increment.step != step {
                step = record.increment.step;
                [work, normal_work, dissipated, lost] = [0.0; 4];
            }
            work += energies.load_work;
            normal_work += energies.normal_work;
            dissipated += energies.dissipation;
            lost += energies.imbalance;
            // Rounding of what it is a difference of.
            let is_rounding = |sum: f64| sum.abs() <= 1e-9 * energies.strain.abs().max(work.abs());
            let mut figures = Figures::new(scene.units);
            let name = Some(name(scene, record.increment));
            figures.described("step", "step", name, record.increment.step);
            figures.json_only("increment", record.increment.number);
            figures.add("time", "time", Dimension::Time, Fixed(4), record.increment.time);
            // What an increment without a solution came to is for programs alone.
            let is_solved = record.status.is_solved();
            figures.zones(scene.has_friction(), record.zone_counts(), is_solved);
            for (row, name, body) in &faces {
                figures.told(&format!("{name} on {body}"), Dimension::FORCE, is_solved.then_some(record.forces[*row]));
            }
            for (tool, state) in record.tools.iter().enumerate() {
                let words = format!("{} moved", escape_control(&scene.tool_name(tool)));
                figures.told(&words, Dimension::LENGTH, is_solved.then_some(state.displacement));
            }
            for (words, energy) in [
                ("work of loads", work), ("normal work", normal_work), ("friction took", dissipated),
                ("strain energy", energies.strain), ("energy imbalance", lost),
            ] {
                let told = if is_rounding(energy) { 0.0 } else { energy };
                figures.told(words, Dimension::Energy, is_solved.then_some([told]));
            }
            if let Some(errors) = &errors {
                let error = errors[k];
                figures.described("estimated_error", "error about", Some(estimated_percent(error)), error);
            }
            figures.plain("status", "status", record.status.word());
            figures.json_only("applications", record.applications);
            for (key, value) in [
                ("strain_energy", energies.strain), ("load_work", energies.load_work), ("normal_work", energies.normal_work),
                ("dissipation", energies.dissipation), ("energy_imbalance", energies.imbalance),
                ("accuracy", record.accuracy), ("certificate", record.certificate),
            ] {
                figures.json_only(key, value);
            }
            for (key, vector) in [
                ("applied_force", record.applied_force), ("contact_force", record.contact_force), ("clamp_force", record.clamp_force),
                ("multiplier_force", record.multiplier_force), ("loaded_displacement", record.loaded_displacement),
            ] {
                figures.json_only(key, vector);
            }
            let forces = self.report.forces.iter().zip(&record.forces);
            let forces = forces.map(|(of, force)| json!({ "source": of.source, "face": of.face, "force": force }));
            figures.json_only("forces", forces.collect::<Vec<_>>());
            figures.json_only("tools", tools_json(scene, &record.tools));
            figures.json_only("contact_displacement", record.contact_displacement);
            let quantities = errors.is_some().then(|| quantities_json(scene.units, &record.quantities));
            figures.json_only("quantities", quantities);
            figures
        });
        FigureTable::new("Increments; works, what friction took and the energy imbalance since their step began", rows)
    }

    /// The rows of the forces of the contact faces, of two that touch each other of the first, what words call each, and the body that it acts on.
    pub(super) fn rows_of_faces(&self) -> Vec<(usize, String, String)> {
        let order = self.scene.contact_order();
        let named = self.scene.contact_features().into_iter().zip(&order);
        let row = |(has, entry): (ContactFeatures, &usize)| {
            let key = self.scene.contact_key(*entry);
            let mut forces = self.report.forces.iter();
            let row = forces.position(|row| row.source == key)?;
            let (of, body) = match self.mesh.bodies.is_empty() {
                true => ("on", "the body".to_owned()),
                false => (
                    "of",
                    escape_control(self.scene.contacts[*entry].first_body()),
                ),
            };
            let name = match order.len() {
                1 => "contact force".to_owned(),
                _ => format!("force {of} {}", escape_control(&has.name)),
            };
            Some((row, name, body))
        };
        named.filter_map(row).collect()
    }

    /// The ends of the steps, or `all` increments of a history that is not long; empty without a history.
    pub fn history_text(&self, all: bool) -> String {
        let (scene, records) = (self.scene, self.increments);
        if records.is_empty() {
            return String::new();
        }
        let head = format!(
            "load history: {} of {} increments in {} steps\n",
            records.len(),
            scene.increments().len(),
            scene.steps.len(),
        );
        let mut lines = self.increments().lines().into_iter();
        let titles = lines.next();
        let last = records.len() - 1;
        let failed = usize::from(!records[last].status.is_solved());
        // Rows of increments that are printed; in a longer history only the ends of steps are.
        let shows_all = all && records.len() <= 60;
        let is_shown =
            |k: usize| shows_all || records[k].increment.share >= 1.0 || k + failed >= last;
        let rows = lines.enumerate().filter(|(k, _)| is_shown(*k));
        let rows = titles.into_iter().chain(rows.map(|(_, line)| line));
        head + &rows.collect::<String>()
            + "  (since each step began: work - normal work - friction - change of strain energy = energy imbalance)\n"
            + &self.peaks().text(2, 22)
    }

    /// The largest forces and stresses of all increments with where they are, and the energies of the last cycle.
    pub fn peaks(&self) -> Figures {
        let (scene, records) = (self.scene, StepRecord::solved(self.increments));
        let mut figures = Figures::new(scene.units);
        let mut peak = |words: &str, dimension, of: &dyn Fn(&StepRecord) -> f64| {
            let Some(record) = records.iter().max_by(|a, b| of(a).total_cmp(&of(b))) else {
                return;
            };
            let (time, name) = (
                shown_time(record.increment.time),
                name(scene, record.increment),
            );
            let value = scene.units.of(dimension).told(&[of(record)]);
            let shown = format!("{value} at time {time} s, {name}");
            figures.human_only(words, (of(record) > 0.0).then_some(shown));
        };
        let (faces, [_, stress, force]) = (self.rows_of_faces(), StepRecord::LOADS);
        for (row, name, _) in faces.iter().filter(|_| faces.len() > 1) {
            peak(&format!("largest {name}"), Dimension::FORCE, &|record| {
                let [x, y, z] = record.forces[*row];
                x.hypot(y).hypot(z)
            });
        }
        // Sums over several faces act nowhere.
        if faces.len() == 1 {
            peak("largest normal force", Dimension::FORCE, &force);
            peak("largest friction force", Dimension::FORCE, &|record| {
                let [_, first, second] = record.multiplier_force;
                first.hypot(second)
            });
        }
        peak("largest pressure", Dimension::STRESS, &|record| {
            let normal = record.multiplier.iter().take(record.panes.len());
            normal.copied().fold(0.0, f64::max)
        });
        peak("largest von Mises", Dimension::STRESS, &stress);
        let mut done = records.iter().filter(|it| it.increment.share >= 1.0);
        let last = done.next_back().map(|it| it.increment.step);
        if let Some(steps) = last.and_then(|last| scene.cycle_until(last)) {
            let of_cycle = records
                .iter()
                .filter(|it| steps.contains(&it.increment.step));
            let sums = of_cycle.fold([0.0, 0.0], |[work, friction], it| {
                [
                    work + it.energies.load_work,
                    friction + it.energies.dissipation,
                ]
            });
            let first = *steps.start();
            let mut before = records.iter().rev().filter(|it| it.increment.step < first);
            let before = before.next().map_or(0.0, |it| it.energies.strain);
            let rise = records.last().map_or(0.0, |it| it.energies.strain) - before;
            let (told, unit) = scene.units.of(Dimension::Energy).parts(&sums);
            // A steady cycle ends as it began, but for the error of its increments.
            let unsteady = rise.abs() > 0.02 * sums[0].abs();
            let unsteady = unsteady.then(|| {
                let rise = scene.units.of(Dimension::Energy).told(&[rise]);
                format!("; not steady, strain energy rose by {rise}")
            });
            let steps = [*steps.start(), *steps.end()];
            let steps = steps.map(|step| escape_control(&scene.step_title(step)));
            figures.human_only(
                "energy of a cycle",
                Some(format!(
                    "work of loads {} {unit}, friction took {} {unit} from {} to {}{}",
                    told[0],
                    told[1],
                    steps[0],
                    steps[1],
                    unsteady.unwrap_or_default()
                )),
            );
        }
        figures
    }
}

/// The name of an increment, and its time.
pub fn increment_in_words(scene: &Scene, increment: Increment) -> String {
    let (time, name) = (shown_time(increment.time), name(scene, increment));
    format!("{name}, at time {time} s")
}

/// The title of a step and the number of the increment.
pub(super) fn name(scene: &Scene, increment: Increment) -> String {
    let step = increment.step;
    let title = escape_control(&scene.step_title(step));
    // Longest title of a step in a table.
    let short: String = title.chars().take(16).collect();
    match scene.steps[step].increments {
        1 => short,
        _ => format!("{short} {}", increment.number),
    }
}

/// The levels of an adaptive mesh for an error, the one in force marked.
#[rustfmt::skip]
pub fn adaptation_table(scene: &Scene, adaptation: &Adaptation, target: f64) -> FigureTable {
    let levels = &adaptation.levels;
    let of = scene.adapt.and_then(|adapt| adapt.of);
    let in_force = adaptation.level_that_meets(target).unwrap_or(levels.len().saturating_sub(1));
    let rows = levels.iter().enumerate().map(|(number, level)| {
        let mut figures = Figures::new(scene.units);
        let mark = if number == in_force { "*" } else { "" };
        figures.human_only("", Some(mark.to_owned()));
        figures.plain("", "level", number);
        figures.plain("n_tetrahedra", "tetrahedra", level.n_tetrahedra);
        figures.plain("n_free", "unknowns", level.n_free);
        figures.plain("n_multipliers", "multipliers", level.n_multipliers);
        let error = level.estimated_error;
        figures.described("estimated_error", "error about", Some(estimated_percent(error)), error);
        figures.plain("n_closed_panes", "panes in contact", level.n_closed);
        if let Some(of) = of {
            figures.told(&name_of_quantity(of), dimension(of), level.value.map(|value| [value]));
            figures.json_only("value", level.value);
        }
        figures.add("seconds", "time", Dimension::Time, Fixed(3), level.seconds);
        figures.json_only("status", level.status.word());
        figures
    });
    let of = of.map_or_else(String::new, |of| format!(" of {}", name_of_quantity(of)));
    let caption = format!("levels for an error of {}{of}", percent(target));
    let appears = |level| format!("contact first appears on level {level}: the errors of coarser meshes are those of a body that nothing touches\n");
    let note = adaptation.first_in_contact().map_or_else(String::new, appears);
    FigureTable::new(&caption, rows).with_note(note)
}

/// The levels for an error, for programs.
pub fn adaptation_json(scene: &Scene, adapted: &RefinedLevels, target: f64) -> Value {
    json!({
        "target_error": target,
        "of": scene.adapt.and_then(|adapt| adapt.of).map(|of| of.word()),
        "status": adapted.status.word(),
        "level": adapted.level,
        "levels": adaptation_table(scene, &adapted.adaptation, target).json(),
    })
}
