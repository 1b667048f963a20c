//! Where the planes between graded cells lie.

/// The share of an edge below plane i of n where cells shrink with exponents p and q towards its ends.
///
/// The regularised incomplete beta function I(i/n; p, q) (DLMF 8.17.2): the cells per length go with
/// s^(1−p) (1 − s)^(1−q), so their widths have no jump anywhere. Equal cells and one graded end, where it is a
/// power, are not left to a series, so they have the bits of that power.
#[must_use]
pub(super) fn graded_share(i: usize, n: usize, exponents: [f64; 2]) -> f64 {
    let below = i as f64 / n as f64;
    let above = (n - i) as f64 / n as f64;
    let [p, q] = exponents;
    match (p == 1.0, q == 1.0) {
        (true, true) => below,
        (false, true) => below.powf(p),
        (true, false) => 1.0 - above.powf(q),
        (false, false) if 2 * i <= n => integral(below, p, q) / whole(p, q),
        (false, false) => 1.0 - integral(above, q, p) / whole(p, q),
    }
}

/// B(1; p, q), both halves by the series where it converges fast.
fn whole(p: f64, q: f64) -> f64 {
    integral(0.5, p, q) + integral(0.5, q, p)
}

/// B(s; p, q) = ∫₀ˢ tᵖ⁻¹ (1 − t)^(q−1) dt for 0 ≤ s ≤ ½ and p, q ≥ 1, by the series of positive terms
/// sᵖ (1 − s)^q / p · (1 + Σₖ s^(k+1) Πⱼ₌₀ᵏ (p + q + j)/(p + 1 + j)) (DLMF 8.17.8).
fn integral(s: f64, p: f64, q: f64) -> f64 {
    let (mut sum, mut term, mut j) = (1.0, 1.0, 0.0);
    // Terms grow at most once and then fall, at last by the factor s.
    while term > 0.1 * f64::EPSILON * sum {
        term *= s * (p + q + j) / (p + 1.0 + j);
        sum += term;
        j += 1.0;
    }
    s.powf(p) * (1.0 - s).powf(q) / p * sum
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

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
}
