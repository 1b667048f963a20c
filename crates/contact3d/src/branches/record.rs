//! Fronts of paths as plain data, from which a search goes on with the same bits.

use serde::{Deserialize, Serialize};

use super::{
    corrector::PathState,
    equations::Equations,
    kink::Ray,
    path::Front,
    piece::{NodePiece, Piece},
    range::ParameterRange,
};
use crate::{
    linalg::{difference, dot, norm},
    post::Zone,
    problem::ProblemError,
};

/// Where a path begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum PathOrigin {
    /// The solver's answer at the start of the range.
    Solver,
    /// A solution at one end of the range that was searched for.
    Search,
    /// A branch point.
    BranchPoint,
}

/// A front: where a path stands and how it goes on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct FrontRecord {
    pub(super) origin: PathOrigin,
    point: Vec<f64>,
    tangent: Vec<f64>,
    orientation: i8,
    step: f64,
    zones: String,
    capped: Vec<bool>,
    nodes: Vec<Option<NodePiece>>,
}

impl FrontRecord {
    pub(super) fn of(origin: PathOrigin, state: &PathState, piece: &Piece, step: f64) -> Self {
        let letter = |zone: &Zone| match zone {
            Zone::Open => 'o',
            Zone::Stick => 't',
            Zone::Slip => 'l',
        };
        Self {
            origin,
            point: state.point.clone(),
            tangent: state.tangent.clone(),
            orientation: state.orientation,
            step,
            zones: piece.zones.iter().map(letter).collect(),
            capped: piece.capped.clone(),
            nodes: piece.nodes.clone(),
        }
    }

    /// The parameter and λ in Pa.
    pub(super) fn solution(&self, range: &ParameterRange, stress: f64) -> (f64, Vec<f64>) {
        let (s, y) = self.point.split_last().unwrap_or((&0.0, &[]));
        (range.value(*s), y.iter().map(|y| stress * y).collect())
    }

    /// Whether a path that ends in a state came along this front, the other way.
    pub(super) fn arrives(&self, state: &PathState, tolerance: f64) -> bool {
        norm(&difference(&self.point, &state.point)) <= tolerance
            && dot(&self.tangent, &state.tangent) <= -1.0 + tolerance
    }

    /// The front again; `None` where the record does not fit the problem.
    pub(super) fn front(&self, equations: &Equations<'_>) -> Result<Option<Front>, ProblemError> {
        let zone = |letter: char| match letter {
            'o' => Some(Zone::Open),
            't' => Some(Zone::Stick),
            'l' => Some(Zone::Slip),
            _ => None,
        };
        let Some(zones) = self.zones.chars().map(zone).collect::<Option<Vec<Zone>>>() else {
            return Ok(None);
        };
        let piece = Piece {
            zones,
            capped: self.capped.clone(),
            nodes: self.nodes.clone(),
        };
        let n = self.point.len();
        let member = equations.family.member(0.0)?;
        let panes = member.dual.n_panes();
        let fits = n == member.dual.dimension() + 1
            && self.tangent.len() == n
            && piece.zones.len() == panes
            && piece.capped.len() == panes;
        if !fits {
            return Ok(None);
        }
        let Some((member, evaluated)) = equations.at(&piece, &self.point)? else {
            return Ok(None);
        };
        Ok(Some(Front {
            state: PathState {
                point: self.point.clone(),
                tangent: self.tangent.clone(),
                orientation: self.orientation,
                steps: 0,
                member,
                evaluated,
            },
            piece,
            step: self.step,
        }))
    }
}

impl Ray {
    pub(super) fn record(&self, origin: PathOrigin, step: f64) -> FrontRecord {
        FrontRecord::of(origin, &self.state, &self.piece, step)
    }
}
