//! The Jacobian against differences, and the frozen problem with its safeguard, on made-up operators.

use std::{path::Path, sync::Arc};

use nalgebra::DMatrix;
use proptest::prelude::*;

use super::{NewtonSettings, minimise_frozen, natural_map::NaturalMap};
use crate::{
    contact::{Interface, MultiplierLayout, change_of_slips},
    dual::{ContactCompliance, ExplicitDual},
    linalg::norm,
    mesh::Mesh,
    scene::{Coefficient, Formula, Friction, Ramp, Scene},
    solver::{
        ContactSide, FeasibleSet, PaneLaws,
        conditions::{Bound, Evaluation},
    },
};

const PANES: usize = 2;
const NODES: usize = 15;
const SIZE: usize = 3 * PANES;

/// Two panes of 2 × 2 faces, with a law that follows the slips.
const SCENE: &str = "
    title = 'two panes'
    body.brick = { size = [2.0, 1.0, 1.0], cells = [4, 2, 2] }
    material.isotropic = { young_modulus = 1.0, poisson_ratio = 0.3 }
    clamp = [{ face = 'z_max' }]
    contact = { face = 'z_min' }
    friction.coefficient.constant = 0.3
";

fn laws_of(law: Friction) -> PaneLaws {
    let mut scene = Scene::parse("two panes", SCENE).unwrap();
    scene.friction = Some(law);
    let mesh = Mesh::of_scene(&scene, Path::new("")).unwrap();
    let interface = Interface::new(&scene, &mesh).unwrap().unwrap();
    let surface = mesh.contact.as_ref().unwrap();
    ContactSide {
        surface,
        interface: &interface,
    }
    .laws()
}

fn set_of(axes: &[f64]) -> FeasibleSet {
    let semi_axes = axes.chunks_exact(2).map(|a| [a[0], a[1]]).collect();
    FeasibleSet::new(PANES, semi_axes)
}

/// S = MᵀM + I and an arbitrary compliance.
fn dual(entries: &[f64], rhs: &[f64], compliance: &[f64], slip_free: &[f64]) -> ExplicitDual {
    let m = DMatrix::from_column_slice(SIZE, SIZE, entries);
    let operator = m.transpose() * &m + DMatrix::identity(SIZE, SIZE);
    ExplicitDual {
        anchor: None,
        operator: Arc::new(operator.as_slice().to_vec()),
        rhs: rhs.to_vec(),
        layout: MultiplierLayout::new(PANES, PANES),
        compliance: Some(ContactCompliance {
            matrix: Arc::new(compliance.to_vec()),
            slip_free: slip_free.chunks_exact(2).map(|p| [p[0], p[1]]).collect(),
        }),
        rigid: None,
        contact_springs: None,
    }
}

/// Ramps whose ends lie outside the slips that the tests reach often, or formulas that couple both
/// axes and the place.
fn law(coupled: bool, pressure_cap: Option<f64>) -> Friction {
    if coupled {
        let formula = |text| Some(Coefficient::Expression(Formula::parse(text).unwrap()));
        return Friction {
            coefficient_1: formula("0.3 + 0.2*exp(-s1) + 0.1*tanh(s2)"),
            coefficient_2: formula("0.5 - 0.2*tanh(s1*s2) + 0.1*x"),
            pressure_cap,
            ..Friction::default()
        };
    }
    let ramp = |initial, residual, rate| {
        Coefficient::Ramp(Ramp {
            initial,
            residual,
            onset: 0.05,
            rate,
        })
    };
    Friction {
        coefficient_1: Some(ramp(0.8, 0.2, 0.3)),
        coefficient_2: Some(ramp(0.1, 0.9, 0.4)),
        pressure_cap,
        ..Friction::default()
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
        let ahead = e
            .slip_derivative
            .as_ref()
            .map(|by| change_of_slips(by, |_| [1.0; 2]));
        let signs = ahead.unwrap_or_default();
        let nodes = e.inverse_slope.iter().zip(&signs);
        nodes
            .map(|(s, by)| [sign(s[0][0] * by[0]), sign(s[1][1] * by[1])])
            .collect()
    };
    signs(x) == signs(y)
        && x.panes
            .iter()
            .zip(&y.panes)
            .all(|(a, b)| a.zone() == b.zone() && a.bound_slope == b.bound_slope)
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
        coupled in any::<bool>(),
        cap in prop::option::of(0.2..2.0_f64),
    ) {
        let dual = dual(&entries, &rhs, &compliance, &slip_free);
        let laws = laws_of(law(coupled, cap));
        let set = frozen.map(|axes| set_of(&axes));
        let coulomb = Bound::Coulomb(&laws, laws.coulomb().unwrap());
        let bound = set.as_ref().map_or(coulomb, Bound::Given);
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
        // The full matrix, by its columns, for a direction that no equation was solved for.
        let Some(change) = difference(&map, &multiplier, &rhs) else { return Err(TestCaseError::reject("kink")) };
        let matrix = map.derivative(&evaluation);
        let slips = dual.compliance.as_ref().expect("a compliance").matrix.chunks_exact(2 * NODES);
        let mut moved = vec![0.0; 2 * NODES];
        for (column, v) in slips.zip(&rhs) {
            moved.iter_mut().zip(column).for_each(|(m, g)| *m -= g * v);
        }
        let pairs: Vec<[f64; 2]> = moved.chunks_exact(2).map(|m| [m[0], m[1]]).collect();
        let along = map.conditions.derivative(&evaluation, &rhs, &dual.apply(&rhs), &pairs);
        for i in 0..SIZE {
            let product: f64 = (0..SIZE).map(|j| matrix[j * SIZE + i] * rhs[j]).sum();
            // As above; entries of R' are below 100.
            prop_assert!((product - change[i]).abs() < 1e-6 * (1.0 + norm(&rhs)) * 100.0, "{product} against {}", change[i]);
            // The same product without the matrix, to rounding.
            prop_assert!((product - along[i]).abs() < 1e-11 * (1.0 + norm(&rhs)) * 100.0, "{product} against {}", along[i]);
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
        let set = set_of(&axes);
        let solution = minimise_frozen(&dual, &set, &start, &NewtonSettings::default(), |_, _| {});
        prop_assert!(solution.stop.is_solution());
        let mut relaxed = start;
        set.project(&mut relaxed);
        NaturalMap::new(&dual, Bound::Given(&set)).relax(&mut relaxed, 2000);
        for (a, b) in solution.unknowns.iter().zip(&relaxed) {
            // Relaxation contracts by the condition number (below 40) each sweep: 2000 reach rounding.
            prop_assert!((a - b).abs() < 1e-9, "{a} against {b}");
        }
    }
}
