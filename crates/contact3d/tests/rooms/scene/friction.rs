//! Isotropic and orthotropic laws.

use contact3d::scene::{Coefficient, Formula, Friction, FrictionLaw, Quantity};
use proptest::prelude::*;

proptest! {
    /// An isotropic law is a function of |u_t| alone, and so are its derivatives.
    #[test]
    fn isotropic_derivatives_equal_differences(s1 in 0.1..2.0_f64, s2 in 0.1..2.0_f64) {
        let formula = Formula::parse("0.2 + 0.1*exp(-s)").unwrap();
        let law = FrictionLaw::Isotropic(Coefficient::Expression(formula));
        let f = |s1: f64, s2: f64| law.evaluate([0.0; 3], [0.0; 3], [s1, s2])[0];
        let derivative = law.derivative([0.0; 3], [0.0; 3], [s1, s2]);
        let step = 1e-6;
        // Truncation 1e-12, cancellation of numbers near 0.3 over 2e-6.
        prop_assert!((derivative[0][0] - (f(s1 + step, s2) - f(s1 - step, s2)) / (2.0 * step)).abs() < 1e-9);
        prop_assert!((derivative[0][1] - (f(s1, s2 + step) - f(s1, s2 - step)) / (2.0 * step)).abs() < 1e-9);
        prop_assert_eq!(derivative[0], derivative[1]);
    }
}

#[test]
fn a_law_needs_one_coefficient_or_two() {
    let half = Friction {
        coefficient_1: Some(Coefficient::Constant(0.3)),
        ..Friction::default()
    };
    assert_eq!(half.law(), None);
    let tresca = Friction {
        slip_bound: Some(Quantity::Constant(1e6)),
        ..Friction::default()
    };
    let unit = FrictionLaw::Isotropic(Coefficient::Constant(1.0));
    assert_eq!(tresca.law(), Some(unit));
}
