//! Dimensions of datasets by name, and their extents.
//!
//! Each named extent of a group is a dataset of that name and size in the group, empty like a netCDF-4 dimension
//! without values, or with the labels of its entries; the parts of a matrix have theirs in the group of the matrix.
//! A dataset names the scales of its axes in `DIMENSION_LIST`, a scale its datasets in `REFERENCE_LIST`. Both hold
//! object references, which HDF5's copy of a group sets to nothing, so they are written at every commit.
//!
//! Types of texts in the attributes of dimension scales: of fixed length, ending with a zero.
//!
//! HDF5 before 2.0, and so netCDF-C and h5py, takes a dataset for a scale only if its `CLASS` has 16 bytes and is of the kind
//! `H5T_STR_NULLTERM`. The binding makes texts of fixed length of another kind, padded with zeros, and none but those. It
//! copies types that a file has, though, so these come from `scale_texts.hdf5`, an HDF5 file of 250 bytes without data:
//!
//! ```python
//! types = {b"CLASS": 16, b"NAME": 64}
//! for name, size in types.items():                 # file: h5py.h5f.create(…), libver v110, no times
//!     text = h5py.h5t.C_S1.copy()
//!     text.set_size(size)
//!     text.set_strpad(h5py.h5t.STR_NULLTERM)
//!     h5py.h5a.create(file, name, text, h5py.h5s.create(h5py.h5s.SCALAR))
//! ```

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::OnceLock;

use hdf5::types::{VarLenArray, VarLenUnicode};
use hdf5::{Datatype, ObjectReference1};
use hdf5_metno as hdf5;

use crate::attribute::{ascii, has, unicode, write_values};
use crate::error::{AtFile, AtPlace, Place, StoreError};
use crate::hdf5_file::has_path;
use crate::layout::{DatasetSpec, Extent, Group, Layout};
use crate::signals::Temporary;

const CLASS: &str = "CLASS";
const SCALE: &str = "DIMENSION_SCALE";
const NAME: &str = "NAME";
pub(super) const DIMENSION_LIST: &str = "DIMENSION_LIST";
const REFERENCE_LIST: &str = "REFERENCE_LIST";

/// What netCDF-4 calls a dimension that holds no values.
const NO_VALUES: &str = "This is a netCDF dimension but not a netCDF variable.";

/// The axes of the parts of a matrix.
const ENTRIES: Extent = Extent::Named("n_entries");
const POINTERS: Extent = Extent::Named("n_pointers");

/// What schemas say of names of axes.
pub(super) const DIMENSION_SCALES: &str = "Every axis of a dataset has a name, given by an HDF5 dimension scale in the group \
     of the stage, as netCDF-4 has it: an empty dataset of the name and length of the axis, or the labels of its \
     entries. The parts of a matrix have scales `n_entries` and `n_pointers` in the group of the matrix. Scales have \
     no digest and do not count as datasets of the stage.";

/// An entry of `REFERENCE_LIST`: a dataset, and which of its axes the scale is of.
#[derive(Clone, Copy, Debug, hdf5_metno::H5Type)]
#[repr(C)]
struct Use {
    dataset: ObjectReference1,
    dimension: i32,
}

/// A dataset of a group and the scales of its axes.
struct Named {
    object: hdf5::Dataset,
    path: String,
    scales: Vec<String>,
}

/// A scale and the axes that it is of.
struct Scale {
    object: hdf5::Dataset,
    /// Whether it was there before, with attributes that are out of date.
    is_old: bool,
    reference: ObjectReference1,
    uses: Vec<Use>,
}

/// Names the axes of all datasets of a group that a file holds itself; none has names yet if the group `is_new`.
pub(super) fn name_axes(
    file: &hdf5::File,
    place: Place<'_>,
    layout: &Layout,
    (group, is_new): (Group, bool),
    types: &Types,
) -> Result<(), StoreError> {
    let parent = file.group(group.name()).at(place, "open the group")?;
    // Paths from the group on spare HDF5 the way from the root.
    let prefix = format!("/{group}/");
    let inner = |path: &str| path.strip_prefix(&prefix).unwrap_or(path).to_owned();
    let mut named = Vec::new();
    let mut scales: BTreeMap<String, Scale> = BTreeMap::new();
    for (path, extents) in layout.of_group(group).flat_map(parts) {
        if !has_path(&parent, &inner(&path)) {
            continue;
        }
        let object = parent.dataset(&inner(&path)).at(place, "open a dataset")?;
        let shape = object.shape();
        if shape.len() != extents.len() || shape.is_empty() {
            continue;
        }
        let dataset = reference(&object, place)?;
        let names = names(&extents).into_iter().zip(&extents);
        let names: Vec<String> = names
            .map(|(name, extent)| format!("{}/{name}", folder(*extent, &path, group)))
            .collect();
        for (axis, (extent, name)) in extents.iter().zip(&names).enumerate() {
            if !scales.contains_key(name) {
                let from = (&parent, inner(name));
                let place = place.beside(name);
                let scale = require_scale(from, place, *extent, shape[axis], types)?;
                scales.insert(name.clone(), scale);
            }
            let dimension = i32::try_from(axis).unwrap_or(i32::MAX);
            let scale = scales.get_mut(name).into_iter();
            scale.for_each(|scale| scale.uses.push(Use { dataset, dimension }));
        }
        named.push(Named {
            object,
            path,
            scales: names,
        });
    }
    for dataset in &named {
        let place = place.beside(&dataset.path);
        let references = dataset.scales.iter().filter_map(|name| scales.get(name));
        let references: Vec<_> = references
            .map(|scale| VarLenArray::from_slice(&[scale.reference]))
            .collect();
        if !is_new {
            remove_attribute(&dataset.object, place, DIMENSION_LIST)?;
        }
        write_values(&dataset.object, place, DIMENSION_LIST, &references)?;
    }
    for scale in scales.into_values() {
        if scale.is_old {
            remove_attribute(&scale.object, place, REFERENCE_LIST)?;
        }
        write_values(&scale.object, place, REFERENCE_LIST, &scale.uses)?;
    }
    Ok(())
}

/// The datasets of a row of the table with their extents: one, or the parts of a matrix.
fn parts(spec: &'static DatasetSpec) -> Vec<(String, Vec<Extent>)> {
    if !spec.kind.is_matrix() {
        return vec![(spec.path.to_owned(), spec.shape.to_vec())];
    }
    let part = |name, extent| (format!("{}/{name}", spec.path), vec![extent]);
    vec![
        part("data", ENTRIES),
        part("indices", ENTRIES),
        part("indptr", POINTERS),
    ]
}

/// The names of the axes of a shape. xarray wants another one for the second axis of a square.
pub(super) fn names(shape: &[Extent]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for extent in shape {
        let mut name = match *extent {
            Extent::Fixed(size) => format!("dim_{size}"),
            Extent::Labelled(axis) => axis.name.to_owned(),
            Extent::Named(name) => name.to_owned(),
            Extent::Plus(name, more) => format!("{name}_plus_{more}"),
        };
        if names.contains(&name) {
            name.push_str("_2");
        }
        names.push(name);
    }
    names
}

/// Where the scale of an extent lies: in the group of the matrix whose part the dataset is, or in that of the table.
fn folder(extent: Extent, dataset: &str, group: Group) -> String {
    let is_part = [ENTRIES, POINTERS].contains(&extent);
    match dataset.rsplit_once('/') {
        Some((matrix, _)) if is_part => matrix.to_owned(),
        _ => format!("/{group}"),
    }
}

/// Opens a scale, or creates it where it is not there yet.
fn require_scale(
    (parent, path): (&hdf5::Group, String),
    place: Place<'_>,
    extent: Extent,
    size: usize,
    types: &Types,
) -> Result<Scale, StoreError> {
    let is_old = parent.link_exists(&path);
    let object = if is_old {
        parent.dataset(&path).at(place, "open a dimension")?
    } else {
        let object = create_scale(parent, place, extent, (&path, size))?;
        let name = match extent {
            Extent::Labelled(_) => path
                .rsplit_once('/')
                .map_or(&*path, |(_, name)| name)
                .into(),
            Extent::Fixed(_) | Extent::Named(_) | Extent::Plus(..) => {
                format!("{NO_VALUES}{size:10}")
            }
        };
        write_fixed(&object, place, (CLASS, &types.class), SCALE)?;
        write_fixed(&object, place, (NAME, &types.name), &name)?;
        object
    };
    Ok(Scale {
        reference: reference(&object, place)?,
        object,
        is_old,
        uses: Vec::new(),
    })
}

/// Creates the dataset of a scale.
fn create_scale(
    parent: &hdf5::Group,
    place: Place<'_>,
    extent: Extent,
    (path, size): (&str, usize),
) -> Result<hdf5::Dataset, StoreError> {
    let action = "create a dimension";
    let builder = parent.new_dataset_builder();
    match extent {
        Extent::Labelled(axis) => {
            let labels: hdf5::Result<Vec<_>> = axis.labels.iter().map(|l| unicode(l)).collect();
            let builder = builder.empty::<VarLenUnicode>();
            let builder = builder.obj_track_times(false).shape(size);
            let object = builder.create(path).at(place, action)?;
            let labels = labels.at(place, action)?;
            object.write_raw(&labels).at(place, action)?;
            Ok(object)
        }
        Extent::Fixed(_) | Extent::Named(_) | Extent::Plus(..) => {
            let builder = builder.empty::<f32>();
            let builder = builder.obj_track_times(false).shape(size);
            builder.create(path).at(place, action)
        }
    }
}

fn reference(object: &hdf5::Dataset, place: Place<'_>) -> Result<ObjectReference1, StoreError> {
    object.reference(".").at(place, "refer to a dataset")
}

fn remove_attribute(
    object: &hdf5::Location,
    place: Place<'_>,
    name: &str,
) -> Result<(), StoreError> {
    if has(object, place, name)? {
        object.delete_attr(name).at(place, "remove an attribute")
    } else {
        Ok(())
    }
}

const FILE: &[u8] = include_bytes!("scale_texts.hdf5");

/// Most bytes of such a text, with the zero that ends it.
pub(super) const TEXT_BYTES: usize = 64;

/// The types, once a process has read them.
static TYPES: OnceLock<Types> = OnceLock::new();

/// The types of the attributes that make a dataset a scale.
#[derive(Debug)]
pub(super) struct Types {
    /// Of `CLASS`.
    class: Datatype,
    /// Of `NAME`.
    name: Datatype,
}

/// The types; the first call of a process writes the file that has them beside some place, and removes it.
///
/// # Errors
/// `Io` or `Hdf5` if that file cannot be written or read.
pub(super) fn types(target: &Path, place: Place<'_>) -> Result<&'static Types, StoreError> {
    if let Some(types) = TYPES.get() {
        return Ok(types);
    }
    let made = Temporary::beside(target, |path| File::create_new(path).map(drop));
    let written = made.and_then(|(temporary, mut file, ())| {
        file.write_all(FILE)?;
        Ok(temporary)
    });
    let temporary = written.at_file(target, "write a temporary file")?;
    let file = hdf5::File::with_options()
        .with_fapl(|access| access.file_locking(false))
        .open(temporary.path())
        .at(place, "open a temporary file")?;
    let type_of = |name| {
        let attribute = file.attr(name);
        let dtype = attribute.and_then(|attribute| attribute.dtype());
        dtype.at(place, "read the type of a text")
    };
    let types = Types {
        class: type_of("CLASS")?,
        name: type_of("NAME")?,
    };
    Ok(TYPES.get_or_init(|| types))
}

/// Writes a text of one of the types.
fn write_fixed(
    object: &hdf5::Location,
    place: Place<'_>,
    (name, dtype): (&str, &Datatype),
    text: &str,
) -> Result<(), StoreError> {
    let fixed = ascii::<TEXT_BYTES>(text.as_bytes(), place)?;
    let attribute = object.new_attr_builder().empty_as(dtype).create(name);
    attribute
        .and_then(|attribute| attribute.write_scalar(&fixed))
        .at(place, "write an attribute")
}
