//! Scenes read with the changes of `--set`.

use contact3d::scene::{InvalidValue, Scene, SceneFile, number_limit};

use super::arguments::SceneArguments;
use crate::{
    format::scene_table,
    format::set_key,
    output::Inputs,
    pipeline::{StageError, mesh_files},
};

/// Reads a scene with the changes of `--set`, and lists the files that belong to it: no output may replace one of them.
pub(super) fn read_with_inputs(
    arguments: &SceneArguments,
) -> Result<(SceneFile, Inputs), StageError> {
    read_for_error(arguments, None, None)
}

/// As [`read_with_inputs`], with the error that the mesh is refined for. Where neither the scene nor `--set` names an element, that of a
/// brick is chosen then.
pub(super) fn read_for_error(
    arguments: &SceneArguments,
    error: Option<f64>,
    quantity: Option<&str>,
) -> Result<(SceneFile, Inputs), StageError> {
    let file = SceneFile::read(&arguments.scene)?;
    let mut overrides = arguments.overrides.clone();
    let sets = overrides.iter().map(|change| format!("--set {change}"));
    let mut changes: Vec<String> = sets.collect();
    if let Some(error) = error {
        if error > 1.0 {
            let expected = "a number from 0.00000001 to 1, or percent";
            let help = format!("for {error} percent write --error {error}%");
            return Err(refused("--error", expected, &error.to_string(), help));
        }
        let keys = overrides.iter().filter_map(|change| change.split_once('='));
        let mut keys = keys.map(|(key, _)| key.trim());
        let is_named =
            file.gives("body.element") || keys.any(|key| ["body", "body.element"].contains(&key));
        if !is_named && file.scene.as_brick().is_some() {
            overrides.push("body.element=\"P2\"".to_owned());
        }
        overrides.push(format!("adapt.error={error:?}"));
        changes.push(format!("--error {error}"));
    }
    if let Some(quantity) = quantity {
        if error.is_none() && file.scene.adapt.is_none() {
            return Err(asks_for_no_error("--quantity", "3%"));
        }
        let value = match quantity.trim_start().starts_with('{') {
            true => quantity.to_owned(),
            false => toml::Value::String(quantity.to_owned()).to_string(),
        };
        overrides.push(format!("adapt.of={value}"));
        changes.push(format!("--quantity {quantity}"));
    }
    let scene = changed(file, &overrides, &changes.join(" "))?;
    let mesh = mesh_files(&scene).into_iter();
    let inputs = Inputs::of(mesh.chain([arguments.scene.clone()]));
    Ok((scene, inputs))
}

/// A stored scene with changes of one of its tables, which alone a stage behind the mesh may change.
pub(super) fn change_table(
    stored: &SceneFile,
    table: &str,
    overrides: &[String],
) -> Result<Scene, StageError> {
    let is_other = |change: &&String| !change.trim_start().starts_with(&format!("{table}."));
    if let Some(change) = overrides.iter().find(is_other) {
        let help = "`run` changes other keys, and does again what follows from them";
        return Err(setting(&format!("a key of [{table}]"), change, help.into()));
    }
    let sets: Vec<String> = overrides.iter().map(|c| format!("--set {c}")).collect();
    Ok(changed(stored.clone(), overrides, &sets.join(" "))?.scene)
}

/// A scene with values at other keys; `words` says for messages what is other.
fn changed(scene: SceneFile, overrides: &[String], words: &str) -> Result<SceneFile, StageError> {
    if overrides.is_empty() {
        return Ok(scene);
    }
    let mut table = scene_table(&scene.scene);
    for change in overrides {
        apply(&mut table, change)?;
    }
    Ok(scene.changed(words, &table.to_string())?)
}

/// Refuses an option that means nothing without an error to refine for.
pub(super) fn asks_for_no_error(option: &str, error: &str) -> StageError {
    let expected = "a scene that asks for an error";
    let help = format!("add --error {error}, for example");
    refused(option, expected, "neither --error nor [adapt]", help)
}

/// Puts a value at a dotted key path; tables that are not there are made.
fn apply(table: &mut toml::Table, change: &str) -> Result<(), StageError> {
    let Some((key, text)) = change.split_once('=') else {
        let help = "write --set solve.epsilon=1e-8, for example";
        return Err(setting("KEY=VALUE", change, help.into()));
    };
    let value = toml_value(text).map_err(|limit| match limit {
        Some(limit) => setting(&limit, change, "give a smaller number".into()),
        None => setting("KEY=VALUE with a TOML value", change, in_quotes(key, text)),
    })?;
    set_key(table, key.trim(), value).map_err(|problem| {
        let found = format!("{key}: {problem}");
        let help = "`contact3d-pipe help scene` lists the keys; items of lists have numbers from 0 on, as in pressure.0.value";
        setting("a key below tables and lists only", &found, help.into())
    })
}

/// One value, a word without quotes too; a text with more than that is none. The error says what a number that is too large should be.
fn toml_value(text: &str) -> Result<toml::Value, Option<String>> {
    let word = text.trim();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-".contains(c);
    let document = match format!("value = {text}").parse::<toml::Table>() {
        Err(_)
            if word.starts_with(|c: char| c.is_ascii_alphabetic())
                && word.chars().all(is_plain) =>
        {
            return Ok(toml::Value::String(word.to_owned()));
        }
        document => document,
    };
    let mut values = document.map_err(|error| number_limit(&error))?.into_iter();
    match (values.next(), values.next()) {
        (Some((_, value)), None) => Ok(value),
        _ => Err(None),
    }
}

/// How to write a text that is no TOML value as a TOML string, in a shell.
fn in_quotes(key: &str, text: &str) -> String {
    let quoted = toml::Value::String(text.trim().to_owned()).to_string();
    let argument = format!("{}={quoted}", key.trim()).replace('\'', r"'\''");
    format!("TOML puts text in quotes, and the shell needs others around them: --set '{argument}'")
}

fn setting(expected: &str, found: &str, help: String) -> StageError {
    refused("--set", expected, found, help)
}

fn refused(option: &str, expected: &str, found: &str, help: String) -> StageError {
    StageError::Setting(InvalidValue {
        key: option.into(),
        expected: expected.into(),
        found: found.into(),
        help,
    })
}
