//! Lengths of vectors.

use contact3d::linalg::norm;

#[test]
fn norms_neither_overflow_nor_hide_what_is_not_finite() {
    // Two roundings.
    assert!((norm(&[3e200, 4e200]) / 5e200 - 1.0).abs() < 1e-15);
    assert_eq!(norm(&[]), 0.0);
    assert!(norm(&[f64::NAN, 0.0]).is_nan() && norm(&[f64::INFINITY, f64::NAN]).is_nan());
    assert_eq!(norm(&[f64::INFINITY, 1.0]), f64::INFINITY);
}
