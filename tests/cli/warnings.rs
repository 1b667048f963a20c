//! What is allowed and probably not meant; parameters on the command line.

use std::fs;

use crate::program::{Program, SMALL, pipeline};

/// Runs a pipeline with changes to `run.h5`; what it said on standard error.
fn run(program: &Program, scene: &str, changes: &[&str]) -> String {
    let scene = pipeline(scene);
    let mut command = program.command(&["run", scene.to_str().unwrap(), "run.h5", "--no-figures"]);
    command.arg("-v").args(SMALL);
    for change in changes {
        command.args(["--set", change]);
    }
    let done = command.assert().success();
    String::from_utf8_lossy(&done.get_output().stderr).into_owned()
}

fn states(program: &Program) -> Vec<String> {
    program
        .states()
        .into_iter()
        .map(|(_, state)| state)
        .collect()
}

#[test]
fn loads_on_held_displacements_are_warned_of() {
    let program = Program::new();
    let clamps = "clamp=[{face=\"x_min\"}, {face=\"z_max\", components=[\"x\", \"z\"]}]";
    let text = run(&program, "newton.toml", &[clamps]);
    let warning = "warning: traction.1.value: its part along z does nothing";
    assert_eq!(text.matches(warning).count(), 1, "{text}");
    assert_eq!(text.matches("warning").count(), 1, "{text}");
    // Also when only the loads are new, and not after the advice was followed.
    let text = run(
        &program,
        "newton.toml",
        &[clamps, "traction.1.value=[0.0, 1e6, -1e6]"],
    );
    assert!(
        text.contains("mesh      fresh") && text.contains(warning),
        "{text}"
    );
    let text = run(
        &program,
        "newton.toml",
        &[clamps, "traction.1.value=[0.0, 1e6, 0.0]"],
    );
    assert!(!text.contains("warning"), "{text}");
}

/// A foundation 1 m below the block, as of an obstacle in a wrong unit: the answer is right, and says what it is not.
#[test]
fn a_face_that_touches_nothing_is_warned_of() {
    let program = Program::new();
    let text = run(&program, "newton.toml", &["contact.gap=1.0"]);
    let warning = "warning: no pane is in contact, the smallest gap left is ";
    assert_eq!(text.matches(warning).count(), 1, "{text}");
    let text = run(&program, "newton.toml", &[]);
    assert!(!text.contains("no pane is in contact"), "{text}");
}

#[test]
fn parameters_that_no_formula_uses_are_warned_of() {
    let program = Program::new();
    let text = run(&program, "newton.toml", &["parameters.mo=0.3"]);
    assert!(
        text.contains("warning: parameters.mo: no formula uses it"),
        "{text}"
    );
    let text = run(&program, "parameters.toml", &[]);
    assert!(!text.contains("warning"), "{text}");
}

#[test]
fn stages_are_run_again_where_their_formulas_use_a_parameter() {
    let program = Program::new();
    run(&program, "parameters.toml", &[]);
    assert_eq!(states(&program), ["fresh"; 5]);
    let kept = |text: &str| text.matches("fresh, kept").count();
    for (change, expected) in [
        ("parameters.mu=0.29", 3),
        ("parameters.pull=1.9e7", 2),
        ("parameters.crown=3e-6", 2),
        ("parameters.unused=1.0", 5),
    ] {
        run(&program, "parameters.toml", &[]);
        let text = run(&program, "parameters.toml", &[change]);
        assert_eq!(kept(&text), expected, "{change}: {text}");
    }
    let turned = ["contact.angle=\"turn*x\"", "parameters.turn=5.0"];
    run(&program, "parameters.toml", &turned);
    let text = run(
        &program,
        "parameters.toml",
        &[turned[0], "parameters.turn=6.0"],
    );
    assert_eq!(kept(&text), 1, "{text}");
}

#[test]
fn scenes_without_parameters_store_none() {
    let program = Program::new();
    run(&program, "newton.toml", &[]);
    let before = program.digests();
    let scene = fs::read_to_string(pipeline("newton.toml")).unwrap();
    fs::write(
        program.path("empty.toml"),
        format!("{scene}\n[parameters]\n"),
    )
    .unwrap();
    let mut command = program.command(&["run", "empty.toml", "run.h5", "--no-figures", "-v"]);
    let done = command.args(SMALL).assert().success();
    let text = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
    assert_eq!(text.matches("fresh, kept").count(), 5, "{text}");
    assert_eq!(program.digests(), before);
}
