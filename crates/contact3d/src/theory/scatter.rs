//! Sparse symmetric matrices gathered from elements.

use std::collections::BTreeMap;

use crate::linalg::{CholeskyFactor, CscMatrix, amd};

/// Sums of element contributions, column by column.
pub(super) struct Scatter {
    columns: Vec<BTreeMap<usize, f64>>,
}

impl Scatter {
    pub(super) fn new(size: usize) -> Self {
        Self {
            columns: vec![BTreeMap::new(); size],
        }
    }

    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        *self.columns[column].entry(row).or_insert(0.0) += value;
    }

    pub(super) fn matrix(self) -> CscMatrix {
        let mut matrix = CscMatrix::empty(self.columns.len());
        matrix.cols = self.columns.len();
        for column in self.columns {
            matrix.indices.extend(column.keys());
            matrix.data.extend(column.values());
            matrix.indptr.push(matrix.indices.len());
        }
        matrix
    }
}

/// A + B of two matrices with the same pattern.
pub(super) fn sum(first: &CscMatrix, second: &CscMatrix) -> CscMatrix {
    let pairs = first.data.iter().zip(&second.data);
    CscMatrix {
        data: pairs.map(|(a, b)| a + b).collect(),
        ..first.clone()
    }
}

/// M x of a symmetric matrix.
pub(super) fn product(matrix: &CscMatrix, x: &[f64]) -> Vec<f64> {
    let mut image = vec![0.0; matrix.cols];
    matrix.mul_transposed(x, &mut image);
    image
}

/// The Cholesky factor of a symmetric positive definite matrix in a fill-reducing order; `None` where it has none.
pub(super) fn factorised(matrix: &CscMatrix) -> Option<CholeskyFactor> {
    CholeskyFactor::factorise(matrix, amd(matrix).ok()?).ok()
}
