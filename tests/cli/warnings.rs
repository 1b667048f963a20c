//! What is allowed and probably not meant; parameters on the command line.

use std::fs;

use serde_json::Value;

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

/// A sleeve that is thicker than its ring by less than their triangles leave of the circles.
#[test]
fn bodies_that_overlap_unasked_are_told_of() {
    let program = Program::new();
    let scene = pipeline("two_rings.toml");
    let mut command = program.command(&["run", scene.to_str().unwrap(), "run.h5", "--no-figures"]);
    for change in ["body.1.gmsh.unit=0.9975137", "contact.interference=false"] {
        command.args(["--set", change]);
    }
    let done = command.assert().success();
    let text = String::from_utf8_lossy(&done.get_output().stderr);
    assert!(text.contains("are taken to touch"), "{text}");
}

#[test]
fn a_tool_to_follow_without_steps_is_told_of() {
    let program = Program::new();
    let scene = pipeline("barrel.toml");
    let warned = |changes: &[&str]| {
        let command = &["run", scene.to_str().unwrap(), "run.h5", "--no-figures"];
        let mut command = program.command(command);
        command.args(["--set", "body.brick.cells=[4,4,2]"]);
        for change in changes {
            command.args(["--set", change]);
        }
        let done = command.assert().success();
        let text = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
        text.contains("contact.follow: without a [[step]]")
    };
    let follow = "contact.follow=\"increment\"";
    assert!(!warned(&[]) && warned(&[follow]));
    // Nor where increments have scenes of their own, which follow and have no steps.
    assert!(!warned(&[follow, "step=[{title=\"press\", increments=2}]"]));
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
    // Three panes are too few for whatever happens on them, and it says so.
    let narrow = text.matches("beside open ones").count();
    assert_eq!(text.matches("warning").count(), 1 + narrow, "{text}");
    // The file tells both whenever it is asked.
    let status = program.command(&["status", "run.h5", "--json"]).output();
    let status: serde_json::Value = serde_json::from_slice(&status.unwrap().stdout).unwrap();
    let told = status["results"]["warnings"].as_array().unwrap();
    assert_eq!(told.len(), 1 + narrow, "{status}");
    let first = told[0].as_str().unwrap();
    assert!(format!("warning: {first}").starts_with(warning), "{status}");
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
    assert!(!text.contains("does nothing"), "{text}");
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

/// A clamped body without a load.
#[test]
fn a_scene_in_which_nothing_moves_is_warned_of() {
    let program = Program::new();
    let warning = "warning: nothing moves: no load acts on displacements that are free";
    let text = run(&program, "elastic_only.toml", &["traction=[]"]);
    assert_eq!(text.matches(warning).count(), 1, "{text}");
    let text = run(&program, "elastic_only.toml", &[]);
    assert!(!text.contains("nothing moves"), "{text}");
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

/// Runs a scene to `run.h5`, whatever comes of it; its exit code, and what it said.
fn scene(text: &str, more: &[&str]) -> (Option<i32>, String) {
    let program = Program::new();
    fs::write(program.path("scene.toml"), text).unwrap();
    let mut command = program.command(&["run", "scene.toml", "run.h5", "--no-figures"]);
    let done = command.args(more).output().unwrap();
    let said = [done.stderr, done.stdout].concat();
    (
        done.status.code(),
        String::from_utf8_lossy(&said).into_owned(),
    )
}

const PAD: &str = r#"
title = "pad"
[body.brick]
size = [10.0, 10.0, 1.0]
cells = [4, 4, 2]
[material.isotropic]
young_modulus = 1e6
poisson_ratio = 0.3
[contact]
face = "z_min"
[[clamp]]
face = "z_max"
"#;

/// A layer squeezed by 20 %: a strain of 0.2 m / 1 m, with displacements of 1.4 % of the body.
#[test]
fn large_strains_are_warned_of() {
    let (code, text) = scene(PAD, &["--set", "clamp.0.value=[0.0, 0.0, -0.2]"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("warning: strains reach 2"), "{text}");
    let (_, text) = scene(PAD, &["--set", "clamp.0.value=[0.0, 0.0, -0.01]"]);
    assert!(!text.contains("warning"), "{text}");
}

/// A ball that presses a layer and slides over it is judged where it does, with the figures of a scene that ends there, though the layer is let
/// go in the end.
#[test]
fn histories_are_judged_where_they_are_loaded_most() {
    let ball = "contact.obstacle.sphere={ centre=[5.0, 5.0, -4.0], radius=4.0 }";
    let sets = [
        "clamp.0.name=\"lid\"",
        ball,
        "clamp.0.value=[0.3, 0.0, -0.25]",
        "contact.multipliers=\"nodal\"",
        "friction.coefficient.constant=0.1",
    ];
    let run = |steps: &str| {
        let sets = sets.iter().chain([&steps]).flat_map(|it| ["--set", it]);
        scene(PAD, &sets.collect::<Vec<_>>()).1
    };
    let pressed = run("step=[{}]");
    let released = run("step=[{}, {value={lid=[0.0, 0.0, 1.0]}}]");
    let told = |text: &str, from: &str, to: &str| {
        let lines = text.lines().find(|line| line.contains(from));
        let words = lines.and_then(|line| line.split_once(from)?.1.split_once(to));
        words.map(|(words, _)| words.to_owned())
    };
    for (from, to, rest) in [
        ("strains reach ", ",", " in increment 1 of 2 (step 1)"),
        ("error of the mesh ", " in the energy norm", ""),
        ("energy norm", ", a rough", " in increment 1 of 2 (step 1)"),
        (
            "warning: 100 % of the normal force",
            " is on",
            " in increment 1 of 2 (step 1)",
        ),
        ("it slips by ", " of the radius", ""),
    ] {
        let expected = told(&pressed, from, to).map(|words| words + rest);
        assert!(expected.is_some(), "{from}: {pressed}");
        assert_eq!(told(&released, from, to), expected, "{released}");
    }
    assert!(!released.contains("no pane"), "{released}");
    assert_eq!(released.matches("warning").count(), 3, "{released}");
}

/// F = 0.1 + 0.5/m · s bears a push of 0.3 of the pressure after a slide of 0.4 m: of 1.5 m, the block's diagonal, 27 %.
#[test]
fn slides_far_from_where_contact_began_are_warned_of() {
    let block = r#"
title = "pushed until friction has risen"
body.brick = { size = [1.0, 1.0, 0.5], cells = [4, 4, 2] }
material.isotropic = { young_modulus = 3e10, poisson_ratio = 0.2 }
pressure = [{ face = "z_max", value = 1e6 }]
traction = [{ face = "z_max", value = [3e5, 0.0, 0.0] }]
contact.face = "z_min"
friction.coefficient.ramp = { initial = 0.1, residual = 0.9, onset = 0.0, rate = 0.5 }
"#;
    let (code, text) = scene(block, &[]);
    assert_eq!(code, Some(0), "{text}");
    assert!(
        text.contains("warning: the body slides by 27 % of its size"),
        "{text}"
    );
    let force = "friction force       300 kN, 100 % of what friction can bear";
    assert!(text.contains(force), "{text}");
    // At a constant coefficient of 0.4 it holds, with three quarters of its friction.
    let ramp =
        "friction.coefficient.ramp = { initial = 0.1, residual = 0.9, onset = 0.0, rate = 0.5 }";
    let (_, text) = scene(
        &block.replace(ramp, "friction.coefficient.constant = 0.4"),
        &[],
    );
    assert!(
        text.contains("300 kN, 75 % of what friction can bear"),
        "{text}"
    );
    assert!(!text.contains("slides"), "{text}");
    // Pressed alone it spreads to all sides, and no force is left of what panes bear.
    let pressed = block.replace("[3e5, 0.0, 0.0]", "[0.0, 0.0, 0.0]");
    let (_, text) = scene(&pressed, &[]);
    assert!(text.contains("0 % of what friction can bear, "), "{text}");
    assert!(
        text.contains(" % on panes, which oppose each other"),
        "{text}"
    );
    // Within 3e-8 of what friction bears it slides by millimetres, a thousand times what it deforms by.
    let limit = block.replace(ramp, "friction.coefficient.constant = 0.30000001");
    let (_, text) = scene(&limit, &[]);
    assert!(text.contains("warning: the body slides by 0."), "{text}");
}

/// A push of 0.2 m along a ball of 2 m turns the normal by 0.1, nearly 6 degrees.
#[test]
fn slips_beyond_a_twentieth_of_a_radius_are_warned_of() {
    let ball = "contact.obstacle.sphere={ centre=[5.0, 5.0, -2.0], radius=2.0 }";
    let sets = |along: &str| format!("clamp.0.value=[{along}, 0.0, -0.05]");
    let friction = "friction.coefficient.constant=0.1";
    let run = |along: &str| {
        let clamp = sets(along);
        let nodal = "contact.multipliers=\"nodal\"";
        scene(
            PAD,
            &[
                "--set", ball, "--set", friction, "--set", &clamp, "--set", nodal,
            ],
        )
    };
    let (code, text) = run("0.2");
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("of the radius of its obstacle"), "{text}");
    let (_, text) = run("0.01");
    assert!(!text.contains("of the radius of its obstacle"), "{text}");
}

/// The quadrature of the first mesh sees a load of 3.89e7 N on each square metre where the formula has 4.00e7.
#[test]
fn loads_that_the_mesh_does_not_resolve_are_warned_of() {
    let load = |formula: &str| format!("pressure=[{{face=\"x_max\", value=\"{formula}\"}}]");
    let clamp = "clamp.0.value=[0.0, 0.0, -0.001]";
    let (_, text) = scene(
        PAD,
        &[
            "--set",
            clamp,
            "--set",
            &load("2e2*(1+sin(40*z)*sin(37*y))"),
        ],
    );
    assert!(
        text.contains("warning: pressure.0.value: it varies inside triangles"),
        "{text}"
    );
    let (_, text) = scene(PAD, &["--set", clamp, "--set", &load("2e2*(1+z*y)")]);
    assert!(!text.contains("warning"), "{text}");
}

/// Steel has 2.1e5 N/mm², and nothing has 2.1e11.
#[test]
fn moduli_in_pascals_with_lengths_in_millimetres_are_warned_of() {
    let mm = [
        "--set",
        "units.length=\"mm\"",
        "--set",
        "clamp.0.value=[0.0, 0.0, -0.001]",
    ];
    let run = |modulus: &str| {
        let set = format!("material.isotropic.young_modulus={modulus}");
        scene(PAD, &[&mm[..], &["--set", &set]].concat()).1
    };
    let text = run("2.1e11");
    assert!(
        text.contains("warning: material.isotropic.young_modulus: stiffer"),
        "{text}"
    );
    assert!(!run("2.1e5").contains("warning"));
}

/// Steel in N/mm² on a pad of 10: in Pa and metres that would be a gel as large as a house.
#[test]
fn millimetres_without_a_word_are_warned_of() {
    let steel = "material.isotropic.young_modulus=2.1e5";
    let clamp = "clamp.0.value=[0.0, 0.0, -0.001]";
    let (_, text) = scene(PAD, &["--set", steel, "--set", clamp]);
    assert!(text.contains("write units.length = \"mm\""), "{text}");
    assert!(text.contains("10 × 10 × 1 m, "), "{text}");
    let (_, text) = scene(PAD, &["--set", clamp]);
    assert!(!text.contains("warning"), "{text}");
}

/// A force beyond a sixth of the width from the middle of a face: its linear traction ends with the other sign.
#[test]
fn forces_that_draw_a_part_of_their_face_are_warned_of() {
    let run = |x: &str| {
        let sets = [
            "clamp=[]".to_owned(),
            format!("force=[{{face=\"z_max\", value=[0.0, 0.0, -1e3], point=[{x}, 5.0, 1.0]}}]"),
            "contact.multipliers=\"nodal\"".to_owned(),
        ];
        let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
        scene(PAD, &sets).1
    };
    let warning = "warning: force.0.point: so far from the middle";
    assert!(run("6.8").contains(warning));
    assert!(!run("6.5").contains(warning));
}

/// 1 N on a steel block of 80 m, which was meant in millimetres: strains below 1e-10.
#[test]
fn bodies_that_hardly_strain_are_warned_of() {
    let (_, text) = scene(PAD, &["--set", "clamp.0.value=[0.0, 0.0, -1e-11]"]);
    assert!(
        text.contains("warning: strains are no more than 1"),
        "{text}"
    );
    let (_, text) = scene(PAD, &["--set", "clamp.0.value=[0.0, 0.0, -1e-7]"]);
    assert!(!text.contains("strains are no more"), "{text}");
}

/// Two blocks of which one stands on a foundation of its own: nothing keeps it out of the other.
#[test]
fn bodies_without_contact_are_warned_of() {
    let program = Program::new();
    let pair = pipeline("two_blocks.toml");
    let said = |contact: &str| {
        let mut command = program.command(&["mesh", pair.to_str().unwrap(), "run.h5"]);
        command.args(["--set", contact, "--set", "step=[]"]);
        let done = command.output().unwrap();
        String::from_utf8_lossy(&done.stderr).into_owned()
    };
    let warning = "body \"steel\": no contact names it";
    let text = said("contact={face=\"aluminium.z_min\"}");
    assert!(text.contains(warning), "{text}");
    let text = said("contact={between=[\"aluminium.z_min\", \"steel.z_max\"]}");
    assert!(!text.contains(warning), "{text}");
}

/// A mesh that was refined for an error is not thrown away in silence; what is read of a file later is what the run said.
#[test]
fn refined_meshes_are_told_of_before_they_go_and_read_as_they_were() {
    let program = Program::new();
    let pad = PAD.replace(
        "[contact]",
        "[contact.obstacle.sphere]\ncentre = [4.0, 5.0, -30.0]\nradius = 30.0\n[contact]",
    );
    fs::write(program.path("scene.toml"), pad).unwrap();
    let run = |more: &[&str]| {
        let mut command = program.command(&["run", "scene.toml", "run.h5", "--no-figures"]);
        command.args([
            "--set",
            "clamp.0.value=[0.0, 0.0, -0.1]",
            "--set",
            "body.element=\"P2\"",
        ]);
        command.args(more).output().unwrap()
    };
    let first = run(&["--error", "40%", "--json"]);
    let first: Value = serde_json::from_slice(&first.stdout).unwrap();
    let status = program
        .command(&["status", "run.h5", "--json"])
        .output()
        .unwrap();
    let later: Value = serde_json::from_slice(&status.stdout).unwrap();
    let largest = |json: &Value| json["largest_von_mises"].clone();
    assert!(largest(&first)["error"].as_f64().unwrap() > 0.0, "{first}");
    assert_eq!(largest(&first), largest(&later["results"]));
    let text = String::from_utf8_lossy(&run(&[]).stderr).into_owned();
    assert!(
        text.contains("that --error had refined is replaced"),
        "{text}"
    );
    let text = String::from_utf8_lossy(&run(&[]).stderr).into_owned();
    assert!(!text.contains("is replaced"), "{text}");
}

/// A ball whose contact is a ring of four panes, three panes across, or fills the face and has panes within.
#[test]
fn contact_as_narrow_as_panes_is_warned_of() {
    let run = |radius: &str, down: &str, cells: usize| {
        let ball =
            format!("contact.obstacle.sphere={{ centre=[5.0, 5.0, -{radius}], radius={radius} }}");
        let clamp = format!("clamp.0.value=[0.0, 0.0, -{down}]");
        let cells = format!("body.brick.cells=[{cells}, {cells}, 2]");
        scene(PAD, &["--set", &ball, "--set", &clamp, "--set", &cells]).1
    };
    let warning = "100 % of the normal force is on panes beside open ones";
    let text = run("30.0", "0.03", 16);
    assert!(text.contains(warning), "{text}");
    // 79 % in the energy norm: no figure stands alone, and what friction has is not spoken of.
    for figure in [
        "normal force",
        "largest pressure",
        "largest von Mises",
        "largest displacement",
    ] {
        let mut lines = text.lines();
        let line = lines.find(|line| line.trim_start().starts_with(figure));
        let is_told = line.is_some_and(|line| line.ends_with(", not resolved: refine the mesh"));
        assert!(is_told, "{figure} {text}");
    }
    assert!(text.contains("contact area         not resolved"), "{text}");
    assert!(!text.contains("stick area"), "{text}");
    let cures = [
        "run ... --error 5% refines",
        "multipliers = \"nodal\" sees more",
    ];
    assert!(cures.iter().all(|cure| text.contains(cure)), "{text}");
    // The middle one of nine panes bears a fifth.
    let text = run("100.0", "0.02", 18);
    assert!(text.contains("79 % of the normal force"), "{text}");
    // A pane whose mean is open: what is left of displacements is rounding, neither stress nor a unit.
    let text = run("8.0", "0.3", 4);
    assert!(
        text.contains("0 Pa, not resolved: refine the mesh"),
        "{text}"
    );
    assert!(!text.contains("Mises") && !text.contains("units"), "{text}");
    let text = run("100.0", "0.05", 16);
    assert!(!text.contains("beside open ones"), "{text}");
}

/// A ball beside the layer that falls until its side, which gaps know as a plane, meets the edge.
#[test]
fn a_tool_that_moves_too_far_is_warned_of() {
    let run = |x: &str| {
        let ball = format!("contact.obstacle.sphere={{ centre=[{x}, 5.0, -4.0], radius=4.0 }}");
        let tool = "tool=[{ name=\"ball\", free=[\"z\"], force=[0.0, 0.0, 1e3] }]";
        let sets = [
            "contact.tool=\"ball\"",
            &ball,
            tool,
            "body.brick.cells=[8, 8, 2]",
        ];
        let sets = sets.iter().flat_map(|set| ["--set", set]);
        scene(PAD, &sets.collect::<Vec<_>>()).1
    };
    let warning = "the tool ball moves by";
    let text = run("13.9");
    assert!(text.contains(warning), "{text}");
    let text = run("5.0");
    assert!(!text.contains(warning), "{text}");
}

/// A block on a foot of one pane, its load 3 mm beside the axis and the foot 60 mm wide: within 60 mm / 6, so it stands
/// with the whole foot pressed.
#[test]
fn a_pane_that_cannot_hold_the_body_is_no_proof_and_is_refined() {
    let peg = r#"
title = "peg"
[body.brick]
size = [0.06, 0.06, 0.05]
cells = [2, 2, 2]
[material.isotropic]
young_modulus = 2.1e11
poisson_ratio = 0.3
[contact]
face = "z_min"
[friction]
coefficient.constant = 0.4
[[pressure]]
face = "z_max"
value = "1e6*(1 + 10*(x - 0.03))"
"#;
    let (code, text) = scene(peg, &[]);
    assert_eq!(code, Some(1), "{text}");
    assert!(
        text.contains("no proof that contact cannot hold the body"),
        "{text}"
    );
    let (code, text) = scene(peg, &["--error", "20%"]);
    assert_eq!(code, Some(0), "{text}");
}
