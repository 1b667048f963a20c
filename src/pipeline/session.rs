use std::{fs, path::Path, time::Instant};

use contact3d::{
    contact::{Coupling, Interface},
    dual::{AssemblyError, AssemblySeconds, DualSystem, Need, OperatorEstimate, PrimalSystem},
    elasticity::{Loads, idle_loads, refuse_rigid_motions},
    mesh::{Mesh, Quality},
    post::ContactReport,
    scene::{AssembleSettings, Body, Invalid, Scene, SceneFile, SolveSettings, Warning},
    solver::{ContactState, OuterState, Progress, Solution, Start, solve},
};
use runfile::{IfMissing, Reader, RunFile, StoreError};

use super::{
    AssemblyFile, StageError, StageState,
    checkpoint::Checkpoints,
    freshness::{StartedFrom, states_from},
    mesh_file::{mesh_of, pin_mesh_file},
    persistence::loaded,
    resources,
    undo::Undo,
};
use crate::format::{self, LAYOUT, Stage};

/// One process at work on one run file: it holds the lock and what it has computed or read so far.
pub struct Session {
    pub(super) file: RunFile,
    pub(super) threads: usize,
    pub(super) assembly_file: AssemblyFile,
    pub(super) input: SceneFile,
    pub(super) mesh: Option<Mesh>,
    pub(super) quality: Option<Quality>,
    /// The laws of the contact face of the loaded mesh.
    pub(super) interface: Option<Interface>,
    pub(super) system: Option<DualSystem>,
    /// Whether the loads of `system` are those of the scene.
    pub(super) loads_applied: bool,
    /// Multipliers that the solve starts from, empty for λ = 0, with their digest; `None` if that is
    /// left to the solve.
    pub(super) start: Option<(Vec<f64>, Option<String>)>,
    /// A, l and B where they were read without the factor.
    pub(super) primal: Option<(PrimalSystem, Option<Coupling>)>,
    pub(super) solution: Option<Solution>,
    pub(super) report: Option<ContactReport>,
    /// Digests of the stages that the stage at work builds on, as they were when it began.
    pub(super) upstream: Vec<(Stage, String)>,
    /// What the last commit of this process took.
    pub(super) last_store_seconds: f64,
    /// Stages computed but not yet stored, with their seconds.
    pub(super) pending: Vec<(Stage, f64)>,
    /// The run file as it was before the command at work.
    pub(super) undo: Undo,
}

/// What a stage did.
#[derive(Debug, Clone, PartialEq)]
pub struct Performed {
    /// The stage.
    pub stage: Stage,
    /// Seconds of computing, reading its input included.
    pub compute_seconds: f64,
    /// Seconds of writing the file; 0 for a solve that is stored together with its report.
    pub store_seconds: f64,
}

/// When a stage is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Commit {
    /// At once.
    Now,
    /// Together with the next stage, unless that would put longer work at risk than writing the
    /// file twice costs.
    WithNextIfCheap,
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
        Ok(Self::new(file, input, threads))
    }

    /// Locks an existing run file and takes its scene.
    ///
    /// # Errors
    /// A missing, busy, foreign or unreadable file.
    pub fn open(path: &Path, threads: usize) -> Result<Self, StageError> {
        let file = RunFile::lock(path, LAYOUT, IfMissing::Refuse)?;
        let input = format::read_scene(&Reader::open(file.path(), LAYOUT)?, path)?;
        let file = file.in_units(input.scene.units);
        Ok(Self::new(file, input, threads))
    }

    fn new(file: RunFile, input: SceneFile, threads: usize) -> Self {
        Self {
            file,
            threads,
            assembly_file: AssemblyFile::default(),
            input,
            mesh: None,
            quality: None,
            interface: None,
            system: None,
            loads_applied: false,
            start: None,
            primal: None,
            solution: None,
            report: None,
            upstream: Vec::new(),
            last_store_seconds: 0.0,
            pending: Vec::new(),
            undo: Undo::default(),
        }
    }

    /// The scene in force.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.input.scene
    }

    /// Changes the solve settings of the scene; stored with the next stage that is written.
    ///
    /// # Errors
    /// Settings that no solve can have.
    pub fn set_solve(&mut self, settings: SolveSettings) -> Result<(), StageError> {
        settings.validate("solve").map_err(StageError::Setting)?;
        self.input.scene.solve = settings;
        Ok(())
    }

    /// The state of every stage with respect to the scene in force; all missing in a new file.
    ///
    /// # Errors
    /// An unreadable file.
    pub fn states(&self) -> Result<Vec<StageState>, StageError> {
        match self.reader() {
            Ok(reader) => Ok(self.states_in(Some(&reader))),
            Err(StoreError::NotFound { .. }) => Ok(self.states_in(None)),
            Err(error) => Err(error.into()),
        }
    }

    /// The states in a file that may not exist yet.
    pub(super) fn states_in(&self, reader: Option<&Reader>) -> Vec<StageState> {
        let start = match &self.start {
            Some((_, digest)) => StartedFrom::Given(digest.as_deref()),
            None => StartedFrom::AsStored,
        };
        states_from(reader, self.scene(), start)
    }

    /// Makes the mesh and stores it with the scene.
    ///
    /// # Errors
    /// A mesh or loads the scene cannot have, too little memory or disk space, HDF5 failures.
    pub fn make_mesh(&mut self) -> Result<Performed, StageError> {
        let started = Instant::now();
        self.upstream.clear();
        let need = match &self.scene().body {
            Body::Brick(brick) => resources::need_of_brick(brick),
            Body::Gmsh(gmsh) => {
                let file = fs::metadata(self.input.folder.join(&gmsh.file));
                resources::need_of_mesh_file(file.map_or(0, |file| file.len()))
            }
        };
        resources::admit(need, self.file.path())?;
        let mesh = mesh_of(&self.input)?;
        refuse_rigid_motions(&mesh, &mesh.held_nodes(self.scene()))
            .and_then(|()| Loads::of(self.scene()).nodal_forces(&mesh).map(drop))
            .map_err(|invalid| self.refuse(invalid))?;
        self.quality = Some(Quality::of(&mesh));
        self.mesh = Some(mesh);
        self.load_interface()?;
        self.store(Stage::Mesh, started)
    }

    /// Assembles and factorises; `observe` sees the name of every long step before it begins.
    ///
    /// # Errors
    /// A stale or missing mesh, a stiffness that is not positive definite, too little memory or
    /// disk space, HDF5 failures.
    pub fn assemble(&mut self, observe: &dyn Fn(&'static str)) -> Result<Performed, StageError> {
        self.require_fresh_before(Stage::Assemble)?;
        let started = Instant::now();
        self.load_mesh()?;
        let mesh = loaded(&self.mesh);
        let admit = |need: Need| {
            observe(need.step);
            resources::admit(need, self.file.path())
        };
        let system = DualSystem::admitted(self.scene(), mesh, self.threads, &admit);
        self.system = Some(system.map_err(|error| match error {
            AssemblyError::Scene(invalid) => self.refuse(invalid),
            error => error.into(),
        })?);
        self.loads_applied = true;
        self.store(Stage::Assemble, started)
    }

    /// Applies the loads of the scene to the assembled problem.
    ///
    /// # Errors
    /// A stale or missing assembly, a load that is not finite, HDF5 failures.
    pub fn apply_loads(&mut self, commit: Commit) -> Result<Performed, StageError> {
        self.require_fresh_before(Stage::Load)?;
        let started = Instant::now();
        self.load_mesh()?;
        self.load_operator()?;
        self.require_unchanged(&self.states()?)?;
        if !self.loads_applied {
            let scene = &self.input.scene;
            let system = self.system.as_mut().expect("loaded before use");
            system
                .apply_loads(scene, loaded(&self.mesh))
                .map_err(|invalid| self.input.refuse(invalid))?;
            self.loads_applied = true;
        }
        self.store_or_wait(Stage::Load, commit, started)
    }

    /// Lets the solve start from the multipliers of a similar problem, `[n_multipliers]`, in Pa, or
    /// from λ = 0 if empty. A stored solve that started from others is stale.
    pub fn start_from(&mut self, multiplier: Vec<f64>) {
        let bytes: Vec<u8> = multiplier.iter().flat_map(|v| v.to_le_bytes()).collect();
        let digest = (!bytes.is_empty()).then(|| blake3::hash(&bytes).to_hex().to_string());
        self.start = Some((multiplier, digest));
    }

    /// The digest of the multipliers that the solve starts from; `None` for λ = 0.
    pub(super) fn start_digest(&self) -> Option<&str> {
        self.start.as_ref()?.1.as_deref()
    }

    /// What the parts of an assembly made in this process took.
    #[must_use]
    pub fn assembly_seconds(&self) -> Option<AssemblySeconds> {
        self.system.as_ref().map(|system| system.assembly.seconds)
    }

    /// What each form of the dual operator costs, and whether the dense one is held; `None`
    /// before [`Self::assemble`].
    #[must_use]
    pub fn operator_estimate(&self) -> Option<(OperatorEstimate, bool)> {
        let (mesh, system) = (self.mesh.as_ref()?, self.system.as_ref()?);
        let contact = system.contact.as_ref()?;
        let nodes = mesh.contact.as_ref()?.nodes.len();
        let estimate = OperatorEstimate::new(&system.assembly.factor, &contact.coupling, nodes);
        Some((estimate, contact.explicit().is_some()))
    }

    /// Changes the assemble settings of the scene; stored with the next stage that is written.
    pub fn set_assemble(&mut self, settings: AssembleSettings) {
        self.input.scene.assemble = settings;
    }

    /// Solves the contact problem; `observe` sees every outer step.
    ///
    /// # Errors
    /// Stale or missing input, HDF5 failures. A solve that does not converge is not an error: it
    /// is stored with its status.
    pub fn solve(
        &mut self,
        commit: Commit,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Result<Performed, StageError> {
        self.require_fresh_before(Stage::Solve)?;
        let started = Instant::now();
        self.load_mesh()?;
        self.load_system()?;
        self.load_interface()?;
        let checkpoint: Option<OuterState> = self.read_checkpoint()?;
        self.require_unchanged(&self.states()?)?;
        let mut checkpoints = Checkpoints::new(self);
        let solution = solve(
            loaded(&self.system),
            self.contact_state().as_ref(),
            &self.scene().solve,
            Start {
                multiplier: self
                    .start
                    .as_ref()
                    .map(|(multiplier, _)| multiplier.as_slice()),
                checkpoint: checkpoint.as_ref(),
            },
            &mut |progress| match progress {
                Progress::Between(state) => checkpoints.keep(state),
                seen => observe(seen),
            },
        )?;
        self.solution = Some(solution);
        self.report = Some(self.evaluate()?);
        self.store_or_wait(Stage::Solve, commit, started)
    }

    fn store_or_wait(
        &mut self,
        stage: Stage,
        commit: Commit,
        started: Instant,
    ) -> Result<Performed, StageError> {
        let compute_seconds = started.elapsed().as_secs_f64();
        if commit == Commit::Now || compute_seconds >= self.last_store_seconds {
            return self.store(stage, started);
        }
        self.pending.push((stage, compute_seconds));
        Ok(Performed {
            stage,
            compute_seconds,
            store_seconds: 0.0,
        })
    }

    /// Evaluates the solution and stores the report, for h5py and for ParaView.
    ///
    /// # Errors
    /// Stale or missing input, HDF5 failures.
    pub fn post(&mut self) -> Result<Performed, StageError> {
        self.require_fresh_before(Stage::Post)?;
        let started = Instant::now();
        self.load_mesh()?;
        self.load_solution()?;
        self.require_unchanged(&self.states()?)?;
        // A solve of this session has evaluated its solution already.
        if self.report.is_none() {
            self.report = Some(self.evaluate()?);
        }
        self.store(Stage::Post, started)
    }

    /// What is allowed in the scene and probably not meant; needs a fresh mesh.
    ///
    /// # Errors
    /// Laws of the contact face that no problem can have, HDF5 failures.
    pub fn warnings(&mut self) -> Result<Vec<Warning>, StageError> {
        let mut warnings = self.scene().warnings();
        self.load_mesh()?;
        self.load_interface()?;
        let mesh = loaded(&self.mesh);
        warnings.extend(idle_loads(self.scene(), mesh));
        if let Some(interface) = &self.interface {
            let length = self.scene().units.length();
            warnings.extend(interface.warnings(mesh.extent(), length));
        }
        Ok(warnings)
    }

    pub(super) fn load_interface(&mut self) -> Result<(), StageError> {
        if self.interface.is_none() {
            let interface = Interface::new(self.scene(), loaded(&self.mesh));
            self.interface = interface.map_err(|invalid| self.refuse(invalid))?;
        }
        Ok(())
    }

    /// The contact face and its laws; `None` without contact.
    #[must_use]
    pub fn contact_state(&self) -> Option<ContactState<'_>> {
        Some(ContactState {
            surface: self.mesh.as_ref()?.contact.as_ref()?,
            interface: self.interface.as_ref()?,
        })
    }

    pub(super) fn refuse(&self, invalid: Invalid) -> StageError {
        self.input.refuse(invalid).into()
    }
}
