//! One smooth piece of the problem, how far its ends are, and what lies beyond them.

use super::{
    corrector::PathState,
    equations::{EvaluatedPiece, PieceEquations},
    kink::HalfPath,
    law_piece::LawPieces,
    path::RETURNED,
    point::{FamilyMember, PathOrigin},
};
use contact3d::{
    linalg::{difference, dot, norm},
    post::Zone,
    scene::FormulaBranch,
    solver::PaneEvaluation,
};

/// What the law of friction does at a contact node on a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct NodePiece {
    /// Whether u_t1 and u_t2 are negative.
    pub(super) negative: [bool; 2],
    /// For each coefficient the segments between its knots, along its own slip or, for a grid, along both.
    pub(super) segment: [[usize; 2]; 2],
    /// For each coefficient that is a formula the way it goes at its forks.
    pub(super) branch: [FormulaBranch; 2],
}

/// A smooth piece of the equations: the zones of all panes, and the branches of the law that their equations use.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Piece {
    pub(super) zones: Vec<Zone>,
    /// Panes whose slip bound is capped.
    pub(super) capped: Vec<bool>,
    /// The law at nodes of slipping panes; `None` at others, and everywhere if the law does not follow the slip.
    pub(super) nodes: Vec<Option<NodePiece>>,
}

/// What ends a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Switch {
    /// A pane closes or opens: z_ν = 0.
    Opening(usize),
    /// A pane begins or ceases to slip: its stress at the bound, and no slip.
    Slipping(usize),
    /// A pane reaches the pressure above which friction grows no further, or leaves it.
    Cap(usize),
    /// The slip of a contact node along an axis changes its sign, which bends the law.
    Reversal(usize, usize),
    /// The slip of a contact node reaches a knot of the law of a coefficient, or a kink of its formula.
    Knot(usize, usize),
}

impl Switch {
    /// The pane that changes; `None` where a node does.
    #[must_use]
    pub fn pane(self) -> Option<usize> {
        match self {
            Self::Opening(pane) | Self::Slipping(pane) | Self::Cap(pane) => Some(pane),
            Self::Reversal(..) | Self::Knot(..) => None,
        }
    }
}

/// How far a point is from one end of its piece: positive inside, in units of the stresses and slips of the whole face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EndDistance {
    pub(super) switch: Switch,
    pub(super) value: f64,
    /// What lies beyond.
    pub(super) beyond: AdjacentPiece,
}

/// What lies beyond one end of a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum AdjacentPiece {
    /// A pane changes between these zones.
    Zone,
    /// The cap is on or off.
    Cap(bool),
    /// The law at a node changes.
    Law(LawChange),
}

/// How the piece of a law at a node changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum LawChange {
    /// Along an axis the slip becomes negative, or no longer is.
    Negative(usize, bool),
    /// A coefficient, along one of its slips, goes to a segment.
    Segment(usize, usize, usize),
    /// The formula of a coefficient goes at a fork to the lesser side, or not.
    Fork(usize, usize, bool),
}

impl Piece {
    /// Changes the law as `beyond` says at the place of a switch; zones are chosen elsewhere.
    pub(super) fn pass(&mut self, switch: Switch, beyond: AdjacentPiece) {
        match (switch, beyond) {
            (Switch::Cap(pane), AdjacentPiece::Cap(capped)) => self.capped[pane] = capped,
            (Switch::Reversal(node, _) | Switch::Knot(node, _), AdjacentPiece::Law(change)) => {
                let Some(node) = &mut self.nodes[node] else {
                    return;
                };
                match change {
                    LawChange::Negative(axis, negative) => node.negative[axis] = negative,
                    LawChange::Segment(coefficient, along, segment) => {
                        node.segment[coefficient][along] = segment;
                    }
                    LawChange::Fork(coefficient, fork, less) => {
                        node.branch[coefficient] = node.branch[coefficient].with(fork, less);
                    }
                }
            }
            _ => {}
        }
    }

    /// How many panes are open, stick, slip.
    pub(super) fn counts(&self) -> [usize; 3] {
        [Zone::Open, Zone::Stick, Zone::Slip]
            .map(|zone| self.zones.iter().filter(|z| **z == zone).count())
    }
}

/// Half paths that are still to be followed, and branch points that are known.
#[derive(Default)]
pub(super) struct Open {
    pub(super) rays: Vec<(PathOrigin, HalfPath)>,
    pub(super) branch_points: Vec<Vec<f64>>,
}

impl Open {
    pub(super) fn keep(&mut self, rays: Vec<HalfPath>) {
        let rays = rays.into_iter();
        self.rays
            .extend(rays.map(|ray| (PathOrigin::BranchPoint, ray)));
    }

    /// Leaves out the half path along which a path has come to a state, the other way.
    pub(super) fn leave_out(&mut self, state: &PathState, tolerance: f64) {
        self.rays.retain(|(_, ray)| {
            norm(&difference(&ray.state.point, &state.point)) > tolerance
                || dot(&ray.state.tangent, &state.tangent) > -1.0 + tolerance
        });
    }

    pub(super) fn knows(&self, point: &[f64]) -> bool {
        let near = |known: &Vec<f64>| norm(&difference(known, point)) < RETURNED;
        self.branch_points.iter().any(near)
    }
}

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
        let mut end = |switch: Switch, value: f64, beyond: AdjacentPiece| {
            distances.push(EndDistance {
                switch,
                value: unit * value,
                beyond,
            });
        };
        let mut zone = |switch, value| end(switch, value, AdjacentPiece::Zone);
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
                let value = if capped { above } else { -above };
                end(Switch::Cap(pane), value, AdjacentPiece::Cap(!capped));
            }
        }
        let laws = LawPieces::new(member);
        let nodes = at.slips.value.iter().zip(&piece.nodes).enumerate();
        for (node, (slip, piece)) in nodes {
            if let Some(piece) = piece {
                distances.extend(laws.distances(node, *slip, piece, self.slip));
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
        let sizes = contact3d::contact::slips(member.interface.previous.as_ref(), &displacement);
        piece.nodes.resize(displacement.len(), None);
        for (index, (node, slips)) in piece.nodes.iter_mut().zip(slips).enumerate() {
            let negative = displacement[index].map(|u| u < 0.0);
            let here = || laws.piece_of(index, sizes[index], negative);
            *node = slips.then(|| node.unwrap_or_else(here));
        }
    }

    /// The piece on which a solution lies.
    pub(super) fn piece_of(&self, member: &FamilyMember, point: &[f64]) -> Piece {
        let (multiplier, law) = (self.multiplier(point), member.law());
        let panes = member.natural_map(|map| map.evaluate(&multiplier).panes);
        let (normal, _) = member.dual.layout.split(&multiplier);
        let mut piece = Piece {
            zones: panes.iter().map(PaneEvaluation::zone).collect(),
            capped: normal.iter().map(|p| law.slip_bound(0, *p) < *p).collect(),
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
