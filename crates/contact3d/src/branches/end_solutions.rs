//! The solutions at the ends of the range, and their degree.

use super::{branches::Branches, search::SAME};
use crate::linalg::{difference, norm};

/// A solution at one end of the range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EndSolution {
    /// Its path.
    pub path: usize,
    /// Its place on it.
    pub point: usize,
}

impl Branches {
    /// The different solutions at one end of the range, by its parameter.
    #[must_use]
    pub fn end_solutions(&self, parameter: f64) -> Vec<EndSolution> {
        let mut found: Vec<EndSolution> = Vec::new();
        for (path, followed) in self.paths.iter().enumerate() {
            for (point, at) in followed.points.iter().enumerate() {
                let known = |other: &EndSolution| {
                    let other = &self.paths[other.path].points[other.point];
                    norm(&difference(&other.multiplier, &at.multiplier)) <= SAME * self.stress
                };
                if at.parameter == parameter && !found.iter().any(known) {
                    found.push(EndSolution { path, point });
                }
            }
        }
        found
    }

    /// Σ sign det R' over the solutions at one end of the range, which is 1 where none is missing and all are regular.
    #[must_use]
    pub fn degree(&self, parameter: f64) -> i32 {
        let solutions = self.end_solutions(parameter);
        let signs = solutions
            .iter()
            .map(|at| i32::from(self.paths[at.path].points[at.point].determinant));
        signs.sum()
    }
}
