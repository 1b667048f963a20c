//! Writing one group: every dataset is looked up in the table, gets its attributes, and adds to the digest of the group.

use std::collections::{BTreeMap, BTreeSet};

use hdf5::H5Type;
use hdf5::types::VarLenUnicode;
use hdf5_metno as hdf5;

use crate::attribute::{ascii, unicode, write_text, write_value, write_values};
use crate::dataset::new_dataset;
use crate::dataset::{StoredElement, StoredEnum};
use crate::digest::{of_group, of_texts, of_values};
use crate::error::{AtPlace, LayoutError, Place, StoreError};
use crate::header::GroupRecord;
use crate::layout::{DatasetSpec, Group, Kind, Presence, Storage};
use crate::matrix::{SparseView, from_indices};
use crate::transaction::Transaction;
use crate::{header, matrix};

/// Writes the datasets of one group into a transaction.
///
/// Every method has the errors `Internal` for a breach of the table and `Hdf5` if writing fails.
#[derive(Debug)]
pub struct GroupWriter<'t> {
    transaction: &'t mut Transaction,
    group: Group,
    object: hdf5::Group,
    written: BTreeSet<&'static str>,
    /// Digests of what counts for that of the group.
    digests: BTreeMap<&'static str, String>,
}

impl<'t> GroupWriter<'t> {
    pub(super) fn new(transaction: &'t mut Transaction, group: Group, object: hdf5::Group) -> Self {
        GroupWriter {
            transaction,
            group,
            object,
            written: BTreeSet::new(),
            digests: BTreeMap::new(),
        }
    }

    /// Writes numbers in row-major order.
    pub fn write<T: StoredElement>(
        &mut self,
        path: &str,
        values: &[T],
        shape: &[usize],
    ) -> Result<(), StoreError> {
        let spec = self.admit(path, T::KIND, shape, Some(values.len()))?;
        let dataset = self.create(spec, shape, values)?;
        self.describe(spec, &dataset, of_values(spec.kind, shape, values))
    }

    /// Writes indices as `i64`.
    pub fn write_indices(
        &mut self,
        path: &str,
        indices: &[usize],
        shape: &[usize],
    ) -> Result<(), StoreError> {
        self.write(path, &from_indices(indices), shape)
    }

    /// Writes members of an enumeration in row-major order.
    pub fn write_enum<E: StoredEnum>(
        &mut self,
        path: &str,
        members: &[E],
        shape: &[usize],
    ) -> Result<(), StoreError> {
        let spec = self.admit(path, Kind::Enum(E::SPEC), shape, Some(members.len()))?;
        let dataset = self.create(spec, shape, members)?;
        let codes: Vec<_> = members.iter().map(|member| member.code()).collect();
        self.describe(spec, &dataset, of_values(spec.kind, shape, &codes))
    }

    /// Writes one text.
    pub fn write_text(&mut self, path: &str, text: &str) -> Result<(), StoreError> {
        self.texts(path, &[text], &[])
    }

    /// Writes a list of texts.
    pub fn write_texts(&mut self, path: &str, texts: &[&str]) -> Result<(), StoreError> {
        self.texts(path, texts, &[texts.len()])
    }

    /// Writes a sparse matrix of the compression the table says.
    pub fn write_matrix(&mut self, path: &str, matrix: SparseView<'_>) -> Result<(), StoreError> {
        let kind = self.find(path)?.kind;
        let kind = if kind.is_matrix() {
            kind
        } else {
            Kind::CscMatrix
        };
        let spec = self.admit(path, kind, &matrix.shape, None)?;
        if let Some(reason) = matrix.problem(spec.kind) {
            return Err(LayoutError::dataset(spec.path, format!(": {reason}")));
        }
        let (object, digest) = matrix::write(&self.object, self.place(spec), spec, matrix)?;
        self.describe(spec, &object, digest)
    }

    /// Writes a fixed-length ASCII attribute on the group of the group, as other programs look for.
    pub fn write_ascii_attribute<const N: usize>(
        &mut self,
        name: &str,
        text: &[u8; N],
    ) -> Result<(), StoreError> {
        let place = self.group_place();
        write_value(&self.object, place, name, &ascii::<N>(text, place)?)
    }

    /// Writes an attribute of numbers on the group of the group, as other programs look for.
    pub fn write_number_attribute<T: StoredElement>(
        &mut self,
        name: &str,
        values: &[T],
    ) -> Result<(), StoreError> {
        write_values(&self.object, self.group_place(), name, values)
    }

    /// Writes one number as an attribute of a group inside the group, which a dataset written before has made, as other programs
    /// look for.
    pub fn write_inner_attribute<T: StoredElement>(
        &mut self,
        inner: &str,
        name: &str,
        value: T,
    ) -> Result<(), StoreError> {
        let place = self.group_place();
        let object = self.object.group(inner).at(place, "open a group")?;
        write_value(&object, place, name, &value)
    }

    /// Ends the group and returns its digest.
    ///
    /// # Errors
    /// `Internal` if a required dataset was not written.
    pub fn finish(self, record: &GroupRecord) -> Result<String, StoreError> {
        let group = self.group;
        let required = self
            .transaction
            .layout
            .of_group(group)
            .filter(|spec| spec.presence == Presence::Required);
        let missing: Vec<_> = required
            .map(|spec| spec.path)
            .filter(|path| !self.written.contains(path))
            .collect();
        if !missing.is_empty() {
            return Err(LayoutError::NotWritten { group, missing }.into());
        }
        let units = self.transaction.layout.units;
        let digest = of_group(&self.digests, units);
        header::write(&self.object, self.group_place(), record, units, &digest)?;
        self.transaction.group_finished(&digest);
        Ok(digest)
    }

    fn create<T: H5Type>(
        &self,
        spec: &DatasetSpec,
        shape: &[usize],
        values: &[T],
    ) -> Result<hdf5::Dataset, StoreError> {
        let (place, storage) = (self.place(spec), spec.storage);
        new_dataset(&self.object, place, spec.name(), shape, storage, values)
    }

    fn texts(&mut self, path: &str, texts: &[&str], shape: &[usize]) -> Result<(), StoreError> {
        let spec = self.admit(path, Kind::Text, shape, Some(texts.len()))?;
        let place = self.place(spec);
        let unicode: hdf5::Result<Vec<VarLenUnicode>> =
            texts.iter().map(|text| unicode(text)).collect();
        let unicode =
            unicode.map_err(|error| LayoutError::dataset(spec.path, format!(": {error}")))?;
        let (name, plain) = (spec.name(), Storage::Plain);
        let dataset = new_dataset(&self.object, place, name, shape, plain, &unicode)?;
        self.describe(spec, &dataset, of_texts(shape, texts))
    }

    fn find(&self, path: &str) -> Result<&'static DatasetSpec, StoreError> {
        let found = self.transaction.layout.find(path);
        found.ok_or_else(|| LayoutError::unknown(path))
    }

    /// The row of a path, if the table allows these values there now.
    fn admit(
        &mut self,
        path: &str,
        kind: Kind,
        shape: &[usize],
        count: Option<usize>,
    ) -> Result<&'static DatasetSpec, StoreError> {
        let spec = self.find(path)?;
        let path = spec.path;
        if spec.group != self.group {
            let (owner, writing) = (spec.group, self.group);
            let problem = format!(" belongs to the group `{owner}`, not to `{writing}`");
            return Err(LayoutError::dataset(path, problem));
        }
        if spec.kind != kind {
            let problem = format!(" holds {}, not {kind}", spec.kind);
            return Err(LayoutError::dataset(path, problem));
        }
        if self.written.contains(path) {
            return Err(LayoutError::Twice { path: path.into() }.into());
        }
        let file = shape
            .iter()
            .try_fold(1_usize, |file, &extent| file.checked_mul(extent));
        if let Some(found) = count.filter(|&count| Some(count) != file) {
            let problem = format!(": {found} values do not fill the shape {shape:?}");
            return Err(LayoutError::dataset(path, problem));
        }
        let bound = self.transaction.sizes.bind(spec, shape);
        bound.map_err(|(expected, found)| {
            LayoutError::dataset(path, format!(": expected {expected}, found {found}"))
        })?;
        Ok(spec)
    }

    /// Writes the attributes of a dataset and remembers its digest.
    fn describe(
        &mut self,
        spec: &'static DatasetSpec,
        object: &hdf5::Location,
        digest: String,
    ) -> Result<(), StoreError> {
        let place = self.place(spec);
        let units = self.transaction.layout.units;
        write_text(object, place, "units", &units.word(spec.dimension))?;
        write_text(object, place, "symbol", spec.symbol)?;
        write_text(object, place, "description", spec.description)?;
        self.written.insert(spec.path);
        if !spec.volatile {
            self.digests.insert(spec.path, digest);
        }
        Ok(())
    }

    fn place(&self, spec: &DatasetSpec) -> Place<'_> {
        Place::new(&self.transaction.target, spec.path)
    }

    fn group_place(&self) -> Place<'_> {
        Place::new(&self.transaction.target, self.group.name())
    }
}
