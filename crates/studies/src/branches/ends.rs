//! The ends of a range of the parameter, and the solutions there.

use serde::{Deserialize, Serialize};

use super::{
    branches::Branches,
    equations::{EvaluatedPiece, PieceEquations},
    law_piece::LawPieces,
    piece::{AdjacentPiece, EndDistance, Piece, Switch},
    point::FamilyMember,
    search::SAME,
};
use contact3d::{
    linalg::{difference, norm},
    post::Zone,
    solver::{Bound, NaturalMap, PaneZone},
};

impl PieceEquations<'_> {
    /// The distances of a point to all ends of its piece.
    pub(super) fn distances(
        &self,
        member: &FamilyMember,
        piece: &Piece,
        at: &EvaluatedPiece,
    ) -> Vec<EndDistance> {
        let law = member.law();
        // Stresses of single panes, of which all together have the size 1.
        let unit = (at.panes.len() as f64).sqrt();
        let cap = law.slip_bound(0, f64::INFINITY) / self.stress;
        let mut distances = Vec::new();
        let mut zone = |switch: Switch, value: f64| {
            distances.push(EndDistance {
                switch,
                value: unit * value,
                beyond: AdjacentPiece::Zone,
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
                distances.push(EndDistance {
                    switch: Switch::Cap(pane),
                    value: unit * if capped { above } else { -above },
                    beyond: AdjacentPiece::Cap(!capped),
                });
            }
        }
        let laws = LawPieces::new(member);
        let nodes = at.slips.value.iter().zip(&piece.nodes).enumerate();
        for (node, (slip, piece)) in nodes {
            if let Some(piece) = piece {
                laws.distances(node, *slip, piece, self.slip, &mut distances);
            }
        }
        distances
    }

    /// The law at the nodes of slipping panes as it is at a point, in place of what a piece says; nodes that slipped before keep
    /// theirs.
    pub(super) fn follow_law(&self, member: &FamilyMember, piece: &mut Piece, point: &[f64]) {
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
        let laws = LawPieces::new(member);
        let sizes = member.interface.slip.operator.slip(&displacement);
        piece.nodes.resize(displacement.len(), None);
        for (index, (node, slips)) in piece.nodes.iter_mut().zip(slips).enumerate() {
            let negative = displacement[index].map(|u| laws.is_nodal && u < 0.0);
            let here = || laws.piece_of(index, sizes[index], negative);
            *node = slips.then(|| node.unwrap_or_else(here));
        }
    }

    /// The piece on which a solution lies.
    pub(super) fn piece_of(&self, member: &FamilyMember, point: &[f64]) -> Piece {
        let multiplier = self.multiplier(point);
        let laws = member.laws();
        let law = member.law();
        let bound = Bound::Coulomb(&laws, law);
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
    pub(super) fn zones_at(&self, at: &EvaluatedPiece, pane: usize, tolerance: f64) -> Vec<Zone> {
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

/// A solution at one end of the range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EndSolution {
    /// Its path.
    pub path: usize,
    /// Its place on it.
    pub point: usize,
}

impl Branches {
    /// The different solutions at one end of the range, by its parameter.
    #[must_use]
    pub fn end_solutions(&self, parameter: f64) -> Vec<EndSolution> {
        let mut found: Vec<EndSolution> = Vec::new();
        for (path, followed) in self.paths.iter().enumerate() {
            for (point, at) in followed.points.iter().enumerate() {
                let known = |other: &EndSolution| {
                    let other = &self.paths[other.path].points[other.point];
                    norm(&difference(&other.multiplier, &at.multiplier)) <= SAME * self.stress
                };
                if at.parameter == parameter && !found.iter().any(known) {
                    found.push(EndSolution { path, point });
                }
            }
        }
        found
    }

    /// Σ sign det R' over the solutions at one end of the range, which is 1 where none is missing and all are regular.
    #[must_use]
    pub fn degree(&self, parameter: f64) -> i32 {
        let solutions = self.end_solutions(parameter);
        let signs = solutions
            .iter()
            .map(|at| i32::from(self.paths[at.path].points[at.point].determinant));
        signs.sum()
    }
}

/// A range of one sign whose ends differ by more than this factor is followed in the logarithm of the parameter.
const LOGARITHMIC_FROM: f64 = 100.0;

/// A range of a parameter of a scene.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ParameterRange {
    /// The key, for messages.
    pub key: String,
    /// The value at s = 0.
    pub from: f64,
    /// The value at s = 1.
    pub to: f64,
}

impl ParameterRange {
    /// Whether s is the share of the logarithm, and not of the value.
    #[must_use]
    pub fn is_logarithmic(&self) -> bool {
        let ratio = self.to / self.from;
        ratio > 0.0
            && ratio.is_finite()
            && !(LOGARITHMIC_FROM.recip()..=LOGARITHMIC_FROM).contains(&ratio)
    }

    /// The parameter at s.
    #[must_use]
    pub fn value(&self, s: f64) -> f64 {
        if s == 0.0 {
            self.from
        } else if s == 1.0 {
            self.to
        } else if self.is_logarithmic() {
            self.from * (self.to / self.from).powf(s)
        } else {
            self.from + s * (self.to - self.from)
        }
    }

    /// The share of the way from `from` to `to` of the value at s.
    pub(super) fn share(&self, s: f64) -> f64 {
        if self.is_logarithmic() {
            (self.value(s) - self.from) / (self.to - self.from)
        } else {
            s
        }
    }
}
