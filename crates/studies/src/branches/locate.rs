//! Where a path crosses from one piece to the next.

use super::{
    corrector::{Along, PathState, unit},
    equations::PieceEquations,
    kink::{HalfPath, REACHED},
    piece::{AdjacentPiece, EndDistance, Piece},
};
use contact3d::{
    ProblemError,
    linalg::{add_scaled, difference, dot, norm},
};

/// An end of a piece is located when its distance is this small.
pub(super) const LOCATED: f64 = 1e-13;

/// A distance below minus this is beyond the end.
pub(super) const CROSSED: f64 = 1e-9;

/// Most corrections to locate a place; bisection alone takes 45 to rounding.
const MOST_TRIALS: usize = 80;

/// Shares of a bracket that are kept from its ends.
const MARGIN: f64 = 0.02;

/// A step between two points of one piece, as a function of the share of its chord.
pub(super) struct Chord<'e> {
    pub(super) equations: &'e PieceEquations<'e>,
    pub(super) piece: &'e Piece,
    pub(super) from: &'e PathState,
    pub(super) to: &'e PathState,
}

impl Chord<'_> {
    /// The point whose projection on the chord lies at a share of it.
    pub(super) fn at(&self, share: f64) -> Result<Option<PathState>, ProblemError> {
        let chord = difference(&self.to.point, &self.from.point);
        let length = norm(&chord);
        let normal = unit(&chord);
        let from = self.from.point.iter().zip(&chord);
        let guess: Vec<f64> = from.map(|(x, d)| x + share * d).collect();
        let value = dot(&normal, &self.from.point) + share * length;
        let along = Along::Plane(&normal, value);
        self.equations.correct(self.piece, guess, &normal, along)
    }

    /// The first point at which an end of the piece is reached, with all ends reached there; `to` lies beyond one.
    pub(super) fn first_end(&self) -> Result<Option<(PathState, Vec<EndDistance>)>, ProblemError> {
        let distances = |state: &PathState| state.distances(self.equations, self.piece);
        let (mut low, mut high) = (0.0, 1.0);
        let values =
            |state: &PathState| -> Vec<f64> { distances(state).iter().map(|d| d.value).collect() };
        let (mut inside, mut outside) = (values(self.from), values(self.to));
        if inside.len() != outside.len() {
            return Ok(None);
        }
        let mut found = None;
        for trial in 0..MOST_TRIALS {
            let crossing = inside.iter().zip(&outside).filter(|(_, b)| **b < -LOCATED);
            let first = crossing
                .map(|(a, b)| a.max(0.0) / (a.max(0.0) - b))
                .fold(1.0, f64::min);
            let share = match trial % 3 {
                2 => 0.5,
                // Without the margin once the line through both ends is all but the path.
                1 if first > 0.0 => first,
                _ => first.clamp(MARGIN, 1.0 - MARGIN),
            };
            let middle = low + share * (high - low);
            let Some(state) = self.at(middle)? else {
                return Ok(None);
            };
            let here = values(&state);
            if here.len() != inside.len() {
                return Ok(None);
            }
            // Ends from which the step began count once they are behind it.
            let crossing = here.iter().zip(&outside).filter(|(_, b)| **b < -LOCATED);
            let least = crossing.map(|(a, _)| *a).fold(f64::INFINITY, f64::min);
            let beyond = least < -LOCATED;
            let located = least.abs() <= LOCATED || (high - low) * share.max(1.0 - share) < LOCATED;
            if beyond {
                (high, outside) = (middle, here);
            } else {
                (low, inside) = (middle, here);
            }
            found = Some(state);
            if located {
                break;
            }
        }
        let Some(state) = found else { return Ok(None) };
        let reached = distances(&state);
        let least = reached.iter().map(|d| d.value);
        let least = least.fold(f64::INFINITY, f64::min);
        if least.abs() > REACHED {
            return Ok(None);
        }
        // Ends that the step does not cross, as the reversal of a held node, end nothing.
        let crossed = distances(self.to).into_iter().map(|d| d.value < -LOCATED);
        let reached = reached.into_iter().zip(crossed);
        let reached = reached.filter(|(d, crossed)| *crossed && d.value <= REACHED);
        Ok(Some((state, reached.map(|(d, _)| d).collect())))
    }

    /// The fold between two points whose parameters go different ways: where ds = 0, by regula falsi in the Illinois variant.
    pub(super) fn fold(&self) -> Result<Option<PathState>, ProblemError> {
        let (mut low, mut high) = (0.0, 1.0);
        let (mut at_low, mut at_high) = (self.from.parameter_rate(), self.to.parameter_rate());
        let (mut found, mut last) = (None, None);
        for _ in 0..MOST_TRIALS {
            let middle = low + (high - low) * (at_low / (at_low - at_high)).clamp(1e-3, 1.0 - 1e-3);
            let Some(state) = self.at(middle)? else {
                return Ok(found);
            };
            let rate = state.parameter_rate();
            let located = rate.abs() <= LOCATED || high - low < LOCATED;
            let is_low = (rate > 0.0) == (at_low > 0.0);
            if is_low {
                (low, at_low) = (middle, rate);
            } else {
                (high, at_high) = (middle, rate);
            }
            // An end that stays twice counts half.
            match (last, is_low) {
                (Some(true), true) => at_high *= 0.5,
                (Some(false), false) => at_low *= 0.5,
                _ => {}
            }
            last = Some(is_low);
            found = Some(state);
            if located {
                break;
            }
        }
        Ok(found)
    }

    /// The place between two points where the determinant of R' bordered by the tangent changes its sign, by bisection.
    pub(super) fn branch_point(&self) -> Result<Option<PathState>, ProblemError> {
        let (mut low, mut high) = (0.0, 1.0);
        let mut found = None;
        for _ in 0..MOST_TRIALS {
            if high - low < CROSSED {
                break;
            }
            let middle = 0.5 * (low + high);
            let Some(state) = self.at(middle)? else { break };
            if state.orientation == self.from.orientation {
                low = middle;
            } else {
                high = middle;
            }
            found = Some(state);
        }
        Ok(found)
    }
}

/// How far from a branch point on a smooth piece the crossing path is sought.
pub(super) const OFF: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// Most changes of the law's signs at a point off a branch point.
const MOST_TURNS: usize = 3;

impl PieceEquations<'_> {
    /// The half paths that cross a path on one of its pieces: near the point, off the tangent along the second null vector of R'.
    pub(super) fn crossing(
        &self,
        piece: &Piece,
        place: &PathState,
    ) -> Result<Vec<HalfPath>, ProblemError> {
        let mut rays = Vec::new();
        let Some(across) = self.second_null_vector(piece, place)? else {
            return Ok(rays);
        };
        for side in [1.0, -1.0] {
            for off in OFF {
                let direction: Vec<f64> = across.iter().map(|v| side * v).collect();
                let mut guess = place.point.clone();
                add_scaled(&mut guess, off, &direction);
                let value = dot(&direction, &guess);
                let along = Along::Plane(&direction, value);
                let Some(ray) = self.law_followed(piece, guess, &direction, along)? else {
                    continue;
                };
                if norm(&difference(&ray.state.point, &place.point)) < 10.0 * off {
                    rays.push(ray);
                    break;
                }
            }
        }
        Ok(rays)
    }

    /// A point near a guess and its piece: the given one, with the law at nodes whose slip turns as it does there.
    fn law_followed(
        &self,
        piece: &Piece,
        guess: Vec<f64>,
        direction: &[f64],
        along: Along<'_>,
    ) -> Result<Option<HalfPath>, ProblemError> {
        let mut piece = piece.clone();
        for _ in 0..MOST_TURNS {
            let Some(state) = self.correct(&piece, guess.clone(), direction, along)? else {
                return Ok(None);
            };
            let mut left = state.distances(self, &piece);
            left.retain(|distance| distance.value < -CROSSED);
            if left.is_empty() {
                return Ok(Some(HalfPath {
                    state,
                    piece,
                    is_inside: true,
                }));
            }
            let is_zone = |distance: &EndDistance| distance.beyond == AdjacentPiece::Zone;
            if left.iter().any(is_zone) {
                return Ok(None);
            }
            for distance in left {
                piece.pass(distance.switch, distance.beyond);
            }
        }
        Ok(None)
    }
}
