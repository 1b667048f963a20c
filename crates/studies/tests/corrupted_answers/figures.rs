//! Every figure of the certificate by itself: an answer is made wrong in the one way that the
//! figure measures, and it must show the amount that follows by hand.

use contact3d::{
    post::{Certificate, Zone},
    solver::Solution,
};

use crate::{
    case::Case,
    corruptions::{SMALL, with_its_displacement},
};

/// Rounding of the amounts, and terms of second order in 1e-6.
const CLOSE: f64 = 1e-4;

fn certificate(case: &Case, solution: &Solution) -> Certificate {
    let report = case.problem.report(solution).expect("finite loads");
    report.certificate
}

fn assert_close(what: &str, found: f64, expected: f64) {
    assert!(expected > 0.0, "{what}: nothing to find");
    assert!(
        (found / expected - 1.0).abs() < CLOSE,
        "{what}: {found:e} instead of {expected:e}"
    );
}

/// λ_ν of the pane that bears most, 1e-6 too small: it and the pressed panes around it come through
/// the foundation by S_ji δ, which as a stress is ρ_j S_ji δ.
#[test]
fn penetration() {
    for name in ["hkl2011_table1.toml", "frictionless.toml", "gap.toml"] {
        let case = Case::named(name);
        let pane = case.most_pressed();
        let change = -SMALL * case.pressure();
        let solution = with_its_displacement(&case, &[(pane, change)]);
        let found = certificate(&case, &solution);
        let dual = case.contact().explicit().expect("S is dense");
        let pressed = (0..case.n_panes()).filter(|j| case.solution.multiplier[*j] > 0.0);
        let stresses =
            pressed.map(|j| case.solution.trace.local_stiffness[j] * dual.column(pane)[j]);
        let expected = SMALL * stresses.fold(0.0, f64::max);
        assert_close(name, found.penetration.expect("contact"), expected);
    }
}

/// A pull of a millionth of the largest pressure.
#[test]
fn adhesion() {
    let case = Case::named("gap.toml");
    let pane = case.pane(Zone::Open).expect("an open pane");
    let mut solution = case.solution.clone();
    solution.multiplier[pane] = -SMALL * case.pressure();
    let found = certificate(&case, &solution);
    assert_close("adhesion", found.adhesion.expect("contact"), SMALL);
}

/// A pressure δ on a pane that stays open by its gap does the work δ |R| gap.
#[test]
fn complementarity() {
    for name in ["gap.toml", "frictionless.toml"] {
        let case = Case::named(name);
        let pane = case.pane(Zone::Open).expect("an open pane");
        let mut solution = case.solution.clone();
        let change = SMALL * case.pressure();
        solution.multiplier[pane] = change;
        let found = certificate(&case, &solution);
        let gap = case.report.panes[pane].gap;
        let work = change * case.surface().pane_area[pane] * gap;
        let own = (0..case.n_panes())
            .map(|i| case.solution.multiplier[i].powi(2) / case.solution.trace.local_stiffness[i]);
        let expected = work / own.sum::<f64>();
        assert_close(name, found.complementarity.expect("contact"), expected);
    }
}

/// λ_t of a slipping pane 1e-6 too long: beyond its bound by 1e-6 of it, over the largest bound.
#[test]
fn friction_bound() {
    for name in ["hkl2011_table1.toml", "tresca.toml"] {
        let case = Case::named(name);
        let pane = case.pane(Zone::Slip).expect("a slipping pane");
        let mut solution = case.solution.clone();
        let at = case.n_panes() + 2 * pane;
        for t in &mut solution.multiplier[at..at + 2] {
            *t *= 1.0 + SMALL;
        }
        let found = certificate(&case, &solution);
        // Bounds are in proportion to F₁ g, and F₁ = 1 with Tresca's law here.
        let bound = |i: usize| match name {
            "tresca.toml" => case.report.panes[i].friction.expect("friction").semi_axes[0],
            _ => case.solution.multiplier[i],
        };
        let largest = (0..case.n_panes()).map(bound).fold(0.0, f64::max);
        assert_close(
            name,
            found.friction_bound.expect("friction"),
            SMALL * bound(pane) / largest,
        );
    }
}

/// Friction that pushes a slipping pane along instead of holding it: twice its work is missing.
#[test]
fn slip_direction() {
    for name in ["hkl2011_table1.toml", "tresca.toml"] {
        let case = Case::named(name);
        let m = case.n_panes();
        let pane = case.pane(Zone::Slip).expect("a slipping pane");
        let mut solution = case.solution.clone();
        for t in &mut solution.multiplier[m + 2 * pane..m + 2 * pane + 2] {
            *t = -*t;
        }
        let found = certificate(&case, &solution);
        let area = &case.surface().pane_area;
        let work = |i: usize| {
            let friction = case.report.panes[i].friction.expect("friction");
            let [[a, b], [s1, s2]] = [friction.semi_axes, friction.slip];
            area[i] * (a * s1).hypot(b * s2)
        };
        let all: f64 = (0..m).map(work).sum();
        let tangential = m..3 * m;
        let elastic: f64 = tangential
            .map(|j| case.solution.multiplier[j].powi(2) / case.solution.trace.local_stiffness[j])
            .sum();
        assert_close(
            name,
            found.slip_direction.expect("friction"),
            2.0 * work(pane) / (all + elastic),
        );
    }
}

/// A tangential stress on an ellipse that does not follow the slip, displaced along it by 1e-6: the
/// bound holds to second order.
#[test]
fn fixed_point() {
    for name in ["nodal.toml", "tresca.toml"] {
        let case = Case::named(name);
        let m = case.n_panes();
        let pane = case.pane(Zone::Slip).expect("a slipping pane");
        let friction = case.report.panes[pane].friction.expect("friction");
        let [a, b] = friction.semi_axes;
        let [t1, t2] = friction.stress.map(|t| -t);
        let change = [-SMALL * t2 * a / b, SMALL * t1 * b / a];
        let at = m + 2 * pane;
        let changes = [(at, change[0]), (at + 1, change[1])];
        let solution = with_its_displacement(&case, &changes);
        let found = certificate(&case, &solution);
        let size = change[0].hypot(change[1]) / case.shear();
        // As in corruptions.rs.
        assert!(
            found.fixed_point.expect("contact") > 0.33 * size,
            "{name}: {found:?}"
        );
        let bound = found.friction_bound.expect("friction");
        assert!(bound < 1e-3 * size, "{name}: {bound:e}");
        assert!(
            found.adhesion.expect("contact") < 1e-12,
            "{name}: {found:?}"
        );
    }
}

/// One component at one node displaced by δ: ‖A e‖ δ / ‖l‖.
#[test]
fn equilibrium() {
    let case = Case::named("frictionless.toml");
    let primal = &case.problem.system.assembly.primal;
    let mut solution = case.solution.clone();
    let last = primal.load.len() - 1;
    let change = 1e-9;
    solution.displacement[last] += change;
    let column = primal.stiffness.indptr[last]..primal.stiffness.indptr[last + 1];
    let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let expected = change * norm(&primal.stiffness.data[column]) / norm(&primal.load);
    let found = certificate(&case, &solution).equilibrium;
    assert_close("equilibrium", found, expected);
}
