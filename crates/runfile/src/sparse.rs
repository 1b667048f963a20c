//! Sparse matrices at the border of the file.

use super::layout::Kind;

/// A compressed sparse matrix that is borrowed to be written.
#[derive(Clone, Copy, Debug)]
pub struct SparseView<'a> {
    /// Rows and columns.
    pub shape: [usize; 2],
    /// Start of each column (CSC) or row (CSR) in `indices` and `data`, and the end of the last.
    pub indptr: &'a [usize],
    /// Row (CSC) or column (CSR) of each entry, increasing within each column or row.
    pub indices: &'a [usize],
    /// Value of each entry.
    pub data: &'a [f64],
}

/// A compressed sparse matrix that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseMatrix {
    /// Rows and columns.
    pub shape: [usize; 2],
    /// Start of each column (CSC) or row (CSR) in `indices` and `data`, and the end of the last.
    pub indptr: Vec<usize>,
    /// Row (CSC) or column (CSR) of each entry, increasing within each column or row.
    pub indices: Vec<usize>,
    /// Value of each entry.
    pub data: Vec<f64>,
}

impl SparseMatrix {
    /// The matrix, borrowed.
    #[must_use]
    pub fn view(&self) -> SparseView<'_> {
        SparseView {
            shape: self.shape,
            indptr: &self.indptr,
            indices: &self.indices,
            data: &self.data,
        }
    }
}

impl SparseView<'_> {
    /// The first breach of the compressed format, if there is one.
    ///
    /// `indptr` starts at 0, does not decrease and ends at the number of entries; indices are in
    /// range and strictly increasing within each column or row.
    #[must_use]
    pub fn problem(&self, kind: Kind) -> Option<String> {
        let [rows, columns] = self.shape;
        let (outer, inner) = if kind == Kind::CscMatrix {
            (columns, rows)
        } else {
            (rows, columns)
        };
        if outer.checked_add(1) != Some(self.indptr.len()) {
            return Some(format!(
                "indptr has {} values for {outer} columns or rows",
                self.indptr.len()
            ));
        }
        if self.indices.len() != self.data.len() {
            return Some(format!(
                "{} indices for {} values",
                self.indices.len(),
                self.data.len()
            ));
        }
        if self.indptr.first() != Some(&0) || self.indptr.last() != Some(&self.data.len()) {
            return Some(format!("indptr does not go from 0 to {}", self.data.len()));
        }
        if !self.indptr.is_sorted() {
            return Some("indptr decreases".into());
        }
        let unordered = |bounds: &[usize]| {
            let indices = &self.indices[bounds[0]..bounds[1]];
            !indices.is_sorted_by(|left, right| left < right)
                || indices.last().is_some_and(|&last| last >= inner)
        };
        let position = self.indptr.windows(2).position(unordered)?;
        Some(format!(
            "indices of column or row {position} are not increasing or not below {inner}"
        ))
    }
}
