//! `export` and `solve-fclib`: what is written, what is refused, and that inputs stay as they are.

use std::fs;

use fclib::{FclibSolution, LocalProblem, Matrix};
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

/// Two contacts whose matrix is diag(2, 4, 4) each, pressed, one of them sliding.
fn problem() -> LocalProblem {
    LocalProblem {
        space_dimension: 3,
        w: Matrix::from_entries(
            6,
            6,
            (0..6)
                .map(|k| (k, k, if k % 3 == 0 { 2.0 } else { 4.0 }))
                .collect(),
        ),
        q: vec![-2.0, 0.8, 0.6, -2.0, 30.0, 40.0],
        mu: vec![0.5; 2],
        info: fclib::Info::default(),
    }
}

const ZERO: [f64; 6] = [0.0; 6];

fn written(problem: &LocalProblem) -> Program {
    let program = Program::new();
    let file = program.path("given.hdf5");
    let file = hdf5_metno::File::create(file).expect("a file");
    fclib::write_local(&file, problem).expect("written");
    let solution = FclibSolution {
        v: None,
        u: ZERO.to_vec(),
        r: ZERO.to_vec(),
    };
    fclib::write_solution(&file, &solution).expect("written");
    program
}

#[test]
fn an_exported_solution_solves_the_exported_problem() {
    let program = solved(&[]);
    let before = fs::read(program.path("run.h5")).expect("run file");
    for (more, form) in [(None, "local"), (Some("--global"), "global")] {
        let mut arguments = vec!["export", "run.h5", "--fclib", "out.hdf5"];
        arguments.extend(more);
        // The second replaces the first, which is the program's own.
        let exported = json(&program, &arguments, 0);
        assert_eq!(exported["form"], form);
        assert_eq!(exported["contacts"], 3);
        if more.is_none() {
            assert!(exported["error"].as_f64().expect("measured") <= 1e-10);
            let solved = json(&program, &["solve-fclib", "out.hdf5"], 0);
            assert!(solved["error_before"].as_f64().expect("measured") <= 1e-10);
        }
    }
    assert!(fs::read(program.path("run.h5")).expect("run file") == before);
    let text = refused(&program, &["solve-fclib", "out.hdf5"]);
    assert!(
        text.contains("a global problem") && text.contains("W = H' M^-1 H"),
        "{text}"
    );
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
        let text = refused(&program, &["export", "run.h5", "--fclib", "out.hdf5"]);
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
        let text = refused(&program, &["export", "run.h5", "--fclib", "out.hdf5"]);
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
    let exported = json(&program, &["export", "run.h5", "--fclib", "out.hdf5"], 0);
    assert!(exported["error"].as_f64().expect("measured") <= 1e-10);
    let problem = fclib::read_local(&program.path("out.hdf5")).expect("readable");
    // Two columns of two panes with friction, which come first, three without; F is the reciprocal of a mean.
    let (with, without) = problem.mu.split_at(4);
    assert!(with.iter().all(|mu| (mu - 0.6).abs() < 1e-14), "{with:?}");
    assert_eq!(without, [0.0; 6]);
    assert!((0..30).all(|k| {
        problem
            .w
            .entries()
            .any(|(i, j, value)| i == k && j == k && value > 0.0)
    }));
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
    let others = hdf5_metno::File::create(program.path("others.hdf5")).expect("a file");
    fclib::write_local(&others, &problem()).expect("written");
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
        ("run.h5", "mesh.h5", "found an HDF5 file"),
        ("run.h5", "no/such/out.hdf5", "make a file in its folder"),
    ] {
        let text = refused(&program, &["export", file, "--fclib", out]);
        assert!(text.contains(word), "{file} {out}: {text}");
    }
}

#[test]
fn a_solution_goes_into_a_copy_and_only_on_request_into_the_file() {
    let program = written(&problem());
    let before = fs::read(program.path("given.hdf5")).expect("given");
    let expected = [1.0, -0.2, -0.15, 1.0, -0.3, -0.4];
    let check = |name: &str| {
        let solution = fclib::read_solution(&program.path(name), 6)
            .expect("readable")
            .expect("there");
        for (found, expected) in solution.r.iter().zip(expected) {
            // The tolerance 1e-10 times ‖q‖ = 50.
            assert!((found - expected).abs() <= 5e-9, "{:?}", solution.r);
        }
    };
    let answer = json(&program, &["solve-fclib", "given.hdf5"], 0);
    assert_eq!(
        (&answer["status"], &answer["contacts"]),
        (&"converged".into(), &2.into())
    );
    assert!(answer["error_before"].as_f64().expect("measured") > 0.01);
    for method in ["newton", "gpcg"] {
        json(
            &program,
            &[
                "solve-fclib",
                "given.hdf5",
                "-o",
                "out.hdf5",
                "--method",
                method,
            ],
            0,
        );
        check("out.hdf5");
    }
    assert!(fs::read(program.path("given.hdf5")).expect("given") == before);
    let text = refused(
        &program,
        &["solve-fclib", "given.hdf5", "--out", "given.hdf5"],
    );
    assert!(text.contains("this command reads that file"), "{text}");
    json(&program, &["solve-fclib", "given.hdf5", "--in-place"], 0);
    check("given.hdf5");
}

/// A link stays a link, permissions stay, and a protected file stays as it is.
#[cfg(unix)]
#[test]
fn a_file_solved_in_place_keeps_what_it_is() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let program = written(&problem());
    fs::create_dir(program.path("far")).expect("a folder");
    fs::rename(program.path("given.hdf5"), program.path("far/real.hdf5")).expect("moved");
    symlink("far/real.hdf5", program.path("given.hdf5")).expect("a link");
    let mode = |mode: u32| {
        let permissions = fs::Permissions::from_mode(mode);
        fs::set_permissions(program.path("far/real.hdf5"), permissions).expect("allowed");
    };
    mode(0o640);
    json(&program, &["solve-fclib", "given.hdf5", "--in-place"], 0);
    assert!(program.path("given.hdf5").is_symlink());
    let found = fs::metadata(program.path("far/real.hdf5")).expect("there");
    assert_eq!(found.permissions().mode() & 0o777, 0o640);
    let stored = fclib::read_solution(&program.path("far/real.hdf5"), 6).expect("readable");
    assert!(stored.expect("there").r[0] > 0.5);
    assert_eq!(
        program.everything().len(),
        3,
        "{:?}",
        program.everything().keys()
    );
    mode(0o440);
    let text = refused(&program, &["solve-fclib", "given.hdf5", "--in-place"]);
    assert!(text.contains("write-protected"), "{text}");
    // A copy of it is as writable as any new file.
    json(
        &program,
        &["solve-fclib", "given.hdf5", "--out", "out.hdf5"],
        0,
    );
}

/// A file whose /solution is a link to another file's numbers, and one without the bytes that it declares.
#[test]
fn data_of_other_files_are_neither_read_nor_stored() {
    let program = written(&problem());
    let other = hdf5::File::create(program.path("other.h5")).expect("made");
    let numbers = other
        .new_dataset::<f64>()
        .shape(6)
        .create("r")
        .expect("made");
    numbers.write_raw(&[1.0; 6]).expect("written");
    other.close().expect("closed");
    let raw = hdf5::File::open_rw(program.path("given.hdf5")).expect("open");
    raw.unlink("solution/r").expect("there");
    raw.link_external("other.h5", "r", "solution/r")
        .expect("linked");
    raw.close().expect("closed");
    let text = refused(
        &program,
        &["solve-fclib", "given.hdf5", "--out", "out.hdf5"],
    );
    assert!(
        text.contains("/solution/r: expected data in the file itself"),
        "{text}"
    );
}

/// W = 0 where bodies would have to be pushed apart: no forces do.
#[test]
fn what_has_no_solution_is_stored_and_is_not_converged() {
    let mut impossible = problem();
    impossible.w = Matrix::from_entries(6, 6, vec![(0, 0, 1.0)]);
    let program = written(&impossible);
    let answer = json(
        &program,
        &["solve-fclib", "given.hdf5", "-o", "out.hdf5"],
        1,
    );
    assert_eq!(answer["status"], "no_solution");
    assert_eq!(answer["obstruction"]["kind"], "penetration");
    assert_eq!(
        answer["obstruction"]["direction"],
        serde_json::json!([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    );
    let stored = hdf5::File::open(program.path("out.hdf5")).expect("open");
    let direction = stored
        .dataset("solution/obstruction")
        .and_then(|dataset| dataset.read_raw::<f64>())
        .expect("numbers");
    assert_eq!(direction, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    stored.close().expect("closed");
    assert!(
        fclib::read_solution(&program.path("out.hdf5"), 6)
            .expect("readable")
            .is_some()
    );
}

#[test]
fn what_is_no_problem_in_3d_is_refused() {
    let refuses = |problem: LocalProblem, word: &str| {
        let program = written(&problem);
        let text = refused(&program, &["solve-fclib", "given.hdf5"]);
        assert!(text.contains(word) && text.contains("given.hdf5"), "{text}");
    };
    refuses(
        LocalProblem {
            space_dimension: 2,
            mu: vec![0.5; 3],
            ..problem()
        },
        "only problems in 3D",
    );
    refuses(
        LocalProblem {
            mu: vec![0.5, -0.5],
            ..problem()
        },
        "found -0.5 at contact 1",
    );
    let mut skew = problem();
    skew.w = Matrix::from_entries(6, 6, vec![(0, 1, 1.0)]);
    refuses(skew, "a symmetric matrix");
    let program = Program::new();
    let text = refused(&program, &["solve-fclib", "gone.hdf5"]);
    assert!(text.contains("gone.hdf5"), "{text}");
}
