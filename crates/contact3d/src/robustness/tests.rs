//! Transformations of scenes and their inverses.

use super::{Scaling, Symmetry};
use crate::scene::{Body, Scene};

fn scene() -> Scene {
    let text = include_str!("../../../../pipelines/expression_law.toml");
    Scene::parse("expression_law.toml", text).expect("a pipeline")
}

/// A symmetry is its own inverse, and a scaling has one.
#[test]
fn transformations_undo_themselves() {
    let scene = scene();
    for symmetry in [Symmetry::Mirror, Symmetry::Exchange] {
        let image = symmetry.apply(&scene).unwrap().expect("a brick on z_min");
        assert_ne!(image.to_toml(), scene.to_toml());
        let back = symmetry.apply(&image).unwrap().expect("a brick on z_min");
        assert_eq!(back.body, scene.body);
        assert_eq!(back.clamps, scene.clamps);
    }
    let scaling = Scaling {
        length: 8.0,
        displacement: 4.0,
        stress: 0.5,
    };
    let inverse = Scaling {
        length: 0.125,
        displacement: 0.25,
        stress: 2.0,
    };
    let back = inverse.apply(&scaling.apply(&scene).unwrap()).unwrap();
    assert_eq!((back.body, back.material), (scene.body, scene.material));
}

#[test]
fn bodies_from_files_have_no_mirror_image() {
    let text = include_str!("../../../../pipelines/gmsh_foot.toml");
    let scene = Scene::parse("gmsh_foot.toml", text).expect("a pipeline");
    assert!(matches!(scene.body, Body::Gmsh(_)));
    assert_eq!(Symmetry::Mirror.apply(&scene).unwrap(), None);
}
