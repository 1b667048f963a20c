//! Bodies and their materials, built in Rust.

use std::path::PathBuf;

use super::super::{Body, Brick, ElementOrder, GmshFile, Isotropic, Material, Shape};

impl Body {
    /// A box (0, Lx) × (0, Ly) × (0, Lz) in m, cut in equal cells; for others make a [`Brick`] first.
    #[must_use]
    pub fn brick(size: [f64; 3], cells: [usize; 3]) -> Self {
        Brick::new(size, cells).into()
    }

    /// A mesh file of Gmsh whose unit of length is `unit` metres.
    #[must_use]
    pub fn gmsh(file: impl Into<PathBuf>, unit: f64) -> Self {
        let file = GmshFile {
            file: file.into(),
            unit,
            digest: None,
        };
        Shape::Gmsh(file).into()
    }

    /// The same body with other elements.
    #[must_use]
    pub fn with_element(self, element: ElementOrder) -> Self {
        Self { element, ..self }
    }
}

impl Material {
    /// Hooke's law with Young's modulus in Pa and Poisson's ratio.
    #[must_use]
    pub fn isotropic(young_modulus: f64, poisson_ratio: f64) -> Self {
        Self::Isotropic(Isotropic {
            young_modulus,
            poisson_ratio,
        })
    }
}
