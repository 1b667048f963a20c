//! Observed order and limit of a sequence v(h) = v₀ + C hᵖ (Richardson extrapolation).

/// Functionals of P1 solutions converge with order 2 at best; twice that means that the last
/// difference is small by chance.
const HIGHEST_ORDER: f64 = 4.0;

/// The order p of three values at the mesh sizes h₁ > h₂ > h₃, from
/// (v₁ − v₂)/(v₂ − v₃) = (h₁ᵖ − h₂ᵖ)/(h₂ᵖ − h₃ᵖ), whose right-hand side grows with p.
///
/// `None` where the values do not approach a limit: the differences change sign or grow too fast
/// for any p > 0, or are below `negligible`, where they are rounding.
#[must_use]
pub(crate) fn observed_order(h: [f64; 3], v: [f64; 3], negligible: f64) -> Option<f64> {
    let [first, second] = [v[0] - v[1], v[1] - v[2]];
    if first.abs() <= negligible || second.abs() <= negligible {
        return None;
    }
    let wanted = first / second;
    let slowest = (h[0] / h[1]).ln() / (h[1] / h[2]).ln();
    let ratio = |p: f64| {
        let [coarse, fine] = [h[0] / h[1], h[2] / h[1]].map(|r| (p * r.ln()).exp_m1());
        coarse / -fine
    };
    if !wanted.is_finite() || wanted <= slowest || wanted >= ratio(HIGHEST_ORDER) {
        return None;
    }
    let (mut low, mut high) = (0.0, HIGHEST_ORDER);
    // Each halving gains a bit; the 53 of a double suffice.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if ratio(middle) < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}

/// The limit v₀ of the last two values at h₂ > h₃ for a known order.
#[must_use]
pub fn extrapolated(h: [f64; 2], v: [f64; 2], order: f64) -> f64 {
    v[1] + (v[1] - v[0]) / ((h[0] / h[1]).powf(order) - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_power_law_is_recovered(
            order in 0.2..3.9_f64,
            ratios in [1.2..4.0_f64, 1.2..4.0_f64],
            limit in -3.0..3.0_f64,
            factor in prop_oneof![0.5..2.0_f64, -2.0..-0.5_f64],
        ) {
            let h = [1.0, 1.0 / ratios[0], 1.0 / (ratios[0] * ratios[1])];
            let v = h.map(|h| limit + factor * h.powf(order));
            let found = observed_order(h, v, 0.0).unwrap();
            // Values of size 3 rounded to 1e-16, over differences of 1e-2 at least: a loss of
            // three digits, and as many again for high orders.
            prop_assert!((found - order).abs() < 1e-9);
            let found = extrapolated([h[1], h[2]], [v[1], v[2]], order);
            // The same cancellation, divided by 1.2^0.2 − 1 = 0.04.
            prop_assert!((found - limit).abs() < 1e-11);
        }
    }

    #[test]
    fn no_order_is_claimed_without_convergence() {
        let h = [1.0, 0.5, 0.25];
        assert_eq!(observed_order(h, [0.0, 1.0, 0.5], 0.0), None);
        assert_eq!(observed_order(h, [0.0, 1.0, 2.0], 0.0), None);
        assert_eq!(observed_order(h, [0.0, 1.0, 1.0], 0.0), None);
        assert_eq!(observed_order(h, [0.0, 1e-12, 1.5e-12], 1e-11), None);
    }
}
