//! Groups that belong to the scene alone, beside the stages.

use contact3d::scene::Scene;
use runfile::{Group, GroupRecord, GroupWriter, Home, RunFile, StoreError, Transaction};

use super::{StageError, store::write_group};
use crate::format;

/// Stores a group with the scene that it was computed from, in one step.
pub(super) fn store_with_scene(
    file: &RunFile,
    scene: &Scene,
    group: Group,
    record: &GroupRecord,
    write: impl FnOnce(&mut GroupWriter<'_>) -> Result<(), StoreError>,
) -> Result<(), StageError> {
    let mut transaction = Transaction::begin(file)?;
    let of_scene = GroupRecord {
        settings: String::new(),
        input_digest: String::new(),
        seconds: 0.0,
        ..record.clone()
    };
    write_group(
        &mut transaction,
        format::SCENE,
        Home::RunFile,
        &of_scene,
        |writer| format::write_scene(writer, scene),
    )?;
    write_group(&mut transaction, group, Home::RunFile, record, write)?;
    transaction.commit()?;
    Ok(())
}
