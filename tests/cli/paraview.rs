//! `/VTKHDF` belongs to `post`: what ParaView shows is what the report says.

use std::path::Path;

use hdf5_metno::File;

use crate::program::Program;

fn state_of_post(program: &Program) -> String {
    let output = program
        .command(&["status", "run.h5", "--json"])
        .output()
        .unwrap();
    let status: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let stages = status["stages"].as_array().expect("stages").clone();
    let post = stages.iter().find(|stage| stage["stage"] == "post");
    post.expect("post")["state"]
        .as_str()
        .expect("a word")
        .to_owned()
}

/// Takes `/VTKHDF` out of a file, and puts that of another one in its place.
fn exchange(file: &Path, other: Option<&Path>) {
    let target = File::open_rw(file).expect("HDF5");
    target.unlink("VTKHDF").expect("removed");
    if let Some(other) = other {
        let source = File::open(other).expect("HDF5");
        let group = source.group("VTKHDF").expect("the group");
        group.copy_to(&target, "VTKHDF").expect("copied");
    }
    target.close().expect("closed");
}

fn is_seen_and_mended(program: &Program, word: &str) {
    assert_eq!(state_of_post(program), "damaged");
    let check = program.command(&["check", "run.h5"]).assert().code(2);
    let text = String::from_utf8_lossy(&check.get_output().stderr).into_owned();
    assert!(text.contains("VTKHDF") && text.contains(word), "{text}");
    let run = program.run(&[]).assert().success();
    let text = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    assert_eq!(text.matches("fresh, kept").count(), 4, "{text}");
    assert_eq!(state_of_post(program), "fresh");
    program.command(&["check", "run.h5"]).assert().success();
}

#[test]
fn a_deleted_grid_is_seen_and_made_again() {
    let program = Program::new();
    program.run(&[]).assert().success();
    let whole = program.digests();
    exchange(&program.path("run.h5"), None);
    is_seen_and_mended(&program, "missing");
    assert_eq!(program.digests(), whole);
}

#[test]
fn the_grid_of_another_run_is_seen_and_made_again() {
    let other = Program::new();
    other
        .run(&["--set", "friction.coefficient_1={constant=0.1}"])
        .assert()
        .success();
    let program = Program::new();
    program.run(&[]).assert().success();
    let whole = program.digests();
    exchange(&program.path("run.h5"), Some(&other.path("run.h5")));
    is_seen_and_mended(&program, "altered");
    assert_eq!(program.digests(), whole);
}

#[test]
fn a_deleted_array_is_a_matter_of_post() {
    let program = Program::new();
    program.run(&[]).assert().success();
    let target = File::open_rw(program.path("run.h5")).expect("HDF5");
    target.unlink("VTKHDF/Points").expect("removed");
    target.close().expect("closed");
    is_seen_and_mended(&program, "Points is missing; run `post` again");
}

#[test]
fn a_changed_attribute_is_seen_and_made_again() {
    for (name, wrong) in [
        ("Type", "Type = \"UnstructuredGrid\", found another type"),
        ("Version", "Version = [2, 0], found [7, 0]"),
    ] {
        let program = Program::new();
        program.run(&[]).assert().success();
        let target = File::open_rw(program.path("run.h5")).expect("HDF5");
        let group = target.group("VTKHDF").expect("the group");
        group.delete_attr(name).expect("removed");
        let changed = group.new_attr::<i64>().shape(2).create(name);
        changed
            .expect("an attribute")
            .write_raw(&[7, 0])
            .expect("written");
        drop(group);
        target.close().expect("closed");
        is_seen_and_mended(&program, wrong);
    }
}
