//! The examples give what is known from elsewhere: published values, closed forms, balances.

#[path = "../../examples/certificate.rs"]
#[expect(dead_code, reason = "an example's main is for its user")]
mod certificate;
#[path = "../../examples/law_as_formula.rs"]
#[expect(dead_code, reason = "an example's main is for its user")]
mod law_as_formula;
#[path = "../../examples/load_sweep.rs"]
#[expect(dead_code, reason = "an example's main is for its user")]
mod load_sweep;
#[path = "../../examples/own_mesh.rs"]
#[expect(dead_code, reason = "an example's main is for its user")]
mod own_mesh;
#[path = "../../examples/published_problem.rs"]
#[expect(dead_code, reason = "an example's main is for its user")]
mod published_problem;
#[path = "../../examples/tresca.rs"]
#[expect(dead_code, reason = "an example's main is for its user")]
mod tresca;

use std::path::Path;

use contact3d::{
    AssembledProblem, Problem,
    post::{ContactReport, Zone},
    scene::{Method, Quantity, SolveSettings},
    solver::Status,
};

fn relative(found: f64, expected: f64) -> f64 {
    (found / expected - 1.0).abs()
}

/// ‖x − y‖ / ‖y‖.
fn distance(x: &[f64], y: &[f64]) -> f64 {
    let size = |x: &mut dyn Iterator<Item = f64>| x.map(|v| v * v).sum::<f64>().sqrt();
    size(&mut x.iter().zip(y).map(|(x, y)| x - y)) / size(&mut y.iter().copied())
}

/// The converged values of an independent implementation at n_div = 8, all digits.
#[test]
fn the_published_problem_has_its_converged_values() {
    let (assembled, solution, report) = published_problem::solve(8).unwrap();
    // HKL's Table 1: 3n and 3m.
    assert_eq!((assembled.n_free(), 3 * assembled.n_panes()), (5832, 144));
    assert_eq!(solution.status, Status::Converged);
    let contact = report.resultants.contact.unwrap();
    // Half a unit of the last digit known.
    assert!((contact.normal_force - 5.883_717_33e7).abs() <= 0.5e-1);
    assert!((contact.largest_pressure - 3.750_408_53e7).abs() <= 0.5e-1);
    assert!((report.resultants.strain_energy - 7_150.207_88).abs() <= 0.5e-5);
    let zones = [Zone::Open, Zone::Slip, Zone::Stick].map(|zone| report.count(zone));
    assert_eq!(zones, [12, 30, 6]);
}

/// Loads, clamps and foundation balance, and friction stays below F times the pressure.
#[test]
fn the_foot_is_in_equilibrium() {
    let meshes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines/meshes");
    let (quality, report) = own_mesh::solve(&meshes.join("foot.msh")).unwrap();
    let r = &report.resultants;
    let contact = r.contact.unwrap();
    for c in 0..3 {
        let load = own_mesh::FORCE[c] * quality.total_volume;
        let largest = 4e6 * quality.total_volume;
        assert!((r.applied_force[c] - load).abs() < 1e-10 * largest);
        let sum = r.applied_force[c] + r.clamp_force[c] + contact.contact_force[c];
        assert!(sum.abs() < 1e-8 * largest, "{sum:e}");
    }
    let [first, second] = contact.tangential_force.unwrap();
    assert!(contact.normal_force > 0.0);
    assert!(first.hypot(second) <= 0.2 * contact.normal_force * (1.0 + 1e-9));
    assert!(report.panes.iter().all(|pane| pane.normal_stress <= 0.0));
}

/// The law at the slips found.
#[test]
fn panes_that_slide_obey_the_formula() {
    use law_as_formula::{KINETIC, STATIC, solve};
    let (solution, panes) = solve().unwrap();
    assert_eq!(solution.status, Status::Converged);
    let slipping = panes.iter().filter(|pane| pane.zone == Zone::Slip);
    assert!(slipping.clone().count() > 0);
    for pane in slipping {
        let friction = pane.friction.unwrap();
        let [first, second] = friction.stress;
        let [coefficient, _] = friction.coulomb.unwrap().coefficients;
        assert!((KINETIC..STATIC).contains(&coefficient));
        // Coulomb's law of a sliding pane, |σ_t| = F |σ_ν|.
        let bound = -coefficient * pane.normal_stress;
        assert!(relative(first.hypot(second), bound) < 1e-8);
    }
}

/// A sliding face bears g times its area, and a bound nobody reaches glues the face.
#[test]
fn tresca_friction_is_the_bound_times_the_area() {
    let sliding = tresca::solve(1e4).unwrap();
    let panes = sliding.panes.len();
    assert_eq!(sliding.count(Zone::Slip), panes);
    // All panes slide along x but for the sideways strain, which turns the stress by its Poisson share.
    let force = tresca::friction_force(&sliding);
    let lengths = sliding.panes.iter().map(|pane| {
        let [first, second] = pane.friction.unwrap().stress;
        first.hypot(second)
    });
    assert!(lengths.clone().all(|length| relative(length, 1e4) < 1e-9));
    assert!(force > 0.0 && force <= 1e4 * tresca::AREA);
    let glued = tresca::solve(1e9).unwrap();
    assert_eq!(glued.count(Zone::Stick), panes);
    // ∫ 2e4 x over (0, 3) × (0, 1) bounds the force of the last line.
    let growing = tresca::solve(Quantity::formula("2e4*x").unwrap()).unwrap();
    assert!(tresca::friction_force(&growing) <= 9e4);
}

/// Each case of the sweep has the bits of an assembly of its own, and forces grow with the loads.
#[test]
fn a_sweep_on_one_factor_is_many_assemblies() {
    let shared = Problem::new(load_sweep::block(0.0, 0.3)).unwrap();
    let shared = shared.assemble().unwrap();
    for (pull, friction) in [(0.0, 0.1), (1e7, 0.6)] {
        let own = Problem::new(load_sweep::block(pull, friction)).unwrap();
        let own = own.assemble().unwrap();
        let own = own.report(&own.solve(&SolveSettings::default()).unwrap());
        let one = load_sweep::solve(&shared, pull, friction).unwrap();
        let own = own.unwrap();
        assert_eq!(one.panes, own.panes);
        assert_eq!(one.displacement, own.displacement);
    }
    // Without a gap and with a constant F the problem is positively homogeneous of degree one.
    let solved = |problem: &AssembledProblem| -> ContactReport {
        let solution = problem.solve(&SolveSettings::default()).unwrap();
        problem.report(&solution).unwrap()
    };
    let single = solved(&shared);
    let double = shared.with_changes(|scene| scene.pressures[0].value = 4e7.into());
    let double = solved(&double.unwrap());
    for (one, two) in single.panes.iter().zip(&double.panes) {
        assert_eq!(one.zone, two.zone);
        assert!((two.normal_stress - 2.0 * one.normal_stress).abs() < 1e-9 * 4e7);
    }
}

/// Newton's answer satisfies every condition to rounding; the published stopping rule leaves an error that is told.
#[test]
fn certificates_tell_a_rounded_answer_from_a_stopped_one() {
    let assembled = certificate::assemble().unwrap();
    let (exact, sound) = certificate::certified(&assembled, Method::Newton).unwrap();
    assert_eq!(exact.status, Status::Converged);
    assert!(sound.worst() < 1e-10, "{sound:?}");
    let (rough, told) = certificate::certified(&assembled, Method::FixedPoint).unwrap();
    let error = distance(&rough.multiplier, &exact.multiplier);
    assert!(told.worst() > 1e3 * sound.worst());
    // The error that the solver measures is about the distance to Newton's answer.
    assert!(
        error > 1e-8 && relative(rough.accuracy, error) < 3.0,
        "{error:e}"
    );
}
