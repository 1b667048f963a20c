//! One factor for all displacements of clamps, and the same answer from every method.

use std::sync::Arc;

use contact3d::{
    Problem,
    scene::{DualOperatorKind, FactorPrecision, InnerSolver, Method, Scene},
    solver::Status,
};

use super::support::Case;

fn scene(height: f64) -> Scene {
    let text = format!(
        "title = 'pushed'
        [body.brick]
        size = [1.2, 0.8, 0.6]
        cells = [6, 4, 4]
        [material.isotropic]
        young_modulus = 2e11
        poisson_ratio = 0.3
        [[clamp]]
        face = 'z_max'
        value = [1e-5, 2e-6, {height:?}]
        [contact]
        face = 'z_min'
        gap = '2e-5*x'
        [friction]
        coefficient_1.ramp = {{ initial = 0.3, residual = 0.2, onset = 1e-6, rate = 3000.0 }}
        coefficient_2.constant = 0.25"
    );
    Scene::parse("pushed", &text).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn displacements_of_clamps_share_the_factor_and_give_the_same_bits() {
    let first = Problem::new(scene(-1e-5)).unwrap().assemble().unwrap();
    let lower = first.with_changes(|scene| scene.clamps[0].value[2] = (-2e-5).into());
    let lower = lower.unwrap();
    let factor = |problem: &contact3d::AssembledProblem| problem.system.assembly.factor.clone();
    assert!(Arc::ptr_eq(&factor(&first), &factor(&lower)));
    let alone = Problem::new(scene(-2e-5)).unwrap().assemble().unwrap();
    assert_eq!(lower.system.assembly.primal, alone.system.assembly.primal);
    assert_eq!(lower.system.contact, alone.system.contact);
    let solve = |problem: &contact3d::AssembledProblem| problem.solve(&problem.scene().solve);
    let [a, b] = [&lower, &alone].map(|problem| solve(problem).unwrap());
    assert_eq!(
        (a.multiplier, a.displacement),
        (b.multiplier, b.displacement)
    );
    // And back to zero, where nothing is prescribed any more.
    let resting = first.with_changes(|scene| scene.clamps[0].value = Default::default());
    let resting = resting.unwrap();
    assert!(resting.system.assembly.primal.dofs.prescribed.is_none());
    assert!(
        solve(&resting)
            .unwrap()
            .displacement
            .iter()
            .all(|u| *u == 0.0)
    );
}

/// Every method and every form of the operator finds the same answer.
#[test]
fn methods_agree_on_prescribed_displacements() {
    let newton = Case::new(scene(-1e-5));
    assert_eq!(newton.solution.status, Status::Converged);
    let report = newton.report();
    assert!(
        report.panes.iter().any(|pane| pane.gap > 1e-8),
        "some panes are open"
    );
    for (operator, method, inner, factor) in [
        (
            DualOperatorKind::Implicit,
            Method::Auto,
            InnerSolver::Gpcg,
            FactorPrecision::Double,
        ),
        (
            DualOperatorKind::Explicit,
            Method::FixedPoint,
            InnerSolver::Kprgp,
            FactorPrecision::Double,
        ),
        (
            DualOperatorKind::Implicit,
            Method::FixedPoint,
            InnerSolver::Gpcg,
            FactorPrecision::Double,
        ),
        (
            DualOperatorKind::Explicit,
            Method::Newton,
            InnerSolver::Kprgp,
            FactorPrecision::Single,
        ),
        (
            DualOperatorKind::Implicit,
            Method::Auto,
            InnerSolver::Gpcg,
            FactorPrecision::Single,
        ),
    ] {
        let mut other = scene(-1e-5);
        other.assemble.dual_operator = operator;
        other.assemble.factor = factor;
        other.solve.method = method;
        other.solve.inner = inner;
        other.solve.epsilon = Some(1e-10);
        let other = Case::new(other);
        let difference: f64 = other
            .solution
            .multiplier
            .iter()
            .zip(&newton.solution.multiplier)
            .map(|(a, b)| (a - b).powi(2))
            .sum();
        let size: f64 = newton.solution.multiplier.iter().map(|l| l * l).sum();
        let found = (difference / size).sqrt();
        // ε = 1e-10 of the changes of successive approximations, which contract by a tenth or so.
        assert!(
            found < 1e-8,
            "{operator:?} {method:?} {factor:?}: {found:e}"
        );
        // A, the coupling and u_c together, whatever the precision of the factor.
        assert!(other.report().certificate.equilibrium < 1e-11);
    }
}
