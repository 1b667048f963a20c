//! `completions`: what a shell needs to complete commands and options.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{arguments::Arguments, exit::Exit, terminal};

/// Arguments of `completions`.
#[derive(Debug, Args)]
pub struct CompletionsArguments {
    /// The shell; for bash: contact3d-pipe completions bash > ~/.local/share/bash-completion/completions/contact3d-pipe
    pub shell: Shell,
}

/// `completions`: prints the script for a shell.
pub(super) fn completions(arguments: &CompletionsArguments) -> Exit {
    let mut script = Vec::new();
    clap_complete::generate(
        arguments.shell,
        &mut Arguments::command(),
        "contact3d-pipe",
        &mut script,
    );
    terminal::result(&String::from_utf8_lossy(&script));
    Exit::Done
}
