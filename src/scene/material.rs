use nalgebra::Matrix6;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The elastic law σ = C ε.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Material {
    /// Hooke's law with two constants.
    Isotropic(Isotropic),
}

/// An isotropic linear elastic material.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Isotropic {
    /// Young's modulus E > 0 in Pa.
    pub young_modulus: f64,
    /// Poisson's ratio, −1 < ν < 0.5.
    pub poisson_ratio: f64,
}

impl Material {
    /// The elasticity tensor C in Voigt notation in Pa, for σ = (xx, yy, zz, yz, xz, xy) and
    /// engineering shear strains 2ε_yz, 2ε_xz, 2ε_xy.
    #[must_use]
    pub fn elasticity(&self) -> Matrix6<f64> {
        let Self::Isotropic(Isotropic {
            young_modulus,
            poisson_ratio,
        }) = *self;
        let lame_lambda =
            young_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
        let lame_mu = young_modulus / (2.0 * (1.0 + poisson_ratio));
        Matrix6::from_fn(|i, j| match (i < 3, j < 3) {
            (true, true) => lame_lambda + if i == j { 2.0 * lame_mu } else { 0.0 },
            (false, false) if i == j => lame_mu,
            _ => 0.0,
        })
    }
}
