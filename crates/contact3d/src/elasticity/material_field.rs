//! The elasticity tensor of every tetrahedron.

use nalgebra::Matrix6;

use crate::{mesh::Mesh, scene::Scene};

/// The elasticity tensor of every tetrahedron.
#[derive(Debug, Clone)]
pub struct MaterialField<'a> {
    /// C in Pa of the body's own material, then of each region.
    tensors: Vec<Matrix6<f64>>,
    /// Region of each tetrahedron; empty for a body of one material.
    region: &'a [usize],
}

impl<'a> MaterialField<'a> {
    /// The materials of a validated scene on its mesh.
    #[must_use]
    pub fn new(scene: &Scene, mesh: &'a Mesh) -> Self {
        let materials = [&scene.material]
            .into_iter()
            .chain(scene.regions.iter().map(|region| &region.material));
        let tensor = |material: &crate::scene::Material| {
            material
                .elasticity()
                .expect("a validated material has an elasticity tensor")
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
    pub(crate) fn compliances(&self) -> Vec<Matrix6<f64>> {
        let inverse = |tensor: &Matrix6<f64>| {
            let inverse = tensor.try_inverse();
            inverse.expect("a validated material has a positive definite elasticity tensor")
        };
        self.tensors.iter().map(inverse).collect()
    }

    /// C in Pa of the body's own material, then of each region.
    pub(crate) fn tensors(&self) -> &[Matrix6<f64>] {
        &self.tensors
    }

    /// C in Pa of a tetrahedron.
    #[must_use]
    pub(crate) fn tensor(&self, tetrahedron: usize) -> &Matrix6<f64> {
        let region = self.region.get(tetrahedron).copied().unwrap_or(0);
        &self.tensors[region]
    }
}
