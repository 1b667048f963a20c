//! `bound` as a user meets it.

use serde_json::Value;

use crate::program::Program;

#[test]
fn a_bound_is_stored_printed_and_shown() {
    let program = Program::new();
    program.run(&[]).assert().success();
    let before = program.digests();
    let done = program.command(&["bound", "run.h5"]).assert().success();
    let text = String::from_utf8_lossy(&done.get_output().stdout).into_owned();
    assert!(
        text.contains("no bound: friction follows the pressure"),
        "{text}"
    );
    let done = program
        .command(&["bound", "run.h5", "--json"])
        .assert()
        .success();
    let json: Value = serde_json::from_slice(&done.get_output().stdout).expect("JSON");
    let share = json["elements"].as_f64().expect("a number");
    // The estimate of this coarse mesh is 0.2 to 0.3.
    assert!(
        (0.2..0.6).contains(&share) && json["total"].is_null(),
        "{json}"
    );
    assert_eq!(program.digests(), before);
    program.command(&["check", "run.h5"]).assert().success();
    program.command(&["report", "run.h5"]).assert().success();
    let page = std::fs::read_to_string(program.path("report.html")).expect("a page");
    assert!(page.contains("under these contact stresses"));
}

#[test]
fn only_answers_within_the_scope_have_bounds() {
    let program = Program::new();
    let nodal = ["--set", "contact.multipliers=\"nodal\""];
    program.run(&nodal).assert().success();
    let bytes = std::fs::read(program.path("run.h5")).expect("a file");
    let refused = program.command(&["bound", "run.h5"]).assert().code(2);
    let message = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(message.contains("contact.multipliers"), "{message}");
    assert_eq!(
        std::fs::read(program.path("run.h5")).expect("a file"),
        bytes
    );
    program.command(&["bound", "other.h5"]).assert().code(2);
    assert!(!program.path("other.h5").exists());
}
