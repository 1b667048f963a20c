//! Scenes with obstacles in other units, numbers, threads and mirrors.

use std::path::Path;

use contact3d::{
    robustness::{Check, Depth, Invariance, Solutions},
    scene::Scene,
};

use crate::moved::MATERIAL;

fn check(obstacle: &str, friction: &str) -> Check {
    let text = format!(
        "title = 'invariances'\n[body.brick]\nsize = [1.0, 0.75, 0.5]\ncells = [6, 4, 2]\n{MATERIAL}\
         [[clamp]]\nface = 'z_max'\n[body_force]\nvalue = [0.004, 0.002, -0.1]\n\
         [contact]\nface = 'z_min'\nobstacle.{obstacle}\n{friction}"
    );
    let scene = Scene::parse("test", &text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let check = Check::new(&scene, Path::new(""), Depth::Invariances, Solutions::One);
    check.unwrap_or_else(|e| panic!("{e}"))
}

const FRICTION: &str = "[friction]\ncoefficient_1.constant = 0.3\ncoefficient_2.constant = 0.2\n";

#[test]
fn answers_do_not_depend_on_units_numbers_and_mirrors() {
    use Invariance::{BinaryUnits, DecimalUnits, Exchange, Mirror, Renumbering, Threads};
    let always = vec![BinaryUnits, DecimalUnits, Renumbering, Threads, Mirror];
    for (obstacle, friction, images) in [
        (
            "sphere = { centre = [0.6, 0.3, -1.0], radius = 1.0 }",
            FRICTION,
            vec![],
        ),
        (
            "sphere = { centre = [0.6, 0.3, -1.0], radius = 1.0 }",
            "",
            vec![Exchange],
        ),
        (
            "cylinder = { point = [0.4, 0.1, -2.005], direction = [0.3, 1.0, 0.0], radius = 2.0 }",
            FRICTION,
            vec![],
        ),
        (
            "half_space = { point = [0.0, 0.0, 0.0], normal = [0.001, 0.002, 1.0] }",
            "",
            vec![Exchange],
        ),
        (
            "height.value = '-0.01*(x - 0.3)^2 - 0.02*(y - 0.5)^2 - 0.001*x'",
            FRICTION,
            vec![],
        ),
    ] {
        let check = check(obstacle, friction);
        let known: Vec<Invariance> = check.invariances.iter().map(|r| r.invariance).collect();
        assert_eq!(known, [always.clone(), images].concat(), "{obstacle}");
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
