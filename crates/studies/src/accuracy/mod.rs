//! What accuracy costs: the error of solving the discrete problem, and the error of the mesh.
//!
//! The two are kept apart. The algebraic error is the distance of a solve of accuracy ε to the
//! solution of the same discrete problem to rounding. The discretisation error is the distance of
//! that discrete solution to those of finer meshes and to their extrapolated limit. Both come with
//! what they cost in seconds, applications n_A and memory.

mod algebraic;
mod cost;
mod discretisation;
mod refinement;

pub use algebraic::{AlgebraicStudy, EPSILONS, RunMethod, RunOperator, RunResult, SolverRun};
pub use cost::{Advice, Cost, process_bytes};
pub use discretisation::{DiscretisationStudy, Level, Trend};
pub(crate) use refinement::{brick_n_div, observed_order};
pub use refinement::{extrapolated, nested_bricks};

use std::path::Path;

use serde::Serialize;

use contact3d::{
    ProblemError,
    scene::{ElementOrder, Scene},
};

use crate::StudyStep;
use discretisation::NestedMeshes;

/// Most unknowns of the finer meshes of a body that is no brick; the published brick has 313,632 at the largest default n_div.
pub const MOST_UNKNOWNS: usize = 320_000;

/// How far the studies go.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct AccuracySettings {
    /// Seconds for both studies: half of what coarser meshes leave for the solves of all methods on all operators, the rest for finer
    /// meshes. What would take longer by a forecast is left out; when not given, solves beyond 10 seconds alone.
    pub budget: Option<f64>,
    /// Smallest n_div of the meshes of a brick; 4 when not given.
    pub coarsest: Option<usize>,
    /// n_div of the finest mesh of a brick, a multiple of the scene's own; chosen when not given.
    pub finest: Option<usize>,
    /// Most unknowns of the finer meshes of a mesh file or of several bodies, by a forecast; chosen when not given.
    pub unknowns: Option<usize>,
}

/// Both studies of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Accuracy {
    /// Errors of the solvers on the scene's own mesh; `None` without contact.
    pub algebraic: Option<AlgebraicStudy>,
    /// Errors of the meshes.
    pub discretisation: DiscretisationStudy,
}

impl Accuracy {
    /// Measures both studies; mesh files are looked for in `folder`.
    ///
    /// # Errors
    /// [`ProblemError`] for a scene that has no discrete problem, for a finest mesh in which
    /// the scene's own is not nested, and for limits that meshes of its body do not have.
    pub fn measure(
        scene: &Scene,
        folder: &Path,
        settings: &AccuracySettings,
        observe: &mut dyn FnMut(StudyStep),
    ) -> Result<Self, ProblemError> {
        scene.require_no_history("accuracy")?;
        // A finest mesh that cannot be is refused before the long work.
        let mut meshes = NestedMeshes::new(scene, folder, settings)?;
        // The small meshes first: what an allocator keeps of a large one would count as their peak.
        meshes.solve(true, observe)?;
        let budget = meshes.left().map(|left| left / 2.0);
        let of_solves = AccuracySettings {
            budget,
            ..*settings
        };
        let algebraic = AlgebraicStudy::of(scene, folder, &of_solves, observe)?;
        meshes.solve(false, observe)?;
        Ok(Self {
            algebraic,
            discretisation: meshes.study(),
        })
    }

    /// What the studies mean for someone who has this mesh of such elements.
    #[must_use]
    pub fn advice(&self, element: ElementOrder) -> Advice<'_> {
        Advice::new(self, element)
    }
}
