//! Distances against nested meshes and their interpolation.

use std::path::Path;

use super::*;
use crate::accuracy::{
    discretisation::energy_norm,
    refinement::{prolongate, with_cells},
};
use contact3d::{
    elasticity::{DofMap, stiffness},
    mesh::RefinableBody,
    scene::{Body, ElementOrder, Material, Scene},
};

fn mesh(scene: &Scene) -> Mesh {
    Mesh::of_scene(scene, Path::new("")).expect("a mesh")
}

fn nodal(mesh: &Mesh, value: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<[f64; 3]> {
    mesh.coordinates.iter().map(|x| value(*x)).collect()
}

fn between(
    (mesh_a, a): (&Mesh, &[[f64; 3]]),
    (mesh_b, b): (&Mesh, &[[f64; 3]]),
    scene: &Scene,
) -> Distance {
    let field = |mesh, displacement| MeshField { mesh, displacement };
    distance(field(mesh_a, a), field(mesh_b, b), scene).expect("springs that hold")
}

#[test]
fn nested_meshes_give_the_norm_of_the_interpolated_difference() {
    let wave = |seed: f64| {
        move |x: [f64; 3]| {
            std::array::from_fn(|c| {
                x[0] * (1.0 + (seed * (c as f64 + 1.0) * (x[1] + 2.0 * x[2])).sin())
            })
        }
    };
    let text = include_str!("../../../../../pipelines/regions.toml");
    let scene = Scene::parse("regions.toml", text).expect("a pipeline");
    let base = scene.body.as_brick().expect("a brick").cells;
    for (first, second) in [
        (ElementOrder::P1, ElementOrder::P1),
        (ElementOrder::P1, ElementOrder::P2),
        (ElementOrder::P2, ElementOrder::P2),
    ] {
        let mut coarse = scene.clone();
        coarse.body.element = first;
        let mut fine = with_cells(&scene, base.map(|n| 2 * n));
        fine.body.element = second;
        let (mesh_a, mesh_b) = (mesh(&coarse), mesh(&fine));
        let (a, b) = (nodal(&mesh_a, wave(17.0)), nodal(&mesh_b, wave(23.0)));
        let found = between((&mesh_a, &a), (&mesh_b, &b), &fine);

        let dofs = DofMap::new(&mesh_b.held_nodes(&fine));
        let matrix = stiffness(&mesh_b, &MaterialField::new(&fine, &mesh_b), &dofs);
        let brick = coarse.body.as_brick().expect("a brick");
        let same = prolongate(brick, &mesh_a, &a, &mesh_b.coordinates);
        let difference: Vec<[f64; 3]> = same
            .iter()
            .zip(&b)
            .map(|(a, b)| std::array::from_fn(|c| a[c] - b[c]))
            .collect();
        let norm = |field: &[[f64; 3]]| energy_norm(&matrix, &dofs.to_free(field));
        let expected = [norm(&difference), norm(&b)];
        // Sums of some thousand terms, each rounded to 1e-16.
        for (found, expected) in [found.absolute, found.reference].iter().zip(expected) {
            assert!(
                (found / expected - 1.0).abs() < 1e-12,
                "{first:?} {second:?}"
            );
        }
    }
}

/// Children of a curved tetrahedron lie on its own map, so the function of its mesh is one of theirs too.
#[test]
fn a_function_on_curved_sides_is_one_on_its_children() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../contact3d/tests/meshes");
    let body = Body::gmsh(folder.join("post_order2_41.msh"), 1.0).with_element(ElementOrder::P2);
    let scene = Scene::new(body, Material::isotropic(1.0, 0.25));
    let coarse = mesh(&scene);
    let mut body = RefinableBody::new(&scene, Path::new("")).expect("a body");
    for seed in [3, 5] {
        let cuts: Vec<u8> = (0..body.n_tetrahedra())
            .map(|t| u8::from(t * t % seed == 1) * 2)
            .collect();
        body.refine(&cuts);
    }
    let fine = body.mesh().expect("a mesh");
    let pieces: Vec<SearchedTetrahedron> = (0..coarse.tetrahedra.len())
        .map(|t| SearchedTetrahedron::of(&coarse, t))
        .collect();
    assert!(pieces.iter().any(|piece| piece.map.is_some()));
    let tree = Tree::new(pieces.iter().map(|piece| piece.bounds).collect());
    let values = nodal(&coarse, |x| [(3.0 * x[2]).sin(), x[0] * x[1], x[0].cos()]);
    let same: Vec<[f64; 3]> = fine
        .coordinates
        .iter()
        .map(|x| {
            let (t, at) = tree.nearest(*x, tree.any(*x), |t| pieces[t].nearest(*x));
            let shape = quadratic_tetrahedron(&at);
            let nodes = coarse.tetrahedron_nodes(t).zip(shape);
            nodes.fold([0.0; 3], |sum, (n, w)| {
                std::array::from_fn(|c| sum[c] + w * values[n][c])
            })
        })
        .collect();
    for (one, other) in [
        ((&coarse, &values), (&fine, &same)),
        ((&fine, &same), (&coarse, &values)),
    ] {
        let found = between((one.0, one.1), (other.0, other.1), &scene);
        assert!(found.reference > 0.1);
        // Newton's method ends at 1e-13, places up to 1e-10 outside count as inside, and slopes jump across sides.
        assert!(found.relative() < 1e-6, "{found:?}");
    }
}
