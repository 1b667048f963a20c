//! `help`, `man`, `completions`, `schema` and `--version`: what the program says of itself.

use std::{
    fs,
    path::{Path, PathBuf},
};

use clap::CommandFactory;
use clap_complete::Shell;
use contact3d::scene::{InvalidValue, Scene};
use runfile::{schema_json, schema_page};

use super::{
    arguments::{Arguments, Output},
    exit::Exit,
    terminal,
};
use crate::{
    format::{LAYOUT, SERIES_LAYOUT, STABILITY_LAYOUT, SWEEP_LAYOUT},
    output::{self, Folder, Inputs, OutputError, OutputFile, OutputKind},
    pipeline::StageError,
    sweep::SweepFile,
};

/// `man`: writes one page for the program and one for each command.
pub(super) fn man(folder: &Path, printing: &Output) -> Result<Exit, StageError> {
    let _folder = Folder::make(folder)?;
    let mut program = Arguments::command();
    program.build();
    let mut pages = vec![page(folder, program.clone(), "contact3d-pipe")?];
    for command in program.get_subcommands() {
        let name = format!("contact3d-pipe-{}", command.get_name());
        pages.push(page(folder, command.clone(), &name)?);
    }
    output::write(&pages, &Inputs::default())?;
    terminal::written(printing, pages.iter().map(|page| &page.path));
    Ok(Exit::Done)
}

fn page(folder: &Path, command: clap::Command, name: &str) -> Result<OutputFile, OutputError> {
    let path = folder.join(format!("{name}.1"));
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

/// The pages of the reference that `help` prints.
const PAGES: [(&str, &str); 9] = [
    ("scene", include_str!("../../docs/reference/scene.md")),
    ("body", include_str!("../../docs/reference/body.md")),
    ("material", include_str!("../../docs/reference/material.md")),
    ("contact", include_str!("../../docs/reference/contact.md")),
    ("supports", include_str!("../../docs/reference/supports.md")),
    ("history", include_str!("../../docs/reference/history.md")),
    ("solver", include_str!("../../docs/reference/solver.md")),
    ("sweep", include_str!("../../docs/reference/sweep.md")),
    ("statuses", include_str!("../../docs/reference/statuses.md")),
];

/// `help`: prints the help of a command and the page of that name, or of the program.
pub(super) fn help(topic: &[String]) -> Result<Exit, StageError> {
    let mut program = Arguments::command();
    program.build();
    let mut command = Some(&mut program);
    for name in topic {
        command = command.and_then(|command| command.find_subcommand_mut(name));
    }
    let page = PAGES.iter().find(|(name, _)| topic == [*name]);
    let help = command.map(|command| command.render_long_help().to_string());
    let texts: Vec<String> = help
        .into_iter()
        .chain(page.map(|(_, page)| (*page).to_owned()))
        .collect();
    if texts.is_empty() {
        return Err(StageError::Setting(InvalidValue {
            key: "help".into(),
            expected: format!(
                "a command, or one of {}",
                PAGES.map(|(name, _)| name).join(", ")
            ),
            found: topic.join(" "),
            help: "`contact3d-pipe help` lists the commands".into(),
        }));
    }
    terminal::result(&texts.join("\n"));
    Ok(Exit::Done)
}

/// `completions`: prints the script for a shell.
pub(super) fn completions(shell: Shell) -> Exit {
    let mut script = Vec::new();
    clap_complete::generate(
        shell,
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

/// `schema`: writes the generated files, or checks that they are up to date.
pub(super) fn schema(folder: &Path, is_check: bool, printing: &Output) -> Result<Exit, StageError> {
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
    let place = |(name, text): (&str, String)| (folder.join(name), text);
    let mut files: Vec<(PathBuf, String)> = read.map(place).into();
    let others = for_programs.map(place).into_iter();
    if is_check {
        files.extend(others.filter(|(path, _)| path.exists()));
        return Ok(check(&files, printing));
    }
    files.extend(others);
    let _folder = Folder::make(folder)?;
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
