//! Loads between the ends of steps, as formulas made of those of the ends.

use contact3d::scene::{Quantity, Scene};

/// A block whose traction along x goes from one formula to another in four increments.
fn history(first: &str, second: &str) -> Scene {
    let text = format!(
        r#"
        title = "between"
        parameters = {{ a = 3.0, b = 5.0 }}
        clamp = [{{ face = "x_min" }}]
        body.brick = {{ size = [1.0, 1.0, 1.0], cells = [2, 2, 2] }}
        material.isotropic = {{ young_modulus = 1.0, poisson_ratio = 0.3 }}
        traction = [{{ face = "x_max", value = ["{first}", 0.0, 0.0] }}]
        [[step]]
        [[step]]
        increments = 4
        value."traction.0" = ["{second}", 0.0, 0.0]
        "#
    );
    Scene::parse("between", &text).unwrap_or_else(|error| panic!("{error}"))
}

/// The traction along x at the end of the first of the four increments.
fn after_a_quarter(scene: &Scene) -> Quantity {
    let increment = scene.increments()[1];
    assert_eq!(increment.share, 0.25);
    let scene = scene.at_increment(increment).expect("values of one shape");
    scene.tractions[0].value[0].clone()
}

#[test]
fn formulas_with_parameters_of_their_own_are_weighted_and_added() {
    let between = after_a_quarter(&history("a*y - b", "b*z + a*b"));
    // 3/4 (3 · 2 − 5) + 1/4 (5 · 4 + 15), exact in binary numbers.
    assert_eq!(between.at([0.0, 2.0, 4.0]), 9.5);
    let Quantity::Varying(formula) = between else {
        panic!("a number");
    };
    assert_eq!(formula.text(), "0.75*(a*y - b) + 0.25*(b*z + a*b)");
    let between = after_a_quarter(&history("a*y - b", "8"));
    assert_eq!(between.at([0.0, 2.0, 4.0]), 2.75);
}

#[test]
fn formulas_of_any_length_lead_from_one_to_another() {
    // Each is nearly as long as a formula may be.
    let long = |name: &str| vec![name; 1000].join(" + ");
    let between = after_a_quarter(&history(&long("y"), &long("z")));
    assert_eq!(between.at([0.0, 2.0, 4.0]), 2500.0);
}
