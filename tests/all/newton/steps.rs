//! How many Newton steps every scene takes, and that refinement does not add many.

use contact3d::{
    scene::{Coefficient::Constant, Friction},
    solver::StopReason,
};

use super::{dense::*, support::hkl_scene};

fn laws() -> Vec<(&'static str, Friction)> {
    let constants = |first, second| orthotropic(Constant(first), Constant(second));
    let published = |table| hkl_scene(table, 4).friction.expect("friction");
    let mut laws = vec![
        ("table 1", published(1)),
        ("table 2", published(2)),
        ("F = 1e-8", isotropic(Constant(1e-8))),
        ("F = 0.3", isotropic(Constant(0.3))),
        ("F1 / F2 = 1e3", constants(0.3, 0.3e-3)),
        ("F2 / F1 = 1e6", constants(0.3e-6, 0.3)),
        (
            "weakening 2 to 0.1 from 1e-5 m",
            isotropic(ramp(2.0, 0.1, 1e-5, 1e-4)),
        ),
        (
            "weakening 5 to 0.01 from 1e-5 m",
            isotropic(ramp(5.0, 0.01, 1e-5, 1e-5)),
        ),
    ];
    laws.extend(hard_laws());
    laws
}

/// The bound for every law; the published ones and constant coefficients need half of it.
const MOST_STEPS: usize = 16;

#[test]
fn steps_are_few_at_every_refinement() {
    for n_div in [4, 8, 16] {
        let case = Dense::new(hkl_scene(1, n_div));
        for (name, law) in laws() {
            let name = format!("{name}, n_div {n_div}");
            let solution = case.solve(&law);
            assert_eq!(solution.stop, StopReason::Converged, "{name}");
            assert!(
                solution.history.iter().all(|step| !step.safeguard),
                "{name}"
            );
            let steps = solution.history.len();
            let follows_slip = law.law().is_some_and(|law| law.depends_on_slip());
            let bound = if follows_slip && !name.starts_with("table") {
                MOST_STEPS
            } else {
                MOST_STEPS / 2
            };
            assert!(steps <= bound, "{name}: {steps} steps");
            // 1e-12 times the conditioning of the frozen problem, some hundreds at n_div = 16;
            // steep laws multiply rounding by dF/du.
            let image = case.distance_to_image(&law, &solution.unknowns);
            assert!(image < 1e-9, "{name}: {image:e}");
        }
    }
}

/// Laws that harden so steeply that relaxation does not settle: the method must notice the stall
/// and fall back on plain steps from the start.
#[test]
fn a_stall_of_the_relaxed_method_is_no_failure() {
    let law = orthotropic(
        ramp(0.448, 0.0123, 3e-5, 6.6e-5),
        ramp(0.0268, 3.7, 0.0, 2.6e-6),
    );
    let case = Dense::new(hkl_scene(1, 4));
    let solution = case.solve(&law);
    assert_eq!(solution.stop, StopReason::Converged);
    // As above.
    assert!(case.distance_to_image(&law, &solution.unknowns) < 1e-9);
}
