//! Newton's corrector on bordered systems.

use std::sync::Arc;

use super::{
    equations::{EvaluatedPiece, FrictionTreatment, PieceEquations},
    piece::{EndDistance, Piece},
    point::FamilyMember,
};
use contact3d::{
    ProblemError,
    linalg::{DenseLu, add_scaled, dot, norm},
    solver::contraction_of_mapping,
};

/// How far beyond the range rounding may take a point.
const BEYOND: f64 = 1e-9;

/// Where a corrected point lies.
#[derive(Clone, Copy)]
pub(super) enum Along<'c> {
    /// Nearest to the guess, by the Moore–Penrose inverse: every step is orthogonal to the tangent, which follows.
    Nearest,
    /// On the plane nᵀx = c.
    Plane(&'c [f64], f64),
}

/// A point on a piece of a path.
pub(super) struct PathState {
    /// (y, s).
    pub(super) point: Vec<f64>,
    /// Unit tangent.
    pub(super) tangent: Vec<f64>,
    /// Sign of the determinant of R' bordered by the tangent.
    pub(super) orientation: i8,
    /// Steps of Newton's method.
    pub(super) steps: usize,
    pub(super) member: Arc<FamilyMember>,
    pub(super) evaluated: EvaluatedPiece,
}

impl PathState {
    /// ds along the path.
    pub(super) fn parameter_rate(&self) -> f64 {
        self.tangent[self.tangent.len() - 1]
    }

    pub(super) fn parameter(&self) -> f64 {
        self.point[self.point.len() - 1]
    }

    /// Goes the other way.
    pub(super) fn turn(&mut self) {
        self.tangent.iter_mut().for_each(|t| *t = -*t);
        self.orientation = -self.orientation;
    }

    /// Goes the way of a direction.
    fn turned_to(mut self, direction: &[f64]) -> Self {
        if dot(&self.tangent, direction) < 0.0 {
            self.turn();
        }
        self
    }

    pub(super) fn distances(
        &self,
        equations: &PieceEquations<'_>,
        piece: &Piece,
    ) -> Vec<EndDistance> {
        equations.distances(&self.member, piece, &self.evaluated)
    }

    /// The sign of det ∂R/∂y: that of the bordered matrix times that of ds, by Cramer's rule.
    pub(super) fn determinant(&self) -> i8 {
        let rate = self.parameter_rate();
        if rate.abs() <= f64::EPSILON {
            0
        } else if rate > 0.0 {
            self.orientation
        } else {
            -self.orientation
        }
    }
}

impl PieceEquations<'_> {
    /// The point of a piece near a guess, with the tangent that goes the way of `direction`; `None` where Newton's method does not
    /// settle.
    pub(super) fn correct(
        &self,
        piece: &Piece,
        guess: Vec<f64>,
        direction: &[f64],
        along: Along<'_>,
    ) -> Result<Option<PathState>, ProblemError> {
        let n = guess.len() - 1;
        let mut point = guess;
        let mut normal = match along {
            Along::Nearest => direction.to_vec(),
            Along::Plane(normal, _) => normal.to_vec(),
        };
        let mut last = f64::INFINITY;
        // Most steps of Newton's method; quadratic convergence from a good guess takes three to five.
        for steps in 1..=12 {
            let Some((member, evaluated)) = self.at(piece, &point)? else {
                return Ok(None);
            };
            let derivative = self.derivative(&member, piece, &point, &evaluated)?;
            let Some(lu) = derivative.and_then(|matrix| bordered(&matrix, &normal)) else {
                return Ok(None);
            };
            let off = match along {
                Along::Nearest => 0.0,
                Along::Plane(normal, value) => dot(normal, &point) - value,
            };
            let mut rhs: Vec<f64> = evaluated.residual.iter().map(|r| -r).collect();
            rhs.push(-off);
            rhs.extend(last_axis(n + 1));
            lu.solve(&mut rhs);
            let (step, kernel) = rhs.split_at(n + 1);
            let (length, reach) = (norm(step), 1.0 + norm(&point));
            if !length.is_finite() {
                return Ok(None);
            }
            let tangent = unit(kernel);
            add_scaled(&mut point, 1.0, step);
            // A step this short, relative to the point, leaves an error of its square: rounding.
            // Steps that no longer shrink are rounding below this size.
            let settled = length <= 1e-10 * reach || length <= 1e-7 * reach && length > 0.5 * last;
            if settled {
                let state = self
                    .at(piece, &point)?
                    .map(|(member, evaluated)| PathState {
                        orientation: orientation(&lu, &tangent, &normal),
                        point,
                        tangent,
                        steps,
                        member,
                        evaluated,
                    });
                return Ok(state.map(|state| state.turned_to(direction)));
            }
            if let Along::Nearest = along {
                let back = dot(&tangent, &normal) < 0.0;
                let same_way = |t: f64| if back { -t } else { t };
                normal = tangent.into_iter().map(same_way).collect();
            }
            last = length;
        }
        Ok(None)
    }

    /// The problem and the state of a piece at a point; `None` outside the range.
    pub(super) fn at(
        &self,
        piece: &Piece,
        point: &[f64],
    ) -> Result<Option<(Arc<FamilyMember>, EvaluatedPiece)>, ProblemError> {
        let (s, y) = point.split_last().expect("a point has a parameter");
        if !(-BEYOND..=1.0 + BEYOND).contains(s) {
            return Ok(None);
        }
        let member = self.family.member(s.clamp(0.0, 1.0))?;
        let evaluated = self.evaluate(&member, piece, y);
        Ok(evaluated.map(|evaluated| (member, evaluated)))
    }

    /// A point of a piece with its tangent, the point as it is; `None` where the tangent is not unique.
    pub(super) fn state_at(
        &self,
        piece: &Piece,
        point: &[f64],
        direction: &[f64],
    ) -> Result<Option<PathState>, ProblemError> {
        let n = point.len() - 1;
        let Some((member, evaluated)) = self.at(piece, point)? else {
            return Ok(None);
        };
        let Some(derivative) = self.derivative(&member, piece, point, &evaluated)? else {
            return Ok(None);
        };
        let along_parameter = last_axis(n + 1);
        for normal in [direction, &along_parameter, &scattered(n + 1)] {
            let Some(lu) = bordered(&derivative, normal) else {
                continue;
            };
            let mut kernel = last_axis(n + 1);
            lu.solve(&mut kernel);
            // A tangent this much longer than its projection is orthogonal to what it is projected on.
            if norm(&kernel) < 1e8 {
                let tangent = unit(&kernel);
                let state = PathState {
                    orientation: orientation(&lu, &tangent, normal),
                    point: point.to_vec(),
                    tangent,
                    steps: 0,
                    member,
                    evaluated,
                };
                return Ok(Some(state.turned_to(direction)));
            }
        }
        Ok(None)
    }

    /// The null vector of R' at a branch point that is orthogonal to the tangent, by inverse iteration.
    pub(super) fn second_null_vector(
        &self,
        piece: &Piece,
        place: &PathState,
    ) -> Result<Option<Vec<f64>>, ProblemError> {
        let derivative = self.derivative(&place.member, piece, &place.point, &place.evaluated)?;
        let Some(lu) = derivative.and_then(|derivative| bordered(&derivative, &place.tangent))
        else {
            return Ok(None);
        };
        let mut vector = scattered(place.point.len());
        for _ in 0..3 {
            lu.solve(&mut vector);
            vector = unit(&vector);
        }
        Ok(vector.iter().all(|v| v.is_finite()).then_some(vector))
    }
}

/// The unit vector of the last of n components, that of the parameter.
pub(super) fn last_axis(n: usize) -> Vec<f64> {
    let mut axis = vec![0.0; n];
    axis[n - 1] = 1.0;
    axis
}

pub(super) fn unit(vector: &[f64]) -> Vec<f64> {
    let length = norm(vector);
    vector.iter().map(|v| v / length).collect()
}

/// The sign of det [R'; t] from a factor of [R'; n]: det [R'; n] = (nᵀt) det [R'; t].
fn orientation(lu: &DenseLu, tangent: &[f64], normal: &[f64]) -> i8 {
    if dot(tangent, normal) < 0.0 {
        -lu.sign
    } else {
        lu.sign
    }
}

/// A direction that no problem prefers: signs and sizes from a linear congruence, the same on every machine.
pub(super) fn scattered(n: usize) -> Vec<f64> {
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    let entries = (0..n).map(|_| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    });
    unit(&entries.collect::<Vec<f64>>())
}

/// The n × (n + 1) derivative of the equations of a path with a last row c: column-major, factorised.
pub(super) fn bordered(derivative: &[f64], constraint: &[f64]) -> Option<DenseLu> {
    let order = constraint.len();
    let mut matrix = vec![0.0; order * order];
    let columns = matrix.chunks_exact_mut(order).zip(constraint);
    for ((to, last), from) in columns.zip(derivative.chunks_exact(order - 1)) {
        to[..order - 1].copy_from_slice(from);
        to[order - 1] = *last;
    }
    DenseLu::new(&matrix, order)
}

impl PieceEquations<'_> {
    /// The spectral radius of Ψ' at a solution; `None` where the minimisation with frozen friction is singular there.
    pub(super) fn spectral_radius(&self, piece: &Piece, state: &PathState) -> Option<f64> {
        let n = state.member.dual.layout.n_multipliers();
        let derivative = |friction| {
            let mut matrix = vec![0.0; n * n];
            for (j, column) in matrix.chunks_exact_mut(n).enumerate() {
                self.column(&state.member, piece, &state.evaluated, j, friction, column);
            }
            matrix
        };
        contraction_of_mapping(
            &derivative(FrictionTreatment::Frozen),
            &derivative(FrictionTreatment::Followed),
            n,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::bordered;

    #[test]
    fn one_equation_and_its_border() {
        // One equation x + 2 y, bordered by (2, −1).
        let lu = bordered(&[1.0, 2.0], &[2.0, -1.0]).unwrap();
        assert_eq!(lu.sign, -1);
    }
}
