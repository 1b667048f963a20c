//! `export --fclib`: what is written, what is refused, and that inputs stay as they are.

use std::fs;

use hdf5_metno as hdf5;
use serde_json::Value;

use crate::program::{Program, pipeline};

/// Three panes of the published scene, solved with further changes.
fn solved(changes: &[&str]) -> Program {
    solved_scene(
        "newton.toml",
        &[&["body.brick.cells=[6,2,2]"], changes].concat(),
    )
}

/// A scene of the pipelines, solved with changes.
fn solved_scene(name: &str, changes: &[&str]) -> Program {
    let program = Program::new();
    let scene = pipeline(name);
    let mut arguments = vec![
        "--quiet",
        "run",
        scene.to_str().expect("plain path"),
        "run.h5",
        "--no-figures",
    ];
    for change in changes {
        arguments.extend(["--set", change]);
    }
    program.command(&arguments).assert().success();
    program
}

/// Runs a command that must end with a code; returns its JSON.
fn json(program: &Program, arguments: &[&str], code: i32) -> Value {
    let arguments = [&["--json"], arguments].concat();
    let output = program.command(&arguments).output().expect("run");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text}");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// Runs a command that must be refused with nothing changed; returns what it said.
fn refused(program: &Program, arguments: &[&str]) -> String {
    let before = program.everything();
    let error = json(program, arguments, 2);
    assert!(
        program.everything() == before,
        "{arguments:?} changed something"
    );
    error["error"].as_str().expect("a message").to_owned()
}

#[test]
fn an_exported_solution_solves_the_exported_problem() {
    let program = solved(&[]);
    let before = fs::read(program.path("run.h5")).expect("run file");
    for (kind, form) in [("fclib", "local"), ("fclib-global", "global")] {
        let arguments = ["export", "run.h5", "out.hdf5", "--kind", kind];
        // The second replaces the first, which is the program's own.
        let exported = json(&program, &arguments, 0);
        assert_eq!(exported["form"], form);
        assert_eq!(exported["contacts"], 3);
        if form == "local" {
            assert!(exported["error"].as_f64().expect("measured") <= 1e-10);
        }
    }
    assert!(fs::read(program.path("run.h5")).expect("run file") == before);
}

#[test]
fn laws_that_fclib_cannot_hold_are_refused_with_the_reason() {
    for (change, word) in [
        (
            "friction={slip_bound=1e6,coefficient={constant=0.3}}",
            "Tresca",
        ),
        ("friction.pressure_cap=1e7", "capped at a pressure"),
        ("assemble.factor=\"single\"", "single precision"),
    ] {
        let program = solved(&[change]);
        let text = refused(
            &program,
            &["export", "run.h5", "out.hdf5", "--kind", "fclib"],
        );
        assert!(text.contains(word), "{change}: {text}");
    }
    for (scene, cells, word) in [
        (
            "block_on_slope.toml",
            "body.brick.cells=[8,4,2]",
            "only contact holds the body",
        ),
        ("history.toml", "body.brick.cells=[6,2,2]", "load history"),
    ] {
        let program = solved_scene(scene, &[cells]);
        let text = refused(
            &program,
            &["export", "run.h5", "out.hdf5", "--kind", "fclib"],
        );
        assert!(text.contains(word), "{scene}: {text}");
    }
}

/// One half with friction, the other without: its contacts have tangential rows all the same, and μ = 0.
#[test]
fn a_face_without_friction_has_contacts_without_friction() {
    let halves = "contact=[{face='z_min',name='dry',box=[[0.0,0.0,0.0],[1.0,1.0,0.0]],\
                  friction={coefficient={constant=0.6}}},{face='z_min',name='greased',box=[[1.5,0.0,0.0],[3.0,1.0,0.0]]}]";
    let program = solved_scene(
        "dry_and_greased.toml",
        &["body.brick.cells=[12,4,2]", halves],
    );
    let exported = json(
        &program,
        &["export", "run.h5", "out.hdf5", "--kind", "fclib"],
        0,
    );
    assert!(exported["error"].as_f64().expect("measured") <= 1e-10);
    let problem = hdf5::File::open(program.path("out.hdf5")).expect("readable");
    let numbers = |name: &str| {
        let dataset = problem.dataset(name).expect("there");
        dataset.read_raw::<f64>().expect("numbers")
    };
    // Two columns of two panes with friction, which come first, three without; F is the reciprocal of a mean.
    let mu = numbers("fclib_local/vectors/mu");
    let (with, without) = mu.split_at(4);
    assert!(with.iter().all(|mu| (mu - 0.6).abs() < 1e-14), "{with:?}");
    assert_eq!(without, [0.0; 6]);
    let entries = numbers("fclib_local/W/x");
    assert_eq!(entries.len(), 30 * 30);
    assert!((0..30).all(|k| entries[31 * k] > 0.0));
}

#[test]
fn unsolved_files_and_outputs_of_others_are_refused() {
    let program = solved(&[]);
    let scene = pipeline("newton.toml");
    let mesh = [
        "mesh",
        scene.to_str().expect("plain path"),
        "mesh.h5",
        "--set",
        "body.brick.cells=[6,2,2]",
    ];
    program.command(&mesh).assert().success();
    fs::write(program.path("notes.txt"), "my notes\n").expect("notes");
    let others = hdf5::File::create(program.path("others.hdf5")).expect("a file");
    others.create_group("fclib_local").expect("a group");
    others.close().expect("closed");
    for (file, out, word) in [
        (
            "mesh.h5",
            "out.hdf5",
            "expected a solved file, but its `assemble`",
        ),
        ("run.h5", "run.h5", "this command reads that file"),
        (
            "run.h5",
            "notes.txt",
            "expected a file of FCLIB of this program",
        ),
        (
            "run.h5",
            "others.hdf5",
            "expected a file of FCLIB of this program",
        ),
        (
            "run.h5",
            "mesh.h5",
            "found another HDF5 file of this program",
        ),
        ("run.h5", "no/such/out.hdf5", "make a file in its folder"),
    ] {
        let text = refused(&program, &["export", file, out, "--kind", "fclib"]);
        assert!(text.contains(word), "{file} {out}: {text}");
    }
}
