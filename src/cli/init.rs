//! `init`: a commented scene to start from.

use std::path::PathBuf;

use clap::Args;

use super::{
    arguments::Output,
    exit::Exit,
    terminal::{self, say},
};
use crate::{
    output::{self, Inputs, OutputFile, OutputKind},
    pipeline::StageError,
};

/// A block on a foundation, with the further keys of a scene in comments.
const SCENE: &str = include_str!("init.toml");

/// Arguments of `init`.
#[derive(Debug, Args)]
pub struct InitArguments {
    /// The scene to write; an existing file is not overwritten
    #[arg(default_value = "scene.toml")]
    pub scene: PathBuf,
}

/// `init`: writes the scene.
pub(super) fn init(arguments: &InitArguments, printing: &Output) -> Result<Exit, StageError> {
    let file = OutputFile {
        path: arguments.scene.clone(),
        kind: OutputKind::Scene,
        bytes: SCENE.into(),
    };
    output::write(&[file], &Inputs::default())?;
    let (scene, run_file) = (&arguments.scene, arguments.scene.with_extension("h5"));
    let (scene, run_file) = (scene.display(), run_file.display());
    say(
        printing,
        &format!("wrote {scene}; solve it with: contact3d-pipe run {scene} {run_file}"),
    );
    if printing.json {
        terminal::json(&serde_json::json!({ "written": arguments.scene }));
    }
    Ok(Exit::Done)
}
