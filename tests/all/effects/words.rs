//! `run` and `status` list which model features are present, what each costs, and what is absent.

use std::fs;

use assert_cmd::Command;
use serde_json::{Value, json};

use super::scenes::{BODY, CONTACT, LOAD, RAMPS, STEEL};

/// The effects of a scene as `run --json` and `status --json` tell them, and the text of both.
fn effects(tables: &[&str]) -> ([Value; 2], [String; 2]) {
    let folder = tempfile::tempdir().unwrap();
    let scene = [&[BODY, STEEL, LOAD], tables].concat().concat();
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let output = |arguments: &[&str]| {
        let mut command = Command::cargo_bin("contact3d-pipe").unwrap();
        let command = command.current_dir(folder.path()).args(arguments);
        command.assert().success().get_output().clone()
    };
    let run = output(&["run", "scene.toml", "run.h5", "--no-figures", "--json"]);
    let status = output(&["status", "run.h5", "--json"]);
    let json = [&run, &status].map(|output| {
        let all: Value = serde_json::from_slice(&output.stdout).unwrap();
        all["effects"].clone()
    });
    let again = output(&["run", "scene.toml", "run.h5", "--no-figures", "-v"]).stdout;
    let text = output(&["status", "run.h5"]).stdout;
    (json, [again, text].map(|t| String::from_utf8(t).unwrap()))
}

/// (effect, unknowns) of the effects present.
fn costs(effects: &Value) -> Vec<(&str, u64)> {
    let present = effects["present"].as_array().unwrap();
    present
        .iter()
        .map(|e| {
            (
                e["effect"].as_str().unwrap(),
                e["unknowns"].as_u64().unwrap(),
            )
        })
        .collect()
}

#[test]
fn an_elastic_scene_names_what_it_lacks() {
    let (json, texts) = effects(&[]);
    for effects in &json {
        assert_eq!(costs(effects), [("elasticity", 900)]);
        assert_eq!(
            effects["absent"],
            json!([
                "anisotropy",
                "regions",
                "prescribed displacements",
                "springs",
                "body force",
                "contact",
                "obstacle",
                "initial gap",
                "friction",
                "slip-dependent coefficients",
                "place-dependent coefficients",
                "turning frame",
                "rigid motions",
                "tools"
            ])
        );
    }
    for text in texts {
        assert!(text.contains("900 displacements"), "{text}");
        assert!(text.contains("absent, not computed"), "{text}");
    }
}

#[test]
fn every_effect_is_counted() {
    let (json, texts) = effects(&[
        "[[clamp]]\nface = 'x_min'\ncomponents = ['x']\nvalue = ['0*x', 0, 0]\n",
        "[[spring]]\nface = 'x_max'\nnormal = 1e9\n",
        "[body_force]\nvalue = [0, 0, -1]\n",
        "[[region]]\npart.box = [[0, 0, 0], [1, 1, 1]]\n",
        "[region.material.orthotropic]\nyoung_moduli = [2e11, 1e11, 2e11]\n",
        "poisson_ratios = [0.2, 0.2, 0.2]\nshear_moduli = [1e11, 1e11, 1e11]\n",
        CONTACT,
        "angle = 'x'\ngap = '1e-5*x'\n",
        "obstacle.half_space = { point = [0, 0, 0], normal = [0, 0, 1] }\n",
        "[friction.coefficient_1]\nexpression = '0.3 + x*exp(-s1/1e-5)'\n",
        "[friction.coefficient_2]\nconstant = 0.2\n",
    ]);
    // 6 × 2 panes, 13 × 5 contact nodes.
    for effects in &json {
        assert_eq!(
            costs(effects),
            [
                ("elasticity", 900),
                ("anisotropy", 0),
                ("regions", 0),
                ("prescribed displacements", 0),
                ("springs", 0),
                ("body force", 0),
                ("contact", 12),
                ("obstacle", 0),
                ("initial gap", 0),
                ("friction", 24),
                ("slip-dependent coefficients", 130),
                ("place-dependent coefficients", 0),
                ("turning frame", 0),
            ]
        );
        assert_eq!(effects["absent"], json!(["rigid motions", "tools"]));
    }
    for text in texts {
        for words in [
            "12 normal multipliers (panes)",
            "24 tangential multipliers (orthotropic Coulomb)",
            "130 slips of contact nodes",
            "1 besides the body's own material",
        ] {
            assert!(text.contains(words), "no {words:?} in\n{text}");
        }
    }
}

#[test]
fn laws_and_spaces_are_named() {
    for (contact, law, words) in [
        (
            "",
            "slip_bound = 1e6",
            "24 tangential multipliers (isotropic Tresca)",
        ),
        (
            "",
            "coefficient.constant = 0.3",
            "24 tangential multipliers (isotropic Coulomb)",
        ),
        (
            "",
            "coefficient.constant = 0.3\npressure_cap = 1e7",
            "24 tangential multipliers (isotropic capped Coulomb)",
        ),
        (
            "multipliers = 'nodal'",
            "slip_bound = 1e6",
            "60 normal multipliers (nodes)",
        ),
    ] {
        let (_, texts) = effects(&[CONTACT, contact, "\n[friction]\n", law]);
        assert!(texts[1].contains(words), "no {words:?} in\n{}", texts[1]);
    }
    let (json, _) = effects(&[CONTACT, RAMPS]);
    assert_eq!(json[0], json[1]);
}
