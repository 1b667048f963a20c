use std::{fs, path::PathBuf};

use super::{
    arguments::{Output, SchemaArguments},
    exit::Exit,
    terminal::{self, say},
};
use crate::{
    format::{LAYOUT, STABILITY_LAYOUT, SWEEP_LAYOUT},
    scene::Scene,
    stages::StageError,
    store::{schema_json, schema_page},
    sweep::SweepFile,
};

/// `schema`: writes the generated files, or checks that they are up to date.
pub(super) fn schema(arguments: &SchemaArguments, output: &Output) -> Result<Exit, StageError> {
    let files = [
        ("run_file.json", schema_json(&LAYOUT)),
        ("run_file.md", schema_page(&LAYOUT)),
        ("scene.json", Scene::json_schema()),
        ("stability.json", schema_json(&STABILITY_LAYOUT)),
        ("sweep.json", SweepFile::json_schema()),
        ("sweep_summary.json", schema_json(&SWEEP_LAYOUT)),
    ]
    .map(|(name, text)| (arguments.out.join(name), text));
    if arguments.check {
        return Ok(check(&files, output));
    }
    fs::create_dir_all(&arguments.out).map_err(|source| StageError::Write {
        file: arguments.out.clone(),
        source,
    })?;
    for (file, text) in &files {
        fs::write(file, text).map_err(|source| StageError::Write {
            file: file.clone(),
            source,
        })?;
        say(output, &format!("wrote {}", file.display()));
    }
    if output.json {
        let written: Vec<&PathBuf> = files.iter().map(|(file, _)| file).collect();
        terminal::json(&serde_json::json!({ "written": written }));
    }
    Ok(Exit::Done)
}

fn check(files: &[(PathBuf, String)], output: &Output) -> Exit {
    let stale: Vec<_> = files
        .iter()
        .filter(|(file, text)| fs::read_to_string(file).ok().as_ref() != Some(text))
        .collect();
    for (file, _) in &stale {
        terminal::message(&format!(
            "error: {} is not what this program writes; run `contact3d-pipe schema`",
            file.display()
        ));
    }
    if output.json {
        let stale: Vec<&PathBuf> = stale.iter().map(|(file, _)| file).collect();
        terminal::json(&serde_json::json!({ "stale": stale }));
    }
    if stale.is_empty() {
        Exit::Done
    } else {
        Exit::BadInput
    }
}
