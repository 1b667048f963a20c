//! The sides of tetrahedra with the forces on them.

use contact3d::{
    mesh::{Mesh, sorted},
    reference::TETRAHEDRON_SIDES,
};
use nalgebra::Vector3;

use super::macro_stress::{DATA, Data, MacroElement, SIDE_DATA, outward};

/// The sides of all tetrahedra, each once.
pub(super) struct MeshSides {
    pub(super) sides: Vec<Side>,
    /// How each tetrahedron sees its sides, `[n_tetrahedra]`.
    pub(super) of_tetrahedra: Vec<[SeenSide; 4]>,
}

/// A side of one or two tetrahedra.
#[derive(Debug, Clone)]
pub(super) struct Side {
    /// Its corners, increasing.
    pub(super) nodes: [usize; 3],
    /// The tetrahedron that it looks out of.
    pub(super) inside: usize,
    /// The tetrahedron on its other side; `None` on the boundary.
    pub(super) outside: Option<usize>,
    /// Its boundary triangle.
    pub(super) facet: Option<usize>,
    /// Area vector in m², out of `inside`.
    pub(super) area: Vector3<f64>,
}

/// A side as a tetrahedron sees it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SeenSide {
    /// The side.
    pub(super) side: usize,
    /// 1 from inside, −1 from outside.
    pub(super) sign: f64,
    /// The place among the side's corners of each of those in the order of [`TETRAHEDRON_SIDES`].
    pub(super) places: [usize; 3],
}

/// Forces ∫ λ_a σν in N of the three corners of each side, on the tetrahedron that it looks out of.
pub(super) type SideForces = Vec<[Vector3<f64>; 3]>;

impl MeshSides {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let mut seen: Vec<([usize; 3], usize, usize)> = Vec::new();
        for (t, corners) in mesh.tetrahedra.iter().enumerate() {
            for (k, side) in TETRAHEDRON_SIDES.into_iter().enumerate() {
                seen.push((sorted(side.map(|c| corners[c])), t, k));
            }
        }
        seen.sort_unstable();
        let facets = mesh.facets.iter().enumerate();
        let mut facets: Vec<([usize; 3], usize)> =
            facets.map(|(f, nodes)| (sorted(*nodes), f)).collect();
        facets.sort_unstable();
        let facet_of = |nodes: &[usize; 3]| {
            let found = facets.binary_search_by_key(nodes, |facet| facet.0);
            found.ok().map(|place| facets[place].1)
        };
        let mut sides = Vec::new();
        let mut of_tetrahedra = vec![[SeenSide::default(); 4]; mesh.tetrahedra.len()];
        for same in seen.chunk_by(|a, b| a.0 == b.0) {
            let (nodes, inside, k) = same[0];
            let corners = &mesh.tetrahedra[inside];
            let [a, b, c] = mesh.corners(&nodes).map(Vector3::from);
            let area = (b - a).cross(&(c - a)) / 2.0;
            let away = a - Vector3::from(mesh.coordinates[corners[k]]);
            for (place, &(_, t, k)) in same.iter().enumerate() {
                let own = TETRAHEDRON_SIDES[k].map(|c| mesh.tetrahedra[t][c]);
                of_tetrahedra[t][k] = SeenSide {
                    side: sides.len(),
                    sign: if place == 0 { 1.0 } else { -1.0 },
                    places: own.map(|n| nodes.iter().position(|m| *m == n).unwrap_or(0)),
                };
            }
            sides.push(Side {
                nodes,
                inside,
                outside: same.get(1).map(|other| other.1),
                facet: facet_of(&nodes).filter(|_| same.len() == 1),
                area: outward(area, away),
            });
        }
        Self {
            sides,
            of_tetrahedra,
        }
    }

    /// The data of the stress of a tetrahedron under forces on its sides and a force f per volume in N/m³.
    pub(super) fn data(
        &self,
        tetrahedron: usize,
        element: &MacroElement,
        forces: &SideForces,
        body_force: Vector3<f64>,
    ) -> Data {
        let mut data = Data::zeros();
        for (k, seen) in self.of_tetrahedra[tetrahedron].iter().enumerate() {
            for (corner, place) in seen.places.into_iter().enumerate() {
                let force = element.inverse * forces[seen.side][place] * seen.sign;
                data.fixed_rows_mut::<3>(k * SIDE_DATA + corner * 3)
                    .copy_from(&force);
            }
        }
        let divergence = element.inverse * body_force * -element.jacobian;
        data.fixed_rows_mut::<3>(DATA - 3).copy_from(&divergence);
        data
    }
}
