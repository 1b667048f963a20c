//! What the parts of an assembly and a solve take, and GFlop/s of the factorisation.
//!
//! `cargo run --release -p contact3d --example speed -- 24 2 single` with n_div = 24, on two threads, with a factor in single
//! precision.

use std::time::Instant;

use contact3d::dual::OperatorEstimate;
use contact3d::scene::{FactorPrecision, SolveSettings};
use contact3d::{Problem, ProblemError};

#[path = "published_problem.rs"]
#[allow(dead_code)]
mod published_problem;

/// Solves with the factor that are timed.
const SOLVES: u32 = 10;

fn main() -> Result<(), ProblemError> {
    let mut arguments = std::env::args().skip(1);
    let mut number = || arguments.next().and_then(|text| text.parse().ok());
    let (n_div, threads) = (number().unwrap_or(16), number().unwrap_or(1));
    let precision = match arguments.next().as_deref() {
        Some("single") => FactorPrecision::Single,
        Some("double") => FactorPrecision::Double,
        _ => FactorPrecision::Auto,
    };
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()
        .expect("no pool yet");
    let mut scene = published_problem::scene(n_div);
    scene.assemble.factor = precision;
    let assembled = Problem::new(scene)?.assemble()?;
    let assembly = &assembled.system.assembly;
    let structure = assembly.factor.structure();
    println!(
        "{} unknowns, {} supernodes, {:.1} million coefficients in {} precision, {:.2} GFlop",
        assembled.n_free(),
        structure.supernodes(),
        structure.value_count() as f64 / 1e6,
        assembly.factor.precision().word(),
        structure.operations() / 1e9
    );
    for (part, seconds) in assembly.seconds.parts() {
        println!("{part:>15} {seconds:8.3} s");
    }
    println!(
        "factorisation {:.1} GFlop/s",
        structure.operations() / 1e9 / assembly.seconds.factorisation
    );
    let contact = assembled.system.contact.as_ref();
    if let (Some(contact), Some(state)) = (contact, assembled.contact_side()) {
        let nodes = state.surface.nodes.len();
        let operator = OperatorEstimate::new(structure, &contact.coupling, nodes);
        let operations = operator.explicit_operations / 1e9;
        println!(
            "dual operator {operations:.2} GFlop, {:.1} GFlop/s",
            operations / assembly.seconds.dual_operator
        );
    }
    let started = Instant::now();
    for _ in 0..SOLVES {
        let mut x = assembly.primal.load.clone();
        assembly.factor.solve_in_place(&mut x);
    }
    println!(
        "{:>15} {:8.3} s",
        "one solve",
        started.elapsed().as_secs_f64() / f64::from(SOLVES)
    );
    let started = Instant::now();
    let solution = assembled.solve(&SolveSettings::default())?;
    println!("{:>15} {:8.3} s", "solve", started.elapsed().as_secs_f64());
    let report = assembled.report(&solution)?;
    println!(
        "{}: error {:.1e} after {} steps, certificate {:.1e}",
        solution.status.word(),
        solution.accuracy,
        solution.trace.newton.len(),
        report.certificate.worst()
    );
    Ok(())
}
