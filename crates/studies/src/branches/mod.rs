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

pub use family::{Family, ParameterRange};
pub use path::PathEnd;
pub use piece::Switch;
pub use point::{PathOrigin, PathPoint, PointKind};

use self::{
    equations::PieceEquations,
    kink::HalfPath,
    piece::Open,
    search::{SAME, rays_from, solver_rays},
};
use contact3d::{
    ProblemError,
    linalg::{add_scaled, difference, norm},
};

/// A path of solutions.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Where it begins.
    pub origin: PathOrigin,
    /// Its points, one after the other.
    pub points: Vec<PathPoint>,
    /// Why it ends.
    pub end: PathEnd,
}

/// The paths of a family.
#[derive(Debug, Clone, Default, PartialEq)]
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
}

/// Values of the parameter inside the range at which solutions are searched for where some are missing at its ends, one in each round.
const EXTRA_PARAMETERS: [f64; 4] = [0.5, 0.25, 0.75, 0.9];

impl Branches {
    /// Follows the path of the solver's solution to its ends, and, where `all` are asked for, those of the solutions that are searched
    /// for at both ends of the range: once more, from other starts and at other values, while their signs do not add up to 1. `observe`
    /// sees the paths after every step, with the half paths that wait to be followed; `None` while solutions are searched for.
    ///
    /// # Errors
    /// A value in the range that no problem can have.
    pub fn follow(
        family: &Family<'_>,
        all: bool,
        observe: &mut dyn FnMut(&Branches, Option<usize>),
    ) -> Result<Self, ProblemError> {
        let equations = PieceEquations::new(family)?;
        let mut found = Self {
            range: family.range.clone(),
            all,
            stress: equations.stress,
            ..Self::default()
        };
        let mut open = Open::default();
        observe(&found, None);
        let rays = solver_rays(&equations)?;
        found.follow_rays(&equations, (PathOrigin::Solver, rays), &mut open, observe)?;
        let again = EXTRA_PARAMETERS.map(|elsewhere| vec![1.0, 0.0, elsewhere]);
        let rounds = [vec![1.0], vec![0.0]].into_iter().chain(again);
        for (number, places) in rounds.enumerate().filter(|_| all) {
            let round = number.saturating_sub(1);
            if is_large(&found.paths) || round > 0 && !found.is_incomplete() {
                break;
            }
            let mut rays = Vec::new();
            for s in places {
                rays.extend(found.searched(&equations, s, round)?);
            }
            found.follow_rays(&equations, (PathOrigin::Search, rays), &mut open, observe)?;
        }
        Ok(found)
    }

    /// Follows half paths, and those that leave the branch points on them.
    fn follow_rays(
        &mut self,
        equations: &PieceEquations<'_>,
        (origin, rays): (PathOrigin, Vec<HalfPath>),
        open: &mut Open,
        observe: &mut dyn FnMut(&Branches, Option<usize>),
    ) -> Result<(), ProblemError> {
        open.rays.extend(rays.into_iter().map(|ray| (origin, ray)));
        while !(open.rays.is_empty() || is_large(&self.paths)) {
            let (origin, ray) = open.rays.remove(0);
            if origin == PathOrigin::Search && self.reaches(equations, &ray) {
                continue;
            }
            let first = equations.describe(&ray.piece, &ray.state, PointKind::Start, Vec::new())?;
            self.paths.push(Path {
                origin,
                points: vec![first],
                end: PathEnd::TooLong,
            });
            observe(self, Some(open.rays.len()));
            let mut see = |points: Vec<PathPoint>, open: &Open| {
                let path = self.paths.last_mut().expect("a path is followed");
                path.points.extend(points);
                observe(self, Some(open.rays.len()));
            };
            let end = equations.follow(ray, open, &mut see)?;
            self.paths.last_mut().expect("a path is followed").end = end;
        }
        self.left_out = open.rays.len();
        observe(self, None);
        Ok(())
    }

    /// Whether a path has come to a solution that was searched for since.
    fn reaches(&self, equations: &PieceEquations<'_>, ray: &HalfPath) -> bool {
        let parameter = self.range.value(ray.state.parameter());
        let multiplier = equations.multiplier(&ray.state.point);
        let is_end = parameter == self.range.from || parameter == self.range.to;
        let solutions = self.end_solutions(parameter);
        let mut points = solutions.iter().map(|(_, point)| point);
        is_end && points.any(|point| self.is_same(&point.multiplier, &multiplier))
    }

    /// Starts at solutions at s that no path reaches.
    fn searched(
        &self,
        equations: &PieceEquations<'_>,
        s: f64,
        round: usize,
    ) -> Result<Vec<HalfPath>, ProblemError> {
        let value = self.range.value(s);
        let known = self.end_solutions(value).into_iter().map(|(_, point)| {
            let scaled = point.multiplier.iter().map(|l| l / self.stress);
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
    pub fn is_incomplete(&self) -> bool {
        let ends = [self.range.from, self.range.to];
        self.all && ends.into_iter().any(|end| self.degree(end) != 1)
    }

    /// Whether every path has an end that says where it leads.
    #[must_use]
    pub fn is_followed(&self) -> bool {
        self.left_out == 0 && self.paths.iter().all(|path| !path.end.is_early())
    }
}

/// Whether no more paths are begun.
fn is_large(paths: &[Path]) -> bool {
    let points = paths.iter().map(|path| path.points.len()).sum::<usize>();
    // Most paths that are begun, and most points after which no more are.
    paths.len() >= 100 || points >= 20_000
}

impl Branches {
    /// Whether two multipliers in Pa are one.
    fn is_same(&self, first: &[f64], second: &[f64]) -> bool {
        norm(&difference(first, second)) <= SAME * self.stress
    }

    /// The different solutions at one end of the range, by its parameter, with the numbers of their paths and theirs on these.
    #[must_use]
    pub fn end_solutions(&self, parameter: f64) -> Vec<([usize; 2], &PathPoint)> {
        let mut found: Vec<([usize; 2], &PathPoint)> = Vec::new();
        for (path, followed) in self.paths.iter().enumerate() {
            for (number, point) in followed.points.iter().enumerate() {
                let mut others = found.iter();
                let is_known =
                    others.any(|(_, it)| self.is_same(&it.multiplier, &point.multiplier));
                if point.parameter == parameter && !is_known {
                    found.push(([path, number], point));
                }
            }
        }
        found
    }

    /// Σ sign det R' over the solutions at one end of the range, which is 1 where none is missing and all are regular.
    #[must_use]
    pub fn degree(&self, parameter: f64) -> i32 {
        let solutions = self.end_solutions(parameter);
        let signs = solutions.iter().map(|(_, point)| point.determinant);
        signs.map(i32::from).sum()
    }
}
