//! Control characters in titles, file names and faulty scenes: shown, never obeyed.

use std::fs;

use serde_json::Value;

use crate::program::{Program, SMALL, pipeline};

/// A scene whose title would colour the terminal, begin a new line and turn the text.
fn scene(program: &Program) {
    let text = fs::read_to_string(pipeline("newton.toml")).unwrap();
    let (before, rest) = text.split_once("title = ").unwrap();
    let (_, after) = rest.split_once('\n').unwrap();
    let title = r#"title = "a\u001b[31mb\nc\u009bd\u007f\u202e""#;
    fs::write(
        program.path("scene.toml"),
        format!("{before}{title}\n{after}"),
    )
    .unwrap();
}

/// Whether text would command a terminal.
fn commands(text: &str) -> bool {
    text.chars()
        .any(|c| (c.is_control() && c != '\n' && c != '\t') || c == '\u{202e}')
}

#[test]
fn titles_are_shown_with_their_escapes() {
    let program = Program::new();
    scene(&program);
    let shown = "a\\u{1b}[31mb\\nc\\u{9b}d\\u{7f}\\u{202e}";
    let run = ["run", "scene.toml", "run.h5", SMALL[0], SMALL[1]];
    let lines: [&[&str]; 3] = [&run, &["status", "run.h5"], &["friction-law", "scene.toml"]];
    for command in lines {
        let done = program.command(command).assert().success();
        let text = String::from_utf8_lossy(&done.get_output().stdout).into_owned();
        assert!(
            text.lines().any(|line| line == shown),
            "{command:?}: {text}"
        );
        assert!(!commands(&text), "{command:?}: {text}");
    }
    program
        .command(&["report", "run.h5", "r.html"])
        .assert()
        .success();
    for file in [
        "r.html",
        "run-figures/overview.svg",
        "scene-friction-law/friction_law.svg",
    ] {
        let text = fs::read_to_string(program.path(file)).unwrap();
        assert!(text.contains(shown) && !commands(&text), "{file}");
    }
}

#[test]
fn a_title_alone_is_stored_and_no_stage_runs_again() {
    let program = Program::new();
    program.run(&["--set", "title=\"A\""]).assert().success();
    let digests = program.digests();
    program.run(&["--set", "title=\"B\""]).assert().success();
    assert_eq!(program.status()["title"], "B");
    assert_eq!(program.digests(), digests);
    let before = fs::read(program.path("run.h5")).unwrap();
    program.run(&["--set", "title=\"B\""]).assert().success();
    assert_eq!(fs::read(program.path("run.h5")).unwrap(), before);
}

#[test]
fn json_holds_the_title_itself() {
    let program = Program::new();
    scene(&program);
    program
        .command(&["mesh", "scene.toml", "run.h5"])
        .args(SMALL)
        .assert()
        .success();
    let done = program
        .command(&["status", "run.h5", "--json"])
        .assert()
        .success();
    let text = String::from_utf8_lossy(&done.get_output().stdout).into_owned();
    assert!(!commands(&text), "{text}");
    let json: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["title"], "a\u{1b}[31mb\nc\u{9b}d\u{7f}\u{202e}");
}

#[test]
fn quoted_scenes_and_paths_command_nothing() {
    let program = Program::new();
    fs::write(
        program.path("bad.toml"),
        "title = \"t\"\nbad \u{1b}[31m = 1\n",
    )
    .unwrap();
    for arguments in [
        ["run", "bad.toml", "run.h5"],
        ["run", "no\u{1b}[31m.toml", "run.h5"],
    ] {
        let refused = program.command(&arguments).assert().code(2);
        let text = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        assert!(text.contains("\\u{1b}[31m") && !commands(&text), "{text}");
    }
}
