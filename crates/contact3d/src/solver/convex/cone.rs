//! Cones of second order in three dimensions and their scaling by Nesterov and Todd.
//!
//! A pressure is a cone of its own, (λ_ν, 0, 0); a pair in an ellipse of semi-axes a, b is (1, λ_1/a, λ_2/b).
//! Source: Yu. Nesterov, M. Todd, *SIAM J. Optim.* 8 (1998) 324; L. Vandenberghe, *The CVXOPT linear and quadratic cone
//! program solvers*, 2010, §4.

use std::array::from_fn;

/// A vector (s₀, s₁, s₂), of the cone where s₀ ≥ ‖(s₁, s₂)‖.
pub(super) type Point = [f64; 3];

pub(super) const IDENTITY: Point = [1.0, 0.0, 0.0];

pub(super) fn inner(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a₀b₀ − a₁b₁ − a₂b₂.
fn hyperbolic(a: Point, b: Point) -> f64 {
    a[0] * b[0] - a[1] * b[1] - a[2] * b[2]
}

/// (a₀, −a₁, −a₂).
fn reflected(a: Point) -> Point {
    [a[0], -a[1], -a[2]]
}

/// s₀² − s₁² − s₂² without cancellation of squares.
pub(super) fn determinant(s: Point) -> f64 {
    let length = s[1].hypot(s[2]);
    (s[0] - length) * (s[0] + length)
}

/// The product a ∘ b of Jordan's algebra.
pub(super) fn product(a: Point, b: Point) -> Point {
    [
        inner(a, b),
        a[0] * b[1] + b[0] * a[1],
        a[0] * b[2] + b[0] * a[2],
    ]
}

/// The u with a ∘ u = b.
fn quotient(a: Point, b: Point) -> Point {
    let first = hyperbolic(a, b) / determinant(a);
    [
        first,
        (b[1] - first * a[1]) / a[0],
        (b[2] - first * a[2]) / a[0],
    ]
}

/// a + t b.
pub(super) fn shifted(a: Point, t: f64, b: Point) -> Point {
    from_fn(|k| a[k] + t * b[k])
}

/// The largest t with s + t d in the cone, for s inside.
pub(super) fn largest_step(s: Point, d: Point) -> f64 {
    let (here, slope, square) = (determinant(s), hyperbolic(s, d), hyperbolic(d, d));
    // For a pressure both are equal but for rounding.
    let root = (slope * slope - here * square).max(0.0).sqrt();
    let step = here / (root - slope);
    // Without a positive root of det(s + t d) the ray stays inside.
    if step > 0.0 { step } else { f64::INFINITY }
}

/// The smaller eigenvalue of s ∘ z in the scaled cone, where both are the same point.
pub(super) fn smaller_eigenvalue(s: Point, z: Point) -> f64 {
    let (trace, square) = (inner(s, z), determinant(s) * determinant(z));
    square / (trace + (trace * trace - square).max(0.0).sqrt())
}

/// W with W z = W⁻¹ s for two points inside the cone.
pub(super) struct Scaling {
    /// (det s / det z)^¼.
    size: f64,
    /// The direction of W², of determinant one.
    direction: Point,
    /// The direction of W.
    root: Point,
    /// W z = W⁻¹ s.
    pub(super) point: Point,
}

impl Scaling {
    pub(super) fn new(s: Point, z: Point) -> Self {
        let (by_s, by_z) = (determinant(s).sqrt(), determinant(z).sqrt());
        let (s, z) = (s.map(|v| v / by_s), z.map(|v| v / by_z));
        let length = (2.0 * (1.0 + inner(s, z))).sqrt();
        let direction = shifted(s, 1.0, reflected(z)).map(|v| v / length);
        let length = (2.0 * (direction[0] + 1.0)).sqrt();
        let root = shifted(direction, 1.0, IDENTITY).map(|v| v / length);
        let mut scaling = Self {
            size: (by_s / by_z).sqrt(),
            direction,
            root,
            point: IDENTITY,
        };
        scaling.point = scaling.apply(z.map(|v| v * by_z));
        scaling
    }

    /// W u.
    pub(super) fn apply(&self, u: Point) -> Point {
        let projection = 2.0 * inner(self.root, u);
        let reflected = reflected(u);
        from_fn(|k| self.size * (projection * self.root[k] - reflected[k]))
    }

    /// W⁻¹ u.
    pub(super) fn apply_inverse(&self, u: Point) -> Point {
        let root = reflected(self.root);
        let projection = 2.0 * inner(root, u);
        let reflected = reflected(u);
        from_fn(|k| (projection * root[k] - reflected[k]) / self.size)
    }

    /// W⁻¹ (W z \ u), where λ \ u is the x with λ ∘ x = u.
    pub(super) fn unscaled_quotient(&self, u: Point) -> Point {
        self.apply_inverse(quotient(self.point, u))
    }

    /// An entry of W⁻².
    pub(super) fn inverse_square(&self, i: usize, j: usize) -> f64 {
        let direction = reflected(self.direction);
        let own = match (i, j) {
            (0, 0) => -1.0,
            _ if i == j => 1.0,
            _ => 0.0,
        };
        (2.0 * direction[i] * direction[j] + own) / (self.size * self.size)
    }
}
