//! The equations of a smooth piece and their derivative by λ and by the parameter.

use super::{
    family::Family,
    law_piece::{LawPieces, NodalInverse},
    piece::Piece,
    point::FamilyMember,
    slip_stress::{SlipStress, Slips},
};
use contact3d::{ProblemError, linalg::norm, post::Zone};

/// The equations R(y, s) = 0 of a family: y = λ/Λ with the size of stresses Λ.
pub(super) struct PieceEquations<'a> {
    pub(super) family: &'a Family<'a>,
    /// Λ in Pa.
    pub(super) stress: f64,
    /// The size of slips in m.
    pub(super) slip: f64,
}

/// The state of all panes at a point of a piece.
pub(super) struct EvaluatedPiece {
    /// R without unit, `[n]`.
    pub(super) residual: Vec<f64>,
    pub(super) panes: Vec<EvaluatedPane>,
    /// 1/F at the nodes of slipping panes.
    pub(super) nodes: Vec<Option<NodalInverse>>,
    /// Those that the law follows.
    pub(super) slips: Slips,
}

/// One pane; stresses over Λ.
pub(super) struct EvaluatedPane {
    /// z_ν = λ_ν − ρ_ν r_ν.
    pub(super) normal_trial: f64,
    pub(super) pressure: f64,
    pub(super) bound: f64,
    pub(super) trial: [f64; 2],
    pub(super) inverse: [f64; 2],
    pub(super) slip: Option<SlipStress>,
}

impl<'a> PieceEquations<'a> {
    pub(super) fn new(family: &'a Family<'a>) -> Result<Self, ProblemError> {
        Ok(Self {
            stress: family.stress()?,
            slip: family.slip()?,
            family,
        })
    }

    /// λ in Pa of a point (y, s).
    pub(super) fn multiplier(&self, point: &[f64]) -> Vec<f64> {
        let (_, y) = point.split_last().expect("a point has a parameter");
        y.iter().map(|y| self.stress * y).collect()
    }

    /// ‖R‖ / ‖λ‖ of the natural map. Where hardly anything presses, over a small share of Λ.
    pub(super) fn natural_residual(&self, point: &[f64]) -> Result<f64, ProblemError> {
        let member = self.family.member(point[point.len() - 1])?;
        let multiplier = self.multiplier(point);
        let residual = member.natural_map(|map| map.evaluate(&multiplier).norm);
        Ok(match residual {
            0.0 => 0.0,
            // Stresses below this share of Λ are those of a face about to open.
            residual => residual / norm(&multiplier).max(1e-4 * self.stress),
        })
    }

    /// ‖R‖ / ‖λ‖ that rounding of S λ makes, n ε max ρ_i S_ii, times the largest coefficient by which a slip bound grows with it.
    pub(super) fn rounding(&self, member: &FamilyMember, at: &EvaluatedPiece) -> f64 {
        let rows = member.steplengths().iter().enumerate();
        let mobility = rows.map(|(j, rho)| rho * member.dual.column(j)[j]);
        let inverse = at.panes.iter().flat_map(|pane| pane.inverse);
        let friction = inverse.fold(1.0, |most, f| f64::max(most, f.recip()));
        member.dual.rounding() * mobility.fold(1.0, f64::max) * friction
    }

    /// R of a piece at a point; `None` where it has no value.
    pub(super) fn evaluate(
        &self,
        member: &FamilyMember,
        piece: &Piece,
        y: &[f64],
    ) -> Option<EvaluatedPiece> {
        self.evaluate_with(member, piece, y, &self.response(member, y))
    }

    /// How the body answers multipliers: r = S λ − h in m³, `[n]`, and u_t at the contact nodes in m, empty where no law of the family
    /// follows it.
    fn response(&self, member: &FamilyMember, y: &[f64]) -> (Vec<f64>, Vec<[f64; 2]>) {
        let multiplier: Vec<f64> = y.iter().map(|y| self.stress * y).collect();
        let displacement = member.dual.tangential_displacement(&multiplier);
        (member.dual.gradient(&multiplier), displacement)
    }

    /// R of a piece at a point where the body answers in a given way.
    fn evaluate_with(
        &self,
        member: &FamilyMember,
        piece: &Piece,
        y: &[f64],
        (gradient, displacement): &(Vec<f64>, Vec<[f64; 2]>),
    ) -> Option<EvaluatedPiece> {
        let rho = member.steplengths();
        let layout = member.dual.layout;
        let law = member.law();
        let cap = law.slip_bound(0, f64::INFINITY);
        let (nodes, slips, inverse) = self.friction(member, piece, displacement);
        let step = |j: usize| rho[j] * gradient[j] / self.stress;
        // A component whose row of S vanishes moves nothing and carries nothing.
        let trial = |j: usize| if rho[j] == 0.0 { 0.0 } else { y[j] - step(j) };
        let mut residual = vec![0.0; y.len()];
        let mut panes = Vec::with_capacity(layout.n_panes());
        for pane in 0..layout.n_panes() {
            let normal = layout.normal(pane);
            let pair = layout.tangential(pane)?;
            let bound = if piece.capped[pane] {
                cap / self.stress
            } else {
                y[normal]
            };
            let mut state = EvaluatedPane {
                normal_trial: trial(normal),
                pressure: y[normal],
                bound,
                trial: pair.map(trial),
                inverse: inverse[pane],
                slip: None,
            };
            let stuck = |j: usize| if rho[j] == 0.0 { y[j] } else { step(j) };
            let all = [normal, pair[0], pair[1]];
            match piece.zones[pane] {
                Zone::Open => all.iter().for_each(|j| residual[*j] = y[*j]),
                Zone::Stick => all.iter().for_each(|j| residual[*j] = stuck(*j)),
                Zone::Slip => {
                    residual[normal] = stuck(normal);
                    let slip = SlipStress::new(state.trial, bound, state.inverse)?;
                    for (j, stress) in pair.into_iter().zip(slip.stress) {
                        residual[j] = y[j] - stress;
                    }
                    state.slip = Some(slip);
                }
            }
            panes.push(state);
        }
        let finite = residual.iter().all(|r| r.is_finite());
        finite.then_some(EvaluatedPiece {
            residual,
            panes,
            nodes,
            slips,
        })
    }

    /// 1/F at the nodes of slipping panes, slips at all nodes, 𝓕⁻¹ on all panes.
    fn friction(
        &self,
        member: &FamilyMember,
        piece: &Piece,
        displacement: &[[f64; 2]],
    ) -> (Vec<Option<NodalInverse>>, Slips, Vec<[f64; 2]>) {
        let (surface, law) = (member.surface(), member.law());
        let laws = LawPieces::new(member);
        let followed = if law.depends_on_slip() {
            displacement
        } else {
            &[]
        };
        let slips = Slips::on_piece(followed, &piece.nodes);
        let nodes = slips.value.iter().zip(&piece.nodes).enumerate();
        let nodes: Vec<Option<NodalInverse>> = nodes
            .map(|(node, (slip, piece))| Some(laws.inverse(node, *slip, piece.as_ref()?)))
            .collect();
        let sizes: Vec<[f64; 2]> = slips.value.iter().map(|slip| slip.map(f64::abs)).collect();
        let everywhere = law.at_nodes(&sizes);
        let inverse_at = |node: usize| match nodes.get(node) {
            Some(Some(forced)) => forced.value,
            _ => everywhere[node].map(f64::recip),
        };
        let panes = (0..surface.n_panes()).map(|pane| {
            let weights = surface.pane_weights(pane);
            weights.fold([0.0; 2], |sum, (node, weight)| {
                let inverse = inverse_at(node);
                [0, 1].map(|k| sum[k] + weight * inverse[k])
            })
        });
        let inverse = panes.collect();
        (nodes, slips, inverse)
    }
}

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
            let pairs = a.iter().zip(b);
            pairs
                .map(|(a, b)| (b - a) / (width * self.stress))
                .collect()
        };
        let gradient = rate(&behind.0, &ahead.0);
        let slips = [&ahead, &behind].map(|side| side.1.as_flattened());
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
            let all = [normal, pair[0], pair[1]];
            match (piece.zones[pane], &state.slip) {
                (Zone::Stick, _) => all.iter().for_each(|i| out[*i] = stuck(*i)),
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
                    let change = motion.slips.as_deref().unwrap_or_default();
                    for (node, weight) in surface.pane_weights(pane) {
                        let Some(([first, second], Some(Some(nodal)))) =
                            change.get(node).map(|moved| (moved, at.nodes.get(node)))
                        else {
                            continue;
                        };
                        for (inverse, by) in inverse.iter_mut().zip(nodal.slope) {
                            *inverse -= weight * self.stress * (by[0] * first + by[1] * second);
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
                (Zone::Open | Zone::Slip, _) => all.iter().for_each(|i| out[*i] = unit(*i)),
            }
        }
    }
}
