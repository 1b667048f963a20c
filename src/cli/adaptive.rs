//! Adaptive runs: the words about their levels, and what became of the target.

use std::time::Instant;

use contact3d::{
    adaptation::{AdaptiveLevel, AdaptiveStatus, LevelForecast, RefinedLevels},
    scene::{Brick, ElementOrder, Scene},
};
use indicatif::ProgressBar;

use super::{arguments::Output, progress, terminal::say};
use crate::{
    pipeline::{AdaptStep, Session, StageError, StageTiming},
    report::{estimated_percent, percent},
};

/// A share of the energy norm: `1%`, `1 %` or `0.01`.
pub(super) fn share(text: &str) -> Result<f64, String> {
    let (number, unit) = match text.trim().strip_suffix('%') {
        Some(percent) => (percent, 0.01),
        None => (text, 1.0),
    };
    match number.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value * unit),
        _ => Err("write 3% or 0.03, for example".into()),
    }
}

/// Runs the levels of a scene that asks for an error.
pub(super) fn run(
    session: &mut Session,
    deadline: Option<Instant>,
    output: &Output,
) -> Result<(RefinedLevels, Vec<StageTiming>), StageError> {
    say(output, &first_mesh_line(session.scene()));
    let mut is_out_of_reach = false;
    let mut spinner = ProgressBar::hidden();
    let adapted = session.adapt(deadline, &mut |step| match step {
        AdaptStep::Stage(level, stage) => {
            spinner.finish_and_clear();
            spinner = progress::spinner(stage.word(), output);
            spinner.set_message(format!("level {level}"));
        }
        AdaptStep::Run(step) => progress::show(&spinner, output, step),
        AdaptStep::Done(number, level) => {
            spinner.finish_and_clear();
            say(output, &level_line(number, level));
        }
        AdaptStep::Kept(levels) => progress::levels_kept(levels),
        AdaptStep::TooLarge(number, why) => {
            spinner.finish_and_clear();
            say(output, &format!("level {number:<3} does not fit: {why}"));
        }
        AdaptStep::Forecast(number, forecast) => say(output, &forecast_line(number, forecast)),
        AdaptStep::OutOfReach {
            n_free,
            needed,
            available,
        } => {
            if !std::mem::replace(&mut is_out_of_reach, true) {
                let [needed, available] = [needed, available].map(|bytes| bytes as f64 / 1e9);
                let line = format!(
                    "mesh      at this rate the target takes about {n_free:.1e} unknowns and {needed:.0} GB of memory, and there are {available:.0} GB: it will hardly be met"
                );
                say(output, &line);
            }
        }
    });
    spinner.finish_and_clear();
    adapted
}

/// What the levels start from.
fn first_mesh_line(scene: &Scene) -> String {
    let element = match scene.element() {
        ElementOrder::P1 => "linear",
        ElementOrder::P2 => "quadratic",
    };
    let cells = match scene.as_brick() {
        Some(Brick {
            cells: [x, y, z], ..
        }) => format!("{x} x {y} x {z} cells"),
        None if scene.bodies.len() > 1 => format!("{} bodies", scene.bodies.len()),
        None => "the mesh file".to_owned(),
    };
    format!("mesh      {element} tetrahedra, from {cells}")
}

fn forecast_line(number: usize, forecast: &LevelForecast) -> String {
    let cells = forecast.cells.map_or_else(String::new, |[x, y, z]| {
        format!(", {x} x {y} x {z} graded cells")
    });
    format!(
        "level {number:<3} {:>9} unknowns, {:>18} error about {:>8}, about {:.1} s{cells}",
        forecast.n_free,
        "expected,",
        estimated_percent(forecast.estimated_error),
        forecast.seconds
    )
}

fn level_line(number: usize, level: &AdaptiveLevel) -> String {
    format!(
        "level {number:<3} {:>9} unknowns, {:>6} multipliers, error about {:>8}, {:.3} s",
        level.n_free,
        level.n_multipliers,
        estimated_percent(level.estimated_error),
        level.seconds
    )
}

/// What to say of a target that is not met; `None` if it is, or if the solve has said enough.
pub(super) fn unmet(adapted: &RefinedLevels, target: f64) -> Option<String> {
    let target = percent(target);
    let reached = adapted
        .adaptation
        .levels
        .get(adapted.level)?
        .estimated_error;
    let reached = estimated_percent(reached);
    let why = match adapted.status {
        AdaptiveStatus::Met | AdaptiveStatus::NotConverged => return None,
        AdaptiveStatus::Refining => "there are levels to come",
        AdaptiveStatus::TooLarge => "the next mesh does not fit into memory or on the disk",
        AdaptiveStatus::NotEstimated => {
            "the quantity is zero on the next mesh, or has no estimate there"
        }
        AdaptiveStatus::OverBudget => {
            "the next mesh is forecast to take more than is left of --budget"
        }
        AdaptiveStatus::Unbounded => {
            "the largest value grows with every finer mesh, as at a sharp edge, and has no limit that meshes come near: \
             round the edge, or refine for another quantity, in contact { mean_pressure = { box = [[X, Y, Z], [X, Y, Z]] } }"
        }
        AdaptiveStatus::Stalled => "finer meshes do not lower the estimate any more",
    };
    // What has no limit has no error.
    let reached = match adapted.status {
        AdaptiveStatus::Unbounded => String::new(),
        _ => format!("the error is {reached}, "),
    };
    Some(format!("NOT MET: {reached}{target} was asked for; {why}"))
}
