//! Large assembled data in a file beside the run file: seen, lost, altered, cleaned up, taken in.

use std::{fs, path::PathBuf};

use serde_json::Value;

use crate::program::{Program, pipeline};

/// Assembled data exceed 512 MB from about 60 million coefficients of the factor on; smaller ones are linked where asked.
const SMALL: &str = "body.brick.cells=[12,4,4]";

fn run(program: &Program, more: &[&str]) -> assert_cmd::assert::Assert {
    let scene = pipeline("newton.toml");
    let scene = scene.to_str().unwrap();
    let mut command =
        program.command(&["run", scene, "run.h5", "--no-figures", "-v", "--set", SMALL]);
    if !more.contains(&"--self-contained") {
        command.arg("--linked");
    }
    command.args(more).assert()
}

fn assemble_status(program: &Program) -> Value {
    program.status()["stages"][1].clone()
}

fn linked_file(program: &Program) -> Option<PathBuf> {
    let status = assemble_status(program);
    let linked = status["linked_file"].as_object()?;
    let path = program.path(linked["name"].as_str().unwrap());
    assert_eq!(linked["bytes"], fs::metadata(&path).unwrap().len());
    Some(path)
}

fn stderr(assert: &assert_cmd::assert::Assert) -> String {
    String::from_utf8_lossy(&assert.get_output().stderr).into_owned()
}

fn linked_files(program: &Program) -> usize {
    let entries = fs::read_dir(program.path("")).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter(|name| name.contains("assemble-")).count()
}

#[test]
fn large_assemblies_live_beside_the_run_file() {
    let program = Program::new();
    run(&program, &[]).success();
    let digests = program.digests();
    let linked = linked_file(&program).expect("a linked file");
    let length = |path: &std::path::Path| fs::metadata(path).unwrap().len();
    let whole = Program::new();
    run(&whole, &["--self-contained"]).success();
    // All but the linked group and what a file has anyway; the run file itself does not hold the factor.
    let factor = hdf5_metno::File::open(&linked).unwrap();
    let factor = factor.dataset("assemble/factor/values").unwrap();
    let rest = length(&whole.path("run.h5")) + factor.storage_size() - length(&linked);
    drop(factor);
    assert!(length(&program.path("run.h5")).abs_diff(rest) < 100_000);
    let shown = program.command(&["status", "run.h5"]).assert().success();
    let text = String::from_utf8_lossy(&shown.get_output().stdout).into_owned();
    assert!(
        text.contains(linked.file_name().unwrap().to_str().unwrap()),
        "{text}"
    );

    let scene = pipeline("newton.toml");
    let again = ["run", scene.to_str().unwrap(), "run.h5", "--no-figures"];
    let mut again = program.command(&again);
    let again = again.args(["--linked", "--set", SMALL]).assert().success();
    let told = String::from_utf8_lossy(&again.get_output().stdout).into_owned();
    let name = linked.file_name().unwrap().to_str().unwrap();
    assert!(told.contains(&format!("run.h5, {name}\n")), "{told}");

    // Lost: said with its name, stale, and made again.
    let bytes = fs::read(&linked).unwrap();
    fs::remove_file(&linked).unwrap();
    let refused = program.command(&["solve", "run.h5"]).assert().code(2);
    let text = stderr(&refused);
    assert!(
        text.contains("needs a fresh `assemble`") && text.contains("is missing"),
        "{text}"
    );
    assert!(text.contains(linked.to_str().unwrap()), "{text}");
    let status = assemble_status(&program);
    assert_eq!(status["state"], "stale");
    assert!(status["why"].as_str().unwrap().contains("is missing"));
    run(&program, &[]).success();
    assert_eq!(program.digests(), digests);
    assert_eq!(linked_file(&program), Some(linked.clone()));

    // Altered in the middle of the factor: found on reading, cured by assembling again.
    let mut altered = bytes;
    let middle = altered.len() / 2;
    altered[middle] ^= 1;
    fs::write(&linked, &altered).unwrap();
    let text = stderr(&program.command(&["solve", "run.h5"]).assert().code(2));
    assert!(
        text.contains("its bytes are not those that") && text.contains("assemble-"),
        "{text}"
    );
    let text = stderr(&run(&program, &[]).success());
    assert!(
        text.contains("warning: assemble is made again: it cannot be used"),
        "{text}"
    );

    // Write-protected: read, but not replaced.
    let mut permissions = fs::metadata(&linked).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&linked, permissions.clone()).unwrap();
    program.command(&["solve", "run.h5"]).assert().success();
    let text = stderr(
        &program
            .command(&["assemble", "run.h5", "--linked"])
            .assert()
            .code(2),
    );
    assert!(text.contains("write-protected"), "{text}");
    #[allow(clippy::permissions_set_readonly_false, reason = "a scratch file")]
    permissions.set_readonly(false);
    fs::set_permissions(&linked, permissions).unwrap();
}

#[test]
fn an_assembly_can_be_kept_in_or_taken_into_the_run_file() {
    let program = Program::new();
    run(&program, &["--self-contained"]).success();
    let digests = program.digests();
    assert_eq!(linked_files(&program), 0);
    assert_eq!(linked_file(&program), None);
    program
        .command(&["assemble", "run.h5", "--linked"])
        .assert()
        .success();
    assert_eq!(linked_files(&program), 1);
    assert_eq!(program.digests(), digests);
    let text = stderr(&run(&program, &["--self-contained"]).success());
    assert_eq!(text.matches("fresh, kept").count(), 5, "{text}");
    assert_eq!(linked_files(&program), 0);
    assert_eq!(program.digests(), digests);
}

#[test]
fn an_assembly_that_is_used_no_more_is_removed() {
    let program = Program::new();
    run(&program, &[]).success();
    let first = linked_file(&program);
    run(&program, &["--set", "material.isotropic.poisson_ratio=0.3"]).success();
    assert_ne!(linked_file(&program), first);
    assert_eq!(linked_files(&program), 1);
    run(
        &program,
        &["--self-contained", "--set", "body.brick.cells=[6,2,2]"],
    )
    .success();
    assert_eq!(linked_files(&program), 0);
}

/// Each level of an adaptive run links its own assembled data, and only those of the last one stay.
#[test]
fn levels_leave_no_assembled_data_behind() {
    let program = Program::new();
    let first = run(
        &program,
        &["--error", "15%", "--set", "body.element=\"P1\""],
    )
    .success();
    assert!(stderr(&first).contains("level 1 "), "{}", stderr(&first));
    assert_eq!(linked_files(&program), 1);
}
