//! No command writes over what it reads, nor over a file that is not of its own kind.

use std::fs;

use crate::program::{Program, SMALL, pipeline};

/// A run file, a scene and files of others, and all that is there.
fn program() -> Program {
    let program = Program::new();
    program.run(&[]).assert().success();
    fs::copy(pipeline("newton.toml"), program.path("scene.toml")).unwrap();
    fs::write(program.path("notes.txt"), "my notes\n").unwrap();
    fs::write(
        program.path("page.html"),
        "<!DOCTYPE html><title>mine</title>\n",
    )
    .unwrap();
    fs::write(program.path("summary.csv"), "id,planned\n1,2\n").unwrap();
    fs::hard_link(program.path("run.h5"), program.path("hard.html")).unwrap();
    #[cfg(unix)]
    {
        let link = std::os::unix::fs::symlink;
        link("run.h5", program.path("soft.html")).unwrap();
        link("gone.html", program.path("dangling.html")).unwrap();
    }
    program
}

/// Runs a command that must be refused with nothing changed; returns what it said.
fn refused(program: &Program, arguments: &[&str]) -> String {
    let before = program.everything();
    let output = program.command(arguments).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
    assert!(
        program.everything() == before,
        "{arguments:?} changed something"
    );
    text
}

#[test]
fn a_report_replaces_neither_its_input_nor_a_file_of_another_kind() {
    let program = program();
    for (out, word) in [
        ("run.h5", "this command reads that file"),
        ("./run.h5", "this command reads that file"),
        ("hard.html", "this command reads that file (run.h5)"),
        ("scene.toml", "expected an HTML report of this program"),
        ("notes.txt", "found another text"),
        ("page.html", "found another HTML page"),
        ("summary.csv", "found another text"),
        (".", "expected a file, found a folder"),
        ("no/such/folder.html", "cannot write the file"),
    ] {
        let text = refused(&program, &["report", "run.h5", out]);
        assert!(text.contains(word), "{out}: {text}");
    }
    #[cfg(unix)]
    for (out, word) in [
        ("soft.html", "this command reads that file"),
        ("dangling.html", "cannot follow the symbolic link"),
    ] {
        let text = refused(&program, &["report", "run.h5", out]);
        assert!(text.contains(word), "{out}: {text}");
    }
}

#[test]
fn a_report_replaces_a_report_and_keeps_a_link_to_it() {
    let program = program();
    let report = |out: &str| {
        let mut command = program.command(&["report", "run.h5", out]);
        command.assert().success();
    };
    report("new.html");
    let first = fs::read(program.path("new.html")).unwrap();
    report("new.html");
    #[cfg(unix)]
    {
        fs::write(program.path("empty.html"), "").unwrap();
        std::os::unix::fs::symlink("empty.html", program.path("link.html")).unwrap();
        report("link.html");
        assert!(program.path("link.html").is_symlink());
        let through = fs::read(program.path("empty.html")).unwrap();
        assert_eq!(through.len(), first.len());
        report("/dev/null");
    }
    assert!(program.hidden().is_empty());
}

#[test]
fn pictures_replace_only_pictures_of_ours() {
    let program = program();
    let folder = program.path("run-figures");
    fs::create_dir(&folder).unwrap();
    for (name, content) in [
        (
            "overview.svg",
            &b"<svg xmlns=\"http://www.w3.org/2000/svg\"/>"[..],
        ),
        (
            "a_contact_pressure.png",
            b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR someone else's",
        ),
        ("f_friction_2.svg", b"notes"),
    ] {
        fs::write(folder.join(name), content).unwrap();
        let text = refused(&program, &["post", "run.h5"]);
        assert!(
            text.contains(name) && text.contains("of this program"),
            "{text}"
        );
        fs::remove_file(folder.join(name)).unwrap();
    }
    program.command(&["post", "run.h5"]).assert().success();
    program.command(&["post", "run.h5"]).assert().success();
    #[cfg(unix)]
    {
        // A picture that is a link to the run file.
        fs::remove_file(folder.join("overview.svg")).unwrap();
        std::os::unix::fs::symlink("../run.h5", folder.join("overview.svg")).unwrap();
        let text = refused(&program, &["post", "run.h5"]);
        assert!(text.contains("this command reads that file"), "{text}");
    }
}

#[test]
fn laws_schemas_studies_and_tables_of_checks_are_guarded_too() {
    let program = program();
    fs::create_dir(program.path("law")).unwrap();
    fs::write(program.path("law/friction_law.png"), "not a picture").unwrap();
    let text = refused(
        &program,
        &["friction-law", "scene.toml", "--figures", "law"],
    );
    assert!(text.contains("friction_law.png"), "{text}");

    fs::create_dir(program.path("schemas")).unwrap();
    fs::write(program.path("schemas/sweep.json"), "{\"mine\": 1}\n").unwrap();
    let text = refused(&program, &["schema", "schemas"]);
    assert!(
        text.contains("sweep.json: expected a JSON schema"),
        "{text}"
    );
    let text = refused(&program, &["schema", "notes.txt"]);
    assert!(
        text.contains("expected a folder to write to, found a file"),
        "{text}"
    );

    fs::write(program.path("convergence.svg"), "<svg/>").unwrap();
    let accuracy = |file: &str, figures: &str| {
        let arguments = ["accuracy", "scene.toml", file, "--figures", figures];
        refused(&program, &[&arguments[..], &SMALL].concat())
    };
    assert!(accuracy("run.h5", ".").contains("convergence.svg"));
    assert!(accuracy("scene.toml", "new").contains("this command reads that file"));
    assert!(accuracy("notes.txt", "new").contains("not an HDF5 file"));

    let stability = |out: &str| {
        let arguments = ["stability", "scene.toml", "--table", out];
        refused(&program, &[&arguments[..], &SMALL].concat())
    };
    assert!(stability("scene.toml").contains("this command reads that file"));
    assert!(stability("run.h5").contains("not one of our files"));
    assert!(stability("no/such/folder.h5").contains("does not exist"));
}

#[test]
fn run_files_are_guarded_too() {
    let program = program();
    let run = |file: &str| refused(&program, &["run", "scene.toml", file]);
    assert!(run("scene.toml").contains("this command reads that file"));
    assert!(run("notes.txt").contains("not an HDF5 file"));
    assert!(refused(&program, &["mesh", "scene.toml", "page.html"]).contains("not an HDF5 file"));
}
