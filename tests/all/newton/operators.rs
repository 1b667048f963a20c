//! Implicit and dense operators, and successive approximations on both.

use contact3d::{
    dual::{ContactOperator, DualOperator, PrimalOperator},
    scene::{Coefficient, PrecisionControl::Fixed, Quantity},
    solver::{Inner, StopReason},
};

use super::{dense::*, support::hkl_scene};

/// Multipliers of many sizes and signs, the same on every machine.
fn probes(n: usize) -> Vec<Vec<f64>> {
    (1..5)
        .map(|k| {
            (0..n)
                .map(|i| 1e7 * ((i * 7919 * k + 13 * k) as f64 * 0.618_033_988_75).fract() - 3e6)
                .collect()
        })
        .collect()
}

#[test]
fn both_operators_agree() {
    for (n_div, gap, axis_1) in [
        (2, 0.0, None),
        (4, 1e-5, None),
        (4, 0.0, Some([0.6, 0.8, 0.0])),
        (6, 2e-6, Some([1.0, -2.0, 0.0])),
    ] {
        let mut scene = hkl_scene(1, n_div);
        let contact = &mut scene.contacts[0];
        contact.gap = Quantity::Constant(gap);
        contact.axis_1 = axis_1.map(|axis: [f64; 3]| axis.map(Quantity::Constant));
        let case = Dense::new(scene);
        let (assembly, contact) = (case.problem.assembly(), case.problem.contact());
        let mut implicit = ContactOperator::implicit(assembly, contact);
        let mut explicit = ContactOperator::explicit(&case.dual, assembly, contact);
        assert_eq!(implicit.rhs(), explicit.rhs());
        assert_eq!(implicit.tangential_displacement(&[]), None);
        for multiplier in probes(case.dual.dimension()) {
            // The same factor in another order of operations: rounding only.
            assert!(distance(&explicit.apply(&multiplier), &implicit.apply(&multiplier)) < 1e-12);
            let displacement = implicit.to_primal(&multiplier);
            assert_eq!(explicit.to_primal(&multiplier), displacement);
            let interface = case.problem.state().interface;
            let expected = interface.slip_of_displacement(
                case.problem.surface(),
                &assembly.primal.dofs,
                &displacement,
            );
            let found = explicit
                .tangential_displacement(&multiplier)
                .expect("explicit");
            for (&node, u) in case.problem.surface().nodes.iter().zip(&found) {
                if assembly.primal.dofs.dof[node] == [None; 3] {
                    assert_eq!(*u, [0.0; 2]);
                }
            }
            let found: Vec<f64> = found.iter().flatten().map(|u| u.abs()).collect();
            assert!(distance(&found, &expected.concat()) < 1e-12);
        }
        assert_eq!(explicit.applications(), implicit.applications());
    }
}

/// Successive approximations with KPRGP take the same steps on both operators, and the explicit one
/// spares every solve over the body but the last.
#[test]
fn successive_approximations_on_both_operators() {
    let mut scene = hkl_scene(1, 4);
    scene.solve.precision = Fixed;
    let case = Dense::new(scene);
    let paper = case.problem.solve(&case.scene);
    let explicit = case.approximate(Inner::Kprgp);
    assert_eq!(
        explicit.solution.trace.history.len(),
        paper.solution.trace.history.len()
    );
    // Each stops within ε = 1e-4 r_tol of its inner minimisers; equal paths differ by rounding only.
    assert!(distance(&explicit.solution.multiplier, &paper.solution.multiplier) < 1e-6);
    assert!(
        distance(
            &explicit.solution.displacement,
            &paper.solution.displacement
        ) < 1e-6
    );
    let [first, second] = [&explicit, &paper].map(|solution| {
        let friction = solution.solution.friction.as_ref().expect("Coulomb's law");
        friction.slip.as_ref().expect("F(u)").concat()
    });
    assert!(distance(&first, &second) < 1e-6);
}

/// A loose inner tolerance may be met by the warm start, so that λ does not change at all; that
/// must not pass for convergence (constant F = 0.1 did after two outer steps).
#[test]
fn an_idle_inner_solver_is_no_convergence() {
    for value in [1e-9, 1e-3, 0.1] {
        let mut scene = hkl_scene(1, 4);
        scene.friction = Some(isotropic(Coefficient::Constant(value)));
        scene.solve.epsilon = Some(1e-6);
        let dense = Dense::new(scene.clone());
        let newton = dense.solve(&dense.law());
        let found = dense.problem.solve(&scene);
        assert_eq!(found.stop, StopReason::Converged);
        let difference: f64 = found
            .solution
            .multiplier
            .iter()
            .zip(&newton.unknowns)
            .map(|(a, b)| (a - b).powi(2))
            .sum::<f64>()
            .sqrt();
        let size = newton.unknowns.iter().map(|l| l * l).sum::<f64>().sqrt();
        // ε = 1e-6, its inner tolerance amplified by the condition number of S, near 1e3.
        assert!(
            difference < 1e-4 * size,
            "F = {value}: {}",
            difference / size
        );
    }
}
