//! The straight tetrahedron: volume, gradients of its barycentric coordinates, traction on a plane.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use crate::mesh::tetrahedron_volume;

/// Geometry of a straight tetrahedron: its volume and the constant gradients of its four
/// barycentric coordinates, the hat functions of P1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Simplex {
    /// Volume V in m³.
    pub volume: f64,
    /// ∇φ_a in 1/m for the four corners a.
    pub gradients: [Vector3<f64>; 4],
}

impl Simplex {
    /// Gradients ∇φ_a = (opposite face's area vector)/(3V), pointing to corner a.
    #[must_use]
    pub(crate) fn new(corners: &[[f64; 3]; 4]) -> Self {
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
    #[must_use]
    pub(crate) fn stiffness_block(
        &self,
        elasticity: &Matrix6<f64>,
        a: usize,
        b: usize,
    ) -> Matrix3<f64> {
        let stresses = unit_stresses(elasticity, &self.gradients[b]);
        let forces = stresses.map(|stress| traction(&self.gradients[a], &stress) * self.volume);
        Matrix3::from_columns(&forces)
    }
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

/// Gᵀσ = σ ∇φ for a Voigt stress.
pub(crate) fn traction(g: &Vector3<f64>, s: &Vector6<f64>) -> Vector3<f64> {
    Vector3::new(
        s[0] * g.x + s[5] * g.y + s[4] * g.z,
        s[5] * g.x + s[1] * g.y + s[3] * g.z,
        s[4] * g.x + s[3] * g.y + s[2] * g.z,
    )
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
    fn gradients_reproduce_linear_functions() {
        let simplex = Simplex::new(&CORNERS);
        for axis in 0..3 {
            let gradient: Vector3<f64> = (0..4)
                .map(|a| simplex.gradients[a] * CORNERS[a][axis])
                .sum();
            let mut expected = Vector3::zeros();
            expected[axis] = 1.0;
            // A handful of roundings on numbers of size 1.
            assert!((gradient - expected).norm() < 1e-14);
        }
    }

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
