//! GPCG and KPRGP on small dense problems.

use contact3d::{
    linalg::{add_scaled, norm},
    solver::{FeasibleSet, Gpcg, InnerOutcome, Kprgp, projected_gradient_steplength},
};
use proptest::prelude::*;

use super::operator::{Dense, N, PANES, projected_step, set_of};

fn solver(operator: &mut Dense) -> Gpcg {
    Gpcg {
        steplength: projected_gradient_steplength(operator),
        max_applications: 100_000,
    }
}

/// A solver with what it makes of zero.
fn minimised(operator: &mut Dense, set: &FeasibleSet) -> (Gpcg, Vec<f64>, InnerOutcome) {
    let solver = solver(operator);
    let mut multiplier = vec![0.0; N];
    let outcome = solver.minimise(operator, set, &mut multiplier, 1e-10);
    (solver, multiplier, outcome)
}

fn entries() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-1.0..1.0_f64, N * N)
}

fn rhs() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-10.0..10.0_f64, N)
}

/// Ellipses, thin ones, segments and points.
fn set() -> impl Strategy<Value = FeasibleSet> {
    let axis = || prop_oneof![Just(0.0), 1e-6..1e-3_f64, 0.1..3.0_f64];
    let ellipse = (axis(), axis()).prop_map(|(a, b)| [a, b]);
    prop::collection::vec(ellipse, PANES).prop_map(set_of)
}

proptest! {
    #[test]
    fn minimiser_satisfies_the_optimality_conditions(
        entries in entries(), rhs in rhs(), set in set(),
    ) {
        let mut operator = Dense::new(&entries, &rhs, &[]);
        let (_, multiplier, outcome) = minimised(&mut operator, &set);
        prop_assert!(outcome.converged);
        let r = operator.gradient(&multiplier);
        // ‖g̃‖ ≤ 1e-10 bounds a projected step of length 0.3 by a small multiple of it.
        prop_assert!(projected_step(&set, &multiplier, &r, 0.3) < 1e-8);
    }

    #[test]
    fn agrees_with_kprgp(entries in entries(), rhs in rhs(), set in set()) {
        let mut operator = Dense::new(&entries, &rhs, &[]);
        let (solver, mut multiplier, _) = minimised(&mut operator, &set);
        let Gpcg { steplength, max_applications } = solver;
        let kprgp = Kprgp { steplength, gamma: 1.0, max_applications };
        let mut expected = vec![0.0; N];
        kprgp.minimise(&mut operator, &set, &mut expected, 1e-10);
        add_scaled(&mut multiplier, -1.0, &expected);
        // The smallest eigenvalue of S is at least 1, so both errors are a few times 1e-10.
        prop_assert!(norm(&multiplier) < 1e-8);
    }

    /// Every step costs one application, and so does the start.
    #[test]
    fn steps_account_for_all_applications(
        entries in entries(), rhs in rhs(), set in set(), max_applications in 1..40_usize,
    ) {
        let mut operator = Dense::new(&entries, &rhs, &[]);
        let solver = Gpcg { max_applications, ..solver(&mut operator) };
        operator.applications = 0;
        let steps = solver.minimise(&mut operator, &set, &mut [0.0; N], 1e-10).steps;
        let sum = steps.conjugate_gradient + steps.expansion + steps.proportioning;
        prop_assert_eq!(operator.applications, 1 + sum);
        prop_assert!(operator.applications <= max_applications);
    }

    /// A pane that feels nothing: its normal component has no stiffness, its pair neither
    /// stiffness nor, for every other problem, a force.
    #[test]
    fn zero_rows_are_no_obstacle(
        entries in entries(), rhs in rhs(), set in set(), forced in any::<bool>(),
    ) {
        let idle = [0, PANES, PANES + 1];
        let mut rhs = rhs;
        rhs[0] = -rhs[0].abs(); // otherwise there is no minimum
        if !forced {
            rhs[PANES..PANES + 2].fill(0.0);
        }
        let mut operator = Dense::new(&entries, &rhs, &idle);
        let (_, multiplier, outcome) = minimised(&mut operator, &set);
        prop_assert!(outcome.converged);
        let r = operator.gradient(&multiplier);
        // As above.
        prop_assert!(projected_step(&set, &multiplier, &r, 0.3) < 1e-8);
    }

    /// Powers of two as units change no bit.
    #[test]
    fn units_do_not_matter(entries in entries(), rhs in rhs(), set in set()) {
        let mut operator = Dense::new(&entries, &rhs, &[]);
        let (solver, multiplier, outcome) = minimised(&mut operator, &set);
        let (stress, volume) = (2.0_f64.powi(20), 2.0_f64.powi(-30));
        let scaled_axes = set.ellipses.iter().map(|e| e.semi_axes.map(|a| stress * a));
        let scaled_set = set_of(scaled_axes.collect());
        operator.matrix *= volume / stress;
        operator.rhs.iter_mut().for_each(|h| *h *= volume);
        let scaled_solver = Gpcg { steplength: solver.steplength * stress / volume, ..solver };
        let mut scaled = vec![0.0; N];
        let scaled_outcome =
            scaled_solver.minimise(&mut operator, &scaled_set, &mut scaled, 1e-10 * volume);
        prop_assert_eq!(scaled_outcome.steps, outcome.steps);
        let expected: Vec<f64> = multiplier.iter().map(|l| stress * l).collect();
        prop_assert_eq!(scaled, expected);
    }

    #[test]
    fn a_value_that_is_not_finite_ends_the_search(
        entries in entries(), rhs in rhs(), set in set(), broken_from in 1..30_usize,
    ) {
        let mut operator = Dense::new(&entries, &rhs, &[]);
        let solver = solver(&mut operator);
        let (mut sound, mut multiplier) = (vec![0.0; N], vec![0.0; N]);
        operator.applications = 0;
        solver.minimise(&mut operator, &set, &mut sound, 1e-10);
        let needed = operator.applications;
        operator.applications = 0;
        operator.broken_from = broken_from;
        let outcome = solver.minimise(&mut operator, &set, &mut multiplier, 1e-10);
        prop_assert!(outcome.converged || broken_from <= needed);
        prop_assert_eq!(outcome.converged, !outcome.reduced_gradient.is_nan());
        if outcome.converged {
            // Where only a trial beyond a good enough iterate broke, that iterate is the answer;
            // S ≥ 1, so the gradients 1e-10 of both bound their distance.
            let pairs = sound.iter().zip(&multiplier);
            prop_assert!(pairs.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) < 1e-9);
        }
        // A broken application, at most three trials of a face step, and the step that finds out.
        let allowed = if outcome.converged { needed + 4 } else { broken_from + 4 };
        prop_assert!(operator.applications <= allowed);
    }
}

#[test]
fn giving_up_is_reported() {
    let mut operator = Dense::new(&[0.5; N * N], &[1.0; N], &[]);
    let set = set_of(vec![[0.5, 0.2]; PANES]);
    let solver = Gpcg {
        steplength: 1e-6,
        max_applications: 3,
    };
    let outcome = solver.minimise(&mut operator, &set, &mut [0.0; N], 1e-14);
    assert!(!outcome.converged);
    assert_eq!(operator.applications, 3);
}

fn thin_set(bounds: &[f64]) -> FeasibleSet {
    set_of(bounds.iter().map(|g| [g / 2.0, g / 5.0]).collect())
}

proptest! {
    /// The minimiser is the only fixed point of a projected gradient step of any length.
    #[test]
    fn kprgp_minimiser_satisfies_the_optimality_conditions(
        entries in prop::collection::vec(-1.0..1.0_f64, N * N),
        rhs in prop::collection::vec(-10.0..10.0_f64, N),
        bounds in prop::collection::vec(prop_oneof![Just(0.0), 0.1..5.0_f64], PANES),
    ) {
        let mut operator = Dense::new(&entries, &rhs, &[]);
        let steplength = projected_gradient_steplength(&mut operator);
        let inner = Kprgp { steplength, gamma: 1.0, max_applications: 100_000 };
        let set = thin_set(&bounds);
        let mut multiplier = vec![0.0; N];
        let outcome = inner.minimise(&mut operator, &set, &mut multiplier, 1e-10);
        prop_assert!(outcome.converged);
        let r = operator.gradient(&multiplier);
        // ‖g̃‖ ≤ 1e-10 bounds a projected step of length 0.3 by a small multiple of it.
        prop_assert!(projected_step(&set, &multiplier, &r, 0.3) < 1e-8);
    }
}

#[test]
fn giving_up_of_kprgp_is_reported() {
    let mut operator = Dense::new(&[0.5; N * N], &[1.0; N], &[]);
    let inner = Kprgp {
        steplength: 1e-6,
        gamma: 1.0,
        max_applications: 3,
    };
    let outcome = inner.minimise(&mut operator, &thin_set(&[1.0; 4]), &mut [0.0; N], 1e-14);
    assert!(!outcome.converged);
}
