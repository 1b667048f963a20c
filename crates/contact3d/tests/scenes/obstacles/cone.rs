//! Sneddon's cone (I. N. Sneddon, Int. J. Engng Sci. 3 (1965) 47): an obstacle with an apex, where its height has no slope.
//!
//! For an angle β between cone and face, F = (π/2) E* a² tan β, and p = (E*/2) tan β arcosh(a/r), so ∫ p r² / ∫ p = a²/3.

use std::f64::consts::PI;

use super::{
    hertz::{POISSON, YOUNG, pressed},
    moved::MATERIAL,
    solved::Solved,
};

const TANGENT: f64 = 0.1;

/// The force on a quarter of a block that is pressed on a cone, and the radius of contact that it and the pressure have.
fn cone(height: &str, delta: f64) -> [f64; 3] {
    let contact = format!("obstacle.height.value = '{height}'\n");
    let body = format!(
        "title = 'cone'\n[body]\nelement = 'P2'\n[body.brick]\nsize = [8.0, 8.0, 8.0]\ncells = [10, 10, 8]\n\
         grading = {{ x_min = 2.0, y_min = 2.0, z_min = 2.0 }}\n{MATERIAL}"
    );
    let solved = Solved::new(&(body + &pressed(delta, &contact)));
    let force = 4.0 * solved.force()[2];
    let stiffness = YOUNG / (1.0 - POISSON * POISSON);
    let by_force = (2.0 * force / (PI * stiffness * TANGENT)).sqrt();
    let by_pressure = (3.0 * solved.pressure_mean(|x| x[0] * x[0] + x[1] * x[1])).sqrt();
    [force, by_force, by_pressure]
}

#[test]
fn a_cone_presses_as_in_closed_form_whatever_its_formula() {
    let [force, by_force, by_pressure] = cone("-0.1*sqrt(x^2 + y^2)", 0.1);
    // Three panes reach from the apex to a, the widest a quarter of it.
    assert!(
        (by_pressure / by_force - 1.0).abs() < 0.07,
        "{by_force} {by_pressure}"
    );
    let [other, ..] = cone("-0.1*(x^2 + y^2)^0.5", 0.1);
    // The same numbers but for roundings of a power.
    assert!((other / force - 1.0).abs() < 1e-9, "{other} {force}");
    // Below the face, which has as much more to go.
    let [lower, ..] = cone("-0.01 - 0.1*sqrt(x^2 + y^2)", 0.11);
    assert!((lower / force - 1.0).abs() < 0.01, "{lower} {force}");
}
