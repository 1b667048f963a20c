//! A table of rows, written one column at a time.

use runfile::{Element, GroupWriter, StoreError, StoredEnum};

/// Writes the columns of a table of rows, each to a dataset of its own.
///
/// Every method has the errors of [`GroupWriter`].
pub(super) struct Columns<'a, 'w, R> {
    writer: &'a mut GroupWriter<'w>,
    rows: &'a [R],
}

impl<'a, 'w, R> Columns<'a, 'w, R> {
    pub(super) fn new(writer: &'a mut GroupWriter<'w>, rows: &'a [R]) -> Self {
        Self { writer, rows }
    }

    /// One number a row, shape `[n]`.
    pub(super) fn numbers<T: Element>(
        &mut self,
        path: &str,
        of: impl Fn(&R) -> T,
    ) -> Result<(), StoreError> {
        let values: Vec<T> = self.rows.iter().map(of).collect();
        self.writer.write(path, &values, &[values.len()])
    }

    /// `N` numbers a row, shape `[n, N]`.
    pub(super) fn vectors<T: Element, const N: usize>(
        &mut self,
        path: &str,
        of: impl Fn(&R) -> [T; N],
    ) -> Result<(), StoreError> {
        let values: Vec<[T; N]> = self.rows.iter().map(of).collect();
        self.writer
            .write(path, values.as_flattened(), &[values.len(), N])
    }

    /// One count or index a row, shape `[n]`.
    pub(super) fn counts(
        &mut self,
        path: &str,
        of: impl Fn(&R) -> usize,
    ) -> Result<(), StoreError> {
        let values: Vec<usize> = self.rows.iter().map(of).collect();
        self.writer.write_indices(path, &values, &[values.len()])
    }

    /// One flag a row, 0 or 1, shape `[n]`.
    pub(super) fn flags(&mut self, path: &str, of: impl Fn(&R) -> bool) -> Result<(), StoreError> {
        self.numbers(path, |row| u8::from(of(row)))
    }

    /// One text a row, shape `[n]`.
    pub(super) fn texts<'t, T: AsRef<str> + 't>(
        &mut self,
        path: &str,
        of: impl Fn(&'a R) -> T,
    ) -> Result<(), StoreError> {
        let texts: Vec<T> = self.rows.iter().map(of).collect();
        let texts: Vec<&str> = texts.iter().map(AsRef::as_ref).collect();
        self.writer.write_texts(path, &texts)
    }

    /// One member of an enumeration a row, shape `[n]`.
    pub(super) fn members<E: StoredEnum>(
        &mut self,
        path: &str,
        of: impl Fn(&R) -> E,
    ) -> Result<(), StoreError> {
        let members: Vec<E> = self.rows.iter().map(of).collect();
        self.writer.write_enum(path, &members, &[members.len()])
    }

    /// `N` members of an enumeration a row, shape `[n, N]`.
    pub(super) fn member_vectors<E: StoredEnum, const N: usize>(
        &mut self,
        path: &str,
        of: impl Fn(&R) -> [E; N],
    ) -> Result<(), StoreError> {
        let members: Vec<[E; N]> = self.rows.iter().map(of).collect();
        self.writer
            .write_enum(path, members.as_flattened(), &[members.len(), N])
    }
}
