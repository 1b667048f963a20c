//! Pipes, devices, folders and files without end, where a scene, a mesh or a run file is expected.
#![cfg(unix)]

use std::{fs, path::Path, process::Command, time::Duration};

use crate::program::{Program, SMALL, pipeline};

/// Longer than any refusal takes.
const PATIENCE: Duration = Duration::from_secs(30);

/// A scratch folder with a pipe that nobody writes to, a folder, and a scene.
fn scratch() -> Program {
    let program = Program::new();
    let made = Command::new("mkfifo").arg(program.path("pipe")).status();
    assert!(made.unwrap().success());
    fs::create_dir(program.path("folder")).unwrap();
    fs::copy(pipeline("newton.toml"), program.path("scene.toml")).unwrap();
    program
}

/// What a command says when it is refused, in time, with exit code 2.
fn refused(program: &Program, arguments: &[&str]) -> String {
    let mut command = program.command(arguments);
    let refused = command.timeout(PATIENCE).assert().code(2);
    String::from_utf8_lossy(&refused.get_output().stderr).into_owned()
}

#[test]
fn a_run_file_is_a_regular_file() {
    let program = scratch();
    for path in ["pipe", "/dev/zero", "/dev/null"] {
        let run = ["run", "scene.toml", path, SMALL[0], SMALL[1]];
        let commands: [&[&str]; 6] = [
            &run,
            &["status", path],
            &["check", path],
            &["solve", path],
            &["report", path],
            &["accuracy", "scene.toml", path],
        ];
        for command in commands {
            let text = refused(&program, command);
            assert!(
                text.contains("expected a regular file"),
                "{command:?}: {text}"
            );
        }
    }
    assert!(!Path::new("/dev/.zero.lock").exists());
    assert!(refused(&program, &["run", "scene.toml", "folder"]).contains("is a directory"));
}

#[test]
fn a_lock_file_that_is_a_pipe_is_refused() {
    let program = scratch();
    fs::rename(program.path("pipe"), program.path(".run.h5.lock")).unwrap();
    let text = refused(&program, &["run", "scene.toml", "run.h5"]);
    assert!(
        text.contains(".run.h5.lock: expected a regular file"),
        "{text}"
    );
}

#[test]
fn an_output_to_a_pipe_that_nobody_reads_is_refused() {
    let program = scratch();
    let text = refused(&program, &["init", "pipe"]);
    assert!(text.contains("nobody reads the pipe"), "{text}");
    let script = "cat pipe >copy & sleep 0.5; timeout 20 \"$program\" init pipe; wait";
    let (code, text) = bash(&program, script);
    assert_eq!(code, Some(0), "{text}");
    assert!(
        fs::read_to_string(program.path("copy"))
            .unwrap()
            .contains("title")
    );
}

#[test]
fn a_scene_or_sweep_is_no_device_and_no_folder() {
    let program = scratch();
    for path in ["/dev/zero", "/dev/null", "folder"] {
        let commands: [&[&str]; 5] = [
            &["run", path, "run.h5"],
            &["friction-law", path],
            &["accuracy", path, "run.h5"],
            &["stability", path],
            &["sweep", path, "out"],
        ];
        for command in commands {
            let text = refused(&program, command);
            assert!(
                text.contains("expected a regular file or a pipe"),
                "{command:?}: {text}"
            );
        }
    }
}

/// Runs a script of bash, which has `<(command)`, and returns its exit code and what it said.
fn bash(program: &Program, script: &str) -> (Option<i32>, String) {
    let output = Command::new("bash")
        .args(["-c", script])
        .current_dir(program.path(""))
        .env("program", assert_cmd::cargo::cargo_bin("contact3d-pipe"))
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), text)
}

#[test]
fn a_scene_may_come_through_a_pipe_up_to_its_limit() {
    let program = scratch();
    let set = SMALL.join(" ");
    let from_pipe =
        format!("\"$program\" run <(sleep 0.5; cat scene.toml) run.h5 --no-figures {set}");
    let (code, text) = bash(&program, &from_pipe);
    assert_eq!(code, Some(0), "{text}");
    assert!(program.states().iter().all(|(_, state)| state == "fresh"));
    let (code, text) = bash(&program, "\"$program\" run <(yes '# endless') endless.h5");
    assert_eq!(code, Some(2), "{text}");
    assert!(text.contains("expected at most 4000000 bytes"), "{text}");
    let (code, text) = bash(&program, "\"$program\" sweep <(yes '# endless') out");
    assert_eq!(code, Some(2), "{text}");
    assert!(text.contains("expected at most 4000000 bytes"), "{text}");
}

#[test]
fn a_mesh_file_is_a_regular_file_that_fits_into_memory() {
    let program = scratch();
    let endless = fs::File::create(program.path("endless")).unwrap();
    endless.set_len(10_000_000_000_000).unwrap();
    let cases = [
        ("pipe", "found a pipe"),
        ("/dev/zero", "found a character device"),
        ("folder", "found a folder"),
        ("endless", "reading the mesh file: expected at most"),
    ];
    for (file, words) in cases {
        let scene = format!(
            "title = \"t\"\n[body.gmsh]\nfile = \"{file}\"\n[material.isotropic]\nyoung_modulus = 1e9\n\
             poisson_ratio = 0.3\n[[clamp]]\nface = \"x_min\"\n"
        );
        fs::write(program.path("gmsh.toml"), scene).unwrap();
        let commands: [&[&str]; 3] = [
            &["run", "gmsh.toml", "run.h5"],
            &["accuracy", "gmsh.toml", "run.h5"],
            &["mesh", "gmsh.toml", "run.h5"],
        ];
        for command in commands {
            let text = refused(&program, command);
            assert!(text.contains(words), "{command:?} {file}: {text}");
        }
    }
    assert!(!program.path("run.h5").exists());
}
