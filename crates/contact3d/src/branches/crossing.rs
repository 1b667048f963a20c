//! The half paths that cross a path at a branch point on a smooth piece.

use super::{
    corrector::{Along, PathState},
    equations::Equations,
    kink::Ray,
    locate::CROSSED,
    piece::{Beyond, Piece},
};
use crate::{
    linalg::{add_scaled, difference, dot, norm},
    problem::ProblemError,
};

/// How far from a branch point on a smooth piece the crossing path is sought.
pub(super) const OFF: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// Most changes of the law's signs at a point off a branch point.
const MOST_TURNS: usize = 3;

impl Equations<'_> {
    /// The half paths that cross a path on one of its pieces: near the point, off the tangent along the second null vector of R'.
    pub(super) fn crossing(
        &self,
        piece: &Piece,
        place: &PathState,
    ) -> Result<Vec<Ray>, ProblemError> {
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
}

impl Equations<'_> {
    /// A point near a guess and its piece: the given one, with the law at nodes whose slip turns as it does there.
    fn law_followed(
        &self,
        piece: &Piece,
        guess: Vec<f64>,
        direction: &[f64],
        along: Along<'_>,
    ) -> Result<Option<Ray>, ProblemError> {
        let mut piece = piece.clone();
        for _ in 0..MOST_TURNS {
            let Some(state) = self.correct(&piece, guess.clone(), direction, along)? else {
                return Ok(None);
            };
            let mut left = state.distances(self, &piece);
            left.retain(|distance| distance.value < -CROSSED);
            if left.is_empty() {
                return Ok(Some(Ray {
                    state,
                    piece,
                    is_inside: true,
                }));
            }
            if left.iter().any(|distance| distance.beyond == Beyond::Zone) {
                return Ok(None);
            }
            for distance in left {
                piece.pass(distance.switch, distance.beyond);
            }
        }
        Ok(None)
    }
}
