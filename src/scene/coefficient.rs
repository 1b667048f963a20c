use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use super::{Expression, ExpressionError};

/// One coefficient of friction as a function of place and slip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Coefficient {
    /// The same value everywhere and for every slip.
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
    /// Value at small slip.
    pub initial: f64,
    /// Value at large slip.
    pub residual: f64,
    /// Slip at which the change begins, in m.
    pub onset: f64,
    /// Steepness |dF/dζ| of the change, in 1/m.
    pub rate: f64,
}

/// Values over increasing slips.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Slips in m, increasing from 0 on.
    pub slip: Vec<f64>,
    /// Coefficient at each slip.
    pub value: Vec<f64>,
}

/// Values over a grid of both slips.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Slips |u_t1| in m, increasing from 0 on.
    pub slip_1: Vec<f64>,
    /// Slips |u_t2| in m, increasing from 0 on.
    pub slip_2: Vec<f64>,
    /// Coefficients: one row for each entry of `slip_1`, one column for each of `slip_2`.
    pub value: Vec<Vec<f64>>,
}

/// The variables of a [`Formula`]: coordinates and slips in m. `s` is |u_t|, for isotropic laws;
/// `s1`, `s2` are |u_t1|, |u_t2|.
pub const LAW_VARIABLES: &[&str] = &["x", "y", "z", "s", "s1", "s2"];

/// An expression in [`LAW_VARIABLES`] with its derivatives by the slips.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Formula {
    value: Expression,
    /// By s, s1 and s2.
    derivatives: [Option<Expression>; 3],
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
    /// F at a point.
    #[must_use]
    pub fn evaluate(&self, at: &LawPoint) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Ramp(ramp) => ramp.evaluate(at.own_slip),
            Self::Table(table) => interpolate(&table.slip, &table.value, at.own_slip).0,
            Self::Grid(grid) => grid.evaluate(at.slip).0,
            Self::Expression(formula) => formula.value.evaluate(&formula_arguments(at)),
        }
    }

    /// The derivatives of F by the slips, one-sided (from the left) at kinks.
    #[must_use]
    pub fn derivative(&self, at: &LawPoint) -> SlipDerivative {
        let own = |own| SlipDerivative {
            own,
            ..SlipDerivative::default()
        };
        match self {
            Self::Constant(_) => SlipDerivative::default(),
            Self::Ramp(ramp) => own(ramp.derivative(at.own_slip)),
            Self::Table(table) => own(interpolate(&table.slip, &table.value, at.own_slip).1),
            Self::Grid(grid) => SlipDerivative {
                own: 0.0,
                pair: grid.evaluate(at.slip).1,
            },
            Self::Expression(formula) => {
                let arguments = formula_arguments(at);
                let [own, first, second] = formula
                    .derivatives
                    .each_ref()
                    .map(|d| d.as_ref().map_or(0.0, |d| d.evaluate(&arguments)));
                SlipDerivative {
                    own,
                    pair: [first, second],
                }
            }
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
            Self::Expression(formula) => formula.derivatives.iter().any(Option::is_some),
        }
    }

    /// Whether F depends on the place.
    #[must_use]
    pub fn depends_on_place(&self) -> bool {
        match self {
            Self::Expression(formula) => ["x", "y", "z"].iter().any(|v| formula.value.uses(v)),
            _ => false,
        }
    }
}

fn formula_arguments(at: &LawPoint) -> [f64; 6] {
    let [x, y, z] = at.position;
    [x, y, z, at.own_slip, at.slip[0], at.slip[1]]
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

impl Formula {
    /// Parses and differentiates.
    ///
    /// # Errors
    /// [`ExpressionError`] for text that is no formula in [`LAW_VARIABLES`].
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        let value = Expression::parse(text, LAW_VARIABLES)?;
        let [own, first, second] = ["s", "s1", "s2"].map(|name| value.derivative(name));
        Ok(Self {
            derivatives: [own?, first?, second?],
            value,
        })
    }

    /// The formula as written.
    #[must_use]
    pub fn expression(&self) -> &Expression {
        &self.value
    }
}

impl TryFrom<String> for Formula {
    type Error = ExpressionError;

    fn try_from(text: String) -> Result<Self, ExpressionError> {
        Self::parse(&text)
    }
}

impl From<Formula> for String {
    fn from(formula: Formula) -> Self {
        formula.value.text().to_owned()
    }
}

impl JsonSchema for Formula {
    fn schema_name() -> Cow<'static, str> {
        "Formula".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "An expression in x, y, z and the slips s1 = |u_t1|, s2 = |u_t2| (s = |u_t| for an isotropic law), all in m.",
            "type": "string"
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(s1: f64, s2: f64) -> LawPoint {
        LawPoint {
            position: [0.5, 0.0, 0.0],
            slip: [s1, s2],
            own_slip: s1,
        }
    }

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

    #[test]
    fn a_table_of_the_ramps_corners_is_the_ramp() {
        let ramp = Coefficient::Ramp(Ramp {
            initial: 0.3,
            residual: 0.2,
            onset: 1.0,
            rate: 0.05,
        });
        let table = Coefficient::Table(Table {
            slip: vec![0.0, 1.0, 3.0],
            value: vec![0.3, 0.3, 0.2],
        });
        for slip in [0.0, 0.5, 1.0, 1.7, 2.9, 10.0] {
            let point = at(slip, 0.0);
            // A few roundings of numbers near 0.3.
            assert!((ramp.evaluate(&point) - table.evaluate(&point)).abs() < 1e-15);
            assert!((ramp.derivative(&point).own - table.derivative(&point).own).abs() < 1e-15);
        }
    }

    proptest! {
        #[test]
        fn derivatives_equal_differences(s1 in 0.05..2.95_f64, s2 in 0.05..1.95_f64) {
            let grid = Coefficient::Grid(Grid {
                slip_1: vec![0.0, 1.0, 3.0],
                slip_2: vec![0.0, 2.0],
                value: vec![vec![0.3, 0.5], vec![0.2, 0.1], vec![0.4, 0.6]],
            });
            let formula = Coefficient::Expression(
                Formula::parse("0.3 + 0.1*tanh(s1) - 0.05*s2*x + exp(-s)").unwrap(),
            );
            prop_assume!((s1 - 1.0).abs() > 1e-3);
            let step = 1e-6;
            for law in [grid, formula] {
                let derivative = law.derivative(&at(s1, s2));
                let first = (law.evaluate(&at(s1 + step, s2)) - law.evaluate(&at(s1 - step, s2))) / (2.0 * step);
                let second = (law.evaluate(&at(s1, s2 + step)) - law.evaluate(&at(s1, s2 - step))) / (2.0 * step);
                // Truncation 1e-12, cancellation of numbers near 1 over 2e-6.
                prop_assert!((derivative.pair[0] + derivative.own - first).abs() < 1e-9);
                prop_assert!((derivative.pair[1] - second).abs() < 1e-9);
            }
        }
    }
}
