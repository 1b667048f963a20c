//! Tresca's law: the tangential stress is bounded by a given g, whatever the pressure.
//!
//! `cargo run --release -p contact3d --example tresca`

use contact3d::{
    Problem, ProblemError,
    post::{ContactReport, Zone},
    scene::{
        Body, Clamp, Contact, Friction, Material, Pressure, Quantity, Scene, SolveSettings,
        Traction,
    },
};

/// Area of the contact face in m².
pub(crate) const AREA: f64 = 3.0;

/// A block pulled along its foundation against a slip bound g in Pa.
pub(crate) fn solve(slip_bound: impl Into<Quantity>) -> Result<ContactReport, ProblemError> {
    let scene = Scene::new(
        Body::brick([3.0, 1.0, 1.0], [12, 4, 4]),
        Material::isotropic(2.1e11, 0.3),
    )
    .with_clamp(Clamp::face("x_min"))
    .with_pressure(Pressure::on("z_max", 2e7))
    .with_traction(Traction::on("x_max", [1e7, 0.0, 0.0]))
    .with_contact(Contact::on("z_min"))
    .with_friction(Friction::tresca(slip_bound));
    let assembled = Problem::new(scene)?.assemble()?;
    let (_, report) = assembled.solve_and_report(&SolveSettings::default())?;
    Ok(report)
}

/// Force of friction along the pull in N.
pub(crate) fn friction_force(report: &ContactReport) -> f64 {
    let contact = report.resultants.contact;
    let force = contact.and_then(|contact| contact.tangential_force);
    force.map_or(0.0, |[first, _]| first)
}

fn main() -> Result<(), ProblemError> {
    println!("g/Pa    friction/N    mean/Pa    slipping panes");
    for bound in [1e4, 1e5, 1e6, 1e7] {
        print_row(&format!("{bound:.0e}"), &solve(bound)?);
    }
    // A bound that varies over the face, as a formula of the place in m.
    let growing = Quantity::formula("2e4*x").expect("a formula");
    print_row("2e4 x", &solve(growing)?);
    Ok(())
}

fn print_row(bound: &str, report: &ContactReport) {
    let force = friction_force(report);
    let (mean, slipping) = (force / AREA, report.count(Zone::Slip));
    println!("{bound:6}  {force:11.4e}  {mean:9.2e}  {slipping}");
}
