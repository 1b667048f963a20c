use std::time::Instant;

use super::{
    arguments::{CheckArguments, Output, StabilityArguments},
    exit::{Exit, explain_sweep},
    override_scene, stability_words,
};
use crate::{
    format::StabilityRow,
    stability::{Depth, Level},
    stages::StageError,
    suite::{self, Case, Version},
    sweep::SweepError,
};

/// `stability`: checks all cases of a suite and prints and stores their table.
pub(super) fn stability(arguments: &StabilityArguments, output: &Output, threads: usize) -> Exit {
    let outcome = run_suite(arguments, output, threads);
    outcome.unwrap_or_else(|error| explain_sweep(error, output))
}

fn run_suite(
    arguments: &StabilityArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, SweepError> {
    let version = match arguments.coarse {
        true => Version::Coarse,
        false => Version::Full,
    };
    let mut cases = suite::read(&arguments.suite, version)?;
    if let Some(part) = &arguments.only {
        cases.retain(|case| case.name.contains(part.as_str()) || case.family == *part);
    }
    let mut rows = Vec::new();
    for case in &cases {
        let started = Instant::now();
        let row = case.check(threads);
        if !output.quiet {
            let seconds = started.elapsed().as_secs_f64();
            eprintln!("{:<28} {:<8} {seconds:.1} s", row.name, row.word());
        }
        rows.push(row);
    }
    if let Some(file) = &arguments.out {
        suite::store(file, &rows, threads)?;
    }
    Ok(show(&rows, output, || match arguments.markdown {
        true => stability_words::markdown(&rows),
        false => stability_words::table(&rows),
    }))
}

/// `check`: the same for one scene.
pub(super) fn check(
    arguments: &CheckArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    let scene = override_scene::read(&arguments.scene)?;
    let row = Case::alone(scene, Depth::Invariances).check(threads);
    let rows = [row];
    Ok(show(&rows, output, || stability_words::details(&rows[0])))
}

fn show(rows: &[StabilityRow], output: &Output, words: impl Fn() -> String) -> Exit {
    if output.json {
        println!("{:#}", stability_words::json(rows));
    } else if !output.quiet {
        print!("{}", words());
    }
    let holds = |row: &StabilityRow| {
        let check = row.outcome.as_ref();
        check.is_ok_and(|check| check.verdict().level != Level::Fails)
    };
    if rows.iter().all(holds) {
        Exit::Done
    } else {
        Exit::NotConverged
    }
}
