//! Arguments outside the range that makes sense: refused with the range, before anything is done.

use crate::program::{Program, SMALL, pipeline};

/// Asserts that a command is refused with exit code 2 and certain words, and leaves no file.
fn refused(arguments: &[&str], words: &str) {
    let program = Program::new();
    let refused = program.command(arguments).assert().code(2);
    let text = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(text.contains(words), "{arguments:?}: {text}");
    let left = std::fs::read_dir(program.path("")).unwrap().count();
    assert_eq!(left, 0, "{arguments:?}");
}

#[test]
fn numbers_of_threads_and_jobs_have_a_range() {
    let scene = pipeline("newton.toml");
    let scene = scene.to_str().unwrap();
    for threads in ["0", "5000", "-1", "many"] {
        let flag = format!("--threads={threads}");
        let words = match threads {
            "many" => "invalid digit",
            _ => "1..=1024",
        };
        refused(&["run", scene, "run.h5", &flag], words);
    }
    let sweep = pipeline("sweep_friction.toml");
    let sweep = sweep.to_str().unwrap();
    for jobs in ["0", "60000"] {
        refused(&["sweep", sweep, "out", "--jobs", jobs], "1..=1024");
    }
}

#[test]
fn memory_and_budget_are_positive_numbers_of_a_range() {
    let sweep = pipeline("sweep_friction.toml");
    let sweep = sweep.to_str().unwrap();
    for memory in ["nan", "-1", "0", "inf", "1e300", "1e-300"] {
        let arguments = ["sweep", sweep, "out", "--memory", memory];
        refused(&arguments, "gigabytes from 1e-9 to 1e6");
    }
    let scene = pipeline("newton.toml");
    let scene = scene.to_str().unwrap();
    for budget in ["nan", "-1", "0", "1e300"] {
        let arguments = ["accuracy", scene, "run.h5", "--budget", budget];
        refused(&arguments, "seconds from 1e-3 to 1e9");
    }
}

#[test]
fn a_finest_mesh_that_no_machine_holds_is_refused_before_the_long_work() {
    let scene = pipeline("newton.toml");
    let scene = scene.to_str().unwrap();
    for n_div in ["1000000", "0", "-4"] {
        let finest = format!("--finest={n_div}");
        let arguments = ["accuracy", scene, "run.h5", &finest];
        refused(&arguments, "from 1 to 4096");
    }
    let mut arguments = vec!["accuracy", scene, "run.h5", "--finest", "4096"];
    arguments.extend(SMALL);
    refused(&arguments, "solving the finest mesh: expected at most");
}

/// With `--json` an error of usage is JSON on standard output too.
#[test]
fn errors_of_usage_are_json_where_json_is_asked_for() {
    let program = Program::new();
    let refused = program.command(&["status", "--json"]).assert().code(2);
    let error: serde_json::Value = serde_json::from_slice(&refused.get_output().stdout).unwrap();
    assert_eq!(error["exit_code"], 2);
    assert!(
        error["error"].as_str().unwrap().contains("<FILE>"),
        "{error}"
    );
}

#[test]
fn shares_are_numbers_or_percent() {
    for text in ["", "%", "one", "1 percent", "nan", "inf"] {
        let run = ["run", "s.toml", "r.h5", "--error", text];
        refused(&run, "write 3% or 0.03");
    }
    let scene = pipeline("newton.toml");
    let scene = scene.to_str().unwrap();
    for (text, share) in [("1%", "0.01"), (" 2.5 % ", "0.025"), ("0.01", "0.01")] {
        let bad = ["--set", "solve.epsilon=7.0", "--error", text];
        let run = [&["run", scene, "r.h5"][..], &bad].concat();
        refused(&run, &format!("--set solve.epsilon=7.0 --error {share}:"));
    }
}
