//! Compressed-column sparse matrices and their products.

use rayon::prelude::*;

/// A sparse matrix M by compressed columns, with strictly increasing row indices inside each
/// column.
///
/// Column j holds rows `indices[indptr[j]..indptr[j + 1]]` with the coefficients at the same places
/// of `data`, as in `scipy.sparse.csc_matrix`.
#[derive(Clone, Debug, PartialEq)]
pub struct CscMatrix {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
    /// Start of each column in `indices` and `data`, length `cols + 1`.
    pub indptr: Vec<usize>,
    /// Row of each stored entry, strictly increasing inside a column.
    pub indices: Vec<usize>,
    /// Coefficient of each stored entry.
    pub data: Vec<f64>,
}

impl CscMatrix {
    /// A matrix without columns.
    #[must_use]
    pub fn empty(rows: usize) -> Self {
        Self {
            rows,
            cols: 0,
            indptr: vec![0],
            indices: Vec::new(),
            data: Vec::new(),
        }
    }

    /// A matrix of some columns, each with increasing rows.
    pub fn of_columns<C: IntoIterator<Item = (usize, f64)>>(
        rows: usize,
        columns: impl IntoIterator<Item = C>,
    ) -> Self {
        let mut matrix = Self::empty(rows);
        columns.into_iter().for_each(|it| matrix.push_column(it));
        matrix
    }

    /// Adds a column with increasing rows.
    pub fn push_column(&mut self, entries: impl IntoIterator<Item = (usize, f64)>) {
        for (row, value) in entries {
            self.indices.push(row);
            self.data.push(value);
        }
        self.indptr.push(self.indices.len());
        self.cols += 1;
    }

    /// Rows and coefficients of one column.
    ///
    /// # Panics
    /// When `column` is not below `cols`.
    #[must_use]
    pub fn column(&self, column: usize) -> (&[usize], &[f64]) {
        let range = self.indptr[column]..self.indptr[column + 1];
        (&self.indices[range.clone()], &self.data[range])
    }

    /// The rows and values of a column.
    pub fn entries(&self, column: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let (rows, values) = self.column(column);
        rows.iter().copied().zip(values.iter().copied())
    }

    /// Where the diagonal entry of a column is stored; `None` where it is not.
    pub(crate) fn place_of_diagonal(&self, column: usize) -> Option<usize> {
        let first = self.indptr[column];
        let (rows, _) = self.column(column);
        rows.binary_search(&column).ok().map(|at| first + at)
    }

    /// The diagonal entry of a column, 0 where none is stored.
    #[must_use]
    pub fn diagonal(&self, column: usize) -> f64 {
        self.place_of_diagonal(column)
            .map_or(0.0, |at| self.data[at])
    }

    /// The mean of the diagonal of a square matrix; 0 without rows.
    #[must_use]
    pub fn mean_diagonal(&self) -> f64 {
        let sum: f64 = (0..self.cols).map(|column| self.diagonal(column)).sum();
        sum / self.cols.max(1) as f64
    }

    /// Product y = M x, summed column after column on one thread; x has `cols` and y has `rows`
    /// entries.
    ///
    /// For a symmetric M, `mul_transposed` gives the same product in parallel.
    ///
    /// # Panics
    /// When x or y has the wrong length.
    pub fn mul(&self, x: &[f64], y: &mut [f64]) {
        assert_eq!(x.len(), self.cols, "length of x");
        assert_eq!(y.len(), self.rows, "length of y");
        y.fill(0.0);
        for (column, &factor) in x.iter().enumerate() {
            for (row, coefficient) in self.entries(column) {
                y[row] += coefficient * factor;
            }
        }
    }

    /// Product y = Mᵀ x; x has `rows` and y has `cols` entries.
    ///
    /// Every yⱼ is one sum in storage order, so big products run in parallel and keep the same bits
    /// at any thread count.
    ///
    /// # Panics
    /// When x or y has the wrong length.
    pub fn mul_transposed(&self, x: &[f64], y: &mut [f64]) {
        assert_eq!(x.len(), self.rows, "length of x");
        assert_eq!(y.len(), self.cols, "length of y");
        let product = |(column, value): (usize, &mut f64)| {
            *value = self.entries(column).map(|(row, a)| a * x[row]).sum();
        };
        // The work of fewer entries is shorter than waking the pool.
        if self.data.len() < 1 << 18 {
            y.iter_mut().enumerate().for_each(product);
        } else {
            y.par_iter_mut()
                .with_min_len(1024)
                .enumerate()
                .for_each(product);
        }
    }

    /// The transposed matrix Mᵀ, again by compressed columns.
    #[must_use]
    pub fn transpose(&self) -> Self {
        let mut indptr = vec![0; self.rows + 1];
        for &row in &self.indices {
            indptr[row + 1] += 1;
        }
        for row in 0..self.rows {
            indptr[row + 1] += indptr[row];
        }
        let mut next = indptr.clone();
        let mut indices = vec![0; self.indices.len()];
        let mut data = vec![0.0; self.data.len()];
        for column in 0..self.cols {
            for (row, coefficient) in self.entries(column) {
                indices[next[row]] = column;
                data[next[row]] = coefficient;
                next[row] += 1;
            }
        }
        Self {
            rows: self.cols,
            cols: self.rows,
            indptr,
            indices,
            data,
        }
    }
}
