//! Laws of friction and what they are made of, built in Rust.

use super::super::{
    Coefficient, Expression, ExpressionError, Formula, Friction, LawFunction, LawPoint, POSITION,
    PlaceFunction, Quantity, Ramp, SlipDerivative, Table,
};

impl Friction {
    /// Coulomb's law with one coefficient.
    #[must_use]
    pub fn coulomb(coefficient: impl Into<Coefficient>) -> Self {
        Self {
            coefficient: Some(coefficient.into()),
            ..Self::default()
        }
    }

    /// Coulomb's law with coefficients along t₁ and t₂.
    #[must_use]
    pub fn orthotropic(first: impl Into<Coefficient>, second: impl Into<Coefficient>) -> Self {
        Self {
            coefficient_1: Some(first.into()),
            coefficient_2: Some(second.into()),
            ..Self::default()
        }
    }

    /// Coulomb's law capped at a pressure p_cap > 0 in Pa, ‖F⁻¹σ_t‖ ≤ min(−σ_ν, p_cap).
    #[must_use]
    pub fn capped(self, pressure_cap: f64) -> Self {
        Self {
            pressure_cap: Some(pressure_cap),
            ..self
        }
    }

    /// Tresca's law ‖σ_t‖ ≤ g with a given slip bound g in Pa.
    #[must_use]
    pub fn tresca(slip_bound: impl Into<Quantity>) -> Self {
        Self {
            slip_bound: Some(slip_bound.into()),
            ..Self::default()
        }
    }
}

impl Coefficient {
    /// A straight change from `initial` to `residual` that begins at the slip `onset` in m, with the steepness `rate`
    /// in 1/m.
    #[must_use]
    pub fn ramp(initial: f64, residual: f64, onset: f64, rate: f64) -> Self {
        Self::Ramp(Ramp {
            initial,
            residual,
            onset,
            rate,
        })
    }

    /// Straight lines between pairs of a slip in m and a value.
    #[must_use]
    pub fn table(points: &[(f64, f64)]) -> Self {
        let (slip, value) = points.iter().copied().unzip();
        Self::Table(Table { slip, value })
    }

    /// A formula in the slips, the place and the scene's parameters, differentiated by this crate.
    ///
    /// # Errors
    /// Text that is no formula.
    pub fn formula(text: &str) -> Result<Self, ExpressionError> {
        Formula::try_from(text.to_owned()).map(Self::Expression)
    }

    /// A Rust function that gives F and dF/dζ in 1/m for a slip ζ in m: |u_t| of an isotropic law, that along its axis of
    /// an orthotropic one. Newton's method needs the derivative, one-sided at kinks; a wrong one costs steps or the
    /// status, never the meaning of `Converged`.
    #[must_use]
    pub fn of_slip(function: impl Fn(f64) -> (f64, f64) + Send + Sync + 'static) -> Self {
        Self::Function(LawFunction::of_slip(function))
    }

    /// As [`Self::of_slip`], of the place and both slips.
    #[must_use]
    pub fn of_point(
        function: impl Fn(&LawPoint) -> (f64, SlipDerivative) + Send + Sync + 'static,
    ) -> Self {
        Self::Function(LawFunction::of_point(function))
    }
}

impl From<f64> for Coefficient {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}

impl Quantity {
    /// A formula in x, y, z and the scene's parameters.
    ///
    /// # Errors
    /// Text that is no formula.
    pub fn formula(text: &str) -> Result<Self, ExpressionError> {
        Expression::unbound(text, POSITION).map(Self::Varying)
    }

    /// A Rust function of the place in m.
    #[must_use]
    pub fn function(function: impl Fn([f64; 3]) -> f64 + Send + Sync + 'static) -> Self {
        Self::Function(PlaceFunction::new(function))
    }
}

impl From<f64> for Quantity {
    fn from(value: f64) -> Self {
        Self::Constant(value)
    }
}
