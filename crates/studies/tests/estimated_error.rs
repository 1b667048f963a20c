//! The estimated error of the mesh beside the true one.

use contact3d::{
    Problem,
    scene::{ElementOrder, Scene},
};
use studies::accuracy::{AccuracySettings, DiscretisationStudy};

/// The published problem on 6 × 2 × 2 cells.
fn published(element: ElementOrder) -> Scene {
    let text = include_str!("../../../pipelines/newton.toml");
    let mut scene = Scene::parse("newton.toml", text).expect("a pipeline");
    scene.body.element = element;
    scene.body.as_brick_mut().expect("a brick").cells = [6, 2, 2];
    scene
}

/// The estimate over the error against the limit of nested meshes. Its aim is 0.7 to 1.5; on these
/// scenes it is within 0.83 and 1.1, and the reference itself is uncertain by some hundredths.
#[test]
fn the_estimated_error_is_near_the_true_one() {
    for (element, finest) in [(ElementOrder::P1, 12), (ElementOrder::P2, 8)] {
        let settings = AccuracySettings {
            budget: 1.0,
            coarsest: 2,
            finest: Some(finest),
            sequences: None,
            memory: None,
        };
        let study = DiscretisationStudy::measure(&published(element), &settings, &mut |_| {});
        let study = study.expect("solves").expect("a brick");
        assert!(study.levels.len() > 2);
        for level in &study.levels {
            let error = level.energy_error.expect("an order is observed");
            let effectivity = level.estimated_error / error;
            println!(
                "published on {element:?}: error {:.1} %, estimate over it {effectivity:.2}",
                100.0 * error
            );
            assert!(
                (0.7..1.3).contains(&effectivity),
                "{element:?} {effectivity:.2}"
            );
        }
    }
}

/// Strain energy of a bent and pulled body on some quadratic cells, and the estimate over its root.
fn bent(cells: [usize; 3], grading: &str) -> (f64, f64) {
    let text = format!(
        r#"
        title = "bent"
        [body]
        element = "P2"
        [body.brick]
        size = [3.0, 1.0, 1.0]
        cells = {cells:?}
        {grading}
        [material.isotropic]
        young_modulus = 1e9
        poisson_ratio = 0.277
        [[clamp]]
        face = "x_min"
        [[traction]]
        face = "x_max"
        value = [1e5, 0.0, 2e5]
        "#
    );
    let scene = Scene::parse("bent.toml", &text).expect("a scene");
    let problem = Problem::new(scene).and_then(Problem::assemble);
    let problem = problem.expect("a problem");
    let (_, report) = problem
        .solve_and_report(&problem.scene().solve)
        .expect("a solve");
    let estimate = report.discretisation_error.relative();
    (report.resultants.strain_energy, estimate)
}

/// Without contact ‖e‖² is what the strain energy lacks, whatever the cells: slices and needles of 1 : 30 to 1 : 50 along every axis.
#[test]
fn flat_cells_are_judged_as_cubes_are() {
    let grading = "grading = { x_min = 2.0, y_min = 1.5, y_max = 1.5, z_min = 1.5, z_max = 1.5 }";
    let (whole, of_reference) = bent([14, 6, 6], grading);
    assert!(of_reference < 0.06);
    for cells in [
        [6, 2, 2],
        [2, 2, 50],
        [2, 50, 2],
        [100, 1, 1],
        [1, 16, 16],
        [2, 12, 24],
    ] {
        let (energy, estimate) = bent(cells, "");
        let error = ((whole - energy) / whole).sqrt();
        let effectivity = estimate / error;
        println!(
            "{cells:?}: error {:.1} %, estimate over it {effectivity:.2}",
            100.0 * error
        );
        // 0.8 to 1.1; with each cell on its own 3 to 40.
        assert!(
            (0.7..1.3).contains(&effectivity),
            "{cells:?} {effectivity:.2} {error:.3}"
        );
    }
}
