//! Files that are not what was written are refused with a clear error.

use std::fs;
use std::path::Path;

use hdf5_metno as hdf5;

use crate::sample::*;
use contact3d_runfile::{IfMissing, Layout, Reader, RunFile, StoreError};

fn edit(file: &Path, change: impl Fn(&hdf5::File)) {
    change(&hdf5::File::open_rw(file).unwrap());
}

fn saved() -> (tempfile::TempDir, std::path::PathBuf) {
    let (folder, file) = folder();
    save_grid(&file, 5);
    save_field(&file, 5, &[0.5]);
    (folder, file)
}

#[test]
fn a_file_that_another_program_changed_is_refused() {
    type Edit = fn(&hdf5::File) -> hdf5::Result<()>;
    let edits: [(&str, Edit); 10] = [
        ("a number", |file| {
            file.dataset("/grid/coordinates")?
                .write_slice(&[9.0], (0, 0..1))
        }),
        ("an entry of a matrix", |file| {
            let data = file.dataset("/field/stiffness/data")?;
            data.write_slice(&[9.0], 1..2)
        }),
        ("a state", |file| {
            file.dataset("/field/zone")?
                .write_slice(&[State::Slip], 0..1)
        }),
        ("a text", |file| {
            let text: hdf5::types::VarLenUnicode = "moved".parse().unwrap();
            file.dataset("/grid/names")?.write_slice(&[text], 0..1)
        }),
        ("an attribute of a dataset", |file| {
            file.dataset("/grid/tags")?.delete_attr("units")
        }),
        ("an attribute of a group", |file| {
            file.group("/field")?
                .attr("seconds")?
                .write_scalar(&0.5_f64)
        }),
        ("an attribute of the root", |file| {
            file.new_attr::<i64>().create("mine")?.write_scalar(&1_i64)
        }),
        ("a dataset less", |file| file.unlink("/grid/tags")),
        ("a dataset more", |file| {
            let builder = file.new_dataset_builder();
            builder.with_data(&[1.0]).create("/mine").map(drop)
        }),
        ("a link", |file| {
            file.unlink("/grid/tags")?;
            file.link_soft("/grid/cells", "/grid/tags")
        }),
    ];
    for (what, change) in edits {
        let (_folder, file) = saved();
        edit(&file, |file| change(file).unwrap());
        let before = fs::read(&file).unwrap();
        let error = open(&file).unwrap_err();
        assert!(
            matches!(error, StoreError::Altered { .. }),
            "{what}: {error}"
        );
        let refused = lock(&file).unwrap_err();
        assert!(
            matches!(refused, StoreError::Altered { .. }),
            "{what}: {refused}"
        );
        assert_eq!(fs::read(&file).unwrap(), before);
    }
}

#[test]
fn a_file_that_another_program_opened_for_writing_and_left_is_as_it_was() {
    let (_folder, file) = saved();
    let before = fs::read(&file).unwrap();
    edit(&file, |_| ());
    assert_eq!(fs::read(&file).unwrap(), before);
    assert_eq!(stiffness_in(&file), stiffness(5));
}

#[test]
fn wrong_types_and_shapes_are_found() {
    let (_folder, file) = saved();
    edit(&file, |file| {
        file.unlink("/grid/tags").unwrap();
        file.new_dataset_builder()
            .with_data(&[1.0_f32, 2.0])
            .create("/grid/tags")
            .unwrap();
        file.unlink("/grid/coordinates").unwrap();
        file.new_dataset_builder()
            .with_data(&[1.0, 2.0])
            .create("/grid/coordinates")
            .unwrap();
        file.unlink("/grid/cells").unwrap();
    });
    fit_digest(&file);
    let reader = open(&file).unwrap();
    let message = reader.read::<u8>("/grid/tags").unwrap_err().to_string();
    assert!(
        message.contains("/grid/tags: expected type uint8, found type float32"),
        "{message}"
    );
    let message = reader
        .read::<f64>("/grid/coordinates")
        .unwrap_err()
        .to_string();
    assert!(message.contains("expected shape [n_nodes"), "{message}");
    let message = reader.read_indices("/grid/cells").unwrap_err().to_string();
    assert!(
        message.contains("/grid/cells is missing; run `draw` again"),
        "{message}"
    );
}

#[test]
fn not_finite_is_refused_where_asked() {
    let (_folder, file) = folder();
    save_field(&file, 5, &[1.0, f64::NAN]);
    let error = open(&file)
        .unwrap()
        .read_finite_f64("/field/history/seconds")
        .unwrap_err();
    assert!(matches!(error, StoreError::NotFinite { index: 1, .. }));
}

#[test]
fn every_truncation_is_an_error_and_never_wrong_data() {
    let (_folder, file) = saved();
    let whole = fs::read(&file).unwrap();
    for length in (0..whole.len()).step_by(whole.len() / 97) {
        fs::write(&file, &whole[..length]).unwrap();
        assert!(
            open(&file).is_err(),
            "{length} of {} bytes were opened",
            whole.len()
        );
    }
}

#[test]
fn every_flipped_byte_is_seen() {
    let (_folder, file) = saved();
    let whole = fs::read(&file).unwrap();
    let positions = (0..whole.len()).step_by(whole.len() / 199);
    for position in positions.chain(0..512) {
        let mut bytes = whole.clone();
        bytes[position] ^= 0x5a;
        fs::write(&file, &bytes).unwrap();
        assert!(open(&file).is_err(), "byte {position}");
    }
}

#[test]
fn foreign_files_are_refused_and_left_alone() {
    let (folder, file) = folder();
    fs::write(&file, "a letter to a friend, much longer than a signature").unwrap();
    assert!(matches!(lock(&file), Err(StoreError::NotHdf5 { .. })));
    hdf5::File::create(&file)
        .unwrap()
        .create_group("theirs")
        .unwrap();
    let before = fs::read(&file).unwrap();
    assert!(matches!(lock(&file), Err(StoreError::NotOurs { .. })));
    assert_eq!(fs::read(&file).unwrap(), before);
    assert!(matches!(
        lock(folder.path()),
        Err(StoreError::IsDirectory { .. })
    ));
    assert!(matches!(
        lock(&folder.path().join("no/run.h5")),
        Err(StoreError::FolderMissing { .. })
    ));
    let refused = RunFile::lock(&folder.path().join("new.h5"), SAMPLE, IfMissing::Refuse);
    assert!(matches!(refused, Err(StoreError::NotFound { .. })));
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        1,
        "only the foreign file is there"
    );
}

#[test]
fn older_minor_versions_are_read_and_newer_ones_refused() {
    let (_folder, file) = saved();
    let reads = |format_version| {
        Reader::open(
            &file,
            Layout {
                format_version,
                ..SAMPLE
            },
        )
    };
    assert!(reads([1, 2]).is_ok() && reads([1, 3]).is_ok());
    for older in [[1, 1], [0, 9], [2, 0]] {
        let error = reads(older).unwrap_err();
        assert!(
            matches!(error, StoreError::Version { found: [1, 2], .. }),
            "{error}"
        );
        let text = error.to_string();
        assert!(text.contains("sample 0.1") && text.contains("run again"));
    }
}
