//! What is written is read back, whatever its kind.

use std::path::Path;

use hdf5_metno as hdf5;
use ndarray::Array2;
use proptest::prelude::*;

use crate::sample::*;
use contact3d_runfile::{Kind, SparseMatrix, StoreError};

#[test]
fn every_kind_comes_back() {
    let (_folder, file) = folder();
    save_grid(&file, 5);
    save_field(&file, 5, &[0.5, 0.25]);
    let reader = open(&file).unwrap();
    let read = reader.read_finite_f64("/grid/coordinates").unwrap();
    assert_eq!(
        (read.shape(), read.as_slice().unwrap()),
        (&[5, 3][..], &coordinates(5)[..])
    );
    let cells = reader.read_indices("/grid/cells").unwrap();
    assert_eq!((cells.shape(), cells[[1, 3]]), (&[2, 4][..], 4));
    assert_eq!(reader.read_vec::<i64>("/grid/offsets").unwrap(), [0, 4, 8]);
    assert_eq!(reader.read_vec::<u8>("/grid/tags").unwrap(), [7, 9]);
    assert_eq!(
        reader.read_texts("/grid/names").unwrap(),
        ["clamp", "Öffnung", ""]
    );
    assert_eq!(
        reader
            .read_enum::<State>("/field/zone")
            .unwrap()
            .into_raw_vec_and_offset()
            .0,
        states(5)
    );
    assert_eq!(
        reader.read_matrix("/field/stiffness").unwrap(),
        stiffness(5)
    );
    assert_eq!(reader.read_matrix("/field/coupling").unwrap(), coupling(5));
    let energy = reader.read::<f64>("/field/energy").unwrap();
    assert_eq!((energy.ndim(), energy.sum()), (0, -12.5));
    assert!(!reader.has("/grid/title"));
    assert!(matches!(
        reader.read_text("/grid/title"),
        Err(StoreError::Missing { group: GRID, .. })
    ));
}

#[test]
fn attributes_tell_unit_symbol_meaning_and_encoding() {
    let (_folder, file) = folder();
    save_grid(&file, 1000);
    save_field(&file, 1000, &[]);
    let file = hdf5::File::open(&file).unwrap();
    let text = |object: &hdf5::Location, name: &str| {
        object
            .attr(name)
            .unwrap()
            .read_scalar::<hdf5::types::VarLenUnicode>()
            .unwrap()
            .to_string()
    };
    let coordinates = file.dataset("/grid/coordinates").unwrap();
    assert_eq!(text(&coordinates, "units"), "m");
    assert_eq!(text(&coordinates, "symbol"), "x");
    assert_eq!(text(&coordinates, "description"), "Positions.");
    assert!(coordinates.is_chunked() && coordinates.filters().len() == 2);
    // Too few bytes to compress.
    assert!(!file.dataset("/grid/cells").unwrap().is_chunked());
    let stiffness = file.group("/field/stiffness").unwrap();
    assert_eq!(text(&stiffness, "encoding-type"), "csc_matrix");
    assert_eq!(
        stiffness.attr("shape").unwrap().read_raw::<i64>().unwrap(),
        [1000, 1000]
    );
    assert!(!file.dataset("/field/stiffness/data").unwrap().is_chunked());
    let zone = file
        .dataset("/field/zone")
        .unwrap()
        .dtype()
        .unwrap()
        .to_descriptor()
        .unwrap();
    let hdf5::types::TypeDescriptor::Enum(zone) = zone else {
        panic!("{zone}")
    };
    assert_eq!(
        zone.members
            .iter()
            .map(|member| member.name.as_str())
            .collect::<Vec<_>>(),
        ["open", "stick", "slip"]
    );
}

#[test]
fn records_and_sizes_come_back() {
    let (_folder, file) = folder();
    let digest = save_grid(&file, 5);
    let reader = open(&file).unwrap();
    let stored = reader.group_record(GRID).unwrap().unwrap();
    assert_eq!((stored.record, stored.digest), (record(), digest));
    assert_eq!(reader.group_record(FIELD).unwrap(), None);
    assert_eq!(reader.group_bytes(FIELD).unwrap(), 0);
    assert!(reader.group_bytes(GRID).unwrap() > 0);
    reader.require_group(GRID).unwrap();
}

#[test]
fn the_digest_of_a_group_depends_on_values_but_not_on_timings() {
    let (_folder, file) = folder();
    let grid = save_grid(&file, 5);
    let field = save_field(&file, 5, &[0.5]);
    assert_eq!(field, save_field(&file, 5, &[0.75, 1.0]));
    assert_eq!(grid, save_grid(&file, 5));
    assert_ne!(grid, save_grid(&file, 6));
}

/// A grid of some coordinates, and no cells.
fn save_nodes(file: &Path, values: &[f64], n: usize) {
    change(file, |transaction| {
        let mut writer = transaction.group(GRID).unwrap();
        writer.write("/grid/coordinates", values, &[n, 3]).unwrap();
        writer.write_indices("/grid/cells", &[], &[0, 4]).unwrap();
        writer.write("/grid/offsets", &[0_i64], &[1]).unwrap();
        writer.write("/grid/tags", &[0_u8; 0], &[0]).unwrap();
        writer.write_texts("/grid/names", &[]).unwrap();
        writer.finish(&record()).unwrap();
    });
}

#[test]
fn arrays_and_empty_ones_come_back() {
    let (_folder, file) = folder();
    let coordinates = Array2::from_shape_fn((4, 3), |(node, axis)| (10 * axis + node) as f64);
    save_nodes(&file, coordinates.as_slice().unwrap(), 4);
    let reader = open(&file).unwrap();
    assert_eq!(
        reader.read::<f64>("/grid/coordinates").unwrap(),
        coordinates.into_dyn()
    );
    assert_eq!(reader.read::<i64>("/grid/cells").unwrap().shape(), [0, 4]);
    assert_eq!(reader.read_texts("/grid/names").unwrap().len(), 0);
}

#[test]
fn highly_compressible_values_are_not_taken_for_damage() {
    let (_folder, file) = folder();
    let n = 1_000_000;
    save_nodes(&file, &vec![0.0; 3 * n], n);
    assert_eq!(coordinates_in(&file).len(), 3 * n);
}

#[test]
fn attributes_for_others_are_fixed_length_ascii() {
    let (_folder, file) = folder();
    change(&file, |transaction| {
        let mut writer = transaction.group(NOTES).unwrap();
        let written = writer.write_ascii_attribute("Type", b"UnstructuredGrid");
        written.unwrap();
        let written = writer.write_number_attribute("Version", &[2_i64, 0]);
        written.unwrap();
        writer.finish(&record()).unwrap();
    });
    let group = hdf5::File::open(&file).unwrap().group("notes").unwrap();
    let descriptor = group
        .attr("Type")
        .unwrap()
        .dtype()
        .unwrap()
        .to_descriptor()
        .unwrap();
    assert_eq!(descriptor, hdf5::types::TypeDescriptor::FixedAscii(16));
    let version = group.attr("Version").unwrap().read_raw::<i64>().unwrap();
    assert_eq!(version, [2, 0]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn any_bit_pattern_of_a_double_comes_back(bits in prop::collection::vec(any::<u64>(), 1..200)) {
        let (_folder, file) = folder();
        let values: Vec<f64> = bits.iter().flat_map(|&bits| [f64::from_bits(bits); 3]).collect();
        save_nodes(&file, &values, bits.len());
        let read = coordinates_in(&file);
        prop_assert!(read.iter().zip(&values).all(|(read, value)| read.to_bits() == value.to_bits()));
    }

    #[test]
    fn a_broken_matrix_is_found(position in 0_usize..6, value in 0_usize..9) {
        let sound = SparseMatrix { shape: [4, 3], indptr: vec![0, 2, 2, 4], indices: vec![0, 3, 1, 2], data: vec![1.0; 4] };
        let mut broken = sound.clone();
        if position < 4 { broken.indptr[position] = value } else { broken.indices[position - 4] = value }
        // Independent oracle: the entries of each column, listed by the definition of the format.
        let columns = broken.indptr.windows(2).map(|ends| broken.indices.get(ends[0]..ends[1]));
        let lists_sound = columns.clone().all(|column| column.is_some_and(|column| {
            column.iter().all(|&row| row < 4) && column.windows(2).all(|pair| pair[0] < pair[1])
        }));
        let sound_format = lists_sound && broken.indptr[0] == 0 && broken.indptr[3] == 4;
        prop_assert_eq!(broken.view().problem(Kind::CscMatrix).is_none(), sound_format);
    }
}
