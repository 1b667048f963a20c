//! Coefficients and laws of friction: values, derivatives, and what a law needs.

use contact3d::scene::{
    Coefficient, Formula, Friction, FrictionLaw, Grid, LawPoint, Quantity, Ramp, Table,
};
use proptest::prelude::*;

fn at(s1: f64, s2: f64) -> LawPoint {
    LawPoint {
        position: [0.5, 0.0, 0.0],
        slip: [s1, s2],
        own_slip: s1,
    }
}

/// Value and slope of a ramp at a slip.
fn on_ramp(ramp: &Ramp, slip: f64) -> [f64; 2] {
    let (ramp, point) = (Coefficient::Ramp(*ramp), at(slip, 0.0));
    [ramp.evaluate(&point), ramp.derivative(&point).own]
}

#[test]
fn ramp_of_the_paper() {
    // HKL §4 with par = 6e4: rate 0.05·par, end 1e-5 + 2/par.
    let ramp = Ramp {
        initial: 0.3,
        residual: 0.2,
        onset: 1e-5,
        rate: 3000.0,
    };
    assert_eq!(
        [0.0, 1e-5, 1.0].map(|slip| on_ramp(&ramp, slip)[0]),
        [0.3, 0.3, 0.2]
    );
    // The midpoint of a straight line; a few roundings of numbers near 0.3.
    assert!((on_ramp(&ramp, 1e-5 + 1.0 / 6e4)[0] - 0.25).abs() < 1e-15);
    assert!((ramp.end() - (1e-5 + 2.0 / 6e4)).abs() < 1e-19);
    assert_eq!(on_ramp(&ramp, 2e-5)[1], -3000.0);
}

#[test]
fn hardening_ramp_rises() {
    let ramp = Ramp {
        initial: 0.1,
        residual: 2.0,
        onset: 0.0,
        rate: 1e4,
    };
    let [value, slope] = on_ramp(&ramp, 1e-4);
    assert!(value > 1.0 && slope == 1e4);
    assert_eq!(on_ramp(&ramp, 1e-3)[0], 2.0);
}

#[test]
fn a_table_of_the_ramps_corners_is_the_ramp() {
    let ramp = Coefficient::Ramp(Ramp {
        initial: 0.3,
        residual: 0.2,
        onset: 1.0,
        rate: 0.05,
    });
    let table = Coefficient::Table(Table {
        slip: vec![0.0, 1.0, 3.0],
        value: vec![0.3, 0.3, 0.2],
    });
    for slip in [0.0, 0.5, 1.0, 1.7, 2.9, 10.0] {
        let point = at(slip, 0.0);
        // A few roundings of numbers near 0.3.
        assert!((ramp.evaluate(&point) - table.evaluate(&point)).abs() < 1e-15);
        assert!((ramp.derivative(&point).own - table.derivative(&point).own).abs() < 1e-15);
    }
}

proptest! {
    #[test]
    fn derivatives_equal_differences(s1 in 0.05..2.95_f64, s2 in 0.05..1.95_f64) {
        let grid = Coefficient::Grid(Grid {
            slip_1: vec![0.0, 1.0, 3.0],
            slip_2: vec![0.0, 2.0],
            value: vec![vec![0.3, 0.5], vec![0.2, 0.1], vec![0.4, 0.6]],
        });
        let formula = Coefficient::Expression(
            Formula::parse("0.3 + 0.1*tanh(s1) - 0.05*s2*x + exp(-s)").unwrap(),
        );
        prop_assume!((s1 - 1.0).abs() > 1e-3);
        let step = 1e-6;
        for law in [grid, formula] {
            let derivative = law.derivative(&at(s1, s2));
            let first = (law.evaluate(&at(s1 + step, s2)) - law.evaluate(&at(s1 - step, s2))) / (2.0 * step);
            let second = (law.evaluate(&at(s1, s2 + step)) - law.evaluate(&at(s1, s2 - step))) / (2.0 * step);
            // Truncation 1e-12, cancellation of numbers near 1 over 2e-6.
            prop_assert!((derivative.pair[0] + derivative.own - first).abs() < 1e-9);
            prop_assert!((derivative.pair[1] - second).abs() < 1e-9);
        }
    }
}

proptest! {
    /// An isotropic law is a function of |u_t| alone, and so are its derivatives.
    #[test]
    fn isotropic_derivatives_equal_differences(s1 in 0.1..2.0_f64, s2 in 0.1..2.0_f64) {
        let formula = Formula::parse("0.2 + 0.1*exp(-s)").unwrap();
        let law = FrictionLaw::Isotropic(Coefficient::Expression(formula));
        let f = |s1: f64, s2: f64| law.evaluate([0.0; 3], [s1, s2])[0];
        let derivative = law.derivative([0.0; 3], [s1, s2]);
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
