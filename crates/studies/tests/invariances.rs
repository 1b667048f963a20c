//! Scenes with obstacles and with formulas in other units, with other node numbers and threads.

use std::path::Path;

use contact3d::scene::Scene;
use studies::stability::{Check, Effort, Invariance, Solutions};

const MATERIAL: &str = "[material.isotropic]\nyoung_modulus = 1.0\npoisson_ratio = 0.3\n";

fn check(obstacle: &str, friction: &str) -> Check {
    let text = format!(
        "title = 'invariances'\n[body.brick]\nsize = [1.0, 0.75, 0.5]\ncells = [6, 4, 2]\n{MATERIAL}\
         [[clamp]]\nface = 'z_max'\n[body_force]\nvalue = [0.004, 0.002, -0.1]\n\
         [contact]\nface = 'z_min'\nobstacle.{obstacle}\n{friction}"
    );
    let scene = Scene::parse("test", &text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    check_of(&scene)
}

fn check_of(scene: &Scene) -> Check {
    let check = Check::new(
        scene,
        Path::new(""),
        Effort::Invariances,
        Solutions::One,
        &mut |_| {},
    );
    check.unwrap_or_else(|e| panic!("{e}"))
}

const FRICTION: &str = "[friction]\ncoefficient_1.constant = 0.3\ncoefficient_2.constant = 0.2\n";

#[test]
fn solutions_do_not_depend_on_units_and_numbers() {
    use Invariance::{BinaryUnits, DecimalUnits, Renumbering, Threads};
    for (obstacle, friction) in [
        (
            "sphere = { centre = [0.6, 0.3, -1.0], radius = 1.0 }",
            FRICTION,
        ),
        ("sphere = { centre = [0.6, 0.3, -1.0], radius = 1.0 }", ""),
        (
            "cylinder = { point = [0.4, 0.1, -2.005], direction = [0.3, 1.0, 0.0], radius = 2.0 }",
            FRICTION,
        ),
        (
            "half_space = { point = [0.0, 0.0, 0.0], normal = [0.001, 0.002, 1.0] }",
            "",
        ),
        (
            "height.value = '-0.01*(x - 0.3)^2 - 0.02*(y - 0.5)^2 - 0.001*x'",
            FRICTION,
        ),
    ] {
        let check = check(obstacle, friction);
        let known: Vec<Invariance> = check.invariances.iter().map(|r| r.invariance).collect();
        assert_eq!(
            known,
            [BinaryUnits, DecimalUnits, Renumbering, Threads],
            "{obstacle}"
        );
        for result in &check.invariances {
            let limit = match result.invariance {
                // Another number of threads and powers of two change no bit.
                BinaryUnits | Threads => 0.0,
                // Roundings of distances near 1 that are measured in displacements near 1e-2.
                _ => 1e-9,
            };
            assert!(result.difference <= limit, "{obstacle} {result:?}");
        }
    }
}

/// In other units a formula is seen as it must be.
#[test]
fn formulas_survive_other_descriptions() {
    let text = "title = 'formulas'
        body.brick = { size = [3.0, 1.0, 1.0], cells = [12, 4, 4] }
        material.isotropic = { young_modulus = 2.1e11, poisson_ratio = 0.3 }
        clamp = [{ face = 'x_min' }]
        pressure = [{ face = 'z_max', value = '1e7 + 4e6*x*y' }]
        traction = [{ face = 'x_max', value = [1e7, 2e6, 0.0] }]
        contact.face = 'z_min'
        friction.coefficient_1.expression = '0.3 + 0.05*x - 0.1*tanh(s1/2e-5) + 0.02*tanh(s2/1e-5)'
        friction.coefficient_2.expression = '0.2 + 1e3*s2'";
    let scene = Scene::parse("formulas", text).unwrap_or_else(|e| panic!("{e}"));
    let check = check_of(&scene);
    for invariance in Invariance::ALL {
        let mut results = check.invariances.iter();
        let result = results.find(|result| result.invariance == invariance);
        let result = result.unwrap_or_else(|| panic!("{invariance:?} does not apply"));
        assert!(result.difference < 1e-9, "{invariance:?}: {result:?}");
    }
}
