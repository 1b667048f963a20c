//! Newton's method on sparse matrices is that on dense ones.

use super::{
    DelassusProblem, proximal,
    scaled::{MatrixForm, Scaled},
};
use crate::{
    dual::LocalStiffness,
    linalg::{CscMatrix, difference, norm},
    solver::{conditions::Bound, newton::natural_map::NaturalMap},
};

/// Both are rounded in other orders; S + α diag S has a condition number of about 1e6 for α = 1e-4.
const ROUNDED: f64 = 1e-8;

/// n point masses on each other, each on four points, and the lowest on the ground: forces that move two masses only, and only
/// together.
fn column(n: usize) -> DelassusProblem {
    let mut matrix = CscMatrix::empty(12 * n);
    for (mass, k) in (0..n).flat_map(|mass| (0..12).map(move |k| (mass, k % 3))) {
        for other in mass.saturating_sub(1)..n.min(mass + 2) {
            let moved = match (mass == other, mass) {
                (false, _) => -1.0,
                (true, 0) => 1.0,
                (true, _) => 2.0,
            };
            let points = (0..4).map(|point| 12 * other + 3 * point + k);
            matrix.indices.extend(points);
            matrix.data.extend([moved; 4]);
        }
        matrix.indptr.push(matrix.indices.len());
        matrix.cols += 1;
    }
    let mut offset = vec![0.0; 12 * n];
    for point in offset[..12].chunks_exact_mut(3) {
        point.copy_from_slice(&[-1.0, 0.05, 0.0]);
    }
    DelassusProblem::new(matrix, offset, vec![0.5; 4 * n]).expect("a problem")
}

#[test]
fn steps_and_stiffness_are_those_of_dense_matrices() {
    let problem = column(12);
    let scaled = Scaled::new(&problem);
    let laws = scaled.laws();
    let bound = Bound::Coulomb(&laws, laws.coulomb().expect("friction"));
    let n = scaled.rhs.len();
    let near = |a: &[f64], b: &[f64]| norm(&difference(a, b)) <= ROUNDED * norm(b);
    // Open, sticking and sliding contacts.
    let multiplier: Vec<f64> = (0..n).map(|j| (1.7 * j as f64).sin() + 0.2).collect();
    let [dense, sparse] = [MatrixForm::Dense, MatrixForm::Sparse].map(|form| {
        let dual = scaled.shifted(form, 1e-4, &vec![0.0; n]);
        let local = LocalStiffness::new(&dual);
        let map = NaturalMap::with_steplengths(&dual, bound, local.stiffness.clone());
        let evaluation = map.evaluate(&multiplier);
        let zones: Vec<_> = evaluation.panes.iter().map(|pane| pane.zone()).collect();
        let (step, free) = map.newton_step(&evaluation).expect("a regular matrix");
        let starts = [local.glued(&dual.rhs), local.pressed(&dual.rhs)];
        let mut relaxed = multiplier.clone();
        map.relax(&mut relaxed, 3);
        (zones, free, step, local.stiffness, starts, relaxed)
    });
    assert_eq!((&dense.0, dense.1), (&sparse.0, sparse.1));
    let several = dense.0.iter().any(|zone| *zone != dense.0[0]);
    assert!(several, "{:?}", dense.0);
    assert!(near(&sparse.2, &dense.2), "steps");
    assert!(near(&sparse.3, &dense.3), "stiffness");
    assert!(near(&sparse.4[0], &dense.4[0]) && near(&sparse.4[1], &dense.4[1]));
    assert!(near(&sparse.5, &dense.5), "relaxed");
}

/// Forces of a column are not unique, but velocities are.
#[test]
fn columns_move_alike_by_either_form() {
    let problem = column(20);
    let scaled = Scaled::new(&problem);
    let [dense, sparse] = [MatrixForm::Dense, MatrixForm::Sparse].map(|form| {
        let found = proximal::solve(&scaled, form, 1e-10);
        assert!(scaled.worst_error(&found.multiplier) <= 1e-10, "{form:?}");
        problem.velocity(&scaled.forces(&found.multiplier))
    });
    // The error is relative to forces, which are twenty times the largest velocity.
    let size = norm(problem.offset());
    assert!(norm(&difference(&dense, &sparse)) <= 1e-7 * size);
}
