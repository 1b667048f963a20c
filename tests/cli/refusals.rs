//! Exit code 2 means that nothing on disk changed.

use std::{
    fs,
    io::{BufRead as _, BufReader, Read as _},
    path::Path,
};

use hdf5_metno::File;

use crate::program::{Program, SMALL, pipeline};

/// Runs a command that must be refused with nothing changed; returns what it said.
fn refused(program: &Program, arguments: &[&str]) -> String {
    let before = program.everything();
    let output = program.command(arguments).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
    let after = program.everything();
    let changed = before.keys().chain(after.keys());
    let changed: Vec<_> = changed
        .filter(|k| before.get(*k) != after.get(*k))
        .collect();
    assert!(
        changed.is_empty(),
        "{arguments:?} changed {changed:?}: {text}"
    );
    text
}

/// A stiffness that overflows: the mesh is made, and then assembling is refused.
const OVERFLOW: [&str; 2] = ["--set", "material.isotropic.young_modulus=1e308"];

fn run<'a>(scene: &'a Path, more: &[&'a str]) -> Vec<&'a str> {
    let arguments = ["run", scene.to_str().expect("plain path"), "run.h5"];
    [&arguments[..], &SMALL, more].concat()
}

#[test]
fn a_stage_that_refuses_its_input_leaves_no_file() {
    let scene = pipeline("hkl2011_table1.toml");
    let program = Program::new();
    refused(&program, &run(&scene, &OVERFLOW));
    assert!(program.everything().is_empty());
}

/// The mesh does not depend on loads: it is fresh when a part of a face leaves the face, or shrinks to a point.
#[test]
fn parts_of_faces_are_looked_at_on_meshes_that_are_there() {
    let program = Program::new();
    let scene = pipeline("force_on_disc.toml");
    let run = ["run", scene.to_str().expect("plain path"), "run.h5"];
    program.command(&run).assert().success();
    for (change, words) in [
        ("force.0.disc.centre=[9.0,0.1,0.1]", "force.0.disc.centre"),
        ("force.0.disc.radius=1e-12", "force.0.disc.radius"),
    ] {
        let text = refused(&program, &[&run[..], &["--set", change]].concat());
        assert!(text.contains(words), "{change}: {text}");
    }
}

#[test]
fn a_stage_that_refuses_its_input_leaves_the_file_of_before() {
    let scene = pipeline("hkl2011_table1.toml");
    let program = Program::new();
    program.run(&[]).assert().success();
    let other_mesh = ["--set", "body.brick.size=[3.0,1.0,1.5]"];
    refused(
        &program,
        &run(&scene, &[&OVERFLOW[..], &other_mesh].concat()),
    );
    // The same file goes on as if nothing had been.
    let again = program.run(&[]).assert().success();
    let text = String::from_utf8_lossy(&again.get_output().stderr).into_owned();
    assert_eq!(text.matches("fresh, kept").count(), 5, "{text}");
}

/// Every command that reads a run file, or writes another state of it.
fn commands(scene: &Path) -> Vec<Vec<&str>> {
    vec![
        run(scene, &[]),
        vec!["solve", "run.h5"],
        vec!["post", "run.h5"],
        vec!["status", "run.h5"],
        vec!["check", "run.h5"],
        vec!["report", "run.h5", "page.html"],
        vec!["export", "run.h5", "grid.vtkhdf", "--kind", "vtkhdf"],
    ]
}

/// Files before format 2 are not gone on from: their user runs the scene again.
#[test]
fn a_file_of_an_older_format_is_left_as_it_is() {
    let scene = pipeline("hkl2011_table1.toml");
    let program = Program::new();
    File::create(program.path("run.h5")).expect("HDF5");
    for arguments in commands(&scene) {
        let text = refused(&program, &arguments);
        assert!(text.contains("of a format before 2.0"), "{text}");
        assert!(text.contains("nothing was changed"), "{text}");
        assert!(text.contains("run again with another path"), "{text}");
    }
}

/// What another program does to a file.
type Alteration = fn(&File) -> hdf5_metno::Result<()>;

const ALTERATIONS: [(&str, Alteration); 7] = [
    ("a value", |file| {
        let force = file.dataset("load/force")?;
        force.write_raw(&vec![f64::NAN; force.size()])
    }),
    ("a value for ParaView", |file| {
        let stresses = file.dataset("VTKHDF/PointData/von_mises")?;
        stresses.write_raw(&vec![f64::NAN; stresses.size()])
    }),
    ("words of units", |file| {
        let text: hdf5_metno::types::VarLenUnicode = "furlong, N".parse().expect("plain text");
        file.group("solve")?.attr("units")?.write_scalar(&text)
    }),
    ("an attribute for ParaView", |file| {
        let grid = file.group("VTKHDF")?;
        grid.delete_attr("Version")?;
        let version = grid.new_attr::<i64>().shape(2).create("Version")?;
        version.write_raw(&[7_i64, 0])
    }),
    ("no grid", |file| file.unlink("VTKHDF")),
    ("an array less", |file| file.unlink("VTKHDF/Points")),
    ("a dataset more", |file| {
        let builder = file.new_dataset_builder();
        builder.with_data(&[1.0]).create("mine").map(drop)
    }),
];

#[test]
fn a_file_that_another_program_changed_is_left_as_it_is() {
    let scene = pipeline("hkl2011_table1.toml");
    let program = Program::new();
    program.run(&[]).assert().success();
    let whole = fs::read(program.path("run.h5")).expect("a file");
    for (what, alter) in ALTERATIONS {
        fs::write(program.path("run.h5"), &whole).expect("written");
        let file = File::open_rw(program.path("run.h5")).expect("HDF5");
        alter(&file).expect("altered");
        file.close().expect("closed");
        for arguments in commands(&scene) {
            let text = refused(&program, &arguments);
            assert!(
                text.contains("run.h5: its bytes are not those that"),
                "{what}: {text}"
            );
            assert!(text.contains("remove it and run again"), "{what}: {text}");
        }
    }
    fs::remove_file(program.path("run.h5")).expect("removed");
    program.run(&[]).assert().success();
    program.command(&["check", "run.h5"]).assert().success();
}

/// The linked file of the old state is needed again when the new state is given up.
#[test]
fn the_linked_assembly_of_the_file_of_before_stays() {
    let scene = pipeline("newton.toml");
    let program = Program::new();
    let large = [
        "--set",
        "body.brick.cells=[12,4,4]",
        "--no-figures",
        "--linked",
    ];
    let arguments = ["run", scene.to_str().expect("plain path"), "run.h5"];
    let run = |more: &[&str]| {
        program
            .command(&[&arguments[..], &large, more].concat())
            .assert()
    };
    run(&[]).success();
    let linked = |name: &String| name.starts_with("assemble-");
    assert_eq!(program.everything().keys().filter(|n| linked(n)).count(), 1);
    let other_mesh = ["--set", "body.brick.size=[3.0,1.0,1.5]"];
    refused(
        &program,
        &[&arguments[..], &large, &OVERFLOW, &other_mesh].concat(),
    );
    program.command(&["check", "run.h5"]).assert().success();
}

#[test]
fn a_folder_for_pictures_that_cannot_be_is_refused_before_anything_is_stored() {
    let scene = pipeline("hkl2011_table1.toml");
    let program = Program::new();
    fs::write(program.path("file"), "text").unwrap();
    for folder in ["file", "file/below", "/proc/nowhere"] {
        let text = refused(&program, &run(&scene, &["--figures", folder]));
        assert!(text.contains("expected a folder to write to"), "{text}");
    }
    program.run(&[]).assert().success();
    for command in ["post", "solve"] {
        let mut arguments = vec![command, "run.h5"];
        if command == "post" {
            arguments.extend(["--figures", "file"]);
        } else {
            arguments.extend(["--set", "solve.epsilon=-1"]);
        }
        refused(&program, &arguments);
    }
    let accuracy = [
        "accuracy",
        scene.to_str().unwrap(),
        "run.h5",
        "--figures",
        "file",
    ];
    refused(&program, &[&accuracy[..], &SMALL].concat());
    refused(
        &program,
        &["friction-law", scene.to_str().unwrap(), "--figures", "file"],
    );
}

/// A folder made for pictures does not outlive a refusal.
#[test]
fn no_empty_folder_is_left() {
    let scene = pipeline("hkl2011_table1.toml");
    let program = Program::new();
    refused(
        &program,
        &run(&scene, &[&OVERFLOW[..], &["--figures", "a/b/c"]].concat()),
    );
    refused(
        &program,
        &["run", "missing.toml", "run.h5", "--figures", "a"],
    );
}

/// A folder that does not take the pictures any more when they are drawn is bad input, and the results are stored all the same.
#[test]
fn pictures_that_cannot_be_written_are_exit_code_2() {
    let program = Program::new();
    let mut started = std::process::Command::new(assert_cmd::cargo::cargo_bin("contact3d-pipe"))
        .current_dir(program.path(""))
        .arg("accuracy")
        .arg(pipeline("hkl2011_table1.toml"))
        .args([
            "run.h5",
            "--json",
            "--coarsest",
            "2",
            "--finest",
            "8",
            "--budget",
            "0.1",
        ])
        .args(SMALL)
        .stderr(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // The folder is claimed before anything is measured, and the first line tells of the first of three measurements.
    let mut told = BufReader::new(started.stderr.take().unwrap());
    let mut text = String::new();
    told.read_line(&mut text).unwrap();
    fs::remove_dir(program.path("run-figures")).expect("a folder without pictures");
    fs::write(program.path("run-figures"), "no folder").unwrap();
    told.read_to_string(&mut text).unwrap();
    let ended = started.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(2), "{text}");
    assert!(
        text.contains("the results were stored before and kept"),
        "{text}"
    );
    let error: serde_json::Value = serde_json::from_slice(&ended.stdout).unwrap();
    assert_eq!(error["exit_code"], 2);
    program.command(&["check", "run.h5"]).assert().success();
}

/// A disk that is full midway is no fault of the input: what was stored stays, and the exit code
/// says so.
#[cfg(target_os = "linux")]
#[test]
fn a_machine_that_fails_midway_keeps_what_was_stored() {
    let program = Program::new();
    program.run(&[]).assert().success();
    let whole = fs::metadata(program.path("run.h5")).unwrap().len();
    fs::remove_file(program.path("run.h5")).unwrap();
    // In blocks of 512 bytes: the last stages do not fit.
    let script = format!("trap '' XFSZ; ulimit -f {}; exec \"$@\"", whole / 512 - 100);
    let scene = pipeline("hkl2011_table1.toml");
    let mut limited = assert_cmd::Command::new("sh");
    let run = limited
        .current_dir(program.path(""))
        .args(["-c", &script, "sh"])
        .arg(assert_cmd::cargo::cargo_bin("contact3d-pipe"))
        .args(run(&scene, &["--no-figures"]))
        .assert()
        .code(1);
    let text = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    assert!(text.contains("stored before and kept"), "{text}");
    assert_eq!(program.states()[1].1, "fresh", "the assembly is kept");
    program.command(&["check", "run.h5"]).assert().success();
    assert!(!program.path(".run.h5.previous").exists());
    let again = program.run(&[]).assert().success();
    let text = String::from_utf8_lossy(&again.get_output().stderr).into_owned();
    assert!(text.contains("assemble  fresh, kept"), "{text}");
}
