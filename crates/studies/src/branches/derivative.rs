//! The derivative of the equations of a smooth piece by λ and by the parameter.

use super::{
    equations::{EvaluatedPiece, PieceEquations},
    piece::Piece,
    point::FamilyMember,
};
use contact3d::{ProblemError, post::Zone};

/// Half the way in s over which r, u_t and the law are differences. What is straight in the parameter has no error but rounding, 1e-12;
/// elsewhere the error, 1e-8 times third derivatives, turns tangents a little, slows Newton's method and moves no point.
const DIFFERENCE: f64 = 1e-4;

/// Whether slip bounds and coefficients move with λ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FrictionTreatment {
    Followed,
    Frozen,
}

/// What moves R: an unknown y_j or nothing of them, r over Λ and the slips, whose change over Λ has the opposite sign.
struct Perturbation<'m> {
    unknown: Option<usize>,
    gradient: &'m [f64],
    slips: Option<Vec<[f64; 2]>>,
    friction: FrictionTreatment,
}

impl PieceEquations<'_> {
    /// ∂R/∂(y, s), column-major, `[n, n + 1]`.
    pub(super) fn derivative(
        &self,
        member: &FamilyMember,
        piece: &Piece,
        point: &[f64],
        at: &EvaluatedPiece,
    ) -> Result<Option<Vec<f64>>, ProblemError> {
        let n = point.len() - 1;
        let mut matrix = vec![0.0; n * (n + 1)];
        let (by_multiplier, by_parameter) = matrix.split_at_mut(n * n);
        for (j, column) in by_multiplier.chunks_exact_mut(n).enumerate() {
            self.column(member, piece, at, j, FrictionTreatment::Followed, column);
        }
        let Some(change) = self.parameter_change(piece, point, at)? else {
            return Ok(None);
        };
        by_parameter.copy_from_slice(&change);
        let finite = matrix.iter().all(|v| v.is_finite());
        Ok(finite.then_some(matrix))
    }

    /// ∂R/∂s: r and u_t move as differences within the range say, and R with them by its derivative, since a law that is steep makes R
    /// bend within less than such a difference; the law itself and steplengths move R by another difference.
    fn parameter_change(
        &self,
        piece: &Piece,
        point: &[f64],
        at: &EvaluatedPiece,
    ) -> Result<Option<Vec<f64>>, ProblemError> {
        let (s, y) = point.split_last().expect("a point has a parameter");
        let ends = [(s - DIFFERENCE).max(0.0), (s + DIFFERENCE).min(1.0)];
        let width = ends[1] - ends[0];
        if width <= 0.0 {
            return Ok(None);
        }
        let here = self.family.member(s.clamp(0.0, 1.0))?;
        let response = self.response(&here, y);
        let sides = [self.family.member(ends[0])?, self.family.member(ends[1])?];
        let [behind, ahead] = sides.each_ref().map(|member| self.response(member, y));
        let rate = |a: &[f64], b: &[f64]| -> Vec<f64> {
            let rates = a
                .iter()
                .zip(b)
                .map(|(a, b)| (b - a) / (width * self.stress));
            rates.collect()
        };
        let gradient = rate(&behind.gradient, &ahead.gradient);
        let slips = [&ahead, &behind].map(|side| side.displacement.as_flattened());
        let motion = Perturbation {
            unknown: None,
            gradient: &gradient,
            slips: Some(at.slips.change(&rate(slips[0], slips[1]))),
            friction: FrictionTreatment::Followed,
        };
        let mut change = vec![0.0; y.len()];
        self.moved(&here, piece, at, &motion, &mut change);
        let [behind, ahead] = sides.map(|member| self.evaluate_with(&member, piece, y, &response));
        let Some((behind, ahead)) = behind.zip(ahead) else {
            return Ok(None);
        };
        let law = behind.residual.iter().zip(&ahead.residual);
        for (change, (a, b)) in change.iter_mut().zip(law) {
            *change += (b - a) / width;
        }
        Ok(Some(change))
    }

    /// ∂R/∂y_j; with frozen friction as the minimisations of Ψ have it.
    pub(super) fn column(
        &self,
        member: &FamilyMember,
        piece: &Piece,
        at: &EvaluatedPiece,
        j: usize,
        friction: FrictionTreatment,
        out: &mut [f64],
    ) {
        let followed = friction == FrictionTreatment::Followed;
        let compliance = member.dual.compliance.as_ref().filter(|_| followed);
        let motion = Perturbation {
            unknown: Some(j),
            gradient: member.dual.column(j),
            slips: compliance.map(|c| at.slips.change(c.column(j))),
            friction,
        };
        self.moved(member, piece, at, &motion, out);
    }

    /// The change of R with a motion.
    fn moved(
        &self,
        member: &FamilyMember,
        piece: &Piece,
        at: &EvaluatedPiece,
        motion: &Perturbation<'_>,
        out: &mut [f64],
    ) {
        let s = motion.gradient;
        let rho = member.steplengths();
        let layout = member.dual.layout;
        let surface = member.surface();
        let unit = |i: usize| if motion.unknown == Some(i) { 1.0 } else { 0.0 };
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
                    let follows = motion.friction == FrictionTreatment::Followed;
                    let bound = if follows && !piece.capped[pane] {
                        unit(normal)
                    } else {
                        0.0
                    };
                    let mut inverse = [0.0; 2];
                    if let Some(change) = &motion.slips {
                        for (node, weight) in surface.pane_weights(pane) {
                            let Some(Some(nodal)) = at.nodes.get(node) else {
                                continue;
                            };
                            let moved = change[node];
                            for k in 0..2 {
                                let along =
                                    nodal.slope[k][0] * moved[0] + nodal.slope[k][1] * moved[1];
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
