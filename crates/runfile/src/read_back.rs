//! Reading back a file that HDF5 wrote piece by piece: large values are not held in memory a second time, so a lost write could
//! leave other bytes than were meant.

use std::collections::BTreeMap;
use std::path::Path;

use hdf5::types::VarLenArray;
use hdf5::{Hyperslab, ObjectReference1, SliceOrIndex};
use hdf5_metno as hdf5;
use ndarray::ArrayD;

use crate::attribute::{has, read_text};
use crate::dataset::StoredElement;
use crate::dataset::texts;
use crate::digest::DatasetDigest;
use crate::dimension::DIMENSION_LIST;
use crate::error::{AtPlace, Place, StoreError};
use crate::hdf5_file::has_path;
use crate::layout::{DatasetSpec, Group, Kind, Layout};
use crate::matrix::shape_of;
use crate::{header, matrix};

/// Bytes read at once.
const READ_BYTES: usize = 1 << 26;

/// Refuses a file whose only group does not read as the one that was written, with some digests of its datasets.
///
/// # Errors
/// `Damaged` if a digest is another one; `Hdf5` or `Mismatch` for what cannot be read.
pub(super) fn require(
    path: &Path,
    layout: &Layout,
    group: Group,
    written: &BTreeMap<&'static str, String>,
) -> Result<(), StoreError> {
    let file = header::open_any(path)?;
    let place = Place::new(path, group.name());
    let object = file.group(group.name()).at(place, "open the group")?;
    header::read(&object, place)?;
    let mut digests = BTreeMap::new();
    for spec in layout.of_group(group) {
        if !has_path(&file, spec.path) {
            continue;
        }
        let digest = digest_of(&file, spec, Place::new(path, spec.path))?;
        digests.insert(spec.path, digest);
    }
    if digests == *written {
        Ok(())
    } else {
        Err(place.damaged("its digest is another one"))
    }
}

/// The digest of a dataset, with its texts read.
fn digest_of(
    file: &hdf5::File,
    spec: &DatasetSpec,
    place: Place<'_>,
) -> Result<String, StoreError> {
    let open = |path: &str| file.dataset(path).at(place, "open the dataset");
    let words = |object: &hdf5::Location| {
        let mut names = ["units", "symbol", "description"].into_iter();
        names.try_for_each(|name| read_text(object, place, name).map(drop))
    };
    if spec.kind.is_matrix() {
        let group = file.group(spec.path).at(place, "open the matrix")?;
        words(&group)?;
        let [data, indices, indptr] =
            matrix::PARTS.map(|part| open(&format!("{}/{part}", spec.path)));
        let data = data?;
        let mut digest = DatasetDigest::new(spec.kind, &shape_of(&group, place)?);
        digest.size(data.size());
        feed::<i64>(&mut digest, &indptr?, place)?;
        feed::<i64>(&mut digest, &indices?, place)?;
        feed::<f64>(&mut digest, &data, place)?;
        return Ok(digest.finish());
    }
    let dataset = open(spec.path)?;
    words(&dataset)?;
    let mut digest = DatasetDigest::new(spec.kind, &dataset.shape());
    match spec.kind {
        Kind::F64 => feed::<f64>(&mut digest, &dataset, place)?,
        Kind::F32 => feed::<f32>(&mut digest, &dataset, place)?,
        Kind::I64 => feed::<i64>(&mut digest, &dataset, place)?,
        Kind::U8 | Kind::Enum(_) => feed::<u8>(&mut digest, &dataset, place)?,
        Kind::Text | Kind::CscMatrix | Kind::CsrMatrix => {
            let texts = texts(&dataset, place)?;
            texts.iter().for_each(|text| digest.text(text));
        }
    }
    Ok(digest.finish())
}

/// Adds the values of a dataset to a digest, in blocks of whole rows, with the names of its axes read.
fn feed<T: StoredElement>(
    digest: &mut DatasetDigest,
    dataset: &hdf5::Dataset,
    place: Place<'_>,
) -> Result<(), StoreError> {
    if has(dataset, place, DIMENSION_LIST)? {
        let list = dataset.attr(DIMENSION_LIST);
        let scales = list.and_then(|list| list.read_raw::<VarLenArray<ObjectReference1>>());
        scales.at(place, "read the names of its axes")?;
    }
    let shape = dataset.shape();
    let row = shape.iter().skip(1).product::<usize>() * size_of::<T>();
    let at_once = (READ_BYTES / row.max(1)).max(1);
    let rows = shape.first().copied().unwrap_or(1);
    if rows <= at_once {
        let values = dataset.read_raw::<T>().at(place, "read the values")?;
        digest.values(&values);
        return Ok(());
    }
    for first in (0..rows).step_by(at_once) {
        let others = shape[1..].iter().map(|extent| 0..*extent);
        let ranges = std::iter::once(first..rows.min(first + at_once)).chain(others);
        let slab: Vec<SliceOrIndex> = ranges.map(SliceOrIndex::from).collect();
        let block = dataset.read_slice::<T, _, ndarray::IxDyn>(Hyperslab::from(slab));
        let block: ArrayD<T> = block.at(place, "read the values")?;
        digest.values(&block.into_raw_vec_and_offset().0);
    }
    Ok(())
}
