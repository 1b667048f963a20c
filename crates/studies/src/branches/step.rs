//! Steps along a path, exact where the piece is linear.

use super::{
    corrector::{Along, PathState},
    equations::PieceEquations,
    locate::{CROSSED, Chord, LOCATED},
    path::{PathFront, STRAIGHT},
    piece::{EndDistance, Piece},
};
use contact3d::{
    ProblemError,
    linalg::{add_scaled, difference, dot, norm},
};

/// A piece does not end within this share of a step; shorter steps tell.
const STILL: f64 = 1e-3;

/// Steps across a branch point are no longer than this.
const SURE_STEP: f64 = 1e-4;

/// A corrected point may lie this many steps from the last one.
const NEAR: f64 = 2.0;

/// What a step came to.
pub(super) enum Advance {
    /// A point of the same piece.
    Point(PathState),
    /// The end of the range.
    RangeEnd(PathState),
    /// An end of the piece, with what ends there.
    PieceEnd(PathState, Vec<EndDistance>),
    /// Nothing; a smaller step may do.
    Nothing,
}

impl PieceEquations<'_> {
    /// One step of the front's length, cut at the end of the range and at the first end of the piece.
    pub(super) fn advance(&self, front: &PathFront) -> Result<Advance, ProblemError> {
        let (from, piece) = (&front.state, &front.piece);
        let mut guess = from.point.clone();
        add_scaled(&mut guess, front.step, &from.tangent);
        let ahead = guess[guess.len() - 1];
        let leaves = !(0.0..=1.0).contains(&ahead);
        let corrected = if leaves {
            self.at_range_end(front, &from.point, &guess)?
        } else {
            self.ahead(front, guess)?
        };
        let Some(mut state) = corrected else {
            return Ok(Advance::Nothing);
        };
        let mut at_end = leaves;
        if !(0.0..=1.0).contains(&state.parameter()) && !leaves {
            let Some(end) = self.at_range_end(front, &from.point, &state.point)? else {
                return Ok(Advance::Nothing);
            };
            (state, at_end) = (end, true);
        }
        let chord = difference(&state.point, &from.point);
        let length = norm(&chord);
        let bent = dot(&state.tangent, &from.tangent) < STRAIGHT
            || dot(&chord, &from.tangent) < STRAIGHT * length
            || dot(&chord, &state.tangent) < STRAIGHT * length;
        // A step to another path may turn the orientation, too; a short one that does has passed a branch point.
        let turned = state.orientation != from.orientation && front.step > SURE_STEP;
        if bent || turned || length > NEAR * front.step {
            return Ok(Advance::Nothing);
        }
        if !self.crosses(piece, from, &state) {
            return Ok(if at_end {
                Advance::RangeEnd(state)
            } else {
                Advance::Point(state)
            });
        }
        let step = Chord {
            equations: self,
            piece,
            from,
            to: &state,
        };
        let found = step.first_end()?;
        // A path that leaves a kink leads into its piece; an end that a step finds at once lies beyond a turn it has missed.
        let moves =
            |state: &PathState| norm(&difference(&state.point, &from.point)) > STILL * front.step;
        if let Some((state, reached)) = found.filter(|(state, _)| moves(state)) {
            return Ok(Advance::PieceEnd(state, reached));
        }
        // Unless the last step has come to rest on the end itself, to rounding.
        let (reached, _) = self.ends_crossed(piece, from, &[])?;
        let here = self.state_at(piece, &from.point, &from.tangent)?;
        Ok(match here.filter(|_| !reached.is_empty()) {
            Some(state) => Advance::PieceEnd(state, reached),
            None => Advance::Nothing,
        })
    }

    /// Whether a step leaves its piece: an end lies behind it, if by little only one that was ahead, since some ends are met all
    /// along a path, as the reversal of a node on a plane of symmetry.
    fn crosses(&self, piece: &Piece, from: &PathState, to: &PathState) -> bool {
        let (before, after) = (from.distances(self, piece), to.distances(self, piece));
        let leaves = |(before, after): (&EndDistance, &EndDistance)| {
            after.value < -CROSSED || after.value < -LOCATED && before.value > CROSSED
        };
        before.len() != after.len() || before.iter().zip(&after).any(leaves)
    }

    /// The point of the piece near a guess on the tangent; where R' is almost singular, as near a branch point, and the nearest one is not
    /// found, the one straight ahead.
    fn ahead(&self, front: &PathFront, guess: Vec<f64>) -> Result<Option<PathState>, ProblemError> {
        let tangent = &front.state.tangent;
        let nearest = self.correct(&front.piece, guess.clone(), tangent, Along::Nearest)?;
        if nearest.is_some() {
            return Ok(nearest);
        }
        let along = Along::Plane(tangent, dot(tangent, &guess));
        self.correct(&front.piece, guess, tangent, along)
    }

    /// The point of a piece at the end of the range that lies between two points.
    fn at_range_end(
        &self,
        front: &PathFront,
        from: &[f64],
        to: &[f64],
    ) -> Result<Option<PathState>, ProblemError> {
        let last = from.len() - 1;
        let end = if to[last] > 1.0 { 1.0 } else { 0.0 };
        let length = to[last] - from[last];
        let share = if length == 0.0 {
            0.0
        } else {
            (end - from[last]) / length
        };
        let mut guess: Vec<f64> = from
            .iter()
            .zip(to)
            .map(|(a, b)| a + share * (b - a))
            .collect();
        guess[last] = end;
        let mut normal = vec![0.0; from.len()];
        normal[last] = 1.0;
        let along = Along::Plane(&normal, end);
        self.correct(&front.piece, guess, &front.state.tangent, along)
    }
}
