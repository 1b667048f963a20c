//! A group in a file of its own: written once, seen through the link, refused when it is not what
//! was linked.

use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};

use hdf5_metno as hdf5;

use crate::sample::*;
use contact3d_runfile::{LinkProblem, StoreError, Transaction};

/// Writes the field of the sample to a file of its own.
fn save_field_beside(file: &Path, n_nodes: usize) -> String {
    change(file, |transaction| {
        transaction.keep_beside(FIELD);
        let writer = transaction.group(FIELD).unwrap();
        write_field(writer, n_nodes, &[0.5]).unwrap()
    })
}

/// A grid in the run file, a field beside it.
fn saved(n_nodes: usize) -> (tempfile::TempDir, PathBuf) {
    let (folder, file) = folder();
    save_grid(&file, n_nodes);
    save_field_beside(&file, n_nodes);
    (folder, file)
}

fn linked_path(file: &Path) -> PathBuf {
    let (name, bytes) = open(file).unwrap().linked_file(FIELD).unwrap();
    let path = file.with_file_name(name);
    assert_eq!(fs::metadata(&path).unwrap().len(), bytes);
    path
}

/// Lets a run file say another name for the file of the field, and link it.
fn link_field(file: &Path, name: &str, target: &str) {
    let edited = hdf5::File::open_rw(file).unwrap();
    edited.delete_attr("field_file").unwrap();
    let text: hdf5::types::VarLenUnicode = name.parse().unwrap();
    let attribute = edited.new_attr::<hdf5::types::VarLenUnicode>();
    let attribute = attribute.create("field_file").unwrap();
    attribute.write_scalar(&text).unwrap();
    drop(attribute);
    edited.unlink("field").unwrap();
    edited.link_external(target, "/field", "field").unwrap();
    drop(edited);
    fit_digest(file);
}

/// What is wrong with the file of the field.
fn problem(file: &Path) -> LinkProblem {
    let reader = open(file).unwrap();
    reader.require_group(GRID).unwrap();
    assert!(!reader.has("/field/energy"));
    assert_eq!(reader.linked_file(FIELD), None);
    let failures = [
        reader.group_record(FIELD).map(drop),
        reader.require_group(FIELD).map(drop),
        reader.group_bytes(FIELD).map(drop),
        reader.read::<f64>("/field/energy").map(drop),
        reader.read_matrix("/field/stiffness").map(drop),
    ];
    let mut problems = failures.map(|failure| match failure {
        Err(StoreError::Linked { problem, group, .. }) => {
            assert_eq!(group, FIELD);
            problem
        }
        other => panic!("{other:?}"),
    });
    problems.sort_by_key(ToString::to_string);
    assert_eq!(problems[0], problems[4]);
    problems[0].clone()
}

fn files(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> = names.filter(|name| !name.ends_with(".lock")).collect();
    names.sort();
    names
}

#[test]
fn a_linked_group_reads_like_one_in_the_run_file_and_others_follow_the_link() {
    let (_folder, file) = saved(5000);
    let (_other_folder, whole) = folder();
    save_grid(&whole, 5000);
    let digest = save_field(&whole, 5000, &[0.5]);
    let reader = open(&file).unwrap();
    assert_eq!(reader.require_group(FIELD).unwrap().digest, digest);
    assert_eq!(stiffness_in(&file), stiffness(5000));
    assert_eq!(reader.read_vec::<f64>("/field/energy").unwrap(), [-12.5]);
    let bytes = |file: &Path| open(file).unwrap().group_bytes(FIELD).unwrap();
    assert_eq!(bytes(&file), bytes(&whole));
    let path = linked_path(&file);
    let name = path.file_name().unwrap().to_str().unwrap();
    assert_eq!(name, format!("field-{}.h5", &digest[..16]));
    assert!(matches!(open(&path), Err(StoreError::NotOurs { .. })));
    drop(reader);
    let followed = hdf5::File::open(&file).unwrap();
    let data = followed.dataset("/field/stiffness/data").unwrap();
    assert_eq!(data.read_raw::<f64>().unwrap(), stiffness(5000).data);
}

#[test]
fn the_size_of_the_linked_file_bounds_its_datasets() {
    let (_folder, file) = saved(5);
    change(&file, |transaction| {
        transaction.remove(GRID);
        transaction.keep_beside(FIELD);
        let writer = transaction.group(FIELD).unwrap();
        write_field(writer, 9000, &[]).unwrap();
    });
    let values = 8 * 9000;
    assert!(fs::metadata(&file).unwrap().len() < values);
    assert!(fs::metadata(linked_path(&file)).unwrap().len() > values);
    assert_eq!(stiffness_in(&file), stiffness(9000));
}

#[test]
fn later_commits_leave_the_linked_file_alone() {
    let (_folder, file) = saved(5);
    let path = linked_path(&file);
    let inode = fs::metadata(&path).unwrap().ino();
    for _ in 0..3 {
        save_grid(&file, 5);
    }
    assert_eq!(fs::metadata(&path).unwrap().ino(), inode);
    open(&file).unwrap().require_group(FIELD).unwrap();
}

#[test]
fn a_missing_file_is_named_and_the_group_can_be_written_again() {
    let (_folder, file) = saved(5);
    let path = linked_path(&file);
    let kept = path.with_extension("kept");
    fs::rename(&path, &kept).unwrap();
    assert_eq!(problem(&file), LinkProblem::Missing { file: path.clone() });
    let message = open(&file).unwrap().require_group(FIELD).unwrap_err();
    let message = message.to_string();
    assert!(message.contains(path.to_str().unwrap()), "{message}");
    assert!(message.contains("run `compute` again"), "{message}");
    save_grid(&file, 5);
    fs::rename(&kept, &path).unwrap();
    open(&file).unwrap().require_group(FIELD).unwrap();
    fs::remove_file(&path).unwrap();
    save_field_beside(&file, 5);
    open(&file).unwrap().require_group(FIELD).unwrap();
}

#[test]
fn a_replaced_or_damaged_file_is_refused() {
    let (_folder, file) = saved(5);
    let path = linked_path(&file);
    let (_other_folder, other) = saved(6);
    fs::copy(linked_path(&other), &path).unwrap();
    let replaced = problem(&file);
    assert!(matches!(&replaced, LinkProblem::Replaced { file, .. } if *file == path));
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    assert!(matches!(problem(&file), LinkProblem::Unusable { .. }));
    fs::write(&path, "not HDF5").unwrap();
    assert!(matches!(problem(&file), LinkProblem::Unusable { .. }));
    fs::copy(&other, &path).unwrap();
    assert!(
        matches!(problem(&file), LinkProblem::Unusable { reason } if reason.contains("sample stage"))
    );
    save_field_beside(&file, 5);
    open(&file).unwrap().require_group(FIELD).unwrap();
}

#[test]
fn an_altered_file_is_refused() {
    let (_folder, file) = saved(5);
    let path = linked_path(&file);
    hdf5::File::open_rw(&path)
        .unwrap()
        .dataset("/field/stiffness/data")
        .unwrap()
        .write_slice(&[9.0], 1..2)
        .unwrap();
    match problem(&file) {
        LinkProblem::Unusable { reason } => {
            assert!(reason.contains(path.to_str().unwrap()), "{reason}");
            assert!(reason.contains("its bytes are not those"), "{reason}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn links_that_lead_elsewhere_are_never_followed() {
    let (folder, file) = saved(5);
    let path = linked_path(&file);
    let name = path.file_name().unwrap().to_str().unwrap().to_owned();
    fs::create_dir(folder.path().join("sub")).unwrap();
    fs::copy(&path, folder.path().join("sub").join(&name)).unwrap();
    let elsewhere = [
        format!("sub/{name}"),
        format!("../{name}"),
        path.to_str().unwrap().to_owned(),
        format!("sub\\{name}"),
        name.replace("field-", "grid-"),
        format!("run.h5/{name}"),
        format!(".{name}"),
        name.to_uppercase(),
        String::new(),
    ];
    for found in elsewhere {
        let target = if found.is_empty() { "other.h5" } else { &found };
        link_field(&file, &found, target);
        assert_eq!(problem(&file), LinkProblem::NotAName { found });
    }
    save_grid(&file, 5);
    assert_eq!(open(&file).unwrap().group_record(FIELD).unwrap(), None);
}

/// Removes what a run file linked and links no more.
fn remove_unlinked(file: &Path, before: Vec<String>) {
    lock(file).unwrap().remove_unlinked(before);
}

#[test]
fn what_no_run_file_links_any_more_can_be_removed() {
    let (folder, file) = saved(5);
    let first = linked_path(&file);
    let before = lock(&file).unwrap().linked_names();
    save_field_beside(&file, 5);
    assert_eq!(
        linked_path(&file),
        first,
        "the same content has the same name"
    );
    remove_unlinked(&file, before.clone());
    assert!(first.exists());
    save_grid(&file, 6);
    save_field_beside(&file, 6);
    remove_unlinked(&file, before);
    assert!(!first.exists());
    let second = linked_path(&file);
    let before = lock(&file).unwrap().linked_names();
    let copy = folder.path().join("copy.h5");
    fs::copy(&file, &copy).unwrap();
    save_field(&file, 6, &[0.5]);
    assert_eq!(open(&file).unwrap().linked_file(FIELD), None);
    remove_unlinked(&file, before.clone());
    assert!(second.exists(), "the copy still uses it");
    fs::remove_file(&copy).unwrap();
    let others = ["run.h5", "../run.h5", "notes.txt"].map(String::from);
    remove_unlinked(&file, [before, others.into()].concat());
    assert_eq!(files(folder.path()), ["run.h5"]);
}

/// A disk that fills up after the file beside the run file: the run file keeps its state, and what it never linked can be found.
#[test]
fn a_change_that_fails_names_what_it_wrote_beside() {
    let (folder, file) = folder();
    save_grid(&file, 5);
    let before = fs::read(&file).unwrap();
    let locked = lock(&file).unwrap();
    let mut transaction = Transaction::begin(&locked).unwrap();
    let names = files(folder.path());
    let hidden = names.iter().find(|name| name.starts_with(".run.h5"));
    transaction.keep_beside(FIELD);
    write_field(transaction.group(FIELD).unwrap(), 5, &[0.5]).unwrap();
    let names = transaction.names_beside();
    assert_eq!(names.len(), 1);
    fs::remove_file(folder.path().join(hidden.unwrap())).unwrap();
    transaction.commit().unwrap_err();
    assert_eq!(fs::read(&file).unwrap(), before);
    assert!(folder.path().join(&names[0]).exists());
    locked.remove_unlinked(names);
    assert_eq!(files(folder.path()), ["run.h5"]);
}

/// A run file that cannot be read, or that was written by a later version, may link any file of the folder.
#[test]
fn nothing_is_removed_while_a_file_does_not_tell_what_it_links() {
    let (folder, file) = saved(5);
    let shared = linked_path(&file);
    let before = lock(&file).unwrap().linked_names();
    let other = folder.path().join("other.h5");
    fs::copy(&file, &other).unwrap();
    let bytes = fs::read(&other).unwrap();
    fs::write(&other, &bytes[..bytes.len() - 1]).unwrap();
    save_field(&file, 5, &[0.5]);
    remove_unlinked(&file, before.clone());
    assert!(shared.exists());
    fs::remove_file(&other).unwrap();
    // A process that is about to link it has locked it.
    let linking = fs::File::open(&shared).unwrap();
    linking.lock_shared().unwrap();
    remove_unlinked(&file, before.clone());
    assert!(shared.exists());
    drop(linking);
    remove_unlinked(&file, before);
    assert!(!shared.exists());
}

#[test]
fn two_run_files_link_one_file_and_a_write_protected_one_stays() {
    let (folder, file) = folder();
    save_grid(&file, 5);
    let digest = save_field_beside(&file, 5);
    let shared = format!("field-{}.h5", &digest[..16]);
    let path = linked_path(&file);
    assert_eq!(path, folder.path().join(&shared));
    let other = folder.path().join("other.h5");
    save_grid(&other, 5);
    save_field_beside(&other, 5);
    assert_eq!(files(folder.path()), [&*shared, "other.h5", "run.h5"]);
    fs::set_permissions(&path, fs::Permissions::from_mode(0o440)).unwrap();
    assert_eq!(stiffness_in(&file), stiffness(5));
    let locked = lock(&file).unwrap();
    let mut transaction = Transaction::begin(&locked).unwrap();
    transaction.keep_beside(FIELD);
    let writer = transaction.group(FIELD).unwrap();
    write_field(writer, 5, &[0.5]).unwrap();
    assert!(matches!(transaction.commit(), Err(StoreError::Io { file, .. }) if file == path));
    drop(locked);
    for each in [&file, &other] {
        save_field(each, 5, &[0.5]);
    }
    remove_unlinked(&file, vec![shared]);
    assert!(path.exists());
}

#[test]
fn killed_between_the_two_renames_the_old_state_is_whole() {
    let (folder, file) = saved(5);
    let (_later_folder, later) = saved(5);
    save_grid(&later, 6);
    save_field_beside(&later, 6);
    // What the disk holds at that moment: the new file of the group, and the new run file under its
    // hidden name.
    let new = linked_path(&later);
    let orphan = folder.path().join(new.file_name().unwrap());
    fs::copy(&new, &orphan).unwrap();
    fs::copy(&later, folder.path().join(".run.h5.part-0123abcd")).unwrap();
    open(&file).unwrap().require_group(FIELD).unwrap();
    assert_eq!(stiffness_in(&file), stiffness(5));
    let old = linked_path(&file);
    drop(lock(&file).unwrap());
    assert!(old.exists() && !orphan.exists());
    assert_eq!(files(folder.path()).len(), 2);
}

#[test]
fn a_dropped_transaction_leaves_no_file_of_the_group() {
    let (folder, file) = saved(5);
    let before = files(folder.path());
    let lock = lock(&file).unwrap();
    let mut transaction = Transaction::begin(&lock).unwrap();
    transaction.keep_beside(FIELD);
    let writer = transaction.group(FIELD).unwrap();
    write_field(writer, 5, &[]).unwrap();
    assert_eq!(hidden(folder.path()).len(), 2, "the run file and the group");
    std::mem::forget(transaction);
    drop(lock);
    let lock = crate::sample::lock(&file).unwrap();
    assert_eq!(
        files(folder.path()),
        before,
        "what a killed process leaves is removed"
    );
    let mut transaction = Transaction::begin(&lock).unwrap();
    transaction.keep_beside(FIELD);
    let writer = transaction.group(FIELD).unwrap();
    write_field(writer, 5, &[]).unwrap();
    drop(transaction);
    assert_eq!(files(folder.path()), before);
}

#[test]
fn a_linked_group_can_be_taken_into_the_run_file() {
    let (folder, file) = saved(5);
    let digest = open(&file).unwrap().require_group(FIELD).unwrap().digest;
    change(&file, Transaction::embed_linked);
    for file in files(folder.path()).iter().filter(|file| *file != "run.h5") {
        fs::remove_file(folder.path().join(file)).unwrap();
    }
    let reader = open(&file).unwrap();
    assert_eq!(reader.require_group(FIELD).unwrap().digest, digest);
    assert_eq!(stiffness_in(&file), stiffness(5));
}

#[test]
fn a_symbolic_link_to_the_run_file_finds_the_linked_file() {
    let (_folder, file) = saved(5);
    let elsewhere = tempfile::tempdir().unwrap();
    let link = elsewhere.path().join("link.h5");
    symlink(&file, &link).unwrap();
    open(&link).unwrap().require_group(FIELD).unwrap();
    save_field_beside(&link, 5);
    assert_eq!(files(elsewhere.path()), ["link.h5"]);
    open(&file).unwrap().require_group(FIELD).unwrap();
}
