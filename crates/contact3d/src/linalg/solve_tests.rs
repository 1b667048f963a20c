//! Tests of solves on a part of the elimination tree and of solves with a factor in single precision.

use super::{
    CholeskyFactor, CscMatrix, Factor, StoppingRule, Workspace, amd, conjugate_gradients,
    difference, norm, test_brick::Brick,
};

fn stiffness_and_factor(n: usize) -> (CscMatrix, CholeskyFactor) {
    let stiffness = Brick::new(n).stiffness();
    let order = amd(&stiffness).expect("square");
    let factor = CholeskyFactor::<f64>::factorise(&stiffness, order).expect("positive definite");
    (stiffness, factor)
}

/// Numbers in [−1, 1] without a pattern.
fn noise(length: usize, seed: u64) -> Vec<f64> {
    (0..length)
        .map(|i| (1e3 * (i as f64 + seed as f64)).sin())
        .collect()
}

#[test]
fn reached_solve_equals_the_full_solve() {
    let brick = Brick::new(6);
    let (_, factor) = stiffness_and_factor(6);
    let rows: Vec<usize> = brick
        .contact_nodes
        .iter()
        .flat_map(|&node| 3 * node..3 * node + 3)
        .take(60)
        .collect();
    let reach = factor.structure().reach(rows.iter().copied());
    assert!(reach.len() < factor.structure().supernodes());
    let mut full = vec![0.0; factor.size()];
    rows.iter()
        .zip(noise(rows.len(), 3))
        .for_each(|(&row, value)| full[row] = value);
    let mut reached = full.clone();
    // leftovers of an earlier solve in the work space must not matter
    let mut work = Workspace::default();
    factor.solve_in_place(&mut noise(factor.size(), 4), &mut work);
    factor.solve_reached(&reach, &mut reached, &mut work);
    factor.solve_in_place(&mut full, &mut work);
    for row in rows {
        // the same sums in another order
        assert!((full[row] - reached[row]).abs() < 1e-12 * full[row].abs().max(1e-3 * norm(&full)));
    }
}

#[test]
fn conjugate_gradients_reach_double_precision_with_a_factor_in_single() {
    let stiffness = Brick::new(8).stiffness();
    let order = amd(&stiffness).expect("square");
    let exact =
        CholeskyFactor::<f64>::factorise(&stiffness, order.clone()).expect("positive definite");
    let factor =
        Factor::Single(CholeskyFactor::factorise(&stiffness, order).expect("positive definite"));
    let b = noise(stiffness.cols, 9);
    let work = &mut Workspace::default();
    let mut expected = b.clone();
    exact.solve_in_place(&mut expected, work);
    let mut rough = b.clone();
    factor.solve_in_place(&mut rough, work);
    let accuracy = StoppingRule {
        share: 1e-12,
        length: 0.0,
    };
    let [solved] = &conjugate_gradients(&stiffness, &factor, &[&b], accuracy, work)[..] else {
        panic!("one right-hand side");
    };
    // Rounding in single precision times the condition number, some thousands; then that of double precision.
    assert!((1e-8..1e-2).contains(&(norm(&difference(&rough, &expected)) / norm(&expected))));
    assert!(norm(&difference(&solved.solution, &expected)) < 1e-11 * norm(&expected));
    assert!(
        solved.steps <= 6 && solved.contraction() < 0.1,
        "{solved:?}"
    );
}
