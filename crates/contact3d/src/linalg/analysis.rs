//! Symbolic factorisation: the structure of the factor, known before its coefficients are allocated.

use faer::Side;
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::linalg::{SupernodalThreshold, SymbolicSupernodalParams};

use super::elimination_tree::{inverse, postordered};
use super::factor::{FactorError, pattern};
use super::sparse::CscMatrix;
use super::structure::FactorStructure;

/// Two neighbouring supernodes of at most `.0` columns together merge when less than the share `.1` of the result is zero.
const RELAXATION: [(usize, f64); 4] = [(4, 1.0), (16, 0.8), (48, 0.1), (usize::MAX, 0.05)];

impl FactorStructure {
    /// Finds the structure of L in LLᵀ = PAPᵀ.
    ///
    /// `permutation` is a fill-reducing ordering, new → old. It is replaced by a postorder of its elimination tree,
    /// which has the same fill; the structure holds the final one. A must store both triangles.
    ///
    /// # Errors
    /// [`FactorError`] when A is not square, the ordering is no permutation, or memory runs out.
    pub fn analyse(a: &CscMatrix, permutation: Vec<usize>) -> Result<Self, FactorError> {
        let size = a.cols;
        if a.rows != size {
            return Err(FactorError::NotSquare {
                rows: a.rows,
                cols: size,
            });
        }
        let not_a_permutation = FactorError::NotAPermutation {
            length: permutation.len(),
            size,
        };
        if permutation.len() != size {
            return Err(not_a_permutation);
        }
        if size == 0 {
            return Ok(Self::empty());
        }
        let first_inverse = inverse(&permutation).ok_or(not_a_permutation)?;
        let permutation = postordered(a, &permutation, &first_inverse);
        let symbolic = analyse(a, &permutation)?;
        let SymbolicCholeskyRaw::Supernodal(supernodes) = symbolic.raw() else {
            return Err(FactorError::OutOfMemory { size });
        };
        let mut supernode_columns = supernodes.supernode_begin().to_vec();
        supernode_columns.push(size);
        let (row_offsets, row_indices) = panel_rows(
            &supernode_columns,
            supernodes.col_ptr_for_row_idx(),
            supernodes.row_idx(),
        );
        let structure = Self {
            permutation,
            supernode_columns,
            row_offsets,
            row_indices,
            value_offsets: supernodes.col_ptr_for_val().to_vec(),
        };
        Ok(structure.with_small_subtrees_merged())
    }
}

/// Symbolic factorisation for a postordered permutation, always supernodal.
fn analyse(a: &CscMatrix, permutation: &[usize]) -> Result<SymbolicCholesky<usize>, FactorError> {
    let size = a.cols;
    let new_of_old = inverse(permutation).ok_or(FactorError::NotAPermutation {
        length: permutation.len(),
        size,
    })?;
    let parameters = CholeskySymbolicParams {
        // any factor has more than −1 operations per entry, so this never chooses the simplicial method
        supernodal_flop_ratio_threshold: SupernodalThreshold(-1.0),
        supernodal_params: SymbolicSupernodalParams {
            relax: Some(&RELAXATION),
        },
        ..Default::default()
    };
    let ordering = SymmetricOrdering::Custom(PermRef::new_checked(permutation, &new_of_old, size));
    factorize_symbolic_cholesky(pattern(a), Side::Upper, ordering, parameters)
        .map_err(|_| FactorError::OutOfMemory { size })
}

/// Puts each supernode's own columns before the rows below its diagonal block.
fn panel_rows(
    supernode_columns: &[usize],
    below_offsets: &[usize],
    below: &[usize],
) -> (Vec<usize>, Vec<usize>) {
    let mut offsets = vec![0];
    let mut rows = Vec::with_capacity(below.len() + supernode_columns.last().unwrap_or(&0));
    for (s, columns) in supernode_columns.windows(2).enumerate() {
        rows.extend(columns[0]..columns[1]);
        rows.extend_from_slice(&below[below_offsets[s]..below_offsets[s + 1]]);
        offsets.push(rows.len());
    }
    (offsets, rows)
}
