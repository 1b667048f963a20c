//! Load histories as a user meets them.

use std::{
    fs,
    process::{Command, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

use contact3d_pipe::{HISTORY, LAYOUT};
use runfile::Reader;
use serde_json::Value;

use crate::program::{Program, pipeline};

const SMALL: [&str; 2] = ["--set", "body.brick.cells=[6,2,2]"];

fn run(program: &Program, more: &[&str]) -> assert_cmd::Command {
    let scene = pipeline("history.toml");
    let scene = scene.to_str().expect("plain path");
    let mut command = program.command(&["run", scene, "run.h5"]);
    command.args(SMALL).args(more);
    command
}

#[test]
fn a_history_is_stored_drawn_printed_and_reported() {
    let program = Program::new();
    let done = run(&program, &[]).assert().success();
    let text = String::from_utf8_lossy(&done.get_output().stdout).into_owned();
    assert!(
        text.contains("load history: 25 of 25 increments in 5 steps"),
        "{text}"
    );
    for words in [
        "push again 6",
        "largest pressure       ",
        " at time 4 s, pull again 6\n",
        "energy of a cycle      work of loads ",
        " from pull again to push again\n",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    for name in ["friction_loop", "force_displacement", "energies"] {
        for kind in ["svg", "png"] {
            assert!(program.path(&format!("run-figures/{name}.{kind}")).exists());
        }
    }
    assert!(program.states().iter().all(|(_, state)| state == "fresh"));
    program.command(&["check", "run.h5"]).assert().success();
    program.command(&["report", "run.h5"]).assert().success();
    let page = fs::read_to_string(program.path("report.html")).expect("a page");
    assert!(page.contains("id=\"load-history\"") && page.contains("pull again"));
    assert!(!page.contains("<script"));
    let interactive = ["report", "run.h5", "--interactive"];
    program.command(&interactive).assert().success();
    let page = fs::read_to_string(program.path("report.html")).expect("a page");
    assert!(page.contains("id=\"view3d-arrays\"") && page.contains("default-src 'none'"));
    assert!(page.contains("<details class=\"picture\" open><summary>"));
    let again = run(&program, &["--json", "--quiet"]).assert().success();
    let json: Value = serde_json::from_slice(&again.get_output().stdout).expect("JSON");
    let rows = json["history"].as_array().expect("rows");
    assert_eq!(rows.len(), 25);
    let dissipated: f64 = rows
        .iter()
        .filter_map(|row| row["dissipation"].as_f64())
        .sum();
    assert!(dissipated > 0.0);
    // Read back from the file, every stage is what it was.
    assert!(json["stages"].as_array().expect("stages").is_empty());
    program
        .command(&["post", "run.h5", "--no-figures"])
        .assert()
        .success();
    assert!(program.states().iter().all(|(_, state)| state == "fresh"));
}

#[test]
fn one_step_stores_what_a_scene_without_steps_stores() {
    let program = Program::new();
    let digests = |more: &[&str]| {
        program.run(more).assert().success();
        let reader = Reader::open(&program.path("run.h5"), LAYOUT).expect("a run file");
        let numbers = [
            "/solve/multiplier_normal",
            "/solve/multiplier_tangential",
            "/solve/displacement",
        ];
        numbers.map(|path| reader.read_vec::<f64>(path).expect("numbers"))
    };
    let plain = digests(&[]);
    let stepped = digests(&["--set", "step=[{title=\"all\"}]"]);
    assert_eq!(plain, stepped);
    // And back: nothing of the history stays.
    assert_eq!(digests(&[]), plain);
    let reader = Reader::open(&program.path("run.h5"), LAYOUT).expect("a run file");
    assert!(reader.group_record(HISTORY).expect("readable").is_none());
}

/// Loads of earlier steps count, though `/load` has only the last.
#[test]
fn a_change_of_any_step_makes_the_solve_stale() {
    let program = Program::new();
    let steps = "step=[{factor={pull=1.0}},{factor={pull=0.0}}]";
    let run = |more: &[&str]| {
        run(&program, &["--no-figures", "--set", steps])
            .args(more)
            .assert()
            .success()
    };
    run(&[]);
    let before = program.digests();
    run(&["--set", "traction.0.value=[2e7,0.0,0.0]"]);
    let after = program.digests();
    // The same mesh, operators and last loads, another solution.
    assert_eq!(before[..3], after[..3]);
    assert!(before[3] != after[3] && before[4] != after[4]);
}

/// All numbers of a file's history.
fn history(program: &Program, file: &str) -> Vec<Vec<u64>> {
    let reader = Reader::open(&program.path(file), LAYOUT).expect("a run file");
    let rows = LAYOUT.of_group(HISTORY);
    let numbers = rows.filter(|row| row.kind == runfile::Kind::F64 && reader.has(row.path));
    numbers
        .map(|row| {
            let values: Vec<f64> = reader.read_vec(row.path).expect("numbers");
            values.into_iter().map(f64::to_bits).collect()
        })
        .collect()
}

/// Increments are stored no earlier than after a second; these take two to four.
#[test]
fn a_killed_history_goes_on_with_the_same_bits() {
    let program = Program::new();
    let scene = pipeline("history.toml");
    let arguments = |file: &'static str| {
        let scene = scene.to_str().expect("plain path").to_owned();
        let steps = "step=[{factor={pull=0.0}},{factor={pull=1.0},increments=500},{factor={pull=-1.0},increments=1000}]";
        let words = [
            "run",
            &scene,
            file,
            "--no-figures",
            "--set",
            "body.brick.cells=[12,4,4]",
            "--set",
            steps,
        ];
        words.map(str::to_owned)
    };
    let command = |file| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_contact3d-pipe"));
        command.current_dir(program.path("")).args(arguments(file));
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        command
    };
    assert!(command("whole.h5").status().expect("runs").success());
    let mut interrupted = 0;
    let deadline = Instant::now() + Duration::from_secs(120);
    loop {
        assert!(Instant::now() < deadline);
        let mut child = command("killed.h5").spawn().expect("runs");
        let done = || {
            let reader = Reader::open(&program.path("killed.h5"), LAYOUT).ok()?;
            let time: Vec<f64> = reader.read_vec("/history/time").ok()?;
            Some(time.len())
        };
        let before = done();
        let ended = loop {
            if child.try_wait().expect("a child").is_some() {
                break true;
            }
            // As soon as more increments are stored.
            if done() > before {
                break false;
            }
            sleep(Duration::from_millis(5));
        };
        if ended {
            break;
        }
        child.kill().expect("a child");
        let said = child.wait_with_output().expect("a child").stderr;
        if let Some(before) = before {
            let said = String::from_utf8_lossy(&said).into_owned();
            let resumed = format!("goes on after increment {before} of 1501 (step ");
            assert!(said.contains(&resumed), "{said}");
        }
        let part = done().unwrap_or(0);
        if (1..1501).contains(&part) {
            interrupted += 1;
            let status = program.command(&["status", "killed.h5"]).assert().success();
            let text = String::from_utf8_lossy(&status.get_output().stdout).into_owned();
            let kept = format!("{part} of 1501 increments are kept, the last step ");
            assert!(text.contains(&kept), "{text}");
            let idle = "no command is at work on this file: the same `run` goes on from there";
            assert!(text.contains(idle), "{text}");
        }
    }
    assert!(interrupted >= 1, "no kill left a part of the history");
    assert_eq!(
        history(&program, "killed.h5"),
        history(&program, "whole.h5")
    );
}

/// Increments that a killed run left are not those of another material, whose mesh and loads are the same.
#[test]
fn a_killed_history_is_not_gone_on_from_for_another_material() {
    let program = Program::new();
    let scene = pipeline("history.toml");
    let steps = "step=[{factor={pull=0.0}},{factor={pull=1.0},increments=1000}]";
    let run = |file: &str, more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_contact3d-pipe"));
        let quiet = [
            "--no-figures",
            "--quiet",
            "--set",
            "body.brick.cells=[12,4,4]",
        ];
        command
            .current_dir(program.path(""))
            .arg("run")
            .arg(&scene)
            .arg(file);
        command.args(quiet).args(["--set", steps]).args(more);
        command
    };
    let mut child = run("killed.h5", &[]).spawn().expect("runs");
    let has_increments = || {
        let reader = Reader::open(&program.path("killed.h5"), LAYOUT).ok()?;
        reader.read_vec::<f64>("/history/time").ok()
    };
    while child.try_wait().expect("a child").is_none() && has_increments().is_none() {
        sleep(Duration::from_millis(5));
    }
    let _ = child.kill();
    child.wait().expect("a child");
    let softer = ["--set", "material.isotropic.young_modulus=1e10"];
    for file in ["killed.h5", "whole.h5"] {
        assert!(run(file, &softer).status().expect("runs").success());
    }
    assert_eq!(
        history(&program, "killed.h5"),
        history(&program, "whole.h5")
    );
}

#[test]
fn a_step_that_fails_ends_the_history_and_is_said() {
    let program = Program::new();
    let settings = [
        "--no-figures",
        "--set",
        "solve.method=\"fixed-point\"",
        "--set",
        "solve.max_outer_steps=1",
    ];
    let failed = run(&program, &settings).assert().code(1);
    let said = String::from_utf8_lossy(&failed.get_output().stderr).into_owned();
    assert!(
        said.contains("load step 1, increment 1, ends the history"),
        "{said}"
    );
    let reader = Reader::open(&program.path("run.h5"), LAYOUT).expect("a run file");
    let stored = |path: &str| reader.read_vec::<f64>(path).expect("numbers");
    assert_eq!(stored("/history/time"), [1.0]);
    // What has no solution has no energies and no forces but the applied ones.
    for unknown in ["load_work", "strain_energy", "contact_force", "clamp_force"] {
        let values = stored(&format!("/history/{unknown}"));
        assert!(values.iter().all(|value| value.is_nan()), "{unknown}");
    }
    assert!(
        stored("/history/applied_force")
            .iter()
            .all(|it| it.is_finite())
    );
    assert!(!said.contains("NaN"), "{said}");
}

#[test]
fn what_is_about_one_problem_refuses_steps() {
    let program = Program::new();
    let scene = pipeline("history.toml");
    let scene = scene.to_str().expect("plain path");
    for command in [
        &["accuracy", scene, "run.h5"][..],
        &[
            "branches",
            scene,
            "run.h5",
            "--parameter",
            "friction.coefficient.constant",
            "--from",
            "0.1",
            "--to",
            "0.2",
        ],
    ] {
        let before = program.everything();
        let refused = program.command(command).args(SMALL).assert().code(2);
        let said = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        assert!(said.contains("step"), "{said}");
        assert_eq!(program.everything(), before, "{command:?}");
    }
}

/// The reason is said of the key, not of a step.
#[test]
fn dissipation_is_refused_with_the_reason() {
    let program = Program::new();
    let refused = run(&program, &["--error", "5%", "--quantity", "dissipation"])
        .assert()
        .code(2);
    let said = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(
        said.contains("adapt.of: expected a quantity of one increment")
            && said.contains("runs backwards"),
        "{said}"
    );
    assert!(!program.path("run.h5").exists());
}

#[test]
fn more_increments_than_fit_are_refused_before_the_first() {
    let program = Program::new();
    let steps = "step=[{increments=100000}]";
    let refused = run(
        &program,
        &[
            "--set",
            steps,
            "--set",
            "body.brick.cells=[48,16,16]",
            "--no-figures",
        ],
    );
    let mut refused = refused;
    let refused = refused.assert().code(2);
    let said = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(
        said.contains("keeping the increments of the load history"),
        "{said}"
    );
    assert!(!program.path("run.h5").exists());
}
