//! The approach of a ball against points of a half-space at infinity, δ = a²/R (Hertz): in blocks whose outer faces move as those of
//! a half-space do, and as the limit of ever larger blocks between rollers.

use super::{
    half_space::HalfSpace,
    hertz::{POISSON, YOUNG, pressed},
    moved::MATERIAL,
    planes::Planes,
    solved::Solved,
};

const HALF_SPACE: HalfSpace = HalfSpace {
    young: YOUNG,
    poisson: POISSON,
    middle: 0.0,
};
const RADIUS: f64 = 100.0;

fn force(a: f64) -> f64 {
    4.0 * HALF_SPACE.modulus() * a.powi(3) / (3.0 * RADIUS)
}

/// A quarter of a block of edge 1 on a ball; what the text holds and presses.
fn block(n: usize, k: f64, clamps: &str) -> Solved {
    let brick = Planes { n, k }.quarter(None);
    Solved::new(&format!(
        "title = 'approach'\n[body]\nelement = 'P2'\n[body.brick]\n{brick}\n{MATERIAL}{clamps}"
    ))
}

fn ball() -> String {
    format!(
        "multipliers = 'nodal'\nobstacle.sphere = {{ centre = [0.0, 0.0, {:?}], radius = {RADIUS:?} }}\n",
        -RADIUS
    )
}

/// a²/R for the force that was found less the approach that made it, over the latter: the outer faces of the block are moved
/// as points of a half-space that tend to −a²/R at infinity.
fn far_field_error(n: usize, a: f64) -> f64 {
    let walls = HALF_SPACE.under_points([0.0, force(a)], [0.0, -a * a / RADIUS]);
    let planes = ["x", "y"]
        .map(|along| format!("[[clamp]]\nface = '{along}_min'\ncomponents = ['{along}']\n"));
    let outer = ["x_max", "y_max", "z_max"]
        .map(|face| format!("[[clamp]]\nface = '{face}'\nvalue = {walls}\n"));
    let contact = format!("[contact]\nface = 'z_min'\n{}", ball());
    // The same number of cells in the contact whatever its share of the block.
    let k = (0.7 / a).ln() + 1.0;
    let solved = block(n, k, &[planes.concat(), outer.concat(), contact].concat());
    let found = 4.0 * solved.force()[2];
    (found / force(a)).powf(2.0 / 3.0) - 1.0
}

/// How far the upper face of a block between rollers moves, over a²/R for the force that was found, and that a.
fn between_rollers(n: usize, a: f64) -> [f64; 2] {
    let delta = a * a / RADIUS;
    let solved = block(n, 4.0, &pressed(delta, &ball()));
    let found = 4.0 * solved.force()[2];
    let a = (found / force(1.0)).cbrt();
    [delta * RADIUS / (a * a), a]
}

/// a²/R over how far the upper face moves, in the limit of large blocks: what the block adds is linear in a up to its cube.
fn limit_of_large_blocks(n: usize) -> f64 {
    let [[near, a], [far, b]] = [0.1, 0.2].map(|a| between_rollers(n, a));
    near + (near - far) * a / (b - a)
}

#[test]
fn a_ball_approaches_as_in_a_half_space() {
    // Six cells to the edge of the contact: 0.1 % at n = 9, 0.2 % at most up to n = 15.
    let error = far_field_error(9, 0.1);
    assert!(error.abs() < 5e-3, "{error}");
}

#[test]
fn larger_blocks_tend_to_a_half_space() {
    // 0.9 % at n = 9, 0.3 % at 12, 0.02 % at 15; the blocks themselves are 6 % and 12 % off.
    let limit = limit_of_large_blocks(9);
    assert!((limit - 1.0).abs() < 0.01, "{limit}");
}

#[test]
#[ignore = "the figures of docs/validation/benchmarks.md"]
fn figures_for_the_page() {
    for n in [6, 9, 12, 15] {
        println!("far field {n} {:.5}", far_field_error(n, 0.1));
    }
    for a in [0.4, 0.2, 0.1, 0.05] {
        println!("far field a = {a} {:.6}", far_field_error(12, a));
    }
    for n in [9, 12, 15] {
        for a in [0.05, 0.1, 0.2, 0.3] {
            println!("rollers {n} {:?}", between_rollers(n, a));
        }
    }
}
