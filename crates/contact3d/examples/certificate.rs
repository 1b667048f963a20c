//! Reading the certificate: how far an answer is from satisfying each condition of the discrete problem, for Newton's
//! method and for the paper's algorithm with its own stopping rule.
//!
//! `cargo run --release -p contact3d --example certificate`

use contact3d::{
    AssembledProblem, Problem, ProblemError,
    post::Certificate,
    scene::{
        Body, Clamp, Contact, Friction, Material, Method, Pressure, Scene, SolveSettings, Traction,
    },
    solver::Solution,
};

pub(crate) fn assemble() -> Result<AssembledProblem, ProblemError> {
    let scene = Scene::new(
        Body::brick([3.0, 1.0, 1.0], [12, 4, 4]),
        Material::isotropic(2.1e11, 0.3),
    )
    .with_clamp(Clamp::face("x_min"))
    .with_pressure(Pressure::on("z_max", 2e7))
    .with_traction(Traction::on("x_max", [1e7, 0.0, 0.0]))
    .with_contact(Contact::on("z_min"))
    .with_friction(Friction::orthotropic(0.3, 0.2));
    Problem::new(scene)?.assemble()
}

/// Solves by a method at its default accuracy.
pub(crate) fn certified(
    assembled: &AssembledProblem,
    method: Method,
) -> Result<(Solution, Certificate), ProblemError> {
    let settings = SolveSettings {
        method,
        ..SolveSettings::default()
    };
    let (solution, report) = assembled.solve_and_report(&settings)?;
    Ok((solution, report.certificate))
}

fn main() -> Result<(), ProblemError> {
    let assembled = assemble()?;
    for (name, method) in [
        ("Newton", Method::Newton),
        ("Algorithm 4.1", Method::FixedPoint),
    ] {
        let (solution, certificate) = certified(&assembled, method)?;
        println!(
            "{name}: {}, error {:.1e}",
            solution.status.word(),
            solution.accuracy
        );
        for (figure, value) in certificate.figures() {
            println!("  {figure:16} {value:.1e}");
        }
    }
    Ok(())
}
