//! One process at work on one run file.

use std::{path::Path, sync::Arc, time::Instant};

use contact3d::{
    contact::Interface,
    dual::{Assembly, OperatorEstimate},
    elasticity::idle_loads,
    history::StepRecord,
    mesh::Mesh,
    post::ContactReport,
    scene::{AssembleSettings, Scene, SceneFile, SolveSettings, Warning},
    solver::Solution,
};
use runfile::{IfMissing, Reader, RunFile, StoreError};

use super::{
    StageError, StageState, Step,
    adapt::RefinementInForce,
    known::{Source, StageCache},
    mesh::Meshed,
    pin_mesh_file,
    post::Evaluated,
    solve::StartFrom,
    stages::{self, Chosen},
    store::Store,
};
use crate::format::{self, LAYOUT, Stage};

/// A session with a run file: it holds the lock, and what it has computed or read so far.
#[derive(Debug)]
pub struct Session {
    pub(super) task: Task,
    pub(super) store: Store,
    pub(super) known: StageCache,
}

/// What is asked of a session.
#[derive(Debug)]
pub(super) struct Task {
    pub(super) input: SceneFile,
    /// The cuts between the first mesh of the scene and the one in force.
    pub(super) refinement: RefinementInForce,
    pub(super) start: StartFrom,
    pub(super) threads: usize,
}

/// What a stage did.
#[derive(Debug, Clone, PartialEq)]
pub struct Performed {
    /// The stage.
    pub stage: Stage,
    /// Seconds of computing, reading its input included.
    pub compute_seconds: f64,
    /// Seconds of writing the file; 0 for a stage that is stored together with the next one.
    pub store_seconds: f64,
}

/// When a stage is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Commit {
    /// At once.
    Now,
    /// Together with the next stage, unless that would put more than a few seconds of work at risk, or more than writing the
    /// file twice costs.
    WithNextIfCheap,
    /// Not before the session is asked to, with all stages that wait; adaptive levels do so.
    Held,
}

/// What a solve came to.
#[derive(Debug)]
pub struct Results {
    meshed: Arc<Meshed>,
    evaluated: Arc<Evaluated>,
}

impl Results {
    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &Mesh {
        &self.meshed.mesh
    }

    /// The laws of the contact face; `None` without contact.
    #[must_use]
    pub fn interface(&self) -> Option<&Interface> {
        match &self.evaluated.history {
            None => self.meshed.interface.as_ref(),
            Some(history) => history.interface.as_ref(),
        }
    }

    /// The increments of a load history, the last of which the other results are of; none without one.
    #[must_use]
    pub fn increments(&self) -> &[StepRecord] {
        let history = self.evaluated.history.as_ref();
        history.map_or(&[], |history| &history.records)
    }

    /// Multipliers and displacement.
    #[must_use]
    pub fn solution(&self) -> &Solution {
        &self.evaluated.answer.solution
    }

    /// What follows from them.
    #[must_use]
    pub fn report(&self) -> &ContactReport {
        &self.evaluated.report
    }
}

/// The results that a finished run file holds; takes no lock.
///
/// # Errors
/// Unreadable datasets.
pub fn read_results(run_file: &Path, input: &SceneFile) -> Result<Results, StageError> {
    let source = Source { run_file, input };
    let mut known = StageCache::default();
    Ok(Results {
        meshed: known.meshed(source)?,
        evaluated: known.evaluated(source)?,
    })
}

impl Task {
    /// Where what this task asks for is read from.
    pub(super) fn source<'a>(&'a self, store: &'a Store) -> Source<'a> {
        Source {
            run_file: store.path(),
            input: &self.input,
        }
    }

    /// The settings of a stage in force, as TOML.
    pub(super) fn settings(&self, stage: Stage) -> String {
        let chosen = Chosen {
            refinement: self.refinement.digest(),
            start: self.start.digest(),
        };
        stages::settings(stage, &self.input.scene, chosen)
    }
}

impl Session {
    /// Locks a run file, new or existing, for a scene that may differ from the stored one.
    ///
    /// # Errors
    /// A busy, foreign or unreadable file.
    pub fn with_scene(
        path: &Path,
        mut input: SceneFile,
        threads: usize,
    ) -> Result<Self, StageError> {
        pin_mesh_file(&mut input)?;
        let layout = LAYOUT.in_units(input.scene.units);
        let file = RunFile::lock(path, layout, IfMissing::Create)?;
        Self::new(file, input, threads)
    }

    /// Locks an existing run file and takes its scene.
    ///
    /// # Errors
    /// A missing, busy, foreign or unreadable file.
    pub fn open(path: &Path, threads: usize) -> Result<Self, StageError> {
        let file = RunFile::lock(path, LAYOUT, IfMissing::Refuse)?;
        let input = format::read_scene(&Reader::open(file.path(), LAYOUT)?, path)?;
        let file = file.in_units(input.scene.units);
        Self::new(file, input, threads)
    }

    fn new(file: RunFile, input: SceneFile, threads: usize) -> Result<Self, StageError> {
        let store = Store::new(file);
        let reader = match store.reader() {
            Err(StoreError::NotFound { .. }) => None,
            opened => Some(opened?),
        };
        let refinement = RefinementInForce::stored(reader.as_ref(), &input.scene);
        Ok(Self {
            task: Task {
                input,
                refinement,
                start: StartFrom::Any,
                threads,
            },
            store,
            known: StageCache::default(),
        })
    }

    /// The scene in force.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.task.input.scene
    }

    /// Changes the solve settings of the scene; stored with the next stage that is written.
    ///
    /// # Errors
    /// Settings that no solve can have.
    pub fn set_solve(&mut self, settings: SolveSettings) -> Result<(), StageError> {
        settings.validate("solve").map_err(StageError::Setting)?;
        self.task.input.scene.solve = settings;
        Ok(())
    }

    /// Changes the assemble settings of the scene; stored with the next stage that is written.
    pub fn set_assemble(&mut self, settings: AssembleSettings) {
        self.task.input.scene.assemble = settings;
    }

    /// Lets the solve start from the multipliers of a similar problem, `[n_multipliers]`, in Pa, or
    /// from λ = 0 if empty. A stored solve that started from others is stale.
    pub fn start_from(&mut self, multiplier: Vec<f64>) {
        self.task.start = StartFrom::multipliers(multiplier);
    }

    /// The state of every stage with respect to the scene in force; all missing in a new file.
    ///
    /// # Errors
    /// An unreadable file.
    pub fn states(&self) -> Result<Vec<StageState>, StageError> {
        Ok(self.store.states(&self.task)?)
    }

    /// Runs a stage and stores it; `observe` sees every step of long ones.
    ///
    /// # Errors
    /// A stale or missing stage before it, what the stage itself refuses, too little memory or disk
    /// space, HDF5 failures. A solve that does not converge is not an error: it is stored with its
    /// status.
    pub fn perform(
        &mut self,
        stage: Stage,
        commit: Commit,
        observe: &mut dyn FnMut(Step<'_>),
    ) -> Result<Performed, StageError> {
        self.store.require_fresh_before(stage, &self.task)?;
        let started = Instant::now();
        let output = self.compute(stage, observe)?;
        self.store.keep(output, started, commit, &self.task)
    }

    /// What is allowed in the scene and probably not meant; needs a fresh mesh.
    ///
    /// # Errors
    /// Laws of the contact face that no problem can have, HDF5 failures.
    pub fn warnings(&mut self) -> Result<Vec<Warning>, StageError> {
        let mut warnings = self.scene().warnings();
        let meshed = self.known.meshed(self.task.source(&self.store))?;
        warnings.extend(idle_loads(self.scene(), &meshed.mesh));
        if let Some(interface) = &meshed.interface {
            let length = self.scene().units.length();
            warnings.extend(interface.warnings(meshed.mesh.extent(), length));
        }
        Ok(warnings)
    }

    /// The results of a solved file.
    ///
    /// # Errors
    /// Unreadable datasets.
    pub fn results(&mut self) -> Result<Results, StageError> {
        let source = self.task.source(&self.store);
        Ok(Results {
            meshed: self.known.meshed(source)?,
            evaluated: self.known.evaluated(source)?,
        })
    }

    /// The elastic problem with its factor; `None` unless it is in memory.
    #[must_use]
    pub fn assembly(&self) -> Option<&Assembly> {
        let (_, system) = self.known.in_memory()?;
        Some(&system.assembly)
    }

    /// Whether the last solve gave up with a factor in single precision, and was done again with one in double.
    #[must_use]
    pub fn is_reconsidered(&self) -> bool {
        self.known.is_reconsidered()
    }

    /// What each form of the dual operator costs, and whether the dense one is held; `None`
    /// unless an assembly is in memory.
    #[must_use]
    pub fn operator_estimate(&self) -> Option<(OperatorEstimate, bool)> {
        let (mesh, system) = self.known.in_memory()?;
        let contact = system.contact.as_ref()?;
        let nodes = mesh.contact.as_ref()?.nodes.len();
        let estimate =
            OperatorEstimate::new(system.assembly.factor.structure(), &contact.coupling, nodes);
        Some((estimate, contact.explicit().is_some()))
    }
}
