//! Several contact faces: results and pictures of each, what is computed anew, what is refused.

use std::fs;

use contact3d_pipe::LAYOUT;
use runfile::Reader;
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
    // Coefficients of the floor are constant, which leaves two panels out.
    assert_eq!(pictures(".png"), 14);
    assert_eq!([pictures("-floor.svg"), pictures("-wall.svg")], [5, 7]);
    assert!(!program.path("run-figures/overview.svg").exists());
    let status = program.command(&["status", "run.h5"]).assert().success();
    let screen = String::from_utf8_lossy(&status.get_output().stdout).into_owned();
    let peak = screen
        .lines()
        .find(|line| line.contains("largest pressure"));
    assert!(
        peak.is_some_and(|it| it.contains(" mm on wall")),
        "{screen}"
    );
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
fn paths_of_solutions_refuse_several_faces() {
    let scene = pipeline("corner_block.toml");
    let scene = scene.to_str().unwrap();
    let program = Program::new();
    let refused = program
        .command(&["branches", scene, "study.h5"])
        .args(["--parameter", "contact.0.friction.coefficient.constant"])
        .args(["--from", "0.1", "--to", "0.2"])
        .assert()
        .code(2);
    let text = String::from_utf8_lossy(&refused.get_output().stderr).replace('│', " ");
    // Long lines are broken.
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        text.contains("contact: expected one contact face"),
        "{text}"
    );
    assert!(!program.path("study.h5").exists());
}

#[test]
fn each_face_has_its_law() {
    let program = Program::new();
    let scene = pipeline("corner_block.toml");
    let scene = scene.to_str().unwrap();
    let law = |scene: &str, more: &[&str]| {
        let mut command = program.command(&["friction-law", scene]);
        let done = command.args(COARSE).args(more).assert().success();
        String::from_utf8_lossy(&done.get_output().stdout).into_owned()
    };
    let json: Value = serde_json::from_str(&law(scene, &["--json", "--quiet"])).unwrap();
    let value = |face: usize, name: &str| json["faces"][face]["bounds"][name]["value"].as_f64();
    assert_eq!(json["faces"][1]["name"], "wall");
    assert_eq!([value(0, "f_min"), value(0, "f_max")], [Some(0.3); 2]);
    assert_eq!(
        [value(1, "f_min"), value(1, "f_max")],
        [Some(0.2), Some(0.4)]
    );
    assert_eq!(
        [value(0, "lipschitz"), value(1, "lipschitz")],
        [Some(0.0), Some(3e4)]
    );
    for name in ["friction_law-floor.svg", "friction_law-wall.png"] {
        assert!(
            program
                .path(&format!("corner_block-friction-law/{name}"))
                .exists()
        );
    }
    // A given slip bound has no bounds and no picture.
    let plates = pipeline("two_plates.toml");
    let plates = plates.to_str().unwrap();
    let text = law(plates, &[]);
    let [lower, upper] = ["lower\n", "upper\n"].map(|heading| text.find(heading).unwrap());
    let words = text.find("with a given slip bound").unwrap();
    assert!(lower < upper && upper < words, "{text}");
    assert!(
        program
            .path("two_plates-friction-law/friction_law-lower.svg")
            .exists()
    );
    assert!(
        !program
            .path("two_plates-friction-law/friction_law-upper.svg")
            .exists()
    );
}

#[test]
fn paraview_gets_the_normal_of_each_triangle() {
    let program = Program::new();
    run(&program, &["--no-figures"]);
    let reader = Reader::open(&program.path("run.h5"), LAYOUT).unwrap();
    let read = |name: &str| reader.read_vec::<f64>(&format!("/VTKHDF/CellData/{name}"));
    let (faces, normals) = (
        read("contact_face").unwrap(),
        read("contact_normal").unwrap(),
    );
    for (face, normal) in faces.iter().zip(normals.as_chunks::<3>().0) {
        match *face {
            0.0 => assert_eq!(*normal, [0.0, 0.0, -1.0]),
            1.0 => assert_eq!(*normal, [-1.0, 0.0, 0.0]),
            _ => assert!(face.is_nan() && normal.iter().all(|v| v.is_nan())),
        }
    }
    assert_eq!(
        faces.iter().filter(|face| !face.is_nan()).count(),
        2 * 2 * 16
    );
}

/// A box whose side lies on a plane between wide cells and cells of a two-thousandth.
#[test]
fn a_box_that_ends_at_narrow_cells_cuts_none() {
    let program = Program::new();
    let scene = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/cases/box_on_narrow_cells.toml"
    );
    program
        .command(&["mesh", scene, "run.h5"])
        .assert()
        .success();
}
