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
    pub(crate) fn largest_step(&self, p: [f64; 2], d: [f64; 2]) -> f64 {
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
    pub(in crate::solver) fn far_direction(&self, p: [f64; 2]) -> [f64; 2] {
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
    const MOST_STEPS: usize = 100;
    let [a, b] = axes;
    let mut t = (a * point[0] - a * a).max(b * point[1] - b * b).max(0.0);
    for _ in 0..MOST_STEPS {
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn distance(p: [f64; 2], q: [f64; 2]) -> f64 {
        (p[0] - q[0]).hypot(p[1] - q[1])
    }

    /// Nearest boundary point by a golden-section search over the angle of the first quadrant.
    fn brute_force(ellipse: Ellipse, p: [f64; 2]) -> f64 {
        let [a, b] = ellipse.semi_axes;
        let at =
            |angle: f64| distance([a * angle.cos(), b * angle.sin()], [p[0].abs(), p[1].abs()]);
        let quarter = std::f64::consts::FRAC_PI_2;
        let coarse = (0..=2000).map(|i| quarter * f64::from(i) / 2000.0);
        let best = coarse.min_by(|s, t| at(*s).total_cmp(&at(*t))).unwrap();
        let (mut low, mut high) = ((best - 1e-3).max(0.0), (best + 1e-3).min(quarter));
        for _ in 0..100 {
            let (s, t) = (low + 0.382 * (high - low), low + 0.618 * (high - low));
            if at(s) < at(t) { high = t } else { low = s }
        }
        at(0.5 * (low + high))
    }

    proptest! {
        #[test]
        fn projection_is_the_nearest_point(
            a in 0.05..2.0_f64, b in 0.05..2.0_f64, x in -5.0..5.0_f64, y in -5.0..5.0_f64,
        ) {
            let ellipse = Ellipse { semi_axes: [a, b] };
            let p = [x, y];
            let q = ellipse.project(p);
            prop_assert!(ellipse.level(q) <= 1.0 + 2.0 * f64::EPSILON);
            if ellipse.level(p) > 1.0 {
                // The search resolves a minimum to about the square root of rounding squared.
                prop_assert!((distance(p, q) - brute_force(ellipse, p)).abs() < 1e-12);
            } else {
                prop_assert_eq!(p, q);
            }
        }

        #[test]
        fn projection_has_the_symmetries_of_the_ellipse(
            a in 1e-3..1e3_f64, b in 1e-3..1e3_f64, x in -1e4..1e4_f64, y in -1e4..1e4_f64,
        ) {
            let ellipse = Ellipse { semi_axes: [a, b] };
            let [qx, qy] = ellipse.project([x, y]);
            prop_assert_eq!(ellipse.project([-x, y]), [-qx, qy]);
            prop_assert_eq!(ellipse.project([x, -y]), [qx, -qy]);
            prop_assert_eq!(Ellipse { semi_axes: [b, a] }.project([y, x]), [qy, qx]);
        }

        #[test]
        fn projection_satisfies_its_conditions_over_the_whole_double_range(
            log_a in -150.0..150.0_f64, log_ratio in -150.0..150.0_f64,
            log_x in -150.0..150.0_f64, log_y in -150.0..150.0_f64,
        ) {
            let a = 10.0_f64.powf(log_a);
            let b = 10.0_f64.powf((log_a + log_ratio).clamp(-150.0, 150.0));
            let (x, y) = (10.0_f64.powf(log_x), 10.0_f64.powf(log_y));
            let ellipse = Ellipse { semi_axes: [a, b] };
            let (q, t) = ellipse.project_with_multiplier([x, y]);
            prop_assert!(q[0].is_finite() && q[1].is_finite() && t >= 0.0);
            prop_assert!(q[0] >= 0.0 && q[0] <= x && q[1] >= 0.0 && q[1] <= y);
            let level = ellipse.level(q);
            if ellipse.level([x, y]) > 1.0 {
                // Newton stops within a few roundings of the level 1.
                prop_assert!((level - 1.0).abs() < 1e-13, "level {level}");
            }
        }

        #[test]
        fn largest_step_ends_on_the_boundary(
            a in 0.01..10.0_f64, b in 0.01..10.0_f64, r in 0.0..1.0_f64,
            angle in 0.0..std::f64::consts::TAU, dx in -1.0..1.0_f64, dy in -1.0..1.0_f64,
        ) {
            prop_assume!(dx.hypot(dy) > 1e-3);
            let ellipse = Ellipse { semi_axes: [a, b] };
            let p = [r * a * angle.cos(), r * b * angle.sin()];
            let s = ellipse.largest_step(p, [dx, dy]);
            let level = ellipse.level([p[0] - s * dx, p[1] - s * dy]);
            // Two divisions and a square root on well scaled numbers.
            prop_assert!((level - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn degenerate_ellipses_clamp() {
        assert_eq!(
            Ellipse {
                semi_axes: [0.0, 2.0]
            }
            .project([3.0, -5.0]),
            [0.0, -2.0]
        );
        assert_eq!(
            Ellipse {
                semi_axes: [0.0, 0.0]
            }
            .project([3.0, -5.0]),
            [0.0, 0.0]
        );
    }

    #[test]
    fn points_beyond_the_double_range_of_the_multiplier_project_as_their_direction() {
        let tiny = Ellipse {
            semi_axes: [3e-320, 1e-320],
        };
        // Support point (a² x, b² y)/‖(a x, b y)‖ of the direction (3, 4)/5, with the few digits of
        // subnormal numbers.
        let [x, y] = tiny.project([3e300, 4e300]);
        let length = 9.0_f64.hypot(4.0);
        assert!((x / 3e-320 - 9.0 / length).abs() < 1e-3);
        assert!((y / 1e-320 - 4.0 / length).abs() < 1e-3);
        let unit = Ellipse {
            semi_axes: [1.0, 1.0],
        };
        assert_eq!(unit.project([f64::INFINITY, 1.0]), [1.0, 0.0]);
        assert_eq!(unit.project([1.0, f64::NEG_INFINITY]), [0.0, -1.0]);
    }

    #[test]
    fn a_disc_scales() {
        let [x, y] = Ellipse {
            semi_axes: [2.0, 2.0],
        }
        .project([6.0, 8.0]);
        // Closed form (1.2, 1.6) to a few roundings.
        assert!((x - 1.2).abs() < 1e-15 && (y - 1.6).abs() < 1e-15);
    }
}
