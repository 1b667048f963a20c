use nalgebra::{Matrix3, Matrix3x6, Matrix6, Vector3, Vector6};

use crate::mesh::tetrahedron_volume;

/// Geometry of a P1 tetrahedron: its volume and the constant gradients of its four hat functions.
#[derive(Debug, Clone, Copy)]
pub struct Element {
    /// Volume V in m³.
    pub volume: f64,
    /// ∇φ_a in 1/m for the four corners a.
    pub gradients: [Vector3<f64>; 4],
}

impl Element {
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
    #[must_use]
    pub fn stiffness_block(&self, elasticity: &Matrix6<f64>, a: usize, b: usize) -> Matrix3<f64> {
        let (ga, gb) = (
            strain_rows(&self.gradients[a]),
            strain_rows(&self.gradients[b]),
        );
        ga * (elasticity * gb.transpose()) * self.volume
    }

    /// Voigt stress C ε(u) in Pa of nodal displacements u in m.
    #[must_use]
    pub fn stress(&self, elasticity: &Matrix6<f64>, displacement: &[[f64; 3]; 4]) -> Vector6<f64> {
        let strain = self
            .gradients
            .iter()
            .zip(displacement)
            .map(|(gradient, u)| strain_rows(gradient).transpose() * Vector3::from(*u))
            .sum::<Vector6<f64>>();
        elasticity * strain
    }

    /// Nodal forces V G_aᵀ σ in N that balance a stress.
    #[must_use]
    pub fn nodal_forces(&self, stress: &Vector6<f64>) -> [Vector3<f64>; 4] {
        self.gradients
            .map(|gradient| strain_rows(&gradient) * stress * self.volume)
    }
}

/// G_aᵀ for Voigt order (xx, yy, zz, yz, xz, xy) with engineering shears.
fn strain_rows(g: &Vector3<f64>) -> Matrix3x6<f64> {
    #[rustfmt::skip]
    let rows = Matrix3x6::new(
        g.x, 0.0, 0.0, 0.0, g.z, g.y,
        0.0, g.y, 0.0, g.z, 0.0, g.x,
        0.0, 0.0, g.z, g.y, g.x, 0.0,
    );
    rows
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
        let element = Element::new(&CORNERS);
        for axis in 0..3 {
            let gradient: Vector3<f64> = (0..4)
                .map(|a| element.gradients[a] * CORNERS[a][axis])
                .sum();
            let mut expected = Vector3::zeros();
            expected[axis] = 1.0;
            // A handful of roundings on numbers of size 1.
            assert!((gradient - expected).norm() < 1e-14);
        }
    }

    #[test]
    fn rigid_motions_carry_no_stress() {
        let element = Element::new(&CORNERS);
        let elasticity = Matrix6::identity();
        let rotation = Vector3::new(0.3, -0.2, 0.5);
        let motion = CORNERS
            .map(|x| (Vector3::new(1.0, 2.0, 3.0) + rotation.cross(&Vector3::from(x))).into());
        // Cancellation of displacements of size 4 through gradients of size 1.
        assert!(element.stress(&elasticity, &motion).norm() < 1e-13);
    }
}
