//! What a session reads back and how it stores a stage.

use std::time::Instant;

use super::{
    Freshness, Performed, Session, StageError,
    freshness::{input_digest, settings},
};
use crate::{
    dual::PrimalSystem,
    format::{self, FormatError, LAYOUT},
    store::{
        Reader, Stage, StageRecord, StageWriter, StoreError, StoredStage, Transaction, timestamp,
    },
};

impl Session {
    pub(super) fn reader(&self) -> Result<Reader, StoreError> {
        Reader::open(self.file.path(), LAYOUT)
    }

    /// A, l and B, from the assembly or read on their own.
    pub(super) fn primal(&self) -> &PrimalSystem {
        match &self.system {
            Some(system) => &system.assembly.primal,
            None => loaded(&self.primal),
        }
    }

    pub(super) fn require_fresh_before(&self, stage: Stage) -> Result<(), StageError> {
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

    pub(super) fn load_mesh(&mut self) -> Result<(), FormatError> {
        if self.mesh.is_none() {
            self.mesh = Some(format::read_mesh(&self.reader()?)?);
        }
        Ok(())
    }

    pub(super) fn load_system(&mut self) -> Result<(), FormatError> {
        if self.system.is_none() {
            self.system = Some(format::read_assembly(&self.reader()?)?);
        }
        Ok(())
    }

    pub(super) fn load_solution(&mut self) -> Result<(), FormatError> {
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
    pub(super) fn store(
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
    pub(super) fn store_with(
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

pub(super) fn write_stage(
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
pub(super) fn loaded<T>(value: &Option<T>) -> &T {
    value.as_ref().expect("loaded before use")
}
