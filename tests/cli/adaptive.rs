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
fn a_target_is_met_and_a_second_run_keeps_everything() {
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
    let page = ["report", "run.h5", "page.html"];
    program.command(&page).assert().success();
    let page = std::fs::read_to_string(program.path("page.html")).expect("a page");
    assert!(page.contains("levels for an error of 10 %"));
    assert_eq!(page.matches(">Levels of the adaptive mesh<").count(), 4);
    assert!(page.contains("time until the level") && page.contains(">asked for<"));
    // A stage by hand works on the adaptive mesh.
    program.command(&["solve", "run.h5"]).assert().success();
    program
        .command(&["post", "run.h5", "--no-figures"])
        .assert()
        .success();
    assert!(program.states().iter().all(|(_, state)| state == "fresh"));
}

/// A block on rollers under a pressure that varies as a cosine: its largest von Mises stress is at a face of symmetry, 111.2 MPa on
/// 24 × 2 × 24 cells, and its bar is first that of the pressure below.
#[test]
fn the_largest_stress_may_be_the_target() {
    let program = Program::new();
    let block = r#"
body = { element = "P2", brick = { size = [1.0, 0.25, 1.0], cells = [4, 1, 4] } }
material.isotropic = { young_modulus = 2e11, poisson_ratio = 0.3 }
clamp = [
  { face = "x_min", components = ["x"] }, { face = "x_max", components = ["x"] },
  { face = "y_min", components = ["y"] }, { face = "y_max", components = ["y"] },
]
contact.face = "z_min"
pressure = [{ face = "z_max", value = "1e8*(1+0.8*cos(3.14159265358979*x))" }]
"#;
    std::fs::write(program.path("block.toml"), block).expect("a scene");
    let target = ["--error", "5%", "--quantity", "largest_von_mises", "--json"];
    let mut command = program.command(&["run", "block.toml", "run.h5", "--no-figures"]);
    let done = command.args(target).assert().success();
    assert_eq!(levels(&done)["status"], "met");
    let json: Value = serde_json::from_slice(&done.get_output().stdout).expect("JSON");
    let stress = |name: &str| json["largest_von_mises"][name].as_f64().expect("a number");
    assert!(stress("error") <= 0.05 * stress("value"));
    assert!(
        (stress("value") - 111.2e6).abs() <= stress("error"),
        "{json}"
    );
}

/// The mesh is refined for a quantity, and what the file says of it is read again.
#[test]
fn a_quantity_may_be_the_target() {
    let program = Program::new();
    let error_of_force = |assert: &assert_cmd::assert::Assert| -> f64 {
        let json: Value = serde_json::from_slice(&assert.get_output().stdout).expect("JSON");
        assert_eq!(json["adaptation"]["of"], "normal_force");
        assert_eq!(json["adaptation"]["status"], "met");
        let found = json["quantities"].as_array().expect("quantities").clone();
        let force = found.iter().find(|it| it["name"] == "normal_force");
        let force = force.expect("the force");
        assert_eq!(force["value"], json["normal_force"]);
        (force["error_bar"].as_f64().expect("an error") / force["value"].as_f64().expect("a force"))
            .abs()
    };
    let first = run(&program, "0.2%", &["--quantity", "normal_force", "--json"]).success();
    let error = error_of_force(&first);
    assert!(error <= 0.002, "{error}");
    let before = program.everything();
    let again = run(&program, "0.2%", &["--quantity", "normal_force", "--json"]).success();
    assert_eq!(error_of_force(&again), error);
    assert_eq!(program.everything(), before, "nothing is written again");
    program.command(&["check", "run.h5"]).assert().success();
}

/// What no answer of the scene has is refused with the reason, before anything is written.
#[test]
fn quantities_that_are_not_there_are_refused() {
    let program = Program::new();
    let before = program.everything();
    let refused = |scene: &str, of: &str, why: &[&str]| {
        let scene = pipeline(scene);
        let scene = scene.to_str().expect("plain path");
        let arguments = [
            "run",
            scene,
            "run.h5",
            "--no-figures",
            "--error",
            "5%",
            "--quantity",
            of,
        ];
        let said = said(&program.command(&arguments).assert().code(2));
        assert!(why.iter().all(|why| said.contains(why)), "{said}");
    };
    refused(
        "frictionless.toml",
        "tangential_force",
        &["adapt.of", "without friction"],
    );
    refused(
        "frictionless.toml",
        "stick_area",
        &["adapt.of", "without friction"],
    );
    refused(
        "elastic_only.toml",
        "normal_force",
        &["adapt.of", "without contact"],
    );
    refused(
        "frictionless.toml",
        "dissipation",
        &["adapt.of", "load history"],
    );
    refused(
        "frictionless.toml",
        "force",
        &["normal_force", "strain_energy"],
    );
    let flat = "{ mean_displacement = { box = [[0, 0, 0], [1, 1, 0]], component = \"z\" } }";
    refused("frictionless.toml", flat, &["adapt.of", "volume"]);
    refused("gmsh_foot.toml", "normal_force", &["adapt.of", "quadratic"]);
    refused(
        "frictionless.toml",
        "mean_pressure",
        &["adapt.of", "box = [["],
    );
    assert_eq!(program.everything(), before);
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
fn a_tighter_target_draws_its_own_pictures() {
    let program = Program::new();
    let scene = pipeline("adaptive.toml");
    let scene = scene.to_str().expect("plain path");
    let drawn = ["10%", "5%"].map(|target| {
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
        run(&program, "3.5%", &[]).success();
        program.digests()
    };
    let program = Program::new();
    for round in 0..6_u64 {
        let mut child = Command::cargo_bin("contact3d-pipe")
            .expect("built program")
            .current_dir(program.path(""))
            .arg("run")
            .arg(pipeline("adaptive.toml"))
            .args(["run.h5", "--no-figures", "--quiet", "--error", "3.5%"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("started");
        sleep(Duration::from_millis(60 + 40 * round));
        let _ = child.kill();
        child.wait().expect("ended");
        let status = program.command(&["status", "run.h5"]).output();
        let text = String::from_utf8_lossy(&status.expect("a status").stdout).into_owned();
        let has_levels = text.contains("levels for an error of 3.5 %");
        let is_told = text.contains("the same `run` goes on from there");
        assert!(
            is_told || !has_levels || !text.contains("missing"),
            "{text}"
        );
    }
    run(&program, "3.5%", &[]).success();
    assert_eq!(program.digests(), expected);
    let status = program.command(&["status", "run.h5"]).assert().success();
    let text = String::from_utf8_lossy(&status.get_output().stdout).into_owned();
    assert!(text.contains("levels for an error of 3.5 %"), "{text}");
    // Levels of another material are none of this scene.
    let scene = pipeline("adaptive.toml");
    let scene = scene.to_str().expect("plain path");
    let softer = "material.isotropic.young_modulus=1e11";
    let mut mesh = program.command(&["mesh", scene, "run.h5", "--set", softer]);
    mesh.assert().success();
    let status = program.command(&["status", "run.h5"]).assert().success();
    let text = String::from_utf8_lossy(&status.get_output().stdout).into_owned();
    assert!(!text.contains("levels for an error"), "{text}");
}

const STEPS: &str =
    "step=[{factor={pull=0.0}},{factor={pull=1.0},increments=3},{factor={pull=-1.0},increments=3}]";

/// A small history on few meshes.
fn history(program: &Program, more: &[&str]) -> assert_cmd::assert::Assert {
    let scene = pipeline("history.toml");
    let scene = scene.to_str().expect("plain path");
    let mut command = program.command(&["run", scene, "run.h5", "--no-figures", "--set", STEPS]);
    command.args(more).assert()
}

/// One mesh serves all increments; every command goes on from the file.
#[test]
fn histories_are_refined() {
    let program = Program::new();
    let wanted = ["--error", "8%"];
    let first = history(&program, &["--error", "8%", "--json"]).success();
    let json: Value = serde_json::from_slice(&first.get_output().stdout).expect("JSON");
    let list = json["adaptation"]["levels"].as_array().expect("levels");
    assert_eq!(json["adaptation"]["status"], "met");
    assert!(list.len() >= 2, "{list:?}");
    let rows = json["history"].as_array().expect("rows");
    let errors = rows.iter().map(|row| row["estimated_error"].as_f64());
    let largest = errors.fold(0.0, |most: f64, error| most.max(error.expect("an error")));
    let last = list.last().expect("levels");
    assert_eq!(Some(largest), last["estimated_error"].as_f64());
    assert!(
        rows.iter()
            .all(|row| row["quantities"].as_array().is_some_and(|q| q.len() >= 4))
    );
    let before = program.everything();
    history(&program, &wanted).success();
    assert_eq!(program.everything(), before, "nothing is written again");
    program.command(&["check", "run.h5"]).assert().success();
    for stage in [
        &["solve", "run.h5"][..],
        &["post", "run.h5", "--no-figures"],
    ] {
        program.command(stage).assert().success();
    }
    assert!(program.states().iter().all(|(_, state)| state == "fresh"));
    program
        .command(&["report", "run.h5", "page.html"])
        .assert()
        .success();
    let page = std::fs::read_to_string(program.path("page.html")).expect("a page");
    assert!(page.contains("levels for an error of 8.0 %") && page.contains("error about"));
    // A tighter target goes on from these levels, by the indicators that the file holds.
    let on = levels(&history(&program, &["--error", "6.5%", "--json"]).success());
    let on = on["levels"].as_array().expect("levels");
    assert!(on.len() > list.len() && on[..list.len()] == list[..]);
    // Without a target nothing of it stays.
    history(&program, &["--set", "body.brick.cells=[6,2,2]"]).success();
    let reader = runfile::Reader::open(&program.path("run.h5"), contact3d_pipe::LAYOUT);
    let reader = reader.expect("a run file");
    assert!(!reader.has("/history/estimated_error") && !reader.has("/adapt/status"));
}

/// A history that ends early meets no target, however loose.
#[test]
fn a_history_that_fails_meets_no_target() {
    let program = Program::new();
    let limits = ["solve.max_outer_steps=1", "solve.epsilon=1e-17"];
    for limit in limits {
        let settings = ["--set", "solve.method=\"fixed-point\"", "--set", limit];
        let failed = history(
            &program,
            &[&settings[..], &["--error", "100%", "--json"]].concat(),
        );
        let failed = failed.code(1);
        assert_eq!(levels(&failed)["status"], "not_converged");
        assert!(levels(&failed)["levels"][0]["estimated_error"].is_null());
        assert!(
            said(&failed).contains("ends the history"),
            "{}",
            said(&failed)
        );
    }
}

#[test]
fn a_killed_adaptive_history_has_the_same_datasets() {
    let wanted = ["--error", "5%", "--quiet"];
    let expected = {
        let program = Program::new();
        history(&program, &[&wanted[..], &["--threads", "1"]].concat()).success();
        program.digests()
    };
    let program = Program::new();
    for round in 0..5_u64 {
        let mut child = Command::cargo_bin("contact3d-pipe")
            .expect("built program")
            .current_dir(program.path(""))
            .arg("run")
            .arg(pipeline("history.toml"))
            .args(["run.h5", "--no-figures", "--set", STEPS])
            .args(wanted)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("started");
        sleep(Duration::from_millis(100 + 150 * round));
        let _ = child.kill();
        child.wait().expect("ended");
    }
    history(&program, &[&wanted[..], &["--threads", "2"]].concat()).success();
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
fn impossible_targets_are_refused() {
    let program = Program::new();
    for (target, words) in [
        ("200%", "from 0.00000001 to 1"),
        ("0", "from 0.00000001 to 1"),
        ("-1%", "from 0.00000001 to 1"),
        ("1e-9", "from 0.00000001 to 1"),
        ("3", "--error 3%"),
        ("nan", "write 3% or 0.03"),
        ("little", "write 3% or 0.03"),
    ] {
        let scene = pipeline("adaptive.toml");
        let scene = scene.to_str().expect("plain path");
        let refused = program
            .command(&["run", scene, "run.h5", "--error", target])
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

/// `--error` takes quadratic tetrahedra on few cells, unless an element is named, and says so.
#[test]
fn the_mesh_is_chosen_and_the_budget_kept() {
    let program = Program::new();
    let scene = pipeline("newton.toml");
    let command = |file: &str, more: &[&str]| {
        let scene = scene.to_str().expect("plain path");
        let mut command = program.command(&["run", scene, file, "--no-figures"]);
        command.args(more).assert()
    };
    let chosen = command("run.h5", &["--error", "20%"]).success();
    let words = said(&chosen);
    assert!(
        words.contains("quadratic tetrahedra, from 6 x 2 x 2 cells"),
        "{words}"
    );
    let linear = [
        "--set",
        "body.element=\"P1\"",
        "--error",
        "50%",
        "--set",
        "body.brick.cells=[12, 4, 4]",
    ];
    let named = said(&command("linear.h5", &linear).success());
    assert!(
        named.contains("linear tetrahedra, from 12 x 4 x 4 cells"),
        "{named}"
    );
    let spent = command("short.h5", &["--error", "5%", "--budget", "1e-3", "--json"]).code(1);
    assert_eq!(levels(&spent)["status"], "over_budget");
    assert_eq!(
        levels(&spent)["levels"].as_array().expect("levels").len(),
        1
    );
    assert!(
        said(&spent).contains("more than is left of --budget"),
        "{}",
        said(&spent)
    );
    // With time, the same command goes on from the level that is stored.
    let on = levels(&command("short.h5", &["--error", "12%", "--json"]).success());
    assert_eq!(on["levels"][0], levels(&spent)["levels"][0]);
    for (more, expected) in [
        (["--budget", "5"], "asks for an error"),
        (["--budget", "-1"], "expected seconds"),
    ] {
        let refused = said(&command("none.h5", &more).code(2));
        assert!(refused.contains(expected), "{refused}");
    }
    assert!(!program.path("none.h5").exists());
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
        .command(&["sweep", "sweep.toml", "cases"])
        .assert()
        .success();
    let before = program.everything();
    program
        .command(&["sweep", "sweep.toml", "cases"])
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
