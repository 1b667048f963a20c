//! Scenes in other units.

use contact3d::scene::{AdaptSettings, Component, FirstMesh, Functional, Scene, UnitChange};

fn scene() -> Scene {
    let text = include_str!("../../../../../pipelines/expression_law.toml");
    Scene::parse("expression_law.toml", text).expect("a pipeline")
}

/// A change of units has an inverse.
#[test]
fn units_are_changed_back() {
    let scene = scene();
    let [change, inverse] = [[8.0, 4.0, 0.5], [0.125, 0.25, 2.0]].map(|factors| {
        let [length, displacement, stress] = factors;
        UnitChange {
            length,
            displacement,
            stress,
        }
    });
    let scaled = scene.in_units(change);
    let back = scaled.in_units(inverse);
    assert_eq!(
        (&back.bodies, &back.material),
        (&scene.bodies, &scene.material)
    );
    assert_eq!(back.clamps, scene.clamps);
    // The law is a formula and a grid, in the place and the slips of the new units.
    let [own, image] =
        [&scene, &scaled].map(|scene| scene.friction_on(0).unwrap().1.law().unwrap());
    assert_eq!(
        image.evaluate([0.0; 3], [8.0, 4.0, 8.0], [4e-5, 8e-5]),
        own.evaluate([0.0; 3], [1.0, 0.5, 1.0], [1e-5, 2e-5])
    );
}

/// The box of a mean goes with the body, steps with what they change, and formulas can be read again.
#[test]
fn every_number_goes_with_its_unit() {
    let mut scene = scene();
    let mean = |corners| Functional::MeanDisplacement {
        corners,
        component: Component::X,
    };
    let corners = [[2.0, 0.0, 0.5], [3.0, 0.25, 1.0]];
    scene.adapt = Some(AdaptSettings {
        error: 0.1,
        start: FirstMesh::Scene,
        of: Some(mean(corners)),
    });
    let image = scene.in_units(UnitChange {
        length: 2.0,
        displacement: 2.0,
        stress: 0.5,
    });
    let of = image.adapt.and_then(|adapt| adapt.of);
    let doubled = corners.map(|corner| corner.map(|x| 2.0 * x));
    assert_eq!(of, Some(mean(doubled)));
    image.validate().expect("a scene");
    let text = image.to_toml().expect("no functions");
    assert_eq!(
        Scene::parse("image", &text)
            .expect("a scene")
            .to_toml()
            .unwrap(),
        text
    );
    let history = include_str!("../../../../../pipelines/history.toml");
    let history = Scene::parse("history.toml", history).expect("a pipeline");
    let change = UnitChange {
        length: 2.0,
        displacement: 4.0,
        stress: 8.0,
    };
    let last = |scene: &Scene| scene.at_end().expect("a problem");
    let [own, image] = [last(&history), last(&history.in_units(change))];
    for (own, image) in own.tractions.iter().zip(&image.tractions) {
        let at = |value: &[contact3d::scene::Quantity; 3]| value.clone().map(|v| v.at([0.0; 3]));
        assert_eq!(at(&image.value), at(&own.value).map(|v| 8.0 * v));
    }
}
