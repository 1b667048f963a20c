//! Stiffness of one tetrahedron, linear or quadratic, in the material at hand.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use crate::{
    mesh::{IsoparametricMap, Mesh, is_straight, tetrahedron_volume},
    reference::{TETRAHEDRON_EDGES, quadratic_tetrahedron_slopes, quadrature},
    scene::{Material, Scene},
};

/// Centre of a tetrahedron in barycentric coordinates.
pub(super) const CENTROID: [f64; 4] = [0.25; 4];

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

/// An isoparametric quadratic tetrahedron.
#[derive(Debug, Clone)]
pub(crate) struct CurvedTetrahedron {
    map: IsoparametricMap,
    /// The volume in m³ that each point of integration stands for, and ∇φ_a in 1/m there, in the order of the element's nodes.
    points: Vec<(f64, [Vector3<f64>; 10])>,
}

/// ([k, along], shift) of the summands (4 λ_k − shift) ∇λ_along of the gradient of a quadratic shape function:
/// ∇(λ_a (2λ_a − 1)) = (4λ_a − 1) ∇λ_a and ∇(4 λ_a λ_b) = 4λ_a ∇λ_b + 4λ_b ∇λ_a.
fn terms(node: usize) -> impl Iterator<Item = ([usize; 2], f64)> + Clone {
    let (pairs, shift) = match node.checked_sub(4) {
        None => ([Some([node, node]), None], 1.0),
        Some(e) => {
            let [a, b] = TETRAHEDRON_EDGES[e];
            ([Some([a, b]), Some([b, a])], 0.0)
        }
    };
    let pairs = pairs.into_iter().flatten();
    pairs.map(move |pair| (pair, shift))
}

/// The mean of (4λ_k − s)(4λ_l − t) over a tetrahedron, from mean λ_k = 1/4, mean λ_k λ_l = (1 + δ_kl)/20.
fn mean_product((k, s): (usize, f64), (l, t): (usize, f64)) -> f64 {
    let product = if k == l { 1.6 } else { 0.8 };
    product - s - t + s * t
}

impl Element {
    /// The element of a tetrahedron of the mesh.
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
    /// Exact on straight sides, where the blocks of P1 are weighted by the means of their [`terms`].
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
                for ([k, along_k], s) in terms(a) {
                    for ([l, along_l], t) in terms(b) {
                        let mean = mean_product((k, s), (l, t));
                        let part = simplex.stiffness_block(elasticity, along_k, along_l);
                        block += part * mean;
                    }
                }
                block
            }
            Self::Curved(curved) => {
                let mut block = Matrix3::zeros();
                for (volume, gradients) in &curved.points {
                    block += block_of(elasticity, [&gradients[a], &gradients[b]], *volume);
                }
                block
            }
        }
    }

    /// The nodal forces ∫ Gᵀ C ε(u) in N that balance the stress of a displacement u in m, both in the order of the
    /// element's nodes.
    pub(super) fn internal_forces(
        &self,
        elasticity: &Matrix6<f64>,
        displacement: &[[f64; 3]],
    ) -> Vec<Vector3<f64>> {
        let mut forces = vec![Vector3::zeros(); displacement.len()];
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
                    let gradients = quadratic_gradients(&simplex.gradients, &at);
                    add(weight * simplex.volume, &gradients);
                }
            }
            Self::Curved(curved) => {
                for (volume, gradients) in &curved.points {
                    add(*volume, gradients);
                }
            }
        }
        forces
    }

    /// Voigt stress C ε(u) in Pa at a point in barycentric coordinates.
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
}

/// ∇φ of the ten quadratic shape functions from the gradients of the barycentric coordinates.
#[must_use]
pub fn quadratic_gradients(simplex: &[Vector3<f64>; 4], at: &[f64; 4]) -> [Vector3<f64>; 10] {
    quadratic_tetrahedron_slopes(at)
        .map(|slopes| (0..4).map(|k| simplex[k] * slopes[k]).sum::<Vector3<f64>>())
}

impl CurvedTetrahedron {
    /// Integrates by the 14 points of degree 5.
    fn new(corners: &[[f64; 3]; 4], middles: &[[f64; 3]; 6]) -> Self {
        let map = IsoparametricMap::new(corners, middles);
        let points = quadrature::tetrahedron_5().map(|(at, weight)| {
            let (volume, gradients) = map.geometry(&at);
            (weight * volume, gradients)
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

/// Geometry of a straight tetrahedron: its volume and the constant gradients of its four
/// barycentric coordinates, the hat functions of P1.
#[derive(Debug, Clone, Copy)]
pub struct Simplex {
    /// Volume V in m³.
    pub volume: f64,
    /// ∇φ_a in 1/m for the four corners a.
    pub gradients: [Vector3<f64>; 4],
}

impl Simplex {
    /// Gradients ∇φ_a = (opposite face's area vector)/(3V), pointing to corner a.
    #[must_use]
    pub fn new(corners: &[[f64; 3]; 4]) -> Self {
        let volume = tetrahedron_volume(corners);
        let p = corners.map(Vector3::from);
        let gradient =
            |b: usize, c: usize, d: usize| (p[d] - p[b]).cross(&(p[c] - p[b])) / (6.0 * volume);
        let gradients = [
            gradient(1, 2, 3),
            gradient(0, 3, 2),
            gradient(0, 1, 3),
            gradient(0, 2, 1),
        ];
        Self { volume, gradients }
    }

    /// The 3 × 3 stiffness block V G_aᵀ C G_b of two corners in N/m, where G_a maps a nodal
    /// displacement to Voigt strain.
    pub(crate) fn stiffness_block(
        &self,
        elasticity: &Matrix6<f64>,
        a: usize,
        b: usize,
    ) -> Matrix3<f64> {
        let gradients = [&self.gradients[a], &self.gradients[b]];
        block_of(elasticity, gradients, self.volume)
    }
}

/// V G_aᵀ C G_b for the gradients at a point that stands for a volume.
fn block_of(elasticity: &Matrix6<f64>, [a, b]: [&Vector3<f64>; 2], volume: f64) -> Matrix3<f64> {
    let stresses = unit_stresses(elasticity, b);
    Matrix3::from_columns(&stresses.map(|stress| traction(a, &stress) * volume))
}

/// Voigt stress C ε(u) in Pa of displacements in m at nodes whose shape functions have some gradients.
pub(super) fn stress(
    elasticity: &Matrix6<f64>,
    gradients: &[Vector3<f64>],
    displacement: &[[f64; 3]],
) -> Vector6<f64> {
    let mut stress = Vector6::zeros();
    for (gradient, u) in gradients.iter().zip(displacement) {
        for (unit, u) in unit_stresses(elasticity, gradient).iter().zip(u) {
            stress += unit * *u;
        }
    }
    stress
}

/// C G: the Voigt stresses (xx, yy, zz, yz, xz, xy) of unit nodal displacements along x, y, z.
pub(super) fn unit_stresses(c: &Matrix6<f64>, g: &Vector3<f64>) -> [Vector6<f64>; 3] {
    [
        c.column(0) * g.x + c.column(4) * g.z + c.column(5) * g.y,
        c.column(1) * g.y + c.column(3) * g.z + c.column(5) * g.x,
        c.column(2) * g.z + c.column(3) * g.y + c.column(4) * g.x,
    ]
}

/// Voigt strains of a displacement in m, `[n_nodes]`, at the corners of each tetrahedron.
#[must_use]
pub fn corner_strains(mesh: &Mesh, displacement: &[[f64; 3]]) -> Vec<[Vector6<f64>; 4]> {
    let unit = Matrix6::identity();
    let of = |t: usize| {
        let element = Element::of(mesh, t);
        let local: Vec<[f64; 3]> = mesh.tetrahedron_nodes(t).map(|n| displacement[n]).collect();
        std::array::from_fn(|k| {
            let at = std::array::from_fn(|j| f64::from(u8::from(j == k)));
            element.stress(&unit, &local, &at)
        })
    };
    (0..mesh.tetrahedra.len()).map(of).collect()
}

/// Gᵀσ = σ ∇φ for a Voigt stress.
#[must_use]
pub fn traction(g: &Vector3<f64>, s: &Vector6<f64>) -> Vector3<f64> {
    Vector3::new(
        s[0] * g.x + s[5] * g.y + s[4] * g.z,
        s[5] * g.x + s[1] * g.y + s[3] * g.z,
        s[4] * g.x + s[3] * g.y + s[2] * g.z,
    )
}

/// The elasticity tensor of every tetrahedron.
#[derive(Debug, Clone)]
pub struct MaterialField<'a> {
    /// C in Pa of the body's own material, then of each region.
    pub(super) tensors: Vec<Matrix6<f64>>,
    /// Region of each tetrahedron; empty for a body of one material.
    region: &'a [usize],
}

impl<'a> MaterialField<'a> {
    /// The materials of a validated scene on its mesh.
    #[must_use]
    pub fn new(scene: &Scene, mesh: &'a Mesh) -> Self {
        let materials = scene.materials().map(|(_, material)| material);
        let tensor = |material: &Material| {
            let tensor = material.elasticity();
            tensor.expect("a validated material has an elasticity tensor")
        };
        Self {
            tensors: materials.map(tensor).collect(),
            region: &mesh.tetrahedron_region,
        }
    }

    /// One material everywhere.
    #[must_use]
    pub fn uniform(tensor: Matrix6<f64>) -> Self {
        Self {
            tensors: vec![tensor],
            region: &[],
        }
    }

    /// C⁻¹ in 1/Pa of the body's own material, then of each region.
    #[must_use]
    pub fn compliances(&self) -> Vec<Matrix6<f64>> {
        let inverse = |tensor: &Matrix6<f64>| {
            let inverse = tensor.try_inverse();
            inverse.expect("a validated material has a positive definite elasticity tensor")
        };
        self.tensors.iter().map(inverse).collect()
    }

    /// C in Pa of a tetrahedron.
    #[must_use]
    pub fn tensor(&self, tetrahedron: usize) -> &Matrix6<f64> {
        &self.tensors[self.region(tetrahedron)]
    }

    /// E/(1 − ν²) of a tetrahedron in Pa, by which a half-space resists what presses on it; of an anisotropic material that of the mean
    /// over all directions (W. Voigt).
    pub(crate) fn plane_strain_modulus(&self, tetrahedron: usize) -> f64 {
        let c = self.tensor(tetrahedron);
        let direct = c[(0, 0)] + c[(1, 1)] + c[(2, 2)];
        let across = c[(0, 1)] + c[(0, 2)] + c[(1, 2)];
        let bulk = (direct + 2.0 * across) / 9.0;
        let shear = (direct - across + 3.0 * (c[(3, 3)] + c[(4, 4)] + c[(5, 5)])) / 15.0;
        4.0 * shear * (3.0 * bulk + shear) / (3.0 * bulk + 4.0 * shear)
    }

    /// Which of the materials a tetrahedron is of: 0 for the body's own.
    #[must_use]
    pub fn region(&self, tetrahedron: usize) -> usize {
        self.region.get(tetrahedron).copied().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f64; 3]; 4] = [
        [0.1, 0.0, 0.2],
        [1.3, 0.1, 0.0],
        [0.2, 0.9, 0.1],
        [0.0, 0.2, 1.1],
    ];

    #[test]
    fn rigid_motions_carry_no_stress() {
        let simplex = Simplex::new(&CORNERS);
        let elasticity = Matrix6::identity();
        let rotation = Vector3::new(0.3, -0.2, 0.5);
        let motion = CORNERS
            .map(|x| (Vector3::new(1.0, 2.0, 3.0) + rotation.cross(&Vector3::from(x))).into());
        // Cancellation of displacements of size 4 through gradients of size 1.
        assert!(stress(&elasticity, &simplex.gradients, &motion).norm() < 1e-13);
    }
}
