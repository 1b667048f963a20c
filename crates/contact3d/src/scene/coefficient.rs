//! One coefficient of friction as a function of place and slip.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    Formula, LawFunction, Measure,
    function::{Grid, Table},
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
    /// A Rust function of place and slips, in scenes built in Rust.
    #[serde(skip_deserializing)]
    #[schemars(skip)]
    Function(LawFunction),
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
    /// The key of its kind in a scene; a Rust function has none in files.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Constant(_) => "constant",
            Self::Ramp(_) => "ramp",
            Self::Table(_) => "table",
            Self::Grid(_) => "grid",
            Self::Expression(_) => "expression",
            Self::Function(_) => "function",
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
            Self::Function(function) => function.at(at).0,
        }
    }

    /// The derivatives of F by the slips, one-sided at kinks: from the left for ramps, tables and
    /// grids, from the right for formulas; those of a Rust function as it gives them.
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
            Self::Function(function) => function.at(at).1,
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
            Self::Function(_) => true,
        }
    }

    /// Whether F depends on the place.
    #[must_use]
    pub fn depends_on_place(&self) -> bool {
        match self {
            Self::Expression(formula) => {
                ["x", "y", "z"].iter().any(|v| formula.expression().uses(v))
            }
            Self::Function(function) => !function.is_of_own_slip_only(),
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
            Self::Function(function) if function.is_of_own_slip_only() => own,
            Self::Function(_) => [true; 2],
        }
    }

    /// The slips |u_t1| and |u_t2| in m at which straight pieces of the coefficient meet; none for
    /// constants and formulas and functions.
    #[must_use]
    pub fn kinks(&self, axis: usize) -> [Vec<f64>; 2] {
        let mut kinks = [Vec::new(), Vec::new()];
        match self {
            Self::Constant(_) | Self::Expression(_) | Self::Function(_) => {}
            Self::Ramp(ramp) => kinks[axis] = vec![ramp.onset, ramp.end()],
            Self::Table(table) => kinks[axis].clone_from(&table.slip),
            Self::Grid(grid) => kinks = [grid.slip_1.clone(), grid.slip_2.clone()],
        }
        kinks
    }

    /// Whether the extremes of the coefficient can only be searched for.
    #[must_use]
    pub(crate) fn is_searched(&self) -> bool {
        match self {
            Self::Expression(_) | Self::Function(_) => true,
            Self::Constant(_) | Self::Ramp(_) | Self::Table(_) | Self::Grid(_) => false,
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
