//! Table 1 of HKL 2011: a steel brick pulled along a rigid foundation, with coefficients of friction that fall with
//! the slip, 0.3 to 0.2 along each axis.
//!
//! `cargo run --release -p contact3d --example published_problem -- 8` with n_div = 8 cells along the short edges.

use contact3d::{
    AssembledProblem, Problem, ProblemError,
    post::{ContactReport, Zone},
    scene::{
        Body, Clamp, Coefficient, Contact, Friction, Material, Scene, SolveSettings, Traction,
    },
    solver::Solution,
};

/// The published scene with 3 n_div × n_div × n_div cells.
pub(crate) fn scene(n_div: usize) -> Scene {
    let falling = |rate| Coefficient::ramp(0.3, 0.2, 1e-5, rate); // onset in m, rate in 1/m
    Scene::new(
        Body::brick([3.0, 1.0, 1.0], [3 * n_div, n_div, n_div]),
        Material::isotropic(21.19e10, 0.277),
    )
    .with_title("HKL 2011, Table 1")
    .with_clamp(Clamp::face("x_min"))
    .with_traction(Traction::on("x_max", [1e7, 0.0, 2e7]))
    .with_traction(Traction::on("z_max", [0.0, 0.0, -3e7]))
    .with_contact(Contact::on("z_min"))
    .with_friction(Friction::orthotropic(falling(3000.0), falling(1000.0)))
}

pub(crate) fn solve(
    n_div: usize,
) -> Result<(AssembledProblem, Solution, ContactReport), ProblemError> {
    let assembled = Problem::new(scene(n_div))?.assemble()?;
    let (solution, report) = assembled.solve_and_report(&SolveSettings::default())?;
    Ok((assembled, solution, report))
}

fn main() -> Result<(), ProblemError> {
    let n_div = std::env::args().nth(1).and_then(|text| text.parse().ok());
    let (assembled, solution, report) = solve(n_div.unwrap_or(8))?;
    println!(
        "{} unknowns, {} panes",
        assembled.n_free(),
        assembled.n_panes()
    );
    println!(
        "{}: error of the multipliers {:.1e}, {} steps of Newton's method",
        solution.status.word(),
        solution.accuracy,
        solution.trace.newton.len()
    );
    let [open, stick, slip] = [Zone::Open, Zone::Stick, Zone::Slip].map(|zone| report.count(zone));
    println!("panes: {open} open, {stick} sticking, {slip} slipping");
    if let Some(contact) = report.resultants.contact {
        println!("contact force {:.6e} N", contact.normal_force);
        println!("largest pressure {:.6e} Pa", contact.largest_pressure);
    }
    println!("strain energy {:.5} J", report.resultants.strain_energy);
    Ok(())
}
