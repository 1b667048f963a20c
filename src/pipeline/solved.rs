//! A solved run file, read whole and without a lock.

use std::{path::Path, sync::Arc};

use contact3d::{
    contact::Interface, dual::DualSystem, mesh::ContactSurface, scene::Scene, solver::Solution,
};
use runfile::Reader;

use super::{
    Freshness, StageError, load,
    mesh::{self, Meshed},
    solve::{self, Equations},
    states,
};
use crate::format::{self, LAYOUT, Stage};

/// A solved problem with its equations.
#[derive(Debug)]
pub struct Solved {
    /// The scene.
    pub scene: Scene,
    /// A, its factor, B, h and perhaps S.
    pub system: Arc<DualSystem>,
    /// What the solver found.
    pub solution: Solution,
    meshed: Meshed,
}

impl Solved {
    /// The contact face and its laws; `None` without contact.
    #[must_use]
    pub fn contact(&self) -> Option<(&ContactSurface, &Interface)> {
        let surface = self.meshed.mesh.contact.as_ref()?;
        Some((surface, self.meshed.interface.as_ref()?))
    }
}

/// Reads a run file whose stages up to `solve` are fresh.
///
/// # Errors
/// A stage that is missing, stale or damaged, unreadable datasets.
pub fn read_solved(path: &Path) -> Result<Solved, StageError> {
    let reader = Reader::open(path, LAYOUT)?;
    let input = format::read_scene(&reader, path)?;
    let states = states(&reader, &input.scene);
    let mut needed = states
        .into_iter()
        .filter(|state| state.stage <= Stage::Solve);
    if let Some(state) = needed.find(|state| state.freshness != Freshness::Fresh) {
        return Err(StageError::Unfit {
            file: path.to_owned(),
            reason: format!(
                "`export` needs a solved file, but `{}` cannot be used, {}; run `contact3d-pipe run` first",
                state.stage.word(),
                state.freshness.why()
            ),
        });
    }
    let meshed = mesh::read(&reader, &input)?;
    let operator = Arc::new(format::read_assembly(&reader)?);
    let system = Arc::new(load::read(&reader, operator)?);
    let answer = solve::read(&reader, Equations::Problem(system.clone()))?;
    Ok(Solved {
        scene: input.scene,
        system,
        solution: answer.solution,
        meshed,
    })
}
