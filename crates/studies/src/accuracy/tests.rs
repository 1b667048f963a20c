//! Nested meshes of a brick, tetrahedron by tetrahedron.

use std::path::Path;

use super::{
    AccuracySettings, nested_bricks,
    refinement::{barycentric, tetrahedron_around, with_brick},
};
use contact3d::{
    mesh::Mesh,
    scene::{Brick, BrickFace, Scene},
};

#[test]
fn each_tetrahedron_of_a_finer_mesh_lies_in_one_of_a_coarser() {
    let settings = AccuracySettings {
        coarsest: 1,
        finest: Some(12),
        ..AccuracySettings::default()
    };
    let text = include_str!("../../../../pipelines/newton.toml");
    let base = Scene::parse("newton.toml", text).expect("valid pipeline");
    let mesh = |scene: &Scene| Mesh::of_scene(scene, Path::new("")).expect("a brick");
    let even = Brick::new([3.0, 1.0, 1.0], [6, 2, 2]);
    let graded = even
        .clone()
        .with_grading(BrickFace::XMin, 1.7)
        .with_grading(BrickFace::ZMin, 1.4)
        .with_grading(BrickFace::ZMax, 2.0);
    // Pairs of equal cells can be merged.
    let pairs =
        Brick::new([3.0, 1.0, 1.0], [4, 4, 4]).with_planes(0, vec![0.0, 0.2, 0.4, 1.7, 3.0]);
    for brick in [even, graded, pairs] {
        let scene = with_brick(&base, &brick);
        let study = nested_bricks(&scene, &brick, &settings).expect("nested meshes");
        let n_divs: Vec<usize> = study.iter().map(|brick| brick.cells[2]).collect();
        assert_eq!(n_divs, [2, 4, 6, 12]);
        let finest = mesh(&with_brick(&scene, &study[3]));
        for brick in &study {
            let coarse = mesh(&with_brick(&scene, brick));
            let planes = [0, 1, 2].map(|axis| brick.planes(axis));
            for nodes in &finest.tetrahedra {
                let corners = finest.corners(nodes);
                let centre = std::array::from_fn(|c| corners.iter().map(|x| x[c] / 4.0).sum());
                let (around, _) = tetrahedron_around(&planes, &coarse, &centre);
                for corner in corners {
                    let at = barycentric(&coarse, around, &corner);
                    // Differences of coordinates near 1 over cells of 0.02 and more.
                    assert!(at.iter().all(|weight| *weight > -1e-13), "{at:?}");
                }
            }
        }
    }
}
