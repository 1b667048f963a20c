//! Projections on ellipses of friction and their derivatives.

use contact3d::contact::Ellipse;
use proptest::prelude::*;

fn distance(p: [f64; 2], q: [f64; 2]) -> f64 {
    (p[0] - q[0]).hypot(p[1] - q[1])
}

/// Nearest boundary point by a golden-section search over the angle of the first quadrant.
fn brute_force(ellipse: Ellipse, p: [f64; 2]) -> f64 {
    let [a, b] = ellipse.semi_axes;
    let at = |angle: f64| distance([a * angle.cos(), b * angle.sin()], [p[0].abs(), p[1].abs()]);
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

/// Central difference of the projection when z and the semi-axes move along given directions.
fn difference(ellipse: Ellipse, z: [f64; 2], dz: [f64; 2], da: [f64; 2], step: f64) -> [f64; 2] {
    let at = |s: f64| {
        let semi_axes = std::array::from_fn(|i| ellipse.semi_axes[i] + s * da[i]);
        Ellipse { semi_axes }.project(std::array::from_fn(|i| z[i] + s * dz[i]))
    };
    let (ahead, behind) = (at(step), at(-step));
    std::array::from_fn(|i| (ahead[i] - behind[i]) / (2.0 * step))
}

fn column(matrix: [[f64; 2]; 2], k: usize) -> [f64; 2] {
    [matrix[0][k], matrix[1][k]]
}

proptest! {
    #[test]
    fn derivative_equals_differences(
        a in 0.2..2.0_f64, b in 0.2..2.0_f64, angle in 0.0..std::f64::consts::TAU, level in 1.05..6.0_f64,
    ) {
        let ellipse = Ellipse { semi_axes: [a, b] };
        let z = [level * a * angle.cos(), level * b * angle.sin()];
        let derivative = ellipse.projection_derivative(z);
        for k in 0..2 {
            let unit: [f64; 2] = std::array::from_fn(|i| f64::from(u8::from(i == k)));
            let by_point = difference(ellipse, z, unit, [0.0; 2], 1e-5);
            let by_axes = difference(ellipse, z, [0.0; 2], unit, 1e-5);
            for i in 0..2 {
                // Central differences with step 1e-5: truncation 1e-10 times third derivatives,
                // which reach some hundreds beside the tip of an ellipse of ratio 10.
                prop_assert!((column(derivative.by_point, k)[i] - by_point[i]).abs() < 1e-6);
                prop_assert!((column(derivative.by_semi_axes, k)[i] - by_axes[i]).abs() < 1e-6);
            }
        }
    }

    /// P is positively homogeneous in (z, a, b) together: Euler's identity ∂p/∂z z + ∂p/∂(a,b)
    /// (a,b) = p.
    #[test]
    fn derivative_satisfies_eulers_identity_at_any_ratio(
        log_a in -100.0..100.0_f64, log_ratio in -12.0..12.0_f64,
        angle in 0.0..std::f64::consts::TAU, log_level in 0.01..8.0_f64,
    ) {
        let a = 10.0_f64.powf(log_a);
        let b = 10.0_f64.powf(log_a + log_ratio);
        let ellipse = Ellipse { semi_axes: [a, b] };
        let level = 10.0_f64.powf(log_level);
        let z = [level * a * angle.cos(), level * b * angle.sin()];
        let p = ellipse.project(z);
        let derivative = ellipse.projection_derivative(z);
        let (by_point, by_axes) = (derivative.by_point, derivative.by_semi_axes);
        for i in 0..2 {
            let terms = [
                by_point[i][0] * z[0], by_point[i][1] * z[1], by_axes[i][0] * a, by_axes[i][1] * b,
            ];
            let size = terms.iter().fold(p[i].abs(), |m, t| m.max(t.abs()));
            // Rounding of the multiplier, enlarged near the tips where it is ill-conditioned;
            // relative to the larger semi-axis it stays near rounding.
            let bound = 1e-9 * size + 1e-12 * a.max(b);
            prop_assert!((terms.iter().sum::<f64>() - p[i]).abs() <= bound);
        }
    }

    #[test]
    fn derivative_of_a_disc_has_its_closed_form(
        radius in 0.1..10.0_f64, angle in 0.0..std::f64::consts::TAU, level in 1.001..1e3_f64,
    ) {
        let ellipse = Ellipse { semi_axes: [radius; 2] };
        let n = [angle.cos(), angle.sin()];
        let z = n.map(|c| c * level * radius);
        let derivative = ellipse.projection_derivative(z);
        for i in 0..2 {
            for k in 0..2 {
                let identity = f64::from(u8::from(i == k));
                // p = radius z/‖z‖; a few roundings of numbers below 1.
                let expected = (identity - n[i] * n[k]) / level;
                prop_assert!((derivative.by_point[i][k] - expected).abs() < 1e-13);
            }
            // Both semi-axes grow together: p = radius n.
            let growth = derivative.by_semi_axes[i][0] + derivative.by_semi_axes[i][1];
            prop_assert!((growth - n[i]).abs() < 1e-13);
        }
    }
}

#[test]
fn inside_and_on_the_boundary_it_is_the_identity() {
    let ellipse = Ellipse {
        semi_axes: [2.0, 1.0],
    };
    for z in [[0.0, 0.0], [1.0, 0.5], [2.0, 0.0]] {
        let derivative = ellipse.projection_derivative(z);
        assert_eq!(derivative.by_point, [[1.0, 0.0], [0.0, 1.0]]);
        assert_eq!(derivative.by_semi_axes, [[0.0; 2]; 2]);
    }
}

#[test]
fn vanishing_semi_axes_take_limits_from_above() {
    let z = [3.0, 0.6];
    let limit = Ellipse {
        semi_axes: [0.0, 1.0],
    }
    .projection_derivative(z);
    let thin = Ellipse {
        semi_axes: [1e-9, 1.0],
    }
    .projection_derivative(z);
    for i in 0..2 {
        // The thin ellipse differs from its limit by O(a).
        assert!((limit.by_point[i][i] - thin.by_point[i][i]).abs() < 1e-7);
        assert!((limit.by_semi_axes[i][i] - thin.by_semi_axes[i][i]).abs() < 1e-7);
    }
    let point = Ellipse {
        semi_axes: [0.0; 2],
    }
    .projection_derivative([3.0, 4.0]);
    assert_eq!(point.by_point, [[0.0; 2]; 2]);
    assert_eq!(point.by_semi_axes, [[0.6, 0.0], [0.0, 0.8]]);
}
