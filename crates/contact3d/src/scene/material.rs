//! Elastic materials and their elasticity tensors.

use nalgebra::{Matrix3, Matrix6, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Measure, ProblemPart};

/// The elastic law σ = C ε.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(extend("examples" = ["material.isotropic = { young_modulus = 2.1e11, poisson_ratio = 0.3 }"]))]
pub enum Material {
    /// Hooke's law with two constants.
    Isotropic(Isotropic),
    /// Three planes of symmetry, nine constants.
    Orthotropic(Orthotropic),
    /// Any elasticity tensor.
    Voigt(Voigt),
}

/// An isotropic linear elastic material.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Isotropic {
    /// Young's modulus E > 0 in Pa.
    #[schemars(extend("measures" = Measure::Modulus, "exclusiveMinimum" = 0))]
    pub young_modulus: f64,
    /// Poisson's ratio, −1 < ν < 0.5; at 0.5 the material is incompressible, and rubber has 0.49 to 0.4999, on quadratic tetrahedra
    /// (body.element = "P2").
    #[schemars(extend("exclusiveMinimum" = -1, "exclusiveMaximum" = 0.5))]
    pub poisson_ratio: f64,
}

/// An orthotropic linear elastic material: ε = C⁻¹σ with C⁻¹_ii = 1/E_i, C⁻¹_ij = −ν_ij/E_i.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Orthotropic {
    /// Young's moduli [E₁, E₂, E₃] > 0 in Pa.
    #[schemars(extend("measures" = Measure::Modulus, "exclusiveMinimum" = 0))]
    pub young_moduli: [f64; 3],
    /// Poisson's ratios [ν₂₃, ν₁₃, ν₁₂]: ν_ij is the contraction along j under tension along i.
    pub poisson_ratios: [f64; 3],
    /// Shear moduli [G₂₃, G₁₃, G₁₂] > 0 in Pa.
    #[schemars(extend("measures" = Measure::Modulus, "exclusiveMinimum" = 0))]
    pub shear_moduli: [f64; 3],
    /// First two material axes in the global frame, orthogonal, of any length; x and y when not
    /// given.
    #[serde(default = "global_axes")]
    pub axes: [[f64; 3]; 2],
}

fn global_axes() -> [[f64; 3]; 2] {
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
}

/// An elasticity tensor in Voigt notation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Voigt {
    /// The symmetric matrix C in Pa for σ = (xx, yy, zz, yz, xz, xy) and engineering shear strains
    /// 2ε_yz, 2ε_xz, 2ε_xy, in the global axes.
    #[schemars(extend("measures" = Measure::Modulus))]
    pub stiffness: [[f64; 6]; 6],
}

/// A part of the body with a material of its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Where it is.
    #[schemars(extend("part" = ProblemPart::Mesh))]
    pub part: Part,
    /// Its elastic law.
    pub material: Material,
}

/// A part of the body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(extend("examples" = ["part.box = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]"]))]
pub enum Part {
    /// A physical volume of a Gmsh file.
    Group(String),
    /// The tetrahedra whose centroid lies between two corners [min, max] in m.
    #[schemars(extend("measures" = Measure::Length))]
    Box([[f64; 3]; 2]),
}

impl Material {
    /// The elasticity tensor C in Voigt notation in Pa, for σ = (xx, yy, zz, yz, xz, xy) and
    /// engineering shear strains 2ε_yz, 2ε_xz, 2ε_xy; `None` when the constants of an orthotropic
    /// law have no inverse.
    #[must_use]
    pub fn elasticity(&self) -> Option<Matrix6<f64>> {
        match self {
            Self::Isotropic(constants) => Some(constants.elasticity()),
            Self::Orthotropic(constants) => constants.elasticity(),
            Self::Voigt(voigt) => Some(Matrix6::from_fn(|i, j| voigt.stiffness[i][j])),
        }
    }
}

impl Material {
    /// E/(1 − ν²) in Pa, what a body yields by where another presses it, for the isotropic law with the same bulk and shear modulus in Voigt's
    /// mean over all directions.
    ///
    /// # Panics
    /// For a material without an elasticity tensor, which no validated scene has.
    #[must_use]
    pub fn contact_modulus(&self) -> f64 {
        let c = self.elasticity().expect("a validated material");
        let direct: f64 = (0..3).map(|i| c[(i, i)]).sum();
        let cross = c[(0, 1)] + c[(0, 2)] + c[(1, 2)];
        let shears: f64 = (3..6).map(|i| c[(i, i)]).sum();
        let bulk = (direct + 2.0 * cross) / 9.0;
        let shear = (direct - cross + 3.0 * shears) / 15.0;
        let young = 9.0 * bulk * shear / (3.0 * bulk + shear);
        let poisson = young / (2.0 * shear) - 1.0;
        young / (1.0 - poisson * poisson)
    }
}

impl Isotropic {
    fn elasticity(&self) -> Matrix6<f64> {
        let (young, poisson) = (self.young_modulus, self.poisson_ratio);
        let lame_lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
        let lame_mu = young / (2.0 * (1.0 + poisson));
        Matrix6::from_fn(|i, j| match (i < 3, j < 3) {
            (true, true) => lame_lambda + if i == j { 2.0 * lame_mu } else { 0.0 },
            (false, false) if i == j => lame_mu,
            _ => 0.0,
        })
    }
}

impl Orthotropic {
    fn elasticity(&self) -> Option<Matrix6<f64>> {
        let [e1, e2, _] = self.young_moduli;
        let [n23, n13, n12] = self.poisson_ratios;
        let coupling = [[0.0, n12 / e1, n13 / e1], [0.0, 0.0, n23 / e2]];
        let compliance = Matrix3::from_fn(|i, j| {
            if i == j {
                1.0 / self.young_moduli[i]
            } else {
                -coupling[i.min(j)][i.max(j)]
            }
        });
        let direct = compliance.try_inverse()?;
        let mut own = Matrix6::zeros();
        for i in 0..3 {
            for j in i..3 {
                own[(i, j)] = direct[(i, j)];
                own[(j, i)] = direct[(i, j)];
            }
            own[(3 + i, 3 + i)] = self.shear_moduli[i];
        }
        if self.axes == global_axes() {
            return Some(own);
        }
        let first = Vector3::from(self.axes[0]).normalize();
        let second = Vector3::from(self.axes[1]).normalize();
        let rotation = Matrix3::from_columns(&[first, second, first.cross(&second)]);
        let bond = bond_matrix(&rotation);
        let turned = bond * own * bond.transpose();
        Some((turned + turned.transpose()) * 0.5)
    }
}

/// Bond's matrix M with σ = M σ' in Voigt notation when σ = R σ' Rᵀ.
fn bond_matrix(r: &Matrix3<f64>) -> Matrix6<f64> {
    const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)];
    Matrix6::from_fn(|row, column| {
        let ((i, j), (k, l)) = (PAIRS[row], PAIRS[column]);
        if k == l {
            r[(i, k)] * r[(j, k)]
        } else {
            r[(i, k)] * r[(j, l)] + r[(i, l)] * r[(j, k)]
        }
    })
}
