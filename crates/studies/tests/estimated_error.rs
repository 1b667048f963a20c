//! The estimated error of the mesh beside the true one.

use contact3d::scene::{ElementOrder, Scene};
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
            assert!(
                (0.7..1.3).contains(&effectivity),
                "{element:?} {effectivity:.2}"
            );
        }
    }
}
