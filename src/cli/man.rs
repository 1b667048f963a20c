//! `man`: manual pages from the definitions of the command line.

use std::path::PathBuf;

use clap::{Args, CommandFactory};

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
    #[arg(long, value_name = "FOLDER", default_value = "man")]
    pub out: PathBuf,
}

/// `man`: writes one page for the program and one for each command.
pub(super) fn man(arguments: &ManArguments, printing: &Output) -> Result<Exit, StageError> {
    let _folder = Folder::make(&arguments.out)?;
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
    let path = arguments.out.join(format!("{name}.1"));
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
