//! The derivative of the equations of a smooth piece by λ and by the parameter.

use super::{
    equations::{Equations, Evaluated},
    member::Member,
    piece::Piece,
};
use crate::{post::Zone, problem::ProblemError};

/// Half the way in s over which derivatives by the parameter are differences. Loads that are straight in the parameter have none
/// but rounding; elsewhere the error, 1e-8 times third derivatives, slows Newton's method and turns tangents a
/// little, and moves no point.
const DIFFERENCE: f64 = 1e-4;

/// Whether slip bounds and coefficients move with λ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Friction {
    Followed,
    Frozen,
}

impl Equations<'_> {
    /// ∂R/∂(y, s), column-major, `[n, n + 1]`.
    pub(super) fn derivative(
        &self,
        member: &Member,
        piece: &Piece,
        point: &[f64],
        at: &Evaluated,
    ) -> Result<Option<Vec<f64>>, ProblemError> {
        let n = point.len() - 1;
        let mut matrix = vec![0.0; n * (n + 1)];
        let (by_multiplier, by_parameter) = matrix.split_at_mut(n * n);
        for (j, column) in by_multiplier.chunks_exact_mut(n).enumerate() {
            self.column(member, piece, at, j, Friction::Followed, column);
        }
        let Some(change) = self.parameter_change(piece, point)? else {
            return Ok(None);
        };
        by_parameter.copy_from_slice(&change);
        let finite = matrix.iter().all(|v| v.is_finite());
        Ok(finite.then_some(matrix))
    }

    /// ∂R/∂s by a difference within the range.
    fn parameter_change(
        &self,
        piece: &Piece,
        point: &[f64],
    ) -> Result<Option<Vec<f64>>, ProblemError> {
        let (s, y) = point.split_last().expect("a point has a parameter");
        let ends = [(s - DIFFERENCE).max(0.0), (s + DIFFERENCE).min(1.0)];
        if ends[1] <= ends[0] {
            return Ok(None);
        }
        let mut sides = Vec::new();
        for end in ends {
            let member = self.family.member(end)?;
            let Some(side) = self.evaluate(&member, piece, y) else {
                return Ok(None);
            };
            sides.push(side.residual);
        }
        let change = sides[1].iter().zip(&sides[0]);
        Ok(Some(
            change.map(|(b, a)| (b - a) / (ends[1] - ends[0])).collect(),
        ))
    }

    /// ∂R/∂y_j; with frozen friction as the minimisations of Ψ have it.
    pub(super) fn column(
        &self,
        member: &Member,
        piece: &Piece,
        at: &Evaluated,
        j: usize,
        friction: Friction,
        out: &mut [f64],
    ) {
        let s = member.dual.column(j);
        let rho = member.steplengths();
        let layout = member.dual.layout;
        let surface = member.surface();
        let compliance = member.dual.compliance.as_ref().map(|c| c.column(j));
        let unit = |i: usize| if i == j { 1.0 } else { 0.0 };
        let stuck = |i: usize| {
            if rho[i] == 0.0 {
                unit(i)
            } else {
                rho[i] * s[i]
            }
        };
        for (pane, state) in at.panes.iter().enumerate() {
            let normal = layout.normal(pane);
            let Some(pair) = layout.tangential(pane) else {
                continue;
            };
            match (piece.zones[pane], &state.slip) {
                (Zone::Stick, _) => {
                    out[normal] = stuck(normal);
                    pair.iter().for_each(|i| out[*i] = stuck(*i));
                }
                (Zone::Slip, Some(slip)) => {
                    out[normal] = stuck(normal);
                    let trial = pair.map(|i| match rho[i] {
                        0.0 => 0.0,
                        rho => unit(i) - rho * s[i],
                    });
                    let followed = friction == Friction::Followed;
                    let bound = match followed && !piece.capped[pane] {
                        true => unit(normal),
                        false => 0.0,
                    };
                    let mut inverse = [0.0; 2];
                    if let (true, Some(compliance)) = (followed, compliance) {
                        for (node, weight) in surface.pane_weights(pane) {
                            let Some(Some(nodal)) = at.nodes.get(node) else {
                                continue;
                            };
                            let u = [compliance[2 * node], compliance[2 * node + 1]];
                            for k in 0..2 {
                                let along = nodal.slope[k][0] * u[0] + nodal.slope[k][1] * u[1];
                                inverse[k] -= weight * self.stress * along;
                            }
                        }
                    }
                    for k in 0..2 {
                        out[pair[k]] = unit(pair[k])
                            - slip.by_trial[k][0] * trial[0]
                            - slip.by_trial[k][1] * trial[1]
                            - slip.by_bound[k] * bound
                            - slip.by_inverse[k][0] * inverse[0]
                            - slip.by_inverse[k][1] * inverse[1];
                    }
                }
                (Zone::Open | Zone::Slip, _) => {
                    out[normal] = unit(normal);
                    pair.iter().for_each(|i| out[*i] = unit(*i));
                }
            }
        }
    }
}
