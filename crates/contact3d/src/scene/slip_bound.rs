//! The laws of friction: what each takes as the bound of tangential stresses, and its words.

use super::{FrictionLaw, Quantity};

/// The law of tangential stresses ‖F⁻¹σ_t‖ ≤ g.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionModel {
    /// F, which is constant beside a given slip bound.
    pub coefficients: FrictionLaw,
    /// g.
    pub bound: SlipBound,
}

/// The slip bound g of a law of friction. Solvers ask what it depends on; pictures and reports ask for its words.
#[derive(Debug, Clone, PartialEq)]
pub enum SlipBound {
    /// Coulomb's law: the pressure itself, g = λ_ν.
    Pressure,
    /// The pressure up to a cap in Pa, g = min(λ_ν, p_cap).
    Capped(f64),
    /// Tresca's law: a given g in Pa.
    Given(Quantity),
}

/// The words of a law.
#[derive(Debug, Clone, Copy)]
pub struct LawWords {
    /// Its name.
    pub name: &'static str,
    /// The law as programs see it; `None` for Coulomb's, which is known by the shape of its coefficients.
    word: Option<&'static str>,
    /// Its condition for a person; `None` for Coulomb's own.
    pub condition: Option<&'static str>,
    /// Its slip bound.
    pub bound: &'static str,
}

impl FrictionModel {
    /// The law as programs see it; without friction, too.
    #[must_use]
    pub fn word(model: Option<&Self>) -> &'static str {
        model.map_or("frictionless", |law| {
            let word = law.bound.words().word;
            word.unwrap_or_else(|| law.coefficients.shape())
        })
    }
}

impl SlipBound {
    /// How it is told.
    #[must_use]
    pub fn words(&self) -> LawWords {
        match self {
            Self::Pressure => LawWords {
                name: "Coulomb",
                word: None,
                condition: None,
                bound: "the pressure as its slip bound (Coulomb's law)",
            },
            Self::Capped(_) => LawWords {
                name: "capped Coulomb",
                word: Some("capped"),
                condition: Some("up to a pressure cap: |F^-1 sigma_t| <= min(-sigma_nu, p_cap)"),
                bound: "a slip bound capped at a pressure",
            },
            Self::Given(_) => LawWords {
                name: "Tresca",
                word: Some("tresca"),
                condition: Some("with a given slip bound: |F^-1 sigma_t| <= g"),
                bound: "a given slip bound (Tresca's law)",
            },
        }
    }

    /// The stress ≥ 0 that differs from pane to pane, with its key; `None` for laws without one.
    #[must_use]
    pub fn place_dependent(&self) -> Option<(&'static str, &Quantity)> {
        match self {
            Self::Pressure | Self::Capped(_) => None,
            Self::Given(bound) => Some(("slip_bound", bound)),
        }
    }

    /// Whether it is the pressure itself, as in Coulomb's law.
    #[must_use]
    pub fn is_pressure(&self) -> bool {
        matches!(self, Self::Pressure)
    }

    /// Whether it follows the pressure. If not, equilibrium is one minimisation.
    #[must_use]
    pub fn follows_pressure(&self) -> bool {
        match self {
            Self::Pressure | Self::Capped(_) => true,
            Self::Given(_) => false,
        }
    }

    /// g in Pa under a pressure λ_ν in Pa, where `of_pane` is the mean of the place-dependent stress; NaN for NaN where it
    /// follows the pressure.
    pub(crate) fn at(&self, pressure: f64, of_pane: impl FnOnce() -> f64) -> f64 {
        match self {
            Self::Capped(cap) if pressure > *cap => *cap,
            Self::Capped(_) | Self::Pressure => pressure,
            Self::Given(_) => of_pane(),
        }
    }

    /// dg/dλ_ν; at a cap that of larger pressures, an element of the generalised derivative.
    pub(crate) fn slope(&self, pressure: f64) -> f64 {
        match self {
            Self::Capped(cap) if pressure >= *cap => 0.0,
            Self::Capped(_) | Self::Pressure => 1.0,
            Self::Given(_) => 0.0,
        }
    }
}
