//! Bad input: exit code 2, a message that says what to do, nothing on disk changed.

use std::fs;

use crate::program::{Program, pipeline};

/// (what is replaced in table 1's scene, by what, what the message must contain).
const BAD_SCENES: [(&str, &str, &[&str]); 30] = [
    ("title =", "titel =", &["unknown field", "titel"]),
    (
        "size = [3.0",
        "size = [-3.0",
        &["body.brick.size", "positive"],
    ),
    (
        "size = [3.0, 1.0, 1.0]",
        "size = [nan, 1.0, 1.0]",
        &["body.brick.size", "NaN"],
    ),
    (
        "cells = [48, 16, 16]",
        "cells = [48, 15, 16]",
        &["body.brick.cells", "even"],
    ),
    ("cells = [48, 16, 16]", "cells = [48, 16]", &["length", "3"]),
    (
        "cells = [48, 16, 16]",
        "cells = [0, 16, 16]",
        &["body.brick.cells"],
    ),
    (
        "cells = [48, 16, 16]",
        "cells = [48, 16, -2]",
        &["invalid value", "-2"],
    ),
    (
        "young_modulus = 21.19e10",
        "young_modulus = 0.0",
        &["young_modulus", "positive"],
    ),
    (
        "young_modulus = 21.19e10",
        "young_modulus = \"steel\"",
        &["invalid type", "steel"],
    ),
    (
        "poisson_ratio = 0.277",
        "poisson_ratio = 0.5",
        &["poisson_ratio", "incompressible"],
    ),
    (
        "poisson_ratio = 0.277",
        "",
        &["missing field", "poisson_ratio"],
    ),
    (
        "face = \"x_min\"",
        "face = \"z_min\"",
        &["clamp.0.face", "contact face"],
    ),
    (
        "face = \"x_min\"",
        "face = \"left\"",
        &["clamp.0.face", "left", "x_min"],
    ),
    ("[[clamp]]\nface = \"x_min\"", "", &["clamp", "rigid"]),
    (
        "face = \"x_min\"",
        "components = [\"x\"]",
        &["clamp.0", "either face or box", "neither"],
    ),
    (
        "face = \"x_min\"",
        "face = \"x_min\"\nbox = [[0, 0, 0], [0, 1, 1]]",
        &["clamp.0", "either face or box", "both"],
    ),
    (
        "face = \"x_min\"",
        "box = [[0, 1, 0], [0, 0, 1]]",
        &["clamp.0.box", "min at most max"],
    ),
    (
        "face = \"x_min\"",
        "box = [[0.01, 0.01, 0.01], [0.02, 0.02, 0.02]]",
        &["clamp.0.box", "at least one node"],
    ),
    (
        "[friction.coefficient_2.ramp]\ninitial = 0.3\nresidual = 0.2\nonset = 1e-5             # m\nrate = 1000.0            # 1/m",
        "[friction]\ncoefficient_2.expression = \"0.3 - 0.2*x\"",
        &[
            "friction.coefficient_2.expression",
            "0 < F",
            "x, y, z = 3, 0, 0",
        ],
    ),
    (
        "face = \"z_min\"",
        "face = \"z_min\"\ngap = \"2*-x\"",
        &["parentheses"],
    ),
    (
        "face = \"x_min\"",
        "face = \"x_min\"\ncomponents = [\"x\"]",
        &["no rigid motion free", "translation along y"],
    ),
    ("face = \"x_max\"", "face = \"z_min\"", &["traction.0.face"]),
    (
        "value = [1e7, 0.0, 2e7]",
        "value = [inf, 0.0, 2e7]",
        &["traction.0.value", "finite"],
    ),
    (
        "face = \"z_min\"",
        "face = \"z_min\"\ngap = -1.0",
        &["contact.gap"],
    ),
    (
        "face = \"z_min\"",
        "face = \"z_min\"\naxis_1 = [0.0, 0.0, 1.0]",
        &["contact.axis_1", "plane"],
    ),
    (
        "initial = 0.3",
        "initial = -0.3",
        &["friction.coefficient_1.ramp", "initial > 0"],
    ),
    (
        "rate = 3000.0",
        "rate = 0.0",
        &["friction.coefficient_1.ramp", "rate"],
    ),
    (
        "epsilon = 1e-4",
        "epsilon = 2.0",
        &["solve.epsilon", "0 < epsilon < 1"],
    ),
    (
        "precision = \"adaptive\"",
        "precision = \"loose\"",
        &["unknown variant", "loose", "adaptive"],
    ),
    ("[solve]", "[solve", &["hkl", "│"]),
];

#[test]
fn bad_scenes_are_refused_with_the_place_and_the_reason() {
    let good = fs::read_to_string(pipeline("hkl2011_table1.toml")).unwrap();
    for (from, to, fragments) in BAD_SCENES {
        let program = Program::new();
        assert!(good.contains(from), "{from}");
        fs::write(program.path("hkl.toml"), good.replacen(from, to, 1)).unwrap();
        let refused = program
            .command(&["run", "hkl.toml", "run.h5"])
            .assert()
            .code(2);
        let text = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        // Long messages are wrapped and indented.
        let folded: Vec<&str> = text.split_whitespace().collect();
        let folded = folded.join(" ");
        for fragment in fragments {
            assert!(
                folded.contains(fragment),
                "{from} -> {to}: no {fragment:?} in\n{text}"
            );
        }
        assert!(folded.contains("hkl.toml"), "the file is named:\n{text}");
        assert!(!program.path("run.h5").exists(), "{from} -> {to}");
    }
}

#[test]
fn overrides_are_checked_like_the_scene() {
    let program = Program::new();
    for (change, fragment) in [
        ("solve.epsilon", "KEY=VALUE"),
        ("solve.epsilon=abc def", "KEY=VALUE"),
        ("solve.epsilon=7.0", "0 < epsilon < 1"),
        ("solve.tolerance=1e-3", "unknown field"),
        ("title.x=1", "below tables"),
    ] {
        let refused = program.run(&["--set", change]).assert().code(2);
        let text = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        assert!(text.contains(fragment), "{change}: {text}");
    }
    assert!(!program.path("run.h5").exists());
}

#[test]
fn bad_files_are_refused_and_left_alone() {
    let program = Program::new();
    fs::write(program.path("notes.txt"), "not HDF5").unwrap();
    fs::create_dir(program.path("folder")).unwrap();
    let scene = pipeline("hkl2011_table1.toml");
    let scene = scene.to_str().unwrap();
    for (arguments, fragment) in [
        (vec!["run", scene, "notes.txt"], "not an HDF5 file"),
        (vec!["status", "notes.txt"], "not an HDF5 file"),
        (vec!["run", scene, "folder"], "is a directory"),
        (vec!["run", scene, "nowhere/run.h5"], "does not exist"),
        (vec!["run", "nowhere.toml", "run.h5"], "nowhere.toml"),
        (vec!["assemble", "missing.h5"], "no such file"),
        (vec!["solve", "missing.h5"], "no such file"),
        (vec!["post", "missing.h5"], "no such file"),
        (vec!["status", "missing.h5"], "no such file"),
        (vec!["sol"], "unrecognized subcommand"),
        (vec!["solve", "run.h5", "--threads", "0"], "--threads"),
    ] {
        let refused = program.command(&arguments).assert().code(2);
        let text = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        assert!(text.contains(fragment), "{arguments:?}: {text}");
    }
    assert_eq!(
        fs::read_to_string(program.path("notes.txt")).unwrap(),
        "not HDF5"
    );
}

#[test]
fn missing_stages_and_bad_settings_are_refused() {
    let program = Program::new();
    let scene = pipeline("hkl2011_table1.toml");
    program
        .command(&["mesh", scene.to_str().unwrap(), "run.h5"])
        .args(crate::program::SMALL)
        .assert()
        .success();
    let before = fs::read(program.path("run.h5")).unwrap();
    for (arguments, fragment) in [
        (
            vec!["solve", "run.h5"],
            "`solve` needs a fresh `assemble`, but it is missing",
        ),
        (vec!["post", "run.h5"], "`post` needs a fresh `assemble`"),
        (vec!["solve", "run.h5", "--epsilon", "0"], "solve.epsilon"),
        (vec!["solve", "run.h5", "--gamma", "-1"], "solve.gamma"),
    ] {
        let refused = program.command(&arguments).assert().code(2);
        let text = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        assert!(text.contains(fragment), "{arguments:?}: {text}");
    }
    assert_eq!(fs::read(program.path("run.h5")).unwrap(), before);
}

#[test]
fn a_second_process_is_told_that_the_file_is_busy() {
    let program = Program::new();
    program.run(&[]).assert().success();
    let lock = fs::File::open(program.path(".run.h5.lock")).unwrap();
    lock.try_lock().unwrap();
    let refused = program.command(&["solve", "run.h5"]).assert().code(2);
    let text = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(text.contains("busy"), "{text}");
    assert_eq!(
        program.states().len(),
        5,
        "reading goes on while another process writes"
    );
}

#[test]
fn stale_schemas_are_found() {
    let program = Program::new();
    program
        .command(&["schema", "--out", "schemas"])
        .assert()
        .success();
    program
        .command(&["schema", "--out", "schemas", "--check"])
        .assert()
        .success();
    let page = program.path("schemas/run_file.md");
    fs::write(&page, fs::read_to_string(&page).unwrap() + "x").unwrap();
    program
        .command(&["schema", "--out", "schemas", "--check"])
        .assert()
        .code(2);
}

#[test]
fn errors_reach_programs_as_json() {
    let program = Program::new();
    let refused = program
        .command(&["status", "missing.h5", "--json"])
        .assert()
        .code(2);
    let error: serde_json::Value = serde_json::from_slice(&refused.get_output().stdout).unwrap();
    assert_eq!(error["exit_code"], 2);
    assert!(error["error"].as_str().unwrap().contains("missing.h5"));
}
