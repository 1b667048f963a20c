//! The interior point method on made-up operators of any conditioning, against the conditions of the solution.

use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use super::{ConvexProgram, InteriorPoint, Motions, cone::largest_step};
use crate::{linalg::norm, solver::FeasibleSet};

/// How far the active set may be undecided, and what the violated conditions may then be, as shares of ‖λ‖.
const DECIDED: f64 = 1e-6;
const ACCURATE: f64 = 1e-4;

/// S = Σ 10^(−decades i/n) vᵢvᵢᵀ over orthonormal vectors, beside three motions that are 10^`loose` times softer.
fn operator(n: usize, entries: &[f64], decades: f64, loose: f64) -> DMatrix<f64> {
    let basis = DMatrix::from_column_slice(n, n, &entries[..n * n]).qr().q();
    let share = |i: usize| i as f64 / n as f64;
    let values = DVector::from_fn(n, |i, _| 10.0_f64.powf(-decades * share(i)));
    let mut operator = &basis * DMatrix::from_diagonal(&values) * basis.transpose();
    for i in 0..3.min(n) {
        let motion = DVector::from_fn(n, |j, _| entries[i * n + j]);
        operator += &motion * motion.transpose() * 10.0_f64.powf(loose);
    }
    0.5 * (&operator + operator.transpose())
}

/// A problem, with the motions that it must balance.
struct ConvexCase {
    operator: DMatrix<f64>,
    rhs: Vec<f64>,
    set: FeasibleSet,
    motions: Motions,
}

impl ConvexCase {
    /// The diagonal of S⁻¹, pairs taking the mean of their two.
    fn stiffness(&self) -> Vec<f64> {
        let inverse = self.operator.clone().try_inverse().unwrap();
        let mut stiffness: Vec<f64> = inverse.diagonal().iter().copied().collect();
        for pair in self.set.layout.split_mut(&mut stiffness).1 {
            *pair = [0.5 * (pair[0] + pair[1]); 2];
        }
        stiffness
    }

    /// ‖λ − P(λ − ρ (S λ − G α − h))‖ and ‖q − Gᵀλ − D α‖ beside ‖λ‖ and ‖q‖, of the interior point method.
    fn residuals(&self) -> Option<[f64; 2]> {
        let n = self.rhs.len();
        let stiffness = self.stiffness();
        let glued =
            self.operator.clone().cholesky()?.inverse() * DVector::from_row_slice(&self.rhs);
        let energy = glued.dot(&(&self.operator * &glued)).sqrt();
        let carried = norm(&self.motions.resultant);
        let entry = |i: usize, j: usize| self.operator[(i, j)];
        let bound = energy + carried;
        let (set, motions) = (&self.set, &self.motions);
        let program = ConvexProgram::new(entry, &self.rhs, set, &stiffness, bound, motions);
        let mut method = InteriorPoint::new(&program)?;
        assert!(method.run(DECIDED), "ended after {} steps", method.steps);
        let unknowns = method.unknowns(n);
        let (multiplier, motion) = unknowns.split_at(n);
        let mut gradient = &self.operator * DVector::from_row_slice(multiplier);
        let mut excess = DVector::from_row_slice(&self.motions.resultant);
        for (k, g) in self.motions.integrals.iter().enumerate() {
            let g = DVector::from_row_slice(g);
            gradient -= &g * motion[k];
            excess[k] -= g.dot(&DVector::from_row_slice(multiplier));
            excess[k] -= self.motions.support[k] * motion[k];
        }
        let mut trial: Vec<f64> = (0..n)
            .map(|i| multiplier[i] - stiffness[i] * (gradient[i] - self.rhs[i]))
            .collect();
        self.set.project(&mut trial);
        let moved: Vec<f64> = trial.iter().zip(multiplier).map(|(a, b)| a - b).collect();
        let equilibrium = if carried > 0.0 {
            excess.norm() / carried
        } else {
            0.0
        };
        Some([norm(&moved) / norm(multiplier), equilibrium])
    }
}

const PANES: usize = 12;

fn set_of(axes: &[f64], scale: f64) -> FeasibleSet {
    let axes = axes.chunks_exact(2);
    let axes = axes.map(|a| [a[0], a[1]].map(|a| scale * 10.0_f64.powf(a)));
    FeasibleSet::new(PANES, axes.collect())
}

/// A pressure falls to zero after the step that takes all of it: its roots are one, and rounding may put their distance below zero.
#[test]
fn the_step_of_a_pressure_ends_where_it_is_zero() {
    for (k, l) in (1..100).flat_map(|k| (1..100).map(move |l| (k, l))) {
        let (pressure, fall) = (f64::from(k) / 7.0, f64::from(l) / 3.0);
        let step = largest_step([pressure, 0.0, 0.0], [-fall, 0.0, 0.0]);
        // Half the digits, where a double root is that of a difference that is rounding.
        assert!(
            (step * fall / pressure - 1.0).abs() < 1e-7,
            "{k} {l}: {step}"
        );
    }
}

proptest! {
    // A fifth of the cases that other properties have, or of PROPTEST_CASES: each solves a problem in two ways.
    #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases / 5, ..ProptestConfig::default() })]

    #[test]
    fn convex_problems_are_solved_whatever_the_conditioning(
        entries in prop::collection::vec(-1.0..1.0_f64, 9 * PANES * PANES),
        rhs in prop::collection::vec(-1.0..1.0_f64, 3 * PANES),
        axes in prop::collection::vec(-3.0..3.0_f64, 2 * PANES),
        decades in 0.0..5.0_f64, loose in -3.0..4.0_f64,
        has_friction in any::<bool>(),
    ) {
        let n = if has_friction { 3 * PANES } else { PANES };
        let rhs = rhs[..n].to_vec();
        let axes = if has_friction { &axes[..] } else { &[] };
        let operator = operator(n, &entries, decades, loose);
        let problem = ConvexCase { operator, rhs, set: set_of(axes, 1.0), motions: Motions::default() };
        if let Some([residual, _]) = problem.residuals() {
            prop_assert!(residual <= ACCURATE, "{residual:e}");
        }
    }

    #[test]
    fn motions_are_balanced_by_contact_and_by_weak_supports(
        entries in prop::collection::vec(-1.0..1.0_f64, PANES * PANES),
        rhs in prop::collection::vec(-1.0..1.0_f64, PANES),
        pressures in prop::collection::vec(0.1..1.0_f64, PANES),
        decades in 0.0..4.0_f64, support in -8.0..2.0_f64, is_supported in any::<bool>(),
    ) {
        let motions: Vec<Vec<f64>> = (0..3)
            .map(|k| (0..PANES).map(|i| (i as f64 / PANES as f64).powi(k)).collect())
            .collect();
        let carried = |g: &Vec<f64>| g.iter().zip(&pressures).map(|(g, p)| g * p).sum();
        let stiffness = if is_supported { 10.0_f64.powf(support) } else { 0.0 };
        let problem = ConvexCase {
            operator: operator(PANES, &entries, decades, -9.0),
            rhs,
            set: set_of(&[], 1.0),
            motions: Motions {
                resultant: motions.iter().map(carried).collect(),
                support: vec![stiffness; 3],
                integrals: motions,
            },
        };
        let [residual, imbalance] = problem.residuals().unwrap();
        prop_assert!(residual <= ACCURATE && imbalance <= ACCURATE, "{residual:e} {imbalance:e}");
    }
}

/// Forces that pull all nodes off their foundation leave none in contact.
#[test]
fn where_nothing_presses_zero_is_the_answer() {
    let operator = DMatrix::from_fn(PANES, PANES, |i, j| if i == j { 2.0 } else { 0.1 });
    for (pressed, has_contact) in [(-1e-9, false), (0.0, false), (1e-9, true)] {
        let mut rhs = vec![-1.0; PANES];
        rhs[3] = pressed;
        let problem = ConvexCase {
            operator: operator.clone(),
            rhs,
            set: set_of(&[], 1.0),
            motions: Motions::default(),
        };
        let residuals = problem.residuals();
        assert_eq!(residuals.is_some(), has_contact, "{pressed}");
        assert!(residuals.is_none_or(|[residual, _]| residual <= ACCURATE));
    }
}

/// One node on a spring of stiffness 1: λ_ν = max(h_ν, 0), and λ_t is h_t as far as the ellipse lets it.
#[test]
fn one_node_has_its_closed_form() {
    for (rhs, expected) in [
        ([2.0, 0.3, 0.0], [2.0, 0.3, 0.0]),
        ([-1.0, 4.0, 0.0], [0.0, 0.5, 0.0]),
        ([1.0, 0.0, -7.0], [1.0, 0.0, -0.25]),
    ] {
        let set = FeasibleSet::new(1, vec![[0.5, 0.25]]);
        let entry = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let bound = norm(&rhs);
        let program = ConvexProgram::new(entry, &rhs, &set, &[1.0; 3], bound, &Motions::default());
        let mut method = InteriorPoint::new(&program).unwrap();
        assert!(method.run(1e-9));
        let found = method.unknowns(3);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() <= 1e-7, "{found} {expected}");
        }
    }
}
