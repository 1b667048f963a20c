//! Graded cells: shares of an edge, which are regularised incomplete beta functions I(i/n; p, q).

use contact3d::scene::{Brick, BrickFace};
use proptest::prelude::*;

/// The share of the edge that the first i of n cells have.
fn graded_share(i: usize, n: usize, [lower, upper]: [f64; 2]) -> f64 {
    Brick::new([1.0; 3], [n, 1, 1])
        .with_grading(BrickFace::XMin, lower)
        .with_grading(BrickFace::XMax, upper)
        .planes(0)[i]
}

/// I(s; 2, 2) = 3s² − 2s³ and I(s; 2, 3) = 6s² − 8s³ + 3s⁴.
#[test]
fn whole_exponents_give_polynomials() {
    for i in 0..=10 {
        let s = f64::from(i) / 10.0;
        let i = usize::try_from(i).expect("a small number");
        let found = [[2.0, 2.0], [2.0, 3.0]].map(|p| graded_share(i, 10, p));
        let exact = [
            s * s * (3.0 - 2.0 * s),
            s * s * (6.0 - 8.0 * s + 3.0 * s * s),
        ];
        // Sums of a few rounded terms.
        assert!((0..2).all(|k| (found[k] - exact[k]).abs() < 1e-15), "{s}");
    }
}

/// dI/ds = s^(p−1) (1 − s)^(q−1) / B, so the ratio of two differences is that of the integrands.
#[test]
fn widths_follow_the_density_for_any_exponents() {
    let n = 4000;
    for [p, q] in [[1.3, 2.7], [1.5, 1.5], [8.0, 1.01], [29.0, 30.0]] {
        let width = |i: usize| graded_share(i + 1, n, [p, q]) - graded_share(i, n, [p, q]);
        let density = |i: usize| {
            let s = (i as f64 + 0.5) / n as f64;
            (p - 1.0) * s.ln() + (q - 1.0) * (1.0 - s).ln()
        };
        for i in [1500, 1999, 2000, 2600] {
            let found = (width(i) / width(1800)).ln();
            // The midpoint rule on 1/4000: an error of some (30/4000)²/24 = 2e-6.
            assert!(
                (found - (density(i) - density(1800))).abs() < 1e-5,
                "{p} {q} {i}"
            );
        }
    }
}

proptest! {
    #[test]
    fn shares_grow_from_0_to_1_and_have_a_mirror_image(
        n in 1..60_usize,
        p in prop_oneof![Just(1.0), 1.0..4.0_f64],
        q in prop_oneof![Just(1.0), 1.0..4.0_f64],
    ) {
        let shares: Vec<f64> = (0..=n).map(|i| graded_share(i, n, [p, q])).collect();
        prop_assert_eq!([shares[0], shares[n]], [0.0, 1.0]);
        prop_assert!(shares.windows(2).all(|pair| pair[0] < pair[1]));
        for i in 0..=n {
            // One rounding of a difference from 1, and of some 60 terms.
            prop_assert!((shares[i] + graded_share(n - i, n, [q, p]) - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn an_exponent_near_1_is_nearly_no_grading(i in 0..=20_usize, p in 1.0..4.0_f64) {
        let found = graded_share(i, 20, [p, 1.0 + 1e-9]);
        // dI/dq is below one.
        prop_assert!((found - graded_share(i, 20, [p, 1.0])).abs() < 2e-9);
    }
}
