//! Functions of place and time: Rust functions, tables, and formulas of the scene.

use std::{borrow::Cow, fmt, sync::Arc};

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize, Serializer};

use super::{
    Expression, ExpressionError, LEAST_COEFFICIENT, LawPoint, Measure, SlipDerivative,
    expression::{FormulaBranch, OnBranch},
    schema::FORMULA,
};

/// What stands for a function in messages.
pub(super) const WORDS: &str = "a Rust function";

/// A function that several scenes may have; equal to itself alone, and to be found in no text.
struct Shared<F: ?Sized>(Arc<F>);

/// A function of the place in m, the same value for the same place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlaceFunction(Shared<dyn Fn([f64; 3]) -> f64 + Send + Sync>);

/// F and its derivatives at a point.
type Law = dyn Fn(&LawPoint) -> (f64, SlipDerivative) + Send + Sync;

/// A coefficient of friction with its derivatives as a function of place and slips, the same values for the same
/// point; slips in m, derivatives in 1/m.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub struct LawFunction {
    function: Shared<Law>,
    #[serde(skip)]
    of_own_slip_only: bool,
}

impl PlaceFunction {
    /// A function of (x, y, z).
    pub fn new(function: impl Fn([f64; 3]) -> f64 + Send + Sync + 'static) -> Self {
        Self(Shared(Arc::new(function)))
    }

    /// The value at a point.
    #[must_use]
    pub fn at(&self, point: [f64; 3]) -> f64 {
        (self.0.0)(point)
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
            function: Shared(Arc::new(of_point)),
            of_own_slip_only: true,
        }
    }

    /// A function of the place, the own slip and both slips.
    pub fn of_point(
        function: impl Fn(&LawPoint) -> (f64, SlipDerivative) + Send + Sync + 'static,
    ) -> Self {
        Self {
            function: Shared(Arc::new(function)),
            of_own_slip_only: false,
        }
    }

    /// Value and derivatives at a point.
    #[must_use]
    pub fn at(&self, point: &LawPoint) -> (f64, SlipDerivative) {
        (self.function.0)(point)
    }

    /// Whether it is a function of the own slip alone.
    #[must_use]
    pub(crate) fn is_of_own_slip_only(&self) -> bool {
        self.of_own_slip_only
    }

    /// The function as another description of the problem sees it: `old` gives the point of this one, `new` takes the
    /// derivatives back.
    #[must_use]
    pub(super) fn seen_from(
        &self,
        old: impl Fn(&LawPoint) -> LawPoint + Send + Sync + 'static,
        new: impl Fn(SlipDerivative) -> SlipDerivative + Send + Sync + 'static,
    ) -> Self {
        let inner = self.clone();
        Self {
            function: Shared(Arc::new(move |at| {
                let (value, derivative) = inner.at(&old(at));
                (value, new(derivative))
            })),
            of_own_slip_only: self.of_own_slip_only,
        }
    }
}

impl<F: ?Sized> Clone for Shared<F> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

impl<F: ?Sized> PartialEq for Shared<F> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl<F: ?Sized> fmt::Debug for Shared<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(WORDS)
    }
}

/// Scenes are compared by their values, so a function has one of its own; [`Scene::to_toml`](super::Scene::to_toml) refuses it.
impl<F: ?Sized> Serialize for Shared<F> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&format_args!("{WORDS} at {:p}", Arc::as_ptr(&self.0)))
    }
}

/// Values over increasing slips.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Slips in m, increasing from 0 on.
    #[schemars(extend("measures" = Measure::Displacement, "minimum" = 0))]
    pub slip: Vec<f64>,
    /// Coefficient > 0 at each slip.
    #[schemars(extend("minimum" = LEAST_COEFFICIENT))]
    pub value: Vec<f64>,
}

/// Values over a grid of both slips.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Slips |u_t1| in m, increasing from 0 on.
    #[schemars(extend("measures" = Measure::Displacement, "minimum" = 0))]
    pub slip_1: Vec<f64>,
    /// Slips |u_t2| in m, increasing from 0 on.
    #[schemars(extend("measures" = Measure::Displacement, "minimum" = 0))]
    pub slip_2: Vec<f64>,
    /// Coefficients > 0: one row for each entry of `slip_1`, one column for each of `slip_2`.
    #[schemars(extend("minimum" = LEAST_COEFFICIENT))]
    pub value: Vec<Vec<f64>>,
}

impl Table {
    /// Value and slope, taken from the left at a knot.
    pub(super) fn evaluate(&self, slip: f64) -> (f64, f64) {
        interpolate(&self.slip, &self.value, slip)
    }
}

/// The cell of a table that holds ζ, taken from the left, and the relative place in it; `None`
/// outside the table, with the index of the nearest entry.
fn cell(knots: &[f64], slip: f64) -> Result<(usize, f64), usize> {
    let above = knots.partition_point(|&knot| knot < slip);
    if above == 0 {
        Err(0)
    } else if above == knots.len() {
        Err(above - 1)
    } else {
        let (low, high) = (knots[above - 1], knots[above]);
        Ok((above - 1, (slip - low) / (high - low)))
    }
}

/// Value and slope of the piecewise linear function through (knots, values).
fn interpolate(knots: &[f64], values: &[f64], slip: f64) -> (f64, f64) {
    match cell(knots, slip) {
        Err(end) => (values[end], 0.0),
        Ok((i, t)) => {
            let rise = values[i + 1] - values[i];
            (values[i] + t * rise, rise / (knots[i + 1] - knots[i]))
        }
    }
}

impl Grid {
    /// Value and gradient.
    pub(super) fn evaluate(&self, slip: [f64; 2]) -> (f64, [f64; 2]) {
        let along_second = |row: usize| interpolate(&self.slip_2, &self.value[row], slip[1]);
        match cell(&self.slip_1, slip[0]) {
            Err(end) => {
                let (value, slope) = along_second(end);
                (value, [0.0, slope])
            }
            Ok((i, t)) => {
                let (low, high) = (along_second(i), along_second(i + 1));
                let width = self.slip_1[i + 1] - self.slip_1[i];
                (
                    low.0 + t * (high.0 - low.0),
                    [(high.0 - low.0) / width, low.1 + t * (high.1 - low.1)],
                )
            }
        }
    }
}

/// The variables of a [`Formula`]: coordinates and slips in m. `s` is |u_t|, for isotropic laws;
/// `s1`, `s2` are |u_t1|, |u_t2|.
pub const LAW_VARIABLES: &[&str] = &["x", "y", "z", "s", "s1", "s2"];

/// An expression in [`LAW_VARIABLES`], with derivatives by the slips.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String")]
pub struct Formula(Expression);

/// The places of s, s1 and s2 in [`LAW_VARIABLES`].
const SLIPS: [usize; 3] = [3, 4, 5];

impl Formula {
    /// Parses a formula without parameters.
    ///
    /// # Errors
    /// [`ExpressionError`] for text that is no formula in [`LAW_VARIABLES`].
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        Expression::parse(text, LAW_VARIABLES).map(Self)
    }

    /// As [`Expression::substitute`].
    #[must_use]
    pub fn substitute(&self, new: &[(&str, Expression)]) -> Self {
        Self(self.0.substitute(new))
    }

    pub(super) fn evaluate(&self, at: &LawPoint) -> f64 {
        self.0.evaluate(&arguments(at))
    }

    pub(super) fn derivative(&self, at: &LawPoint) -> SlipDerivative {
        let [own, first, second] = self.0.derivatives(&arguments(at), SLIPS);
        SlipDerivative {
            own,
            pair: [first, second],
        }
    }

    /// The branch that the formula takes at a point.
    #[must_use]
    pub fn branch(&self, at: &LawPoint) -> FormulaBranch {
        self.0.branch(&arguments(at), SLIPS)
    }

    /// The formula on a branch; slopes are by the own slip, by |u_t1| and by |u_t2|.
    #[must_use]
    pub fn on_branch(&self, at: &LawPoint, branch: FormulaBranch) -> OnBranch {
        self.0.on_branch(&arguments(at), SLIPS, branch)
    }

    pub(super) fn depends_on_slip(&self) -> bool {
        SLIPS.iter().any(|&k| self.0.uses(LAW_VARIABLES[k]))
    }

    /// The formula as written.
    #[must_use]
    pub fn expression(&self) -> &Expression {
        &self.0
    }

    pub(super) fn expression_mut(&mut self) -> &mut Expression {
        &mut self.0
    }
}

impl TryFrom<String> for Formula {
    type Error = ExpressionError;

    fn try_from(text: String) -> Result<Self, ExpressionError> {
        Expression::unbound(&text, LAW_VARIABLES).map(Self)
    }
}

impl JsonSchema for Formula {
    fn schema_name() -> Cow<'static, str> {
        "Formula".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "An expression in x, y, z, the slips s1 = |u_t1|, s2 = |u_t2| (s = |u_t| for an isotropic law), all in m, and the scene's parameters.",
            "type": "string",
            "format": FORMULA
        })
    }
}

/// The values of [`LAW_VARIABLES`].
fn arguments(at: &LawPoint) -> [f64; 6] {
    let [x, y, z] = at.position;
    [x, y, z, at.own_slip, at.slip[0], at.slip[1]]
}
