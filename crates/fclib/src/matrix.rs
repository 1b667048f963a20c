//! Sparse matrices, held by compressed columns whatever the file has.

use crate::FclibError;

/// How a file holds a matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MatrixStorage {
    /// Compressed columns, `nz` = −1.
    Columns,
    /// Compressed rows, `nz` = −2.
    Rows,
    /// Triplets, `nz` ≥ 0 of them.
    Triplets,
}

/// A sparse matrix by compressed columns, row indices strictly increasing inside each column.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// Start of each column in `indices` and `values`, `[columns + 1]`.
    pub starts: Vec<usize>,
    /// Row of each entry.
    pub indices: Vec<usize>,
    /// Each entry.
    pub values: Vec<f64>,
}

/// The arrays of a matrix in a file.
#[derive(Debug)]
pub(crate) struct StoredMatrix<'a> {
    pub(crate) nz: i32,
    pub(crate) p: Vec<i32>,
    pub(crate) i: Vec<i32>,
    pub(crate) x: &'a [f64],
}

impl Matrix {
    /// A dense matrix, column-major; zeros become entries too.
    ///
    /// # Panics
    /// Where `values` has another number of entries than `rows` × `columns`.
    #[must_use]
    pub fn dense(rows: usize, columns: usize, values: Vec<f64>) -> Self {
        assert_eq!(values.len(), rows * columns, "a dense matrix is full");
        Self {
            rows,
            columns,
            starts: (0..=columns).map(|j| j * rows).collect(),
            indices: (0..columns).flat_map(|_| 0..rows).collect(),
            values,
        }
    }

    /// From entries (row, column, value) in any order; those at the same place are added.
    ///
    /// # Panics
    /// Where an entry lies outside.
    #[must_use]
    pub fn from_entries(
        rows: usize,
        columns: usize,
        mut entries: Vec<(usize, usize, f64)>,
    ) -> Self {
        entries.sort_by_key(|&(row, column, _)| (column, row));
        let mut matrix = Self {
            rows,
            columns,
            starts: vec![0; columns + 1],
            indices: Vec::with_capacity(entries.len()),
            values: Vec::with_capacity(entries.len()),
        };
        let mut last = None;
        for (row, column, value) in entries {
            assert!(
                row < rows && column < columns,
                "an entry outside its matrix"
            );
            if last == Some((row, column)) {
                *matrix.values.last_mut().expect("an entry before") += value;
                continue;
            }
            last = Some((row, column));
            matrix.indices.push(row);
            matrix.values.push(value);
            matrix.starts[column + 1] += 1;
        }
        for column in 0..columns {
            matrix.starts[column + 1] += matrix.starts[column];
        }
        matrix
    }

    /// The entries (row, column, value), column after column.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        (0..self.columns).flat_map(move |column| {
            let range = self.starts[column]..self.starts[column + 1];
            range.map(move |k| (self.indices[k], column, self.values[k]))
        })
    }

    /// The arrays as a file holds them, by compressed columns or as triplets.
    ///
    /// # Errors
    /// [`FclibError::TooLarge`].
    pub(crate) fn stored(&self, storage: MatrixStorage) -> Result<StoredMatrix<'_>, FclibError> {
        let i = self.indices.iter().map(|&row| int("rows", row));
        let p: Result<Vec<i32>, FclibError> = match storage {
            MatrixStorage::Triplets => {
                let columns = self.entries().map(|(_, column, _)| int("columns", column));
                columns.collect()
            }
            MatrixStorage::Columns | MatrixStorage::Rows => {
                let starts = self.starts.iter();
                starts.map(|&start| int("entries", start)).collect()
            }
        };
        Ok(StoredMatrix {
            nz: match storage {
                MatrixStorage::Columns => -1,
                MatrixStorage::Rows => -2,
                MatrixStorage::Triplets => int("entries", self.values.len())?,
            },
            p: p?,
            i: i.collect::<Result<_, _>>()?,
            x: &self.values,
        })
    }
}

/// A number as files hold it.
pub(crate) fn int(what: &'static str, count: usize) -> Result<i32, FclibError> {
    i32::try_from(count).map_err(|_| FclibError::TooLarge { what, count })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_sorted_and_those_at_one_place_added() {
        let matrix = Matrix::from_entries(
            2,
            3,
            vec![(1, 2, 5.0), (0, 0, 1.0), (1, 2, -2.0), (1, 0, 4.0)],
        );
        assert_eq!(matrix.starts, [0, 2, 2, 3]);
        assert_eq!(matrix.indices, [0, 1, 1]);
        assert_eq!(matrix.values, [1.0, 4.0, 3.0]);
        let stored = matrix.stored(MatrixStorage::Triplets).expect("small");
        assert_eq!(
            (stored.nz, stored.p, stored.i),
            (3, vec![0, 0, 2], vec![0, 1, 1])
        );
    }

    #[test]
    fn a_dense_matrix_has_all_entries() {
        let matrix = Matrix::dense(2, 2, vec![1.0, 0.0, 3.0, 4.0]);
        let entries: Vec<_> = matrix.entries().collect();
        assert_eq!(
            entries,
            [(0, 0, 1.0), (1, 0, 0.0), (0, 1, 3.0), (1, 1, 4.0)]
        );
    }
}
