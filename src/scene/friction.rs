use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Orthotropic Coulomb friction, F = diag(F₁, F₂) in the frame (t₁, t₂).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// F₁, which may depend on |u_t1|.
    pub coefficient_1: Coefficient,
    /// F₂, which may depend on |u_t2|.
    pub coefficient_2: Coefficient,
}

/// One coefficient of friction as a function of the slip ζ ≥ 0 along its own axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Coefficient {
    /// The same value everywhere and for every slip.
    Constant(f64),
    /// A linear change between two constant values (HKL §4).
    Ramp(Ramp),
}

/// F(ζ) = `initial` for ζ ≤ `onset`, then a straight line to `residual`, constant afterwards.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ramp {
    /// Value at small slip.
    pub initial: f64,
    /// Value at large slip.
    pub residual: f64,
    /// Slip at which the change begins, in m.
    pub onset: f64,
    /// Steepness |dF/dζ| of the change, in 1/m.
    pub rate: f64,
}

impl Friction {
    /// (F₁, F₂) at the slips (|u_t1|, |u_t2|) in m.
    #[must_use]
    pub fn evaluate(&self, slip: [f64; 2]) -> [f64; 2] {
        [
            self.coefficient_1.evaluate(slip[0]),
            self.coefficient_2.evaluate(slip[1]),
        ]
    }

    /// (∂F₁/∂ζ₁, ∂F₂/∂ζ₂) in 1/m, one-sided (from the left) at the kinks of a ramp.
    #[must_use]
    pub fn derivative(&self, slip: [f64; 2]) -> [f64; 2] {
        [
            self.coefficient_1.derivative(slip[0]),
            self.coefficient_2.derivative(slip[1]),
        ]
    }

    /// Whether any coefficient depends on the solution.
    #[must_use]
    pub fn depends_on_slip(&self) -> bool {
        [self.coefficient_1, self.coefficient_2]
            .iter()
            .any(|c| matches!(c, Coefficient::Ramp(r) if r.initial != r.residual))
    }
}

impl Coefficient {
    /// F(ζ).
    #[must_use]
    pub fn evaluate(&self, slip: f64) -> f64 {
        match *self {
            Self::Constant(value) => value,
            Self::Ramp(ramp) => ramp.evaluate(slip),
        }
    }

    /// dF/dζ in 1/m.
    #[must_use]
    pub fn derivative(&self, slip: f64) -> f64 {
        match *self {
            Self::Constant(_) => 0.0,
            Self::Ramp(ramp) => ramp.derivative(slip),
        }
    }
}

impl Ramp {
    /// Slip at which the residual value is reached, in m.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.onset + (self.initial - self.residual).abs() / self.rate
    }

    fn evaluate(&self, slip: f64) -> f64 {
        if slip <= self.onset {
            self.initial
        } else if slip >= self.end() {
            self.residual
        } else {
            self.initial + self.derivative(slip) * (slip - self.onset)
        }
    }

    fn derivative(&self, slip: f64) -> f64 {
        if slip <= self.onset || slip > self.end() || self.initial == self.residual {
            0.0
        } else {
            self.rate.copysign(self.residual - self.initial)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramp_of_the_paper() {
        // HKL §4 with par = 6e4: rate 0.05·par, end 1e-5 + 2/par.
        let ramp = Ramp {
            initial: 0.3,
            residual: 0.2,
            onset: 1e-5,
            rate: 3000.0,
        };
        assert_eq!(ramp.evaluate(0.0), 0.3);
        assert_eq!(ramp.evaluate(1e-5), 0.3);
        assert_eq!(ramp.evaluate(1.0), 0.2);
        // The midpoint of a straight line; a few roundings of numbers near 0.3.
        assert!((ramp.evaluate(1e-5 + 1.0 / 6e4) - 0.25).abs() < 1e-15);
        assert!((ramp.end() - (1e-5 + 2.0 / 6e4)).abs() < 1e-19);
        assert_eq!(ramp.derivative(2e-5), -3000.0);
    }

    #[test]
    fn hardening_ramp_rises() {
        let ramp = Ramp {
            initial: 0.1,
            residual: 2.0,
            onset: 0.0,
            rate: 1e4,
        };
        assert!(ramp.evaluate(1e-4) > 1.0 && ramp.derivative(1e-4) == 1e4);
        assert_eq!(ramp.evaluate(1e-3), 2.0);
    }
}
