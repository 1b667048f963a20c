//! Paths of solutions in a parameter of a scene, and all solutions at one value of it.
//!
//! The solutions of a contact problem with Coulomb friction need not be unique, and where a key of the scene changes they form
//! paths that turn back at folds, break at kinks where panes change their zones, and may branch.
//! [`Branches::follow`] follows them by piecewise-smooth continuation:
//!
//! | step | algorithm | source |
//! |---|---|---|
//! | equations | on each piece, given by the zones of all panes and the segments of the law, R(λ, γ) = 0 is smooth and continued beyond its ends | — |
//! | tangent | R' bordered by the last tangent, dense LU | E. Allgower, K. Georg, *Introduction to Numerical Continuation Methods*, SIAM 2003 |
//! | corrector | Newton's method with the Moore–Penrose inverse | A. Dhooge, W. Govaerts, Yu. Kuznetsov, *ACM Trans. Math. Softw.* 29 (2003) 141 |
//! | kinks | the end of the piece is located, and the half paths of all pieces that meet there are sought | T. Ligurský, Y. Renard, *Comput. Methods Appl. Mech. Eng.* 280 (2014) 222; *Comput. Mech.* 56 (2015) 39 |
//! | folds, branch points | signs of the parameter's rate and of the bordered determinant | the same |
//!
//! Lengths of steps are measured by ‖λ‖²/Λ² + s², where Λ is the size of the stresses of the glued face and s runs from 0 to 1
//! over the range; so no unit matters.

mod corrector;
mod equations;
mod family;
mod kink;
mod law_piece;
mod locate;
mod path;
mod piece;
mod point;
mod search;
mod slip_stress;

pub use family::{Family, ParameterRange, SceneAt};
pub use path::PathEnd;
pub use piece::Switch;
pub use point::{PathOrigin, PathPoint, PointKind};

use serde::{Deserialize, Serialize};

use self::{
    equations::PieceEquations,
    kink::HalfPath,
    path::PathFront,
    piece::Open,
    point::FrontRecord,
    search::{SAME, rays_from, solver_rays},
};
use contact3d::{
    ProblemError,
    linalg::{add_scaled, difference, norm},
    scene::InvalidValue,
};

/// A path of solutions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Path {
    /// Where it begins.
    pub origin: PathOrigin,
    /// Its points, one after the other.
    pub points: Vec<PathPoint>,
    /// Why it ends; `None` while it is followed.
    pub end: Option<PathEnd>,
}

/// The paths of a family, as far as they have been followed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Branches {
    /// The key and its range.
    pub range: ParameterRange,
    /// The paths.
    pub paths: Vec<Path>,
    /// Whether solutions were searched for at both ends of the range.
    pub all: bool,
    /// The size of stresses Λ in Pa.
    pub stress: f64,
    /// Half paths that were not followed, since there are so many.
    pub left_out: usize,
    /// What is still to be done; `None` when all is.
    pub pending: Option<Pending>,
}

/// What is still to be done.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Pending {
    /// The path that is being followed.
    current: Option<(FrontRecord, [Vec<f64>; 2])>,
    open: Open,
    stage: SearchStage,
}

/// What is searched for when no path is left to follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
enum SearchStage {
    #[default]
    Solver,
    End,
    Start,
    /// Again, from other starts and at other values of the parameter, while the signs at an end do not add up to 1.
    Again(usize),
    Done,
}

/// Values of the parameter inside the range at which solutions are searched for where some are missing at its ends, one in each round.
const ELSEWHERE: [f64; 4] = [0.5, 0.25, 0.75, 0.9];

impl Branches {
    /// Nothing followed yet.
    ///
    /// # Errors
    /// A value in the range that no problem can have.
    pub fn new(family: &Family<'_>, all: bool) -> Result<Self, ProblemError> {
        Ok(Self {
            range: family.range().clone(),
            all,
            stress: family.stress()?,
            pending: Some(Pending::default()),
            ..Self::default()
        })
    }

    /// Follows all paths to their ends, from where they stand; `observe` sees every new point.
    ///
    /// # Errors
    /// A value in the range that no problem can have, and a record that does not fit the problem.
    pub fn follow(
        &mut self,
        family: &Family<'_>,
        observe: &mut dyn FnMut(&Self),
    ) -> Result<(), ProblemError> {
        let equations = PieceEquations::new(family)?;
        while let Some(pending) = &mut self.pending {
            if let Some((record, start)) = pending.current.take() {
                self.follow_one(&equations, &record, start, observe)?;
            } else if !pending.open.rays.is_empty() && !is_large(&self.paths) {
                let record = pending.open.rays.remove(0);
                if !self.reaches(&record) {
                    self.begin(&equations, record)?;
                    observe(self);
                }
            } else {
                observe(self);
                self.next_stage(&equations)?;
            }
        }
        Ok(())
    }

    /// Half paths that wait to be followed; `None` while solutions are searched for.
    #[must_use]
    pub fn n_waiting(&self) -> Option<usize> {
        let pending = self.pending.as_ref()?;
        let is_followed = pending.current.is_some() || !pending.open.rays.is_empty();
        is_followed.then_some(pending.open.rays.len())
    }

    /// Whether a path has come to a solution that was searched for since.
    fn reaches(&self, record: &FrontRecord) -> bool {
        let (parameter, multiplier) = record.solution(&self.range, self.stress);
        let is_end = parameter == self.range.from || parameter == self.range.to;
        let solutions = self.end_solutions(parameter);
        let mut points = solutions.iter().map(|at| at.point);
        record.origin == PathOrigin::Search
            && is_end
            && points.any(|point| self.is_same(&point.multiplier, &multiplier))
    }

    /// Begins a path.
    fn begin(
        &mut self,
        equations: &PieceEquations<'_>,
        record: FrontRecord,
    ) -> Result<(), ProblemError> {
        let PathFront { state, piece, .. } = restored(&record, equations)?;
        let first = equations.describe(&piece, &state, PointKind::Start, Vec::new())?;
        self.paths.push(Path {
            origin: record.origin,
            points: vec![first],
            end: None,
        });
        let pending = self.pending.get_or_insert_default();
        pending.current = Some((record, [state.point, state.tangent]));
        Ok(())
    }

    /// Follows the last path from its front to its end.
    fn follow_one(
        &mut self,
        equations: &PieceEquations<'_>,
        record: &FrontRecord,
        start: [Vec<f64>; 2],
        observe: &mut dyn FnMut(&Self),
    ) -> Result<(), ProblemError> {
        let front = restored(record, equations)?;
        let mut open = self.pending.get_or_insert_default().open.clone();
        let done = self.paths.last().map_or(0, |path| path.points.len());
        let origin = record.origin;
        let mut see =
            |points: &[PathPoint], front: &PathFront, open: &Open, end: Option<PathEnd>| {
                let path = self.paths.last_mut().expect("a path is followed");
                path.points.extend_from_slice(points);
                path.end = end;
                let pending = self.pending.get_or_insert_default();
                let record = FrontRecord::of(origin, &front.state, &front.piece, front.step);
                pending.current = end.is_none().then(|| (record, start.clone()));
                if end.is_some() || pending.open.branch_points.len() != open.branch_points.len() {
                    pending.open = open.clone();
                }
                observe(self);
            };
        let end = equations.follow(front, &start, done, &mut open, &mut see)?;
        self.paths.last_mut().expect("a path is followed").end = Some(end);
        let pending = self.pending.get_or_insert_default();
        pending.current = None;
        pending.open = open;
        Ok(())
    }

    /// Looks for new starts when all known paths have been followed.
    fn next_stage(&mut self, equations: &PieceEquations<'_>) -> Result<(), ProblemError> {
        let stage = self.pending.as_ref().map_or(SearchStage::Done, |p| p.stage);
        let too_many = is_large(&self.paths);
        self.left_out = self.pending.as_ref().map_or(0, |p| p.open.rays.len());
        let mut rays = Vec::new();
        let next = match stage {
            SearchStage::Done => {
                self.pending = None;
                return Ok(());
            }
            _ if too_many => SearchStage::Done,
            SearchStage::Solver => {
                rays = solver_rays(equations)?;
                if self.all {
                    SearchStage::End
                } else {
                    SearchStage::Done
                }
            }
            SearchStage::End => {
                rays = self.searched(equations, 1.0, 0)?;
                SearchStage::Start
            }
            SearchStage::Start => {
                rays = self.searched(equations, 0.0, 0)?;
                SearchStage::Again(0)
            }
            SearchStage::Again(round) if self.lacks() && round < ELSEWHERE.len() => {
                for s in [1.0, 0.0, ELSEWHERE[round]] {
                    rays.extend(self.searched(equations, s, round + 1)?);
                }
                SearchStage::Again(round + 1)
            }
            SearchStage::Again(_) => SearchStage::Done,
        };
        let origin = match stage {
            SearchStage::Solver => PathOrigin::Solver,
            _ => PathOrigin::Search,
        };
        let pending = self.pending.get_or_insert_default();
        pending.stage = next;
        let records = rays.iter().map(|ray| ray.record(origin));
        pending.open.rays.extend(records);
        Ok(())
    }

    /// Starts at solutions at s that no path reaches.
    fn searched(
        &self,
        equations: &PieceEquations<'_>,
        s: f64,
        round: usize,
    ) -> Result<Vec<HalfPath>, ProblemError> {
        let value = self.range.value(s);
        let known = self.end_solutions(value).into_iter().map(|at| {
            let scaled = at.point.multiplier.iter().map(|l| l / self.stress);
            scaled.chain([s]).collect()
        });
        let known: Vec<Vec<f64>> = known.collect();
        let mut rays = Vec::new();
        for point in equations.solutions_at(s, &known, round)? {
            let near = |other: &Vec<f64>| norm(&difference(other, &point)) <= SAME;
            if known.iter().any(near) {
                continue;
            }
            let both = rays_from(equations, &point)?.into_iter();
            if s == 0.0 || s == 1.0 {
                rays.extend(both.take(1));
            } else if !self.passes(value, &equations.multiplier(&point)) {
                rays.extend(both);
            }
        }
        Ok(rays)
    }

    /// Whether a path comes by a solution at a value inside the range, as near as a chord is to its arc.
    fn passes(&self, value: f64, multiplier: &[f64]) -> bool {
        let mut steps = self.paths.iter().flat_map(|path| path.points.windows(2));
        steps.any(|ends| {
            let [a, b] = [&ends[0], &ends[1]];
            let share = (value - a.parameter) / (b.parameter - a.parameter);
            let chord = difference(&b.multiplier, &a.multiplier);
            let mut offset = difference(multiplier, &a.multiplier);
            add_scaled(&mut offset, -share, &chord);
            // How far an arc is from its chord at most, over the chord's length: tangents of a step make an angle of cosine 0.9 at most.
            (0.0..=1.0).contains(&share)
                && norm(&offset) <= 0.25 * norm(&chord) + SAME * self.stress
        })
    }

    /// Whether the signs of det R' over the solutions that were searched for at an end of the range do not add up to 1: then one is missing
    /// or not regular. That they do is necessary and proves nothing.
    #[must_use]
    pub fn lacks(&self) -> bool {
        let ends = [self.range.from, self.range.to];
        self.all && ends.into_iter().any(|end| self.degree(end) != 1)
    }

    /// Whether every path has an end that says where it leads.
    #[must_use]
    pub fn is_followed(&self) -> bool {
        let known = |end: PathEnd| match end {
            PathEnd::Range | PathEnd::Closed | PathEnd::KnownPoint | PathEnd::Degenerate => true,
            PathEnd::Stuck | PathEnd::Uncertified | PathEnd::TooLong => false,
        };
        self.pending.is_none()
            && self.left_out == 0
            && self.paths.iter().all(|path| path.end.is_some_and(known))
    }
}

/// Whether no more paths are begun.
fn is_large(paths: &[Path]) -> bool {
    let points = paths.iter().map(|path| path.points.len()).sum::<usize>();
    // Most paths that are begun, and most points after which no more are.
    paths.len() >= 100 || points >= 20_000
}

fn restored(
    record: &FrontRecord,
    equations: &PieceEquations<'_>,
) -> Result<PathFront, ProblemError> {
    record.front(equations)?.ok_or_else(|| {
        InvalidValue {
            key: "branches".into(),
            expected: "a stored front of this problem".into(),
            found: "one of another".into(),
            help: "remove the group /branches, or use another file".into(),
        }
        .into()
    })
}

/// A solution at one end of the range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndSolution<'a> {
    /// The number of its path.
    pub path: usize,
    /// Its number on the path.
    pub number: usize,
    /// What is known of it.
    pub point: &'a PathPoint,
}

impl Branches {
    /// Whether two multipliers in Pa are one.
    fn is_same(&self, first: &[f64], second: &[f64]) -> bool {
        norm(&difference(first, second)) <= SAME * self.stress
    }

    /// The different solutions at one end of the range, by its parameter.
    #[must_use]
    pub fn end_solutions(&self, parameter: f64) -> Vec<EndSolution<'_>> {
        let mut found: Vec<EndSolution<'_>> = Vec::new();
        for (path, followed) in self.paths.iter().enumerate() {
            for (number, point) in followed.points.iter().enumerate() {
                let known = |other: &EndSolution<'_>| {
                    self.is_same(&other.point.multiplier, &point.multiplier)
                };
                if point.parameter == parameter && !found.iter().any(known) {
                    found.push(EndSolution {
                        path,
                        number,
                        point,
                    });
                }
            }
        }
        found
    }

    /// Σ sign det R' over the solutions at one end of the range, which is 1 where none is missing and all are regular.
    #[must_use]
    pub fn degree(&self, parameter: f64) -> i32 {
        let solutions = self.end_solutions(parameter);
        let signs = solutions.iter().map(|at| at.point.determinant);
        signs.map(i32::from).sum()
    }
}
