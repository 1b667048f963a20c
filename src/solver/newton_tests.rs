//! The Jacobian against differences, and the frozen problem with its safeguard, on made-up operators.

use nalgebra::DMatrix;
use proptest::prelude::*;

use super::{
    ContactState, Ellipse, FeasibleSet, NewtonSettings, NewtonStatus, minimise_frozen,
    natural_map::{Bound, Evaluation, NaturalMap},
    vector::norm,
};
use crate::{
    dual::ExplicitDual,
    mesh::{ContactSurface, brick},
    scene::{Brick, Coefficient, Face, Frame, Friction, Ramp},
};

const PANES: usize = 2;
const NODES: usize = 15;
const SIZE: usize = 3 * PANES;

/// Two panes of 2 × 2 faces.
fn surface() -> ContactSurface {
    let spec = Brick {
        size: [2.0, 1.0, 1.0],
        cells: [4, 2, 2],
    };
    brick(&spec, Face::ZMin).contact
}

/// S = MᵀM + I and an arbitrary compliance.
fn dual(entries: &[f64], rhs: &[f64], compliance: &[f64], slip_free: &[f64]) -> ExplicitDual {
    let m = DMatrix::from_column_slice(SIZE, SIZE, entries);
    let operator = m.transpose() * &m + DMatrix::identity(SIZE, SIZE);
    ExplicitDual {
        operator: operator.as_slice().to_vec(),
        rhs: rhs.to_vec(),
        compliance: compliance.to_vec(),
        slip_free: slip_free.chunks_exact(2).map(|p| [p[0], p[1]]).collect(),
    }
}

/// Ramps whose ends lie outside the slips that the tests reach often.
fn law() -> Friction {
    let ramp = |initial, residual, rate| {
        Coefficient::Ramp(Ramp {
            initial,
            residual,
            onset: 0.05,
            rate,
        })
    };
    Friction {
        coefficient_1: ramp(0.8, 0.2, 0.3),
        coefficient_2: ramp(0.1, 0.9, 0.4),
    }
}

fn moved(point: &[f64], direction: &[f64], s: f64) -> Vec<f64> {
    let pairs = point.iter().zip(direction);
    pairs.map(|(l, d)| l + s * d).collect()
}

/// Whether two evaluations lie on the same smooth piece of R.
fn same_piece(x: &Evaluation, y: &Evaluation) -> bool {
    let signs = |e: &Evaluation| -> Vec<[Option<bool>; 2]> {
        let sign = |v: f64| (v != 0.0).then_some(v > 0.0);
        e.inverse_slope.iter().map(|s| s.map(sign)).collect()
    };
    signs(x) == signs(y)
        && x.panes
            .iter()
            .zip(&y.panes)
            .all(|(a, b)| a.zone() == b.zone())
}

/// The central difference of R along a direction; `None` across a kink.
fn difference(map: &NaturalMap<'_>, at: &[f64], direction: &[f64]) -> Option<Vec<f64>> {
    let s = 1e-6 / norm(direction).max(1e-300);
    let [ahead, behind] = [s, -s].map(|s| map.evaluate(&moved(at, direction, s)));
    let pairs = ahead.residual.iter().zip(&behind.residual);
    same_piece(&ahead, &behind).then(|| pairs.map(|(a, b)| (a - b) / (2.0 * s)).collect())
}

proptest! {
    /// R'(λ) d = −R(λ): every coefficient of the system takes part, whatever λ is.
    #[test]
    fn newton_step_solves_the_equation_of_differences(
        entries in prop::collection::vec(-0.5..0.5_f64, SIZE * SIZE),
        rhs in prop::collection::vec(-1.0..3.0_f64, SIZE),
        compliance in prop::collection::vec(-0.3..0.3_f64, 2 * NODES * SIZE),
        slip_free in prop::collection::vec(-1.0..1.0_f64, 2 * NODES),
        multiplier in prop::collection::vec(-1.0..3.0_f64, SIZE),
        frozen in prop::option::of(prop::collection::vec(0.1..2.0_f64, 2 * PANES)),
    ) {
        let dual = dual(&entries, &rhs, &compliance, &slip_free);
        let (surface, law) = (surface(), law());
        let frame = Frame { normal: [0.0, 0.0, -1.0], axis_1: [1.0, 0.0, 0.0], axis_2: [0.0, 1.0, 0.0] };
        let contact = ContactState { surface: &surface, frame: &frame, law: &law };
        let set = frozen.map(|axes| FeasibleSet {
            ellipses: axes.chunks_exact(2).map(|a| Ellipse { semi_axes: [a[0], a[1]] }).collect(),
        });
        let bound = set.as_ref().map_or(Bound::Coulomb(&contact), Bound::Frozen);
        let map = NaturalMap::new(&dual, bound);
        let evaluation = map.evaluate(&multiplier);
        let Some((step, _)) = map.newton_step(&evaluation) else { return Err(TestCaseError::reject("kink")) };
        let Some(change) = difference(&map, &multiplier, &step) else { return Err(TestCaseError::reject("kink")) };
        let scale = norm(&step) + evaluation.norm;
        for (change, residual) in change.iter().zip(&evaluation.residual) {
            // Central differences over 1e-6: rounding 1e-10, truncation 1e-12 times third
            // derivatives, and a system that may be ill-conditioned.
            prop_assert!((change + residual).abs() < 1e-6 * scale, "{change} against {residual}");
        }
    }

    /// The frozen problem is convex: Newton's method finds its minimiser from any start, and the
    /// relaxation sweeps of its safeguard find the same one.
    #[test]
    fn frozen_minimiser_is_found_by_newton_and_by_relaxation(
        entries in prop::collection::vec(-1.0..1.0_f64, SIZE * SIZE),
        rhs in prop::collection::vec(-5.0..5.0_f64, SIZE),
        start in prop::collection::vec(-5.0..5.0_f64, SIZE),
        axes in prop::collection::vec(prop_oneof![Just(0.0), 0.1..2.0_f64], 2 * PANES),
    ) {
        let dual = dual(&entries, &rhs, &[0.0; 2 * NODES * SIZE], &[0.0; 2 * NODES]);
        let set = FeasibleSet {
            ellipses: axes.chunks_exact(2).map(|a| Ellipse { semi_axes: [a[0], a[1]] }).collect(),
        };
        let solution = minimise_frozen(&dual, &set, &start, &NewtonSettings::default());
        prop_assert!(matches!(solution.status, NewtonStatus::Converged | NewtonStatus::RoundingLimit));
        let mut relaxed = start;
        set.project(&mut relaxed);
        NaturalMap::new(&dual, Bound::Frozen(&set)).relax(&mut relaxed, 2000);
        for (a, b) in solution.multiplier.iter().zip(&relaxed) {
            // Relaxation contracts by the condition number (below 40) each sweep: 2000 reach rounding.
            prop_assert!((a - b).abs() < 1e-9, "{a} against {b}");
        }
    }
}
