//! The same problem by other routes: driven by the reaction as a load, or moved as a whole.

use contact3d::{
    AssembledProblem, Problem,
    elasticity::{InternalForces, MaterialField},
    post::Zone,
    scene::{Clamp, Component, Scene},
    solver::{ContactProblem, Solution, Start, Status},
};

use super::support::Case;

/// A block that is sheared by 4e-6 m over a rough foundation while it is pressed, with whatever of element, multipliers and
/// friction; x_min is on rollers that push its edge on the foundation along.
fn sheared(element: &str, contact: &str, friction: &str) -> Scene {
    let text = format!(
        "title = 'sheared'
        [body]
        element = '{element}'
        [body.brick]
        size = [1.2, 0.8, 0.6]
        cells = [6, 4, 4]
        [material.isotropic]
        young_modulus = 2e11
        poisson_ratio = 0.3
        [[clamp]]
        face = 'z_max'
        value = [4e-6, '2e-6*(1 - x)', '-1e-5*(1 + 0.2*y)']
        [[clamp]]
        box = [[0.0, 0.0, 0.0], [0.0, 0.8, 0.45]]
        components = ['x']
        value = [7e-6, 0.0, 0.0]
        [[traction]]
        face = 'x_max'
        value = [1e6, 2e6, 0.0]
        [contact]
        face = 'z_min'
        {contact}
        [friction]
        {friction}"
    );
    Scene::parse("sheared", &text).unwrap_or_else(|error| panic!("{error}"))
}

const RAMPS: &str =
    "coefficient_1.ramp = { initial = 0.3, residual = 0.2, onset = 1e-6, rate = 3000.0 }
        coefficient_2.ramp = { initial = 0.35, residual = 0.2, onset = 1e-6, rate = 1000.0 }";

/// All kinds of problems: element, contact, friction.
const KINDS: [(&str, &str, &str); 5] = [
    ("P1", "", RAMPS),
    ("P2", "", RAMPS),
    ("P1", "multipliers = 'nodal'\nangle = '20*x'", RAMPS),
    ("P2", "multipliers = 'nodal'\ngap = '1e-6*x'", RAMPS),
    ("P1", "gap = 1e-6", "slip_bound = 2e6"),
];

/// ‖x − y‖ / ‖y‖.
fn distance(x: &[f64], y: &[f64]) -> f64 {
    assert_eq!(x.len(), y.len());
    let difference: f64 = x.iter().zip(y).map(|(a, b)| (a - b).powi(2)).sum();
    (difference / y.iter().map(|b| b * b).sum::<f64>()).sqrt()
}

/// The scene without its second clamp, with nodal forces in place of the loads.
fn driven_by(case: &Case, forces: &[[f64; 3]]) -> (AssembledProblem, Solution) {
    let mut scene = case.scene().clone();
    scene.clamps.pop();
    let problem = Problem::new(scene).expect("a brick").assemble();
    let problem = problem.expect("a held body");
    let state = problem.contact_side().expect("contact");
    let mut system = problem.system.clone();
    let assembly = &mut system.assembly;
    let free = assembly.primal.dofs.to_free(forces);
    assembly
        .primal
        .load
        .iter_mut()
        .zip(free)
        .for_each(|(l, f)| *l += f);
    let unconstrained = assembly.unconstrained();
    let dofs = &assembly.primal.dofs;
    let contact = system.contact.as_mut().expect("contact");
    let rhs = contact.gap_residual(&unconstrained, dofs, state.surface, state.interface);
    contact.set_dual_rhs(rhs);
    let tangential = |u: &[f64]| -> Vec<[f64; 2]> {
        let nodes = state.surface.nodes.iter().enumerate();
        let frame = &state.interface.frame;
        nodes
            .map(|(i, &n)| frame.tangential(i, dofs.at_node(n, u)))
            .collect()
    };
    if let Some(compliance) = &mut contact.explicit_mut().expect("dense").compliance {
        compliance.slip_free = tangential(&unconstrained);
    }
    let settings = &case.scene().solve;
    let contact = ContactProblem::new(&system, state).expect("contact");
    let solution = contact.solve(settings, Start::default(), &mut |_| {});
    let solution = solution.expect("dense");
    (problem, solution)
}

/// Reactions of the second clamp as nodal forces on the body that lacks it give the same displacement and the same contact
/// stresses.
#[test]
fn a_body_driven_by_the_reaction_moves_as_one_driven_by_the_displacement() {
    for (element, contact, friction) in KINDS {
        let case = Case::new(sheared(element, contact, friction));
        assert_eq!(
            case.solution.status,
            Status::Converged,
            "{element} {contact}"
        );
        let report = case.report();
        assert!(
            report.certificate.worst() < 1e-10,
            "{:?}",
            report.certificate
        );
        let zones: Vec<_> = report.panes.iter().map(|pane| pane.zone).collect();
        assert!(zones.iter().any(|zone| *zone != Zone::Open), "{zones:?}");
        let (scene, mesh) = (case.scene(), case.mesh());
        let material = MaterialField::new(scene, mesh);
        let internal = InternalForces::of(mesh, &material, &report.displacement).forces;
        // x at the nodes of the second clamp: internal forces are the clamp's and the foundation's.
        let mut forces = vec![[0.0; 3]; internal.len()];
        let contact_forces = foundation(&case);
        let boxed = |x: &[f64; 3]| x[0] == 0.0 && x[2] <= 0.45;
        let nodes = mesh.coordinates.iter().enumerate();
        for (node, _) in nodes.filter(|(_, x)| boxed(x)) {
            assert!(report.displacement[node][0] == 7e-6);
            forces[node][0] = internal[node][0] - contact_forces[node][0];
        }
        let sum: f64 = forces.iter().map(|f| f[0]).sum();
        // Sums of some hundred nodal forces in different orders.
        assert!((sum - report.forces[1].force[0]).abs() < 1e-10 * sum.abs());
        let (other, solution) = driven_by(&case, &forces);
        assert_eq!(solution.status, Status::Converged, "{element} {contact}");
        // ε is 1e-12; displacements come from backsolves with condition number near 1e4.
        let found = distance(&solution.multiplier, &case.solution.multiplier);
        assert!(found < 1e-9, "{element} {contact} {friction}: {found:e}");
        let dofs = &other.system.assembly.primal.dofs;
        let moved = dofs.to_nodes(&solution.displacement);
        let found = distance(moved.as_flattened(), report.displacement.as_flattened());
        assert!(found < 1e-9, "{element} {contact}: {found:e}");
    }
}

/// Nodal forces of the foundation, from Bᵀ with every node free.
fn foundation(case: &Case) -> Vec<[f64; 3]> {
    let mesh = case.mesh();
    let state = case.contact_side().expect("contact");
    let all = contact3d::elasticity::DofMap::new(&vec![[false; 3]; mesh.coordinates.len()]);
    let coupling = state.interface.coupling(state.surface, &all);
    let forces = coupling.nodal_forces(&case.solution.multiplier);
    forces
        .chunks_exact(3)
        .map(|f| [-f[0], -f[1], -f[2]])
        .collect()
}

/// The body and its foundation moved away from each other by τ, the clamps moved after: the same contact stresses, and all
/// displacements are τ larger. Here contact nodes are held along the normal, too.
#[test]
fn clamps_that_follow_the_foundation_change_nothing() {
    let tau = 4e-6;
    for (element, contact, friction) in KINDS {
        let scene = |tau: f64| {
            let mut scene = sheared(element, contact, friction);
            let mut side = Clamp::face("x_min").along(&[Component::Y, Component::Z]);
            let mut pulled = Clamp::face("x_max");
            pulled.value = [1e-6, 2e-6, 3e-6 - tau].map(Into::into);
            side.value[2] = (-tau).into();
            scene.clamps = vec![pulled, side];
            let contact = &mut scene.contacts[0];
            let gap = contact3d::scene::Quantity::formula(&format!("1e-6*x + {tau:?}"));
            contact.gap = gap.expect("a formula");
            scene
                .pressures
                .push(contact3d::scene::Pressure::on("z_max", 2e7));
            scene.tractions.clear();
            Case::new(scene)
        };
        let [here, there] = [0.0, tau].map(scene);
        assert_eq!(there.solution.status, Status::Converged);
        assert!(there.report().certificate.worst() < 1e-10);
        let found = distance(&there.solution.multiplier, &here.solution.multiplier);
        // Backsolves with condition number near 1e4 on displacements that are some times larger.
        assert!(found < 1e-9, "{element} {contact} {friction}: {found:e}");
        for (a, b) in there.displacement().iter().zip(here.displacement()) {
            for (found, expected) in a.iter().zip([b[0], b[1], b[2] - tau]) {
                assert!((found - expected).abs() < 1e-9 * tau, "{found} {expected}");
            }
        }
        // Strain does not see the motion.
        let energies = [&here, &there].map(|case| case.report().resultants.strain_energy);
        assert!(
            (energies[1] / energies[0] - 1.0).abs() < 1e-9,
            "{energies:?}"
        );
    }
}
