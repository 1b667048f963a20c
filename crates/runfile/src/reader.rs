//! Reading a run file: every dataset is checked against the table and against its digest.

use std::collections::BTreeMap;
use std::path::Path;

use hdf5::H5Type;
use hdf5::types::TypeDescriptor;
use hdf5_metno as hdf5;
use ndarray::ArrayD;

use super::attribute::read_text;
use super::bounds;
use super::dataset::open_dataset;
use super::digest::{of_texts, of_values};
use super::element::StoredElement;
use super::enumeration::StoredEnum;
use super::error::{LayoutError, StoreError};
use super::extents::Sizes;
use super::home::Linked;
use super::layout::{DatasetSpec, Group, Kind};
use super::matrix;
use super::place::{AtPlace, Place};
use super::stream;
use super::table::Layout;
use super::volume::Volume;

/// A run file opened for reading.
///
/// A symbolic size gets its value from the first dataset that has it, in the order of the table,
/// groups upstream first: after a new mesh, the datasets of a stale later group are the ones that
/// are refused.
#[derive(Debug)]
pub struct Reader {
    pub(super) home: Volume,
    pub(super) linked: BTreeMap<Group, Linked>,
    pub(super) layout: Layout,
    sizes: Sizes,
}

impl Reader {
    /// Opens a run file and checks its root attributes.
    ///
    /// # Errors
    /// `NotFound`, `IsDirectory`, `NotAFile`, `NotHdf5`, `NotOurs`, `Version`, or `Damaged` for a
    /// truncated file.
    pub fn open(path: &Path, layout: Layout) -> Result<Self, StoreError> {
        let mut reader = Self::open_state(path, layout)?;
        if reader.linked.values().any(|linked| linked.volume.is_err()) {
            // Another process may have committed, and removed that file, since we opened the run
            // file.
            reader = Self::open_state(path, layout)?;
        }
        reader.sizes = reader.sizes_of(layout.groups());
        Ok(reader)
    }

    fn open_state(path: &Path, layout: Layout) -> Result<Self, StoreError> {
        let home = Volume::open(path, &layout, layout.filetype)?;
        let linked = |group| Some((group, Linked::open(&home, &layout, group)?));
        Ok(Reader {
            linked: layout.groups().filter_map(linked).collect(),
            home,
            layout,
            sizes: Sizes::default(),
        })
    }

    /// The path of the file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.home.path
    }

    /// Whether a dataset of the table is in the file.
    #[must_use]
    pub fn has(&self, path: &str) -> bool {
        self.layout.find(path).is_some_and(|spec| self.holds(spec))
    }

    /// Reads numbers in row-major order, with their shape.
    ///
    /// # Errors
    /// `Missing`, `Mismatch` of type or shape, `Altered`, `Damaged`; `Internal` for a path or kind
    /// not in the table.
    pub fn read<T: StoredElement>(&self, path: &str) -> Result<ArrayD<T>, StoreError> {
        let spec = self.spec(path, |kind| kind == T::KIND, T::KIND)?;
        let (values, shape) = self.values(spec, &T::type_descriptor())?;
        array(values, shape, self.place(spec))
    }

    /// Reads numbers in row-major order, without their shape; errors as for [`Reader::read`].
    pub fn read_vec<T: StoredElement>(&self, path: &str) -> Result<Vec<T>, StoreError> {
        let spec = self.spec(path, |kind| kind == T::KIND, T::KIND)?;
        Ok(self.values(spec, &T::type_descriptor())?.0)
    }

    /// Reads doubles and refuses NaN and infinities; other errors as for [`Reader::read`].
    pub fn read_finite_f64(&self, path: &str) -> Result<ArrayD<f64>, StoreError> {
        let array = self.read::<f64>(path)?;
        self.all_finite(path, &array)?;
        Ok(array)
    }

    /// Refuses NaN and infinities.
    pub(super) fn all_finite<'v>(
        &self,
        path: &str,
        values: impl IntoIterator<Item = &'v f64>,
    ) -> Result<(), StoreError> {
        let mut numbered = values.into_iter().enumerate();
        match numbered.find(|(_, value)| !value.is_finite()) {
            None => Ok(()),
            Some((index, &found)) => Err(StoreError::NotFinite {
                file: self.file_of(path).into(),
                dataset: path.into(),
                index,
                found,
            }),
        }
    }

    /// Reads indices stored as `i64`; `Damaged` if one is negative, other errors as for
    /// [`Reader::read`].
    pub fn read_indices(&self, path: &str) -> Result<ArrayD<usize>, StoreError> {
        let spec = self.spec(path, |kind| kind == Kind::I64, Kind::I64)?;
        let (values, shape) = self.values::<i64>(spec, &i64::type_descriptor())?;
        array(
            to_indices(&values, self.place(spec))?,
            shape,
            self.place(spec),
        )
    }

    /// Reads members of an enumeration; `Damaged` for an unknown code, other errors as for
    /// [`Reader::read`].
    pub fn read_enum<E: StoredEnum>(&self, path: &str) -> Result<ArrayD<E>, StoreError> {
        let kind = Kind::Enum(E::SPEC);
        let spec = self.spec(path, |found| found == kind, kind)?;
        let (codes, shape) = self.values::<u8>(spec, &E::type_descriptor())?;
        let members = codes.iter().map(|&code| {
            E::from_code(code).ok_or_else(|| {
                self.place(spec)
                    .damaged(format!("{code} is no {}", E::SPEC.name))
            })
        });
        array(members.collect::<Result<_, _>>()?, shape, self.place(spec))
    }

    /// Reads one text; errors as for [`Reader::read`].
    pub fn read_text(&self, path: &str) -> Result<String, StoreError> {
        let mut texts = self.read_texts(path)?;
        let count = texts.len();
        texts.pop().filter(|_| count == 1).ok_or_else(|| {
            Place::new(self.file_of(path), path).mismatch("one text", format!("{count} texts"))
        })
    }

    /// Reads a list of texts; errors as for [`Reader::read`].
    pub fn read_texts(&self, path: &str) -> Result<Vec<String>, StoreError> {
        let spec = self.spec(path, |kind| kind == Kind::Text, Kind::Text)?;
        let place = self.place(spec);
        let dataset = self.dataset(spec, &TypeDescriptor::VarLenUnicode)?;
        let shape = self.checked_shape(spec, &dataset)?;
        let texts = stream::texts(&dataset, &shape, place, self.volume(spec.group)?.bytes)?;
        place.same_digest(
            read_text(&dataset, place, "digest")?,
            of_texts(&shape, &texts),
        )?;
        Ok(texts)
    }

    /// The sizes fixed by the datasets of some groups; unreadable datasets are left to their
    /// readers.
    pub(super) fn sizes_of(&self, groups: impl Iterator<Item = Group>) -> Sizes {
        let mut sizes = Sizes::default();
        for spec in groups.flat_map(|group| self.layout.of_group(group)) {
            if let Some(shape) = self.shape(spec) {
                // A dataset that contradicts an upstream one is refused when it is read.
                let _ = sizes.bind(spec, &shape);
            }
        }
        sizes
    }

    /// The shape of a dataset that is there and can be opened.
    fn shape(&self, spec: &DatasetSpec) -> Option<Vec<usize>> {
        if !self.holds(spec) {
            return None;
        }
        if spec.kind.is_matrix() {
            return matrix::shape(self, spec).ok().map(Vec::from);
        }
        let dataset = self.volume(spec.group).ok()?.file.dataset(spec.path).ok()?;
        dataset.get_shape().ok()
    }

    /// The row of a path, if it holds the kind that is asked for.
    pub(super) fn spec(
        &self,
        path: &str,
        fits: impl Fn(Kind) -> bool,
        asked: Kind,
    ) -> Result<&'static DatasetSpec, StoreError> {
        let spec = self.layout.find(path);
        let spec = spec.ok_or_else(|| LayoutError::unknown(path))?;
        if !fits(spec.kind) {
            let problem = format!(" holds {}, not {asked}", spec.kind);
            return Err(LayoutError::dataset(path, problem));
        }
        if !self
            .volume_of_object(spec.group, spec.path)?
            .holds(spec.path)
        {
            return Err(self.missing(spec.path, spec.group));
        }
        Ok(spec)
    }

    pub(super) fn check_shape(
        &self,
        spec: &DatasetSpec,
        shape: &[usize],
    ) -> Result<(), StoreError> {
        let conflict = |conflict: super::extents::ShapeConflict| {
            self.place(spec).mismatch(conflict.expected, conflict.found)
        };
        self.sizes.check(spec, shape).map_err(conflict)
    }

    fn dataset(
        &self,
        spec: &DatasetSpec,
        expected: &TypeDescriptor,
    ) -> Result<hdf5::Dataset, StoreError> {
        open_dataset(&self.volume(spec.group)?.file, self.place(spec), expected)
    }

    fn checked_shape(
        &self,
        spec: &DatasetSpec,
        dataset: &hdf5::Dataset,
    ) -> Result<Vec<usize>, StoreError> {
        let place = self.place(spec);
        let shape = dataset.get_shape().at(place, "read the shape")?;
        self.check_shape(spec, &shape)?;
        bounds::check(dataset, place, self.volume(spec.group)?.bytes)?;
        Ok(shape)
    }

    pub(super) fn values<T: StoredElement>(
        &self,
        spec: &DatasetSpec,
        expected: &TypeDescriptor,
    ) -> Result<(Vec<T>, Vec<usize>), StoreError> {
        let place = self.place(spec);
        let dataset = self.dataset(spec, expected)?;
        let shape = self.checked_shape(spec, &dataset)?;
        let digest = read_text(&dataset, place, "digest")?;
        if bounds::claims_much(&dataset, &shape, size_of::<T>()) {
            let found = stream::digest::<T>(&dataset, spec.kind, &shape, place)?;
            place.same_digest(digest.clone(), found)?;
        }
        let values = dataset.read_raw::<T>().at(place, "read the values")?;
        place.same_digest(digest, of_values(spec.kind, &shape, &values))?;
        Ok((values, shape))
    }

    /// Compares the values of a dataset with its digest, without keeping them.
    pub(super) fn check_digest<T: StoredElement>(
        &self,
        spec: &DatasetSpec,
        expected: &TypeDescriptor,
    ) -> Result<(), StoreError> {
        let place = self.place(spec);
        let dataset = self.dataset(spec, expected)?;
        let shape = self.checked_shape(spec, &dataset)?;
        let digest = read_text(&dataset, place, "digest")?;
        place.same_digest(
            digest,
            stream::digest::<T>(&dataset, spec.kind, &shape, place)?,
        )
    }
}

pub(super) fn to_indices(values: &[i64], place: Place<'_>) -> Result<Vec<usize>, StoreError> {
    let index = |&value: &i64| {
        usize::try_from(value).map_err(|_| place.damaged(format!("{value} is no index")))
    };
    values.iter().map(index).collect()
}

fn array<T>(values: Vec<T>, shape: Vec<usize>, place: Place<'_>) -> Result<ArrayD<T>, StoreError> {
    ArrayD::from_shape_vec(shape, values).map_err(|error| place.damaged(error.to_string()))
}
