//! One process at work on one run file.

use std::{path::Path, sync::Arc, time::Instant};

use contact3d::{
    AssembledProblem, Problem, RunStep,
    dual::{Assembly, OperatorEstimate},
    linalg::EngineError,
    mesh::Mesh,
    scene::{AssembleSettings, Scene, SceneFile, SolveSettings, Warning},
};
use runfile::{IfMissing, Reader, RunFile};

use super::{
    StageError, StageState,
    mesh::{self, pin_mesh_file},
    resources,
    results::Results,
    store::Store,
};
use crate::format::{self, FormatError, LAYOUT, Stage};

/// A session with a run file: it holds the lock, and what it has computed or read so far.
#[derive(Debug)]
pub struct Session {
    pub(super) store: Store,
    pub(super) cache: StageCache,
}

/// The chain from the mesh to the results, as far as it is in memory.
///
/// A new link replaces all that rested on the old one. Links are shared, so holding one keeps no other from being read.
#[derive(Debug, Default)]
pub(super) struct StageCache {
    /// The mesh of a level, made while the level before was at hand.
    pub(super) mesh: Option<Mesh>,
    pub(super) problem: Option<Arc<Problem>>,
    pub(super) assembled: Option<(Arc<AssembledProblem>, LoadState)>,
    pub(super) results: Option<Arc<Results>>,
}

/// The loads of an assembled problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LoadState {
    /// Perhaps those of another scene.
    Any,
    /// Those of the scene, at the end of its load history.
    OfScene,
}

/// What a stage did.
#[derive(Debug, Clone, PartialEq)]
pub struct StageTiming {
    /// The stage.
    pub stage: Stage,
    /// Seconds of computing, reading its input included.
    pub compute_seconds: f64,
    /// Seconds of writing the file; 0 for a stage that is stored together with the next one.
    pub store_seconds: f64,
}

/// When a stage is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StoreWhen {
    /// At once.
    Now,
    /// Together with the next stage, unless that would put more than a few seconds of work at risk, or more than writing the
    /// file twice costs.
    Deferred,
    /// Not before the session is asked to, with all stages that wait; adaptive levels do so.
    Manual,
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
        input.scene = input.scene.with_first_mesh();
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
        Ok(Self {
            store: Store::new(file, input, threads)?,
            cache: StageCache::default(),
        })
    }

    /// The scene in force.
    pub fn scene(&self) -> &Scene {
        &self.store.input.scene
    }

    /// The scene in force with the text that it came from.
    pub fn input(&self) -> &SceneFile {
        &self.store.input
    }

    /// Changes the solve settings of the scene; stored with the next stage that is written.
    pub fn set_solve(&mut self, settings: SolveSettings) -> Result<(), StageError> {
        settings.validate().map_err(StageError::Setting)?;
        self.store.input.scene.solve = settings;
        Ok(())
    }

    /// Changes the assemble settings of the scene; stored with the next stage that is written.
    pub fn set_assemble(&mut self, settings: AssembleSettings) {
        self.store.input.scene.assemble = settings;
    }

    /// Lets another program, by its command line, hold factors.
    pub fn hold_factors_with(&mut self, engine: Option<String>) {
        self.store.engine = engine;
    }

    /// Lets the solve start from the multipliers of a similar problem, `[n_multipliers]`, in Pa, or
    /// from λ = 0 if empty. A stored solve that started from others is stale.
    pub fn start_from(&mut self, multiplier: Vec<f64>) {
        self.store.start = Some(multiplier);
    }

    /// The state of every stage with respect to the scene in force; all missing in a new file.
    pub fn states(&self) -> Result<Vec<StageState>, StageError> {
        Ok(self.store.states()?)
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
        commit: StoreWhen,
        observe: &mut dyn FnMut(RunStep<'_>),
    ) -> Result<StageTiming, StageError> {
        self.store.require_fresh_before(stage)?;
        let started = Instant::now();
        let output = self.compute(stage, observe)?;
        self.store.keep(output, started, commit)
    }

    /// Refuses a problem that cannot fit into memory before its mesh is made.
    pub fn admit_problem(&self) -> Result<(), StageError> {
        if self.store.engine.is_none() {
            resources::admit_memory(resources::least_of_problem(&self.store.input))?;
        }
        Ok(())
    }

    /// Stores the scene where the file has other words for the same problem, such as another title.
    pub fn store_scene(&mut self) -> Result<(), StageError> {
        if !format::holds_scene(&self.store.reader()?, self.scene())? {
            self.store.commit(None)?;
        }
        Ok(())
    }

    /// What is allowed in the scene and probably not meant; needs a fresh mesh.
    pub fn warnings(&mut self) -> Result<Vec<Warning>, StageError> {
        Ok(self.problem()?.warnings())
    }

    /// The elastic problem with its factor; `None` unless it is in memory.
    pub fn assembly(&self) -> Option<&Assembly> {
        let (assembled, _) = self.cache.assembled.as_ref()?;
        Some(&assembled.system.assembly)
    }

    /// What each form of the dual operator costs, and whether the dense one is held; `None`
    /// unless an assembly is in memory.
    pub fn operator_estimate(&self) -> Option<(OperatorEstimate, bool)> {
        let (assembled, _) = self.cache.assembled.as_ref()?;
        let system = &assembled.system;
        let contact = system.contact.as_ref()?;
        let nodes = assembled.mesh().contact.as_ref()?.nodes.len();
        let structure = system.assembly.factor.structure();
        let estimate = OperatorEstimate::new(structure, &contact.coupling, nodes);
        Some((estimate, contact.explicit().is_some()))
    }

    /// The scene on its mesh.
    pub(super) fn problem(&mut self) -> Result<Arc<Problem>, StageError> {
        if let Some(problem) = &self.cache.problem {
            return Ok(problem.clone());
        }
        let problem = Arc::new(mesh::read(&self.store.reader()?, &self.store.input)?);
        self.cache.problem = Some(problem.clone());
        Ok(problem)
    }

    /// The assembled problem, whatever its loads.
    pub(super) fn assembled(&mut self) -> Result<Arc<AssembledProblem>, StageError> {
        if let Some((assembled, _)) = &self.cache.assembled {
            return Ok(assembled.clone());
        }
        let problem = self.problem()?.as_ref().clone();
        let engine = self.store.engine.as_deref();
        let assembled = match format::read_assembly(&self.store.reader()?, engine) {
            Ok(mut system) => {
                let dofs = &mut system.assembly.primal.dofs;
                dofs.glue(problem.scene(), problem.mesh());
                AssembledProblem { problem, system }
            }
            // The factor stayed with an engine; here it is made again.
            Err(FormatError::Engine(EngineError::NotAtHand)) => self.assemble_again(problem)?,
            Err(error) => return Err(error.into()),
        };
        let assembled = Arc::new(assembled);
        self.cache.assembled = Some((assembled.clone(), LoadState::Any));
        Ok(assembled)
    }

    /// The assembled problem with the loads of the scene, which `load` applies where it has others.
    pub(super) fn loaded(
        &mut self,
        load: impl FnOnce(&Self, AssembledProblem) -> Result<AssembledProblem, StageError>,
    ) -> Result<Arc<AssembledProblem>, StageError> {
        let mut assembled = self.assembled()?;
        if !matches!(self.cache.assembled.take(), Some((_, LoadState::OfScene))) {
            assembled = Arc::new(load(self, Arc::unwrap_or_clone(assembled))?);
        }
        self.cache.assembled = Some((assembled.clone(), LoadState::OfScene));
        Ok(assembled)
    }

    /// The results of a solved file, evaluated anew where they are read.
    pub fn results(&mut self) -> Result<Arc<Results>, StageError> {
        if let Some(results) = &self.cache.results {
            return Ok(results.clone());
        }
        let problem = self.problem()?;
        let reader = self.store.reader()?;
        let results = Arc::new(Results::read(&reader, &self.store.input, &problem)?);
        self.cache.results = Some(results.clone());
        Ok(results)
    }
}
