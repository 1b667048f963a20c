use super::{
    arguments::{LawArguments, Output},
    exit::Exit,
    law_words, override_scene,
    terminal::{self, say},
};
use crate::stages::{LawStudy, StageError, law_folder};

/// `law`: bounds and picture of a law of friction; stores no run file.
pub(super) fn law(arguments: &LawArguments, output: &Output) -> Result<Exit, StageError> {
    let study = LawStudy::new(override_scene::read(&arguments.scene)?)?;
    let files = if arguments.no_figures {
        Vec::new()
    } else {
        let folder = arguments.figures.clone();
        study.draw(&folder.unwrap_or_else(|| law_folder(&arguments.scene.scene)))?
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
