//! Elasticity tensors of orthotropic materials.

use contact3d::scene::{Material, Orthotropic};
use nalgebra::Matrix6;

/// Axes along x and y.
const GLOBAL: [[f64; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn wood(axes: [[f64; 3]; 2]) -> Matrix6<f64> {
    let constants = Orthotropic {
        young_moduli: [11e9, 0.8e9, 0.5e9],
        poisson_ratios: [0.4, 0.45, 0.37],
        shear_moduli: [0.05e9, 0.6e9, 0.7e9],
        axes,
    };
    Material::Orthotropic(constants).elasticity().unwrap()
}

#[test]
fn equal_constants_are_isotropic() {
    let isotropic = Material::isotropic(2e11, 0.3);
    let shear = 2e11 / 2.6;
    let orthotropic = Material::Orthotropic(Orthotropic {
        young_moduli: [2e11; 3],
        poisson_ratios: [0.3; 3],
        shear_moduli: [shear; 3],
        axes: [[1.0, 2.0, 0.5], [-2.0, 1.0, 0.0]],
    });
    let difference = orthotropic.elasticity().unwrap() - isotropic.elasticity().unwrap();
    // Some ten roundings of numbers near 3e11.
    assert!(difference.amax() < 1e-3);
}

#[test]
fn compliance_has_the_given_constants() {
    let compliance = wood(GLOBAL).try_inverse().unwrap();
    // Relative roundings of a 3 × 3 inverse with condition number near 30.
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
    assert!(close(1.0 / compliance[(0, 0)], 11e9));
    assert!(close(-compliance[(0, 1)] * 11e9, 0.37));
    assert!(close(-compliance[(1, 2)] * 0.8e9, 0.4));
    assert!(close(1.0 / compliance[(4, 4)], 0.6e9));
}

#[test]
fn a_quarter_turn_exchanges_axes() {
    let turned = wood([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]);
    let own = wood(GLOBAL);
    // Products with the exact rotation entries 0 and 1.
    assert!((turned[(1, 1)] - own[(0, 0)]).abs() <= 1e-15 * own[(0, 0)]);
    assert!((turned[(3, 3)] - own[(4, 4)]).abs() <= 1e-15 * own[(4, 4)]);
}
