//! A law of friction as a formula: from the static to the kinetic coefficient, exponentially with the slip.
//!
//! `cargo run --release -p contact3d --example law_as_formula`

use contact3d::{
    Problem, ProblemError,
    post::PaneState,
    scene::{
        Body, Clamp, Coefficient, Contact, Friction, Material, Pressure, Scene, SolveSettings,
        Traction,
    },
    solver::Solution,
};

pub(crate) const STATIC: f64 = 0.4;
pub(crate) const KINETIC: f64 = 0.15;
/// Slip in m over which the difference falls to 1/e.
pub(crate) const DECAY: f64 = 2e-5;

/// F(|u_t|), which the crate differentiates for Newton's method.
pub(crate) fn weakening() -> Coefficient {
    let text = format!("{KINETIC} + ({STATIC} - {KINETIC})*exp(-s/{DECAY:e})");
    Coefficient::formula(&text).expect("a formula of the slip")
}

/// A steel block pressed onto its foundation and pulled along it.
pub(crate) fn block(friction: Friction) -> Scene {
    Scene::new(
        Body::brick([3.0, 1.0, 1.0], [12, 4, 4]),
        Material::isotropic(2.1e11, 0.3),
    )
    .with_clamp(Clamp::face("x_min"))
    .with_pressure(Pressure::on("z_max", 2e7))
    .with_traction(Traction::on("x_max", [1e7, 0.0, 0.0]))
    .with_contact(Contact::on("z_min"))
    .with_friction(friction)
}

pub(crate) fn solve() -> Result<(Solution, Vec<PaneState>), ProblemError> {
    let assembled = Problem::new(block(Friction::coulomb(weakening())))?.assemble()?;
    let (solution, report) = assembled.solve_and_report(&SolveSettings::default())?;
    Ok((solution, report.panes))
}

fn main() -> Result<(), ProblemError> {
    let (solution, panes) = solve()?;
    println!("{}, {:.1e}", solution.status.word(), solution.accuracy);
    println!("pane  pressure/Pa  slip/m     F");
    for (number, pane) in panes.iter().enumerate() {
        let Some(friction) = &pane.friction else {
            continue;
        };
        let slip = friction.slip[0].hypot(friction.slip[1]);
        let coefficient = friction.coulomb.map_or(f64::NAN, |c| c.coefficients[0]);
        println!(
            "{number:4}  {:11.3e}  {slip:.2e}  {coefficient:.3}",
            -pane.normal_stress
        );
    }
    Ok(())
}
