//! What accuracy costs: the error of solving the discrete problem, and the error of the mesh.
//!
//! The two are kept apart. The algebraic error is the distance of a solve of accuracy ε to the
//! solution of the same discrete problem to rounding. The discretisation error is the distance of
//! that discrete solution to those of finer meshes and to their extrapolated limit. Both come with
//! what they cost in seconds, applications n_A and memory.

mod advice;
mod algebraic;
mod cost;
mod discretisation;
mod prolongation;
mod refinement;
mod richardson;
#[cfg(test)]
mod tests;

pub use advice::{Advice, Refinement};
pub use algebraic::{AlgebraicLadder, EPSILONS, LadderEntry, LadderMethod, LadderResult, Operator};
pub use cost::Cost;
pub use discretisation::{DiscretisationLadder, Forces, Level, Trend};
pub(crate) use refinement::brick_n_div;
pub use refinement::nested_cells;
pub use richardson::extrapolated;
pub(crate) use richardson::observed_order;

use std::path::Path;

use serde::Serialize;

use crate::{problem::ProblemError, scene::Scene};

/// How far a ladder goes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AccuracySettings {
    /// Seconds for each method on each operator; later entries are left out.
    pub budget: f64,
    /// Smallest n_div of the meshes.
    pub coarsest: usize,
    /// n_div of the finest mesh, a multiple of the scene's own; chosen when not given.
    pub finest: Option<usize>,
}

/// Both ladders of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Accuracy {
    /// Errors of the solvers on the scene's own mesh; `None` without contact.
    pub algebraic: Option<AlgebraicLadder>,
    /// Errors of the meshes; `None` for a mesh file, which has no finer meshes.
    pub discretisation: Option<DiscretisationLadder>,
}

/// What an observer of the ladders sees before each piece of work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AccuracyProgress {
    /// A mesh of this n_div is solved.
    Level(usize),
    /// The scene's own mesh is solved to this ε.
    LadderEntry(LadderMethod, Operator, f64),
}

impl Accuracy {
    /// Climbs both ladders; mesh files are looked for in `folder`.
    ///
    /// # Errors
    /// [`ProblemError`] for a scene that has no discrete problem, and for a finest mesh in which
    /// the scene's own is not nested.
    pub fn measure(
        scene: &Scene,
        folder: &Path,
        settings: &AccuracySettings,
        threads: usize,
        observe: &mut dyn FnMut(AccuracyProgress),
    ) -> Result<Self, ProblemError> {
        // A finest mesh that cannot be is refused before the long work.
        if let Some(brick) = scene.body.as_brick() {
            nested_cells(scene, brick, settings)?;
        }
        // The small meshes first: what an allocator keeps of a large one would count as their peak.
        let algebraic = AlgebraicLadder::measure(scene, folder, settings, threads, observe)?;
        let discretisation = DiscretisationLadder::measure(scene, settings, threads, observe)?;
        Ok(Self {
            algebraic,
            discretisation,
        })
    }

    /// What the ladders mean for someone who has this mesh.
    #[must_use]
    pub fn advice(&self) -> Advice {
        Advice::new(self)
    }
}
