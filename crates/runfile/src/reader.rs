//! Reading a run file: every dataset is checked against the table and against its digest.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::OnceLock;

use hdf5_metno as hdf5;
use ndarray::ArrayD;

use crate::attribute::read_text;
use crate::dataset::{claims_much, digest_of, open_dataset, require_bytes, texts};
use crate::digest::{of_texts, of_values};
use crate::element::{StoredElement, StoredEnum};
use crate::error::{AtPlace, LayoutError, Place, StoreError};
use crate::extents::Sizes;
use crate::home::Linked;
use crate::layout::{DatasetSpec, Group, Kind, Layout};
use crate::matrix;
use crate::volume::Volume;

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
    /// Read when a dataset is checked against them.
    sizes: OnceLock<Sizes>,
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
        Ok(reader)
    }

    /// Opens a run file that may not be there.
    ///
    /// # Errors
    /// Those of [`Reader::open`] but `NotFound`.
    pub fn open_if_there(path: &Path, layout: Layout) -> Result<Option<Self>, StoreError> {
        match Self::open(path, layout) {
            Err(StoreError::NotFound { .. }) => Ok(None),
            opened => opened.map(Some),
        }
    }

    fn open_state(path: &Path, layout: Layout) -> Result<Self, StoreError> {
        let home = Volume::open(path, &layout, layout.filetype)?;
        let linked = |group| Some((group, Linked::open(&home, &layout, group)?));
        Ok(Reader {
            linked: layout.groups().filter_map(linked).collect(),
            home,
            layout,
            sizes: OnceLock::new(),
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
        let (values, shape, place) = self.values::<T>(path, T::KIND)?;
        array(values, shape, place)
    }

    /// Reads numbers in row-major order, without their shape; errors as for [`Reader::read`].
    pub fn read_vec<T: StoredElement>(&self, path: &str) -> Result<Vec<T>, StoreError> {
        Ok(self.values::<T>(path, T::KIND)?.0)
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
        let (values, shape, place) = self.values::<i64>(path, Kind::I64)?;
        array(to_indices(&values, place)?, shape, place)
    }

    /// Reads members of an enumeration; `Damaged` for an unknown code, other errors as for
    /// [`Reader::read`].
    pub fn read_enum<E: StoredEnum>(&self, path: &str) -> Result<ArrayD<E>, StoreError> {
        let (codes, shape, place) = self.values::<u8>(path, Kind::Enum(E::SPEC))?;
        let unknown = |code| place.damaged(format!("{code} is no {}", E::SPEC.name));
        let members = codes
            .iter()
            .map(|&code| E::from_code(code).ok_or_else(|| unknown(code)));
        array(members.collect::<Result<_, _>>()?, shape, place)
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
        let spec = self.spec(path, Kind::Text)?;
        let (place, dataset) = (self.place(spec), self.dataset(spec)?);
        let bytes = self.volume(spec.group)?.bytes;
        require_bytes(&dataset, place, bytes)?;
        let shape = dataset.get_shape().at(place, "read the shape")?;
        let texts = texts(&dataset, &shape, place, bytes)?;
        let digest = read_text(&dataset, place, "digest")?;
        place.same_digest(digest, of_texts(&shape, &texts))?;
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
        let file = &self.volume(spec.group).ok()?.file;
        if spec.kind.is_matrix() {
            let group = file.group(spec.path).ok()?;
            return matrix::shape_of(&group, self.place(spec))
                .ok()
                .map(Vec::from);
        }
        file.dataset(spec.path).ok()?.get_shape().ok()
    }

    /// The row of a path, if it holds the kind that is asked for, or both are matrices.
    pub(super) fn spec(&self, path: &str, asked: Kind) -> Result<&'static DatasetSpec, StoreError> {
        let spec = self.layout.find(path);
        let spec = spec.ok_or_else(|| LayoutError::unknown(path))?;
        if spec.kind != asked && !(spec.kind.is_matrix() && asked.is_matrix()) {
            let problem = format!(" holds {}, not {asked}", spec.kind);
            return Err(LayoutError::dataset(path, problem));
        }
        let volume = self.volume_of_object(spec.group, spec.path)?;
        if !volume.holds(spec.path) {
            return Err(self.missing(spec.path, spec.group));
        }
        Ok(spec)
    }

    pub(super) fn check_shape(
        &self,
        spec: &DatasetSpec,
        shape: &[usize],
    ) -> Result<(), StoreError> {
        let sizes = || self.sizes_of(self.layout.groups());
        let checked = self.sizes.get_or_init(sizes).check(spec, shape);
        checked.map_err(|(expected, found)| self.place(spec).mismatch(expected, found))
    }

    /// A plain dataset with the type and the shape that the table says.
    pub(super) fn dataset(&self, spec: &DatasetSpec) -> Result<hdf5::Dataset, StoreError> {
        let place = self.place(spec);
        let dataset = open_dataset(&self.volume(spec.group)?.file, place, spec.kind)?;
        let shape = dataset.get_shape().at(place, "read the shape")?;
        self.check_shape(spec, &shape)?;
        Ok(dataset)
    }

    fn values<T: StoredElement>(
        &self,
        path: &str,
        kind: Kind,
    ) -> Result<(Vec<T>, Vec<usize>, Place<'_>), StoreError> {
        let spec = self.spec(path, kind)?;
        let (place, dataset) = (self.place(spec), self.dataset(spec)?);
        let bytes = self.volume(spec.group)?.bytes;
        require_bytes(&dataset, place, bytes)?;
        let shape = dataset.get_shape().at(place, "read the shape")?;
        let digest = read_text(&dataset, place, "digest")?;
        if claims_much(&dataset, &shape, size_of::<T>()) {
            place.same_digest(digest.clone(), digest_of(&dataset, kind, place, bytes)?)?;
        }
        let values = dataset.read_raw::<T>().at(place, "read the values")?;
        place.same_digest(digest, of_values(kind, &shape, &values))?;
        Ok((values, shape, place))
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
