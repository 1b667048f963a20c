//! Adaptive runs: the target, its levels in the file, going on after a kill, and what is refused.

use std::{
    process::{Command, Stdio},
    thread::sleep,
    time::Duration,
};

use assert_cmd::cargo::CommandCargoExt;
use serde_json::Value;

use crate::program::{Program, pipeline};

/// `run` on the adaptive pipeline with a target.
fn run(program: &Program, target: &str, more: &[&str]) -> assert_cmd::assert::Assert {
    let scene = pipeline("adaptive.toml");
    let scene = scene.to_str().expect("plain path");
    let mut command = program.command(&["run", scene, "run.h5", "--no-figures", "--error", target]);
    command.args(more).assert()
}

fn levels(assert: &assert_cmd::assert::Assert) -> Value {
    let json: Value = serde_json::from_slice(&assert.get_output().stdout).expect("JSON");
    json["adaptation"].clone()
}

fn said(assert: &assert_cmd::assert::Assert) -> String {
    String::from_utf8_lossy(&assert.get_output().stderr).into_owned()
}

#[test]
fn a_wish_is_met_and_a_second_run_keeps_everything() {
    let program = Program::new();
    let first = run(&program, "10%", &["--json"]).success();
    let adaptation = levels(&first);
    assert_eq!(adaptation["status"], "met");
    let list = adaptation["levels"].as_array().expect("levels");
    let errors: Vec<f64> = list
        .iter()
        .map(|l| l["estimated_error"].as_f64().expect("a share"))
        .collect();
    let (last, earlier) = errors.split_last().expect("levels");
    assert!(
        *last <= 0.1 && earlier.iter().all(|e| *e > 0.1),
        "{errors:?}"
    );
    assert!(program.states().iter().all(|(_, state)| state == "fresh"));
    let before = program.everything();
    run(&program, "10%", &[]).success();
    assert_eq!(program.everything(), before, "nothing is written again");
    program.command(&["check", "run.h5"]).assert().success();
    // A stage by hand works on the adaptive mesh.
    program.command(&["solve", "run.h5"]).assert().success();
    program
        .command(&["post", "run.h5", "--no-figures"])
        .assert()
        .success();
    assert!(program.states().iter().all(|(_, state)| state == "fresh"));
}

/// A tighter target goes on from the levels that are there, a looser one takes the first that is enough, and
/// that is the one it was.
#[test]
fn targets_may_change() {
    let program = Program::new();
    run(&program, "12%", &[]).success();
    let coarse = program.digests();
    let more = run(&program, "8.5%", &[]).success();
    assert!(!said(&more).contains("level 0"), "{}", said(&more));
    let again = run(&program, "12%", &[]).success();
    assert!(!said(&again).contains("level"), "{}", said(&again));
    assert_eq!(program.digests(), coarse);
    // Without a target the mesh is the body's own again.
    let scene = pipeline("quadratic.toml");
    let arguments = [
        "run",
        scene.to_str().expect("plain path"),
        "run.h5",
        "--no-figures",
    ];
    program
        .command(&arguments)
        .args(["--set", "body.brick.cells=[6,2,2]"])
        .assert()
        .success();
    program.command(&["check", "run.h5"]).assert().success();
}

/// Pictures are those of the last level, also when a tighter target goes on from a file that was done.
#[test]
fn a_tighter_wish_draws_its_own_pictures() {
    let program = Program::new();
    let scene = pipeline("adaptive.toml");
    let scene = scene.to_str().expect("plain path");
    let drawn = ["14%", "10%"].map(|target| {
        let mut command = program.command(&["run", scene, "run.h5", "--error", target]);
        command.assert().success();
        std::fs::read(program.path("run-figures/discretisation_error.svg")).expect("a picture")
    });
    assert_ne!(drawn[0], drawn[1]);
}

#[test]
fn threads_do_not_change_the_bits() {
    let digests = ["1", "3"].map(|threads| {
        let program = Program::new();
        run(&program, "12%", &["--threads", threads]).success();
        program.digests()
    });
    assert_eq!(digests[0], digests[1]);
}

#[test]
fn a_killed_run_goes_on_from_the_last_level() {
    let expected = {
        let program = Program::new();
        run(&program, "6%", &[]).success();
        program.digests()
    };
    let program = Program::new();
    for round in 0..6_u64 {
        let mut child = Command::cargo_bin("contact3d-pipe")
            .expect("built program")
            .current_dir(program.path(""))
            .arg("run")
            .arg(pipeline("adaptive.toml"))
            .args(["run.h5", "--no-figures", "--quiet", "--error", "6%"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("started");
        sleep(Duration::from_millis(60 + 40 * round));
        let _ = child.kill();
        child.wait().expect("ended");
    }
    run(&program, "6%", &[]).success();
    assert_eq!(program.digests(), expected);
}

/// What does not fit, here into the largest file allowed, ends with the last level that did, stored, and exit
/// code 1.
#[test]
fn a_wish_beyond_the_disk_is_not_met() {
    let program = Program::new();
    let scene = pipeline("adaptive.toml");
    let limited = format!(
        "ulimit -f 20000; exec {} run {} run.h5 --no-figures --threads 1 --error 0.5%",
        assert_cmd::cargo::cargo_bin("contact3d-pipe").display(),
        scene.display()
    );
    let ended = Command::new("sh")
        .args(["-c", &limited])
        .current_dir(program.path(""))
        .output()
        .expect("sh");
    let text = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(1), "{text}");
    assert!(
        text.contains("does not fit") && text.contains("NOT MET"),
        "{text}"
    );
    assert!(program.states().iter().all(|(_, state)| state == "fresh"));
}

#[test]
fn impossible_wishes_are_refused() {
    let program = Program::new();
    for (target, words) in [
        ("200%", "between 1e-8 and 1"),
        ("0", "between 1e-8 and 1"),
        ("-1%", "between 1e-8 and 1"),
        ("1e-9", "between 1e-8 and 1"),
        ("nan", "write 1% or 0.01"),
        ("little", "write 1% or 0.01"),
    ] {
        let scene = pipeline("adaptive.toml");
        let error = format!("--error={target}");
        let refused = program
            .command(&["run", scene.to_str().expect("plain path"), "run.h5", &error])
            .assert()
            .code(2);
        assert!(
            said(&refused).contains(words),
            "{target}: {}",
            said(&refused)
        );
    }
    assert!(!program.path("run.h5").exists());
}

/// Cases of a sweep have meshes of their own, and one whose target is not met counts as not converged.
#[test]
fn sweeps_refine_each_case() {
    let program = Program::new();
    let scene = std::fs::read_to_string(pipeline("adaptive.toml")).expect("a pipeline");
    std::fs::write(program.path("scene.toml"), scene).expect("written");
    let sweep = "scene = \"scene.toml\"\n[[axis]]\nkey = \"adapt.error\"\nvalues = [0.14, 0.1]\n";
    std::fs::write(program.path("sweep.toml"), sweep).expect("written");
    program
        .command(&["sweep", "sweep.toml", "--out", "cases"])
        .assert()
        .success();
    let before = program.everything();
    program
        .command(&["sweep", "sweep.toml", "--out", "cases"])
        .assert()
        .success();
    let run_files = |all: &std::collections::BTreeMap<String, Option<Vec<u8>>>| {
        all.iter()
            .filter(|(name, _)| name.ends_with(".h5") && !name.contains("summary"))
            .map(|(n, c)| (n.clone(), c.clone()))
            .collect::<Vec<_>>()
    };
    assert_eq!(run_files(&program.everything()), run_files(&before));
    assert_eq!(run_files(&before).len(), 2);
}
