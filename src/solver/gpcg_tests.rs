//! GPCG on small dense problems.

use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use std::sync::atomic::AtomicUsize;

use super::{FeasibleSet, Gpcg, Kprgp, operator_norm};
use crate::{
    dual::DualOperator,
    linalg::{add_scaled, norm},
};

const PANES: usize = 4;
const N: usize = 3 * PANES;

/// A dense S; from action `broken_from` on it gives NaN.
struct Dense {
    matrix: DMatrix<f64>,
    rhs: Vec<f64>,
    actions: usize,
    broken_from: usize,
}

impl Dense {
    /// S = GᵀG + I, with zero rows and columns where `idle` says so.
    fn new(entries: &[f64], rhs: &[f64], idle: &[usize]) -> Self {
        let g = DMatrix::from_column_slice(N, N, entries);
        let mut matrix = g.transpose() * &g + DMatrix::identity(N, N);
        for &i in idle {
            matrix.row_mut(i).fill(0.0);
            matrix.column_mut(i).fill(0.0);
        }
        Self {
            matrix,
            rhs: rhs.to_vec(),
            actions: 0,
            broken_from: usize::MAX,
        }
    }

    fn gradient(&mut self, multiplier: &[f64]) -> Vec<f64> {
        let mut r = self.apply(multiplier);
        add_scaled(&mut r, -1.0, &self.rhs);
        r
    }

    fn solver(&mut self) -> Gpcg {
        Gpcg {
            steplength: 1.9 / operator_norm(self),
            max_actions: 100_000,
        }
    }
}

impl DualOperator for Dense {
    fn dimension(&self) -> usize {
        self.rhs.len()
    }
    fn rhs(&self) -> &[f64] {
        &self.rhs
    }
    fn apply(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.actions += 1;
        let product = &self.matrix * DVector::from_column_slice(multiplier);
        let broken = self.actions >= self.broken_from;
        let factor = if broken { f64::NAN } else { 1.0 };
        product.iter().map(|v| factor * v).collect()
    }
    fn to_primal(&mut self, _: &[f64]) -> Vec<f64> {
        Vec::new()
    }
    fn actions(&self) -> usize {
        self.actions
    }
}

fn entries() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-1.0..1.0_f64, N * N)
}

fn rhs() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-10.0..10.0_f64, N)
}

static PROJECTIONS: AtomicUsize = AtomicUsize::new(0);

fn set_of(semi_axes: Vec<[f64; 2]>) -> FeasibleSet<'static> {
    FeasibleSet::new(PANES, semi_axes, &PROJECTIONS)
}

/// Ellipses, thin ones, segments and points.
fn set() -> impl Strategy<Value = FeasibleSet<'static>> {
    let axis = || prop_oneof![Just(0.0), 1e-6..1e-3_f64, 0.1..3.0_f64];
    let ellipse = (axis(), axis()).prop_map(|(a, b)| [a, b]);
    prop::collection::vec(ellipse, PANES).prop_map(set_of)
}

/// ‖λ − P(λ − s r)‖, which vanishes for every s > 0 exactly at the minimiser.
fn projected_step(set: &FeasibleSet<'_>, multiplier: &[f64], r: &[f64], s: f64) -> f64 {
    let mut step = multiplier.to_vec();
    add_scaled(&mut step, -s, r);
    set.project(&mut step);
    add_scaled(&mut step, -1.0, multiplier);
    norm(&step)
}

proptest! {
    #[test]
    fn minimiser_satisfies_the_optimality_conditions(
        entries in entries(), rhs in rhs(), set in set(),
    ) {
        let mut operator = Dense::new(&entries, &rhs, &[]);
        let solver = operator.solver();
        let mut multiplier = vec![0.0; N];
        let outcome = solver.minimise(&mut operator, &set, &mut multiplier, 1e-10);
        prop_assert!(outcome.converged);
        let r = operator.gradient(&multiplier);
        // ‖g̃‖ ≤ 1e-10 bounds a projected step of length 0.3 by a small multiple of it.
        prop_assert!(projected_step(&set, &multiplier, &r, 0.3) < 1e-8);
    }

    #[test]
    fn agrees_with_kprgp(entries in entries(), rhs in rhs(), set in set()) {
        let mut operator = Dense::new(&entries, &rhs, &[]);
        let solver = operator.solver();
        let mut multiplier = vec![0.0; N];
        solver.minimise(&mut operator, &set, &mut multiplier, 1e-10);
        let Gpcg { steplength, max_actions } = solver;
        let kprgp = Kprgp { steplength, gamma: 1.0, max_actions };
        let mut expected = vec![0.0; N];
        kprgp.minimise(&mut operator, &set, &mut expected, 1e-10);
        add_scaled(&mut multiplier, -1.0, &expected);
        // The smallest eigenvalue of S is at least 1, so both errors are a few times 1e-10.
        prop_assert!(norm(&multiplier) < 1e-8);
    }

    /// Every step costs one action, and so does the start.
    #[test]
    fn steps_account_for_all_actions(
        entries in entries(), rhs in rhs(), set in set(), max_actions in 1..40_usize,
    ) {
        let mut operator = Dense::new(&entries, &rhs, &[]);
        let solver = Gpcg { max_actions, ..operator.solver() };
        operator.actions = 0;
        let steps = solver.minimise(&mut operator, &set, &mut [0.0; N], 1e-10).steps;
        let sum = steps.conjugate_gradient + steps.expansion + steps.proportioning;
        prop_assert_eq!(operator.actions, 1 + sum);
        prop_assert!(operator.actions <= max_actions);
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
        let solver = operator.solver();
        let mut multiplier = vec![0.0; N];
        let outcome = solver.minimise(&mut operator, &set, &mut multiplier, 1e-10);
        prop_assert!(outcome.converged);
        let r = operator.gradient(&multiplier);
        // As above.
        prop_assert!(projected_step(&set, &multiplier, &r, 0.3) < 1e-8);
    }

    /// Powers of two as units change no bit.
    #[test]
    fn units_do_not_matter(entries in entries(), rhs in rhs(), set in set()) {
        let mut operator = Dense::new(&entries, &rhs, &[]);
        let solver = operator.solver();
        let mut multiplier = vec![0.0; N];
        let outcome = solver.minimise(&mut operator, &set, &mut multiplier, 1e-10);
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
        let solver = operator.solver();
        let (mut sound, mut multiplier) = (vec![0.0; N], vec![0.0; N]);
        operator.actions = 0;
        solver.minimise(&mut operator, &set, &mut sound, 1e-10);
        let needed = operator.actions;
        operator.actions = 0;
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
        // A broken action, at most three trials of a face step, and the step that finds out.
        let allowed = if outcome.converged { needed + 4 } else { broken_from + 4 };
        prop_assert!(operator.actions <= allowed);
    }
}

#[test]
fn giving_up_is_reported() {
    let mut operator = Dense::new(&[0.5; N * N], &[1.0; N], &[]);
    let set = set_of(vec![[0.5, 0.2]; PANES]);
    let solver = Gpcg {
        steplength: 1e-6,
        max_actions: 3,
    };
    let outcome = solver.minimise(&mut operator, &set, &mut [0.0; N], 1e-14);
    assert!(!outcome.converged);
    assert_eq!(operator.actions, 3);
}
