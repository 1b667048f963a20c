//! One path: predictor, corrector, kinks, folds, and the choice of the step.

use serde::{Deserialize, Serialize};

use super::{
    corrector::{Along, PathState},
    equations::Equations,
    kink::Ray,
    locate::{CROSSED, Step},
    piece::{Beyond, Distance, Piece, Switch},
    point::{PathPoint, PointKind},
    record::{FrontRecord, PathOrigin},
};
use crate::{
    linalg::{add_scaled, difference, dot, norm},
    problem::ProblemError,
};

/// Steps in the norm ‖λ‖²/Λ² + s²: the first one, the smallest, the largest relative to 1 + ‖λ‖/Λ. All solutions lie in the ball
/// λᵀSλ ≤ λᵀh, so paths do not run to infinity.
pub(super) const FIRST_STEP: f64 = 1e-3;
const SMALLEST_STEP: f64 = 1e-8;
const LARGEST_STEP: f64 = 0.1;

/// A step grows by this after fewer corrections than `FEW`, and shrinks by `SHRINK` after a failure (GetFEM's rule).
const GROWTH: f64 = 1.3;
const SHRINK: f64 = 0.5;
const FEW: usize = 5;

/// A piece does not end within this share of a step; shorter steps tell.
const STILL: f64 = 1e-3;

/// Least cosine of the tangents of both ends of a step, with each other and with its chord.
const STRAIGHT: f64 = 0.9;

/// Steps across a branch point are no longer than this.
const SURE_STEP: f64 = 1e-4;

/// A corrected point may lie this many steps from the last one.
const NEAR: f64 = 2.0;

/// A path that comes this near to a known point in its direction has come back to it.
const RETURNED: f64 = 1e-5;

/// A start nearer than this share of a step is the one that the path has just left.
const BEHIND: f64 = 1e-9;

/// Rates of the parameter below this are those of a path that stands upright, and no fold.
const UPRIGHT: f64 = 1e-9;

/// How far from a branch point on a smooth piece the crossing path is sought.
const OFF: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// Most changes of the law's signs at a point off a branch point.
const MOST_TURNS: usize = 3;

/// Most points of one path.
const MOST_POINTS: usize = 5_000;

/// A certified point has at most this residual of the natural map, measured by local stiffness.
const CERTIFIED: f64 = 1e-8;

/// As many times the estimate of rounding count as rounding.
const SEVERAL: f64 = 10.0;

/// Why a path ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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

/// Where a path stands: the next step depends on nothing else.
pub(super) struct Front {
    pub(super) state: PathState,
    pub(super) piece: Piece,
    pub(super) step: f64,
}

/// What a step came to.
enum Advance {
    /// A point of the same piece.
    Point(PathState),
    /// The end of the range.
    RangeEnd(PathState),
    /// An end of the piece, with what ends there.
    PieceEnd(PathState, Vec<Distance>),
    /// Nothing; a smaller step may do.
    Nothing,
}

/// What sees the new points of every step, with the front behind them, what is still open, and why the path ends there.
pub(super) type Observer<'o> = dyn FnMut(&[PathPoint], &Front, &Open, Option<PathEnd>) + 'o;

/// Half paths that are still to be followed, and branch points that are known.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Open {
    pub(super) rays: Vec<FrontRecord>,
    pub(super) branch_points: Vec<Vec<f64>>,
}

impl Equations<'_> {
    /// Follows a path from its front to its end; `start` is where it began and its tangent there, `done` the number of its points so far.
    /// Branch points put their other half paths into `open`.
    pub(super) fn follow(
        &self,
        mut front: Front,
        start: &[Vec<f64>; 2],
        done: usize,
        open: &mut Open,
        observe: &mut Observer<'_>,
    ) -> Result<PathEnd, ProblemError> {
        for _ in done..MOST_POINTS {
            match self.advance(&front)? {
                Advance::Nothing => {
                    front.step *= SHRINK;
                    if front.step < SMALLEST_STEP {
                        return Ok(PathEnd::Stuck);
                    }
                }
                Advance::RangeEnd(state) => {
                    let (mut points, known) = self.turning_points(&front, &state, open)?;
                    if known {
                        let end = PathEnd::KnownPoint;
                        observe(&points, &front, open, Some(end));
                        return Ok(end);
                    }
                    let point = self.describe(&front.piece, &state, PointKind::End, Vec::new())?;
                    let is_certified = self.is_certified(&point, &state);
                    front.state = state;
                    points.push(point);
                    let end = match is_certified {
                        true => PathEnd::Range,
                        false => PathEnd::Uncertified,
                    };
                    observe(&points, &front, open, Some(end));
                    return Ok(end);
                }
                Advance::Point(state) => {
                    let (mut points, known) = self.turning_points(&front, &state, open)?;
                    if known {
                        let end = PathEnd::KnownPoint;
                        observe(&points, &front, open, Some(end));
                        return Ok(end);
                    }
                    let returned = passes(&front.state, &state, start);
                    let reach = norm(&state.point);
                    if state.steps < FEW {
                        front.step = (GROWTH * front.step).min(LARGEST_STEP * (1.0 + reach));
                    }
                    front.state = state;
                    let kind = match returned {
                        true => PointKind::End,
                        false => PointKind::Regular,
                    };
                    let point = self.describe(&front.piece, &front.state, kind, Vec::new())?;
                    let is_certified = self.is_certified(&point, &front.state);
                    points.push(point);
                    let end = match (is_certified, returned) {
                        (false, _) => Some(PathEnd::Uncertified),
                        (true, true) => Some(PathEnd::Closed),
                        (true, false) => None,
                    };
                    observe(&points, &front, open, end);
                    if let Some(end) = end {
                        return Ok(end);
                    }
                }
                Advance::PieceEnd(state, reached) => {
                    let (points, known) = self.turning_points(&front, &state, open)?;
                    if known {
                        let end = PathEnd::KnownPoint;
                        observe(&points, &front, open, Some(end));
                        return Ok(end);
                    }
                    if let Some(end) =
                        self.pass(&mut front, state, reached, points, open, observe)?
                    {
                        return Ok(end);
                    }
                }
            }
        }
        Ok(PathEnd::TooLong)
    }

    /// Whether a point solves the problem as the solvers measure it: to `CERTIFIED`, or to what rounding of S λ leaves where large
    /// coefficients of friction multiply it.
    fn is_certified(&self, point: &PathPoint, state: &PathState) -> bool {
        point.residual <= CERTIFIED.max(SEVERAL * self.rounding(&state.member, &state.evaluated))
    }

    /// One step of the front's length, cut at the end of the range and at the first end of the piece.
    fn advance(&self, front: &Front) -> Result<Advance, ProblemError> {
        let (from, piece) = (&front.state, &front.piece);
        let mut guess = from.point.clone();
        add_scaled(&mut guess, front.step, &from.tangent);
        let ahead = guess[guess.len() - 1];
        let leaves = !(0.0..=1.0).contains(&ahead);
        let corrected = match leaves {
            true => self.at_range_end(front, &from.point, &guess)?,
            false => self.correct(piece, guess, &from.tangent, Along::Nearest)?,
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
        let way = norm(&chord);
        let bent = dot(&state.tangent, &from.tangent) < STRAIGHT
            || dot(&chord, &from.tangent) < STRAIGHT * way
            || dot(&chord, &state.tangent) < STRAIGHT * way;
        // A step to another path may turn the orientation, too; a short one that does has passed a branch point.
        let turned = state.orientation != from.orientation && front.step > SURE_STEP;
        if bent || turned || way > NEAR * front.step {
            return Ok(Advance::Nothing);
        }
        let distances = state.distances(self, piece);
        if distances.iter().all(|distance| distance.value >= -CROSSED) {
            return Ok(match at_end {
                true => Advance::RangeEnd(state),
                false => Advance::Point(state),
            });
        }
        let step = Step {
            equations: self,
            piece,
            from,
            to: &state,
        };
        let found = step.first_end()?;
        // A path that leaves a kink leads into its piece; an end that a step finds at once lies beyond a turn it has missed.
        let moves =
            |state: &PathState| norm(&difference(&state.point, &from.point)) > STILL * front.step;
        Ok(match found.filter(|(state, _)| moves(state)) {
            Some((state, reached)) => Advance::PieceEnd(state, reached),
            None => Advance::Nothing,
        })
    }

    /// The point of a piece at the end of the range that lies between two points.
    fn at_range_end(
        &self,
        front: &Front,
        from: &[f64],
        to: &[f64],
    ) -> Result<Option<PathState>, ProblemError> {
        let last = from.len() - 1;
        let end = if to[last] > 1.0 { 1.0 } else { 0.0 };
        let way = to[last] - from[last];
        let share = if way == 0.0 {
            0.0
        } else {
            (end - from[last]) / way
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

    /// The folds and branch points between the front and the next point of its piece, and whether one is a branch point that was
    /// known, beyond which all has been or will be followed.
    fn turning_points(
        &self,
        front: &Front,
        to: &PathState,
        open: &mut Open,
    ) -> Result<(Vec<PathPoint>, bool), ProblemError> {
        let mut points = Vec::new();
        let step = Step {
            equations: self,
            piece: &front.piece,
            from: &front.state,
            to,
        };
        let rates = [front.state.parameter_rate(), to.parameter_rate()];
        let turns = rates[0] * rates[1] < 0.0 && rates.iter().all(|rate| rate.abs() > UPRIGHT);
        if turns && let Some(fold) = step.fold()? {
            points.push(self.describe(&front.piece, &fold, PointKind::Fold, Vec::new())?);
        }
        let crosses = front.state.orientation != to.orientation;
        if crosses && let Some(place) = step.branch_point()? {
            let kind = PointKind::BranchPoint;
            points.push(self.describe(&front.piece, &place, kind, Vec::new())?);
            if open.knows(&place.point) {
                open.rays.retain(|ray| !ray.arrives(&place, 2.0 * OFF[0]));
                return Ok((points, true));
            }
            open.branch_points.push(place.point.clone());
            open.keep(&self.crossing(&front.piece, &place)?);
        }
        Ok((points, false))
    }

    /// Goes from one piece to the next; the end of the path where there is none.
    fn pass(
        &self,
        front: &mut Front,
        state: PathState,
        reached: Vec<Distance>,
        mut points: Vec<PathPoint>,
        open: &mut Open,
        observe: &mut Observer<'_>,
    ) -> Result<Option<PathEnd>, ProblemError> {
        let mut switches: Vec<Switch> = Vec::new();
        for distance in &reached {
            if !switches.contains(&distance.switch) {
                switches.push(distance.switch);
            }
        }
        let mut rays = self.rays(&front.piece, &state, &reached)?;
        let came = |ray: &Ray| dot(&ray.state.tangent, &state.tangent);
        rays.retain(|ray| came(ray) > -1.0 + RETURNED);
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
            let end = Some(PathEnd::Degenerate);
            observe(&points, front, open, end);
            return Ok(end);
        };
        let known = is_branch_point && open.knows(&state.point);
        if is_branch_point && !known {
            open.branch_points.push(state.point.clone());
            open.keep(&rays);
        } else if known {
            // The half path that comes in here is one of those still to be followed from here.
            open.rays.retain(|ray| !ray.arrives(&state, RETURNED));
        }
        front.state = next.state;
        front.piece = next.piece;
        front.step = front.step.min(FIRST_STEP);
        let end = if !is_certified {
            Some(PathEnd::Uncertified)
        } else if known {
            Some(PathEnd::KnownPoint)
        } else {
            None
        };
        observe(&points, front, open, end);
        Ok(end)
    }

    /// The half paths that cross a path on one of its pieces: near the point, off the tangent along the second null vector of R'.
    fn crossing(&self, piece: &Piece, place: &PathState) -> Result<Vec<Ray>, ProblemError> {
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
                return Ok(Some(Ray { state, piece }));
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

impl Open {
    fn keep(&mut self, rays: &[Ray]) {
        let origin = PathOrigin::BranchPoint;
        let records = rays.iter().map(|ray| ray.record(origin, FIRST_STEP));
        self.rays.extend(records);
    }

    fn knows(&self, point: &[f64]) -> bool {
        let near = |known: &Vec<f64>| norm(&difference(known, point)) < RETURNED;
        self.branch_points.iter().any(near)
    }
}

/// Whether a step passes a point in its direction.
fn passes(from: &PathState, to: &PathState, [point, tangent]: &[Vec<f64>; 2]) -> bool {
    let chord = difference(&to.point, &from.point);
    let way = difference(point, &from.point);
    let along = dot(&way, &chord) / dot(&chord, &chord);
    let mut off = way;
    add_scaled(&mut off, -along, &chord);
    (BEHIND..=1.0).contains(&along)
        && norm(&off) < 0.1 * norm(&chord)
        && dot(&to.tangent, tangent) > STRAIGHT
}
