use super::arguments::SceneArguments;
use crate::{
    output::Inputs,
    scene::{Invalid, SceneFile},
    stages::{StageError, mesh_file},
    sweep::set_key,
};

/// As [`read`], with the files that belong to the scene: no output may replace one of them.
pub(super) fn read_with_inputs(
    arguments: &SceneArguments,
) -> Result<(SceneFile, Inputs), StageError> {
    let scene = read(arguments)?;
    let inputs = Inputs::of(
        mesh_file(&scene)
            .into_iter()
            .chain([arguments.scene.clone()]),
    );
    Ok((scene, inputs))
}

/// Reads a scene file and applies `--set KEY=VALUE`.
pub(super) fn read(arguments: &SceneArguments) -> Result<SceneFile, StageError> {
    let file = SceneFile::read(&arguments.scene)?;
    if arguments.overrides.is_empty() {
        return Ok(file);
    }
    let text = file.scene.to_toml();
    let mut table: toml::Table = text.parse().map_err(|_| setting(&text, "a scene"))?;
    for change in &arguments.overrides {
        apply(&mut table, change)?;
    }
    let changes: Vec<String> = arguments
        .overrides
        .iter()
        .map(|change| format!("--set {change}"))
        .collect();
    Ok(file.changed(&changes.join(" "), table.to_string())?)
}

/// Puts a value at a dotted key path; tables that are not there are made.
fn apply(table: &mut toml::Table, change: &str) -> Result<(), StageError> {
    let parsed = change.split_once('=').and_then(|(key, value)| {
        let document: toml::Table = format!("value = {value}").parse().ok()?;
        Some((key.trim(), document.get("value")?.clone()))
    });
    let (key, value) = parsed.ok_or_else(|| {
        setting(
            change,
            "KEY=VALUE with a TOML value, such as solve.epsilon=1e-8",
        )
    })?;
    set_key(table, key, value).map_err(|found| {
        let problem = format!("{key}: {found}");
        setting(&problem, "a key below tables and lists only")
    })
}

fn setting(found: &str, expected: &str) -> StageError {
    StageError::Setting(Invalid {
        key: "--set".into(),
        expected: expected.into(),
        found: format!("{found:?}"),
        help: "quote the argument for the shell".into(),
    })
}
