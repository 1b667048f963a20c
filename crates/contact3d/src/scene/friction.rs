//! The laws of friction of a scene: Coulomb's or Tresca's, isotropic or orthotropic, with what bounds tangential stresses.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Coefficient, LawPoint, Measure, Quantity, is_default, varying::varies};

/// What the scene says about friction: one isotropic coefficient, or two for the axes t₁ and t₂;
/// with a slip bound it is Tresca's law, without one Coulomb's, which a pressure cap may limit.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// Given slip bound g ≥ 0 of Tresca's law ‖F⁻¹σ_t‖ ≤ g in Pa: a number, or an expression in
    /// x, y, z. The coefficients are then constants, and 1 when not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Stress, "minimum" = 0))]
    pub slip_bound: Option<Quantity>,
    /// Pressure p_cap > 0 in Pa above which Coulomb friction grows no further,
    /// ‖F⁻¹σ_t‖ ≤ min(−σ_ν, p_cap); F p_cap is the shear strength of the weaker body. Leave it out where nothing
    /// limits friction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Stress, "exclusiveMinimum" = 0))]
    pub pressure_cap: Option<f64>,
    /// F of an isotropic law, which may depend on |u_t|.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coefficient: Option<Coefficient>,
    /// F₁, which may depend on |u_t1| and |u_t2|.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coefficient_1: Option<Coefficient>,
    /// F₂, which may depend on |u_t1| and |u_t2|.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coefficient_2: Option<Coefficient>,
    /// In a load history, the slip that coefficients follow.
    #[serde(default, skip_serializing_if = "is_default")]
    pub follows: SlipMeasure,
}

/// The slip that coefficients of friction follow in step n of a load history.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SlipMeasure {
    /// The displacement since the first step began, |u_tⁿ|.
    #[default]
    TotalSlip,
    /// The slip of the step, |u_tⁿ − u_tⁿ⁻¹|.
    StepSlip,
    /// The length of the path of sliding, Σ |u_tᵏ − u_tᵏ⁻¹| over the steps k up to n, which wears surfaces in.
    PathLength,
}

/// The matrix F = diag(F₁, F₂) as a function of place and slip.
#[derive(Debug, Clone, PartialEq)]
pub enum FrictionLaw {
    /// F₁ = F₂, a function of |u_t|.
    Isotropic(Coefficient),
    /// F₁ and F₂.
    Orthotropic(Box<[Coefficient; 2]>),
}

varies!(Friction: slip_bound, coefficient, coefficient_1, coefficient_2);

impl Friction {
    /// The coefficients; `None` when the scene gives none, or one of two, or one too many.
    #[must_use]
    pub fn law(&self) -> Option<FrictionLaw> {
        match (&self.coefficient, &self.coefficient_1, &self.coefficient_2) {
            (Some(f), None, None) => Some(FrictionLaw::Isotropic(f.clone())),
            (None, Some(first), Some(second)) => Some(FrictionLaw::Orthotropic(Box::new([
                first.clone(),
                second.clone(),
            ]))),
            (None, None, None) if self.slip_bound.is_some() => {
                Some(FrictionLaw::Isotropic(Coefficient::Constant(1.0)))
            }
            _ => None,
        }
    }

    /// The law that the table gives; `None` where its coefficients are none.
    pub(super) fn model(&self) -> Option<FrictionModel> {
        Some(FrictionModel {
            coefficients: self.law()?,
            bound: match (&self.slip_bound, self.pressure_cap) {
                (Some(bound), _) => SlipBound::Given(bound.clone()),
                (None, Some(cap)) => SlipBound::Capped(cap),
                (None, None) => SlipBound::Pressure,
            },
        })
    }

    /// The coefficients that are given, with their keys.
    pub fn given(&self) -> impl Iterator<Item = (&'static str, &Coefficient)> {
        [
            ("coefficient", &self.coefficient),
            ("coefficient_1", &self.coefficient_1),
            ("coefficient_2", &self.coefficient_2),
        ]
        .into_iter()
        .filter_map(|(key, coefficient)| Some((key, coefficient.as_ref()?)))
    }
}

impl FrictionLaw {
    /// (F₁, F₂) at a place in m for the slips (|u_t1|, |u_t2|) in m. The lengths of the path that was slid before, along t₁, along t₂ and in
    /// the plane, in m, add to |u_t1|, |u_t2| and |u_t|.
    #[must_use]
    pub fn evaluate(&self, path: [f64; 3], position: [f64; 3], slip: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Isotropic(f) => [f.evaluate(&self.point(path, 0, position, slip)); 2],
            Self::Orthotropic(pair) => {
                [0, 1].map(|axis| pair[axis].evaluate(&self.point(path, axis, position, slip)))
            }
        }
    }

    /// What coefficient 0 or 1 depends on, for the slips (|u_t1|, |u_t2|) in m after a path, as in [`Self::evaluate`].
    #[must_use]
    pub fn point(
        &self,
        path: [f64; 3],
        axis: usize,
        position: [f64; 3],
        slip: [f64; 2],
    ) -> LawPoint {
        let after = [path[0] + slip[0], path[1] + slip[1]];
        LawPoint {
            position,
            slip: after,
            own_slip: match self {
                Self::Isotropic(_) => path[2] + slip[0].hypot(slip[1]),
                Self::Orthotropic(_) => after[axis],
            },
        }
    }

    /// ∂F_i/∂|u_tk| in 1/m after a path, as in [`Self::evaluate`]; one-sided at kinks.
    #[must_use]
    pub fn derivative(&self, path: [f64; 3], position: [f64; 3], slip: [f64; 2]) -> [[f64; 2]; 2] {
        match self {
            Self::Isotropic(f) => {
                let derivative = f.derivative(&self.point(path, 0, position, slip));
                let own = slip[0].hypot(slip[1]);
                let direction = slip.map(|s| if s > 0.0 { s / own } else { 0.0 });
                [[0, 1].map(|k| derivative.own * direction[k] + derivative.pair[k]); 2]
            }
            Self::Orthotropic(pair) => [0, 1].map(|axis| {
                let derivative = pair[axis].derivative(&self.point(path, axis, position, slip));
                let mut row = derivative.pair;
                row[axis] += derivative.own;
                row
            }),
        }
    }

    /// The coefficients, one or two.
    #[must_use]
    pub fn coefficients(&self) -> &[Coefficient] {
        match self {
            Self::Isotropic(f) => std::slice::from_ref(f),
            Self::Orthotropic(pair) => pair.as_slice(),
        }
    }

    /// One coefficient or two, in a word.
    #[must_use]
    pub fn shape(&self) -> &'static str {
        match self {
            Self::Isotropic(_) => "isotropic",
            Self::Orthotropic(_) => "orthotropic",
        }
    }

    /// Whether any coefficient depends on the solution.
    #[must_use]
    pub fn depends_on_slip(&self) -> bool {
        self.coefficients().iter().any(Coefficient::depends_on_slip)
    }

    /// Whether any coefficient depends on the place.
    #[must_use]
    pub fn depends_on_place(&self) -> bool {
        self.coefficients()
            .iter()
            .any(Coefficient::depends_on_place)
    }
}

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
