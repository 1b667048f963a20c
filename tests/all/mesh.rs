//! The brick mesh: conforming, positively oriented, with a complete boundary and exact panes.

use std::collections::HashMap;

use contact3d::{
    mesh::{Mesh, tetrahedron_volume, triangle_area},
    scene::{Brick, BrickFace, Scene},
};
use proptest::prelude::*;

fn sorted(mut nodes: [usize; 3]) -> [usize; 3] {
    nodes.sort_unstable();
    nodes
}

/// How many tetrahedra share each triangle.
fn triangle_counts(mesh: &Mesh) -> HashMap<[usize; 3], usize> {
    let mut counts = HashMap::new();
    for &[a, b, c, d] in &mesh.tetrahedra {
        for triangle in [[a, b, c], [a, b, d], [a, c, d], [b, c, d]] {
            *counts.entry(sorted(triangle)).or_insert(0) += 1;
        }
    }
    counts
}

/// The mesh of a brick with panes on a face, held at the opposite one.
fn brick(spec: &Brick, face: BrickFace) -> Mesh {
    let opposite = BrickFace::ALL[face as usize ^ 1].word();
    let text = format!(
        "title = 'brick'\n[body.brick]\nsize = [1.0, 1.0, 1.0]\ncells = [2, 2, 2]\n\
         [material.isotropic]\nyoung_modulus = 1.0\npoisson_ratio = 0.3\n\
         [[clamp]]\nface = '{opposite}'\n[contact]\nface = '{}'\n",
        face.word()
    );
    let mut scene = Scene::parse("test", &text).unwrap();
    scene.bodies = vec![spec.clone().into()];
    Mesh::of_scene(&scene, std::path::Path::new("")).unwrap()
}

fn any_brick() -> impl Strategy<Value = (Brick, BrickFace)> {
    let size = prop::array::uniform3(0.01..50.0_f64);
    let cells = prop::array::uniform3(1..4_usize);
    let exponent = prop_oneof![Just(1.0), 1.0..3.0_f64];
    let grading = prop::option::of(prop::array::uniform6(exponent));
    (size, cells, 0..6_usize, grading).prop_map(|(size, mut cells, face, grading)| {
        let face = BrickFace::ALL[face];
        for axis in (0..3).filter(|&axis| axis != face.axis()) {
            cells[axis] *= 2;
        }
        let even = Brick::new(size, cells);
        let exponents = grading.unwrap_or([1.0; 6]);
        let towards = BrickFace::ALL.into_iter().zip(exponents);
        let graded = towards.fold(even, |brick, (face, p)| brick.with_grading(face, p));
        (graded, face)
    })
}

proptest! {
    #[test]
    fn bricks_are_conforming((spec, face) in any_brick()) {
        let mesh = brick(&spec, face);
        let counts = triangle_counts(&mesh);
        prop_assert!(counts.values().all(|&n| n == 1 || n == 2));
        let mut outer: Vec<_> =
            counts.iter().filter(|(_, n)| **n == 1).map(|(triangle, _)| *triangle).collect();
        let mut facets: Vec<_> = mesh.facets.iter().map(|f| sorted(*f)).collect();
        outer.sort_unstable();
        facets.sort_unstable();
        prop_assert_eq!(outer, facets);
    }

    #[test]
    fn tetrahedra_fill_the_box((spec, face) in any_brick()) {
        let mesh = brick(&spec, face);
        let volumes: Vec<f64> =
            mesh.tetrahedra.iter().map(|t| tetrahedron_volume(&mesh.corners(t))).collect();
        prop_assert!(volumes.iter().all(|v| *v > 0.0));
        let whole: f64 = spec.size.iter().product();
        // A sum of at most a few thousand positive terms.
        prop_assert!((volumes.iter().sum::<f64>() / whole - 1.0).abs() < 1e-12);
    }

    #[test]
    fn facets_look_outwards((spec, face) in any_brick()) {
        let mesh = brick(&spec, face);
        for (facet, tag) in mesh.facets.iter().zip(&mesh.facet_face) {
            let [a, b, c] = mesh.corners(facet).map(nalgebra::Vector3::from);
            let side = BrickFace::ALL[*tag];
            let mut normal = nalgebra::Vector3::zeros();
            normal[side.axis()] = if side.is_max() { 1.0 } else { -1.0 };
            let along = (b - a).cross(&(c - a)).dot(&normal);
            // The area vector is the normal times twice the area; roundings only.
            prop_assert!((along / (2.0 * triangle_area(&mesh.corners(facet))) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn panes_partition_the_contact_face((spec, face) in any_brick()) {
        let mesh = brick(&spec, face);
        let contact = mesh.contact.as_ref().unwrap();
        prop_assert_eq!(contact.normal_at(0)[face.axis()].abs(), 1.0);
        let [p, q] = [0, 1, 2].iter().copied().filter(|&a| a != face.axis()).collect::<Vec<_>>()[..]
        else { unreachable!() };
        prop_assert_eq!(contact.n_panes(), spec.cells[p] * spec.cells[q] / 4);
        prop_assert_eq!(contact.nodes.len(), (spec.cells[p] + 1) * (spec.cells[q] + 1));
        // Eight equal triangles make a pane; a sum of few terms.
        let area = spec.size[p] * spec.size[q];
        prop_assert!((contact.pane_area.iter().sum::<f64>() / area - 1.0).abs() < 1e-12);
        for pane in 0..contact.n_panes() {
            let triangles = contact.facet_pane.iter().filter(|&&p| p == pane).count();
            prop_assert_eq!(triangles, 8);
            let mut weights: Vec<f64> = contact.pane_weights(pane).map(|(_, w)| w).collect();
            weights.sort_by(f64::total_cmp);
            // SPEC section 2: 1/12 at eight nodes, 4/12 at the centre where all triangles meet.
            let expected = [[1.0 / 12.0; 8].as_slice(), &[4.0 / 12.0]].concat();
            prop_assert_eq!(weights.len(), 9);
            let is_even = (0..3).all(|axis| spec.is_even(axis));
            // Between other cells only the centre has its weight, a third of each triangle.
            let known = if is_even { 0 } else { 8 };
            let pairs = weights.iter().zip(expected).skip(known);
            prop_assert!(pairs.into_iter().all(|(w, e)| (w - e).abs() < 1e-12));
        }
    }
}
