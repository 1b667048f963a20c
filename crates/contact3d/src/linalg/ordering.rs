//! Fill-reducing orderings that need the matrix only.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd as faer_amd;
use thiserror::Error;

use super::sparse::CscMatrix;

/// Why no ordering was made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum OrderingError {
    /// The matrix is not square.
    #[error("an ordering needs a square matrix, got {rows} × {cols}")]
    NotSquare {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        cols: usize,
    },
    /// Pointers and neighbours do not describe a graph of the given nodes.
    #[error("adjacency arrays do not describe a graph of {nodes} nodes")]
    NotAGraph {
        /// Number of nodes.
        nodes: usize,
    },
    /// Work space could not be allocated, or an index overflowed.
    #[error("not enough memory to order {rows} rows")]
    OutOfMemory {
        /// Number of rows.
        rows: usize,
    },
}

/// Approximate minimum degree ordering of a symmetric matrix, new → old: row i of PAPᵀ is row
/// `result[i]` of A.
///
/// # Errors
/// [`OrderingError`] for a matrix that is not square or too large for memory.
pub fn amd(a: &CscMatrix) -> Result<Vec<usize>, OrderingError> {
    if a.rows != a.cols {
        return Err(OrderingError::NotSquare {
            rows: a.rows,
            cols: a.cols,
        });
    }
    amd_of_pattern(&a.indptr, &a.indices)
}

/// [`amd`] of a square pattern given by pointers and sorted indices.
pub(super) fn amd_of_pattern(
    indptr: &[usize],
    indices: &[usize],
) -> Result<Vec<usize>, OrderingError> {
    let n = indptr.len() - 1;
    let failure = OrderingError::OutOfMemory { rows: n };
    let mut order = vec![0_usize; n];
    let mut inverse = vec![0_usize; n];
    let scratch = faer_amd::order_scratch::<usize>(n, indices.len());
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| failure.clone())?;
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, indptr, None, indices);
    let control = faer_amd::Control::default();
    faer_amd::order(
        &mut order,
        &mut inverse,
        pattern,
        control,
        MemStack::new(&mut memory),
    )
    .map_err(|_| failure)?;
    Ok(order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::test_brick::Brick;

    #[test]
    fn amd_is_a_permutation() {
        let stiffness = Brick::new(2).stiffness();
        let mut order = amd(&stiffness).expect("square");
        order.sort_unstable();
        assert!(order.iter().copied().eq(0..stiffness.cols));
    }

    #[test]
    fn rectangles_are_refused() {
        let matrix = CscMatrix::new(1, 0, vec![0], vec![], vec![]).expect("valid");
        assert_eq!(
            amd(&matrix),
            Err(OrderingError::NotSquare { rows: 1, cols: 0 })
        );
    }

    #[test]
    fn empty_matrix_has_the_empty_ordering() {
        let matrix = CscMatrix::new(0, 0, vec![0], vec![], vec![]).expect("valid");
        assert_eq!(amd(&matrix), Ok(vec![]));
    }
}
