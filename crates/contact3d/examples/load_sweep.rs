//! Many loads and laws on one factor: the stiffness is factorised once, each further case costs one solve with it.
//!
//! `cargo run --release -p contact3d --example load_sweep`

use contact3d::{
    AssembledProblem, Problem, ProblemError,
    post::{ContactReport, Zone},
    scene::{Body, Clamp, Contact, Friction, Material, Pressure, Scene, SolveSettings, Traction},
};

/// A block under 20 MPa, pulled by some traction in Pa.
pub(crate) fn block(pull: f64, friction: f64) -> Scene {
    Scene::new(
        Body::brick([3.0, 1.0, 1.0], [24, 8, 8]),
        Material::isotropic(2.1e11, 0.3),
    )
    .with_clamp(Clamp::face("x_min"))
    .with_pressure(Pressure::on("z_max", 2e7))
    .with_traction(Traction::on("x_max", [pull, 0.0, 0.0]))
    .with_contact(Contact::on("z_min"))
    .with_friction(Friction::coulomb(friction))
}

/// The same block under another pull and another coefficient of friction.
pub(crate) fn solve(
    assembled: &AssembledProblem,
    pull: f64,
    friction: f64,
) -> Result<ContactReport, ProblemError> {
    let case = assembled.with_changes(|scene| {
        scene.tractions[0] = Traction::on("x_max", [pull, 0.0, 0.0]);
        scene.friction = Some(Friction::coulomb(friction));
    })?;
    let (_, report) = case.solve_and_report(&SolveSettings::default())?;
    Ok(report)
}

fn main() -> Result<(), ProblemError> {
    let assembled = Problem::new(block(0.0, 0.3))?.assemble()?;
    println!("F    pull/Pa  slipping  friction/N     end moves/m");
    for friction in [0.1, 0.3, 0.6] {
        for pull in [0.0, 5e6, 1e7, 2e7] {
            let report = solve(&assembled, pull, friction)?;
            let contact = report.resultants.contact;
            let force = contact.and_then(|contact| contact.tangential_force);
            println!(
                "{friction}  {pull:7.0e}  {:8}  {:13.5e}  {:.4e}",
                report.count(Zone::Slip),
                force.unwrap_or_default()[0],
                report.resultants.largest_displacement_along[0]
            );
        }
    }
    Ok(())
}
