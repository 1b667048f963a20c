//! `schema`: the generated files, written or checked. Those that people and editors read are in the repository; the others are
//! only for programs.

use std::{fs, path::PathBuf};

use clap::Args;
use contact3d::scene::Scene;
use runfile::{schema_json, schema_page};

use super::{arguments::Output, exit::Exit, terminal};
use crate::{
    format::{LAYOUT, SERIES_LAYOUT, STABILITY_LAYOUT, SWEEP_LAYOUT},
    output::{self, Folder, Inputs, OutputFile, OutputKind},
    pipeline::StageError,
    sweep::SweepFile,
};

/// Arguments of `schema`.
#[derive(Debug, Args)]
pub struct SchemaArguments {
    /// Folder for the schemas
    #[arg(default_value = "schemas")]
    pub folder: PathBuf,
    /// Write nothing; fail when files there differ from what would be written, or one that people or editors read is missing
    #[arg(long)]
    pub check: bool,
}

/// `schema`: writes the generated files, or checks that they are up to date.
pub(super) fn schema(arguments: &SchemaArguments, printing: &Output) -> Result<Exit, StageError> {
    let read = [
        ("run_file.md", schema_page(&LAYOUT)),
        ("scene.json", Scene::json_schema()),
        ("sweep.json", SweepFile::json_schema()),
    ];
    let for_programs = [
        ("run_file.json", schema_json(&LAYOUT)),
        ("series.json", schema_json(&SERIES_LAYOUT)),
        ("stability.json", schema_json(&STABILITY_LAYOUT)),
        ("sweep_summary.json", schema_json(&SWEEP_LAYOUT)),
    ];
    let place = |(name, text): (&str, String)| (arguments.folder.join(name), text);
    let mut files: Vec<(PathBuf, String)> = read.map(place).into();
    let others = for_programs.map(place).into_iter();
    if arguments.check {
        files.extend(others.filter(|(path, _)| path.exists()));
        return Ok(check(&files, printing));
    }
    files.extend(others);
    let _folder = Folder::make(&arguments.folder)?;
    let output = |(path, text): (PathBuf, String)| OutputFile {
        kind: match path.extension() {
            Some(ending) if ending == "md" => OutputKind::SchemaPage,
            _ => OutputKind::Schema,
        },
        path,
        bytes: text.into_bytes(),
    };
    let outputs: Vec<OutputFile> = files.into_iter().map(output).collect();
    output::write(&outputs, &Inputs::default())?;
    terminal::written(printing, outputs.iter().map(|output| &output.path));
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
