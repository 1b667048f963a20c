//! The P1 tetrahedron: gradients, stiffness blocks, stresses, nodal forces.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::simplex::{Simplex, stress, traction, unit_stresses};
use crate::{
    mesh::{IsoparametricMap, Mesh, is_straight},
    reference::{TETRAHEDRON_EDGES, quadrature, shape::quadratic_tetrahedron_slopes},
};

/// Centre of a tetrahedron in barycentric coordinates.
const CENTROID: [f64; 4] = [0.25; 4];

/// A tetrahedron as assembly sees it; nodes are its corners, then its mid-edge nodes.
#[derive(Debug, Clone)]
pub(crate) enum Element {
    /// Four nodes, constant strain.
    Linear(Simplex),
    /// Ten nodes on straight sides, linear strain.
    Quadratic(Simplex),
    /// Ten nodes on curved sides, isoparametric.
    Curved(Box<CurvedTetrahedron>),
}

/// A point of integration and the gradients of the shape functions there.
#[derive(Debug, Clone, Copy)]
struct IntegrationPoint {
    /// Volume in m³ that the point stands for.
    volume: f64,
    /// ∇φ_a in 1/m, in the order of the element's nodes.
    gradients: [Vector3<f64>; 10],
}

/// An isoparametric quadratic tetrahedron.
#[derive(Debug, Clone)]
pub(crate) struct CurvedTetrahedron {
    map: IsoparametricMap,
    points: Vec<IntegrationPoint>,
}

/// One summand (4 λ_k − shift) ∇λ_along of the gradient of a quadratic shape function.
#[derive(Clone, Copy)]
struct Term {
    k: usize,
    shift: f64,
    along: usize,
}

/// ∇(λ_a (2λ_a − 1)) = (4λ_a − 1) ∇λ_a and ∇(4 λ_a λ_b) = 4λ_a ∇λ_b + 4λ_b ∇λ_a.
fn terms(node: usize) -> impl Iterator<Item = Term> + Clone {
    let (pairs, shift) = match node.checked_sub(4) {
        None => ([Some([node, node]), None], 1.0),
        Some(e) => {
            let [a, b] = TETRAHEDRON_EDGES[e];
            ([Some([a, b]), Some([b, a])], 0.0)
        }
    };
    let pairs = pairs.into_iter().flatten();
    pairs.map(move |[k, along]| Term { k, shift, along })
}

/// The mean of (4λ_k − s)(4λ_l − t) over a tetrahedron, from mean λ_k = 1/4, mean λ_k λ_l = (1 + δ_kl)/20.
fn mean_product(first: Term, second: Term) -> f64 {
    let product = if first.k == second.k { 1.6 } else { 0.8 };
    product - first.shift - second.shift + first.shift * second.shift
}

impl Element {
    /// The element of a tetrahedron of the mesh.
    #[must_use]
    pub(crate) fn of(mesh: &Mesh, tetrahedron: usize) -> Self {
        let corners = mesh.corners(&mesh.tetrahedra[tetrahedron]);
        let Some(mid_edges) = &mesh.mid_edges else {
            return Self::Linear(Simplex::new(&corners));
        };
        let middles = mesh.corners(&mid_edges.tetrahedra[tetrahedron]);
        if is_straight(&corners, &TETRAHEDRON_EDGES, &middles) {
            Self::Quadratic(Simplex::new(&corners))
        } else {
            Self::Curved(Box::new(CurvedTetrahedron::new(&corners, &middles)))
        }
    }

    /// The 3 × 3 stiffness block ∫ G_aᵀ C G_b of two nodes in N/m, where G_a maps a nodal
    /// displacement to Voigt strain.
    ///
    /// Exact on straight sides, where the blocks of P1 are weighted by the means of [`Term`]s.
    #[must_use]
    pub(crate) fn stiffness_block(
        &self,
        elasticity: &Matrix6<f64>,
        a: usize,
        b: usize,
    ) -> Matrix3<f64> {
        match self {
            Self::Linear(simplex) => simplex.stiffness_block(elasticity, a, b),
            Self::Quadratic(simplex) => {
                let mut block = Matrix3::zeros();
                for first in terms(a) {
                    for second in terms(b) {
                        let mean = mean_product(first, second);
                        let part = simplex.stiffness_block(elasticity, first.along, second.along);
                        block += part * mean;
                    }
                }
                block
            }
            Self::Curved(curved) => {
                let mut block = Matrix3::zeros();
                for point in &curved.points {
                    let stresses = unit_stresses(elasticity, &point.gradients[b]);
                    let forces = stresses.map(|s| traction(&point.gradients[a], &s) * point.volume);
                    block += Matrix3::from_columns(&forces);
                }
                block
            }
        }
    }

    /// Adds the nodal forces ∫ Gᵀ C ε(u) in N that balance the stress of a displacement u in m, both
    /// in the order of the element's nodes.
    pub(crate) fn add_internal_forces(
        &self,
        elasticity: &Matrix6<f64>,
        displacement: &[[f64; 3]],
        forces: &mut [Vector3<f64>],
    ) {
        let mut add = |volume: f64, gradients: &[Vector3<f64>]| {
            let stress = stress(elasticity, gradients, displacement);
            for (force, gradient) in forces.iter_mut().zip(gradients) {
                *force += traction(gradient, &stress) * volume;
            }
        };
        match self {
            Self::Linear(simplex) => add(simplex.volume, &simplex.gradients),
            // The integrand is quadratic.
            Self::Quadratic(simplex) => {
                for (at, weight) in quadrature::TETRAHEDRON_2 {
                    add(
                        weight * simplex.volume,
                        &quadratic_gradients(&simplex.gradients, &at),
                    );
                }
            }
            Self::Curved(curved) => {
                for point in &curved.points {
                    add(point.volume, &point.gradients);
                }
            }
        }
    }

    /// Voigt stress C ε(u) in Pa at a point in barycentric coordinates.
    #[must_use]
    pub(crate) fn stress(
        &self,
        elasticity: &Matrix6<f64>,
        displacement: &[[f64; 3]],
        at: &[f64; 4],
    ) -> Vector6<f64> {
        match self {
            Self::Linear(simplex) => stress(elasticity, &simplex.gradients, displacement),
            Self::Quadratic(simplex) => {
                let gradients = quadratic_gradients(&simplex.gradients, at);
                stress(elasticity, &gradients, displacement)
            }
            Self::Curved(curved) => {
                let (_, gradients) = curved.map.geometry(at);
                stress(elasticity, &gradients, displacement)
            }
        }
    }

    /// Voigt stress C ε(u) in Pa at the centroid.
    #[must_use]
    pub(crate) fn centroid_stress(
        &self,
        elasticity: &Matrix6<f64>,
        displacement: &[[f64; 3]],
    ) -> Vector6<f64> {
        self.stress(elasticity, displacement, &CENTROID)
    }
}

/// ∇φ of the ten quadratic shape functions from the gradients of the barycentric coordinates.
pub(crate) fn quadratic_gradients(
    simplex: &[Vector3<f64>; 4],
    at: &[f64; 4],
) -> [Vector3<f64>; 10] {
    quadratic_tetrahedron_slopes(at)
        .map(|slopes| (0..4).map(|k| simplex[k] * slopes[k]).sum::<Vector3<f64>>())
}

impl CurvedTetrahedron {
    /// Integrates by the 14 points of degree 5.
    #[must_use]
    fn new(corners: &[[f64; 3]; 4], middles: &[[f64; 3]; 6]) -> Self {
        let map = IsoparametricMap::new(corners, middles);
        let points = quadrature::tetrahedron_5().map(|(at, weight)| {
            let (volume, gradients) = map.geometry(&at);
            IntegrationPoint {
                volume: weight * volume,
                gradients,
            }
        });
        Self {
            points: points.collect(),
            map,
        }
    }

    /// The place of a point in m, and the volume in m³ of a straight tetrahedron with the Jacobian
    /// there.
    pub(super) fn place(&self, at: &[f64; 4]) -> ([f64; 3], f64) {
        (self.map.place(at), self.map.geometry(at).0)
    }
}
