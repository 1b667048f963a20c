//! Frictionless contact of round bodies against the closed forms of Hertz (K. L. Johnson, *Contact Mechanics*, Cambridge
//! 1985, §4.2): peak pressure, size of the contact and approach, and the orders in which the errors fall.
//!
//! The upper faces of the blocks move δ towards the obstacle, between rollers.

use std::f64::consts::PI;

use super::{
    moved::{MATERIAL, moved},
    planes::Planes,
    solved::Solved,
};

pub(crate) const YOUNG: f64 = 1.0;
pub(crate) const POISSON: f64 = 0.3;

/// E* = E/(1 − ν²) of a body against a rigid one.
const E_STAR: f64 = YOUNG / (1.0 - POISSON * POISSON);

/// Rollers, of which those at the top move down by δ, and the contact face with its obstacle.
pub(crate) fn pressed(delta: f64, contact: &str) -> String {
    let rollers = [
        ("x_min", "x"),
        ("x_max", "x"),
        ("y_min", "y"),
        ("y_max", "y"),
    ];
    let rollers = rollers
        .map(|(face, along)| format!("[[clamp]]\nface = '{face}'\ncomponents = ['{along}']\n"))
        .concat();
    format!(
        "{rollers}[[clamp]]\nface = 'z_max'\ncomponents = ['z']\nvalue = [0.0, 0.0, {:?}]\n\
         [contact]\nface = 'z_min'\n{contact}",
        -delta
    )
}

fn block(brick: &str, delta: f64, contact: &str) -> Solved {
    let body =
        format!("title = 'hertz'\n[body]\nelement = 'P2'\n[body.brick]\n{brick}\n{MATERIAL}");
    Solved::new(&(body + &pressed(delta, contact)))
}

/// Peak pressure and radius for a force on a quarter of a contact with this relative radius, and what was found over
/// them less 1: ∫ p r² / ∫ p = 2a²/5 for p = p₀ √(1 − r²/a²).
fn point_errors(solved: &Solved, radius: f64) -> ([f64; 2], [f64; 2]) {
    let force = 4.0 * solved.force()[2];
    let a = (3.0 * force * radius / (4.0 * E_STAR)).cbrt();
    let peak = 3.0 * force / (2.0 * PI * a * a);
    let found = (2.5 * solved.pressure_mean(|x| x[0] * x[0] + x[1] * x[1])).sqrt();
    ([peak, a], [solved.peak() / peak - 1.0, found / a - 1.0])
}

/// Relative errors of p₀, a and the approach against a point of the surface some 3a away, for a rigid sphere of
/// radius 2 that makes a = 0.05.
fn sphere_errors(n: usize, multipliers: &str) -> [f64; 3] {
    let (radius, planes) = (2.0, Planes { n, k: 5.0 });
    let contact = format!(
        "multipliers = '{multipliers}'\nobstacle.sphere = {{ centre = [0.0, 0.0, -2.0], radius = 2.0 }}\n"
    );
    let solved = block(&planes.quarter(None), 0.05 * 0.05 / radius, &contact);
    let ([peak, a], [of_peak, of_a]) = point_errors(&solved, radius);
    // u_z of the surface beyond the contact (Johnson (3.42a)).
    let outside = |r: f64| {
        let angle = (2.0 * a * a - r * r) * (a / r).asin();
        peak / (2.0 * a * E_STAR) * (angle + r * a * (1.0 - a * a / (r * r)).sqrt())
    };
    let far = planes.beyond(3.0 * a);
    let moved = solved.lift([0.0; 3]) - solved.lift([far, 0.0, 0.0]);
    let approach = a * a / radius - outside(far);
    [of_peak, of_a, moved / approach - 1.0]
}

/// Relative errors of p₀ and b for a rigid cylinder of radius 2 along y that makes b near 0.03.
fn cylinder_errors(n: usize, multipliers: &str) -> [f64; 2] {
    let (radius, width, planes) = (2.0, 0.05, Planes { n, k: 5.0 });
    let contact = format!(
        "multipliers = '{multipliers}'\n\
         obstacle.cylinder = {{ point = [0.0, 0.0, -2.0], direction = [0.0, 1.0, 0.0], radius = 2.0 }}\n"
    );
    let delta = 4.0 * 0.03 * 0.03 / radius;
    let solved = block(&planes.quarter(Some(width)), delta, &contact);
    let force = 2.0 * solved.force()[2] / width;
    let b = (4.0 * force * radius / (PI * E_STAR)).sqrt();
    let peak = 2.0 * force / (PI * b);
    // ∫ p x² / ∫ p = b²/4 for p = p₀ √(1 − x²/b²).
    let found = (4.0 * solved.pressure_mean(|x| x[0] * x[0])).sqrt();
    [solved.peak() / peak - 1.0, found / b - 1.0]
}

/// Errors of p₀ and a where the lower face itself is round, convex for a positive radius, and a is near 0.08.
fn round_errors(n: usize, own_radius: f64, obstacle: &str, radius: f64, nodal: bool) -> [f64; 2] {
    let height = move |x: f64, y: f64| {
        let r = own_radius.abs();
        own_radius.signum() * (r - (r * r - x * x - y * y).sqrt())
    };
    let round = move |[x, y, z]: [f64; 3]| [x, y, z + (1.0 - z) * height(x, y)];
    let multipliers = if nodal { "nodal" } else { "panes" };
    let contact = format!("multipliers = '{multipliers}'\nobstacle.{obstacle}\n");
    let scene = pressed(0.08 * 0.08 / radius, &contact);
    // Flatter cells than those of the flat blocks would fold over the round face.
    let brick = Planes { n, k: 4.0 }.quarter(None);
    let solved = moved(&brick, "P2", round, &scene).unwrap_or_else(|error| panic!("{error}"));
    point_errors(&solved, radius).1
}

const PLANE: &str = "half_space = { point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }";
const CUP: &str = "sphere = { centre = [0.0, 0.0, 6.0], radius = 6.0, side = 'inside' }";
const BALL: &str = "sphere = { centre = [0.0, 0.0, -4.0], radius = 4.0 }";

/// A ball on a plane, a ball in a cup, a cup on a ball: 1/R = 1/R₁ − 1/R₂.
fn round_cases(n: usize, nodal: bool) -> [[f64; 2]; 3] {
    [
        round_errors(n, 4.0, PLANE, 4.0, nodal),
        round_errors(n, 4.0, CUP, 12.0, nodal),
        round_errors(n, -6.0, BALL, 12.0, nodal),
    ]
}

#[test]
fn a_rigid_sphere_presses_as_hertz_says() {
    let [coarse, fine] = [10, 15].map(|n| sphere_errors(n, "nodal"));
    // 14 cells per radius of the contact at n = 15; the block is 20 radii wide and deep.
    assert!(fine.iter().all(|e| e.abs() < 0.01), "{fine:?}");
    // Order 2 and better: 1.5² = 2.25.
    assert!(coarse[0] / fine[0] > 2.0 && coarse[1] / fine[1] > 2.0);
    let panes = sphere_errors(15, "panes");
    assert!(panes.iter().all(|e| e.abs() < 0.01), "{panes:?}");
}

#[test]
fn a_rigid_cylinder_presses_as_hertz_says() {
    for multipliers in ["panes", "nodal"] {
        let [coarse, fine] = [10, 40].map(|n| cylinder_errors(n, multipliers));
        // Cells of b/8 at the edge of the contact; the block is 33 half widths wide and deep.
        assert!(fine.iter().all(|e| e.abs() < 0.01), "{fine:?}");
        // Order 1 at least over two doublings, up to the size of the block.
        assert!(coarse[1].abs() > 4.0 * fine[1].abs(), "{coarse:?} {fine:?}");
    }
}

#[test]
fn round_faces_press_as_hertz_says() {
    for [of_peak, of_a] in round_cases(12, true) {
        assert!(
            of_peak.abs() < 0.01 && of_a.abs() < 0.01,
            "{of_peak} {of_a}"
        );
    }
}

#[test]
#[ignore = "the figures of docs/validation/benchmarks.md"]
fn figures_for_the_page() {
    for multipliers in ["panes", "nodal"] {
        for n in [5, 10, 15, 20] {
            println!(
                "sphere {multipliers} {n} {:.5?}",
                sphere_errors(n, multipliers)
            );
        }
        for n in [10, 20, 40, 80] {
            println!(
                "cylinder {multipliers} {n} {:.5?}",
                cylinder_errors(n, multipliers)
            );
        }
        for n in [6, 9, 12, 15] {
            let nodal = multipliers == "nodal";
            println!("round {multipliers} {n} {:.5?}", round_cases(n, nodal));
        }
    }
}
