//! The contact face as a surface of linear triangles: forms and norms of Y^h.

use nalgebra::Vector3;

use super::scatter::{Scatter, product};
use crate::{
    elasticity::DofMap,
    linalg::{CscMatrix, dot},
    mesh::{ContactSurface, Mesh, triangle_area},
};

/// A flat surface of linear triangles, some of whose nodes are held.
#[derive(Debug, Clone)]
pub(super) struct Face {
    /// Its nodes in m, `[n]`.
    pub(super) points: Vec<[f64; 3]>,
    /// Nodes of each triangle.
    pub(super) triangles: Vec<[usize; 3]>,
    /// The place among the free nodes; `None` where functions of Y^h vanish.
    pub(super) place: Vec<Option<usize>>,
}

/// The mass and the stiffness of scalar functions of Y^h over the free nodes.
pub(super) struct FaceForms {
    /// ∫ φ_i φ_j in m².
    pub(super) mass: CscMatrix,
    /// ∫ ∇φ_i·∇φ_j.
    pub(super) stiffness: CscMatrix,
}

impl Face {
    /// The contact face of a mesh of linear tetrahedra; a node of which one component is free is free.
    pub(super) fn new(mesh: &Mesh, surface: &ContactSurface, dofs: &DofMap) -> Self {
        let local = |node: usize| surface.nodes.partition_point(|&n| n < node);
        let facets = surface.facets.iter();
        Self::with_held(
            surface.nodes.iter().map(|&n| mesh.coordinates[n]).collect(),
            facets.map(|&f| mesh.facets[f].map(local)).collect(),
            |node| dofs.dof[surface.nodes[node]].iter().all(Option::is_none),
        )
    }

    pub(super) fn with_held(
        points: Vec<[f64; 3]>,
        triangles: Vec<[usize; 3]>,
        is_held: impl Fn(usize) -> bool,
    ) -> Self {
        let mut free = 0;
        let place = (0..points.len()).map(|node| {
            (!is_held(node)).then(|| {
                free += 1;
                free - 1
            })
        });
        Self {
            place: place.collect(),
            points,
            triangles,
        }
    }

    /// Number of free nodes, the dimension of Y^h.
    pub(super) fn n_free(&self) -> usize {
        self.place.iter().flatten().count()
    }

    pub(super) fn corners(&self, triangle: usize) -> [[f64; 3]; 3] {
        self.triangles[triangle].map(|node| self.points[node])
    }

    pub(super) fn area(&self, triangle: usize) -> f64 {
        triangle_area(&self.corners(triangle))
    }

    /// h_Γ: the largest diameter of a triangle.
    pub(super) fn size(&self) -> f64 {
        let edges = self
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let length = |[a, b]: [usize; 2]| distance(self.points[a], self.points[b]);
        edges.map(length).fold(0.0, f64::max)
    }

    /// ∫ φ_j of the hat functions, `[n]`.
    pub(super) fn lumped(&self) -> Vec<f64> {
        let mut lumped = vec![0.0; self.points.len()];
        for (t, nodes) in self.triangles.iter().enumerate() {
            nodes.iter().for_each(|&n| lumped[n] += self.area(t) / 3.0);
        }
        lumped
    }

    pub(super) fn forms(&self) -> FaceForms {
        let n = self.n_free();
        let (mut mass, mut stiffness) = (Scatter::new(n), Scatter::new(n));
        for (t, nodes) in self.triangles.iter().enumerate() {
            let area = self.area(t);
            let gradients = gradients(&self.corners(t));
            for (a, row) in nodes.iter().enumerate() {
                for (b, column) in nodes.iter().enumerate() {
                    let (Some(row), Some(column)) = (self.place[*row], self.place[*column]) else {
                        continue;
                    };
                    mass.add(row, column, area / if a == b { 6.0 } else { 12.0 });
                    stiffness.add(row, column, area * gradients[a].dot(&gradients[b]));
                }
            }
        }
        FaceForms {
            mass: mass.matrix(),
            stiffness: stiffness.matrix(),
        }
    }

    /// The values of a nodal field at the free nodes.
    pub(super) fn to_free(&self, nodal: impl Fn(usize) -> f64) -> Vec<f64> {
        let nodes = self.place.iter().enumerate();
        nodes
            .filter_map(|(node, place)| place.map(|_| nodal(node)))
            .collect()
    }

    /// The norm of a pair of functions of Y^h in L²(Γ_c), from values at the nodes.
    pub(super) fn norm_of_pair(&self, mass: &CscMatrix, values: &[[f64; 2]]) -> f64 {
        let square = |k: usize| {
            let values = self.to_free(|node| values[node][k]);
            dot(&values, &product(mass, &values))
        };
        (square(0) + square(1)).sqrt()
    }
}

/// Gradients of the barycentric coordinates of a triangle in space.
pub(super) fn gradients(corners: &[[f64; 3]; 3]) -> [Vector3<f64>; 3] {
    let points = corners.map(Vector3::from);
    let normal = (points[1] - points[0]).cross(&(points[2] - points[0]));
    let square = normal.norm_squared();
    [0, 1, 2].map(|k| normal.cross(&(points[(k + 2) % 3] - points[(k + 1) % 3])) / square)
}

pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (Vector3::from(a) - Vector3::from(b)).norm()
}
