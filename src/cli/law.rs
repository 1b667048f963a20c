//! `law`: bounds and pictures of a law of friction.

use super::{
    arguments::{LawArguments, Output},
    exit::Exit,
    law_words, override_scene,
    terminal::{self, say, warn},
};
use crate::{
    pipeline::StageError,
    views::{Drawing, LawStudy, PictureFolder, law_folder},
};

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
        study.draw(&PictureFolder::claim(&folder, Drawing::Law, inputs)?)?
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
