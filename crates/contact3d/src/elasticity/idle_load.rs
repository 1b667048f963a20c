//! Loads that clamps take up whole.

use super::Loads;
use crate::{
    mesh::Mesh,
    scene::{Component, Quantity, Scene, Warning},
};

/// Forces below this share of the largest one are rounding of a face's normal.
const ROUNDING: f64 = 1e-12;

/// The loads of a scene, or their components, that act on held displacements only.
#[must_use]
pub fn idle_loads(scene: &Scene, mesh: &Mesh) -> Vec<Warning> {
    let held = mesh.held_nodes(scene);
    let loads = Loads {
        tractions: &[],
        pressures: &[],
        body_force: None,
    };
    let tractions = scene.tractions.iter().enumerate();
    let tractions = tractions.map(|(i, traction)| {
        let alone = Loads {
            tractions: std::slice::from_ref(traction),
            ..loads
        };
        let components = idle_components(&forces(&alone, mesh), &held).collect();
        (format!("traction.{i}.value"), components)
    });
    let whole = scene.body_force.iter().map(|force| {
        let is_idle = |component: &Component| {
            let c = *component as usize;
            force.value[c] != Quantity::Constant(0.0) && held.iter().all(|held| held[c])
        };
        let components = Component::ALL.into_iter().filter(is_idle).collect();
        ("body_force.value".to_owned(), components)
    });
    let pressures = scene.pressures.iter().enumerate();
    let pressures = pressures.filter_map(|(i, pressure)| {
        let alone = Loads {
            pressures: std::slice::from_ref(pressure),
            ..loads
        };
        let forces = forces(&alone, mesh);
        let acting = Component::ALL
            .into_iter()
            .filter(|c| acts(&forces, *c))
            .count();
        let idle = idle_components(&forces, &held).count();
        (acting > 0 && idle == acting).then(|| Warning::IdlePressure {
            key: format!("pressure.{i}.value"),
        })
    });
    tractions
        .chain(whole)
        .filter(|(_, components): &(_, Vec<Component>)| !components.is_empty())
        .map(|(key, components)| Warning::IdleLoad { key, components })
        .chain(pressures)
        .collect()
}

/// Nodal forces of a load; none of one that is not finite, which is refused elsewhere.
fn forces(load: &Loads<'_>, mesh: &Mesh) -> Vec<[f64; 3]> {
    load.nodal_forces(mesh).unwrap_or_default()
}

/// The components of nodal forces that act, and on held displacements only.
fn idle_components(forces: &[[f64; 3]], held: &[[bool; 3]]) -> impl Iterator<Item = Component> {
    let limit = ROUNDING * largest(forces);
    Component::ALL.into_iter().filter(move |component| {
        let c = *component as usize;
        let mut free = forces.iter().zip(held).filter(|(_, held)| !held[c]);
        acts(forces, *component) && free.all(|(force, _)| force[c].abs() <= limit)
    })
}

fn acts(forces: &[[f64; 3]], component: Component) -> bool {
    let limit = ROUNDING * largest(forces);
    let mut along = forces.iter().map(|force| force[component as usize].abs());
    along.any(|force| force > limit)
}

fn largest(forces: &[[f64; 3]]) -> f64 {
    let forces = forces.as_flattened().iter();
    forces.fold(0.0, |most, force| most.max(force.abs()))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn warnings(clamps: &str, loads: &str) -> Vec<String> {
        let text = format!(
            "title = \"t\"\n[body.brick]\nsize = [1.0, 1.0, 1.0]\ncells = [2, 2, 2]\n\
             [material.isotropic]\nyoung_modulus = 1.0\npoisson_ratio = 0.3\n{clamps}\n{loads}"
        );
        let scene = Scene::parse("test", &text).unwrap();
        let mesh = Mesh::of_scene(&scene, Path::new("")).unwrap();
        let warnings = idle_loads(&scene, &mesh);
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
}
