//! `init`, `completions`, `man`, `--version`, and hints for mistyped words.

use std::fs;

use crate::program::Program;

fn printed(program: &Program, arguments: &[&str]) -> String {
    let output = program.command(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_scene_to_start_from_runs_and_is_never_overwritten() {
    let program = Program::new();
    printed(&program, &["init", "block.toml"]);
    printed(&program, &["run", "block.toml", "block.h5", "--no-figures"]);
    let before = program.everything();
    program.command(&["init", "block.toml"]).assert().code(2);
    assert!(program.everything() == before);
}

#[test]
fn every_command_has_a_page_and_a_completion() {
    let program = Program::new();
    printed(&program, &["man", "--out", "pages"]);
    let script = printed(&program, &["completions", "bash"]);
    let help = printed(&program, &["--help"]);
    let (_, commands) = help.split_once("Commands:").expect("a list of commands");
    let (commands, _) = commands.split_once("\n\n").expect("an end of the list");
    // Lines that go on with a meaning are indented further.
    let begun = commands.lines().filter_map(|line| line.strip_prefix("  "));
    let begun = begun.filter(|line| !line.starts_with(' '));
    let names = begun.filter_map(|line| line.split_whitespace().next());
    let mut seen = 0;
    for name in names.filter(|name| *name != "help") {
        let path = program
            .path("pages")
            .join(format!("contact3d-pipe-{name}.1"));
        let page = fs::read_to_string(&path).unwrap_or_default();
        assert!(
            page.contains(&format!(".TH contact3d-pipe-{name} 1")),
            "{name}"
        );
        assert!(script.contains(name), "{name}");
        seen += 1;
    }
    assert!(seen > 15, "{seen} commands in {commands}");
    // Pages of our own are written again; another file of that name is not.
    printed(&program, &["man", "--out", "pages"]);
    fs::write(program.path("pages").join("contact3d-pipe-run.1"), "mine").unwrap();
    program.command(&["man", "--out", "pages"]).assert().code(2);
}

#[test]
fn the_version_names_hdf5() {
    let program = Program::new();
    let long = printed(&program, &["--version"]);
    assert!(long.starts_with(concat!("contact3d-pipe ", env!("CARGO_PKG_VERSION"), "\n")));
    assert!(long.contains("\nHDF5 "), "{long}");
    assert_eq!(
        printed(&program, &["-V"]),
        concat!("contact3d-pipe ", env!("CARGO_PKG_VERSION"), "\n")
    );
}

#[test]
fn mistyped_words_are_answered_with_the_nearest_one() {
    let program = Program::new();
    let said = |arguments: &[&str]| {
        let output = program.command(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    printed(&program, &["init", "block.toml"]);
    assert!(said(&["stauts", "block.h5"]).contains("'status'"));
    let key = said(&["mesh", "block.toml", "run.h5", "--set", "contact.gapp=1e-5"]);
    assert!(key.contains("did you mean `gap`?"), "{key}");
}
