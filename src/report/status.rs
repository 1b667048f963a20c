//! What is said of a run file: its stages, the main figures of its results, what the status of a solve means, and what helps.

use contact3d::{
    mesh::{ContactSurface, Mesh},
    scene::{DualOperatorKind, FactorPrecision, Method, Scene, SolveSettings},
    solver::{Solution, Status},
};
use runfile::{Reader, StoreError};
use serde_json::json;
use units::Dimension;

use super::{
    Digits::{Fixed, Scientific},
    FigureTable, Figures,
};
use crate::{
    format::OutcomeWords,
    pipeline::{Freshness, StageState, StageTiming},
};

/// What a status means to a person, and what helps.
pub fn status(solution: &Solution, scene: &Scene, mesh: &Mesh) -> String {
    let automatic = by_another_way(scene);
    let accuracy = solution.accuracy;
    let (limits, usual) = (&scene.solve, SolveSettings::default());
    let what = failure(solution.status, accuracy).unwrap_or_default();
    let advice = match solution.status {
        Status::Converged => return format!("converged to {accuracy:.1e}"),
        Status::MachinePrecision => {
            // Newton's steps are those of a dense operator.
            let more = match scene.assemble.dual_operator {
                DualOperatorKind::Implicit if solution.trace.newton.is_empty() => {
                    "; assemble.dual_operator = \"explicit\" reaches more"
                }
                DualOperatorKind::Implicit
                | DualOperatorKind::Explicit
                | DualOperatorKind::Auto => "",
            };
            return format!(
                "accurate to machine precision, {accuracy:.1e}: rounding forbids more{more}"
            );
        }
        Status::ReducedAccuracy => {
            return format!(
                "reduced accuracy: the method met its stopping rule, and the multipliers are accurate to {accuracy:.1e}; epsilon asks for more"
            );
        }
        Status::MaxOuterSteps => automatic
            .filter(|_| limits.max_outer_steps >= usual.max_outer_steps)
            .unwrap_or_else(|| "raise solve.max_outer_steps".to_owned()),
        Status::MaxOperatorApplications => automatic
            .filter(|_| limits.max_operator_applications >= usual.max_operator_applications)
            .unwrap_or_else(|| "raise solve.max_operator_applications".to_owned()),
        Status::NumericalError => "check loads, material and formulas".to_owned(),
        Status::MaxNewtonSteps | Status::Inaccurate | Status::Cycling => {
            automatic.unwrap_or_else(|| after_all_solvers(solution, scene))
        }
        Status::NoEquilibrium if solution.is_mechanism_of_panes(mesh) => {
            let other = match scene.bodies_touch() {
                true => "",
                false => " or contact.multipliers = \"nodal\"",
            };
            return format!(
                "NOT CONVERGED: no equilibrium with {} pane(s), which is no proof that contact cannot hold the body: panes transmit \
                 forces at their centres only; a finer mesh{other} may hold it; see the mechanism",
                mesh.contact.as_ref().map_or(0, ContactSurface::n_panes)
            );
        }
        Status::NoEquilibrium => format!(
            "see the mechanism; hold it with [[clamp]], or change {}",
            load_and_friction(scene, "or")
        ),
    };
    format!("NOT CONVERGED: {what}; {advice}")
}

/// Why a solve failed; `None` for one that did not.
pub fn failure(status: Status, accuracy: f64) -> Option<String> {
    let words = match status {
        Status::Converged | Status::MachinePrecision | Status::ReducedAccuracy => return None,
        Status::MaxOuterSteps => {
            return Some(format!("out of outer steps at a change of {accuracy:.1e}"));
        }
        Status::Inaccurate => {
            return Some(format!(
                "the stopping rule is met, but the multipliers are off by about {accuracy:.1e}"
            ));
        }
        Status::MaxOperatorApplications => "an inner problem ran out of applications of S",
        Status::NumericalError => {
            "a value is not finite, or a coefficient of friction not positive at the slips reached"
        }
        Status::MaxNewtonSteps => "Newton's method found no solution from any start",
        Status::NoEquilibrium => "no equilibrium: contact cannot hold the body under this load",
        Status::Cycling => "successive approximations go round in a cycle",
    };
    Some(words.to_owned())
}

/// What may help where no setting does: only Coulomb's law leaves open whether there is a solution of a body that is held.
fn after_all_solvers(solution: &Solution, scene: &Scene) -> String {
    let faces = scene.contact_features().into_iter();
    let mut laws = faces.filter_map(|face| face.friction);
    let has_coulomb = laws.any(|law| law.bound.follows_pressure());
    let look = load_and_friction(scene, "and");
    if solution.rigid.is_some() && !scene.springs.is_empty() {
        return format!(
            "no equilibrium was found, and none is ruled out: look at {look}, and at how soft the springs are"
        );
    }
    match (solution.rigid.is_none(), has_coulomb) {
        (true, true) => {
            "there may be no solution: look at the friction, or try another mesh".to_owned()
        }
        (true, false) => {
            "there is one solution, lost in rounding: look at what holds the body, and at parts whose sizes or moduli differ by many orders of magnitude".to_owned()
        }
        (false, _) => format!(
            "no equilibrium was found, and none is ruled out: contact may not hold the body; look at {look}, or hold it with [[clamp]]"
        ),
    }
}

/// What a scene without equilibrium may change.
fn load_and_friction(scene: &Scene, word: &str) -> String {
    if scene.has_friction() {
        format!("load {word} friction")
    } else {
        "the load".to_owned()
    }
}

/// The settings that look for the answer with every solver there is; `None` where they are chosen.
fn by_another_way(scene: &Scene) -> Option<String> {
    let method = (scene.solve.method != Method::Auto).then_some("solve.method = \"auto\"");
    let implicit = scene.assemble.dual_operator == DualOperatorKind::Implicit;
    let operator = implicit.then_some("assemble.dual_operator = \"explicit\"");
    let single = scene.assemble.factor == FactorPrecision::Single;
    let factor = single.then_some("assemble.factor = \"double\"");
    let settings: Vec<&str> = [method, operator, factor].into_iter().flatten().collect();
    (!settings.is_empty()).then(|| format!("choose {}", settings.join(" with ")))
}

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
