//! The Gram matrix of the norm of H¹(Ω)³ on V^h.

use nalgebra::Vector3;

use super::scatter::Scatter;
use crate::{
    elasticity::DofMap,
    linalg::CscMatrix,
    mesh::{Mesh, tetrahedron_volume},
};

/// ∫ u·v + ∫ ∇u:∇v over the free degrees of freedom of linear tetrahedra, `[n_free, n_free]`; lengths in the unit of
/// the scene, which decides what the first term weighs beside the second.
pub(super) fn first_sobolev_gram(mesh: &Mesh, dofs: &DofMap) -> CscMatrix {
    let mut gram = Scatter::new(dofs.n_free);
    for nodes in &mesh.tetrahedra {
        let corners = mesh.corners(nodes);
        let volume = tetrahedron_volume(&corners);
        let gradients = gradients(&corners, volume);
        for (a, &row) in nodes.iter().enumerate() {
            for (b, &column) in nodes.iter().enumerate() {
                // ∫ λ_a λ_b = V/20, and V/10 for a = b.
                let mass = volume / if a == b { 10.0 } else { 20.0 };
                let value = mass + volume * gradients[a].dot(&gradients[b]);
                for (row, column) in dofs.dof[row].iter().zip(dofs.dof[column]) {
                    if let (Some(row), Some(column)) = (*row, column) {
                        gram.add(row, column, value);
                    }
                }
            }
        }
    }
    gram.matrix()
}

/// Gradients of the four barycentric coordinates: inward normals of the faces, their length area/(3 V).
fn gradients(corners: &[[f64; 3]; 4], volume: f64) -> [Vector3<f64>; 4] {
    let [a, b, c, d] = corners.map(Vector3::from);
    let scale = 1.0 / (6.0 * volume);
    let first = (c - a).cross(&(d - a)) * scale;
    let second = (d - a).cross(&(b - a)) * scale;
    let third = (b - a).cross(&(c - a)) * scale;
    [-(first + second + third), first, second, third]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Brick;

    #[test]
    fn the_norm_of_linear_fields_is_known() {
        let raw = crate::mesh::brick(&Brick::new([2.0, 1.0, 1.0], [2, 2, 2]), None);
        let mesh = Mesh {
            coordinates: raw.coordinates,
            tetrahedra: raw.tetrahedra,
            tetrahedron_region: Vec::new(),
            facets: Vec::new(),
            facet_face: Vec::new(),
            face_names: Vec::new(),
            mid_edges: None,
            contact: None,
        };
        let dofs = DofMap::new(&vec![[false; 3]; mesh.coordinates.len()]);
        let gram = first_sobolev_gram(&mesh, &dofs);
        // u = (x, 0, 2): ∫ x² + 4 + 1 over (0,2)×(0,1)² = 8/3 + 8 + 2.
        let field: Vec<[f64; 3]> = mesh.coordinates.iter().map(|x| [x[0], 0.0, 2.0]).collect();
        let field = dofs.to_free(&field);
        let mut image = vec![0.0; field.len()];
        gram.mul(&field, &mut image);
        let square = crate::linalg::dot(&field, &image);
        assert!((square - (8.0 / 3.0 + 10.0)).abs() < 1e-12, "{square}");
    }
}
