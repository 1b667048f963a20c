//! One path: steps that are exact where the piece is linear, kinks, folds, and the choice of the step.

use super::{
    corrector::{Along, PathState, last_axis},
    equations::PieceEquations,
    kink::HalfPath,
    locate::{CROSSED, Chord, LOCATED, OFF},
    piece::{EndDistance, Open, Piece, Switch},
    point::{PathPoint, PointKind},
};
use contact3d::{
    ProblemError,
    linalg::{add_scaled, difference, dot, norm},
};

/// Steps in the norm ‖λ‖²/Λ² + s²: the first one, the smallest, the largest relative to 1 + ‖λ‖/Λ. All solutions lie in the ball
/// λᵀSλ ≤ λᵀh, so paths do not run to infinity.
const FIRST_STEP: f64 = 1e-3;
const SMALLEST_STEP: f64 = 1e-8;
const LARGEST_STEP: f64 = 0.1;

/// A step grows by this after fewer corrections than `FEW`, and shrinks by `SHRINK` after a failure (GetFEM's rule).
const STEP_GROWTH: f64 = 1.3;
const SHRINK: f64 = 0.5;
const FEW: usize = 5;

/// Least cosine of the tangents of both ends of a step, with each other and with its chord.
pub(super) const STRAIGHT: f64 = 0.9;

/// A path that comes this near to a known point in its direction has come back to it.
pub(super) const RETURNED: f64 = 1e-5;

/// A certified point has at most this residual of the natural map, measured by local stiffness.
const CERTIFIED: f64 = 1e-8;

/// Why a path ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathEnd {
    /// At an end of the range.
    Range,
    /// At its own start.
    Closed,
    /// At a branch point from which this path has been followed already.
    KnownPoint,
    /// No half path leaves the point, or the equations have no direction there: so many panes change at once that no piece can
    /// be told.
    Degenerate,
    /// Newton's method does not settle at the smallest step.
    Stuck,
    /// A point that the solver's own natural map does not certify.
    Uncertified,
    /// It has more points than are followed.
    TooLong,
}

impl PathEnd {
    /// Whether the path may go on, but was not followed further.
    #[must_use]
    pub fn is_early(self) -> bool {
        matches!(self, Self::Stuck | Self::Uncertified | Self::TooLong)
    }
}

impl PieceEquations<'_> {
    /// Follows a half path to its end. Branch points put their other half paths into `open`.
    pub(super) fn follow(
        &self,
        mut front: HalfPath,
        open: &mut Open,
        observe: &mut dyn FnMut(Vec<PathPoint>, &Open),
    ) -> Result<PathEnd, ProblemError> {
        let start = [front.state.point.clone(), front.state.tangent.clone()];
        let mut length = FIRST_STEP;
        // Most points of one path.
        for _ in 1..5_000 {
            let (points, end) = match self.advance(&front, length)? {
                Advance::Nothing => {
                    length *= SHRINK;
                    if length < SMALLEST_STEP {
                        return Ok(PathEnd::Stuck);
                    }
                    continue;
                }
                Advance::Point(state, at_range_end) => {
                    let returned = !at_range_end && passes(&front.state, &state, &start);
                    let kind = if at_range_end || returned {
                        PointKind::End
                    } else {
                        PointKind::Regular
                    };
                    let point = self.describe(&front.piece, &state, kind, Vec::new())?;
                    let is_certified = self.is_certified(&point, &state);
                    // A shorter step starts nearer and settles better.
                    if !(is_certified || at_range_end) && length * SHRINK >= SMALLEST_STEP {
                        length *= SHRINK;
                        continue;
                    }
                    let (mut points, known) = self.turning_points(&front, &state, open)?;
                    if known.is_none() {
                        let reach = norm(&state.point);
                        if state.steps < FEW {
                            length = (STEP_GROWTH * length).min(LARGEST_STEP * (1.0 + reach));
                        }
                        front.state = state;
                        points.push(point);
                    }
                    let end = known.or(match (is_certified, at_range_end, returned) {
                        (false, ..) => Some(PathEnd::Uncertified),
                        (true, true, _) => Some(PathEnd::Range),
                        (true, false, true) => Some(PathEnd::Closed),
                        (true, false, false) => None,
                    });
                    (points, end)
                }
                Advance::PieceEnd(state, reached) => {
                    match self.turning_points(&front, &state, open)? {
                        (points, None) => {
                            length = length.min(FIRST_STEP);
                            self.pass(&mut front, state, reached, points, open)?
                        }
                        known => known,
                    }
                }
            };
            observe(points, open);
            if let Some(end) = end {
                return Ok(end);
            }
        }
        Ok(PathEnd::TooLong)
    }

    /// Whether a point solves the problem as the solvers measure it: to `CERTIFIED`, or to what rounding of S λ leaves where large
    /// coefficients of friction multiply it.
    fn is_certified(&self, point: &PathPoint, state: &PathState) -> bool {
        // As many times the estimate of rounding count as rounding.
        point.residual <= CERTIFIED.max(10.0 * self.rounding(&state.member, &state.evaluated))
    }

    /// The folds and branch points between the front and the next point of its piece, and the end of the path where one is a branch
    /// point that was known, beyond which all has been or will be followed.
    fn turning_points(
        &self,
        front: &HalfPath,
        to: &PathState,
        open: &mut Open,
    ) -> Result<(Vec<PathPoint>, Option<PathEnd>), ProblemError> {
        let mut points = Vec::new();
        let step = Chord {
            equations: self,
            piece: &front.piece,
            from: &front.state,
            to,
        };
        let rates = [front.state.parameter_rate(), to.parameter_rate()];
        // Rates of the parameter below this are those of a path that stands upright, and no fold.
        let turns = rates[0] * rates[1] < 0.0 && rates.iter().all(|rate| rate.abs() > 1e-9);
        if turns && let Some(fold) = step.fold()? {
            points.push(self.describe(&front.piece, &fold, PointKind::Fold, Vec::new())?);
        }
        let crosses = front.state.orientation != to.orientation;
        if crosses && let Some(place) = step.branch_point()? {
            let kind = PointKind::BranchPoint;
            points.push(self.describe(&front.piece, &place, kind, Vec::new())?);
            if open.knows(&place.point) {
                open.leave_out(&place, 2.0 * OFF[0]);
                return Ok((points, Some(PathEnd::KnownPoint)));
            }
            open.branch_points.push(place.point.clone());
            open.keep(self.crossing(&front.piece, &place)?);
        }
        Ok((points, None))
    }

    /// Goes from one piece to the next: the points up to there, and the end of the path where there is none.
    fn pass(
        &self,
        front: &mut HalfPath,
        state: PathState,
        reached: Vec<EndDistance>,
        mut points: Vec<PathPoint>,
        open: &mut Open,
    ) -> Result<(Vec<PathPoint>, Option<PathEnd>), ProblemError> {
        let mut switches: Vec<Switch> = Vec::new();
        for distance in &reached {
            if !switches.contains(&distance.switch) {
                switches.push(distance.switch);
            }
        }
        let mut rays = self.rays(&front.piece, &state, &reached)?;
        let came = |ray: &HalfPath| dot(&ray.state.tangent, &state.tangent);
        rays.retain(|ray| !ray.leads_back(&front.piece, &state.tangent));
        rays.sort_by(|a, b| came(a).total_cmp(&came(b)));
        let next = rays.pop();
        let is_branch_point = !rays.is_empty();
        let kind = match &next {
            None => PointKind::End,
            Some(_) if is_branch_point => PointKind::BranchPoint,
            Some(next) if next.state.parameter_rate() * state.parameter_rate() < 0.0 => {
                PointKind::KinkFold
            }
            Some(_) => PointKind::Kink,
        };
        let point = self.describe(&front.piece, &state, kind, switches)?;
        let is_certified = self.is_certified(&point, &state);
        points.push(point);
        let Some(next) = next else {
            front.state = state;
            return Ok((points, Some(PathEnd::Degenerate)));
        };
        let known = is_branch_point && open.knows(&state.point);
        if is_branch_point && !known {
            open.branch_points.push(state.point.clone());
            open.keep(rays);
        } else if known {
            // The half path that comes in here is one of those still to be followed from here.
            open.leave_out(&state, RETURNED);
        }
        *front = next;
        let end = match (is_certified, known) {
            (false, _) => Some(PathEnd::Uncertified),
            (true, true) => Some(PathEnd::KnownPoint),
            (true, false) => None,
        };
        Ok((points, end))
    }
}

/// Whether a step passes a point in its direction.
fn passes(from: &PathState, to: &PathState, [point, tangent]: &[Vec<f64>; 2]) -> bool {
    let chord = difference(&to.point, &from.point);
    let offset = difference(point, &from.point);
    let along = dot(&offset, &chord) / dot(&chord, &chord);
    let mut off = offset;
    add_scaled(&mut off, -along, &chord);
    // A start nearer than this share of a step is the one that the path has just left.
    (1e-9..=1.0).contains(&along)
        && norm(&off) < 0.1 * norm(&chord)
        && dot(&to.tangent, tangent) > STRAIGHT
}

/// What a step came to.
pub(super) enum Advance {
    /// A point of the same piece, and whether it is the end of the range.
    Point(PathState, bool),
    /// An end of the piece, with what ends there.
    PieceEnd(PathState, Vec<EndDistance>),
    /// Nothing; a smaller step may do.
    Nothing,
}

impl PieceEquations<'_> {
    /// One step of a length, cut at the end of the range and at the first end of the piece.
    fn advance(&self, front: &HalfPath, length: f64) -> Result<Advance, ProblemError> {
        let (from, piece) = (&front.state, &front.piece);
        let mut guess = from.point.clone();
        add_scaled(&mut guess, length, &from.tangent);
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
        let gone = norm(&chord);
        let bent = dot(&state.tangent, &from.tangent) < STRAIGHT
            || dot(&chord, &from.tangent) < STRAIGHT * gone
            || dot(&chord, &state.tangent) < STRAIGHT * gone;
        // A step to another path may turn the orientation, too; a short one that does has passed a branch point.
        // Steps across a branch point are no longer than this.
        let turned = state.orientation != from.orientation && length > 1e-4;
        // A corrected point may lie this many steps from the last one.
        if bent || turned || gone > 2.0 * length {
            return Ok(Advance::Nothing);
        }
        if !self.crosses(piece, from, &state) {
            return Ok(Advance::Point(state, at_end));
        }
        let step = Chord {
            equations: self,
            piece,
            from,
            to: &state,
        };
        let found = step.first_end()?;
        // A path that leaves a kink leads into its piece; an end that a step finds at once lies beyond a turn it has missed.
        // A piece does not end within this share of a step; shorter steps tell.
        let moves =
            |state: &PathState| norm(&difference(&state.point, &from.point)) > 1e-3 * length;
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
    fn ahead(&self, front: &HalfPath, guess: Vec<f64>) -> Result<Option<PathState>, ProblemError> {
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
        front: &HalfPath,
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
        let pairs = from.iter().zip(to);
        let mut guess: Vec<f64> = pairs.map(|(a, b)| a + share * (b - a)).collect();
        guess[last] = end;
        let normal = last_axis(from.len());
        let along = Along::Plane(&normal, end);
        self.correct(&front.piece, guess, &front.state.tangent, along)
    }
}
