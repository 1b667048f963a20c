//! Writing a stage in two goes.

use std::collections::BTreeMap;

use hdf5_metno as hdf5;

use super::layout::Stage;
use super::transaction::Transaction;
use super::writer::StageWriter;

/// A stage whose writer was put aside.
#[derive(Debug)]
pub(super) struct Suspended {
    pub(super) stage: Stage,
    group: hdf5::Group,
    digests: BTreeMap<&'static str, (String, bool)>,
}

impl Suspended {
    pub(super) fn new(stage: Stage, group: hdf5::Group) -> Self {
        Suspended {
            stage,
            group,
            digests: BTreeMap::new(),
        }
    }

    pub(super) fn resume(self, transaction: &mut Transaction) -> StageWriter<'_> {
        StageWriter {
            transaction,
            stage: self.stage,
            group: self.group,
            digests: self.digests,
        }
    }
}

impl StageWriter<'_> {
    /// Whether a dataset was written already, before the writer was suspended.
    pub fn has_written(&self, path: &str) -> bool {
        self.digests.contains_key(path)
    }

    /// Puts the writer aside; [`Transaction::stage`] goes on with the same stage.
    pub fn suspend(self) {
        self.transaction.suspend(Suspended {
            stage: self.stage,
            group: self.group,
            digests: self.digests,
        });
    }
}
