//! Lengths of vectors, dense systems and eigenvalues.

use contact3d::linalg::{DenseLu, largest_eigenvalue, norm};

#[test]
fn norms_neither_overflow_nor_hide_what_is_not_finite() {
    // Two roundings.
    assert!((norm(&[3e200, 4e200]) / 5e200 - 1.0).abs() < 1e-15);
    assert_eq!(norm(&[]), 0.0);
    assert!(norm(&[f64::NAN, 0.0]).is_nan() && norm(&[f64::INFINITY, f64::NAN]).is_nan());
    assert_eq!(norm(&[f64::INFINITY, 1.0]), f64::INFINITY);
}

#[test]
fn solutions_and_signs_of_small_systems() {
    let lu = DenseLu::new(&[0.0, 2.0, 1.0, 3.0], 2).unwrap();
    assert_eq!(lu.sign, -1);
    let mut x = [1.0, 8.0];
    lu.solve(&mut x);
    assert_eq!(x, [2.5, 1.0]);
    let mut x = [2.0, 4.0];
    lu.solve_transposed(&mut x);
    assert_eq!(x, [1.0, 1.0]);
    assert!(DenseLu::new(&[1.0, 2.0, 2.0, 4.0], 2).is_none());
}

#[test]
fn the_largest_of_known_eigenvalues_is_found_from_above() {
    let eigenvalues: Vec<f64> = (1..=200).map(f64::from).collect();
    let estimate = largest_eigenvalue(200, |v| {
        v.iter().zip(&eigenvalues).map(|(v, e)| v * e).collect()
    });
    // The residual of at most 1 % is added to a Ritz value that is at most 1 % too small.
    assert!((estimate / 200.0 - 1.0).abs() < 0.02, "{estimate}");
    assert_eq!(largest_eigenvalue(3, |_| vec![0.0; 3]), 0.0);
}
