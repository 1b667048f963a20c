//! Slips of panes and the tangential stresses that follow from them.

use super::piece::NodePiece;
use contact3d::contact::change_of_slips;

/// The stress p of a slipping pane as a smooth function of the trial stress z, of the slip bound g and of
/// 𝓕⁻¹ = diag(f₁, f₂).
///
/// Outside the ellipse with semi-axes g/f₁, g/f₂ it is the projection of z. With aₖ = fₖ⁻² that is pₖ = g aₖ zₖ/(τ + g aₖ),
/// Σ aₖ zₖ²/(τ + g aₖ)² = 1, the projection's multiplier being g τ: an equation that knows neither the sign of g nor that of τ.
/// Its largest root is the slip stress, also a little beyond τ = 0, where the pane would rather stick, and g = 0, where it
/// would rather open; so a path can overshoot and come back to the kink.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SlipStress {
    /// p.
    pub(super) stress: [f64; 2],
    /// τ, which has the unit of a stress: the pane slips while τ ≥ 0.
    pub(super) excess: f64,
    /// ∂p/∂z.
    pub(super) by_trial: [[f64; 2]; 2],
    /// ∂p/∂g.
    pub(super) by_bound: [f64; 2],
    /// ∂p/∂f.
    pub(super) by_inverse: [[f64; 2]; 2],
}

impl SlipStress {
    /// `None` where the direction of slip is not known, z = 0.
    pub(super) fn new(trial: [f64; 2], bound: f64, inverse: [f64; 2]) -> Option<Self> {
        let a = inverse.map(|f| (f * f).recip());
        let excess = excess(trial, bound, a)?;
        let d = [excess + bound * a[0], excess + bound * a[1]];
        // q = p/g; a component that is not loaded stays zero, whatever d is.
        let ratio = |k: usize| if trial[k] == 0.0 { 0.0 } else { a[k] / d[k] };
        let q = [0, 1].map(|k| ratio(k) * trial[k]);
        // Derivatives of φ = Σ aₖ zₖ²/dₖ² − 1.
        let square = [0, 1].map(|k| q[k] * trial[k] / d[k]);
        let square = square.map(|v| if v.is_finite() { v } else { 0.0 });
        let over = [0, 1].map(|k| if trial[k] == 0.0 { 0.0 } else { d[k].recip() });
        let by_excess = -2.0 * (square[0] * over[0] + square[1] * over[1]);
        let by_trial = [0, 1].map(|k| 2.0 * q[k] * over[k]);
        let by_bound = -2.0 * (a[0] * square[0] * over[0] + a[1] * square[1] * over[1]);
        let by_a = [0, 1].map(|k| {
            let t = trial[k] * over[k];
            t * t * (1.0 - 2.0 * bound * a[k] * over[k])
        });
        let excess_by_trial = by_trial.map(|v| -v / by_excess);
        let excess_by_bound = -by_bound / by_excess;
        let excess_by_a = by_a.map(|v| -v / by_excess);
        let along = [0, 1].map(|k| bound * q[k] * over[k]);
        Some(Self {
            stress: q.map(|q| bound * q),
            excess,
            by_trial: [0, 1].map(|k| {
                [0, 1].map(|l| {
                    let own = if k == l { bound * a[k] / d[k] } else { 0.0 };
                    own - along[k] * excess_by_trial[l]
                })
            }),
            by_bound: [0, 1].map(|k| q[k] - along[k] * (excess_by_bound + a[k])),
            by_inverse: [0, 1].map(|k| {
                [0, 1].map(|l| {
                    let own = if k == l {
                        bound * (trial[k] * over[k] - q[k] * bound * over[k])
                    } else {
                        0.0
                    };
                    (own - along[k] * excess_by_a[l]) * (-2.0 * a[l] / inverse[l])
                })
            }),
        })
    }
}

/// The largest root τ, by Newton's method from the left: φ is convex and falls there.
fn excess(trial: [f64; 2], bound: f64, a: [f64; 2]) -> Option<f64> {
    let reach = |share: f64| {
        let ends = [0, 1].map(|k| match trial[k] {
            0.0 => f64::NEG_INFINITY,
            z => share * a[k].sqrt() * z.abs() - bound * a[k],
        });
        ends[0].max(ends[1])
    };
    let mut excess = reach(1.0);
    if !excess.is_finite() {
        return None;
    }
    // Where both terms are one half, φ ≤ 0.
    let upper = reach(std::f64::consts::SQRT_2);
    // Most steps of Newton's method for τ, which converges monotonically.
    for _ in 0..60 {
        let (mut value, mut slope) = (-1.0, 0.0);
        for k in [0, 1] {
            if trial[k] != 0.0 {
                let d = excess + bound * a[k];
                let term = a[k] * (trial[k] / d).powi(2);
                value += term;
                slope -= 2.0 * term / d;
            }
        }
        let next = excess - value / slope;
        if !(next > excess && next <= upper) {
            break;
        }
        excess = next;
    }
    Some(excess)
}

/// φ at the contact nodes and how it moves with u_t there; nothing where the law does not follow it.
///
/// φ_k is u_tk times its sign on the piece, so it goes on below zero beyond a reversal.
pub(super) struct Slips {
    /// φ in m, `[n_contact_nodes]`, or empty.
    pub(super) value: Vec<[f64; 2]>,
    signs: Vec<[f64; 2]>,
}

impl Slips {
    /// From u_t at the contact nodes in m; empty where the law does not follow it.
    pub(super) fn on_piece(displacement: &[[f64; 2]], nodes: &[Option<NodePiece>]) -> Self {
        let sign = |negative: bool| if negative { -1.0 } else { 1.0 };
        let pieces = displacement.iter().zip(nodes);
        let signs = pieces.map(|(u, piece)| match piece {
            Some(piece) => piece.negative.map(sign),
            None => u.map(|u| sign(u < 0.0)),
        });
        let signs: Vec<[f64; 2]> = signs.collect();
        let pairs = displacement.iter().zip(&signs);
        Self {
            value: pairs
                .map(|(u, sign)| [sign[0] * u[0], sign[1] * u[1]])
                .collect(),
            signs,
        }
    }

    /// The change of φ with a change of u_t, given as pairs of the contact nodes.
    pub(super) fn change(&self, moved: &[f64]) -> Vec<[f64; 2]> {
        change_of_slips(&self.signs, |node| [moved[2 * node], moved[2 * node + 1]])
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use contact3d::contact::Ellipse;

    proptest! {
        /// Outside the ellipse it is the projection.
        #[test]
        fn slip_stress_is_the_projection(
            z in prop::array::uniform2(-3.0..3.0_f64), g in 0.01..2.0_f64, f in prop::array::uniform2(0.3..4.0_f64),
        ) {
            let ellipse = Ellipse { semi_axes: f.map(|f| g / f) };
            prop_assume!(ellipse.level(z) > 1.0);
            let slip = SlipStress::new(z, g, f).unwrap();
            prop_assert!(slip.excess > -1e-12);
            for (p, expected) in slip.stress.iter().zip(ellipse.project(z)) {
                // Both find a root of an equation with numbers up to 30 to rounding.
                prop_assert!((p - expected).abs() < 1e-12, "{p} {expected}");
            }
        }

        /// Its derivatives are those of differences, also beyond the bounds of slip.
        #[test]
        fn derivatives_equal_differences(
            z in prop::array::uniform2(0.5..3.0_f64), g in -0.05..2.0_f64, f in prop::array::uniform2(0.8..2.0_f64),
        ) {
            let slip = SlipStress::new(z, g, f).unwrap();
            prop_assume!(slip.excess > -0.1);
            let step = 1e-6;
            let at = |dz: [f64; 2], dg: f64, df: [f64; 2]| {
                let moved = |x: [f64; 2], d: [f64; 2]| [x[0] + step * d[0], x[1] + step * d[1]];
                SlipStress::new(moved(z, dz), g + step * dg, moved(f, df)).unwrap().stress
            };
            let unit = |l: usize| { let mut e = [0.0; 2]; e[l] = 1.0; e };
            let minus = |l: usize| unit(l).map(|v: f64| -v);
            let o = [0.0; 2];
            for k in 0..2 {
                for l in 0..2 {
                    let slope = (at(unit(l), 0.0, o)[k] - at(minus(l), 0.0, o)[k]) / (2.0 * step);
                    // Truncation 1e-12 times third derivatives below 1e3, cancellation 1e-10.
                    prop_assert!((slope - slip.by_trial[k][l]).abs() < 1e-7);
                    let slope = (at(o, 0.0, unit(l))[k] - at(o, 0.0, minus(l))[k]) / (2.0 * step);
                    prop_assert!((slope - slip.by_inverse[k][l]).abs() < 1e-7);
                }
                let slope = (at(o, 1.0, o)[k] - at(o, -1.0, o)[k]) / (2.0 * step);
                prop_assert!((slope - slip.by_bound[k]).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn a_disc_has_its_closed_form() {
        // p = g z / (f |z|) whatever the sign of g and of the excess |z|/f − g/f².
        for g in [2.0, 0.5, -0.1] {
            let slip = SlipStress::new([0.6, 0.8], g, [2.0; 2]).unwrap();
            // A few roundings.
            assert!((slip.stress[0] - 0.3 * g).abs() < 1e-15);
            assert!((slip.excess - (0.5 - 0.25 * g)).abs() < 1e-15);
        }
        assert_eq!(SlipStress::new([0.0; 2], 1.0, [1.0; 2]), None);
    }
}
