//! Stages alone and together, fresh and stale.

use std::fs;

use serde_json::Value;

use crate::program::{Program, SMALL, pipeline};

fn words(states: &[(String, String)]) -> Vec<&str> {
    states.iter().map(|(_, state)| state.as_str()).collect()
}

#[test]
fn run_makes_every_stage_and_then_keeps_them() {
    let program = Program::new();
    program.run(&[]).assert().success();
    assert_eq!(words(&program.states()), ["fresh"; 5]);
    let before = program.digests();
    let again = program.run(&[]).assert().success();
    let text = String::from_utf8_lossy(&again.get_output().stderr).into_owned();
    assert_eq!(text.matches("fresh, kept").count(), 5, "{text}");
    assert_eq!(program.digests(), before);
}

/// The reports of the two have other sizes.
#[test]
fn another_scene_takes_the_place_of_the_first() {
    let program = Program::new();
    program.run(&[]).assert().success();
    let wedge = pipeline("wedge.toml");
    let arguments = ["run", wedge.to_str().unwrap(), "run.h5", "--no-figures"];
    program.command(&arguments).assert().success();
    assert_eq!(words(&program.states()), ["fresh"; 5]);
    program.run(&[]).assert().success();
    assert_eq!(words(&program.states()), ["fresh"; 5]);
}

/// As after a kill among the pictures, which come after the last stage.
#[test]
fn run_draws_pictures_that_are_missing() {
    let program = Program::new();
    let scene = pipeline("hkl2011_table1.toml");
    let run = || {
        let mut run = program.command(&["run", scene.to_str().unwrap(), "run.h5"]);
        run.args(SMALL).assert().success();
    };
    run();
    let last = program.path("run-figures/overview.png");
    let drawn = fs::read(&last).unwrap();
    let unchanged = fs::metadata(&last).unwrap().modified().unwrap();
    run();
    assert_eq!(fs::metadata(&last).unwrap().modified().unwrap(), unchanged);
    fs::remove_file(&last).unwrap();
    run();
    assert_eq!(fs::read(&last).unwrap(), drawn);
}

/// Besides those that compute, one thread reads the command line, one waits for signals, and, unless one alone shall compute,
/// one writes the file.
#[cfg(target_os = "linux")]
#[test]
fn no_more_threads_compute_than_are_asked_for() {
    for threads in [1, 3] {
        let program = Program::new();
        let scene = pipeline("newton.toml");
        let mut run = std::process::Command::new(assert_cmd::cargo::cargo_bin("contact3d-pipe"))
            .args(["run", scene.to_str().unwrap(), "run.h5", "--no-figures"])
            .args(["--quiet", "--threads", &threads.to_string()])
            .current_dir(program.path(""))
            .spawn()
            .unwrap();
        let tasks = format!("/proc/{}/task", run.id());
        let mut most = 0;
        while run.try_wait().unwrap().is_none() {
            most = most.max(fs::read_dir(&tasks).map_or(0, Iterator::count));
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        // The first one, which waits for the work, the one that waits for signals, the one that syncs a file while it is read back, and
        // what starts the process.
        let others = if threads == 1 { 4 } else { 5 };
        assert!(
            (threads..=threads + others).contains(&most),
            "{most} threads"
        );
    }
}

#[test]
fn stages_in_processes_of_their_own_give_the_same_digests_as_run() {
    let whole = Program::new();
    whole.run(&[]).assert().success();
    let parts = Program::new();
    let scene = pipeline("hkl2011_table1.toml");
    let scene = scene.to_str().unwrap();
    parts
        .command(&["mesh", scene, "run.h5"])
        .args(SMALL)
        .assert()
        .success();
    assert_eq!(
        words(&parts.states()),
        ["fresh", "missing", "missing", "missing", "missing"]
    );
    parts
        .command(&["assemble", "run.h5", "--threads", "1"])
        .assert()
        .success();
    parts
        .command(&["solve", "run.h5", "--threads", "2"])
        .assert()
        .success();
    parts.command(&["post", "run.h5"]).assert().success();
    assert_eq!(parts.digests(), whole.digests());
    assert!(parts.path("run-figures/overview.png").exists());
    assert!(parts.path("run-figures/d_friction_ellipses.svg").exists());
}

#[test]
fn a_changed_law_makes_only_solve_and_post_stale() {
    let program = Program::new();
    program.run(&[]).assert().success();
    let changed = ["--set", "friction.coefficient_2={constant=0.25}"];
    let scene = pipeline("hkl2011_table1.toml");
    program
        .command(&["mesh", scene.to_str().unwrap(), "run.h5"])
        .args(SMALL)
        .args(changed)
        .assert()
        .success();
    assert_eq!(
        words(&program.states()),
        ["fresh", "fresh", "fresh", "stale", "stale"]
    );
    let refused = program.command(&["post", "run.h5"]).assert().code(2);
    let text = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(
        text.contains("`post` needs a fresh `solve`") && text.contains("has changed"),
        "{text}"
    );
    let again = program.run(&changed).assert().success();
    let text = String::from_utf8_lossy(&again.get_output().stderr).into_owned();
    assert_eq!(text.matches("fresh, kept").count(), 3, "{text}");
    assert_eq!(words(&program.states()), ["fresh"; 5]);
}

#[test]
fn a_new_mesh_makes_everything_after_it_stale() {
    let program = Program::new();
    program.run(&[]).assert().success();
    let scene = pipeline("hkl2011_table1.toml");
    let finer = ["--set", "body.brick.cells=[12,4,6]"];
    program
        .command(&["mesh", scene.to_str().unwrap(), "run.h5"])
        .args(finer)
        .assert()
        .success();
    assert_eq!(
        words(&program.states()),
        ["fresh", "stale", "stale", "stale", "stale"]
    );
    program.command(&["solve", "run.h5"]).assert().code(2);
    program.run(&finer).assert().success();
    assert_eq!(words(&program.states()), ["fresh"; 5]);
}

#[test]
fn settings_given_to_solve_are_stored_and_make_post_stale() {
    let program = Program::new();
    program.run(&[]).assert().success();
    program
        .command(&[
            "solve",
            "run.h5",
            "--set",
            "solve.epsilon=1e-6",
            "--set",
            "solve.precision=\"fixed\"",
        ])
        .assert()
        .success();
    assert_eq!(
        words(&program.states()),
        ["fresh", "fresh", "fresh", "fresh", "stale"]
    );
    program
        .command(&["post", "run.h5", "--no-figures"])
        .assert()
        .success();
    assert_eq!(words(&program.states()), ["fresh"; 5]);
    assert!(!program.path("run-figures").exists());
}

#[test]
fn non_convergence_is_stored_said_and_exit_code_1() {
    let program = Program::new();
    let failed = program
        .run(&["--set", "solve.max_outer_steps=2", "--json"])
        .assert()
        .code(1);
    let output = failed.get_output();
    let results: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(results["status"], "max_outer_steps");
    assert!(String::from_utf8_lossy(&output.stderr).contains("NOT CONVERGED"));
    let failed = program
        .run(&["--set", "solve.max_outer_steps=2"])
        .assert()
        .code(1);
    let text = String::from_utf8_lossy(&failed.get_output().stderr).into_owned();
    assert!(
        text.contains("fresh, kept"),
        "a stored failure is said again: {text}"
    );
    // Pictures and page say so before anything else.
    let scene = pipeline("hkl2011_table1.toml");
    let drawn = ["run", scene.to_str().unwrap(), "run.h5"];
    let few = ["--set", "solve.max_outer_steps=2"];
    let mut drawn = program.command(&[&drawn[..], &SMALL, &few].concat());
    drawn.assert().code(1);
    program
        .command(&["report", "run.h5", "-q"])
        .assert()
        .success();
    for file in [
        "run-figures/von_mises.svg",
        "run-figures/overview.svg",
        "report.html",
    ] {
        let shown = fs::read_to_string(program.path(file)).unwrap();
        assert!(
            shown.contains("NOT CONVERGED: out of outer steps"),
            "{file}"
        );
    }
    program
        .run(&["--set", "solve.max_operator_applications=5", "--quiet"])
        .assert()
        .code(1);
}

#[test]
fn json_results_are_complete_and_quiet_is_quiet() {
    let program = Program::new();
    let done = program.run(&["--json", "--quiet"]).assert().success();
    assert!(done.get_output().stderr.is_empty());
    let results: Value = serde_json::from_slice(&done.get_output().stdout).unwrap();
    assert_eq!(results["n_free"], 900);
    assert_eq!(results["n_multipliers"], 36);
    assert_eq!(results["stages"].as_array().unwrap().len(), 5);
    let panes = ["open", "slip", "stick"].map(|zone| results[zone].as_u64().unwrap());
    assert_eq!(panes.iter().sum::<u64>(), 12);
}

#[test]
fn help_shows_a_newcomer_how_to_start() {
    let program = Program::new();
    let help = program.command(&["--help"]).assert().success();
    let text = String::from_utf8_lossy(&help.get_output().stdout).into_owned();
    for word in [
        "contact3d-pipe init block.toml",
        "mesh",
        "assemble",
        "solve",
        "post",
        "status",
        "Exit codes",
    ] {
        assert!(text.contains(word), "{word}: {text}");
    }
}

/// Remedies name pages that the program itself brings.
#[test]
fn pages_of_the_reference_and_commands_have_help() {
    let program = Program::new();
    fs::write(program.path("bad.toml"), "titel = 1").unwrap();
    let refused = program.command(&["run", "bad.toml", "run.h5"]).assert();
    let said = String::from_utf8_lossy(&refused.code(2).get_output().stderr).into_owned();
    assert!(
        said.contains("`contact3d-pipe help scene` lists the keys"),
        "{said}"
    );
    for (topic, words) in [
        ("scene", "| `title` |"),
        ("statuses", "`no_equilibrium`"),
        ("run", "Usage: contact3d-pipe run"),
    ] {
        let help = program.command(&["help", topic]).assert().success();
        let text = String::from_utf8_lossy(&help.get_output().stdout).into_owned();
        assert!(text.contains(words), "{topic}: {text}");
    }
    program.command(&["help", "nothing"]).assert().code(2);
}

/// A file of another kind is called what it is.
#[test]
fn files_of_other_kinds_are_named() {
    let program = Program::new();
    program.run(&["-q"]).assert().success();
    fs::write(
        program.path("a.msh"),
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n",
    )
    .unwrap();
    fs::write(program.path("a.stl"), "solid a\nendsolid a\n").unwrap();
    fs::write(program.path("a.toml"), "title = \"a\"\n").unwrap();
    for (command, file, words) in [
        ("run", "run.h5", "expected a scene, found an HDF5 file"),
        ("run", "a.msh", "expected a scene, found a mesh of Gmsh"),
        ("run", "a.stl", "expected a scene, found an STL"),
        ("inspect", "a.stl", "expected a Gmsh file, found an STL"),
        ("inspect", "a.toml", "expected a Gmsh file, found a scene"),
        (
            "inspect",
            "run.h5",
            "expected a Gmsh file, found an HDF5 file",
        ),
    ] {
        let more: &[&str] = if command == "run" { &["other.h5"] } else { &[] };
        let refused = program.command(&[&[command, file], more].concat()).assert();
        let said = String::from_utf8_lossy(&refused.code(2).get_output().stderr).into_owned();
        assert!(said.contains(words), "{command} {file}: {said}");
    }
}

/// Runs the scene that leaves method and operator to the program.
fn run_newton(program: &Program, more: &[&str]) -> assert_cmd::assert::Assert {
    let scene = pipeline("newton.toml");
    let mut command = program.command(&["run", scene.to_str().unwrap(), "run.h5", "--no-figures"]);
    command.arg("-v").args(SMALL).args(more).assert()
}

#[test]
fn newton_stores_its_history_and_is_certified_by_the_papers_mapping() {
    let program = Program::new();
    let done = run_newton(&program, &["--json"]).success();
    let results: Value = serde_json::from_slice(&done.get_output().stdout).unwrap();
    assert!(results["newton_steps"].as_u64().unwrap() <= 16);
    assert_eq!(results["outer_steps"], 0);
    // Two evaluations of the same fixed point with a condition number of S near 1e3.
    assert!(results["mapping_change"].as_f64().unwrap() < 1e-11);
    let text = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
    assert!(text.contains("dual      explicit"), "{text}");
}

#[test]
fn methods_are_one_key_away_and_agree() {
    let program = Program::new();
    run_newton(&program, &[]).success();
    let force = |program: &Program, arguments: &[&str]| {
        let done = program.command(arguments).arg("--json").assert().success();
        let results: Value = serde_json::from_slice(&done.get_output().stdout).unwrap();
        results["normal_force"].as_f64().unwrap()
    };
    let newton = force(&program, &["solve", "run.h5"]);
    let inner_newton = [
        "solve",
        "run.h5",
        "--set",
        "solve.method=\"fixed-point\"",
        "--set",
        "solve.inner=\"newton\"",
        "--set",
        "solve.epsilon=1e-12",
    ];
    let paper = [
        "solve",
        "run.h5",
        "--set",
        "solve.inner=\"kprgp\"",
        "--set",
        "solve.epsilon=1e-6",
        "--set",
        "solve.precision=\"fixed\"",
    ];
    // ε = 1e-12 and a contraction factor near 0.1.
    assert!((force(&program, &inner_newton) / newton - 1.0).abs() < 1e-11);
    // ε = 1e-6, the same factor, and an inner tolerance of 1e-7 times the condition of S.
    assert!((force(&program, &paper) / newton - 1.0).abs() < 1e-4);
}

#[test]
fn newton_without_the_dense_operator_is_refused_with_the_way_out() {
    let program = Program::new();
    run_newton(&program, &[]).success();
    let assemble = |kind: &str| {
        let set = format!("assemble.dual_operator=\"{kind}\"");
        program
            .command(&["assemble", "run.h5", "--set", &set])
            .assert()
    };
    assemble("implicit").success();
    assert_eq!(
        words(&program.states()),
        ["fresh", "fresh", "fresh", "stale", "stale"]
    );
    let refused = program
        .command(&["solve", "run.h5", "--set", "solve.method=\"newton\""])
        .assert()
        .code(2);
    let text = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(
        text.contains("assemble.dual_operator=\"explicit\""),
        "{text}"
    );
    assemble("sparse").code(2);
}

#[test]
fn a_tolerance_below_rounding_is_said_and_not_accepted() {
    let program = Program::new();
    let limited = run_newton(&program, &["--set", "solve.epsilon=1e-17"]).code(1);
    let text = String::from_utf8_lossy(&limited.get_output().stderr).into_owned();
    assert!(text.contains("accurate to machine precision"), "{text}");
}
