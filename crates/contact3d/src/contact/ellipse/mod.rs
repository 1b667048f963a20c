//! Ellipses of friction: projection, its derivatives, the geometry of the boundary.

mod derivative;

pub use derivative::ProjectionDerivative;

/// The closed set (x/a)² + (y/b)² ≤ 1 with semi-axes a, b ≥ 0; a segment or a point when one or
/// both vanish.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipse {
    /// Semi-axes (a, b).
    pub semi_axes: [f64; 2],
}

/// A point this close to the level 1 counts as lying on the boundary: the projection and the
/// largest feasible step reach the level 1 up to a few roundings.
const BOUNDARY_ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Most steps for a projection, which takes some six.
const PROJECTION_MAX_STEPS: usize = 100;

impl Ellipse {
    /// The ellipse of vanishing semi-axes.
    pub(crate) const POINT: Self = Self {
        semi_axes: [0.0; 2],
    };

    /// ‖diag(1/a, 1/b) p‖: below 1 inside, 1 on the boundary. A vanishing semi-axis contributes 0
    /// for a vanishing component and +∞ otherwise.
    #[must_use]
    pub fn level(&self, p: [f64; 2]) -> f64 {
        let [x, y] = [0, 1].map(|i| {
            if p[i] == 0.0 {
                0.0
            } else {
                p[i].abs() / self.semi_axes[i]
            }
        });
        x.hypot(y)
    }

    /// Whether a feasible point lies on the boundary (every point of a degenerate ellipse does).
    #[must_use]
    pub fn on_boundary(&self, p: [f64; 2]) -> bool {
        self.semi_axes.contains(&0.0) || self.level(p) >= 1.0 - BOUNDARY_ROUNDING
    }

    /// The nearest point of the ellipse.
    #[must_use]
    pub fn project(&self, p: [f64; 2]) -> [f64; 2] {
        self.project_with_multiplier(p).0
    }

    /// The nearest point q and the multiplier t ≥ 0 of p = q + t (q₁/a², q₂/b²), in units of the
    /// larger semi-axis squared; t = 0 inside.
    ///
    /// Outside, t is the root of (a x/(t+a²))² + (b y/(t+b²))² = 1, a convex decreasing function
    /// on which Newton's method from max(a|x| − a², b|y| − b², 0) rises monotonically to the root.
    /// A point too far away for t to be a double has t = ∞ and projects as its direction does.
    #[must_use]
    pub fn project_with_multiplier(&self, p: [f64; 2]) -> ([f64; 2], f64) {
        let [a, b] = self.semi_axes;
        if a == 0.0 || b == 0.0 {
            let clamp = |v: f64, half: f64| if v.abs() > half { half.copysign(v) } else { v };
            return ([clamp(p[0], a), clamp(p[1], b)], 0.0);
        }
        if self.level(p) <= 1.0 {
            return (p, 0.0);
        }
        let scale = a.max(b);
        let axes = [a / scale, b / scale];
        let point = [p[0].abs() / scale, p[1].abs() / scale];
        let t = multiplier(axes, point);
        if t == f64::INFINITY {
            let [c1, c2] = self.far_direction(p);
            return (self.pull_to_boundary([a * c1, b * c2]), t);
        }
        let nearest: [f64; 2] = std::array::from_fn(|i| {
            let ratio = axes[i] * point[i] / (t + axes[i] * axes[i]);
            (axes[i] * ratio.min(1.0) * scale)
                .min(p[i].abs())
                .copysign(p[i])
        });
        (self.pull_to_boundary(nearest), t)
    }

    /// The largest step s ≥ 0 with p − s d in the ellipse, for p in the ellipse.
    #[must_use]
    pub fn largest_step(&self, p: [f64; 2], d: [f64; 2]) -> f64 {
        let scaled = |v: [f64; 2], i: usize| {
            if v[i] == 0.0 {
                0.0
            } else {
                v[i] / self.semi_axes[i]
            }
        };
        let (px, py) = (scaled(p, 0), scaled(p, 1));
        let (dx, dy) = (scaled(d, 0), scaled(d, 1));
        let square = dx * dx + dy * dy;
        if square == 0.0 {
            return f64::INFINITY;
        }
        let along = px * dx + py * dy;
        let inside = ((1.0 - px) * (1.0 + px) - py * py).max(0.0);
        let root = (along * along + square * inside).sqrt();
        // Of the two forms of the larger root the one without cancellation.
        if along >= 0.0 {
            (along + root) / square
        } else {
            inside / (root - along)
        }
    }

    /// c with P(s p) → (a c₁, b c₂) and ‖c‖ = 1 as s → ∞.
    pub(crate) fn far_direction(&self, p: [f64; 2]) -> [f64; 2] {
        let unit = |v: [f64; 2]| {
            let largest = v[0].abs().max(v[1].abs());
            v.map(|v| {
                if largest.is_infinite() {
                    f64::from(u8::from(v.is_infinite())).copysign(v)
                } else {
                    v / largest
                }
            })
        };
        let (axes, direction) = (unit(self.semi_axes), unit(p));
        let support = [axes[0] * direction[0], axes[1] * direction[1]];
        let length = support[0].hypot(support[1]);
        support.map(|v| v / length)
    }

    /// Removes the last roundings that leave a projected point outside.
    fn pull_to_boundary(&self, p: [f64; 2]) -> [f64; 2] {
        let level = self.level(p);
        if level > 1.0 { p.map(|v| v / level) } else { p }
    }
}

/// Root t of (a x/(t+a²))² + (b y/(t+b²))² = 1 for a point outside, semi-axes scaled to max 1.
fn multiplier(axes: [f64; 2], point: [f64; 2]) -> f64 {
    let [a, b] = axes;
    let mut t = (a * point[0] - a * a).max(b * point[1] - b * b).max(0.0);
    for _ in 0..PROJECTION_MAX_STEPS {
        let ratio = [0, 1].map(|i| axes[i] * point[i] / (t + axes[i] * axes[i]));
        // Newton on 1/level, nearly linear in t: few steps even far outside.
        let level = ratio[0].hypot(ratio[1]);
        let excess = level - 1.0;
        let slope = [0, 1]
            .map(|i| (ratio[i] / level) * (ratio[i] / (t + axes[i] * axes[i])))
            .iter()
            .sum::<f64>();
        let next = t + excess / slope;
        if next.is_nan() || next <= t || next.is_infinite() {
            break;
        }
        t = next;
    }
    t
}
