//! What a session reads back and how it stores a stage.

use std::time::Instant;

use contact3d::{contact::Coupling, dual::PrimalSystem, solver::OuterState};
use runfile::{
    Group, GroupRecord, GroupWriter, Home, Reader, StoreError, StoredGroup, Transaction, timestamp,
};

use super::{
    Freshness, Performed, Session, StageError, StageState,
    freshness::{input_digest, settings},
};
use crate::format::{self, FormatError, LAYOUT, Stage};

/// Assembled data above this many bytes go to a file of their own.
///
/// Copying inside the run file costs every later stage about 2 s per gigabyte on a disk of 0.5
/// GB/s: at most an eighth of a second below this size, where one file is worth more.
const KEEP_BESIDE_ABOVE: usize = 64_000_000;

/// Where a session keeps what `assemble` makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AssemblyFile {
    /// In the run file up to 64 MB, above that in a file beside it.
    #[default]
    BySize,
    /// In the run file, whatever its size.
    SelfContained,
    /// With the mesh, in files that the run files of the folder share.
    Shared,
}

impl Session {
    /// Chooses where the assembly is kept; `SelfContained` also takes in one that is kept
    /// elsewhere, at the next commit.
    pub fn keep_assembly(&mut self, assembly_file: AssemblyFile) {
        self.assembly_file = assembly_file;
    }

    /// Takes stages that are kept elsewhere into the run file now; does nothing if there are none.
    ///
    /// # Errors
    /// HDF5 failures.
    pub fn embed_assembly(&mut self) -> Result<(), StageError> {
        let reader = self.reader()?;
        let linked = [Stage::Mesh, Stage::Assemble].map(|stage| reader.linked_file(stage.group()));
        if linked.iter().any(Option::is_some) {
            let mut transaction = self.begin()?;
            transaction.embed_linked();
            self.commit_change(transaction, &[])?;
        }
        Ok(())
    }

    fn home(&self, stage: Stage) -> Home {
        match (stage, self.assembly_file) {
            (Stage::Assemble, AssemblyFile::BySize)
                if format::assembly_bytes(loaded(&self.system)) > KEEP_BESIDE_ABOVE =>
            {
                Home::Beside
            }
            (Stage::Mesh | Stage::Assemble, AssemblyFile::Shared) => Home::Shared,
            _ => Home::RunFile,
        }
    }

    pub(super) fn reader(&self) -> Result<Reader, StoreError> {
        Reader::open(self.file.path(), LAYOUT)
    }

    /// A and l, from the assembly or read on their own.
    pub(super) fn primal(&self) -> &PrimalSystem {
        match &self.system {
            Some(system) => &system.assembly.primal,
            None => &loaded(&self.primal).0,
        }
    }

    /// B, from the assembly or read on its own; `None` without contact.
    pub(super) fn coupling(&self) -> Option<&Coupling> {
        match &self.system {
            Some(system) => system.contact.as_ref().map(|contact| &contact.coupling),
            None => loaded(&self.primal).1.as_ref(),
        }
    }

    /// Refuses to begin a stage on anything but fresh ones, and remembers which these were.
    pub(super) fn require_fresh_before(&mut self, stage: Stage) -> Result<(), StageError> {
        let is_stored = |state: &StageState| {
            let mut pending = self.pending.iter();
            pending.all(|(pending, _)| *pending != state.stage)
        };
        let (fresh, bad): (Vec<StageState>, Vec<StageState>) = self
            .states()?
            .into_iter()
            .take_while(|state| state.stage != stage)
            .filter(is_stored)
            .partition(|state| state.freshness == Freshness::Fresh);
        match bad.into_iter().next() {
            None => {
                let digest = |state: StageState| Some((state.stage, state.stored?.digest));
                self.upstream = fresh.into_iter().filter_map(digest).collect();
                Ok(())
            }
            Some(state) => Err(StageError::NotReady {
                file: self.file.path().to_owned(),
                stage,
                upstream: state.stage,
                why: state.freshness.why(),
            }),
        }
    }

    /// Refuses to go on once the file holds other stages than those that the stage at work builds
    /// on: another program may have replaced or removed it meanwhile.
    pub(super) fn require_unchanged(&self, states: &[StageState]) -> Result<(), StoreError> {
        let holds = |(stage, digest): &(Stage, String)| {
            let mut stored = states
                .iter()
                .filter_map(|s| Some((s.stage, s.stored.as_ref()?)));
            stored.any(|(other, stored)| other == *stage && stored.digest == *digest)
        };
        match self.upstream.iter().all(holds) {
            true => Ok(()),
            false => Err(StoreError::Changed {
                file: self.file.path().to_owned(),
            }),
        }
    }

    pub(super) fn load_mesh(&mut self) -> Result<(), FormatError> {
        if self.mesh.is_none() {
            self.mesh = Some(format::read_mesh(&self.reader()?)?);
        }
        Ok(())
    }

    /// The assembled problem, whatever its loads.
    pub(super) fn load_operator(&mut self) -> Result<(), FormatError> {
        if self.system.is_none() {
            self.system = Some(format::read_assembly(&self.reader()?)?);
            self.loads_applied = false;
        }
        Ok(())
    }

    /// The assembled problem with the loads of the scene.
    pub(super) fn load_system(&mut self) -> Result<(), FormatError> {
        self.load_operator()?;
        if let (false, Some(system)) = (self.loads_applied, &mut self.system) {
            format::read_loads(&Reader::open(self.file.path(), LAYOUT)?, system)?;
            self.loads_applied = true;
        }
        Ok(())
    }

    pub(super) fn load_solution(&mut self) -> Result<(), FormatError> {
        let reader = self.reader()?;
        if self.system.is_some() {
            self.load_system()?;
        } else if self.primal.is_none() {
            let coupling = format::read_coupling(&reader)?;
            self.primal = Some((format::read_primal(&reader)?, coupling));
        }
        if self.solution.is_none() {
            let dofs = &self.primal().dofs;
            self.solution = Some(format::read_solution(&reader, dofs)?);
        }
        Ok(())
    }

    /// Writes the scene, what is pending and a stage just computed in one transaction.
    pub(super) fn store(
        &mut self,
        stage: Stage,
        started: Instant,
    ) -> Result<Performed, StageError> {
        let compute_seconds = started.elapsed().as_secs_f64();
        let storing = Instant::now();
        self.pending.push((stage, compute_seconds));
        self.commit(None)?;
        self.pending.clear();
        self.last_store_seconds = storing.elapsed().as_secs_f64();
        Ok(Performed {
            stage,
            compute_seconds,
            store_seconds: self.last_store_seconds,
        })
    }

    /// Stores the state of an unfinished solve, with what is pending.
    pub(super) fn write_checkpoint(&self, state: &OuterState) -> Result<(), StageError> {
        self.commit(Some(state))
    }

    fn commit(&self, checkpoint: Option<&OuterState>) -> Result<(), StageError> {
        let mut transaction = self.begin()?;
        let states = self.states_in(transaction.previous());
        self.require_unchanged(&states)?;
        // What is damaged cannot be used, and copying it could fail.
        for group in transaction
            .previous()
            .map_or(Vec::new(), Reader::damaged_groups)
        {
            transaction.remove(group);
        }
        let mut stored: Vec<(Stage, StoredGroup)> = states
            .into_iter()
            .filter_map(|state| Some((state.stage, state.stored?)))
            .collect();
        if self.assembly_file == AssemblyFile::SelfContained {
            transaction.embed_linked();
        }
        self.write_scene(&mut transaction)?;
        for &(stage, seconds) in &self.pending {
            stored.retain(|(earlier, _)| *earlier != stage);
            let upstream: Vec<&StoredGroup> = stored
                .iter()
                .filter(|(earlier, _)| *earlier < stage)
                .map(|(_, s)| s)
                .collect();
            let digest = input_digest(stage, &self.settings(stage), &upstream);
            let record = self.record(self.settings(stage), seconds, digest);
            let digest = self.write(&mut transaction, stage, &record)?;
            let units = self.scene().units;
            stored.push((
                stage,
                StoredGroup {
                    record,
                    digest,
                    units,
                },
            ));
        }
        transaction.remove(format::CHECKPOINT);
        if let Some(state) = checkpoint {
            stored.retain(|(earlier, _)| *earlier < Stage::Solve);
            let upstream: Vec<&StoredGroup> = stored.iter().map(|(_, s)| s).collect();
            let digest = input_digest(Stage::Solve, &self.settings(Stage::Solve), &upstream);
            let record = self.record(String::new(), 0.0, digest);
            let home = Home::RunFile;
            write_group(
                &mut transaction,
                format::CHECKPOINT,
                home,
                &record,
                |writer| format::write_checkpoint(writer, state),
            )?;
        }
        let stored = self.pending.iter().map(|(stage, _)| stage.group());
        let stored = stored.chain(checkpoint.map(|_| format::CHECKPOINT));
        Ok(self.commit_change(transaction, &stored.collect::<Vec<Group>>())?)
    }

    pub(super) fn write_scene(&self, transaction: &mut Transaction) -> Result<(), StoreError> {
        let record = self.record(String::new(), 0.0, String::new());
        write_group(
            transaction,
            format::SCENE,
            Home::RunFile,
            &record,
            |writer| format::write_scene(writer, self.scene()),
        )?;
        Ok(())
    }

    /// The settings of a stage in force, as TOML.
    pub(super) fn settings(&self, stage: Stage) -> String {
        settings(stage, self.scene(), self.start_digest())
    }

    fn record(&self, settings: String, seconds: f64, input_digest: String) -> GroupRecord {
        GroupRecord {
            settings,
            input_digest,
            seconds,
            threads: i64::try_from(self.threads).unwrap_or(i64::MAX),
            date: timestamp(),
        }
    }

    /// Writes one computed stage and returns its digest.
    fn write(
        &self,
        transaction: &mut Transaction,
        stage: Stage,
        record: &GroupRecord,
    ) -> Result<String, StoreError> {
        let mesh = loaded(&self.mesh);
        let home = self.home(stage);
        match stage {
            Stage::Mesh => write_group(transaction, stage.group(), home, record, |writer| {
                format::write_mesh(writer, mesh, loaded(&self.quality))
            }),
            Stage::Assemble => write_group(transaction, stage.group(), home, record, |writer| {
                format::write_assembly(writer, loaded(&self.system))
            }),
            Stage::Load => write_group(transaction, stage.group(), home, record, |writer| {
                format::write_loads(writer, loaded(&self.system))
            }),
            Stage::Solve => write_group(transaction, stage.group(), home, record, |writer| {
                let n_panes = mesh.contact.as_ref().map_or(0, |surface| surface.n_panes());
                let dofs = &self.primal().dofs;
                format::write_solution(writer, loaded(&self.solution), n_panes, dofs)
            }),
            Stage::Post => {
                let report = loaded(&self.report);
                let frame = self.interface.as_ref().map(|interface| &interface.frame);
                let vtkhdf = write_group(transaction, format::VTKHDF, home, record, |writer| {
                    format::write_vtkhdf(writer, mesh, report, frame)
                })?;
                write_group(transaction, stage.group(), home, record, |writer| {
                    let face = mesh.contact.as_ref().zip(frame);
                    format::write_report(writer, report, face, &vtkhdf)
                })
            }
        }
    }
}

pub(super) fn write_group(
    transaction: &mut Transaction,
    group: Group,
    home: Home,
    record: &GroupRecord,
    write: impl FnOnce(&mut GroupWriter<'_>) -> Result<(), StoreError>,
) -> Result<String, StoreError> {
    let mut writer = transaction.group(group, home)?;
    write(&mut writer)?;
    writer.finish(record)
}

/// A value that the caller has just loaded.
pub(super) fn loaded<T>(value: &Option<T>) -> &T {
    value.as_ref().expect("loaded before use")
}
