//! One smooth piece of the problem and what lies beyond its ends.

use serde::{Deserialize, Serialize};

use super::{
    kink::HalfPath,
    path::{FIRST_STEP, RETURNED},
    point::{FrontRecord, PathOrigin},
};
use contact3d::{
    linalg::{difference, norm},
    post::Zone,
    scene::FormulaBranch,
};

/// What the law of friction does at a contact node on a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub(super) struct NodePiece {
    /// Whether u_t1 and u_t2 are negative.
    pub(super) negative: [bool; 2],
    /// For each coefficient the segments between its knots, along its own slip or, for a grid, along both.
    pub(super) segment: [[usize; 2]; 2],
    /// For each coefficient that is a formula the way it goes at its forks.
    #[serde(default)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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
    /// The sign of the slip of a node along an axis.
    Negative { axis: usize, negative: bool },
    /// The segment of a coefficient at a node.
    Segment {
        coefficient: usize,
        along: usize,
        segment: usize,
    },
    /// The side of a fork of the formula of a coefficient at a node.
    Fork {
        coefficient: usize,
        fork: usize,
        less: bool,
    },
}

impl Piece {
    /// Changes the law as `beyond` says at the place of a switch; zones are chosen elsewhere.
    pub(super) fn pass(&mut self, switch: Switch, beyond: AdjacentPiece) {
        match (switch, beyond) {
            (Switch::Cap(pane), AdjacentPiece::Cap(capped)) => self.capped[pane] = capped,
            (Switch::Reversal(node, _), AdjacentPiece::Negative { axis, negative }) => {
                if let Some(piece) = &mut self.nodes[node] {
                    piece.negative[axis] = negative;
                }
            }
            (
                Switch::Knot(node, _),
                AdjacentPiece::Segment {
                    coefficient,
                    along,
                    segment,
                },
            ) => {
                if let Some(piece) = &mut self.nodes[node] {
                    piece.segment[coefficient][along] = segment;
                }
            }
            (
                Switch::Knot(node, _),
                AdjacentPiece::Fork {
                    coefficient,
                    fork,
                    less,
                },
            ) => {
                if let Some(piece) = &mut self.nodes[node] {
                    let branch = &mut piece.branch[coefficient];
                    *branch = branch.with(fork, less);
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
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Open {
    pub(super) rays: Vec<FrontRecord>,
    pub(super) branch_points: Vec<Vec<f64>>,
}

impl Open {
    pub(super) fn keep(&mut self, rays: &[HalfPath]) {
        let origin = PathOrigin::BranchPoint;
        let records = rays.iter().map(|ray| ray.record(origin, FIRST_STEP));
        self.rays.extend(records);
    }

    pub(super) fn knows(&self, point: &[f64]) -> bool {
        let near = |known: &Vec<f64>| norm(&difference(known, point)) < RETURNED;
        self.branch_points.iter().any(near)
    }
}
