use std::{path::Path, time::Instant};

use super::{
    Freshness, StageError, StageState,
    freshness::{input_digest, settings, states},
};
use crate::{
    dual::{DualSystem, OperatorEstimate, PrimalSystem},
    format::{self, FormatError, LAYOUT},
    mesh::{Mesh, Quality},
    post::{ContactReport, Solved},
    scene::{AssembleSettings, Scene, SolveSettings},
    solver::{ContactState, Progress, Solution, solve},
    store::{
        IfMissing, Reader, RunFile, Stage, StageRecord, StageWriter, StoreError, StoredStage,
        Transaction, timestamp,
    },
};

/// One process at work on one run file: it holds the lock and what it has computed or read so far.
pub struct Session {
    file: RunFile,
    threads: usize,
    scene: Scene,
    mesh: Option<Mesh>,
    system: Option<DualSystem>,
    primal: Option<PrimalSystem>,
    solution: Option<Solution>,
    report: Option<ContactReport>,
}

/// What a stage did.
#[derive(Debug, Clone, PartialEq)]
pub struct Performed {
    /// The stage.
    pub stage: Stage,
    /// Seconds of computing, reading its input included.
    pub compute_seconds: f64,
    /// Seconds of writing the file.
    pub store_seconds: f64,
}

impl Session {
    /// Locks a run file, new or existing, for a scene that may differ from the stored one.
    ///
    /// # Errors
    /// A busy, foreign or unreadable file.
    pub fn with_scene(path: &Path, scene: Scene, threads: usize) -> Result<Self, StageError> {
        let file = RunFile::lock(path, LAYOUT, IfMissing::Create)?;
        Ok(Self::new(file, scene, threads))
    }

    /// Locks an existing run file and takes its scene.
    ///
    /// # Errors
    /// A missing, busy, foreign or unreadable file.
    pub fn open(path: &Path, threads: usize) -> Result<Self, StageError> {
        let file = RunFile::lock(path, LAYOUT, IfMissing::Refuse)?;
        let scene = format::read_scene(&Reader::open(file.path(), LAYOUT)?)?;
        Ok(Self::new(file, scene, threads))
    }

    fn new(file: RunFile, scene: Scene, threads: usize) -> Self {
        Self {
            file,
            threads,
            scene,
            mesh: None,
            system: None,
            primal: None,
            solution: None,
            report: None,
        }
    }

    /// The scene in force.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Changes the solve settings of the scene; stored with the next stage that is written.
    ///
    /// # Errors
    /// Settings that no solve can have.
    pub fn set_solve(&mut self, settings: SolveSettings) -> Result<(), StageError> {
        settings.validate("solve").map_err(StageError::Setting)?;
        self.scene.solve = settings;
        Ok(())
    }

    /// The state of every stage with respect to the scene in force; all missing in a new file.
    ///
    /// # Errors
    /// An unreadable file.
    pub fn states(&self) -> Result<Vec<StageState>, StageError> {
        match self.reader() {
            Ok(reader) => Ok(states(&reader, &self.scene)?),
            Err(StoreError::NotFound { .. }) => Ok(super::PIPELINE
                .map(|stage| StageState {
                    stage,
                    freshness: Freshness::Missing,
                    stored: None,
                })
                .to_vec()),
            Err(error) => Err(error.into()),
        }
    }

    /// Makes the mesh and stores it with the scene.
    ///
    /// # Errors
    /// HDF5 failures.
    pub fn make_mesh(&mut self) -> Result<Performed, StageError> {
        let started = Instant::now();
        let mesh = Mesh::of_scene(&self.scene);
        let quality = Quality::of(&mesh);
        let performed = self.store(Stage::Mesh, started, |writer| {
            format::write_mesh(writer, &mesh, &quality)
        });
        self.mesh = Some(mesh);
        performed
    }

    /// Assembles and factorises.
    ///
    /// # Errors
    /// A stale or missing mesh, a stiffness that is not positive definite, HDF5 failures.
    pub fn assemble(&mut self) -> Result<Performed, StageError> {
        self.require_fresh_before(Stage::Assemble)?;
        let started = Instant::now();
        self.load_mesh()?;
        let mesh = loaded(&self.mesh);
        let system = DualSystem::new(&self.scene, mesh, self.threads)?;
        let performed = self.store(Stage::Assemble, started, |writer| {
            format::write_assembly(writer, &system)
        });
        self.system = Some(system);
        performed
    }

    /// What each form of the dual operator costs, and whether the dense one is held; `None`
    /// before [`Self::assemble`].
    #[must_use]
    pub fn operator_estimate(&self) -> Option<(OperatorEstimate, bool)> {
        let (mesh, system) = (self.mesh.as_ref()?, self.system.as_ref()?);
        let estimate = OperatorEstimate::new(&system.assembly, mesh.contact.nodes.len());
        Some((estimate, system.explicit.is_some()))
    }

    /// Changes the assemble settings of the scene; stored with the next stage that is written.
    pub fn set_assemble(&mut self, settings: AssembleSettings) {
        self.scene.assemble = settings;
    }

    /// Solves the contact problem; `observe` sees every outer step.
    ///
    /// # Errors
    /// Stale or missing input, HDF5 failures. A solve that does not converge is not an error: it
    /// is stored with its status.
    pub fn solve(
        &mut self,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Result<Performed, StageError> {
        self.require_fresh_before(Stage::Solve)?;
        let started = Instant::now();
        self.load_mesh()?;
        self.load_system()?;
        let (mesh, system) = (loaded(&self.mesh), loaded(&self.system));
        let frame = self.scene.contact.frame();
        let contact = ContactState {
            surface: &mesh.contact,
            frame: &frame,
            law: &self.scene.friction,
        };
        let solution = solve(system, &contact, &self.scene.solve, observe)?;
        let performed = self.store(Stage::Solve, started, |writer| {
            format::write_solution(writer, &solution, &system.assembly.primal.dofs)
        });
        self.solution = Some(solution);
        performed
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
        let mesh = loaded(&self.mesh);
        let report = ContactReport::new(&Solved {
            scene: &self.scene,
            mesh,
            system: self.primal(),
            solution: loaded(&self.solution),
        });
        let frame = self.scene.contact.frame();
        let performed = self.store_with(Stage::Post, started, |transaction, record| {
            write_stage(transaction, Stage::Post, record, |w| {
                format::write_report(w, &report)
            })?;
            write_stage(transaction, Stage::Vtk, record, |w| {
                format::write_vtkhdf(w, mesh, &report, [frame.axis_1, frame.axis_2])
            })
        });
        self.report = Some(report);
        performed
    }

    /// The mesh, the solution and the report of a post-processed file.
    ///
    /// # Errors
    /// Unreadable datasets.
    pub fn results(&mut self) -> Result<(&Mesh, &Solution, &ContactReport), StageError> {
        self.load_mesh()?;
        self.load_solution()?;
        if self.report.is_none() {
            self.report = Some(ContactReport::new(&Solved {
                scene: &self.scene,
                mesh: loaded(&self.mesh),
                system: self.primal(),
                solution: loaded(&self.solution),
            }));
        }
        Ok((
            loaded(&self.mesh),
            loaded(&self.solution),
            loaded(&self.report),
        ))
    }
}

impl Session {
    fn reader(&self) -> Result<Reader, StoreError> {
        Reader::open(self.file.path(), LAYOUT)
    }

    /// A, l and B, from the assembly or read on their own.
    fn primal(&self) -> &PrimalSystem {
        match &self.system {
            Some(system) => &system.assembly.primal,
            None => loaded(&self.primal),
        }
    }

    fn require_fresh_before(&self, stage: Stage) -> Result<(), StageError> {
        let bad = self
            .states()?
            .into_iter()
            .take_while(|state| state.stage != stage)
            .find(|state| state.freshness != Freshness::Fresh);
        match bad {
            None => Ok(()),
            Some(state) => Err(StageError::NotReady {
                file: self.file.path().to_owned(),
                stage,
                upstream: state.stage,
                why: state.freshness.why(),
            }),
        }
    }

    fn load_mesh(&mut self) -> Result<(), FormatError> {
        if self.mesh.is_none() {
            self.mesh = Some(format::read_mesh(&self.reader()?)?);
        }
        Ok(())
    }

    fn load_system(&mut self) -> Result<(), FormatError> {
        if self.system.is_none() {
            self.system = Some(format::read_assembly(&self.reader()?)?);
        }
        Ok(())
    }

    fn load_solution(&mut self) -> Result<(), FormatError> {
        if self.system.is_none() && self.primal.is_none() {
            self.primal = Some(format::read_primal(&self.reader()?)?);
        }
        if self.solution.is_none() {
            let dofs = &self.primal().dofs;
            self.solution = Some(format::read_solution(&self.reader()?, dofs)?);
        }
        Ok(())
    }

    /// Writes the scene and one stage in a transaction.
    fn store(
        &self,
        stage: Stage,
        started: Instant,
        write: impl FnOnce(&mut StageWriter<'_>) -> Result<(), StoreError>,
    ) -> Result<Performed, StageError> {
        self.store_with(stage, started, |transaction, record| {
            write_stage(transaction, stage, record, write)
        })
    }

    /// Writes the scene and what `write` adds for a stage in a transaction.
    fn store_with(
        &self,
        stage: Stage,
        started: Instant,
        write: impl FnOnce(&mut Transaction, &StageRecord) -> Result<(), StoreError>,
    ) -> Result<Performed, StageError> {
        let compute_seconds = started.elapsed().as_secs_f64();
        let storing = Instant::now();
        let states = self.states()?;
        let upstream: Vec<&StoredStage> = states
            .iter()
            .take_while(|state| state.stage != stage)
            .filter_map(|state| state.stored.as_ref())
            .collect();
        let record = StageRecord {
            settings: settings(stage, &self.scene),
            input_digest: input_digest(stage, &self.scene, &upstream),
            seconds: compute_seconds,
            threads: i64::try_from(self.threads).unwrap_or(i64::MAX),
            date: timestamp(),
        };
        let mut transaction = Transaction::begin(&self.file)?;
        let input = StageRecord {
            settings: String::new(),
            input_digest: String::new(),
            seconds: 0.0,
            ..record.clone()
        };
        write_stage(&mut transaction, Stage::Scene, &input, |writer| {
            format::write_scene(writer, &self.scene)
        })?;
        write(&mut transaction, &record)?;
        transaction.commit()?;
        let store_seconds = storing.elapsed().as_secs_f64();
        Ok(Performed {
            stage,
            compute_seconds,
            store_seconds,
        })
    }
}

fn write_stage(
    transaction: &mut Transaction,
    stage: Stage,
    record: &StageRecord,
    write: impl FnOnce(&mut StageWriter<'_>) -> Result<(), StoreError>,
) -> Result<(), StoreError> {
    let mut writer = transaction.stage(stage)?;
    write(&mut writer)?;
    writer.finish(record).map(|_digest| ())
}

/// A value that the caller has just loaded.
fn loaded<T>(value: &Option<T>) -> &T {
    value.as_ref().expect("loaded before use")
}
