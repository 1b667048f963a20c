//! Rust functions in place of the formulas of a scene; no text holds them.

use std::{fmt, sync::Arc};

use serde::{Serialize, Serializer, ser};

use super::{LawPoint, SlipDerivative};

/// What stands for a function in messages.
const WORDS: &str = "a Rust function";

/// A function of the place in m, the same value for the same place.
#[derive(Clone)]
pub struct PlaceFunction(Arc<dyn Fn([f64; 3]) -> f64 + Send + Sync>);

/// F and its derivatives at a point.
type Law = dyn Fn(&LawPoint) -> (f64, SlipDerivative) + Send + Sync;

/// A coefficient of friction with its derivatives as a function of place and slips, the same values for the same
/// point; slips in m, derivatives in 1/m.
#[derive(Clone)]
pub struct LawFunction {
    function: Arc<Law>,
    of_own_slip_only: bool,
}

impl PlaceFunction {
    /// A function of (x, y, z).
    pub fn new(function: impl Fn([f64; 3]) -> f64 + Send + Sync + 'static) -> Self {
        Self(Arc::new(function))
    }

    /// The value at a point.
    #[must_use]
    pub fn at(&self, point: [f64; 3]) -> f64 {
        (self.0)(point)
    }
}

impl LawFunction {
    /// A function of the own slip: |u_t| of an isotropic law, that along its axis of an orthotropic one.
    pub fn of_slip(function: impl Fn(f64) -> (f64, f64) + Send + Sync + 'static) -> Self {
        let of_point = move |at: &LawPoint| {
            let (value, own) = function(at.own_slip);
            let derivative = SlipDerivative {
                own,
                ..SlipDerivative::default()
            };
            (value, derivative)
        };
        Self {
            function: Arc::new(of_point),
            of_own_slip_only: true,
        }
    }

    /// A function of the place, the own slip and both slips.
    pub fn of_point(
        function: impl Fn(&LawPoint) -> (f64, SlipDerivative) + Send + Sync + 'static,
    ) -> Self {
        Self {
            function: Arc::new(function),
            of_own_slip_only: false,
        }
    }

    /// Value and derivatives at a point.
    #[must_use]
    pub fn at(&self, point: &LawPoint) -> (f64, SlipDerivative) {
        (self.function)(point)
    }

    /// Whether it is a function of the own slip alone.
    #[must_use]
    pub(crate) fn is_of_own_slip_only(&self) -> bool {
        self.of_own_slip_only
    }

    /// The function as another description of the problem sees it: `old` gives the point of this one, `new` takes the
    /// derivatives back.
    #[must_use]
    pub(crate) fn seen_from(
        &self,
        old: impl Fn(&LawPoint) -> LawPoint + Send + Sync + 'static,
        new: impl Fn(SlipDerivative) -> SlipDerivative + Send + Sync + 'static,
    ) -> Self {
        let inner = self.clone();
        Self {
            function: Arc::new(move |at| {
                let (value, derivative) = inner.at(&old(at));
                (value, new(derivative))
            }),
            of_own_slip_only: self.of_own_slip_only,
        }
    }
}

impl PartialEq for PlaceFunction {
    /// Whether both are one function; equal values are not looked for.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl PartialEq for LawFunction {
    /// Whether both are one function; equal values are not looked for.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.function, &other.function)
    }
}

impl fmt::Debug for PlaceFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(WORDS)
    }
}

impl fmt::Debug for LawFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(WORDS)
    }
}

impl Serialize for PlaceFunction {
    fn serialize<S: Serializer>(&self, _: S) -> Result<S::Ok, S::Error> {
        Err(ser::Error::custom(WORDS))
    }
}

impl Serialize for LawFunction {
    fn serialize<S: Serializer>(&self, _: S) -> Result<S::Ok, S::Error> {
        Err(ser::Error::custom(WORDS))
    }
}
