//! Readers that go away, outputs that are full or closed, and which output says what.
#![cfg(unix)]

use std::process::{Command, Output};

use serde_json::Value;

use crate::program::{Program, SMALL, pipeline};

/// Runs a shell script in the scratch folder, where `$program` is the program and `$scene` a small
/// scene.
fn shell(program: &Program, script: &str) -> Output {
    let scene = pipeline("hkl2011_table1.toml");
    Command::new("bash")
        .args(["-c", script])
        .current_dir(program.path(""))
        .env("program", assert_cmd::cargo::cargo_bin("contact3d-pipe"))
        .env("scene", scene)
        .env("small", SMALL.join(" "))
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Asserts that every stage of `run.h5` is stored and what was written.
fn assert_complete(program: &Program) {
    let states = program.states();
    assert!(
        states.iter().all(|(_, state)| state == "fresh"),
        "{states:?}"
    );
    program.command(&["check", "run.h5"]).assert().success();
}

#[test]
fn a_reader_that_goes_away_ends_no_command() {
    let program = Program::new();
    let script = "\"$program\" run \"$scene\" run.h5 $small 2>&1 | head -1; echo ${PIPESTATUS[0]}";
    let output = shell(&program, script);
    assert_eq!(text(&output.stdout).lines().last(), Some("0"), "{output:?}");
    assert_complete(&program);
    assert!(program.path("run-figures/overview.svg").exists());
    // A reader that is gone before the first line.
    let script =
        "(sleep 0.3; \"$program\" status run.h5; echo $? >code) | true; sleep 0.6; cat code";
    let output = shell(&program, script);
    assert_eq!(text(&output.stdout).trim(), "0");
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
    for command in [
        "check run.h5 --json --quiet",
        "--help",
        "friction-law \"$scene\" --no-figures",
        "report run.h5 r.html --json",
    ] {
        let script = format!(
            "(sleep 0.2; \"$program\" {command}; echo $? >code) 2>err | true; sleep 0.6; cat code err"
        );
        let output = shell(&program, &script);
        assert_eq!(text(&output.stdout).trim(), "0", "{command}");
    }
}

#[test]
fn a_full_standard_output_is_said_and_work_is_kept() {
    let program = Program::new();
    for flags in ["--quiet --json", ""] {
        let script =
            format!("\"$program\" run \"$scene\" run.h5 --no-figures $small {flags} >/dev/full");
        let output = shell(&program, &script);
        assert_eq!(output.status.code(), Some(3), "{output:?}");
        let said = text(&output.stderr);
        assert!(
            said.contains("error: cannot write the results to standard output"),
            "{said}"
        );
        assert_complete(&program);
    }
    for command in ["status run.h5", "--help", "check run.h5 --json"] {
        let output = shell(&program, &format!("\"$program\" {command} >/dev/full"));
        assert_eq!(output.status.code(), Some(3), "{command}: {output:?}");
    }
}

#[test]
fn a_full_or_closed_standard_error_stops_no_work() {
    for redirection in ["2>/dev/full", "2>&-", "2>&- >&-"] {
        let program = Program::new();
        let script =
            format!("\"$program\" run \"$scene\" run.h5 --no-figures $small {redirection}");
        let output = shell(&program, &script);
        assert_eq!(output.status.code(), Some(0), "{redirection}: {output:?}");
        assert_complete(&program);
    }
}

#[test]
fn errors_survive_a_full_standard_error() {
    let program = Program::new();
    let output = shell(&program, "\"$program\" status missing.h5 2>/dev/full");
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn results_go_to_standard_output_and_messages_to_standard_error() {
    let program = Program::new();
    let done = program.run(&[]).assert().success();
    let [out, err] = [&done.get_output().stdout, &done.get_output().stderr].map(|o| text(o));
    let results = ["12 panes: ", "normal force", "certificate equilibrium"];
    for words in results {
        assert!(
            out.contains(words) && !err.contains(words),
            "{words}: {out}{err}"
        );
    }
    for words in ["mesh      done in", "post      done in"] {
        assert!(
            err.contains(words) && !out.contains(words),
            "{words}: {out}{err}"
        );
    }
    for command in ["solve", "post"] {
        let done = program.command(
            &[command, "run.h5", "-v", "--no-figures"][..if command == "solve" { 3 } else { 4 }],
        );
        let out = text(&{ done }.assert().success().get_output().stdout);
        assert!(out.contains("12 panes: "), "{command}: {out}");
    }
    // By default an answer fits on the first screen: fifteen lines of results, and nothing of the work.
    let scene = pipeline("newton.toml");
    let mut run = program.command(&["run", scene.to_str().unwrap(), "run.h5", "--no-figures"]);
    let done = run.args(SMALL).assert().success();
    let [out, err] = [&done.get_output().stdout, &done.get_output().stderr].map(|o| text(o));
    assert!(out.lines().count() <= 15 && err.is_empty(), "{out}{err}");
    for line in [
        "  status               converged to ",
        "  contact force        (-9.15, 0, 59.14) MN on the body",
        "  friction force       9.153 MN",
        "  largest pressure     41.64 MPa ± ",
        "  largest von Mises    ",
        "  largest displacement ",
        "  next                 contact3d-pipe report run.h5 run.html",
    ] {
        assert!(out.contains(line), "{line}: {out}");
    }
    let quiet = program.run(&["--quiet"]).assert().success();
    assert!(quiet.get_output().stdout.is_empty());
}

#[test]
fn with_json_standard_output_holds_json_alone() {
    let program = Program::new();
    let scene = pipeline("hkl2011_table1.toml");
    let scene = scene.to_str().unwrap();
    let run = ["run", scene, "run.h5", "--no-figures", SMALL[0], SMALL[1]];
    let commands: [&[&str]; 10] = [
        &run,
        &["mesh", scene, "mesh.h5", SMALL[0], SMALL[1]],
        &["assemble", "run.h5"],
        &["solve", "run.h5"],
        &["post", "run.h5"],
        &["status", "run.h5"],
        &["check", "run.h5"],
        &["report", "run.h5"],
        &["friction-law", scene],
        &["schema", "schemas"],
    ];
    for command in commands {
        let done = program.command(command).arg("--json").assert().success();
        let json: Result<Value, _> = serde_json::from_slice(&done.get_output().stdout);
        assert!(
            json.is_ok(),
            "{command:?}: {}",
            text(&done.get_output().stdout)
        );
    }
    let failed = program
        .command(&["status", "none.h5", "--json"])
        .assert()
        .code(2);
    let error: Value = serde_json::from_slice(&failed.get_output().stdout).unwrap();
    assert_eq!(error["exit_code"], 2);
}
