//! Datasets declared once: a line of `fields!` is the row of the table, and what is written and read.
//!
//! A table of fields belongs to a Rust type `T`. One `T` is stored as single values, many as columns with a row for each.

use std::borrow::Cow;

use runfile::{DatasetSpec, Extent, Group, GroupWriter, Presence, Reader, StoreError};
use units::Dimension;

use super::{
    FormatError, require,
    stored::{Item, Stored},
};

/// The datasets that hold records of one type.
pub(super) struct Fields<T: 'static> {
    pub(super) fields: &'static [FieldSpec<T>],
    pub(super) rows: &'static [DatasetSpec],
}

/// One dataset: its row of the table, and which part of a record it holds.
pub(super) struct FieldSpec<T: 'static> {
    spec: DatasetSpec,
    /// How the part is written and read; `None` where that is done by hand.
    part: Option<&'static dyn FieldCodec<T>>,
    /// Whether the first record says that all have it; `None` where all do.
    condition: Option<fn(&T) -> bool>,
    /// What a file without it says of a record.
    missing: fn(&mut T),
    is_finite: bool,
}

/// Why a dataset may be missing, and which records have it.
pub(super) type Condition<T> = (&'static str, fn(&T) -> bool);

impl<T> FieldSpec<T> {
    /// A dataset that holds a part of a record.
    pub(super) const fn new<V: Stored>(
        group: Group,
        path: &'static str,
        shape: &'static [Extent],
        dimension: Dimension,
        description: &'static str,
        part: &'static Lens<T, V>,
    ) -> Self {
        let spec = group.row(path, V::Item::KIND, shape, dimension, description);
        let part: Option<&'static dyn FieldCodec<T>> = Some(part);
        Self {
            part,
            ..Self::by_hand(spec)
        }
    }

    /// A dataset whose values are written and read by hand.
    pub(super) const fn by_hand(spec: DatasetSpec) -> Self {
        Self {
            spec,
            part: None,
            condition: None,
            missing: |_| (),
            is_finite: false,
        }
    }

    /// The same with the symbol of the quantity.
    pub(super) const fn symbol(self, symbol: &'static str) -> Self {
        let spec = self.spec.symbol(symbol);
        Self { spec, ..self }
    }

    /// The same, missing for the stated reason where a record has an empty list or nothing there.
    pub(super) const fn optional(self, reason: &'static str) -> Self {
        let spec = self.spec.optional(reason);
        Self { spec, ..self }
    }

    /// The same for some records.
    pub(super) const fn when(self, (reason, condition): Condition<T>) -> Self {
        Self {
            condition: Some(condition),
            ..self.optional(reason)
        }
    }

    /// The same, with what a file without it says of a record.
    pub(super) const fn missing(self, missing: fn(&mut T)) -> Self {
        Self { missing, ..self }
    }

    /// The same, stored chunked, shuffled and gzipped.
    pub(super) const fn compressed(self) -> Self {
        let spec = self.spec.compressed();
        Self { spec, ..self }
    }

    /// The same, left out of the digest of the group.
    pub(super) const fn volatile(self) -> Self {
        let spec = self.spec.volatile();
        Self { spec, ..self }
    }

    /// The same, refused when read with NaN or infinity.
    pub(super) const fn finite(self) -> Self {
        Self {
            is_finite: true,
            ..self
        }
    }
}

/// A part of a record: a value that is taken from it, and put into it.
pub(super) struct Lens<T, V> {
    pub(super) get: Get<T, V>,
    /// `None` for what follows from other parts.
    pub(super) put: Option<fn(&mut T, V)>,
}

/// How a value is taken from a record.
pub(super) enum Get<T, V> {
    /// It stands there.
    At(fn(&T) -> &V),
    /// It follows from what stands there.
    Of(fn(&T) -> V),
}

impl<T, V: Clone> Get<T, V> {
    fn from<'a>(&self, record: &'a T) -> Cow<'a, V> {
        match self {
            Self::At(place) => Cow::Borrowed(place(record)),
            Self::Of(function) => Cow::Owned(function(record)),
        }
    }
}

/// How many records a table holds.
#[derive(Clone, Copy)]
enum RecordForm {
    One,
    Rows,
}

/// Puts the next row of a dataset into a record.
type Next<'a, T> = Box<dyn FnMut(&mut T) + 'a>;

/// A [`Lens`] of some type of value.
trait FieldCodec<T> {
    /// Writes the values of some records.
    fn write(
        &self,
        writer: &mut GroupWriter<'_>,
        spec: &DatasetSpec,
        records: &[&T],
        form: RecordForm,
    ) -> Result<(), StoreError>;

    /// Reads all rows, and says how many there are; `None` for what is not put into records.
    fn read(
        &self,
        reader: &Reader,
        path: &'static str,
        form: RecordForm,
        is_finite: bool,
    ) -> Result<Option<(usize, Next<'_, T>)>, FormatError>;
}

impl<T, V: Stored> FieldCodec<T> for Lens<T, V> {
    fn write(
        &self,
        writer: &mut GroupWriter<'_>,
        spec: &DatasetSpec,
        records: &[&T],
        form: RecordForm,
    ) -> Result<(), StoreError> {
        let first = records.first().map(|record| self.get.from(record));
        if spec.presence != Presence::Required && first.as_ref().is_some_and(|v| v.is_absent()) {
            return Ok(());
        }
        let own = V::shape(first.as_deref());
        let shape = match form {
            RecordForm::One => own,
            RecordForm::Rows => [vec![records.len()], own].concat(),
        };
        let mut items = Vec::new();
        for record in records {
            self.get.from(record).flatten(&mut items);
        }
        V::Item::write(writer, spec.path, &items, &shape)
    }

    fn read(
        &self,
        reader: &Reader,
        path: &'static str,
        form: RecordForm,
        is_finite: bool,
    ) -> Result<Option<(usize, Next<'_, T>)>, FormatError> {
        let Some(put) = self.put else {
            return Ok(None);
        };
        let (items, shape) = read_items::<V>(reader, path, is_finite)?;
        let (rows, own) = match (form, shape.as_slice()) {
            (RecordForm::Rows, [rows, own @ ..]) => (*rows, own.to_vec()),
            (RecordForm::One | RecordForm::Rows, all) => (1, all.to_vec()),
        };
        let mut items = items.into_iter();
        let next = move |record: &mut T| put(record, V::take(&mut items, &own));
        Ok(Some((rows, Box::new(next))))
    }
}

/// The items of a dataset, as many as its shape says.
fn read_items<V: Stored>(
    reader: &Reader,
    path: &'static str,
    is_finite: bool,
) -> Result<(Vec<V::Item>, Vec<usize>), FormatError> {
    let (items, shape) = V::Item::read(reader, path, is_finite)?;
    let fits = items.len() == shape.iter().product::<usize>();
    require(fits, path, || {
        format!("expected values of shape {shape:?}, found {}", items.len())
    })?;
    Ok((items, shape))
}

/// Writes the value of a dataset that no record has.
pub(super) fn write_value<V: Stored>(
    writer: &mut GroupWriter<'_>,
    path: &str,
    value: &V,
) -> Result<(), StoreError> {
    let mut items = Vec::new();
    value.flatten(&mut items);
    V::Item::write(writer, path, &items, &V::shape(Some(value)))
}

/// As [`write_value`], of values one after the other.
pub(super) fn write_list<V: Stored>(
    writer: &mut GroupWriter<'_>,
    path: &str,
    values: &[V],
) -> Result<(), StoreError> {
    let mut items = Vec::new();
    values.iter().for_each(|value| value.flatten(&mut items));
    let shape = [vec![values.len()], V::shape(values.first())].concat();
    V::Item::write(writer, path, &items, &shape)
}

/// Reads the value of a dataset by itself.
pub(super) fn read_value<V: Stored>(reader: &Reader, path: &'static str) -> Result<V, FormatError> {
    read_as(reader, path, false)
}

/// As [`read_value`], of finite numbers.
pub(super) fn read_finite<V: Stored>(
    reader: &Reader,
    path: &'static str,
) -> Result<V, FormatError> {
    read_as(reader, path, true)
}

/// As [`read_value`], of finite numbers where `is_finite`.
pub(super) fn read_as<V: Stored>(
    reader: &Reader,
    path: &'static str,
    is_finite: bool,
) -> Result<V, FormatError> {
    let (items, shape) = read_items::<V>(reader, path, is_finite)?;
    Ok(V::take(&mut items.into_iter(), &shape))
}

/// As [`read_value`]; `None` where a file does not have it.
pub(super) fn read_if_there<V: Stored>(
    reader: &Reader,
    path: &'static str,
) -> Result<Option<V>, FormatError> {
    let is_there = reader.has(path);
    is_there.then(|| read_value(reader, path)).transpose()
}

/// As [`read_finite`]; `None` where a file does not have it.
pub(super) fn read_finite_if_there<V: Stored>(
    reader: &Reader,
    path: &'static str,
) -> Result<Option<V>, FormatError> {
    let is_there = reader.has(path);
    is_there.then(|| read_finite(reader, path)).transpose()
}

impl<T> Fields<T> {
    /// Writes one record as single values.
    pub(super) fn write_one(
        &self,
        writer: &mut GroupWriter<'_>,
        record: &T,
    ) -> Result<(), StoreError> {
        self.write(writer, &[record], RecordForm::One)
    }

    /// Writes records as columns, a row for each.
    pub(super) fn write_rows<'a>(
        &self,
        writer: &mut GroupWriter<'_>,
        records: impl IntoIterator<Item = &'a T>,
    ) -> Result<(), StoreError> {
        let records: Vec<&T> = records.into_iter().collect();
        self.write(writer, &records, RecordForm::Rows)
    }

    fn write(
        &self,
        writer: &mut GroupWriter<'_>,
        records: &[&T],
        form: RecordForm,
    ) -> Result<(), StoreError> {
        for field in self.fields {
            let first = records.first();
            let holds = |condition: fn(&T) -> bool| first.is_some_and(|first| condition(first));
            let applies = field.condition.is_none_or(holds);
            if let Some(part) = field.part.filter(|_| applies) {
                part.write(writer, &field.spec, records, form)?;
            }
        }
        Ok(())
    }

    /// Whether a file has such records.
    pub(super) fn is_there(&self, reader: &Reader) -> bool {
        let first = self.fields.first();
        first.is_some_and(|field| reader.has(field.spec.path))
    }

    /// Reads the values of one record into it; those that are said to be finite may be any where `is_finite` is false.
    ///
    /// # Errors
    /// Those of [`Reader`]; `Missing` also for a dataset without which others are never there.
    pub(super) fn read_one(
        &self,
        reader: &Reader,
        record: &mut T,
        is_finite: bool,
    ) -> Result<(), FormatError> {
        for field in self.fields {
            match self.read(field, reader, RecordForm::One, is_finite)? {
                Some((_, mut next)) => next(record),
                None => (field.missing)(record),
            }
        }
        Ok(())
    }

    /// Reads all rows, each into a blank record.
    ///
    /// # Errors
    /// As [`Self::read_one`]; columns of different lengths.
    pub(super) fn read_rows(
        &self,
        reader: &Reader,
        blank: impl Fn() -> T,
    ) -> Result<Vec<T>, FormatError> {
        let mut n_rows = None;
        let mut columns: Vec<Next<'_, T>> = Vec::new();
        for field in self.fields {
            let Some((found, next)) = self.read(field, reader, RecordForm::Rows, true)? else {
                columns.push(Box::new(field.missing));
                continue;
            };
            let expected = *n_rows.get_or_insert(found);
            require(found == expected, field.spec.path, || {
                format!("expected {expected} rows, found {found}")
            })?;
            columns.push(next);
        }
        let record = |_| {
            let mut record = blank();
            columns.iter_mut().for_each(|next| next(&mut record));
            record
        };
        Ok((0..n_rows.unwrap_or(0)).map(record).collect())
    }

    /// Reads a dataset; `None` for one that is not there, or is read by hand. Those that may be missing for one reason are there
    /// together.
    fn read(
        &self,
        field: &FieldSpec<T>,
        reader: &Reader,
        form: RecordForm,
        is_finite: bool,
    ) -> Result<Option<(usize, Next<'_, T>)>, FormatError> {
        let Some(part) = field.part else {
            return Ok(None);
        };
        let is_alike = |other: &&FieldSpec<T>| other.spec.presence == field.spec.presence;
        let mut alike = self.fields.iter().filter(is_alike);
        if field.spec.presence != Presence::Required
            && !alike.any(|other| reader.has(other.spec.path))
        {
            return Ok(None);
        }
        part.read(reader, field.spec.path, form, is_finite && field.is_finite)
    }
}

/// A figure of each part of a record.
pub(super) fn each<T, V>(parts: &[T], of: impl Fn(&T) -> V) -> Vec<V> {
    parts.iter().map(of).collect()
}

/// Puts a figure into each part of a record that has one.
pub(super) fn put_each<T, V>(parts: &mut [T], values: Vec<V>, put: impl Fn(&mut T, V)) {
    let parts = parts.iter_mut().zip(values);
    parts.for_each(|(part, value)| put(part, value));
}

/// The rows of the table that some fields are.
pub(super) const fn rows<T, const N: usize>(fields: &[FieldSpec<T>]) -> [DatasetSpec; N] {
    let mut rows = [fields[0].spec; N];
    let mut k = 1;
    while k < N {
        rows[k] = fields[k].spec;
        k += 1;
    }
    rows
}

/// Declares the table of a type, a dataset a line: the part of a record that it holds, its path, shape, dimension and meaning.
///
/// The part is a place in the record, `(energies.strain)`; one in an optional part of it, `(results?.accuracy)`, whose value is
/// that of [`super::stored::Absent`] where there is none; an optional number that is stored as NaN, `(nan energy_error)`; the same
/// place of both of two, `(each k in assembly[k].seconds)`; what is taken and what is put, `[|r| …, |r, v| …]`; what is only
/// written, `[|r| …]`; or `{Kind}`, a dataset that is written and read by hand.
macro_rules! fields {
    ($T:ty => $group:expr;
     $($part:tt $path:expr, $shape:expr, $dimension:expr, $meaning:literal $(.$modifier:ident($($argument:expr),*))*;)+) => {{
        const FIELDS: &[$crate::format::fields::FieldSpec<$T>] = &[
            $($crate::format::fields::field!($T, $group, $part, $path, $shape, $dimension, $meaning)
                $(.$modifier($($argument),*))*),+
        ];
        $crate::format::fields::Fields {
            fields: FIELDS,
            rows: &$crate::format::fields::rows::<$T, { FIELDS.len() }>(FIELDS),
        }
    }};
}

/// One dataset of `fields!`.
macro_rules! field {
    ($T:ty, $group:expr, {$kind:expr}, $path:expr, $shape:expr, $dimension:expr, $meaning:literal) => {
        $crate::format::fields::FieldSpec::<$T>::by_hand(
            $group.row($path, $kind, $shape, $dimension, $meaning),
        )
    };
    ($T:ty, $group:expr, $part:tt, $path:expr, $shape:expr, $dimension:expr, $meaning:literal) => {
        $crate::format::fields::FieldSpec::<$T>::new(
            $group,
            $path,
            $shape,
            $dimension,
            $meaning,
            &$crate::format::fields::lens!($T, $part),
        )
    };
}

/// The part of a record that a dataset holds.
macro_rules! lens {
    ($T:ty, [$get:expr]) => {
        $crate::format::fields::Lens::<$T, _> { get: $crate::format::fields::Get::Of($get), put: None }
    };
    ($T:ty, [$get:expr, $put:expr]) => {
        $crate::format::fields::Lens::<$T, _> {
            get: $crate::format::fields::Get::Of($get),
            put: Some($put),
        }
    };
    ($T:ty, (nan $($place:tt)+)) => {
        $crate::format::fields::lens!($T, [
            |record| record.$($place)+.unwrap_or(f64::NAN),
            |record, value: f64| record.$($place)+ = Some(value).filter(|value| !value.is_nan())
        ])
    };
    ($T:ty, (each $k:ident in $($place:tt)+)) => {
        $crate::format::fields::lens!($T, [
            |record| [0, 1].map(|$k: usize| Clone::clone(&record.$($place)+)),
            |record, values| for ($k, value) in values.into_iter().enumerate() {
                record.$($place)+ = value;
            }
        ])
    };
    ($T:ty, ($($optional:ident).* ? . $($place:tt)+)) => {
        $crate::format::fields::lens!($T, [
            |record| record$(.$optional)*.as_ref()
                .map_or_else($crate::format::stored::Absent::absent, |part| Clone::clone(&part.$($place)+)),
            |record, value| if let Some(part) = record$(.$optional)*.as_mut() {
                part.$($place)+ = value;
            }
        ])
    };
    ($T:ty, ($($place:tt)+)) => {
        $crate::format::fields::Lens::<$T, _> {
            get: $crate::format::fields::Get::At(|record| &record.$($place)+),
            put: Some(|record, value| record.$($place)+ = value),
        }
    };
}

pub(super) use {field, fields, lens};
