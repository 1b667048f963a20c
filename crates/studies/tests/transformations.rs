//! Transformations of scenes and their inverses.

use contact3d::scene::{AdaptSettings, Brick, BrickFace, Component, FirstMesh, Functional, Scene};
use studies::stability::{Transformation, UnitChange};

fn scene() -> Scene {
    let text = include_str!("../../../pipelines/expression_law.toml");
    Scene::parse("expression_law.toml", text).expect("a pipeline")
}

/// A symmetry is its own inverse, and a scaling has one.
#[test]
fn transformations_undo_themselves() {
    let mut scene = scene();
    let brick = Brick::new([3.0, 1.0, 1.0], [4, 2, 2])
        .with_planes(0, vec![0.0, 0.25, 1.0, 2.0, 3.0])
        .with_grading(BrickFace::YMin, 2.0)
        .with_grading(BrickFace::ZMin, 1.5);
    scene.body = brick.into();
    for symmetry in [Transformation::mirror(&scene), Transformation::Exchange] {
        let image = symmetry.apply(&scene).unwrap().expect("a brick on z_min");
        assert_ne!(image.to_toml(), scene.to_toml());
        let back = symmetry.apply(&image).unwrap().expect("a brick on z_min");
        assert_eq!(back.body, scene.body);
        assert_eq!(back.clamps, scene.clamps);
    }
    let [scaling, inverse] = [[8.0, 4.0, 0.5], [0.125, 0.25, 2.0]].map(|factors| {
        let [length, displacement, stress] = factors;
        Transformation::Units(UnitChange {
            length,
            displacement,
            stress,
        })
    });
    let scaled = scaling.apply(&scene).unwrap().expect("no obstacle");
    let back = inverse.apply(&scaled).unwrap().expect("no obstacle");
    assert_eq!((back.body, back.material), (scene.body, scene.material));
}

/// The planes of an image are the images of the planes.
#[test]
fn graded_cells_go_with_the_symmetry() {
    let mut scene = scene();
    let given = vec![0.0, 0.25, 0.5, 1.75, 2.0];
    let brick = Brick::new([3.0, 2.0, 1.0], [6, 4, 2])
        .with_planes(1, given.clone())
        .with_grading(BrickFace::XMin, 2.0);
    scene.body = brick.clone().into();
    let image = |symmetry: Transformation| {
        let image = symmetry.apply(&scene).unwrap().expect("a brick on z_min");
        image.body.as_brick().expect("a brick").clone()
    };
    let mirrored = image(Transformation::mirror(&scene));
    assert_eq!(mirrored.planes(1), [0.0, 0.25, 1.5, 1.75, 2.0]);
    assert_eq!(mirrored.planes(0), brick.planes(0));
    let exchanged = image(Transformation::Exchange);
    assert_eq!(exchanged.planes(0), given);
    assert_eq!(exchanged.planes(1), brick.planes(0));
}

#[test]
fn bodies_from_files_have_no_mirror_image() {
    let text = include_str!("../../../pipelines/gmsh_foot.toml");
    let scene = Scene::parse("gmsh_foot.toml", text).expect("a pipeline");
    assert!(scene.body.mesh_file().is_some());
    assert_eq!(Transformation::mirror(&scene).apply(&scene).unwrap(), None);
}

/// The box of a mean goes with the body, and its component with the axes.
#[test]
fn the_quantity_to_refine_for_has_an_image() {
    let mut scene = scene();
    scene.body = Brick::new([3.0, 1.0, 1.0], [6, 2, 2]).into();
    let mean = |corners, component| Functional::MeanDisplacement { corners, component };
    let corners = [[2.0, 0.0, 0.5], [3.0, 0.25, 1.0]];
    scene.adapt = Some(AdaptSettings {
        error: 0.1,
        start: FirstMesh::Scene,
        of: Some(mean(corners, Component::X)),
    });
    let scaling = Transformation::Units(UnitChange {
        length: 2.0,
        displacement: 2.0,
        stress: 0.5,
    });
    for (map, corners, component) in [
        (
            scaling,
            corners.map(|corner| corner.map(|x| 2.0 * x)),
            Component::X,
        ),
        (
            Transformation::mirror(&scene),
            [[2.0, 0.75, 0.5], [3.0, 1.0, 1.0]],
            Component::X,
        ),
        (
            Transformation::Exchange,
            [[0.0, 2.0, 0.5], [0.25, 3.0, 1.0]],
            Component::Y,
        ),
    ] {
        let image = map.apply(&scene).unwrap().expect("a brick on z_min");
        let of = image.adapt.and_then(|adapt| adapt.of);
        assert_eq!(of, Some(mean(corners, component)));
        image.validate().expect("a scene");
    }
}
