//! `branches`: what it finds and refuses.

use std::process::{Command, Stdio};

use assert_cmd::cargo::CommandCargoExt;
use serde_json::Value;

use crate::program::{Program, pipeline};

const COEFFICIENT: &str = "friction.coefficient.constant";

fn scene(name: &str) -> String {
    let path = pipeline("hard").join(name);
    path.to_str().expect("plain path").to_owned()
}

fn json(output: &[u8]) -> Value {
    serde_json::from_slice(output).expect("JSON")
}

#[test]
fn one_node_has_three_solutions_beyond_its_fold() {
    let program = Program::new();
    let scene = scene("one_node.toml");
    let span = [
        "--parameter",
        COEFFICIENT,
        "--from",
        "0.5",
        "--to",
        "4",
        "--all",
        "--json",
    ];
    let arguments = [&["branches", scene.as_str(), "run.h5"], &span[..]].concat();
    let done = program.command(&arguments).assert().success();
    let said = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
    let first = "path 1, point 1: friction.coefficient.constant = 0.500000, normal force ";
    assert!(said.starts_with(first), "{said}");
    let found = json(&done.get_output().stdout);
    assert_eq!(
        found["solutions"][0]["solutions"].as_array().map(Vec::len),
        Some(1)
    );
    assert_eq!(
        found["solutions"][1]["solutions"].as_array().map(Vec::len),
        Some(3)
    );
    assert_eq!(
        (&found["solutions"][1]["degree"], &found["followed"]),
        (&1.into(), &true.into())
    );
    let paths = found["paths"].as_array().expect("paths");
    let points = paths
        .iter()
        .flat_map(|path| path["points"].as_array().expect("points"));
    let folds: Vec<f64> = points
        .filter(|point| point["kind"] == "fold at a kink")
        .map(|point| point["parameter"].as_f64().expect("a number"))
        .collect();
    // |λ_t|/λ_ν of the sticking node is 2 in this scene; located to 1e-13 of the range.
    assert!(
        folds.len() == 1 && (folds[0] - 2.0).abs() < 1e-12,
        "{folds:?}"
    );
    for picture in ["branches_normal_force", "branches_tangential_force"] {
        assert!(
            program
                .path(&format!("run-figures/{picture}.svg"))
                .is_file()
        );
    }
    program.command(&["check", "run.h5"]).assert().success();
    let page = ["report", "run.h5", "page.html"];
    program.command(&page).assert().success();
    let page = std::fs::read_to_string(program.path("page.html")).expect("a page");
    assert!(page.contains("Paths of solutions") && page.contains("Solutions over"));
    // Nothing is followed again.
    let again = program.command(&arguments).assert().success();
    assert_eq!(json(&again.get_output().stdout), found);
}

#[test]
fn what_cannot_be_followed_is_refused() {
    let program = Program::new();
    let one = scene("one_node.toml");
    let frictionless = pipeline("frictionless.toml");
    let frictionless = frictionless.to_str().expect("plain path");
    for (scene, key, from, to, said) in [
        (
            one.as_str(),
            "title",
            "1",
            "2",
            "expected a key whose value is a number, found the text",
        ),
        (&one, "friction", "1", "2", "found a table of keys"),
        (
            &one,
            COEFFICIENT,
            "-1",
            "2",
            "valid at every value of the range",
        ),
        (
            &one,
            COEFFICIENT,
            "1",
            "1",
            "a range between two different numbers",
        ),
        (
            &one,
            COEFFICIENT,
            "nan",
            "1",
            "a range between two different numbers",
        ),
        (&one, "friction.mu", "1", "2", "unknown"),
        (
            frictionless,
            "contact.gap",
            "0",
            "1e-5",
            "expected Coulomb friction",
        ),
    ] {
        let span = ["--parameter", key, "--from", from, "--to", to];
        let arguments = [&["branches", scene, "run.h5"], &span[..]].concat();
        let output = program.command(&arguments).output().expect("it runs");
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{key}: {text}");
        assert!(text.contains(said), "{key}: {text}");
        assert!(program.everything().is_empty(), "{key} left something");
    }
}

/// Of several at once on one file, those that find it busy take nothing from the one that has it.
#[test]
fn a_refused_search_leaves_the_folder_of_another_alone() {
    let program = Program::new();
    let scene = scene("one_node.toml");
    for round in 0..3 {
        let folder = format!("series{round}");
        let mut searches: Vec<_> = (0..3)
            .map(|_| {
                let mut command = Command::cargo_bin("contact3d-pipe").expect("built program");
                command
                    .current_dir(program.path("."))
                    .args(["branches", &scene, "run.h5", "--no-figures", "--quiet"])
                    .args(["--parameter", COEFFICIENT, "--from", "0.5", "--to", "2"])
                    .args(["--series", &folder])
                    .stderr(Stdio::piped())
                    .spawn()
                    .expect("a process")
            })
            .collect();
        let ends = searches
            .iter_mut()
            .map(|search| search.wait().expect("an end"));
        let ends: Vec<Option<i32>> = ends.map(|end| end.code()).collect();
        assert!(ends.contains(&Some(0)), "{ends:?}");
        assert!(
            ends.iter().all(|end| [Some(0), Some(2)].contains(end)),
            "{ends:?}"
        );
        assert!(program.path(&folder).join("path_1.vtkhdf").is_file());
    }
}

/// Where a full step ends above the certified residual, a shorter one does not: a beam above a floor, over its stiffness.
#[test]
fn a_path_of_a_slender_body_takes_shorter_steps() {
    let program = Program::new();
    let scene = "title = 'slender'
        body.brick = { size = [5.0, 0.5, 0.25], cells = [16, 2, 2] }
        material.isotropic = { young_modulus = 2e11, poisson_ratio = 0.3 }
        clamp = [{ face = 'x_min' }]
        traction = [{ face = 'x_max', value = [1e5, 2e3, -1e3] }]
        contact = { face = 'z_min', gap = 1e-5 }
        friction.coefficient.constant = 0.3";
    std::fs::write(program.path("scene.toml"), scene).expect("written");
    let key = "material.isotropic.young_modulus";
    let arguments = [
        &["branches", "scene.toml", "run.h5", "--no-figures", "--json"],
        &["--parameter", key, "--from", "1e11", "--to", "3e11"][..],
    ]
    .concat();
    let found = program.command(&arguments).assert().success();
    let points = json(&found.get_output().stdout);
    let last = points["paths"][0]["points"]
        .as_array()
        .expect("points")
        .last()
        .cloned();
    assert_eq!(last.expect("a point")["parameter"], 3e11);
}
