//! Checks of load histories.

use std::collections::BTreeSet;

use super::require;
use crate::scene::{InvalidValue, MOST_INCREMENTS, Scene, SlipMeasure, Written};

pub(super) fn check(scene: &Scene) -> Result<(), InvalidValue> {
    check_names(scene)?;
    for (key, friction) in scene.friction_tables() {
        require(
            scene.has_history() || friction.follows == SlipMeasure::default(),
            format!("{key}.follows"),
            "a scene with [[step]]",
            "none",
            "without a history there is one slip to follow; leave the key out, or add a [[step]]",
        )?;
        require(
            friction.follows == scene.slip_measure(),
            format!("{key}.follows"),
            "the same on all contact faces",
            Written(&friction.follows),
            "give all tables of friction the same word",
        )?;
    }
    if !scene.has_history() {
        return Ok(());
    }
    check_times(scene)?;
    let mut increments = 0_usize;
    for (k, step) in scene.steps.iter().enumerate() {
        require(
            step.increments >= 1,
            format!("step.{k}.increments"),
            "a whole number >= 1",
            step.increments,
            "1 solves the step at once",
        )?;
        increments = increments.saturating_add(step.increments);
        require(
            increments <= MOST_INCREMENTS,
            format!("step.{k}.increments"),
            &format!("at most {MOST_INCREMENTS} increments in all steps together"),
            increments,
            "use fewer increments",
        )?;
        for (name, factor) in &step.factor {
            require(
                factor.is_finite(),
                format!("step.{k}.factor.{name}"),
                "a finite number",
                Written(factor),
                "1 is the value of the scene, 0 takes a load away",
            )?;
        }
    }
    check_ends(scene)
}

/// Every step must end in a scene that a problem of one step could have.
fn check_ends(scene: &Scene) -> Result<(), InvalidValue> {
    for end in scene.increments().iter().filter(|end| end.share >= 1.0) {
        scene
            .at_increment(*end)?
            .validate()
            .map_err(|invalid| InvalidValue {
                key: format!("step.{}", end.step),
                expected: format!("{}: {}", invalid.key, invalid.expected),
                ..invalid
            })?;
    }
    Ok(())
}

fn check_times(scene: &Scene) -> Result<(), InvalidValue> {
    if scene.steps.iter().all(|step| step.time.is_none()) {
        return Ok(());
    }
    let mut before = 0.0;
    for (k, step) in scene.steps.iter().enumerate() {
        let key = format!("step.{k}.time");
        let Some(time) = step.time else {
            return require(
                false,
                key,
                "a time, as other steps have one",
                "none",
                "give every step a time, or none",
            );
        };
        require(
            time.is_finite() && time > before,
            key,
            &format!(
                "a time [s] after {}, when the step begins",
                Written(&before)
            ),
            Written(&time),
            "times of steps grow, and the first begins at 0",
        )?;
        before = time;
    }
    Ok(())
}

fn check_names(scene: &Scene) -> Result<(), InvalidValue> {
    let mut known = BTreeSet::new();
    for (key, name) in scene.given_names() {
        require(
            !name.is_empty() && !name.contains('.') && name != "body_force",
            key.clone(),
            "a name without dots",
            Written(&name),
            "keys such as traction.0 have dots, names do not",
        )?;
        require(
            known.insert(name.clone()),
            key,
            "a name that no other load has",
            Written(&name),
            "steps could not tell the two apart",
        )?;
    }
    Ok(())
}
