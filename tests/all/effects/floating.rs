//! Bodies that only contact holds: their datasets, exit codes, words, and what cannot be asked of them.

use std::path::Path;

use assert_cmd::{Command, assert::Assert};
use contact3d_pipe::LAYOUT;
use runfile::Reader;

use super::support::pipelines;

/// A coarse block on a slope of a tangent; F is 0.3.
fn on_slope(folder: &Path, command: &[&str], slope: &str, more: &[&str]) -> Assert {
    let scene = pipelines().join("block_on_slope.toml");
    let set = format!("parameters.slope={slope}");
    let mut arguments: Vec<&str> = command.to_vec();
    arguments.insert(1, scene.to_str().unwrap());
    arguments.extend(["--set", "body.brick.cells=[8,4,2]", "--set", &set]);
    arguments.extend(more);
    let mut program = Command::cargo_bin("contact3d-pipe").unwrap();
    program.current_dir(folder).args(arguments).assert()
}

fn has(folder: &Path, path: &str) -> bool {
    Reader::open(&folder.join("run.h5"), LAYOUT)
        .unwrap()
        .has(path)
}

#[test]
fn below_the_limit_the_file_has_the_rigid_motions() {
    let folder = tempfile::tempdir().unwrap();
    let run = ["run", "run.h5", "--no-figures", "-v"];
    let assert = on_slope(folder.path(), &run, "0.2999997", &[]).success();
    let text = String::from_utf8(assert.get_output().stdout.clone()).unwrap();
    assert!(text.contains("6 motions that only contact stops"), "{text}");
    assert!(text.contains("moves"), "{text}");
    assert!(has(folder.path(), "/assemble/rigid_modes"));
    assert!(has(folder.path(), "/solve/rigid_motion"));
    assert!(!has(folder.path(), "/solve/mechanism"));
    assert!(!has(folder.path(), "/VTKHDF/PointData/mechanism"));
}

#[test]
fn beyond_the_limit_the_exit_code_is_1_and_the_motion_is_said_and_stored() {
    let folder = tempfile::tempdir().unwrap();
    let run = ["run", "run.h5", "--no-figures"];
    let assert = on_slope(folder.path(), &run, "0.3000003", &[]).code(1);
    let text = String::from_utf8(assert.get_output().stdout.clone()).unwrap();
    assert!(
        text.contains("mechanism            translation along"),
        "{text}"
    );
    let message = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
    assert!(message.contains("no equilibrium"), "{message}");
    let reader = Reader::open(&folder.path().join("run.h5"), LAYOUT).unwrap();
    let [stored, shown] = ["/solve/mechanism", "/VTKHDF/PointData/mechanism"]
        .map(|path| reader.read_vec::<f64>(path).unwrap());
    assert_eq!(stored, shown);
    drop(reader);
    // The parts of a run do what the whole does, from the stored factor.
    for stage in ["solve", "post"] {
        let mut program = Command::cargo_bin("contact3d-pipe").unwrap();
        program
            .current_dir(folder.path())
            .args([stage, "run.h5"])
            .assert()
            .code(1);
    }
    let mut program = Command::cargo_bin("contact3d-pipe").unwrap();
    program
        .current_dir(folder.path())
        .args(["check", "run.h5"])
        .assert()
        .success();
}

#[test]
fn stored_modes_give_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let run = ["run", "run.h5", "--no-figures"];
    on_slope(folder.path(), &run, "0.25", &[]).success();
    let read = || -> Vec<f64> {
        let reader = Reader::open(&folder.path().join("run.h5"), LAYOUT).unwrap();
        let mut all = reader.read_vec::<f64>("/solve/multiplier_normal").unwrap();
        all.extend(reader.read_vec::<f64>("/solve/displacement").unwrap());
        all
    };
    let first = read();
    let mut program = Command::cargo_bin("contact3d-pipe").unwrap();
    let solve = ["solve", "run.h5", "--quiet"];
    program
        .current_dir(folder.path())
        .args(solve)
        .assert()
        .success();
    assert!(
        first
            .iter()
            .zip(&read())
            .all(|(a, b)| a.to_bits() == b.to_bits())
    );
}

#[test]
fn what_needs_the_inverse_of_a_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let range = [
        "--parameter=friction.coefficient.constant",
        "--from=0.3",
        "--to=0.4",
    ];
    let paths = on_slope(folder.path(), &["branches", "paths.h5"], "0.2", &range).code(2);
    let message = String::from_utf8(paths.get_output().stderr.clone()).unwrap();
    assert!(message.contains("only contact holds"), "{message}");
}
