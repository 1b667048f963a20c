//! `stability`: one scene, or a suite of cases.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use clap::Args;
use contact3d::scene::InvalidValue;
use runfile::RunFile;
use studies::{StudyStep, stability::VerdictLevel};

use super::{
    arguments::{Output, SceneArguments},
    exit::Exit,
    override_scene, progress, terminal,
};
use crate::{
    format::StabilityRow,
    output::Inputs,
    pipeline::{StageError, mesh_files},
    report::stability as figures,
    suite::{self, SuiteCase},
};

/// Arguments of `stability`.
#[derive(Debug, Args)]
pub struct StabilityArguments {
    /// A scene, or the index of a suite; by default the hard cases that are part of the program
    pub input: Option<PathBuf>,
    /// Change one key of the scene, for example --set body.brick.cells=[12,4,4]
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// Store the table in this HDF5 file, created or updated
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
    /// Small meshes only
    #[arg(long)]
    pub coarse: bool,
    /// Only the cases of this family, or with this in their names
    #[arg(long, value_name = "NAME")]
    pub only: Option<String>,
    /// Print the table as Markdown
    #[arg(long, conflicts_with = "json")]
    pub markdown: bool,
}

impl StabilityArguments {
    /// The file for the table, looked at before the checks, which take long.
    fn claim(&self, inputs: &Inputs) -> Result<Option<RunFile>, StageError> {
        let claim = |file: &PathBuf| suite::claim(file, inputs);
        self.table.as_ref().map(claim).transpose()
    }
}

/// `stability`: checks a scene, or all cases of a suite; prints and stores their table.
pub(super) fn stability(
    arguments: &StabilityArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    match &arguments.input {
        None => run_builtin(arguments, output, threads),
        Some(index) if suite::is_index(index) => run_suite(arguments, index, output, threads),
        Some(scene) => run_scene(arguments, scene, output, threads),
    }
}

fn run_builtin(
    arguments: &StabilityArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    let folder = suite::unpack().map_err(|source| StageError::Io {
        action: "write the hard cases to the folder for temporary files",
        file: std::env::temp_dir(),
        source,
    })?;
    let index = folder.path().join(suite::INDEX);
    run_suite(arguments, &index, output, threads)
}

fn run_suite(
    arguments: &StabilityArguments,
    index: &Path,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    if let Some(change) = arguments.overrides.first() {
        return Err(StageError::Setting(InvalidValue {
            key: "--set".into(),
            expected: "a scene to change".into(),
            found: format!("--set {change} with a suite"),
            help: "name a scene, as in `stability SCENE --set KEY=VALUE`, or change the index of the suite".into(),
        }));
    }
    let mut cases = suite::read(index, arguments.coarse)?;
    if let Some(part) = &arguments.only {
        cases.retain(|case| case.name.contains(part.as_str()) || case.family == *part);
        if cases.is_empty() {
            return Err(StageError::Setting(InvalidValue {
                key: "--only".into(),
                expected: "a family of the suite, or a part of the name of a case".into(),
                found: part.clone(),
                help: "without --only all cases run, and their names are printed".into(),
            }));
        }
    }
    let meshes = cases.iter().flat_map(|case| mesh_files(&case.scene));
    let table = arguments.claim(&Inputs::of(meshes.chain([index.to_owned()])))?;
    let mut rows = Vec::new();
    let spinner = progress::spinner("stability", output);
    let began = Instant::now();
    for (number, case) in cases.iter().enumerate() {
        let started = Instant::now();
        let left = (number > 0).then(|| {
            let each = began.elapsed().as_secs_f64() / number as f64;
            each * (cases.len() - number) as f64
        });
        let row = case.check(&mut |step| {
            if let StudyStep::Begin(words) = step {
                let words = format!("{}: {words}", case.name);
                progress::piece(&spinner, &words, [number + 1, cases.len()], left, started);
            }
        });
        let seconds = started.elapsed().as_secs_f64();
        let line = format!("{:<28} {:<8} {seconds:.1} s", row.name, row.word());
        spinner.suspend(|| terminal::say(output, &line));
        rows.push(row);
    }
    spinner.finish_and_clear();
    if let Some(file) = table {
        suite::store(file, &rows, threads)?;
    }
    Ok(finish(arguments, output, &rows, figures::table))
}

fn run_scene(
    arguments: &StabilityArguments,
    scene: &Path,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    let (scene, inputs) = override_scene::read_with_inputs(&SceneArguments {
        scene: scene.to_owned(),
        overrides: arguments.overrides.clone(),
    })?;
    let table = arguments.claim(&inputs)?;
    let spinner = progress::spinner("stability", output);
    let case = SuiteCase::alone(scene);
    let rows = [case.check(&mut |step| progress::show_study(&spinner, output, step))];
    spinner.finish_and_clear();
    if let Some(file) = table {
        suite::store(file, &rows, threads)?;
    }
    Ok(finish(arguments, output, &rows, figures::details))
}

fn finish(
    arguments: &StabilityArguments,
    output: &Output,
    rows: &[StabilityRow],
    words: fn(&[StabilityRow]) -> String,
) -> Exit {
    let words = if arguments.markdown {
        figures::markdown
    } else {
        words
    };
    terminal::print(output, || figures::json(rows), || words(rows));
    let passes = |row: &StabilityRow| {
        let check = row.outcome.as_ref();
        check.is_ok_and(|check| check.verdict().level != VerdictLevel::Fail)
    };
    Exit::of(rows.iter().all(passes))
}
