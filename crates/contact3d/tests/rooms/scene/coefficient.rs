//! Laws of friction as functions of the slip.

use contact3d::scene::{Coefficient, Formula, Grid, LawPoint, Ramp, Table};
use proptest::prelude::*;

fn at(s1: f64, s2: f64) -> LawPoint {
    LawPoint {
        position: [0.5, 0.0, 0.0],
        slip: [s1, s2],
        own_slip: s1,
    }
}

#[test]
fn ramp_of_the_paper() {
    // HKL §4 with par = 6e4: rate 0.05·par, end 1e-5 + 2/par.
    let law = Ramp {
        initial: 0.3,
        residual: 0.2,
        onset: 1e-5,
        rate: 3000.0,
    };
    let ramp = Coefficient::Ramp(law);
    assert_eq!(ramp.evaluate(&at(0.0, 0.0)), 0.3);
    assert_eq!(ramp.evaluate(&at(1e-5, 0.0)), 0.3);
    assert_eq!(ramp.evaluate(&at(1.0, 0.0)), 0.2);
    // The midpoint of a straight line; a few roundings of numbers near 0.3.
    assert!((ramp.evaluate(&at(1e-5 + 1.0 / 6e4, 0.0)) - 0.25).abs() < 1e-15);
    assert!((law.end() - (1e-5 + 2.0 / 6e4)).abs() < 1e-19);
    assert_eq!(ramp.derivative(&at(2e-5, 0.0)).own, -3000.0);
}

#[test]
fn hardening_ramp_rises() {
    let ramp = Coefficient::Ramp(Ramp {
        initial: 0.1,
        residual: 2.0,
        onset: 0.0,
        rate: 1e4,
    });
    assert!(ramp.evaluate(&at(1e-4, 0.0)) > 1.0 && ramp.derivative(&at(1e-4, 0.0)).own == 1e4);
    assert_eq!(ramp.evaluate(&at(1e-3, 0.0)), 2.0);
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

#[test]
fn slips_and_kinks_of_each_kind() {
    let ramp = Coefficient::Ramp(Ramp {
        initial: 0.5,
        residual: 0.25,
        onset: 1.0,
        rate: 0.125,
    });
    assert_eq!(ramp.slips_used(1), [false, true]);
    assert_eq!(ramp.kinks(1), [vec![], vec![1.0, 3.0]]);
    let formula = |text| Coefficient::Expression(Formula::parse(text).unwrap());
    assert_eq!(formula("0.3 + s").slips_used(0), [true, false]);
    assert_eq!(formula("0.3 + x + s2").slips_used(0), [false, true]);
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
