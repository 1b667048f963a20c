//! One coefficient of friction as a function of place and slip.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use super::{
    Expression, ExpressionError, Measure,
    expression::{FormulaBranch, OnBranch},
    schema::FORMULA,
};

/// Smallest coefficient: means of its inverse over panes, and their products with stresses, stay far from overflow.
pub(crate) const LEAST_COEFFICIENT: f64 = 1e-100;

/// Whether a number can be a coefficient of friction.
pub(crate) fn is_coefficient(value: f64) -> bool {
    value >= LEAST_COEFFICIENT && value.is_finite()
}

/// One coefficient of friction as a function of place and slip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(extend("examples" = ["friction.coefficient.constant = 0.3"]))]
pub enum Coefficient {
    /// The same value > 0 everywhere and for every slip; for frictionless contact leave the table friction out.
    #[schemars(extend("minimum" = LEAST_COEFFICIENT))]
    Constant(f64),
    /// A linear change with the own slip between two constant values (HKL §4).
    Ramp(Ramp),
    /// Straight lines between given values over the own slip, constant beyond the last.
    Table(Table),
    /// Bilinear interpolation of given values over both slips, constant beyond the last.
    Grid(Grid),
    /// A formula in x, y, z and the slips.
    Expression(Formula),
}

/// F(ζ) = `initial` for ζ ≤ `onset`, then a straight line to `residual`, constant afterwards.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ramp {
    /// Value at small slip, > 0.
    #[schemars(extend("minimum" = LEAST_COEFFICIENT))]
    pub initial: f64,
    /// Value at large slip, > 0.
    #[schemars(extend("minimum" = LEAST_COEFFICIENT))]
    pub residual: f64,
    /// Slip ≥ 0 at which the change begins, in m.
    #[schemars(extend("measures" = Measure::Displacement, "minimum" = 0))]
    pub onset: f64,
    /// Steepness |dF/dζ| > 0 of the change, in 1/m; whether F falls or rises follows from initial and residual.
    #[schemars(extend("measures" = Measure::PerDisplacement, "exclusiveMinimum" = 0))]
    pub rate: f64,
}

/// What a coefficient depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawPoint {
    /// Place in m.
    pub position: [f64; 3],
    /// (|u_t1|, |u_t2|) in m.
    pub slip: [f64; 2],
    /// The slip that [`Coefficient::Ramp`] and [`Coefficient::Table`] see: the one along the
    /// coefficient's axis, or |u_t| for an isotropic law.
    pub own_slip: f64,
}

/// Partial derivatives of a coefficient in 1/m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SlipDerivative {
    /// By `own_slip`.
    pub own: f64,
    /// By (|u_t1|, |u_t2|).
    pub pair: [f64; 2],
}

impl Coefficient {
    /// The key of its kind in a scene.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Constant(_) => "constant",
            Self::Ramp(_) => "ramp",
            Self::Table(_) => "table",
            Self::Grid(_) => "grid",
            Self::Expression(_) => "expression",
        }
    }

    /// F at a point.
    #[must_use]
    pub fn evaluate(&self, at: &LawPoint) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Ramp(ramp) => ramp.evaluate(at.own_slip),
            Self::Table(table) => table.evaluate(at.own_slip).0,
            Self::Grid(grid) => grid.evaluate(at.slip).0,
            Self::Expression(formula) => formula.evaluate(at),
        }
    }

    /// The derivatives of F by the slips, one-sided at kinks: from the left for ramps, tables and
    /// grids, from the right for formulas.
    #[must_use]
    pub fn derivative(&self, at: &LawPoint) -> SlipDerivative {
        let own = |own| SlipDerivative {
            own,
            ..SlipDerivative::default()
        };
        match self {
            Self::Constant(_) => SlipDerivative::default(),
            Self::Ramp(ramp) => own(ramp.derivative(at.own_slip)),
            Self::Table(table) => own(table.evaluate(at.own_slip).1),
            Self::Grid(grid) => SlipDerivative {
                own: 0.0,
                pair: grid.evaluate(at.slip).1,
            },
            Self::Expression(formula) => formula.derivative(at),
        }
    }

    /// Whether F depends on the slip.
    #[must_use]
    pub fn depends_on_slip(&self) -> bool {
        let differ = |values: &[f64]| values.iter().any(|v| *v != values[0]);
        match self {
            Self::Constant(_) => false,
            Self::Ramp(ramp) => ramp.initial != ramp.residual,
            Self::Table(table) => differ(&table.value),
            Self::Grid(grid) => differ(&grid.value.concat()),
            Self::Expression(formula) => formula.depends_on_slip(),
        }
    }

    /// Whether F depends on the place.
    #[must_use]
    pub fn depends_on_place(&self) -> bool {
        match self {
            Self::Expression(formula) => {
                ["x", "y", "z"].iter().any(|v| formula.expression().uses(v))
            }
            Self::Constant(_) | Self::Ramp(_) | Self::Table(_) | Self::Grid(_) => false,
        }
    }

    /// Which of |u_t1|, |u_t2| the coefficient is a function of; `axis` is that of its own slip.
    #[must_use]
    pub fn slips_used(&self, axis: usize) -> [bool; 2] {
        let own = [axis == 0, axis == 1];
        match self {
            Self::Constant(_) => [false; 2],
            Self::Ramp(_) | Self::Table(_) => own,
            Self::Grid(_) => [true; 2],
            Self::Expression(formula) => {
                let uses = |name| formula.expression().uses(name);
                [0, 1].map(|k| uses(["s1", "s2"][k]) || own[k] && uses("s"))
            }
        }
    }

    /// The slips |u_t1| and |u_t2| in m at which straight pieces of the coefficient meet; none for
    /// constants and formulas.
    #[must_use]
    pub fn kinks(&self, axis: usize) -> [Vec<f64>; 2] {
        let mut kinks = [Vec::new(), Vec::new()];
        match self {
            Self::Constant(_) | Self::Expression(_) => {}
            Self::Ramp(ramp) => kinks[axis] = vec![ramp.onset, ramp.end()],
            Self::Table(table) => kinks[axis].clone_from(&table.slip),
            Self::Grid(grid) => kinks = [grid.slip_1.clone(), grid.slip_2.clone()],
        }
        kinks
    }

    /// Whether the extremes of the coefficient can only be searched for.
    #[must_use]
    pub(crate) fn is_searched(&self) -> bool {
        matches!(self, Self::Expression(_))
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
    fn evaluate(&self, slip: f64) -> (f64, f64) {
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
    fn evaluate(&self, slip: [f64; 2]) -> (f64, [f64; 2]) {
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
pub struct Formula(pub(super) Expression);

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

    fn evaluate(&self, at: &LawPoint) -> f64 {
        self.0.evaluate(&arguments(at))
    }

    fn derivative(&self, at: &LawPoint) -> SlipDerivative {
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

    fn depends_on_slip(&self) -> bool {
        SLIPS.iter().any(|&k| self.0.uses(LAW_VARIABLES[k]))
    }

    /// The formula as written.
    #[must_use]
    pub fn expression(&self) -> &Expression {
        &self.0
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
