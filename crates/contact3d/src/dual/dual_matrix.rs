//! The dual operator as it is held.

use std::sync::Arc;

use super::dense::symmetric_product;
use crate::linalg::{CscMatrix, add_scaled};

/// S, exactly symmetric, `[n_multipliers, n_multipliers]`, in m³/Pa; shared by problems that differ in their loads.
#[derive(Debug, Clone, PartialEq)]
pub enum DualMatrix {
    /// Column-major: the panes of one body all move each other.
    Dense(Arc<Vec<f64>>),
    /// By columns: contacts between many bodies move their neighbours only.
    Sparse(Arc<CscMatrix>),
}

impl DualMatrix {
    /// All coefficients, column-major.
    ///
    /// # Panics
    /// If S is sparse; that of a body never is.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        match self {
            Self::Dense(values) => values,
            Self::Sparse(_) => panic!("the dual operator of a body is dense"),
        }
    }

    /// S_jj of `n` multipliers.
    pub(super) fn diagonal(&self, j: usize, n: usize) -> f64 {
        match self {
            Self::Dense(values) => values[j * n + j],
            Self::Sparse(matrix) => matrix.diagonal(j),
        }
    }

    /// y += a S_j.
    pub(super) fn add_column(&self, j: usize, factor: f64, out: &mut [f64]) {
        match self {
            Self::Dense(values) => {
                let n = out.len();
                add_scaled(out, factor, &values[j * n..(j + 1) * n]);
            }
            Self::Sparse(matrix) => {
                let (rows, values) = matrix.column(j);
                for (&row, value) in rows.iter().zip(values) {
                    out[row] += factor * value;
                }
            }
        }
    }

    /// S λ.
    pub(super) fn apply(&self, multiplier: &[f64]) -> Vec<f64> {
        match self {
            Self::Dense(values) => symmetric_product(values, multiplier),
            Self::Sparse(matrix) => {
                let mut product = vec![0.0; multiplier.len()];
                matrix.mul_transposed(multiplier, &mut product);
                product
            }
        }
    }
}
