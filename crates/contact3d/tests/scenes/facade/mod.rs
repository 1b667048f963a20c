//! Scenes built in Rust: validation, one assembly for many problems.

mod reuse;
mod validation;

use contact3d::{
    AssembledProblem, Problem,
    scene::{Body, Clamp, Contact, Friction, Material, Pressure, Scene, SolveSettings, Traction},
    solver::Solution,
};

/// A steel block, pressed onto its foundation and pulled along it.
fn block(friction: Friction) -> Scene {
    let body = Body::brick([3.0, 1.0, 1.0], [12, 4, 4]);
    Scene::new(body, Material::isotropic(2.1e11, 0.3))
        .with_clamp(Clamp::face("x_min"))
        .with_pressure(Pressure::on("z_max", 2e7))
        .with_traction(Traction::on("x_max", [1e7, 2e6, 0.0]))
        .with_contact(Contact::on("z_min"))
        .with_friction(friction)
}

fn assembled(scene: Scene) -> AssembledProblem {
    let problem = Problem::new(scene).unwrap_or_else(|error| panic!("{error}"));
    problem.assemble().unwrap_or_else(|error| panic!("{error}"))
}

fn solved(problem: &AssembledProblem) -> Solution {
    let solution = problem.solve(&SolveSettings::default());
    solution.unwrap_or_else(|error| panic!("{error}"))
}
