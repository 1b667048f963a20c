//! A range of a parameter of a scene.

use serde::{Deserialize, Serialize};

/// A range of one sign whose ends differ by more than this factor is followed in the logarithm of the parameter.
const LOGARITHMIC_FROM: f64 = 100.0;

/// A range of a parameter of a scene.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ParameterRange {
    /// The key, for messages.
    pub key: String,
    /// The value at s = 0.
    pub from: f64,
    /// The value at s = 1.
    pub to: f64,
}

impl ParameterRange {
    /// Whether s is the share of the logarithm, and not of the value.
    #[must_use]
    pub fn is_logarithmic(&self) -> bool {
        let ratio = self.to / self.from;
        ratio > 0.0
            && ratio.is_finite()
            && !(LOGARITHMIC_FROM.recip()..=LOGARITHMIC_FROM).contains(&ratio)
    }

    /// The parameter at s.
    #[must_use]
    pub fn value(&self, s: f64) -> f64 {
        if s == 0.0 {
            self.from
        } else if s == 1.0 {
            self.to
        } else if self.is_logarithmic() {
            self.from * (self.to / self.from).powf(s)
        } else {
            self.from + s * (self.to - self.from)
        }
    }

    /// The share of the way from `from` to `to` of the value at s.
    pub(super) fn share(&self, s: f64) -> f64 {
        if self.is_logarithmic() {
            (self.value(s) - self.from) / (self.to - self.from)
        } else {
            s
        }
    }
}
