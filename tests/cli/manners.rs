//! `init`, `completions`, `man`, `--version`, and hints for mistyped words.

use std::fs;

use crate::program::Program;

fn printed(program: &Program, arguments: &[&str]) -> String {
    let output = program.command(arguments).output().unwrap();
    assert!(output.status.success(), "{arguments:?}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_scene_to_start_from_runs_and_is_never_overwritten() {
    let program = Program::new();
    printed(&program, &["init", "block.toml"]);
    printed(&program, &["run", "block.toml", "block.h5", "--no-figures"]);
    let before = program.everything();
    program.command(&["init", "block.toml"]).assert().code(2);
    assert!(program.everything() == before);
}

/// Each kind of scene solves as it was written, once a part from Gmsh has its mesh and names.
#[test]
fn every_kind_of_scene_to_start_from_runs() {
    let program = Program::new();
    printed(&program, &["init", "loop.toml", "--kind", "history"]);
    let small = ["--set", "body.brick.cells=[6, 2, 2]", "--no-figures"];
    printed(
        &program,
        &[&["run", "loop.toml", "loop.h5"], &small[..]].concat(),
    );
    let init = program
        .command(&["init", "block.toml", "--kind", "sweep"])
        .assert()
        .success();
    let said = String::from_utf8_lossy(&init.get_output().stderr).into_owned();
    let (_, next) = said
        .split_once("go on with: contact3d-pipe sweep ")
        .unwrap();
    let next: Vec<&str> = next.split_whitespace().collect();
    let plan = [&["sweep", "plan"], &next[..]].concat();
    let plan: serde_json::Value = serde_json::from_str(&printed(&program, &plan)).unwrap();
    assert_eq!(plan.as_array().map_or(0, Vec::len), 12, "{plan}");
    let mesh = concat!(env!("CARGO_MANIFEST_DIR"), "/pipelines/meshes/foot.msh");
    fs::copy(mesh, program.path("foot.msh")).unwrap();
    let shown = printed(&program, &["inspect", "foot.msh", "--scene", "foot.toml"]);
    assert!(
        shown.contains("held end") && shown.contains("rubber"),
        "{shown}"
    );
    let linear = ["--set", "body.element=\"P1\"", "--no-figures"];
    printed(
        &program,
        &[&["run", "foot.toml", "foot.h5"], &linear[..]].concat(),
    );
    program
        .command(&["inspect", "foot.msh", "--scene", "foot.toml"])
        .assert()
        .code(2);
    let picture = fs::read_to_string(program.path("foot-mesh/mesh.svg")).unwrap();
    for word in ["foot.msh", "contact", "held end", "from below"] {
        assert!(picture.contains(word), "{word}");
    }
    let other = fs::read(program.path("foot-mesh/mesh.png")).unwrap();
    assert!(other.starts_with(b"\x89PNG"));
    program.command(&["inspect", "none.msh"]).assert().code(2);
}

/// A round block touches with its curved bottom, and on a plane below it; its scene runs.
#[test]
fn a_scene_for_a_round_part_touches_with_its_curved_face() {
    let program = Program::new();
    let mesh = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/pipelines/meshes/round_block.msh"
    );
    let quiet = ["--scene", "round.toml", "--no-figures"];
    printed(&program, &[&["inspect", mesh], &quiet[..]].concat());
    assert!(!program.path("round_block-mesh").exists());
    let scene = fs::read_to_string(program.path("round.toml")).unwrap();
    for line in [
        "title = \"round_block.msh\"",
        "face = \"z_max\"\nvalue",
        "face = \"round\"\nobstacle.half_space",
        "# obstacle.sphere = { centre = [5.0, 5.0, -10.0], radius = 10.0 }",
        "# The mesh is 10 x 10 x 10: is that mm?",
    ] {
        assert!(scene.contains(line), "{line}: {scene}");
    }
    let said = printed(&program, &["run", "round.toml", "round.h5", "--no-figures"]);
    assert!(!said.contains("no pane is in contact"), "{said}");
}

/// Volumes that share no nodes are bodies, which touch where faces of theirs lie on each other.
#[test]
fn volumes_without_common_nodes_are_bodies() {
    let program = Program::new();
    let mesh = concat!(env!("CARGO_MANIFEST_DIR"), "/pipelines/meshes/bolt.msh");
    let asked = ["inspect", mesh, "--scene", "bolt.toml", "--no-figures"];
    let shown = printed(&program, &asked);
    assert!(shown.contains("bodies, no nodes shared"), "{shown}");
    let scene = fs::read_to_string(program.path("bolt.toml")).unwrap();
    // Quadratic elements read meshes of either order.
    for part in ["[[body]]", "element = \"P2\""] {
        assert_eq!(scene.matches(part).count(), 3, "{scene}");
    }
    let pairs: Vec<&str> = scene.lines().filter(|it| it.contains("between")).collect();
    let expected = [
        "between = [\"bolt.under_head\", \"upper.top\"]",
        "between = [\"upper.joint\", \"lower.joint\"]",
    ];
    assert_eq!(pairs, expected);
    assert!(scene.contains("face = \"bolt.end\"\n") && scene.contains("face = \"upper.rim\"\n"));
    printed(&program, &["mesh", "bolt.toml", "bolt.h5"]);
}

/// Forces are named as the scene names them, and what is rounding beside them is 0.
#[test]
fn printed_forces_have_names_and_no_noise() {
    let program = Program::new();
    printed(&program, &["init", "loop.toml", "--kind", "history"]);
    let small = ["-v", "--set", "body.brick.cells=[6, 2, 2]", "--no-figures"];
    let said = printed(
        &program,
        &[&["run", "loop.toml", "loop.h5"], &small[..]].concat(),
    );
    let of = |name: &str| -> Vec<f64> {
        let mut lines = said
            .lines()
            .filter_map(|line| line.trim().strip_prefix(name));
        let numbers = lines.next().expect("a force").trim();
        let numbers = numbers.trim_start_matches('(').trim_end_matches(") MN");
        numbers
            .split(", ")
            .map(|part| part.parse().expect("a number"))
            .collect()
    };
    assert_eq!(of("force of weight (pressure.0)"), [0.0, 0.0, -60.0]);
    // Block and loads are mirrored in y.
    assert_eq!(of("force of contact")[1], 0.0);
    let refused = ["accuracy", "loop.toml", "other.h5", "--coarsest", "0"];
    program.command(&refused).assert().code(2);
}

/// The figures of a mesh file against those of its run: volume, and the area of the face that touches.
#[test]
fn a_mesh_file_is_shown_as_it_is() {
    let program = Program::new();
    let mesh = concat!(env!("CARGO_MANIFEST_DIR"), "/pipelines/meshes/foot.msh");
    let shown = printed(&program, &["inspect", mesh, "--json"]);
    let shown: serde_json::Value = serde_json::from_str(&shown).unwrap();
    assert_eq!(shown["n_tetrahedra"], 573);
    let faces = shown["faces"].as_array().unwrap();
    let normals: Vec<_> = faces
        .iter()
        .filter_map(|face| face["normal"].as_array())
        .collect();
    assert!(normals.iter().any(|normal| normal[2] == -1.0), "{faces:?}");
    let parts = shown["parts"].as_array().unwrap();
    let volumes: f64 = parts
        .iter()
        .filter_map(|part| part["volume"].as_f64())
        .sum();
    // Sums of the same tetrahedra in another order.
    assert!((volumes / shown["volume"].as_f64().unwrap() - 1.0).abs() < 1e-12);
}

#[test]
fn every_command_has_a_page_and_a_completion() {
    let program = Program::new();
    printed(&program, &["man", "pages"]);
    let script = printed(&program, &["completions", "bash"]);
    let help = printed(&program, &["--help"]);
    let (_, commands) = help.split_once("Commands:").expect("a list of commands");
    let (commands, _) = commands.split_once("\n\n").expect("an end of the list");
    // Lines that go on with a meaning are indented further.
    let begun = commands.lines().filter_map(|line| line.strip_prefix("  "));
    let begun = begun.filter(|line| !line.starts_with(' '));
    let names = begun.filter_map(|line| line.split_whitespace().next());
    let mut seen = 0;
    for name in names.filter(|name| *name != "help") {
        let path = program
            .path("pages")
            .join(format!("contact3d-pipe-{name}.1"));
        let page = fs::read_to_string(&path).unwrap_or_default();
        assert!(
            page.contains(&format!(".TH contact3d-pipe-{name} 1")),
            "{name}"
        );
        assert!(script.contains(name), "{name}");
        seen += 1;
    }
    assert!(seen > 15, "{seen} commands in {commands}");
    // Pages of our own are written again; another file of that name is not.
    printed(&program, &["man", "pages"]);
    fs::write(program.path("pages").join("contact3d-pipe-run.1"), "mine").unwrap();
    program.command(&["man", "pages"]).assert().code(2);
}

#[test]
fn the_version_names_hdf5() {
    let program = Program::new();
    let long = printed(&program, &["--version"]);
    assert!(long.starts_with(concat!("contact3d-pipe ", env!("CARGO_PKG_VERSION"), "\n")));
    assert!(long.contains("\nHDF5 "), "{long}");
    assert_eq!(
        printed(&program, &["-V"]),
        concat!("contact3d-pipe ", env!("CARGO_PKG_VERSION"), "\n")
    );
}

#[test]
fn mistyped_words_are_answered_with_the_nearest_one() {
    let program = Program::new();
    let said = |arguments: &[&str]| {
        let output = program.command(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    printed(&program, &["init", "block.toml"]);
    assert!(said(&["stauts", "block.h5"]).contains("'status'"));
    let key = said(&["mesh", "block.toml", "run.h5", "--set", "contact.gapp=1e-5"]);
    assert!(key.contains("did you mean `gap`?"), "{key}");
}

/// Every command takes what it reads and then what it writes, and the message about another order shows it.
#[test]
fn outputs_come_after_inputs() {
    let program = Program::new();
    for (arguments, usage) in [
        (
            &["run", "block.toml", "-o", "block.h5"][..],
            "<SCENE> <FILE>",
        ),
        (
            &["sweep", "sweep.toml", "--out", "cases"],
            "<SWEEP> <FOLDER>",
        ),
        (&["sweep", "sweep.toml"], "<FOLDER>"),
        (
            &["report", "block.h5", "--out", "page.html"],
            "<INPUT> [PAGE]",
        ),
        (&["export", "block.h5", "out.vtkhdf"], "--kind <KIND>"),
        (&["friction-law", "block.toml", "pictures"], "<SCENE>"),
        (&["schema", "--out", "schemas"], "[FOLDER]"),
    ] {
        let assert = program.command(arguments).assert().code(2);
        let said = String::from_utf8_lossy(&assert.get_output().stderr).into_owned();
        assert!(said.contains(usage), "{said}");
    }
}
