use std::{f64::consts::SQRT_2, path::Path};

use super::*;
use crate::{
    scene::{Body, Clamp, Coefficient, Contact, Friction, Material, Pressure, Traction},
    solver::Status,
};

/// The published problem with Table 1's law on 3 n × n × n cells.
fn published(n: usize) -> Scene {
    let coefficient = |rate: f64| Coefficient::ramp(0.3, 0.2, 1e-5, rate);
    Scene::new(
        Body::brick([3.0, 1.0, 1.0], [3 * n, n, n]),
        Material::isotropic(21.19e10, 0.277),
    )
    .with_clamp(Clamp::face("x_min"))
    .with_traction(Traction::on("x_max", [1e7, 0.0, 2e7]))
    .with_traction(Traction::on("z_max", [0.0, 0.0, -3e7]))
    .with_contact(Contact::on("z_min"))
    .with_friction(Friction::orthotropic(coefficient(3000.0), coefficient(1000.0)))
}

fn measure(scene: &Scene) -> Theory {
    let settings = TheorySettings {
        coarsest: 2,
        finest: None,
    };
    Theory::measure(scene, Path::new(""), &settings, &mut |_| {}).expect("covered")
}

#[test]
fn scratch() {
    for n in [2, 4] {
        let started = std::time::Instant::now();
        let theory = measure(&published(n));
        println!("{n} {:?} {:#?}", started.elapsed(), theory.levels.last());
        println!("{}", theory.findings());
    }
}
