//! The command `friction-law`: bounds and picture of a law by itself.

use std::fs;

use serde_json::Value;

use crate::program::{Program, SMALL, pipeline};

/// Table 1's scene with another law of friction.
fn scene_with(program: &Program, law: &str) {
    let text = fs::read_to_string(pipeline("newton.toml")).unwrap();
    let (head, _) = text.split_once("[friction.coefficient_1").unwrap();
    fs::write(program.path("scene.toml"), format!("{head}\n{law}")).unwrap();
}

/// Standard output of `law` for a scene of the scratch folder.
fn law(program: &Program, more: &[&str]) -> String {
    let mut command = program.command(&["friction-law", "scene.toml"]);
    let done = command.args(SMALL).args(more).assert().success();
    String::from_utf8_lossy(&done.get_output().stdout).into_owned()
}

#[test]
fn the_law_of_table_1_is_bounded_and_drawn_without_a_run_file() {
    let program = Program::new();
    let scene = pipeline("hkl2011_table1.toml");
    let done = program
        .command(&["friction-law", scene.to_str().unwrap()])
        .args(SMALL)
        .assert()
        .success();
    let text = String::from_utf8_lossy(&done.get_output().stdout).into_owned();
    let words: Vec<&str> = text.split_whitespace().collect();
    let words = words.join(" ");
    for fragment in [
        "orthotropic Coulomb friction",
        "F_min 0.2 F1 at slip 4.3333e-5, 0 m",
        "F_max 0.3 F1 at slip 0, 0 m",
        "Lipschitz modulus L 3000 1/m F1",
        "kappa(F) 1.5",
        "exact",
    ] {
        assert!(words.contains(fragment), "{fragment}: {text}");
    }
    let mut files: Vec<String> = fs::read_dir(program.path("."))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    assert_eq!(files, ["hkl2011_table1-friction-law"]);
    for name in ["friction_law.svg", "friction_law.png"] {
        assert!(
            program
                .path("hkl2011_table1-friction-law")
                .join(name)
                .exists()
        );
    }
}

#[test]
fn json_holds_the_bounds() {
    let program = Program::new();
    scene_with(
        &program,
        "[friction.coefficient_1]\nexpression = \"0.2 + 0.1*x + (s1/3e-4)*exp(0 - s1/3e-4)\"\n\
         [friction.coefficient_2]\nconstant = 0.2",
    );
    let text = law(&program, &["--json", "--quiet", "--figures", "pictures"]);
    let json: Value = serde_json::from_str(&text).unwrap();
    let bounds = &json["faces"][0]["bounds"];
    let value = |name: &str| bounds[name]["value"].as_f64().unwrap();
    // The peak of s exp(-s) is 1/e, at the far end of the brick; its steepest slope that at 0.
    let peak = 0.5 + (-1.0_f64).exp();
    assert!((value("f_max") - peak).abs() < 1e-12);
    assert!((value("kappa") - peak / 0.2).abs() < 1e-11);
    assert!((value("lipschitz") - 1.0 / 3e-4).abs() < 1e-9);
    assert_eq!(bounds["f_max"]["position"][0], 3.0);
    assert_eq!(bounds["f_max"]["coefficient"], "F1");
    assert_eq!(bounds["estimated"], true);
    assert_eq!(json["figures"][0], "pictures/friction_law.svg");
    assert!(program.path("pictures/friction_law.png").exists());
}

#[test]
fn laws_without_coulomb_friction_say_so() {
    let program = Program::new();
    for (friction, kind, fragment) in [
        ("", "frictionless", "frictionless contact"),
        (
            "[friction]\nslip_bound = \"1e6*(1+x)\"",
            "tresca",
            "with a given slip bound",
        ),
    ] {
        scene_with(&program, friction);
        let text = law(&program, &[]);
        assert!(text.contains(fragment), "{text}");
        let json: Value = serde_json::from_str(&law(&program, &["--json"])).unwrap();
        assert_eq!(json["faces"][0]["law"], kind);
        assert!(json["faces"][0]["bounds"].is_null());
    }
    assert!(!program.path("scene-friction-law").exists());
}

#[test]
fn a_law_that_turns_negative_is_warned_of_and_solved_where_it_holds() {
    let program = Program::new();
    let scene = |law: &str| {
        scene_with(
            &program,
            &format!(
                "[friction.coefficient_1]\nexpression = \"{law}\"\n[friction.coefficient_2]\nconstant = 0.2"
            ),
        );
    };
    for (law, code) in [("0.3 - 500*s1", 0), ("0.3 - 3e4*s1", 1)] {
        scene(law);
        for (arguments, code) in [
            (vec!["friction-law", "scene.toml"], 0),
            (vec!["mesh", "scene.toml", "run.h5"], 0),
            (vec!["run", "scene.toml", "run.h5"], code),
        ] {
            let mut command = program.command(&arguments);
            let done = command.args(SMALL).assert().code(code);
            let text = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
            let warning =
                "warning: friction.coefficient_1.expression: not 0 < F < infinity, at worst ";
            assert_eq!(text.matches(warning).count(), 1, "{arguments:?}: {text}");
            assert!(text.contains("max(FORMULA, 0.05)"), "{text}");
        }
    }
    scene("max(0.3 - 3e4*s1, 0.05)");
    let mut command = program.command(&["run", "scene.toml", "run.h5"]);
    let done = command.args(SMALL).assert().success();
    let text = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
    assert!(!text.contains("warning"), "the advice was followed: {text}");
}

#[test]
fn a_law_that_is_not_positive_at_rest_is_refused_before_anything_is_stored() {
    let program = Program::new();
    scene_with(
        &program,
        "[friction.coefficient_1]\nexpression = \"0.2*x - 0.3 - 1e3*s1\"\n\
         [friction.coefficient_2]\nconstant = 0.2",
    );
    for arguments in [
        vec!["friction-law", "scene.toml"],
        vec!["mesh", "scene.toml", "run.h5"],
        vec!["run", "scene.toml", "run.h5"],
    ] {
        let mut command = program.command(&arguments);
        let refused = command.args(SMALL).assert().code(2);
        let text = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        let folded: Vec<&str> = text.split_whitespace().filter(|w| *w != "│").collect();
        let folded = folded.join(" ");
        for fragment in [
            "friction.coefficient_1.expression",
            "0 < F < infinity without slip",
            "found -0.3 at |u_t1| = 0.0000e0 m, x, y, z = 0.0, 0.0, 0.0",
            "correct the formula there",
        ] {
            assert!(
                folded.contains(fragment),
                "{arguments:?}: {fragment}: {text}"
            );
        }
    }
    assert!(!program.path("run.h5").exists() && !program.path("scene-friction-law").exists());
}

/// The cap bounds the slip bound, not F: the law's bounds are those of the law without it.
#[test]
fn a_capped_law_names_its_cap() {
    let program = Program::new();
    let coefficient = "[friction]\ncoefficient.constant = 0.3\n";
    scene_with(&program, &format!("{coefficient}pressure_cap = 15e6"));
    let text = law(&program, &[]);
    for fragment in ["capped Coulomb", "min(-sigma_nu, p_cap)"] {
        assert!(text.contains(fragment), "{fragment}: {text}");
    }
    let json = |program: &Program| -> Value {
        let json: Value = serde_json::from_str(&law(program, &["--json"])).unwrap();
        json["faces"][0].clone()
    };
    let capped = json(&program);
    assert_eq!(capped["law"], "capped");
    scene_with(&program, coefficient);
    let uncapped = json(&program);
    assert_eq!(uncapped["law"], "isotropic");
    assert_eq!(capped["bounds"], uncapped["bounds"]);
    assert!(capped["bounds"]["f_max"]["value"].is_number());
}
