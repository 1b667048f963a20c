//! Killed at any moment, the previous state stays readable and the same command goes on.

use std::{
    process::{Command, Stdio},
    thread::sleep,
    time::Duration,
};

use assert_cmd::cargo::CommandCargoExt;

use crate::program::{Program, SMALL, pipeline};

/// Starts `run` with a tolerance of its own, waits, and sends a signal.
fn interrupt(program: &Program, epsilon: &str, wait: Duration, signal: &str) {
    let mut child = Command::cargo_bin("contact3d-pipe")
        .unwrap()
        .current_dir(program.path(""))
        .arg("run")
        .arg(pipeline("hkl2011_table1.toml"))
        .args(["run.h5", "--no-figures", "--quiet", "--set", epsilon])
        .args(SMALL)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    sleep(wait);
    let _ = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .stderr(Stdio::null())
        .status();
    child.wait().unwrap();
}

#[test]
fn a_killed_run_leaves_a_readable_file_and_goes_on() {
    let program = Program::new();
    program.run(&[]).assert().success();
    let expected = {
        let other = Program::new();
        other
            .run(&["--set", "solve.epsilon=1e-6"])
            .assert()
            .success();
        other.digests()
    };
    for round in 0..24_u64 {
        let signal = ["-KILL", "-TERM", "-INT"][round as usize % 3];
        let epsilon = ["solve.epsilon=1e-6", "solve.epsilon=1e-5"][round as usize % 2];
        interrupt(&program, epsilon, Duration::from_millis(3 * round), signal);
        let states = program.states();
        assert_eq!(states[0].1, "fresh", "round {round}: {states:?}");
        assert_eq!(states[1].1, "fresh", "round {round}: {states:?}");
        if signal != "-KILL" {
            assert!(program.hidden().is_empty(), "round {round}");
        }
    }
    program
        .run(&["--set", "solve.epsilon=1e-6"])
        .assert()
        .success();
    assert_eq!(program.digests(), expected);
    assert!(program.hidden().is_empty());
}

/// Waits until a file is there.
fn wait_for(path: &std::path::Path) {
    for _ in 0..600 {
        if path.exists() {
            return;
        }
        sleep(Duration::from_millis(50));
    }
    panic!("{} did not appear", path.display());
}

#[test]
fn an_interrupted_run_says_what_it_kept() {
    let program = Program::new();
    // Long enough for checkpoints, with which what waits is stored.
    let child = Command::cargo_bin("contact3d-pipe")
        .unwrap()
        .current_dir(program.path(""))
        .arg("run")
        .arg(pipeline("hkl2011_table1.toml"))
        .args([
            "run.h5",
            "--no-figures",
            "--set",
            "body.brick.cells=[24,8,8]",
            "--set",
            "solve.epsilon=1e-10",
        ])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    wait_for(&program.path("run.h5"));
    Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), None, "ended by the signal");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let kept = "interrupted: run.h5 keeps scene, mesh";
    assert!(text.contains(kept), "{text}");
    assert!(
        text.contains("the same command goes on from there"),
        "{text}"
    );
    assert_eq!(program.states()[0].1, "fresh");
}

/// An engine that greets, notes its process, and does what is said.
fn engine(program: &Program, then: &str) -> String {
    let text = format!("echo $$ >engine.pid; printf 'C3DENG01\\1\\0\\0\\0\\0\\0\\0\\0x'; {then}");
    std::fs::write(program.path("engine.sh"), text).unwrap();
    "sh engine.sh".into()
}

#[test]
fn an_engine_with_an_unknown_status_is_refused() {
    let program = Program::new();
    let engine = engine(
        &program,
        "printf '\\7\\0\\0\\0\\0\\0\\0\\0'; cat >/dev/null",
    );
    let mut run = program.run(&["--engine", &engine]);
    let refused = run.timeout(Duration::from_secs(60)).assert().code(2);
    let text = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(
        text.contains("its answer begins with 7, expected 0, 1, 2 or 3"),
        "{text}"
    );
}

#[test]
fn an_engine_dies_with_a_killed_program() {
    let program = Program::new();
    let engine = engine(&program, "sleep 600 & wait");
    let mut child = Command::cargo_bin("contact3d-pipe")
        .unwrap()
        .current_dir(program.path(""))
        .arg("run")
        .arg(pipeline("newton.toml"))
        .args(["run.h5", "--no-figures", "--quiet", "--engine", &engine])
        .spawn()
        .unwrap();
    wait_for(&program.path("engine.pid"));
    sleep(Duration::from_millis(200));
    child.kill().unwrap();
    child.wait().unwrap();
    let pid = std::fs::read_to_string(program.path("engine.pid")).unwrap();
    let is_there = || {
        let status = Command::new("kill")
            .args(["-0", pid.trim()])
            .stderr(Stdio::null())
            .status();
        status.unwrap().success()
    };
    let mut looks = (0..100).map(|_| {
        sleep(Duration::from_millis(100));
        is_there()
    });
    assert!(looks.any(|there| !there), "the engine outlives the program");
}
