//! The equations of a smooth piece, their derivative, and how far a point is from the ends of the piece.

use super::{
    family::{Family, Member},
    law_piece::{LawPieces, NodalInverse},
    piece::{Beyond, Distance, Piece, Switch},
    slip_stress::SlipStress,
};
use crate::{
    linalg::norm,
    post::Zone,
    problem::ProblemError,
    solver::{Bound, NaturalMap, PaneZone},
};

/// Half the way in s over which derivatives by the parameter are differences. Loads that are straight in the parameter have none
/// but rounding; elsewhere the error, 1e-8 times third derivatives, slows Newton's method and turns tangents a
/// little, and moves no point.
const DIFFERENCE: f64 = 1e-4;

/// Stresses below this share of Λ are those of a face about to open.
const PRESSED: f64 = 1e-4;

/// The equations R(y, s) = 0 of a family: y = λ/Λ with the size of stresses Λ.
pub(super) struct Equations<'a> {
    pub(super) family: &'a Family<'a>,
    /// Λ in Pa.
    pub(super) stress: f64,
    /// The size of slips in m.
    pub(super) slip: f64,
}

/// The state of all panes at a point of a piece.
pub(super) struct Evaluated {
    /// R without unit, `[n]`.
    pub(super) residual: Vec<f64>,
    panes: Vec<PaneState>,
    /// 1/F at the nodes of slipping panes.
    nodes: Vec<Option<NodalInverse>>,
    /// u_t at the contact nodes in m; empty unless the law follows it.
    displacement: Vec<[f64; 2]>,
}

/// One pane; stresses over Λ.
struct PaneState {
    /// z_ν = λ_ν − ρ_ν r_ν.
    normal_trial: f64,
    pressure: f64,
    bound: f64,
    trial: [f64; 2],
    inverse: [f64; 2],
    slip: Option<SlipStress>,
}

impl<'a> Equations<'a> {
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

    /// ‖R‖ / ‖λ‖ of the natural map, measured by local stiffness as the solvers do; it knows nothing of pieces. Where hardly anything
    /// presses, over a small share of Λ.
    pub(super) fn natural_residual(&self, point: &[f64]) -> Result<f64, ProblemError> {
        let member = self.family.member(point[point.len() - 1])?;
        let multiplier = self.multiplier(point);
        let contact = member.contact();
        let bound = Bound::Coulomb(&contact, member.law());
        let steplengths = member.steplengths().to_vec();
        let map = NaturalMap::with_steplengths(&member.dual, bound, steplengths);
        Ok(match map.evaluate(&multiplier).norm {
            0.0 => 0.0,
            residual => residual / norm(&multiplier).max(PRESSED * self.stress),
        })
    }

    /// ‖R‖ / ‖λ‖ that rounding of S λ makes, n ε max ρ_i S_ii, times the largest coefficient by which a slip bound grows with it.
    pub(super) fn rounding(&self, member: &Member, at: &Evaluated) -> f64 {
        let rows = member.steplengths().iter().enumerate();
        let mobility = rows.map(|(j, rho)| rho * member.dual.column(j)[j]);
        let inverse = at.panes.iter().flat_map(|pane| pane.inverse);
        let friction = inverse.fold(1.0, |most, f| f64::max(most, f.recip()));
        member.dual.rounding() * mobility.fold(1.0, f64::max) * friction
    }

    /// R of a piece at a point; `None` where it has no value.
    pub(super) fn evaluate(&self, member: &Member, piece: &Piece, y: &[f64]) -> Option<Evaluated> {
        let multiplier: Vec<f64> = y.iter().map(|y| self.stress * y).collect();
        let gradient = member.dual.gradient(&multiplier);
        let rho = member.steplengths();
        let layout = member.dual.layout;
        let law = member.law();
        let cap = law.slip_bound(0, f64::INFINITY);
        let (nodes, displacement, inverse) = self.friction(member, piece, &multiplier);
        let step = |j: usize| rho[j] * gradient[j] / self.stress;
        // A component whose row of S vanishes moves nothing and carries nothing.
        let trial = |j: usize| if rho[j] == 0.0 { 0.0 } else { y[j] - step(j) };
        let mut residual = vec![0.0; y.len()];
        let mut panes = Vec::with_capacity(layout.n_panes());
        for pane in 0..layout.n_panes() {
            let normal = layout.normal(pane);
            let pair = layout.tangential(pane)?;
            let bound = match piece.capped[pane] {
                true => cap / self.stress,
                false => y[normal],
            };
            let mut state = PaneState {
                normal_trial: trial(normal),
                pressure: y[normal],
                bound,
                trial: pair.map(trial),
                inverse: inverse[pane],
                slip: None,
            };
            let stuck = |j: usize| if rho[j] == 0.0 { y[j] } else { step(j) };
            match piece.zones[pane] {
                Zone::Open => {
                    residual[normal] = y[normal];
                    pair.iter().for_each(|j| residual[*j] = y[*j]);
                }
                Zone::Stick => {
                    residual[normal] = stuck(normal);
                    pair.iter().for_each(|j| residual[*j] = stuck(*j));
                }
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
        finite.then_some(Evaluated {
            residual,
            panes,
            nodes,
            displacement,
        })
    }

    /// 1/F at the nodes of slipping panes, u_t at all nodes, 𝓕⁻¹ on all panes.
    #[expect(clippy::type_complexity)]
    fn friction(
        &self,
        member: &Member,
        piece: &Piece,
        multiplier: &[f64],
    ) -> (Vec<Option<NodalInverse>>, Vec<[f64; 2]>, Vec<[f64; 2]>) {
        let (surface, law) = (member.surface(), member.law());
        let laws = LawPieces::new(law);
        let displacement = match law.depends_on_slip() {
            true => member.dual.tangential_displacement(multiplier),
            false => Vec::new(),
        };
        let nodes: Vec<Option<NodalInverse>> = if displacement.is_empty() {
            Vec::new()
        } else {
            let nodes = displacement.iter().zip(&piece.nodes).enumerate();
            nodes
                .map(|(node, (u, piece))| Some(laws.inverse(node, *u, piece.as_ref()?)))
                .collect()
        };
        let slip: Vec<[f64; 2]> = displacement.iter().map(|u| u.map(f64::abs)).collect();
        let everywhere = law.at_nodes(&slip);
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
        (nodes, displacement, inverse)
    }

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

    /// The distances of a point to all ends of its piece.
    pub(super) fn distances(
        &self,
        member: &Member,
        piece: &Piece,
        at: &Evaluated,
    ) -> Vec<Distance> {
        let law = member.law();
        // Stresses of single panes, of which all together have the size 1.
        let unit = (at.panes.len() as f64).sqrt();
        let cap = law.slip_bound(0, f64::INFINITY) / self.stress;
        let mut distances = Vec::new();
        let mut zone = |switch: Switch, value: f64| {
            distances.push(Distance {
                switch,
                value: unit * value,
                beyond: Beyond::Zone,
            });
        };
        for (pane, state) in at.panes.iter().enumerate() {
            match piece.zones[pane] {
                Zone::Open => zone(Switch::Opening(pane), -state.normal_trial),
                Zone::Stick => {
                    let [f1, f2] = state.inverse;
                    let stress = (f1 * state.trial[0]).hypot(f2 * state.trial[1]);
                    zone(Switch::Opening(pane), state.pressure);
                    zone(Switch::Slipping(pane), state.bound - stress);
                }
                Zone::Slip => {
                    zone(Switch::Opening(pane), state.pressure);
                    let excess = state.slip.as_ref().map_or(0.0, |slip| slip.excess);
                    zone(Switch::Slipping(pane), excess);
                }
            }
        }
        if cap.is_finite() {
            for (pane, state) in at.panes.iter().enumerate() {
                let above = state.pressure - cap;
                let capped = piece.capped[pane];
                distances.push(Distance {
                    switch: Switch::Cap(pane),
                    value: unit * if capped { above } else { -above },
                    beyond: Beyond::Cap(!capped),
                });
            }
        }
        let laws = LawPieces::new(law);
        let nodes = at.displacement.iter().zip(&piece.nodes).enumerate();
        for (node, (u, piece)) in nodes {
            if let Some(piece) = piece {
                laws.distances(node, *u, piece, self.slip, &mut distances);
            }
        }
        distances
    }

    /// The law at the nodes of slipping panes as it is at a point, in place of what a piece says; nodes that slipped before keep
    /// theirs.
    pub(super) fn follow_law(&self, member: &Member, piece: &mut Piece, point: &[f64]) {
        let law = member.law();
        let surface = member.surface();
        if !law.depends_on_slip() {
            piece.nodes = Vec::new();
            return;
        }
        let displacement = member.dual.tangential_displacement(&self.multiplier(point));
        let mut slips = vec![false; displacement.len()];
        for (pane, zone) in piece.zones.iter().enumerate() {
            if *zone == Zone::Slip {
                surface
                    .pane_weights(pane)
                    .for_each(|(node, _)| slips[node] = true);
            }
        }
        let laws = LawPieces::new(law);
        piece.nodes.resize(displacement.len(), None);
        for ((node, slips), u) in piece.nodes.iter_mut().zip(slips).zip(displacement) {
            *node = slips.then(|| node.unwrap_or_else(|| laws.piece_of(u)));
        }
    }

    /// The piece on which a solution lies.
    pub(super) fn piece_of(&self, member: &Member, point: &[f64]) -> Piece {
        let multiplier = self.multiplier(point);
        let contact = member.contact();
        let law = member.law();
        let bound = Bound::Coulomb(&contact, law);
        let steplengths = member.steplengths().to_vec();
        let map = NaturalMap::with_steplengths(&member.dual, bound, steplengths);
        let (normal, _) = member.dual.layout.split(&multiplier);
        let capped = normal.iter().map(|p| law.slip_bound(0, *p) < *p).collect();
        let mut piece = Piece {
            zones: map
                .evaluate(&multiplier)
                .panes
                .iter()
                .map(|pane| match pane.zone() {
                    PaneZone::Open => Zone::Open,
                    PaneZone::Stick => Zone::Stick,
                    PaneZone::Slip => Zone::Slip,
                })
                .collect(),
            capped,
            nodes: Vec::new(),
        };
        self.follow_law(member, &mut piece, point);
        piece
    }

    /// What the candidates of a pane's zone are where it switches: those whose closures hold the point.
    pub(super) fn zones_at(&self, at: &Evaluated, pane: usize, tolerance: f64) -> Vec<Zone> {
        let state = &at.panes[pane];
        let unit = (at.panes.len() as f64).sqrt();
        let [f1, f2] = state.inverse;
        let stress = unit * (f1 * state.trial[0]).hypot(f2 * state.trial[1]);
        let lifts = unit * state.normal_trial.abs() <= tolerance;
        let stays = stress <= unit * state.normal_trial.max(0.0) + tolerance;
        match (lifts, stays) {
            (true, true) => vec![Zone::Open, Zone::Stick, Zone::Slip],
            (true, false) => vec![Zone::Open, Zone::Slip],
            (false, _) => vec![Zone::Stick, Zone::Slip],
        }
    }
}

/// Whether slip bounds and coefficients move with λ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Friction {
    Followed,
    Frozen,
}
