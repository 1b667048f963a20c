//! Adaptive meshes of load histories.

use std::path::Path;

use contact3d::{
    Problem,
    adaptation::{AdaptiveStatus, adapted},
    history::HistoryErrors,
    scene::{AdaptSettings, ElementOrder, FirstMesh, Functional, Scene, SolveSettings, Step},
};

/// A history of one step is refined as the static problem, for the energy norm and for a force, by cells and by cuts.
#[test]
fn a_history_of_one_step_is_refined_as_the_static_problem() {
    for (of, error) in [(None, 0.06), (Some(Functional::NormalForce), 0.001)] {
        let text = include_str!("../../../../pipelines/newton.toml");
        let mut scene = Scene::parse("newton", text).expect("a scene");
        scene.bodies[0].element = ElementOrder::P2;
        scene.as_brick_mut().expect("a brick").cells = [6, 2, 2];
        scene.adapt = Some(AdaptSettings {
            error,
            of,
            start: FirstMesh::Scene,
        });
        let levels = |scene: Scene| {
            let (found, levels) = adapted(scene, Path::new("")).expect("levels");
            assert_eq!(levels.status, AdaptiveStatus::Met);
            (found, levels.adaptation)
        };
        let (expected, static_levels) = levels(scene.clone());
        scene.steps = vec![Step::new("all")];
        let (found, levels) = levels(scene);
        assert!(levels.levels.len() > 1);
        assert_eq!(levels.refinement, static_levels.refinement);
        assert_eq!(found.solution.multiplier, expected.solution.multiplier);
        let pairs = levels.levels.iter().zip(&static_levels.levels);
        for (found, expected) in pairs {
            let difference = found.estimated_error - expected.estimated_error;
            // The same squares, summed in another order.
            assert!(difference.abs() <= 1e-12 * expected.estimated_error);
        }
        let force = |of: Functional| (found.report.functional(of), expected.report.functional(of));
        let (found, of_static) = force(Functional::TangentialForce);
        assert_eq!(found, of_static);
        // The estimate does not depend on the adjoints that are estimated beside it.
        let alone = expected.problem.report(&expected.solution);
        let alone = alone.expect("a report").discretisation_error;
        assert_eq!(alone, expected.report.discretisation_error);
    }
}

/// Every increment has the estimate of a plain history that ends with it, and the mesh that of the worst.
#[test]
fn increments_are_estimated_as_if_each_was_the_last() {
    let text = include_str!("../../../../pipelines/history.toml");
    let mut scene = Scene::parse("history", text).expect("a scene");
    scene.bodies[0].element = ElementOrder::P2;
    scene.as_brick_mut().expect("a brick").cells = [6, 2, 2];
    scene.steps.truncate(3);
    scene.steps.iter_mut().for_each(|step| step.increments = 1);
    let mut adaptive = scene.clone();
    adaptive.adapt = Some(AdaptSettings {
        error: 1.0,
        of: None,
        start: FirstMesh::Scene,
    });
    let (found, levels) = adapted(adaptive, Path::new("")).expect("a level");
    let errors = HistoryErrors::new(&found.records, None).expect("estimates");
    let mut parts = Vec::new();
    for n in 1..=3 {
        let mut part = scene.clone();
        part.steps.truncate(n);
        let problem = Problem::new(part)
            .and_then(Problem::assemble)
            .expect("a problem");
        let last = problem
            .solve_history(&SolveSettings::default())
            .expect("a solve");
        assert!(
            last.records
                .iter()
                .all(|record| record.error_energy.is_empty())
        );
        assert!(last.report.functionals.is_empty());
        let error = &last.report.discretisation_error;
        parts.push((error.total(), error.displacement));
    }
    let largest = parts
        .iter()
        .fold(0.0, |most: f64, (_, size)| most.max(*size));
    assert_eq!(errors.relative.len(), 3);
    for (relative, (total, _)) in errors.relative.iter().zip(&parts) {
        // Squares of the same roots, summed in another order.
        assert!(
            (relative * largest - total).abs() <= 1e-12 * total,
            "{relative}"
        );
    }
    let worst = errors.relative.iter().copied().fold(0.0, f64::max);
    assert_eq!(levels.adaptation.levels[0].estimated_error, worst);
}
