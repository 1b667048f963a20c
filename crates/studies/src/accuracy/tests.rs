//! The study of meshes against closed forms and identities.

use std::path::Path;

use super::{
    AccuracySettings,
    discretisation::energy_norm,
    nested_bricks,
    refinement::{
        barycentric, default_finest, prolongate, refined, tetrahedron_around, with_brick,
    },
};
use contact3d::{
    elasticity::{DofMap, MaterialField, stiffness},
    mesh::Mesh,
    scene::{Brick, BrickFace, ElementOrder, Scene},
};

fn scene(contact_face: &str) -> Scene {
    let text = include_str!("../../../../pipelines/newton.toml");
    let text = text.replace("face = \"z_min\"", &format!("face = \"{contact_face}\""));
    Scene::parse("newton.toml", &text).expect("valid pipeline")
}

/// A field without symmetry that vanishes on the clamped face x = 0.
fn field(mesh: &Mesh) -> Vec<[f64; 3]> {
    let wave = |seed: usize, x: f64| x * (1.0 + 0.7 * ((seed * seed % 97) as f64).sin());
    let nodes = mesh.coordinates.iter().enumerate();
    nodes
        .map(|(n, x)| std::array::from_fn(|c| wave(3 * n + c, x[0])))
        .collect()
}

fn energy(scene: &Scene, mesh: &Mesh, field: &[[f64; 3]]) -> f64 {
    let dofs = DofMap::new(&mesh.held_nodes(scene));
    let stiffness = stiffness(mesh, &MaterialField::new(scene, mesh), &dofs);
    energy_norm(&stiffness, &dofs.to_free(field))
}

/// A coarse function is one of the finer mesh too, so both stiffness matrices give it the same
/// energy; with any cell cut differently it would gain some.
#[test]
fn finer_meshes_are_nested_whatever_the_factor_and_the_contact_face() {
    for face in ["z_min", "y_max"] {
        for (brick, element) in bricks()
            .into_iter()
            .zip([ElementOrder::P1, ElementOrder::P2])
        {
            let mut scene = scene(face);
            scene.body.element = element;
            let coarse_scene = with_brick(&scene, &brick);
            let coarse = mesh(&coarse_scene);
            let given = field(&coarse);
            let expected = energy(&coarse_scene, &coarse, &given);
            for factor in [1, 2, 3, 4] {
                let fine_scene = with_brick(&scene, &refined(&brick, factor));
                let fine = mesh(&fine_scene);
                let same = prolongate(&brick, &coarse, &given, &fine.coordinates);
                let found = energy(&fine_scene, &fine, &same);
                // Sums of a few thousand terms, each rounded to 1e-16.
                assert!((found / expected - 1.0).abs() < 1e-12, "{face}, {factor}");
            }
        }
    }
}

/// Equal cells, and cells graded towards one face and towards both of an axis.
fn bricks() -> [Brick; 2] {
    let even = Brick::new([3.0, 1.0, 1.0], [6, 2, 2]);
    let graded = even
        .clone()
        .with_grading(BrickFace::XMin, 1.7)
        .with_grading(BrickFace::ZMin, 1.4)
        .with_grading(BrickFace::ZMax, 2.0);
    [even, graded]
}

fn mesh(scene: &Scene) -> Mesh {
    Mesh::of_scene(scene, Path::new("")).expect("a brick")
}

#[test]
fn each_tetrahedron_of_a_finer_mesh_lies_in_one_of_a_coarser() {
    let settings = AccuracySettings {
        coarsest: 1,
        finest: Some(12),
        ..AccuracySettings::default()
    };
    // Pairs of equal cells can be merged.
    let [even, graded] = bricks();
    let pairs =
        Brick::new([3.0, 1.0, 1.0], [4, 4, 4]).with_planes(0, vec![0.0, 0.2, 0.4, 1.7, 3.0]);
    for (brick, expected) in [
        (even, vec![2, 4, 6, 12]),
        (graded, vec![2, 4, 6, 12]),
        (pairs, vec![2, 4, 6, 12]),
    ] {
        let scene = with_brick(&scene("z_min"), &brick);
        let study = nested_bricks(&scene, &brick, &settings).expect("nested meshes");
        let n_divs: Vec<usize> = study.iter().map(|brick| brick.cells[2]).collect();
        assert_eq!(n_divs, expected);
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

/// Merging cells of different widths would move the planes of a five-tetrahedra cell.
#[test]
fn the_ladder_of_a_graded_brick_has_no_coarser_meshes() {
    let brick = Brick::new([3.0, 1.0, 1.0], [12, 4, 4]).with_grading(BrickFace::XMin, 1.5);
    let settings = AccuracySettings {
        coarsest: 1,
        finest: Some(8),
        ..AccuracySettings::default()
    };
    let study = nested_bricks(&with_brick(&scene("z_min"), &brick), &brick, &settings);
    let study = study.expect("nested meshes");
    assert_eq!(study[0].planes(0), brick.planes(0));
    let cells: Vec<[usize; 3]> = study.iter().map(|brick| brick.cells).collect();
    assert_eq!(cells, [[12, 4, 4], [24, 8, 8]]);
}

#[test]
fn the_finest_mesh_by_default_stays_affordable() {
    assert_eq!(
        [4, 8, 10, 16, 24, 48].map(default_finest),
        [16, 32, 20, 32, 24, 48]
    );
}
