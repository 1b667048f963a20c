//! How a pane rests on what lies opposite: waves of the gap inside it, and how far they close.
//!
//! A half-space resists waves of the number K like
//!
//!   k = E* K/2,  K² = ∫ |∇g|² / ∫ (g − ḡ)²,  1/E* = (1 − ν²)/E, of two bodies the sum of both,
//!
//! where g is what the mesh leaves between face and obstacle inside the pane; an open pane has k = 2 E*/h, h = √|R|. The narrower the share
//! σ of a pane that is pressed, the more it resists: κ k with κ = (1 + 3 σ̄⁻ⁿ)/4, n = 1 where g varies along one direction and 1/2 where
//! along two, of the mean σ̄ over the pressed panes around. Of waves a (1 − cos Kx), which a pressure λ_ν = k a sin²(πσ/2) closes so far
//! (H. M. Westergaard 1939), κ is that to an eighth.

use nalgebra::{Matrix3, Matrix3x2, Vector2, Vector3};

use crate::linalg::ratio;

/// Steps of Newton's method for c, and for the stiffness of a patch; more change no digit that is printed.
pub(super) const PATCH_STEPS: usize = 8;

/// How a pane rests on what lies opposite.
#[derive(Clone, Copy, Default)]
pub(super) struct Patch {
    /// κ k in Pa/m.
    pub(super) stiffness: f64,
    /// c in Pa.
    pub(super) excess: f64,
    /// 1 − σ, the share of the pane with z ≤ 0.
    pub(super) open: f64,
    /// p̂ in Pa.
    pub(super) wave: f64,
}

/// −g inside a pane.
#[derive(Default)]
pub(super) struct Opening {
    /// In m at the corners of parts of the pane, with their areas.
    pub(super) depths: Vec<([f64; 3], f64)>,
    /// ∫ ∇g ∇gᵀ in m².
    slopes: Matrix3<f64>,
}

impl Opening {
    /// Adds a part with its corners.
    pub(super) fn add(&mut self, corners: [[f64; 3]; 3], depths: [f64; 3], area: f64) {
        let [a, b, c] = corners.map(Vector3::from);
        let edges = Matrix3x2::from_columns(&[b - a, c - a]);
        let rises = Vector2::new(depths[1] - depths[0], depths[2] - depths[0]);
        if let Some(inverse) = (edges.transpose() * edges).try_inverse() {
            let slope = edges * (inverse * rises);
            self.slopes += slope * slope.transpose() * area;
        }
        self.depths.push((depths, area));
    }

    fn mean(&self, of: impl Fn([f64; 3]) -> f64) -> f64 {
        let terms = || self.depths.iter();
        terms().map(|(at, area)| area * of(*at)).sum::<f64>()
            / terms().map(|(_, area)| area).sum::<f64>()
    }

    /// The mean of (g − ḡ)² in m².
    fn variance(&self) -> f64 {
        let mean = self.mean(|at| at.iter().sum::<f64>() / 3.0);
        self.mean(|at| {
            let off = at.map(|depth| depth - mean);
            (off.iter().map(|d| d * d).sum::<f64>() + off.iter().sum::<f64>().powi(2)) / 12.0
        })
    }

    /// That of waves with this variance in m.
    pub(super) fn amplitude(&self) -> f64 {
        (2.0 * self.variance()).sqrt()
    }

    /// K in 1/m.
    pub(super) fn wave_number(&self) -> f64 {
        let whole: f64 = self.depths.iter().map(|(_, area)| area).sum();
        ratio(self.slopes.trace(), whole * self.variance()).sqrt()
    }

    /// n: 1 of waves along one direction, 1/2 of those along two.
    pub(super) fn exponent(&self) -> f64 {
        let trace = self.slopes.trace();
        let of_two = 2.0 * (1.0 - ratio((self.slopes * self.slopes).trace(), trace * trace));
        1.0 - 0.5 * of_two.clamp(0.0, 1.0)
    }

    /// The patch of a pressure in Pa for a stiffness in Pa/m, by Newton's method for c on the mean of z⁺, a convex function.
    pub(super) fn settled(&self, pressure: f64, stiffness: f64) -> Patch {
        let trial = |at: [f64; 3]| at.map(|depth| pressure + stiffness * depth);
        let mut patch = Patch {
            stiffness,
            // As if all of it were pressed, when the mean of z is linear in c.
            excess: self.mean(|at| trial(at).iter().sum::<f64>() / 3.0) - pressure,
            ..Patch::default()
        };
        for _ in 0..PATCH_STEPS {
            let z = |at| trial(at).map(|z| z - patch.excess);
            let force = self.mean(|at| positive_mean(z(at)));
            let share = self.mean(|at| positive_share(z(at)));
            // Convex, so c comes up to its root from below.
            if share <= 0.0 || force - pressure <= 1e-9 * pressure {
                break;
            }
            patch.open = 1.0 - share;
            patch.excess += (force - pressure) / share;
        }
        patch
    }
}

/// The mean over a triangle of the positive part of a linear function with these values at its corners.
fn positive_mean(corners: [f64; 3]) -> f64 {
    let largest = |values: [f64; 3]| values.into_iter().fold(0.0, f64::max);
    match corners.iter().filter(|v| **v > 0.0).count() {
        0 => 0.0,
        1 => positive_share(corners) * largest(corners) / 3.0,
        _ => {
            let negated = corners.map(|v| -v);
            let cut_off = 1.0 - positive_share(corners);
            corners.iter().sum::<f64>() / 3.0 + cut_off * largest(negated) / 3.0
        }
    }
}

/// The share of a triangle in which a linear function with these values at its corners is positive.
pub(super) fn positive_share(corners: [f64; 3]) -> f64 {
    let negated = corners.map(|v| -v);
    // The corner cut off by the line through zero: f(a)² / (f(a) − f(b)) (f(a) − f(c)) of the triangle.
    let cut_off = |values: [f64; 3]| {
        let [a, b, c] = match values.map(|v| v > 0.0) {
            [true, false, false] => values,
            [false, true, false] => [values[1], values[2], values[0]],
            _ => [values[2], values[0], values[1]],
        };
        a / (a - b) * (a / (a - c))
    };
    match corners.iter().filter(|v| **v > 0.0).count() {
        0 => 0.0,
        1 => cut_off(corners),
        2 if negated.iter().any(|v| *v > 0.0) => 1.0 - cut_off(negated),
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// Strips of a pane as long as a wave close as far as Westergaard's solution says.
    #[test]
    fn waves_close_as_in_closed_form() {
        let mut wave = Opening::default();
        for k in 0..200 {
            let [from, to] = [k, k + 1].map(|k| f64::from(k) / 200.0);
            let depth = |x: f64| (2.0 * PI * x).cos() - 1.0;
            wave.add(
                [[from, 0.0, 0.0], [to, 0.0, 0.0], [from, 1.0, 0.0]],
                [from, to, from].map(depth),
                1.0,
            );
            wave.add(
                [[to, 1.0, 0.0], [from, 1.0, 0.0], [to, 0.0, 0.0]],
                [to, from, to].map(depth),
                1.0,
            );
        }
        // 200 straight pieces of a wave.
        assert!((wave.wave_number() / (2.0 * PI) - 1.0).abs() < 1e-3);
        assert!((wave.exponent() - 1.0).abs() < 1e-12);
        for share in [0.05, 0.3, 0.6, 0.95] {
            let pressure = (PI * share / 2.0).sin().powi(2);
            let found = 1.0 - wave.settled(pressure, (1.0 + 3.0 / share) / 4.0).open;
            // A stiffness off by an eighth moves the edge by a third of that where the patch is narrow, by nearly a half where it is wide.
            assert!((found / share - 1.0).abs() < 0.06, "{found} {share}");
        }
    }

    #[test]
    fn lines_cut_triangles_in_closed_form() {
        for (corners, share) in [
            ([1.0, -1.0, -1.0], 0.25),
            ([-1.0, 1.0, 1.0], 0.75),
            ([-2.0, 1.0, -2.0], 1.0 / 9.0),
            ([1.0, 2.0, 0.0], 1.0),
            ([0.0, 0.0, 0.0], 0.0),
            ([3.0, 1.0, -1.0], 1.0 - 1.0 / 8.0),
        ] {
            assert!(
                (positive_share(corners) - share).abs() < 1e-15,
                "{corners:?}"
            );
        }
    }
}
