//! Several contact faces: results and pictures of each, what is computed anew, what is refused.

use std::fs;

use serde_json::Value;

use crate::program::{Program, pipeline};

const COARSE: [&str; 2] = ["--set", "body.brick.cells=[4,4,4]"];

/// `run` of the block in a corner with changes.
fn run(program: &Program, options: &[&str]) -> Value {
    let scene = pipeline("corner_block.toml");
    let mut run = program.command(&["run", scene.to_str().unwrap(), "run.h5", "--json"]);
    let output = run.args(COARSE).args(options).assert().success();
    serde_json::from_slice(&output.get_output().stdout).unwrap()
}

#[test]
fn each_face_has_its_results_and_its_pictures() {
    let program = Program::new();
    let results = run(&program, &[]);
    let faces = results["faces"].as_array().unwrap();
    let names: Vec<_> = faces.iter().map(|face| face["name"].as_str()).collect();
    assert_eq!(names, [Some("floor"), Some("wall")]);
    for zone in ["open", "stick", "slip"] {
        let sum: u64 = faces.iter().filter_map(|face| face[zone].as_u64()).sum();
        assert_eq!(Some(sum), results[zone].as_u64());
    }
    let normal: f64 = faces
        .iter()
        .filter_map(|face| face["normal_force"].as_f64())
        .sum();
    // Two sums of the same eight forces.
    assert!((normal / results["normal_force"].as_f64().unwrap() - 1.0).abs() < 1e-14);
    assert_eq!(results["tangential_force"], Value::Null);
    let pictures = |ending: &str| {
        let files = fs::read_dir(program.path("run-figures")).unwrap();
        let names = files.map(|file| file.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name.ends_with(ending)).count()
    };
    assert_eq!(pictures(".png"), 15);
    assert_eq!([pictures("-floor.svg"), pictures("-wall.svg")], [7, 7]);
    assert!(!program.path("run-figures/figure5.svg").exists());
}

/// The laws are settings of the solve, gaps of the loads, axes of B; a face that loses its friction loses its pairs, and comes last.
#[test]
fn changes_of_one_face_are_computed_as_far_as_they_reach() {
    let program = Program::new();
    run(&program, &["--no-figures"]);
    let performed = |change: &str| -> Vec<String> {
        let results = run(&program, &["--no-figures", "--set", change]);
        let stages = results["stages"].as_array().unwrap().iter();
        let stages = stages.map(|stage| stage["stage"].as_str().unwrap().to_owned());
        stages.collect()
    };
    let law = performed("contact.0.friction.coefficient.constant=0.25");
    assert_eq!(law, ["solve", "post"]);
    run(&program, &["--no-figures"]);
    assert_eq!(performed("contact.1.gap=1e-6"), ["load", "solve", "post"]);
    run(&program, &["--no-figures"]);
    let axes = performed("contact.1.angle=30.0");
    assert_eq!(axes, ["assemble", "load", "solve", "post"]);
    run(&program, &["--no-figures"]);
    let name = performed("contact.1.name=\"pillar\"");
    assert_eq!(name, ["mesh", "assemble", "load", "solve", "post"]);
}

#[test]
fn studies_of_one_face_refuse_several() {
    let scene = pipeline("corner_block.toml");
    let scene = scene.to_str().unwrap();
    let key = "contact.0.friction.coefficient.constant";
    for arguments in [
        vec!["law", scene],
        vec!["theory", scene, "study.h5"],
        vec![
            "branches",
            scene,
            "study.h5",
            "--parameter",
            key,
            "--from",
            "0.1",
            "--to",
            "0.2",
        ],
    ] {
        let program = Program::new();
        let refused = program.command(&arguments).assert().code(2);
        let text = String::from_utf8_lossy(&refused.get_output().stderr).replace('│', " ");
        // Long lines are broken.
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            text.contains("contact: expected one contact face"),
            "{text}"
        );
        assert!(!program.path("study.h5").exists());
    }
}
