//! One tetrahedron of a mesh: places, strains, and the nearest place to a point.

use nalgebra::{Matrix3, Vector3, Vector6};

use super::Field;
use crate::{
    elasticity::{Simplex, quadratic_gradients},
    mesh::{IsoparametricMap, Mesh, is_straight},
    reference::{TETRAHEDRON_EDGES, quadrature, shape::quadratic_tetrahedron},
};

/// Steps of Newton's method for a place in a curved tetrahedron; few are needed, and more help no point outside.
const STEPS: usize = 12;

/// Steps below this size in barycentric coordinates are roundings.
const SMALL_STEP: f64 = 1e-13;

/// Barycentric coordinates down to minus this belong to a tetrahedron: roundings of places on its sides.
const ROUNDING: f64 = 1e-10;

/// A tetrahedron of a mesh.
#[derive(Debug, Clone)]
pub(super) enum Piece {
    /// On straight sides.
    Straight {
        /// Corners in m.
        corners: [[f64; 3]; 4],
        /// Volume and gradients.
        simplex: Simplex,
    },
    /// On curved sides.
    Curved {
        /// Its ten nodes in m.
        nodes: [[f64; 3]; 10],
        /// The map through them.
        map: Box<IsoparametricMap>,
    },
}

impl Piece {
    /// A tetrahedron of a mesh.
    pub(super) fn of(mesh: &Mesh, t: usize) -> Self {
        let corners = mesh.corners(&mesh.tetrahedra[t]);
        let middles = mesh.mid_edges.as_ref();
        let middles = middles.map(|known| mesh.corners(&known.tetrahedra[t]));
        match middles.filter(|middles| !is_straight(&corners, &TETRAHEDRON_EDGES, middles)) {
            None => Self::Straight {
                simplex: Simplex::new(&corners),
                corners,
            },
            Some(middles) => Self::Curved {
                nodes: std::array::from_fn(|k| if k < 4 { corners[k] } else { middles[k - 4] }),
                map: Box::new(IsoparametricMap::new(&corners, &middles)),
            },
        }
    }

    /// Smallest and largest coordinates of a box around it in m.
    pub(super) fn surrounding_box(&self) -> [[f64; 3]; 2] {
        let around = |nodes: &[[f64; 3]]| {
            let with = |start: f64, choose: fn(f64, f64) -> f64| {
                std::array::from_fn(|c| nodes.iter().map(|x| x[c]).fold(start, choose))
            };
            [
                with(f64::INFINITY, f64::min),
                with(f64::NEG_INFINITY, f64::max),
            ]
        };
        match self {
            Self::Straight { corners, .. } => around(corners),
            // The quadratic map is a convex combination of corners and of 2 m − (a + b)/2 for edges a b with middle m.
            Self::Curved { nodes, .. } => {
                let mut controls = *nodes;
                for (e, [a, b]) in TETRAHEDRON_EDGES.into_iter().enumerate() {
                    controls[4 + e] = std::array::from_fn(|c| {
                        2.0 * nodes[4 + e][c] - 0.5 * (nodes[a][c] + nodes[b][c])
                    });
                }
                around(&controls)
            }
        }
    }

    /// The place in m of a point in barycentric coordinates, and the volume in m³ of a straight tetrahedron with the
    /// Jacobian there.
    pub(super) fn place(&self, at: &[f64; 4]) -> ([f64; 3], f64) {
        match self {
            Self::Straight { corners, simplex } => (quadrature::point(corners, at), simplex.volume),
            Self::Curved { map, .. } => (map.place(at), map.geometry(at).0),
        }
    }

    /// The displacement at a point in barycentric coordinates in m.
    pub(super) fn displacement(field: Field<'_>, t: usize, at: &[f64; 4]) -> Vector3<f64> {
        let sum = |shape: &[f64]| {
            let nodes = field.mesh.tetrahedron_nodes(t).zip(shape);
            nodes
                .map(|(n, w)| Vector3::from(field.displacement[n]) * *w)
                .sum()
        };
        match field.mesh.mid_edges {
            None => sum(at),
            Some(_) => sum(&quadratic_tetrahedron(at)),
        }
    }

    /// Voigt strain (xx, yy, zz, 2yz, 2xz, 2xy) of a displacement at a point in barycentric coordinates.
    pub(super) fn strain(&self, field: Field<'_>, t: usize, at: &[f64; 4]) -> Vector6<f64> {
        let slope = |gradients: &[Vector3<f64>]| -> Matrix3<f64> {
            let nodes = field.mesh.tetrahedron_nodes(t).zip(gradients);
            nodes
                .map(|(n, g)| Vector3::from(field.displacement[n]) * g.transpose())
                .sum()
        };
        let slope = match (self, &field.mesh.mid_edges) {
            (Self::Straight { simplex, .. }, None) => slope(&simplex.gradients),
            (Self::Straight { simplex, .. }, Some(_)) => {
                slope(&quadratic_gradients(&simplex.gradients, at))
            }
            (Self::Curved { map, .. }, _) => slope(&map.geometry(at).1),
        };
        let shear = |i: usize, j: usize| slope[(i, j)] + slope[(j, i)];
        let [x, y, z] = [0, 1, 2].map(|c| slope[(c, c)]);
        Vector6::new(x, y, z, shear(1, 2), shear(0, 2), shear(0, 1))
    }

    /// The distance in m from a point to the piece, 0 inside, and the barycentric coordinates of the place in it that
    /// the point is taken for: its own, with the negative ones cut off.
    pub(super) fn nearest(&self, point: [f64; 3]) -> (f64, [f64; 4]) {
        let found = self.barycentric(point);
        if !found.iter().all(|l| l.is_finite()) {
            // Newton's method leads nowhere from far outside a curved tetrahedron.
            return (f64::INFINITY, [0.25; 4]);
        }
        let least = found.iter().copied().fold(f64::INFINITY, f64::min);
        let inside = found.map(|l| l.max(0.0));
        let sum: f64 = inside.iter().sum();
        let inside = inside.map(|l| l / sum);
        if least >= -ROUNDING {
            return (0.0, inside);
        }
        let off = Vector3::from(self.place(&inside).0) - Vector3::from(point);
        (off.norm(), inside)
    }

    fn barycentric(&self, point: [f64; 3]) -> [f64; 4] {
        let point = Vector3::from(point);
        match self {
            Self::Straight { corners, simplex } => {
                let arm = point - Vector3::from(corners[0]);
                let [_, b, c, d] = simplex.gradients.map(|gradient| gradient.dot(&arm));
                [1.0 - b - c - d, b, c, d]
            }
            Self::Curved { map, .. } => {
                let mut at = [0.25; 4];
                for _ in 0..STEPS {
                    let arm = point - Vector3::from(map.place(&at));
                    let (_, slopes) = map.geometry(&at);
                    // λ_k is 1 at corner k and ½ in the middle of its edges.
                    let step: [f64; 4] = std::array::from_fn(|k| {
                        let own = TETRAHEDRON_EDGES.iter().zip(&slopes[4..]);
                        let own = own.filter(|(ends, _)| ends.contains(&k));
                        let halves: Vector3<f64> = own.map(|(_, slope)| slope * 0.5).sum();
                        (slopes[k] + halves).dot(&arm)
                    });
                    at = std::array::from_fn(|k| at[k] + step[k]);
                    if step.iter().all(|s| s.abs() < SMALL_STEP) {
                        break;
                    }
                }
                at
            }
        }
    }
}
