//! The same mesh with its nodes and tetrahedra in another order.

use crate::{
    linalg::CscMatrix,
    mesh::{ContactSurface, Mesh, MidEdgeNodes},
};

/// A stride near the golden section of any number scatters neighbours far apart.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// The mesh with scattered node numbers and its tetrahedra in reverse; panes keep their numbers.
pub(super) fn renumbered(mesh: &Mesh) -> Mesh {
    let new = scattered(mesh.coordinates.len());
    let mut coordinates = mesh.coordinates.clone();
    for (old, place) in mesh.coordinates.iter().zip(&new) {
        coordinates[*place] = *old;
    }
    Mesh {
        coordinates,
        tetrahedra: mesh
            .tetrahedra
            .iter()
            .rev()
            .map(|t| t.map(|n| new[n]))
            .collect(),
        tetrahedron_region: mesh.tetrahedron_region.iter().rev().copied().collect(),
        facets: mesh.facets.iter().map(|f| f.map(|n| new[n])).collect(),
        facet_face: mesh.facet_face.clone(),
        face_names: mesh.face_names.clone(),
        mid_edges: mesh.mid_edges.as_ref().map(|middles| MidEdgeNodes {
            tetrahedra: middles
                .tetrahedra
                .iter()
                .rev()
                .map(|m| m.map(|n| new[n]))
                .collect(),
            facets: middles.facets.iter().map(|m| m.map(|n| new[n])).collect(),
        }),
        contact: mesh
            .contact
            .as_ref()
            .map(|surface| reordered(surface, &new)),
    }
}

/// A permutation of 0…n−1 without order.
fn scattered(n: usize) -> Vec<usize> {
    let divides_both = |stride: usize| {
        let (mut a, mut b) = (n, stride);
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let first = ((n as f64 * GOLDEN) as usize).max(1);
    let stride = (first..).find(|&stride| divides_both(stride) == 1);
    (0..n).map(|i| i * stride.unwrap_or(1) % n).collect()
}

fn reordered(surface: &ContactSurface, new: &[usize]) -> ContactSurface {
    let mut order: Vec<usize> = (0..surface.nodes.len()).collect();
    for face in &surface.faces {
        order[face.nodes.clone()].sort_by_key(|&local| new[surface.nodes[local]]);
    }
    let mut place = vec![0; order.len()];
    for (next, &local) in order.iter().enumerate() {
        place[local] = next;
    }
    let old = &surface.pane_average;
    let mut average = CscMatrix {
        indices: Vec::new(),
        data: Vec::new(),
        ..old.clone()
    };
    for pane in 0..surface.n_panes() {
        let weights = surface.pane_weights(pane);
        let mut column: Vec<_> = weights
            .map(|(local, weight)| (place[local], weight))
            .collect();
        column.sort_by_key(|(local, _)| *local);
        average
            .indices
            .extend(column.iter().map(|(local, _)| *local));
        average
            .data
            .extend(column.iter().map(|(_, weight)| *weight));
    }
    ContactSurface {
        normals: match surface.normals.as_slice() {
            [everywhere] => vec![*everywhere],
            each => order.iter().map(|&local| each[local]).collect(),
        },
        clearance: match surface.clearance.is_empty() {
            true => Vec::new(),
            false => order
                .iter()
                .map(|&local| surface.clearance[local])
                .collect(),
        },
        nodes: order
            .iter()
            .map(|&local| new[surface.nodes[local]])
            .collect(),
        pane_average: average,
        ..surface.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::scattered;

    #[test]
    fn scattered_numbers_are_a_permutation() {
        for n in 1..60 {
            let mut numbers = scattered(n);
            assert!(n < 4 || numbers[1] > 1, "{n}");
            numbers.sort_unstable();
            assert_eq!(numbers, (0..n).collect::<Vec<_>>());
        }
    }
}
