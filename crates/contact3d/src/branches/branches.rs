//! All paths of a family: starts, branches, solutions at both ends of the range.

use serde::{Deserialize, Serialize};

use super::{
    equations::Equations,
    family::Family,
    kink::Ray,
    open::Open,
    path::{FIRST_STEP, Front, PathEnd},
    point::{PathPoint, PointKind},
    range::ParameterRange,
    record::{FrontRecord, PathOrigin},
    search::SAME,
    starts::{rays_from, solver_rays},
};
use crate::{
    linalg::{difference, norm},
    problem::ProblemError,
    scene::Invalid,
};

/// Most paths that are begun, and most points after which no more are.
const MOST_PATHS: usize = 100;
const MOST_POINTS: usize = 20_000;

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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Branches {
    /// The key and its range.
    pub range: ParameterRange,
    /// The paths.
    pub paths: Vec<Path>,
    /// Whether solutions were searched for at both ends of the range.
    pub all: bool,
    /// Whether every state of the panes was tried at both ends, so that no solution there is missing.
    pub is_enumerated: bool,
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
    stage: Stage,
}

/// What is searched for when no path is left to follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
enum Stage {
    #[default]
    Solver,
    End,
    Start,
    Done,
}

impl Branches {
    /// Nothing followed yet.
    ///
    /// # Errors
    /// A value in the range that no problem can have.
    pub fn new(family: &Family<'_>, all: bool) -> Result<Self, ProblemError> {
        Ok(Self {
            range: family.range().clone(),
            paths: Vec::new(),
            all,
            is_enumerated: false,
            stress: family.stress()?,
            left_out: 0,
            pending: Some(Pending::default()),
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
        let equations = Equations::new(family)?;
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
                self.next_stage(&equations)?;
            }
        }
        Ok(())
    }

    /// Whether a path has come to a solution that was searched for since.
    fn reaches(&self, record: &FrontRecord) -> bool {
        let (parameter, multiplier) = record.solution(&self.range, self.stress);
        let solutions = self.end_solutions(parameter).into_iter();
        let mut points = solutions.map(|at| &self.paths[at.path].points[at.point]);
        let near = |point: &PathPoint| {
            norm(&difference(&point.multiplier, &multiplier)) <= SAME * self.stress
        };
        record.origin == PathOrigin::Search && points.any(near)
    }

    /// Begins a path.
    fn begin(
        &mut self,
        equations: &Equations<'_>,
        record: FrontRecord,
    ) -> Result<(), ProblemError> {
        let Front { state, piece, .. } = restored(&record, equations)?;
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
        equations: &Equations<'_>,
        record: &FrontRecord,
        start: [Vec<f64>; 2],
        observe: &mut dyn FnMut(&Self),
    ) -> Result<(), ProblemError> {
        let front = restored(record, equations)?;
        let mut open = self.pending.get_or_insert_default().open.clone();
        let done = self.paths.last().map_or(0, |path| path.points.len());
        let origin = record.origin;
        let mut see = |points: &[PathPoint], front: &Front, open: &Open, end: Option<PathEnd>| {
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
    fn next_stage(&mut self, equations: &Equations<'_>) -> Result<(), ProblemError> {
        let stage = self.pending.as_ref().map_or(Stage::Done, |p| p.stage);
        let too_many = is_large(&self.paths);
        self.left_out = self.pending.as_ref().map_or(0, |p| p.open.rays.len());
        let (rays, origin, next) = match stage {
            _ if too_many => (Vec::new(), PathOrigin::Search, Stage::Done),
            Stage::Solver => {
                let next = if self.all { Stage::End } else { Stage::Done };
                (solver_rays(equations)?, PathOrigin::Solver, next)
            }
            Stage::End => {
                let (rays, enumerated) = self.searched(equations, 1.0)?;
                self.is_enumerated = enumerated;
                (rays, PathOrigin::Search, Stage::Start)
            }
            Stage::Start => {
                let (rays, enumerated) = self.searched(equations, 0.0)?;
                self.is_enumerated &= enumerated;
                (rays, PathOrigin::Search, Stage::Done)
            }
            Stage::Done => {
                self.pending = None;
                return Ok(());
            }
        };
        let pending = self.pending.get_or_insert_default();
        pending.stage = next;
        let records = rays.iter().map(|ray| ray.record(origin, FIRST_STEP));
        pending.open.rays.extend(records);
        Ok(())
    }

    /// Starts at solutions at one end of the range that no path reaches.
    fn searched(
        &self,
        equations: &Equations<'_>,
        s: f64,
    ) -> Result<(Vec<Ray>, bool), ProblemError> {
        let value = self.range.value(s);
        let known: Vec<Vec<f64>> = self
            .end_solutions(value)
            .into_iter()
            .map(|at| {
                let multiplier = &self.paths[at.path].points[at.point].multiplier;
                let scaled = multiplier.iter().map(|l| l / self.stress);
                scaled.chain([s]).collect()
            })
            .collect();
        let found = equations.solutions_at(s, &known)?;
        let mut rays = Vec::new();
        for point in found.points {
            let near = |other: &Vec<f64>| norm(&difference(other, &point)) <= SAME;
            if !known.iter().any(near) {
                rays.extend(rays_from(equations, &point)?.into_iter().next());
            }
        }
        Ok((rays, found.is_enumerated))
    }

    /// Whether every path has an end that says where it leads.
    #[must_use]
    pub fn is_complete(&self) -> bool {
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
    paths.len() >= MOST_PATHS || points >= MOST_POINTS
}

fn restored(record: &FrontRecord, equations: &Equations<'_>) -> Result<Front, ProblemError> {
    record.front(equations)?.ok_or_else(|| {
        Invalid {
            key: "branches".into(),
            expected: "a stored front of this problem".into(),
            found: "one of another".into(),
            help: "remove the group /branches, or use another file".into(),
        }
        .into()
    })
}
