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
fn altered_values_are_found_in_every_kind() {
    let (_folder, file) = saved();
    edit(&file, |file| {
        file.dataset("/grid/coordinates")
            .unwrap()
            .write_slice(&[9.0], (0, 0..1))
            .unwrap();
        file.dataset("/field/stiffness/data")
            .unwrap()
            .write_slice(&[9.0], 1..2)
            .unwrap();
        file.dataset("/field/zone")
            .unwrap()
            .write_slice(&[State::Slip], 0..1)
            .unwrap();
        let text: hdf5::types::VarLenUnicode = "moved".parse().unwrap();
        file.dataset("/grid/names")
            .unwrap()
            .write_slice(&[text], 0..1)
            .unwrap();
    });
    let reader = open(&file).unwrap();
    let altered =
        |error: StoreError| assert!(matches!(error, StoreError::Altered { .. }), "{error}");
    altered(reader.read::<f64>("/grid/coordinates").unwrap_err());
    altered(reader.read_matrix("/field/stiffness").unwrap_err());
    altered(reader.read_enum::<State>("/field/zone").unwrap_err());
    altered(reader.read_texts("/grid/names").unwrap_err());
    assert!(reader.read_indices("/grid/cells").is_ok());
}

#[test]
fn wrong_type_shape_and_unknown_datasets_are_found() {
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
        file.new_dataset_builder()
            .with_data(&[1.0])
            .create("/field/more/secret")
            .unwrap();
    });
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
    assert!(matches!(
        reader.check_group(GRID),
        Err(StoreError::Missing { .. })
    ));
    let message = reader.check_group(FIELD).unwrap_err().to_string();
    assert!(message.contains("/field/more/secret"), "{message}");
}

#[test]
fn a_changed_set_of_datasets_is_found() {
    let (_folder, file) = saved();
    edit(&file, |file| {
        let dataset = file.dataset("/grid/tags").unwrap();
        dataset.delete_attr("digest").unwrap();
        let forged: hdf5::types::VarLenUnicode = "0".repeat(64).parse().unwrap();
        dataset
            .new_attr::<hdf5::types::VarLenUnicode>()
            .create("digest")
            .unwrap()
            .write_scalar(&forged)
            .unwrap();
    });
    assert!(matches!(
        open(&file).unwrap().check_group(GRID),
        Err(StoreError::Altered { .. })
    ));
}

#[test]
fn a_size_without_bytes_takes_no_memory() {
    let (_folder, file) = saved();
    edit(&file, |file| {
        file.unlink("/grid/coordinates").unwrap();
        file.new_dataset::<f64>()
            .shape((1_usize << 50, 3))
            .create("/grid/coordinates")
            .unwrap();
        file.unlink("/field/history/seconds").unwrap();
        file.new_dataset::<f64>()
            .chunk(1 << 16)
            .deflate(1)
            .shape(1_usize << 50)
            .create("/field/history/seconds")
            .unwrap();
    });
    let reader = open(&file).unwrap();
    for path in ["/grid/coordinates", "/field/history/seconds"] {
        let error = reader.read::<f64>(path).unwrap_err();
        assert!(matches!(error, StoreError::Damaged { .. }), "{error}");
    }
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
fn flipped_bytes_give_errors_or_the_data_that_were_written() {
    let (_folder, file) = saved();
    let whole = fs::read(&file).unwrap();
    for position in (0..whole.len()).step_by(whole.len() / 199) {
        let mut bytes = whole.clone();
        bytes[position] ^= 0x5a;
        fs::write(&file, &bytes).unwrap();
        let Ok(reader) = open(&file) else { continue };
        if let Ok(read) = reader.read_vec::<f64>("/grid/coordinates") {
            assert_eq!(read, coordinates(5), "byte {position}");
        }
        if let Ok(read) = reader.read_matrix("/field/stiffness") {
            assert_eq!(read, stiffness(5), "byte {position}");
        }
        let _ = (
            reader.read_texts("/grid/names"),
            reader.read_enum::<State>("/field/zone"),
        );
        let _ = (reader.check_group(GRID), reader.group_bytes(FIELD));
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

/// Where heaps of texts begin, and where the length of the free space of each lies.
fn heaps(bytes: &[u8]) -> Vec<(usize, usize)> {
    let number = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
    let starts = bytes.windows(8).enumerate();
    let starts = starts.filter(|(_, window)| *window == b"GCOL\x01\0\0\0");
    let free_space = |start: usize| {
        let mut object = start + 16;
        while bytes[object..object + 2] != [0, 0] {
            object += 16 + number(object + 8).next_multiple_of(8);
        }
        (start, object + 8)
    };
    starts.map(|(start, _)| free_space(start)).collect()
}

#[test]
fn a_heap_of_texts_that_hdf5_would_never_leave_is_refused() {
    let (_folder, file) = saved();
    let whole = fs::read(&file).unwrap();
    let found = heaps(&whole);
    assert!(!found.is_empty());
    for (start, length) in found {
        let mut bytes = whole.clone();
        bytes[length..length + 8].fill(0);
        fs::write(&file, &bytes).unwrap();
        let error = open(&file).unwrap_err();
        let place = format!("the heap of texts at byte {start} has no end");
        assert!(error.to_string().contains(&place), "{error}");
        // Other lengths are HDF5's to judge, which ends.
        for other in [1, 8, 16, 24, u64::MAX] {
            bytes[length..length + 8].copy_from_slice(&other.to_le_bytes());
            fs::write(&file, &bytes).unwrap();
            let _ = open(&file).map(|reader| reader.check_group(GRID));
        }
    }
}

#[test]
fn a_heap_of_texts_inside_another_is_refused() {
    let (_folder, file) = saved();
    let mut bytes = fs::read(&file).unwrap();
    let (start, length) = heaps(&bytes)[0];
    // In the free space, which HDF5 does not read: an inner one would be walked again and again.
    bytes.copy_within(start..start + 16, length + 8);
    bytes[length + 16..length + 24].copy_from_slice(&16_u64.to_le_bytes());
    fs::write(&file, &bytes).unwrap();
    let error = open(&file).unwrap_err().to_string();
    assert!(error.contains("lies in another one"), "{error}");
}
