//! The stages side by side: how each runs, and what it writes.

use std::sync::Arc;

use contact3d::{
    AssembledProblem, Checkpoint, Problem, ProblemError, RunStep, RunStorage,
    dual::{AssemblyError, InsufficientResource, Requirement},
    mesh::Mesh,
    scene::{AdaptSettings, Scene, SceneFile},
    solver::Start,
};
use runfile::{GroupRecord, GroupWriter, StoreError, Transaction};

use super::{
    AssemblyFile, Session, StageError, mesh, resources,
    results::Results,
    session::{LoadState, StageCache},
    store::{Checkpoints, FIRST_COMMIT_SECONDS, Store},
};
use crate::format::{self, HISTORY, Stage, VTKHDF};

/// What a stage computed.
#[derive(Debug, Clone)]
pub(super) enum StageOutput {
    Mesh(Arc<Problem>),
    Assemble(Arc<AssembledProblem>),
    Load(Arc<AssembledProblem>),
    Solve(Arc<Results>),
    Post(Arc<Results>),
}

/// Keeps what an interrupted solve can go on from in the run file, where that costs no more than a twentieth of the time.
struct CheckpointStorage<'a> {
    store: &'a mut Store,
    checkpoints: Checkpoints,
    observe: &'a mut dyn FnMut(RunStep<'_>),
}

impl RunStorage for CheckpointStorage<'_> {
    fn admit(&self, mut need: Requirement) -> Result<(), InsufficientResource> {
        let with_factor = need.stored.saturating_add(need.remakable);
        if self.store.assembly_file.is_beside(with_factor) {
            need.stored = with_factor;
        }
        resources::admit(need, self.store.path())
    }

    fn engine(&self) -> Option<&str> {
        self.store.engine.as_deref()
    }

    fn observe(&mut self, step: RunStep<'_>) {
        (self.observe)(step);
    }

    fn checkpoint(&mut self, unfinished: Checkpoint<'_>) {
        let store = &mut self.store;
        self.checkpoints.keep(|| store.commit(Some(unfinished)));
    }
}

impl Session {
    /// Computes a stage from those before it, which are fresh.
    pub(super) fn compute(
        &mut self,
        stage: Stage,
        observe: &mut dyn FnMut(RunStep<'_>),
    ) -> Result<StageOutput, StageError> {
        match stage {
            Stage::Mesh => self.make_mesh(),
            Stage::Assemble => self.assemble(observe),
            Stage::Load => self.apply_loads(),
            Stage::Solve => self.solve(observe),
            // A solve of this session has evaluated its solution already.
            Stage::Post => {
                let results = self.results()?;
                self.store.require_unchanged()?;
                Ok(StageOutput::Post(results))
            }
        }
    }

    fn make_mesh(&mut self) -> Result<StageOutput, StageError> {
        let store = &self.store;
        let made = self.cache.mesh.take();
        let problem = mesh::make(&store.input, &store.refinement, made, store.path())?;
        let problem = Arc::new(problem);
        self.cache = StageCache {
            problem: Some(problem.clone()),
            ..StageCache::default()
        };
        Ok(StageOutput::Mesh(problem))
    }

    fn assemble(
        &mut self,
        observe: &mut dyn FnMut(RunStep<'_>),
    ) -> Result<StageOutput, StageError> {
        let problem = self.problem()?.as_ref().clone();
        let assembled = problem.assemble_with(&mut self.storage(0.0, observe));
        let assembled = Arc::new(assembled.map_err(|error| refused(&self.store.input, error))?);
        // The loads of a history are those of its last increment, which nothing has applied yet.
        let loads = if self.scene().has_history() {
            LoadState::Any
        } else {
            LoadState::OfScene
        };
        self.cache = StageCache {
            problem: self.cache.problem.take(),
            assembled: Some((assembled.clone(), loads)),
            ..StageCache::default()
        };
        Ok(StageOutput::Assemble(assembled))
    }

    /// The problem of the stored assembly, whose factor is not stored.
    pub(super) fn assemble_again(
        &mut self,
        problem: Problem,
    ) -> Result<AssembledProblem, StageError> {
        let mut observe = |_: RunStep<'_>| {};
        let assembled = problem.assemble_with(&mut self.storage(0.0, &mut observe));
        assembled.map_err(|error| refused(&self.store.input, error))
    }

    fn apply_loads(&mut self) -> Result<StageOutput, StageError> {
        self.assembled()?;
        self.store.require_unchanged()?;
        let loaded = self.loaded(|session, assembled| {
            let loaded = assembled.with_last_loads();
            Ok(loaded.map_err(|invalid| session.store.input.refuse(invalid))?)
        })?;
        Ok(StageOutput::Load(loaded))
    }

    fn solve(&mut self, observe: &mut dyn FnMut(RunStep<'_>)) -> Result<StageOutput, StageError> {
        let (assembled, least_cost) = if self.scene().has_history() {
            let assembled = self.assembled()?;
            let need = need_of_history(self.scene(), assembled.mesh());
            resources::admit(need, self.store.path())?;
            (assembled, FIRST_COMMIT_SECONDS)
        } else {
            let loaded = self.loaded(|session, mut assembled| {
                format::read_loads(&session.store.reader()?, &mut assembled.system)?;
                Ok(assembled)
            })?;
            (loaded, 0.0)
        };
        let (checkpoint, done) = self.store.read_unfinished()?;
        self.store.require_unchanged()?;
        let settings = self.scene().solve.clone();
        let multiplier = self.store.start.clone().filter(|start| !start.is_empty());
        let start = Start {
            multiplier: multiplier.as_deref(),
            checkpoint: checkpoint.as_ref(),
        };
        let answer = assembled.run(
            &settings,
            start,
            done,
            &mut self.storage(least_cost, observe),
        );
        let answer = answer.map_err(|error| refused(&self.store.input, error))?;
        let results = Results::of(&assembled.problem, answer);
        let results = Arc::new(results.map_err(|invalid| self.store.input.refuse(invalid))?);
        self.cache.results = Some(results.clone());
        Ok(StageOutput::Solve(results))
    }

    fn storage<'a>(
        &'a mut self,
        least_cost: f64,
        observe: &'a mut dyn FnMut(RunStep<'_>),
    ) -> CheckpointStorage<'a> {
        let cost = self.store.last_store_seconds.max(least_cost);
        CheckpointStorage {
            store: &mut self.store,
            checkpoints: Checkpoints::new(cost),
            observe,
        }
    }
}

/// An error of the driver, with the line of the scene that it is about.
pub(super) fn refused(input: &SceneFile, error: ProblemError) -> StageError {
    match error {
        ProblemError::Invalid(invalid) | ProblemError::Assembly(AssemblyError::Scene(invalid)) => {
            input.refuse(invalid).into()
        }
        ProblemError::Assembly(error) => error.into(),
        ProblemError::Mesh(error) => error.into(),
        error => error.into(),
    }
}

/// What the increments of a history take: their fields in memory, twice while they are written, and on the disk.
fn need_of_history(scene: &Scene, mesh: &Mesh) -> Requirement {
    let contact = mesh.contact.as_ref();
    let nodes = contact.map_or(0, |surface| surface.nodes.len());
    let panes = contact.map_or(0, |surface| surface.n_panes());
    let of_tetrahedra = match scene.adapt {
        None => 1,
        Some(AdaptSettings { of: None, .. }) => 2,
        Some(AdaptSettings { of: Some(_), .. }) => 3,
    } * mesh.tetrahedra.len();
    let numbers = 6 * mesh.coordinates.len() + of_tetrahedra + 5 * nodes + 12 * panes + 64;
    let bytes = 8 * numbers as u64 * scene.increments().len() as u64;
    Requirement {
        step: "keeping the increments of the load history",
        memory: bytes + bytes / 2,
        stored: 2 * bytes,
        ..Requirement::default()
    }
}

impl StageOutput {
    /// The stage it is of.
    pub(super) fn stage(&self) -> Stage {
        match self {
            Self::Mesh(_) => Stage::Mesh,
            Self::Assemble(_) => Stage::Assemble,
            Self::Load(_) => Stage::Load,
            Self::Solve(_) => Stage::Solve,
            Self::Post(_) => Stage::Post,
        }
    }

    /// Whether its group is kept in a file beside the run file.
    pub(super) fn is_kept_beside(&self, assembly_file: AssemblyFile) -> bool {
        match (self, assembly_file) {
            (Self::Mesh(_), AssemblyFile::LinkedWithMesh) => true,
            (Self::Assemble(problem), _) => {
                assembly_file.is_beside(format::assembly_bytes(&problem.system) as u64)
            }
            _ => false,
        }
    }

    /// Writes the groups of the stage and returns the digest of its own.
    pub(super) fn write(
        &self,
        transaction: &mut Transaction,
        record: &GroupRecord,
        scene: &Scene,
    ) -> Result<String, StoreError> {
        let group = self.stage().group();
        if let Self::Post(_) = self {
            // The report of another scene has other sizes, and would bind those of the grid, which is written first.
            transaction.remove(group);
        }
        let mut write = |group, write: &dyn Fn(&mut GroupWriter<'_>) -> Result<(), StoreError>| {
            transaction.write(group, record, write)
        };
        match self {
            Self::Mesh(problem) => write(group, &|writer| mesh::write(writer, problem)),
            Self::Assemble(problem) => {
                let is_shared = transaction.keeps_beside(group);
                transaction.write(group, record, |writer| {
                    format::write_assembly(writer, &problem.system, is_shared)
                })
            }
            Self::Load(problem) => write(group, &|writer| {
                format::write_loads(writer, &problem.system)
            }),
            Self::Solve(results) => {
                let history = if scene.has_history() {
                    Some(write(HISTORY, &|writer| {
                        format::write_history(writer, scene, &results.increments)
                    })?)
                } else {
                    None
                };
                write(group, &|writer| {
                    results.write_solution(writer, history.as_deref())
                })
            }
            Self::Post(results) => {
                let vtkhdf = write(VTKHDF, &|writer| results.write_vtkhdf(writer))?;
                write(group, &|writer| results.write_report(writer, &vtkhdf))
            }
        }
    }
}
