//! Figures known from elsewhere: other programs, closed forms, a published test.

use crate::support::{Case, pipelines, refine};
use contact3d::{post::Zone, scene::Scene, solver::Status};

fn pipeline(name: &str) -> String {
    std::fs::read_to_string(pipelines().join(name)).expect("pipeline file")
}

/// The published body and loads at n_div = 8 with nodal multipliers and some law of friction.
fn nodal(friction: &str) -> Case {
    let text = pipeline("newton.toml").replace(
        "face = \"z_min\"",
        "face = \"z_min\"\nmultipliers = \"nodal\"",
    );
    let at = text.find("[friction.").expect("a published law");
    let text = match friction {
        "published" => text,
        law => text[..at].to_owned() + law,
    };
    let mut scene = Scene::parse("nodal", &text).unwrap_or_else(|error| panic!("{error}"));
    refine(&mut scene, [24, 8, 8]);
    Case::new(scene)
}

/// J(u) = ½ uᵀAu − lᵀu in N m, on which Siconos and GetFEM agree for these matrices.
#[test]
fn energies_of_nodal_contact_agree_with_other_programs() {
    for (law, energy) in [
        (
            "[friction]\ncoefficient_1.constant = 0.3\ncoefficient_2.constant = 0.3\n",
            -7_501.915_760,
        ),
        (
            "[friction]\ncoefficient_1.constant = 0.3\ncoefficient_2.constant = 0.2\n",
            -7_508.308_109,
        ),
        ("published", -7_754.978_429),
    ] {
        let case = nodal(law);
        assert_eq!(case.solution.status, Status::Converged);
        let r = case.report().resultants;
        let found = r.strain_energy - r.load_work;
        // Half a unit of the last digit known.
        assert!((found - energy).abs() <= 5e-7, "{law}: {found:.7}");
    }
}

/// The same without friction, where an active set on the raw arrays gave J
/// (`python-checks/test_effects.py`).
#[test]
fn energy_of_frictionless_nodal_contact() {
    let case = nodal("");
    let r = case.report().resultants;
    let found = r.strain_energy - r.load_work;
    // Half a unit of the last digit known.
    assert!((found + 8_213.159_249).abs() <= 5e-7, "{found:.7}");
}

/// A column on a smooth foundation between two planes of symmetry, pressed from above. The corner
/// is held vertically, where the foundation holds it anyway.
fn column(poisson_ratio: f64, contact: &str) -> Case {
    Case::of(&format!(
        "title = 'column'
        body.brick = {{ size = [1.0, 0.8, 1.5], cells = [4, 4, 3] }}
        material.isotropic = {{ young_modulus = {YOUNG:?}, poisson_ratio = {poisson_ratio} }}
        clamp = [{{ face = 'x_min', components = ['x'] }}, {{ face = 'y_min', components = ['y'] }},
                 {{ box = [[0, 0, 0], [0, 0, 0]], components = ['z'] }}]
        pressure = [{{ face = 'z_max', value = {PRESSURE:?} }}]
        [contact]
        face = 'z_min'
        {contact}"
    ))
}

const YOUNG: f64 = 2e11;
const PRESSURE: f64 = 3e7;

/// The patch test: u = p/E (ν x, ν y, −z) and λ_ν = p everywhere, exact for linear elements.
#[test]
fn a_uniform_pressure_passes_through_the_contact_face() {
    for (poisson, contact) in [
        (0.277, ""),
        (0.277, "multipliers = 'nodal'"),
        // Without lateral strain nothing slides, and friction changes nothing.
        (0.0, "[friction]\ncoefficient.constant = 0.3"),
        (
            0.0,
            "multipliers = 'nodal'\n[friction]\ncoefficient.constant = 0.3",
        ),
    ] {
        let case = column(poisson, contact);
        assert_eq!(case.solution.status, Status::Converged, "{contact}");
        let (m, _) = case.sizes();
        let (normal, tangential) = case.solution.multiplier.split_at(m);
        for pressure in normal {
            // Backsolves with condition number near 1e3, and the tolerance 1e-12.
            assert!(
                (pressure / PRESSURE - 1.0).abs() < 1e-10,
                "{contact}: {pressure}"
            );
        }
        assert!(tangential.iter().all(|t| t.abs() < 1e-10 * PRESSURE));
        let strain = PRESSURE / YOUNG;
        for (u, [x, y, z]) in case.displacement().iter().zip(&case.mesh().coordinates) {
            let exact = [poisson * x * strain, poisson * y * strain, -z * strain];
            for (found, exact) in u.iter().zip(exact) {
                assert!((found - exact).abs() < 1e-10 * strain, "{contact}");
            }
        }
    }
}

/// u_x at the nodes of the foundation at x in 1e-5 m, smallest and largest.
fn along_foundation(case: &Case, x: f64) -> [f64; 2] {
    let nodes = case.mesh().coordinates.iter().zip(case.displacement());
    let displacements = nodes
        .filter(|(at, _)| (at[0] - x).abs() < 1e-9 && at[1] == 0.0)
        .map(|(_, u)| 1e5 * u[0]);
    displacements.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], u| {
        [low.min(u), high.max(u)]
    })
}

/// Code_Aster's test SSNV503 (V6.04.503), whose foundation is inclined by 30°: there (8.794, 2.768) mm after the last step.
#[test]
fn pad_of_ssnv503_slides_as_far_as_its_springs_let_it() {
    let case = Case::of(&pipeline("ssnv503.toml"));
    assert_eq!(case.solution.status, Status::Converged);
    let (sin, cos) = (std::f64::consts::PI / 6.0).sin_cos();
    let published = [8.794 * cos + 2.768 * sin, 2.768 * cos - 8.794 * sin];
    let (displacement, nodes) = (case.displacement(), case.mesh().coordinates.len() as f64);
    let mean = |k: usize| displacement.iter().map(|u| u[k]).sum::<f64>() / nodes;
    for (found, published) in [mean(0), mean(2)].iter().zip(published) {
        // In mm. The tolerance of the published test; its body deforms by a thousandth of its motion.
        assert!((found / published - 1.0).abs() < 0.01, "{found}");
    }
    let report = case.report();
    let force = report.resultants.contact.expect("contact").tangential_force;
    // All slides: 0.3 · 300 N/mm² on 800 mm², to the accuracy of the solve.
    let [along, _] = force.expect("friction");
    assert!((along.abs() / 72e3 - 1.0).abs() < 1e-9, "{along}");
}

/// Code_Aster's test SSNV128 (V6.04.128).
#[test]
fn plate_of_ssnv128() {
    let text = pipeline("ssnv128.toml");
    let panes = text
        .replace("cells = [32, 32, 1]", "cells = [32, 32, 2]")
        .replace("multipliers = \"nodal\"\n", "");
    // x in m; the reference; the converged value of an independent computation.
    let references = [
        (0.0, 2.86, 2.860),
        (1.25e-3, 2.72, 2.723),
        (5e-3, 2.28, 2.287),
        (7.5e-3, 1.98, 1.981),
        (11.25e-3, 1.50, 1.541),
    ];
    for text in [text, panes] {
        let case = Case::of(&text);
        assert_eq!(case.solution.status, Status::Converged);
        for (x, reference, converged) in references {
            for found in along_foundation(&case, x) {
                // The tolerance of the reference itself.
                assert!((found / reference - 1.0).abs() < 0.05, "x = {x}: {found}");
                // Linear elements of 1.25 mm; another tetrahedral mesh of that size is 0.3 % off.
                assert!((found / converged - 1.0).abs() < 0.005, "x = {x}: {found}");
            }
        }
        let report = case.report();
        assert!(report.count(Zone::Slip) > 0 && report.count(Zone::Stick) > 0);
    }
}
