//! Coefficients of friction as other descriptions of a problem see them.

use super::{Scaling, Symmetry, scaling::unscalable};
use crate::scene::{
    Coefficient, Formula, Grid, Invalid, LawPoint, Ramp, SlipDerivative, Table, replace_names,
};

impl Scaling {
    /// A coefficient in other units.
    pub(super) fn coefficient(&self, coefficient: &Coefficient) -> Result<Coefficient, Invalid> {
        let (length, d) = (self.length, self.displacement);
        let slips = |slips: &[f64]| slips.iter().map(|s| s * d).collect();
        Ok(match coefficient {
            Coefficient::Constant(value) => Coefficient::Constant(*value),
            Coefficient::Ramp(ramp) => Coefficient::Ramp(Ramp {
                onset: ramp.onset * d,
                rate: ramp.rate / d,
                ..*ramp
            }),
            Coefficient::Table(table) => Coefficient::Table(Table {
                slip: slips(&table.slip),
                value: table.value.clone(),
            }),
            Coefficient::Grid(grid) => Coefficient::Grid(Grid {
                slip_1: slips(&grid.slip_1),
                slip_2: slips(&grid.slip_2),
                value: grid.value.clone(),
            }),
            Coefficient::Expression(formula) => {
                let mut old = self.places();
                old.extend(["s", "s1", "s2"].map(|name| (name, format!("{name}*{:e}", 1.0 / d))));
                Coefficient::Expression(rewritten(formula, &old)?)
            }
            Coefficient::Function(function) => Coefficient::Function(function.seen_from(
                move |at| LawPoint {
                    position: at.position.map(|x| x / length),
                    slip: at.slip.map(|s| s / d),
                    own_slip: at.own_slip / d,
                },
                move |derivative| SlipDerivative {
                    own: derivative.own / d,
                    pair: derivative.pair.map(|slope| slope / d),
                },
            )),
        })
    }
}

impl Symmetry {
    /// A coefficient in the image of a brick of this width.
    pub(super) fn coefficient(
        self,
        coefficient: &Coefficient,
        width: f64,
    ) -> Result<Coefficient, Invalid> {
        Ok(match coefficient {
            Coefficient::Constant(_) | Coefficient::Ramp(_) | Coefficient::Table(_) => {
                coefficient.clone()
            }
            Coefficient::Grid(grid) => Coefficient::Grid(match self {
                Self::Mirror => grid.clone(),
                Self::Exchange => Grid {
                    slip_1: grid.slip_2.clone(),
                    slip_2: grid.slip_1.clone(),
                    value: (0..grid.slip_2.len())
                        .map(|j| grid.value.iter().map(|row| row[j]).collect())
                        .collect(),
                },
            }),
            Coefficient::Expression(formula) => {
                let mut old = self.places(width);
                if self == Self::Exchange {
                    old.extend([("s1", "s2".to_owned()), ("s2", "s1".to_owned())]);
                }
                Coefficient::Expression(rewritten(formula, &old)?)
            }
            Coefficient::Function(function) => Coefficient::Function(function.seen_from(
                move |at| LawPoint {
                    position: self.point(at.position, width),
                    slip: self.slips(at.slip),
                    own_slip: at.own_slip,
                },
                move |derivative| SlipDerivative {
                    own: derivative.own,
                    pair: self.slips(derivative.pair),
                },
            )),
        })
    }

    /// What belongs to t₁ and t₂, without signs.
    fn slips(self, [first, second]: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Mirror => [first, second],
            Self::Exchange => [second, first],
        }
    }
}

/// A formula with other text in the place of its variables.
fn rewritten(formula: &Formula, old: &[(&'static str, String)]) -> Result<Formula, Invalid> {
    let text = replace_names(formula.expression().text(), old);
    formula.rewritten(&text).map_err(|e| unscalable(&text, &e))
}
