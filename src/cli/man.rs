//! `man`, `completions` and `--version`: what the definitions of the command line make.

use std::path::PathBuf;

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{
    arguments::{Arguments, Output},
    exit::Exit,
    terminal,
};
use crate::{
    output::{self, Folder, Inputs, OutputError, OutputFile, OutputKind},
    pipeline::StageError,
};

/// Arguments of `man`.
#[derive(Debug, Args)]
pub struct ManArguments {
    /// Folder for the pages, for example ~/.local/share/man/man1
    #[arg(default_value = "man")]
    pub folder: PathBuf,
}

/// `man`: writes one page for the program and one for each command.
pub(super) fn man(arguments: &ManArguments, printing: &Output) -> Result<Exit, StageError> {
    let _folder = Folder::make(&arguments.folder)?;
    let mut program = Arguments::command();
    program.build();
    let mut pages = vec![page(arguments, program.clone(), "contact3d-pipe")?];
    for command in program.get_subcommands() {
        let name = format!("contact3d-pipe-{}", command.get_name());
        pages.push(page(arguments, command.clone(), &name)?);
    }
    output::write(&pages, &Inputs::default())?;
    terminal::written(printing, pages.iter().map(|page| &page.path));
    Ok(Exit::Done)
}

fn page(
    arguments: &ManArguments,
    command: clap::Command,
    name: &str,
) -> Result<OutputFile, OutputError> {
    let path = arguments.folder.join(format!("{name}.1"));
    let mut bytes = Vec::new();
    let rendered = clap_mangen::Man::new(command)
        .title(name)
        .source(concat!("contact3d-pipe ", env!("CARGO_PKG_VERSION")))
        .render(&mut bytes);
    match rendered {
        Ok(()) => Ok(OutputFile {
            path,
            kind: OutputKind::ManualPage,
            bytes,
        }),
        Err(source) => Err(OutputError::Io {
            file: path,
            action: "make the page",
            source,
        }),
    }
}

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

/// The version of the program, the commit it was built from where the build named it (`CONTACT3D_COMMIT`), and the
/// version of HDF5.
pub(super) fn version_words() -> &'static str {
    static WORDS: std::sync::LazyLock<String> = std::sync::LazyLock::new(|| {
        let commit = option_env!("CONTACT3D_COMMIT")
            .map_or_else(String::new, |commit| format!("commit {commit}\n"));
        let [major, minor, patch] = runfile::hdf5_version();
        format!(
            "{}\n{commit}HDF5 {major}.{minor}.{patch}",
            env!("CARGO_PKG_VERSION")
        )
    });
    &WORDS
}
