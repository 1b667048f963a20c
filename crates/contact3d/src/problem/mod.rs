//! A scene from its mesh to its report, in memory: what a user of this crate begins with.
//!
//! [`Problem`] is a scene that fits its mesh, [`AssembledProblem`] the same with the stiffness
//! factorised, from which any number of solves start, also with other loads and other friction. [`AssembledProblem::run`] is the
//! driver of all of them, in memory and in the program; a [`RunStorage`] says what becomes of unfinished work.

mod assembled;
mod nested;
mod run;
mod storage;

pub use assembled::AssembledProblem;
pub use run::SolvedProblem;
pub use storage::{Checkpoint, InMemory, RunStep, RunStorage};

use std::{collections::BTreeSet, path::Path, sync::Arc};

use thiserror::Error;

use crate::{
    contact::{Coupling, Interface, PreviousIncrement, tool_rows},
    dual::{AssemblyError, DualSystem, PrimalSystem},
    elasticity::load_warnings,
    history::StepRecord,
    mesh::{GmshError, Mesh, MeshError},
    post::{ContactReport, FunctionalEstimate, Solved, SolvedContact},
    scene::{Increment, InvalidValue, Scene, SceneError, SceneFile, SlipMeasure, Warning},
    solver::{ContactSide, NeedsExplicit, Solution},
};

/// A scene on its mesh, with the laws of its contact face.
#[derive(Debug, Clone)]
pub struct Problem {
    scene: Scene,
    mesh: Arc<Mesh>,
    interface: Option<Interface>,
}

impl Problem {
    /// Checks a scene and meshes its body; a mesh file is looked for in the working directory.
    ///
    /// # Errors
    /// [`ProblemError::Invalid`] for a value that no problem of this kind can have,
    /// [`ProblemError::Mesh`] for an unusable mesh file.
    pub fn new(scene: Scene) -> Result<Self, ProblemError> {
        Self::in_folder(scene, Path::new(""))
    }

    /// As [`Self::new`], with a mesh file looked for in `folder`.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn in_folder(scene: Scene, folder: &Path) -> Result<Self, ProblemError> {
        let scene = scene.checked()?;
        let mesh = Mesh::of_scene(&scene, folder)?;
        Ok(Self::of_checked(scene, Arc::new(mesh))?)
    }

    /// Reads a scene file and meshes its body; a mesh file is looked for beside the scene.
    ///
    /// # Errors
    /// As [`Self::new`], and [`ProblemError::Scene`] for a file that is no scene.
    pub fn read(path: &Path) -> Result<Self, ProblemError> {
        let file = SceneFile::read(path)?;
        Self::in_folder(file.scene, &file.folder)
    }

    /// A scene on a mesh of its body that exists already.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn on_mesh(scene: Scene, mesh: Mesh) -> Result<Self, ProblemError> {
        Ok(Self::of_checked(scene.checked()?, Arc::new(mesh))?)
    }

    /// A scene that has been checked, on a mesh of its body.
    ///
    /// # Errors
    /// Laws of the contact face that no problem can have.
    pub fn of_checked(scene: Scene, mesh: Arc<Mesh>) -> Result<Self, InvalidValue> {
        let interface = Interface::new(&scene, &mesh)?;
        Ok(Self {
            scene,
            mesh,
            interface,
        })
    }

    /// The same problem in a later step of a load history.
    fn following(mut self, previous: Option<PreviousIncrement>) -> Self {
        if let Some(previous) = previous {
            let interface = self.interface;
            self.interface = interface.map(|interface| interface.following(previous));
        }
        self
    }

    /// The problem of an increment of the scene's load history, which begins where `before` ended.
    ///
    /// # Errors
    /// Gaps and laws that no problem can have.
    pub fn at_increment(
        &self,
        increment: Increment,
        before: Option<&StepRecord>,
    ) -> Result<Self, InvalidValue> {
        let scene = self.scene.at_increment(increment)?;
        let mut problem = Self::of_checked(scene, Arc::clone(&self.mesh))?;
        let mut tangential = before.map(|before| before.tangential.clone());
        if problem.scene.follows_tools()
            && let Some(interface) = problem.interface.take()
        {
            let (scene, mesh) = (&problem.scene, &problem.mesh);
            let tools = before.iter().flat_map(|before| &before.tools);
            let mut motions: Vec<_> = tools.map(|tool| [tool.displacement, tool.turn]).collect();
            motions.resize(scene.tools.len(), [[0.0; 3]; 2]);
            let at_rest = || vec![[0.0; 3]; mesh.coordinates.len()];
            let moved = before.map_or_else(at_rest, |before| before.displacement.clone());
            let driven = scene.driven(&motions);
            let interface = interface.at_present(scene, mesh, &moved, &driven)?;
            tangential = before.map(|_| interface.tangential_of(scene, mesh, &moved, &motions));
            problem.interface = Some(interface);
        }
        let Some((before, tangential)) = before.zip(tangential) else {
            return Ok(problem);
        };
        let has_friction = problem.interface().is_some_and(Interface::has_friction);
        let pane_tangential = problem.contact_side().map_or_else(Vec::new, |face| {
            let moved = |node: usize| before.displacement[node];
            face.interface
                .pane_tangential(face.surface, &tangential, moved)
        });
        let previous = has_friction.then(|| PreviousIncrement {
            tangential,
            pane_tangential,
            path: before.path.clone(),
            follows: self.scene.slip_measure(),
        });
        Ok(problem.following(previous))
    }

    /// The problem after some increments of the scene's load history: that of the last of them, or of the end where there are
    /// none.
    ///
    /// # Errors
    /// Gaps and laws that no problem can have.
    pub fn after_increments(&self, records: &[StepRecord]) -> Result<Self, InvalidValue> {
        let Some((last, before)) = records.split_last() else {
            return Self::of_checked(self.scene.at_end()?, Arc::clone(&self.mesh));
        };
        let problem = self.at_increment(last.increment, before.last())?;
        Ok(match last.slip_origin.as_slice() {
            [] => problem,
            origin => problem.counted_from(origin.to_vec(), self.scene.slip_measure()),
        })
    }

    /// The same with its A and l, and with its B where tools are followed.
    ///
    /// # Errors
    /// As [`Self::after_increments`]; a load that is not finite.
    pub fn system_after(
        &self,
        records: &[StepRecord],
        system: &PrimalSystem,
    ) -> Result<(Self, PrimalSystem, Option<Coupling>), InvalidValue> {
        let (problem, mut system) = (self.after_increments(records)?, system.clone());
        system.apply_loads(&problem.scene, &problem.mesh)?;
        let side = problem
            .contact_side()
            .filter(|_| self.scene.follows_tools());
        let coupling = side.map(|it| it.interface.coupling(it.surface, &system.dofs));
        Ok((problem, system, coupling))
    }

    /// Increments of a history by their places, as [`StepRecord::loaded_most`] has them, but for the last, with what follows from their records on
    /// A and B; residuals are measured as those of the last solution.
    ///
    /// # Errors
    /// As [`Self::system_after`].
    pub fn loaded_most(
        &self,
        records: &[StepRecord],
        (system, coupling): (&PrimalSystem, Option<&Coupling>),
        last: &Solution,
    ) -> Result<Vec<(usize, Self, ContactReport)>, InvalidValue> {
        let places = StepRecord::LOADS.map(|load| StepRecord::loaded_most(records, load));
        let places = BTreeSet::from(places).into_iter();
        let evaluated = |place: usize| {
            let record = &records[place];
            let (problem, system, followed) = self.system_after(&records[..=place], system)?;
            let motions = record.tools.iter().map(|it| [it.displacement, it.turn]);
            let motions: Vec<_> = motions.collect();
            let tools = tool_rows(&problem.scene, &problem.mesh, &motions);
            let rows = [record.displacement.as_slice(), &tools].concat();
            let mut solution = Solution {
                status: record.status,
                accuracy: record.accuracy,
                multiplier: record.multiplier.clone(),
                displacement: system.dofs.to_free(&rows),
                ..last.clone()
            };
            let coupling = followed.as_ref().or(coupling);
            let friction = problem.solved(&system, coupling, &solution).friction();
            solution.friction = friction;
            let report = problem.assess(&system, coupling, &mut solution, Vec::new())?;
            Ok((place, problem, report))
        };
        let earlier = places.filter(|place| place + 1 < records.len());
        earlier.map(evaluated).collect()
    }

    /// The problem of an increment with its slip counted from other (u_t1, u_t2) of the contact nodes in m.
    fn counted_from(self, tangential: Vec<[f64; 2]>, follows: SlipMeasure) -> Self {
        let previous = self.interface.as_ref().and_then(|it| it.previous.as_ref());
        let path = previous.map_or_else(
            || vec![[0.0; 3]; tangential.len()],
            |previous| previous.path.clone(),
        );
        let pane_tangential = self.contact_side().map_or_else(Vec::new, |face| {
            let surface = face.surface;
            let component = |k: usize| tangential.iter().map(|u| u[k]).collect::<Vec<_>>();
            let components = [component(0), component(1)];
            let panes = 0..face.interface.n_friction_panes();
            let mean = |pane: usize| match surface.touches_body(pane) {
                true => previous.map_or([0.0; 2], |previous| previous.pane_tangential[pane]),
                false => components
                    .each_ref()
                    .map(|values| surface.pane_mean(pane, values)),
            };
            panes.map(mean).collect()
        });
        self.following(Some(PreviousIncrement {
            tangential,
            pane_tangential,
            path,
            follows,
        }))
    }

    /// Assembles the stiffness and factorises it, on the threads of rayon's current pool. The bits of the
    /// result do not depend on their number.
    ///
    /// # Errors
    /// [`ProblemError::Assembly`] when the stiffness has no Cholesky factor, a load no value, or the
    /// clamps let the body move as a rigid one.
    pub fn assemble(self) -> Result<AssembledProblem, ProblemError> {
        self.assemble_with(&mut InMemory)
    }

    /// As [`Self::assemble`], where a storage admits and watches every step.
    ///
    /// # Errors
    /// As [`Self::assemble`], and what the storage refuses.
    pub fn assemble_with(
        self,
        storage: &mut dyn RunStorage,
    ) -> Result<AssembledProblem, ProblemError> {
        let system = storage::assembled_by(storage, |assembling| {
            DualSystem::assembled(&self.scene, &self.mesh, self.interface.as_ref(), assembling)
        })?;
        Ok(AssembledProblem {
            problem: self,
            system,
        })
    }

    /// What follows from a solution of A and l with B, which it is held against.
    ///
    /// # Errors
    /// A law of friction without a value at the slips of the solution.
    pub fn assess(
        &self,
        system: &PrimalSystem,
        coupling: Option<&Coupling>,
        solution: &mut Solution,
        known: Vec<FunctionalEstimate>,
    ) -> Result<ContactReport, InvalidValue> {
        let report = ContactReport::new(&self.solved(system, coupling, solution), known)?;
        report.classify(solution);
        Ok(report)
    }

    /// The problem with a solution of it, by A, l and B.
    #[must_use]
    pub fn solved<'a>(
        &'a self,
        system: &'a PrimalSystem,
        coupling: Option<&'a Coupling>,
        solution: &'a Solution,
    ) -> Solved<'a> {
        let contact = coupling.zip(self.contact_side());
        Solved {
            scene: &self.scene,
            mesh: &self.mesh,
            system,
            contact: contact.map(|(coupling, state)| SolvedContact { coupling, state }),
            solution,
        }
    }

    /// Γ_c and its laws; `None` without contact.
    #[must_use]
    pub fn contact_side(&self) -> Option<ContactSide<'_>> {
        Some(ContactSide {
            surface: self.mesh.contact.as_ref()?,
            interface: self.interface.as_ref()?,
        })
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Its mesh.
    #[must_use]
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// The laws of the contact face; `None` without contact.
    #[must_use]
    pub fn interface(&self) -> Option<&Interface> {
        self.interface.as_ref()
    }

    /// What is allowed in the scene and probably not meant.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = self.scene.warnings();
        warnings.extend(self.scene.unnamed_units(self.mesh.extent()));
        warnings.extend(load_warnings(&self.scene, &self.mesh));
        warnings.extend(self.mesh.joint_warnings(&self.scene));
        if let Some(interface) = &self.interface {
            let length = self.scene.units.length();
            warnings.extend(interface.warnings(self.mesh.extent(), length));
        }
        warnings
    }
}

/// Why a problem cannot be posed or solved.
#[derive(Debug, Error)]
pub enum ProblemError {
    /// A scene file.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A value of the scene or of the settings.
    #[error(transparent)]
    Invalid(#[from] InvalidValue),
    /// The mesh file.
    #[error(transparent)]
    Mesh(#[from] GmshError),
    /// The stiffness matrix.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// A solver setting that the operator does not allow.
    #[error(transparent)]
    NeedsExplicit(#[from] NeedsExplicit),
    /// A changed scene that the assembled operators do not fit.
    #[error(
        "{key}: expected as when the problem was assembled, found another; only loads, gap, law of friction and \
         settings of the solve may differ: assemble a problem of its own"
    )]
    OtherOperator {
        /// The key that differs.
        key: String,
    },
}

impl From<MeshError> for ProblemError {
    fn from(error: MeshError) -> Self {
        match error {
            MeshError::Scene(invalid) => Self::Invalid(invalid),
            MeshError::Gmsh(error) => Self::Mesh(error),
        }
    }
}
