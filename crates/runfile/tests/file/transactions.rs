//! A change happens whole or not at all.

use std::fs::{self, TryLockError};
use std::io;
use std::path::Path;

use crate::sample::*;
use contact3d_runfile::{StoreError, Temporary, Transaction, lock_file, remove_left_overs};

#[test]
fn dropping_a_transaction_leaves_the_old_state_and_no_temporary() {
    let (folder, file) = folder();
    save_grid(&file, 5);
    let before = fs::read(&file).unwrap();
    let run_file = lock(&file).unwrap();
    let mut transaction = Transaction::begin(&run_file).unwrap();
    let mut writer = transaction.group(GRID).unwrap();
    writer.write("/grid/tags", &[1_u8; 4], &[4]).unwrap();
    assert_eq!(hidden(folder.path()).len(), 1);
    drop(transaction);
    assert!(hidden(folder.path()).is_empty());
    assert_eq!(fs::read(&file).unwrap(), before);
}

#[test]
fn what_a_killed_process_leaves_is_harmless_and_removed() {
    let (folder, file) = folder();
    save_grid(&file, 5);
    let temporary = folder.path().join(".run.h5.part-0123abcd");
    fs::write(&temporary, "half a file").unwrap();
    open(&file).unwrap().require_group(GRID).unwrap();
    let run_file = lock(&file).unwrap();
    assert!(!temporary.exists());
    drop(run_file);
    let run_file = lock(&file).unwrap();
    let mut transaction = Transaction::begin(&run_file).unwrap();
    let mut writer = transaction.group(GRID).unwrap();
    writer.write("/grid/tags", &[1_u8; 4], &[4]).unwrap();
    std::mem::forget(transaction);
    open(&file).unwrap().require_group(GRID).unwrap();
}

/// Others who may write to the folder cannot have our files written through links of theirs.
#[cfg(unix)]
#[test]
fn links_that_others_plant_are_not_followed() {
    use std::os::unix::fs::symlink;
    let (folder, file) = folder();
    let private = folder.path().join("private");
    fs::write(&private, "precious").unwrap();
    for planted in [".run.h5.part", ".run.h5.previous"] {
        symlink(&private, folder.path().join(planted)).unwrap();
    }
    save_grid(&file, 5);
    assert!(!file.is_symlink());
    let lock_file = folder.path().join(".run.h5.lock");
    fs::remove_file(&lock_file).unwrap();
    symlink(folder.path().join("made"), &lock_file).unwrap();
    assert!(matches!(lock(&file), Err(StoreError::NotAFile { file }) if file == lock_file));
    assert!(!folder.path().join("made").exists());
    assert_eq!(fs::read_to_string(&private).unwrap(), "precious");
}

/// `flock` of NFS without its lock daemon.
#[cfg(unix)]
#[test]
fn a_file_system_without_locks_is_named() {
    const ENOLCK: i32 = 37;
    let (folder, _) = folder();
    let lock = |_: &fs::File| Err(TryLockError::Error(io::Error::from_raw_os_error(ENOLCK)));
    let refused = lock_file(&folder.path().join("lock"), lock).unwrap_err();
    let text = refused.to_string();
    assert!(
        text.contains("no locks") && text.contains("HDF5_USE_FILE_LOCKING=FALSE"),
        "{text}"
    );
}

/// The lock of a new file is still there for a moment when it is in its place: a reader may lock it too, nobody may remove it.
#[test]
fn a_temporary_file_may_be_read_but_not_taken_for_a_left_over() {
    let (_folder, file) = folder();
    let create = |path: &Path| fs::File::create_new(path);
    let (temporary, _handle, _) = Temporary::beside(&file, create).unwrap();
    remove_left_overs(&file);
    temporary.publish(&file).unwrap();
    let reader = fs::File::open(&file).unwrap();
    reader.try_lock_shared().unwrap();
    assert!(reader.try_lock().is_err());
}

#[test]
fn a_second_lock_is_refused_until_the_first_is_dropped() {
    let (_folder, file) = folder();
    let first = lock(&file).unwrap();
    assert!(matches!(lock(&file), Err(StoreError::Busy { .. })));
    drop(first);
    lock(&file).unwrap();
}

#[test]
fn readers_keep_the_state_they_opened() {
    let (_folder, file) = folder();
    save_grid(&file, 5);
    let before = open(&file).unwrap();
    save_grid(&file, 6);
    assert_eq!(
        before.read_vec::<f64>("/grid/coordinates").unwrap(),
        coordinates(5)
    );
    assert_eq!(coordinates_in(&file), coordinates(6));
}

#[test]
fn twenty_reruns_do_not_grow_the_file() {
    let (_folder, file) = folder();
    save_grid(&file, 2000);
    save_field(&file, 2000, &[0.5]);
    let size = || fs::metadata(&file).unwrap().len();
    save_grid(&file, 2000);
    let first = size();
    for _ in 0..20 {
        save_grid(&file, 2000);
        save_field(&file, 2000, &[0.5]);
    }
    // The order of the groups may change the padding between them: 8 KiB of a file of about 160
    // KiB.
    assert!(size() <= first + 8192, "{first} bytes became {}", size());
    open(&file).unwrap().require_group(FIELD).unwrap();
}

#[test]
fn a_new_grid_makes_the_stale_group_unreadable_not_the_grid() {
    let (_folder, file) = folder();
    save_grid(&file, 5);
    save_field(&file, 5, &[]);
    save_grid(&file, 7);
    let reader = open(&file).unwrap();
    reader.read::<f64>("/grid/coordinates").unwrap();
    let message = reader
        .read_enum::<State>("/field/zone")
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("n_nodes = 7 by /grid/coordinates"),
        "{message}"
    );
    assert!(message.contains("found shape [5]"), "{message}");
    save_field(&file, 7, &[]);
    open(&file)
        .unwrap()
        .read_enum::<State>("/field/zone")
        .unwrap();
}

#[test]
fn a_removed_group_is_gone_and_the_others_stay() {
    let (_folder, file) = folder();
    save_grid(&file, 5);
    save_field(&file, 5, &[]);
    change(&file, |transaction| {
        assert!(transaction.previous().unwrap().has("/field/zone"));
        transaction.remove(FIELD);
    });
    let reader = open(&file).unwrap();
    assert_eq!(reader.group_record(FIELD).unwrap(), None);
    reader.require_group(GRID).unwrap();
}

#[test]
fn a_symbolic_link_stays_a_link_and_permissions_stay() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let (folder, file) = folder();
    save_grid(&file, 5);
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
    let link = folder.path().join("link.h5");
    symlink(&file, &link).unwrap();
    save_grid(&link, 6);
    assert!(link.is_symlink());
    assert_eq!(coordinates_in(&file), coordinates(6));
    assert_eq!(
        fs::metadata(&file).unwrap().permissions().mode() & 0o777,
        0o640
    );
    fs::set_permissions(&file, fs::Permissions::from_mode(0o440)).unwrap();
    let run_file = lock(&file).unwrap();
    assert!(matches!(
        Transaction::begin(&run_file),
        Err(StoreError::Io { .. })
    ));
}
