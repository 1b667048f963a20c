//! `accuracy` and `report` as a user meets them.

use serde_json::Value;

use crate::program::{Program, SMALL, pipeline};

const MESHES: [&str; 6] = ["--coarsest", "2", "--finest", "8", "--budget", "40"];

fn accuracy(program: &Program, more: &[&str]) -> assert_cmd::Command {
    let scene = pipeline("newton.toml");
    let scene = scene.to_str().expect("plain path");
    let mut command = program.command(&["accuracy", scene, "run.h5"]);
    command.args(SMALL).args(MESHES).args(more);
    command
}

#[test]
fn both_studies_are_stored_drawn_printed_and_advised_on() {
    let program = Program::new();
    let done = accuracy(&program, &[]).assert().success();
    let text = String::from_utf8_lossy(&done.get_output().stdout).into_owned();
    assert!(
        text.starts_with("At this mesh (12 x 4 x 4 cells)"),
        "{text}"
    );
    assert!(text.contains("Discretisation error") && !text.contains("Algebraic error"));
    assert!(text.trim_end().ends_with("--json list them"), "{text}");
    // The small meshes come first, so a first figure does too.
    let said = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
    let [small, solves, large] = [
        "6 x 2 x 2 cells: ",
        "reference solved",
        "24 x 8 x 8 cells: ",
    ]
    .map(|words| {
        said.find(words)
            .unwrap_or_else(|| panic!("{words}: {said}"))
    });
    assert!(small < solves && solves < large, "{said}");
    for name in ["work_precision", "convergence"] {
        for kind in ["svg", "png"] {
            assert!(program.path(&format!("run-figures/{name}.{kind}")).exists());
        }
    }
    let json = accuracy(&program, &["--json", "--no-figures"])
        .assert()
        .success();
    let json: Value = serde_json::from_slice(&json.get_output().stdout).expect("JSON");
    assert_eq!(json["levels"].as_array().map(Vec::len), Some(3));
    assert_eq!(json["solves"].as_array().map(Vec::len), Some(55));
}

/// Meshes up to the scene's own are solved whatever they take, finer ones as the budget allows. A mean has a column of its own, and the
/// page of a file whose scene has another box shows it.
#[test]
fn the_budget_bounds_meshes_and_the_wanted_mean_is_listed() {
    let program = Program::new();
    let scene = pipeline("newton.toml");
    let scene = scene.to_str().expect("plain path");
    let measure = |more: &[&str]| {
        let meshes = ["--finest", "4", "--json", "--no-figures"];
        let mut command = program.command(&["accuracy", scene, "run.h5", "--coarsest", "1"]);
        let set = [
            "--set",
            "body.brick.cells=[6,2,2]",
            "--set",
            "body.element=\"P2\"",
        ];
        let done = command.args(meshes).args(set).args(more).assert().success();
        let said = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
        let json: Value = serde_json::from_slice(&done.get_output().stdout).expect("JSON");
        (said, json)
    };
    let (said, json) = measure(&["--budget", "0.001"]);
    assert!(
        said.contains("no finer mesh: it is forecast to take"),
        "{said}"
    );
    assert_eq!(json["levels"].as_array().map(Vec::len), Some(2));
    let adapt = "adapt={error=0.5, of={mean_pressure={box=[[0, 0, 0], [1, 1, 0]]}}}";
    let (_, json) = measure(&["--budget", "20", "--set", adapt]);
    let means = json["levels"].as_array().expect("levels").iter();
    let means: Vec<f64> = means
        .filter_map(|level| level["mean_pressure"].as_f64())
        .collect();
    assert!(
        means.len() > 1 && means.iter().all(|mean| *mean > 0.0),
        "{json}"
    );
    let limits = json["limits"].as_array().expect("limits");
    assert_eq!(limits.last().expect("one")["name"], "mean_pressure");
    // The largest stress is at the rim of the clamp.
    let stress = limits.iter().find(|it| it["name"] == "largest_von_mises");
    assert_eq!(stress.expect("one")["concentration"], "clamp");
    program.run(&[]).assert().success();
    program.command(&["report", "run.h5"]).assert().success();
    let page = std::fs::read_to_string(program.path("report.html")).expect("a page");
    assert!(page.contains("mean pressure [Pa]"));
    assert!(page.contains("grows with every finer mesh at the rim of a clamp"));
}

#[test]
fn studies_and_run_share_a_file_and_leave_each_other_alone() {
    let program = Program::new();
    program.run(&[]).assert().success();
    let before = program.digests();
    let scene = pipeline("hkl2011_table1.toml");
    let scene = scene.to_str().expect("plain path");
    let measure = || {
        let mut command = program.command(&["accuracy", scene, "run.h5", "--no-figures"]);
        let few = ["--finest", "4", "--budget", "1"];
        command.args(SMALL).args(few).assert().success();
    };
    measure();
    assert_eq!(program.digests(), before);
    assert!(program.states().iter().all(|(_, state)| state == "fresh"));
    program.run(&[]).assert().success();
    let report = || {
        program.command(&["report", "run.h5"]).assert().success();
        std::fs::read_to_string(program.path("report.html")).expect("a page")
    };
    let page = report();
    assert!(page.contains("id=\"accuracy\"") && page.contains("id=\"panels\""));
    assert!(!page.contains("Measured for another scene"));
    program
        .run(&["--set", "solve.epsilon=1e-5"])
        .assert()
        .success();
    assert!(report().contains("Measured for another scene"));
}

#[test]
fn what_cannot_be_measured_or_reported_is_bad_input() {
    let program = Program::new();
    let refused = |mut command: assert_cmd::Command, words: &str| {
        let output = command.assert().code(2);
        let text = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
        assert!(text.contains(words), "{text}");
    };
    refused(
        accuracy(&program, &["--set", "body.brick.cells=[18,6,6]"]),
        "a multiple of 6",
    );
    assert!(!program.path("run.h5").exists());
    let scene = pipeline("newton.toml");
    let scene = scene.to_str().expect("plain path");
    let budget = program.command(&["accuracy", scene, "run.h5", "--budget", "-1"]);
    refused(budget, "seconds from 1e-3 to 1e9");
    refused(program.command(&["report", "absent.h5"]), "absent.h5");
    refused(program.command(&["report", "."]), "summary.h5");
}

/// Pushed three times beyond friction, the body has no equilibrium on any mesh, and no error.
#[test]
fn meshes_without_a_solution_have_no_error() {
    let program = Program::new();
    let scene = r#"
title = "pushed block"
[body.brick]
size = [1.0, 1.0, 1.0]
cells = [2, 2, 2]
[material.isotropic]
young_modulus = 1e9
poisson_ratio = 0.3
[body_force]
value = [1e4, 0.0, -1e4]
[contact]
face = "z_min"
[friction]
coefficient.constant = 0.3
"#;
    std::fs::write(program.path("scene.toml"), scene).expect("a scene");
    let meshes = ["--coarsest", "2", "--finest", "4", "--no-figures"];
    let mut command = program.command(&["accuracy", "scene.toml", "run.h5"]);
    let done = command.args(meshes).assert().code(1);
    let [out, err] = [&done.get_output().stdout, &done.get_output().stderr];
    let text = [out, err]
        .map(|text| String::from_utf8_lossy(text))
        .concat();
    assert!(text.contains("no solution (no_equilibrium)"), "{text}");
    assert!(
        !text.contains("0.00 %") && !text.contains("at least 0"),
        "{text}"
    );
}

/// The edges of a mesh file are halved while the unknowns allow it.
#[test]
fn meshes_of_files_are_cut_and_have_their_own_limits() {
    let program = Program::new();
    let scene = pipeline("gmsh_foot.toml");
    let command = |more: &[&str]| {
        let scene = scene.to_str().expect("plain path");
        let mut command = program.command(&["accuracy", scene, "run.h5", "--budget", "20"]);
        command.args(more);
        command
    };
    for (options, words) in [
        (
            ["--finest", "8"],
            "--finest: expected a body that is one brick",
        ),
        (
            ["--coarsest", "2"],
            "--coarsest: expected a body that is one brick",
        ),
    ] {
        let refused = command(&options).assert().code(2);
        let text = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        assert!(text.contains(words), "{text}");
        assert!(!program.path("run.h5").exists());
    }
    let done = command(&["--unknowns", "5000", "--json"])
        .assert()
        .success();
    let said = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
    assert!(
        said.contains("no finer mesh: expected at most 5000 unknowns"),
        "{said}"
    );
    let json: Value = serde_json::from_slice(&done.get_output().stdout).expect("JSON");
    let advice = json["advice"].as_str().expect("words");
    assert!(advice.starts_with("At this mesh (573 tetrahedra)") && !advice.contains("n_div"));
    let [own, finer] = [0, 1].map(|level| &json["levels"][level]);
    assert!(own["n_div"].is_null() && own["contact_area"].is_null());
    assert!(finer["contact_area"].is_number() && finer["stick_area_order"].is_null());
    assert!(finer["size"].as_f64() < own["size"].as_f64());
    program.command(&["report", "run.h5"]).assert().success();
    let page = std::fs::read_to_string(program.path("report.html")).expect("a page");
    assert!(page.contains("573 tetrahedra") && page.contains("largest von Mises stress [Pa]"));
}
