//! Reading a run file: every dataset is checked against the table; how its groups were run.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::OnceLock;

use hdf5_metno as hdf5;
use ndarray::ArrayD;

use crate::dataset::{StoredElement, StoredEnum};
use crate::dataset::{open_dataset, texts};
use crate::error::{AtPlace, LayoutError, Place, StoreError};
use crate::extents::Sizes;
use crate::external::Linked;
use crate::hdf5_file::Hdf5File;
use crate::header::StoredGroup;
use crate::layout::{DatasetSpec, Group, Kind, Layout};
use crate::{header, matrix};

/// A run file opened for reading.
///
/// A symbolic size gets its value from the first dataset that has it, in the order of the table,
/// groups upstream first: after a new mesh, the datasets of a stale later group are the ones that
/// are refused.
#[derive(Debug)]
pub struct Reader {
    pub(super) home: Hdf5File,
    pub(super) linked: BTreeMap<Group, Linked>,
    pub(super) layout: Layout,
    /// Read when a dataset is checked against them.
    sizes: OnceLock<Sizes>,
}

impl Reader {
    /// Opens a run file and checks its root attributes.
    ///
    /// # Errors
    /// `NotFound`, `IsDirectory`, `NotAFile`, `NotHdf5`, `NotOurs`, `Version`, or `Altered` for a file that is not as it was
    /// written.
    pub fn open(path: &Path, layout: Layout) -> Result<Self, StoreError> {
        let mut reader = Self::open_state(path, layout)?;
        if reader.linked.values().any(|linked| linked.file.is_err()) {
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
        let home = Hdf5File::open(path, &layout, layout.filetype)?;
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
    /// `Missing`, `Mismatch` of type or shape; `Internal` for a path or kind not in the table.
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
                file: self.path_of(path).into(),
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
            Place::new(self.path_of(path), path).mismatch("one text", format!("{count} texts"))
        })
    }

    /// Reads a list of texts; errors as for [`Reader::read`].
    pub fn read_texts(&self, path: &str) -> Result<Vec<String>, StoreError> {
        let spec = self.spec(path, Kind::Text)?;
        texts(&self.dataset(spec)?, self.place(spec))
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
        let file = &self.file_of(spec.group).ok()?.hdf5;
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
        if !self.file_of(spec.group)?.holds(spec.path) {
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
        let dataset = open_dataset(&self.file_of(spec.group)?.hdf5, place, spec.kind)?;
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
        let shape = dataset.get_shape().at(place, "read the shape")?;
        let values = dataset.read_raw::<T>().at(place, "read the values")?;
        Ok((values, shape, place))
    }
}

impl Reader {
    /// How a group was run, or `None` if the file does not hold it.
    ///
    /// # Errors
    /// `Mismatch` if the group lacks an attribute or is not complete; `Linked` if the group is kept
    /// in a file of its own that cannot be used.
    pub fn group_record(&self, group: Group) -> Result<Option<StoredGroup>, StoreError> {
        let file = self.file_of(group)?;
        if !file.hdf5.link_exists(group.name()) {
            return Ok(None);
        }
        let place = Place::new(&file.path, group.name());
        let object = file.hdf5.group(group.name()).at(place, "open the group")?;
        header::read(&object, place).map(Some)
    }

    /// As [`Reader::group_record`], of a group that must be there: `Missing` where it is not.
    pub fn require_group(&self, group: Group) -> Result<StoredGroup, StoreError> {
        let stored = self.group_record(group)?;
        stored.ok_or_else(|| self.missing(group.name(), group))
    }

    /// Bytes the datasets of a group take on disk; 0 if the file does not hold the group.
    ///
    /// # Errors
    /// `Linked` as for [`Reader::group_record`]; `Hdf5`.
    pub fn group_bytes(&self, group: Group) -> Result<u64, StoreError> {
        let file = self.file_of(group)?;
        let mut bytes = 0;
        for spec in self.layout.of_group(group) {
            if !file.holds(spec.path) {
                continue;
            }
            for path in stored_paths(spec) {
                let dataset = file.hdf5.dataset(&path);
                bytes += dataset
                    .at(self.place(spec), "open the dataset")?
                    .storage_size();
            }
        }
        Ok(bytes)
    }
}

/// The paths of the datasets that a row of the table stands for: one, or the parts of a matrix.
fn stored_paths(spec: &DatasetSpec) -> Vec<String> {
    if spec.kind.is_matrix() {
        matrix::PARTS
            .map(|part| format!("{}/{part}", spec.path))
            .into()
    } else {
        vec![spec.path.to_owned()]
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
