//! A solve that goes on between any two outer steps gives the bits of an undisturbed one.

use crate::support::hkl_scene;
use contact3d::{
    contact::Interface,
    dual::DualSystem,
    mesh::Mesh,
    scene::{DualOperatorKind, InnerSolver, Method, Scene},
    solver::{ContactProblem, ContactSide, OuterState, Progress, Solution, Start},
};

/// A solve from a start, with the states between its steps.
fn run(
    scene: &Scene,
    mesh: &Mesh,
    system: &DualSystem,
    start: Start<'_>,
) -> (Solution, Vec<OuterState>) {
    let interface = Interface::new(scene, mesh).unwrap().unwrap();
    let surface = mesh.contact.as_ref().unwrap();
    let contact = ContactSide {
        surface,
        interface: &interface,
    };
    let mut states = Vec::new();
    let mut observe = |progress: Progress<'_>| {
        if let Progress::Between(state) = progress {
            states.push(state.clone());
        }
    };
    let problem = ContactProblem::new(system, contact).unwrap();
    let solution = problem.solve(&scene.solve, start, &mut observe).unwrap();
    (solution, states)
}

/// All numbers of a solution but its timings.
fn bits(solution: &Solution) -> Vec<u64> {
    let friction = solution.friction.as_ref().unwrap();
    let coulomb = &friction.coulomb;
    let vectors = [
        &solution.multiplier,
        &solution.displacement,
        &coulomb.slip_bound,
    ];
    let mut numbers: Vec<f64> = vectors.into_iter().flatten().copied().collect();
    numbers.extend(coulomb.friction.nodal.as_flattened());
    numbers.extend(coulomb.friction.pane_inverse.as_flattened());
    numbers.extend(friction.slip.iter().flatten().flatten());
    numbers.extend([solution.accuracy, solution.trace.steplength]);
    let counts = [solution.trace.applications, solution.trace.law_evaluations];
    let steps = solution.trace.history.iter();
    numbers.extend(steps.flat_map(|s| [s.change, s.inner_tolerance, s.inner_residual]));
    let applications = solution.trace.history.iter().map(|step| step.applications);
    let counts = counts
        .into_iter()
        .chain(applications)
        .map(|count| count as u64);
    numbers.iter().map(|x| x.to_bits()).chain(counts).collect()
}

#[test]
fn going_on_gives_the_same_bits_for_every_inner_solver_and_operator() {
    for (operator, inner) in [
        (DualOperatorKind::Implicit, InnerSolver::Kprgp),
        (DualOperatorKind::Implicit, InnerSolver::Gpcg),
        (DualOperatorKind::Explicit, InnerSolver::Kprgp),
        (DualOperatorKind::Explicit, InnerSolver::Newton),
    ] {
        let mut scene = hkl_scene(1, 4);
        scene.assemble.dual_operator = operator;
        scene.solve.method = Method::FixedPoint;
        scene.solve.inner = inner;
        let mesh = Mesh::of_scene(&scene, "".as_ref()).unwrap();
        let system = DualSystem::new(&scene, &mesh).unwrap();
        let (whole, states) = run(&scene, &mesh, &system, Start::default());
        assert_eq!(states.len() + 1, whole.trace.history.len());
        assert!(states.len() > 3, "{operator:?} {inner:?}");
        for state in &states {
            let start = Start {
                checkpoint: Some(state),
                ..Start::default()
            };
            let (resumed, later) = run(&scene, &mesh, &system, start);
            let done = state.history.len();
            assert_eq!(
                bits(&resumed),
                bits(&whole),
                "{operator:?} {inner:?} after {done} steps"
            );
            assert_eq!(later.len() + done, states.len());
        }
    }
}

#[test]
fn loads_applied_to_another_problem_give_the_bits_of_assembling_anew() {
    let scene = hkl_scene(1, 4);
    let mut other = hkl_scene(1, 4);
    other.tractions.remove(0);
    for operator in [DualOperatorKind::Implicit, DualOperatorKind::Explicit] {
        let [scene, other] = [&scene, &other].map(|scene| {
            let mut scene = scene.clone();
            scene.assemble.dual_operator = operator;
            scene
        });
        let mesh = Mesh::of_scene(&scene, "".as_ref()).unwrap();
        let expected = DualSystem::new(&scene, &mesh).unwrap();
        let mut moved = DualSystem::new(&other, &mesh).unwrap();
        assert_ne!(moved.assembly.primal.load, expected.assembly.primal.load);
        moved.apply_loads(&scene, &mesh).unwrap();
        // Timings differ, and nothing else.
        moved.assembly.seconds = expected.assembly.seconds;
        assert!(moved == expected, "{operator:?}");
    }
}
