//! The pieces that meet at a point, and the half paths that leave it.

use super::{
    corrector::PathState,
    equations::PieceEquations,
    piece::{AdjacentPiece, EndDistance, Piece, Switch},
};
use contact3d::{
    ProblemError,
    linalg::{add_scaled, dot, norm},
    post::Zone,
};

/// Ends of a piece this near are reached.
pub(super) const REACHED: f64 = 1e-8;

/// A point that satisfies the equations of a piece to this, lies on it.
const ON_PIECE: f64 = 1e-6;

/// Half the way of the difference that tells on which side of its ends a half path goes, and the rates that count as none. Over so
/// short a way the bend of a path under a law that falls within a micrometre does not count, and rounding makes rates of 1e-7.
const TRIAL: f64 = 1e-8;
const LEVEL: f64 = 1e-5;

/// The same for slips, which do not bend along a tangent; rounding makes rates of 1e-8.
const LAW_TRIAL: f64 = 1e-6;
const LAW_LEVEL: f64 = 3e-7;

/// A half path whose cosine with the tangent of a path is within this of −1 leads back along it.
const OPPOSITE: f64 = 1e-5;

/// Most corrections of the law at nodes that begin to slip.
const MOST_REVERSALS: usize = 4;

/// A half path from a point.
pub(super) struct HalfPath {
    pub(super) state: PathState,
    pub(super) piece: Piece,
    /// Whether it leaves the ends at which other pieces begin, so that it belongs to none of them; where a law is steep, the rays of two
    /// pieces may be all but parallel.
    pub(super) is_inside: bool,
}

impl HalfPath {
    /// Whether two pieces describe one ray.
    fn is(&self, other: &Self) -> bool {
        // Half paths with tangents this near are one.
        let parallel = 1.0 - dot(&self.state.tangent, &other.state.tangent) < 1e-7;
        let apart = self.is_inside && other.is_inside && self.piece != other.piece;
        parallel && !apart
    }

    /// Whether it leads back along a path that came on a piece, in the direction of a tangent.
    pub(super) fn leads_back(&self, piece: &Piece, tangent: &[f64]) -> bool {
        let opposite = dot(&self.state.tangent, tangent) <= -1.0 + OPPOSITE;
        opposite && (self.piece == *piece || !self.is_inside)
    }
}

/// What may change at a point: the zone of a pane, or one branch of the law.
enum Choice {
    Zone(usize, Vec<Zone>),
    Law(Switch, AdjacentPiece),
}

impl PieceEquations<'_> {
    /// All half paths that leave a point where a piece ends, each with the tangent that leads into its own piece.
    ///
    /// A generic end, where one pane or node changes, has two: the one that came and the one that goes on. Where several change
    /// at once, as panes of a symmetric body do, there may be more, and the point is a branch point.
    pub(super) fn rays(
        &self,
        piece: &Piece,
        state: &PathState,
        reached: &[EndDistance],
    ) -> Result<Vec<HalfPath>, ProblemError> {
        let choices = self.choices(state, reached);
        let mut rays: Vec<HalfPath> = Vec::new();
        for mut candidate in combinations(piece, &choices) {
            self.follow_law(&state.member, &mut candidate, &state.point);
            for ray in self.rays_into(&candidate, state, reached)? {
                if !rays.iter().any(|other| other.is(&ray)) {
                    rays.push(ray);
                }
            }
        }
        Ok(rays)
    }

    fn choices(&self, state: &PathState, reached: &[EndDistance]) -> Vec<Choice> {
        let mut choices: Vec<Choice> = Vec::new();
        for distance in reached {
            match distance.beyond {
                AdjacentPiece::Zone => {
                    let Some(pane) = distance.switch.pane() else {
                        continue;
                    };
                    let known =
                        |choice: &Choice| matches!(choice, Choice::Zone(p, _) if *p == pane);
                    if !choices.iter().any(known) {
                        let zones = self.zones_at(&state.evaluated, pane, 10.0 * REACHED);
                        choices.push(Choice::Zone(pane, zones));
                    }
                }
                beyond => choices.push(Choice::Law(distance.switch, beyond)),
            }
        }
        choices
    }

    /// The ways along a piece from a point of its closure that stay on it.
    fn rays_into(
        &self,
        piece: &Piece,
        from: &PathState,
        reached: &[EndDistance],
    ) -> Result<Vec<HalfPath>, ProblemError> {
        let mut rays = Vec::new();
        for forward in [true, false] {
            let mut piece = piece.clone();
            for _ in 0..MOST_REVERSALS {
                let found = self.state_at(&piece, &from.point, &from.tangent)?;
                let Some(mut state) = found else { break };
                if norm(&state.evaluated.residual) > ON_PIECE {
                    break;
                }
                if !forward {
                    state.turn();
                }
                let (left, is_inside) = self.ends_crossed(&piece, &state, reached)?;
                if left.is_empty() {
                    rays.push(HalfPath {
                        state,
                        piece,
                        is_inside,
                    });
                    break;
                }
                // The law at a node that begins to slip follows the way it slips.
                let is_zone = |distance: &EndDistance| distance.beyond == AdjacentPiece::Zone;
                if left.iter().any(is_zone) {
                    break;
                }
                for distance in left {
                    piece.pass(distance.switch, distance.beyond);
                }
            }
        }
        Ok(rays)
    }

    /// The ends of a piece, reached by a point, that its tangent crosses at once, and whether it leaves all those at which another piece
    /// begins.
    pub(super) fn ends_crossed(
        &self,
        piece: &Piece,
        state: &PathState,
        reached: &[EndDistance],
    ) -> Result<(Vec<EndDistance>, bool), ProblemError> {
        let here = state.distances(self, piece);
        let Some(of_zones) = self.rates(piece, state, TRIAL)? else {
            return Ok((here, false));
        };
        let of_law = self.rates(piece, state, LAW_TRIAL)?;
        let of_law = of_law.unwrap_or_else(|| of_zones.clone());
        let mut crossed = Vec::new();
        let mut is_inside = true;
        for ((here, of_zone), of_law) in here.iter().zip(of_zones).zip(of_law) {
            let (rate, level) = match here.beyond {
                AdjacentPiece::Zone | AdjacentPiece::Cap(_) => (of_zone, LEVEL),
                AdjacentPiece::Law(_) => (of_law, LAW_LEVEL),
            };
            if here.value <= REACHED && rate < -level || here.value < -10.0 * REACHED {
                crossed.push(*here);
            }
            let changes = reached.iter().any(|end| end.switch == here.switch);
            is_inside &= !changes || here.value > REACHED || rate > level;
        }
        Ok((crossed, is_inside))
    }

    /// How fast the distances to the ends of a piece change along a tangent, from those a little to both sides; `None` where the
    /// equations have no value.
    fn rates(
        &self,
        piece: &Piece,
        state: &PathState,
        trial: f64,
    ) -> Result<Option<Vec<f64>>, ProblemError> {
        let beside = |step: f64| -> Result<Option<Vec<EndDistance>>, ProblemError> {
            let mut point = state.point.clone();
            add_scaled(&mut point, step, &state.tangent);
            let (s, y) = point.split_last().expect("a point has a parameter");
            let member = self.family.member(s.clamp(0.0, 1.0))?;
            let evaluated = self.evaluate(&member, piece, y);
            Ok(evaluated.map(|evaluated| self.distances(&member, piece, &evaluated)))
        };
        let Some((behind, ahead)) = beside(-trial)?.zip(beside(trial)?) else {
            return Ok(None);
        };
        let rate = |(a, b): (&EndDistance, &EndDistance)| (b.value - a.value) / (2.0 * trial);
        Ok(Some(behind.iter().zip(&ahead).map(rate).collect()))
    }
}

/// All pieces that the choices allow; where they are too many, those in which one choice differs, and all at once.
fn combinations(piece: &Piece, choices: &[Choice]) -> Vec<Piece> {
    let number = |choice: &Choice| match choice {
        Choice::Zone(_, zones) => zones.len(),
        Choice::Law(..) => 2,
    };
    let mut all = choices.iter();
    let total = all.try_fold(1_usize, |n, choice| n.checked_mul(number(choice)));
    // Most combinations of pieces that are tried at a point.
    if total.is_some_and(|total| total <= 256) {
        let mut pieces = vec![piece.clone()];
        for choice in choices {
            let ways = |piece| (0..number(choice)).map(move |k| chosen(piece, choice, k));
            pieces = pieces.iter().flat_map(ways).collect();
        }
        return pieces;
    }
    let other = |piece: &Piece, choice: &Choice| match choice {
        Choice::Zone(pane, zones) => {
            let differs = |zone: &Zone| *zone != piece.zones[*pane];
            chosen(piece, choice, zones.iter().position(differs).unwrap_or(0))
        }
        Choice::Law(..) => chosen(piece, choice, 1),
    };
    let apart = |piece: Piece, choice| other(&piece, choice);
    let all = choices.iter().fold(piece.clone(), apart);
    let single = choices.iter().map(|choice| other(piece, choice));
    [piece.clone(), all].into_iter().chain(single).collect()
}

fn chosen(piece: &Piece, choice: &Choice, k: usize) -> Piece {
    let mut piece = piece.clone();
    match choice {
        Choice::Zone(pane, zones) => piece.zones[*pane] = zones[k],
        Choice::Law(switch, beyond) if k == 1 => piece.pass(*switch, *beyond),
        Choice::Law(..) => {}
    }
    piece
}
