//! Bad arguments and files: exit code 2, a message that says what to do, nothing on disk changed.

use std::fs;

use crate::program::{Program, pipeline};

#[test]
fn overrides_are_checked_like_the_scene() {
    let program = Program::new();
    for (change, fragment) in [
        ("solve.epsilon", "KEY=VALUE"),
        ("solve.epsilon=abc def", "KEY=VALUE"),
        ("title=", "KEY=VALUE"),
        ("title=1\nother = 2", "KEY=VALUE"),
        ("title=1 2", "KEY=VALUE"),
        ("title=\"open", "KEY=VALUE"),
        ("body.brick.size=[1, 1e400]", "largest double"),
        ("solve.epsilon=7.0", "0 < epsilon < 1"),
        ("solve.tolerance=1e-3", "unknown key"),
        ("title.x=1", "below tables"),
        ("title.x=1", "title is neither a table nor a list"),
        ("traction.x=1", "no item x in the list traction"),
        ("traction.7.face=\"x_max\"", "numbers from 0 on"),
    ] {
        let refused = program.run(&["--set", change]).assert().code(2);
        let text = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        assert!(text.contains(fragment), "{change}: {text}");
    }
    assert!(!program.path("run.h5").exists());
}

/// A shell hands on what the advice about quotes says, and it is the text that was meant.
#[test]
fn the_advice_about_quotes_helps() {
    let program = Program::new();
    let scene = pipeline("newton.toml");
    let law = [
        "friction-law",
        scene.to_str().unwrap(),
        "--no-figures",
        "--json",
    ];
    for text in ["it's", "a \"word\" and $HOME", "both ' and \""] {
        let mut command = program.command(&law);
        let refused = command.args(["--set", &format!("title={text}")]).assert();
        let said = String::from_utf8_lossy(&refused.code(2).get_output().stderr).into_owned();
        let (_, argument) = said.rsplit_once("--set ").unwrap();
        let shell = format!("printf %s {}", argument.trim_end());
        let mut shell_command = std::process::Command::new("sh");
        let read = shell_command.args(["-c", &shell]).output().unwrap();
        let read = String::from_utf8(read.stdout).unwrap();
        let done = program.command(&law).args(["--set", &read]).assert();
        let json: serde_json::Value =
            serde_json::from_slice(&done.success().get_output().stdout).unwrap();
        assert_eq!(json["title"], text, "{said}");
    }
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
        (
            vec!["solve", "run.h5", "--set", "solve.epsilon=0"],
            "solve.epsilon",
        ),
        (
            vec!["solve", "run.h5", "--set", "solve.gamma=-1"],
            "solve.gamma",
        ),
        (
            vec!["solve", "run.h5", "--set", "contact.gap=1e-5"],
            "a key of [solve]",
        ),
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
    program.command(&["schema", "schemas"]).assert().success();
    program
        .command(&["schema", "schemas", "--check"])
        .assert()
        .success();
    let page = program.path("schemas/run_file.md");
    fs::write(&page, fs::read_to_string(&page).unwrap() + "x").unwrap();
    program
        .command(&["schema", "schemas", "--check"])
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
