//! `law`: bounds and pictures of a law of friction.

use std::path::PathBuf;

use clap::Args;

use super::{
    arguments::{Output, SceneArguments},
    exit::Exit,
    law_words, override_scene,
    terminal::{self, say, warn},
};
use crate::{
    pipeline::StageError,
    views::{LawStudy, PictureFolder, law_folder},
};

/// Arguments of `law`.
#[derive(Debug, Args)]
pub struct LawArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    /// Folder for law.svg and law.png; SCENE-law in the current directory by default
    #[arg(long, value_name = "FOLDER")]
    pub figures: Option<PathBuf>,
    /// Draw no picture
    #[arg(long, conflicts_with = "figures")]
    pub no_figures: bool,
}

/// `law`: bounds and picture of a law of friction; stores no run file.
pub(super) fn law(arguments: &LawArguments, output: &Output) -> Result<Exit, StageError> {
    let (scene, inputs) = override_scene::read_with_inputs(&arguments.scene)?;
    let study = LawStudy::new(scene)?;
    warn(output, &study.warnings());
    let files = if arguments.no_figures {
        Vec::new()
    } else {
        let folder = arguments.figures.clone();
        let folder = folder.unwrap_or_else(|| law_folder(&arguments.scene.scene));
        study.draw(&PictureFolder::claim(&folder, study.drawing(), inputs)?)?
    };
    if output.json {
        terminal::json(&law_words::json(&study, &files));
    } else if !output.quiet {
        terminal::result(&law_words::text(&study));
    }
    for file in files {
        say(output, &format!("figure    {}", file.display()));
    }
    Ok(Exit::Done)
}
