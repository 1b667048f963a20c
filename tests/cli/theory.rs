//! `theory` as a user meets it.

use serde_json::Value;

use crate::program::{Program, SMALL, pipeline};

fn theory(program: &Program, more: &[&str]) -> assert_cmd::Command {
    let scene = pipeline("hkl2011_table1.toml");
    let scene = scene.to_str().expect("plain path");
    let mut command = program.command(&["theory", scene, "run.h5"]);
    command.args(SMALL).args(more);
    command
}

#[test]
fn the_theory_is_stored_drawn_printed_and_reported() {
    let program = Program::new();
    program.run(&[]).assert().success();
    let before = program.digests();
    let done = theory(&program, &[]).assert().success();
    let text = String::from_utf8_lossy(&done.get_output().stdout).into_owned();
    let last = text.lines().last().expect("a last line");
    assert!(
        last.starts_with("At n_div = 4 uniqueness is proven for this law"),
        "{last}"
    );
    let said = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
    assert!(said.starts_with("coefficients of friction from "), "{said}");
    assert!(
        said.contains("n_div = 4: uniqueness is proven for"),
        "{said}"
    );
    for name in ["theory_thresholds", "theory_scaled_law", "theory_constants"] {
        for kind in ["svg", "png"] {
            assert!(program.path(&format!("run-figures/{name}.{kind}")).exists());
        }
    }
    // The stages stay as they were.
    assert_eq!(program.digests(), before);
    assert!(program.states().iter().all(|(_, state)| state == "fresh"));
    program.command(&["check", "run.h5"]).assert().success();
    program.command(&["report", "run.h5"]).assert().success();
    let page = std::fs::read_to_string(program.path("report.html")).expect("a page");
    assert!(page.contains("id=\"theory\"") && page.contains("id=\"panels\""));
    assert!(!page.contains("Measured for another scene"));
}

#[test]
fn figures_have_their_names_in_words_and_do_not_depend_on_threads() {
    let program = Program::new();
    let json = |threads: &str| -> Value {
        let more = ["--json", "--no-figures", "--threads", threads];
        let done = theory(&program, &more).assert().success();
        serde_json::from_slice(&done.get_output().stdout).expect("JSON")
    };
    let one = json("1");
    assert_eq!(one, json("2"));
    let levels = one["levels"].as_array().expect("levels");
    assert_eq!(levels.len(), 2);
    for level in levels {
        for key in ["spectral_radius", "observed_rate", "inverse_first"] {
            assert!(level[key].as_f64().is_some_and(|v| v > 0.0), "{key}");
        }
        for norm in level["norms"].as_array().expect("norms") {
            for key in ["contraction_bound", "ellipticity", "jacobian_norm_weighted"] {
                assert!(norm[key].as_f64().is_some_and(|v| v > 0.0), "{key}");
            }
        }
    }
    let beta = levels[0]["inf_sup"][0]["inf_sup"].as_f64();
    assert!(beta.is_some_and(|beta| beta > 0.0 && beta < 1.0));
}

#[test]
fn scenes_beyond_the_theory_are_bad_input_and_leave_no_file() {
    for (change, key) in [
        ("contact.gap=1e-5", "contact.gap"),
        ("body.element=\"P2\"", "body.element"),
        ("friction={slip_bound=1e6}", "friction"),
    ] {
        let program = Program::new();
        let output = theory(&program, &["--set", change]).assert().code(2);
        let text = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
        assert!(text.contains(&format!("{key}: expected")), "{text}");
        assert!(!program.path("run.h5").exists());
    }
    let program = Program::new();
    let output = theory(&program, &["--finest", "6"]).assert().code(2);
    let text = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(text.contains("a multiple of 4"), "{text}");
}

#[test]
fn mesh_files_are_for_bodies_from_mesh_files() {
    for (scene, mesh, key) in [
        ("hkl2011_table1.toml", "meshes/foot.msh", "body.gmsh"),
        ("gmsh_foot.toml", "meshes/none.msh", "body.gmsh.file"),
    ] {
        let program = Program::new();
        let scene = pipeline(scene);
        let scene = scene.to_str().expect("plain path");
        let arguments = ["theory", scene, "run.h5", "--mesh", mesh];
        let output = program.command(&arguments).assert().code(2);
        let text = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
        assert!(text.contains(&format!("{key}: expected")), "{text}");
        assert!(!program.path("run.h5").exists());
    }
}
