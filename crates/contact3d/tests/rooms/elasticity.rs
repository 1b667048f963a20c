//! Gradients of shape functions, and loads that clamps make idle.

use std::path::Path;

use contact3d::{
    elasticity::{Simplex, load_warnings},
    mesh::Mesh,
    scene::Scene,
};

fn warnings(clamps: &str, loads: &str) -> Vec<String> {
    let text = format!(
        "title = \"t\"\n[body.brick]\nsize = [1.0, 1.0, 1.0]\ncells = [2, 2, 2]\n\
         [material.isotropic]\nyoung_modulus = 1.0\npoisson_ratio = 0.3\n{clamps}\n{loads}"
    );
    let scene = Scene::parse("test", &text).unwrap();
    let mesh = Mesh::of_scene(&scene, Path::new("")).unwrap();
    let warnings = load_warnings(&scene, &mesh);
    warnings.iter().map(ToString::to_string).collect()
}

const HELD: &str = "[[clamp]]\nface = \"x_min\"\n";

#[test]
fn components_on_held_displacements_are_named() {
    let clamps = format!("{HELD}[[clamp]]\nface = \"x_max\"\ncomponents = [\"y\", \"z\"]\n");
    let found = warnings(
        &clamps,
        "[[traction]]\nface = \"x_max\"\nvalue = [1.0, \"y\", 2.0]",
    );
    assert_eq!(found.len(), 1);
    assert!(found[0].starts_with("traction.0.value: its part along y, z does nothing"));
    // Following the advice ends the warning.
    let advised = "[[traction]]\nface = \"x_max\"\nvalue = [1.0, 0.0, 0.0]";
    assert!(warnings(&clamps, advised).is_empty());
    let load = "[[traction]]\nface = \"x_max\"\nvalue = [1.0, \"y\", 2.0]";
    assert!(warnings(HELD, load).is_empty());
}

#[test]
fn a_load_that_reaches_a_free_node_acts() {
    let clamps = format!("{HELD}[[clamp]]\nbox = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.5]]\n");
    let load = "[[traction]]\nface = \"x_max\"\nvalue = [1.0, 1.0, 1.0]";
    assert!(warnings(&clamps, load).is_empty());
    // Two clamps that hold a face together.
    let clamps = format!("{HELD}[[clamp]]\nbox = [[1.0, 0.0, 0.0], [1.0, 1.0, 1.0]]\n");
    assert!(warnings(&clamps, load)[0].contains("along x, y, z"));
}

#[test]
fn pressures_and_body_forces_are_looked_at_too() {
    let clamps = format!("{HELD}[[clamp]]\nface = \"y_max\"\ncomponents = [\"y\"]\n");
    let load = "[[pressure]]\nface = \"y_max\"\nvalue = \"1 + x\"\n[[pressure]]\nface = \"z_max\"\nvalue = 1.0";
    let found = warnings(&clamps, load);
    assert_eq!(found.len(), 1);
    assert!(
        found[0].starts_with("pressure.0.value: it does nothing"),
        "{found:?}"
    );
    let flat = format!(
        "{HELD}[[clamp]]\nbox = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]\ncomponents = [\"y\"]\n"
    );
    let found = warnings(&flat, "[body_force]\nvalue = [1.0, 1.0, 0.0]");
    assert_eq!(found.len(), 1);
    assert!(found[0].starts_with("body_force.value: its part along y does nothing"));
}

#[test]
fn gradients_reproduce_linear_functions() {
    let corners = [
        [0.1, 0.0, 0.2],
        [1.3, 0.1, 0.0],
        [0.2, 0.9, 0.1],
        [0.0, 0.2, 1.1],
    ];
    let simplex = Simplex::new(&corners);
    for (axis, component) in (0..3).flat_map(|axis| (0..3).map(move |c| (axis, c))) {
        let terms = simplex.gradients.iter().zip(&corners);
        let gradient: f64 = terms.map(|(g, x)| g[component] * x[axis]).sum();
        // A handful of roundings on numbers of size 1.
        assert!((gradient - f64::from(u8::from(axis == component))).abs() < 5e-15);
    }
}
