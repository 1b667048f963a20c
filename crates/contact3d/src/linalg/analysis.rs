//! Symbolic factorisation: the structure of the factor of a matrix in a given order, before its coefficients are allocated.

use faer::{
    Side,
    perm::PermRef,
    sparse::{
        SymbolicSparseColMatRef,
        linalg::{
            SupernodalThreshold, SymbolicSupernodalParams,
            cholesky::{
                CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
                factorize_symbolic_cholesky,
            },
        },
    },
};

use super::{
    sparse::CscMatrix,
    structure::{FactorError, FactorStructure, inverse},
};

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
        let (rows, size, length) = (a.rows, a.cols, permutation.len());
        if rows != size {
            return Err(FactorError::NotSquare { rows, cols: size });
        }
        let first_inverse = inverse(&permutation)
            .filter(|_| length == size)
            .ok_or(FactorError::NotAPermutation { length, size })?;
        if size == 0 {
            return Ok(Self::empty());
        }
        let permutation = postordered(a, &permutation, &first_inverse);
        let out_of_memory = FactorError::OutOfMemory { size };
        let symbolic = analyse(a, &permutation).ok_or(out_of_memory.clone())?;
        let SymbolicCholeskyRaw::Supernodal(supernodes) = symbolic.raw() else {
            return Err(out_of_memory);
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

/// Symbolic factorisation for a postordered permutation, always supernodal; `None` where memory runs out.
fn analyse(a: &CscMatrix, permutation: &[usize]) -> Option<SymbolicCholesky<usize>> {
    let new_of_old = inverse(permutation)?;
    let parameters = CholeskySymbolicParams {
        // any factor has more than −1 operations per entry, so this never chooses the simplicial method
        supernodal_flop_ratio_threshold: SupernodalThreshold(-1.0),
        supernodal_params: SymbolicSupernodalParams {
            relax: Some(&RELAXATION),
        },
        ..Default::default()
    };
    let ordering =
        SymmetricOrdering::Custom(PermRef::new_checked(permutation, &new_of_old, a.cols));
    let pattern = SymbolicSparseColMatRef::new_checked(a.rows, a.cols, &a.indptr, None, &a.indices);
    factorize_symbolic_cholesky(pattern, Side::Upper, ordering, parameters).ok()
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

/// Reorders `permutation` (new → old) by a postorder of its elimination tree: the same fill and the
/// same operations, but the columns of every subtree become neighbours, which lets supernodes
/// merge. The largest child comes last.
pub(super) fn postordered(a: &CscMatrix, permutation: &[usize], inverse: &[usize]) -> Vec<usize> {
    let parent = elimination_tree(a, permutation, inverse);
    postorder(&parent)
        .into_iter()
        .map(|new| permutation[new])
        .collect()
}

/// Parent of each column of the factor of PAPᵀ (Liu's algorithm with path compression); roots have
/// `NONE`.
fn elimination_tree(a: &CscMatrix, permutation: &[usize], inverse: &[usize]) -> Vec<usize> {
    let n = permutation.len();
    let mut parent = vec![NONE; n];
    let mut ancestor = vec![NONE; n];
    for new in 0..n {
        for &old_row in a.column(permutation[new]).0 {
            let mut node = inverse[old_row];
            while node != NONE && node < new {
                let next = ancestor[node];
                ancestor[node] = new;
                if next == NONE {
                    parent[node] = new;
                }
                node = next;
            }
        }
    }
    parent
}

/// Postorder of a forest whose parents have larger numbers than their children.
fn postorder(parent: &[usize]) -> Vec<usize> {
    let n = parent.len();
    let mut size = vec![1_usize; n];
    for node in (0..n).filter(|&node| parent[node] != NONE) {
        size[parent[node]] += size[node];
    }
    // The place of a subtree's root is the end of the subtree's range; ranges are handed out from the last root down, then
    // to the largest subtrees first, which are never larger than their parent's.
    let mut handed: Vec<usize> = (0..n).filter(|&node| parent[node] != NONE).collect();
    handed.sort_unstable_by_key(|&node| (size[node], node));
    handed.extend((0..n).filter(|&node| parent[node] == NONE));
    let mut end = vec![0; n];
    // What is left of the range below each node and, last, below all roots.
    let mut free = vec![n; n + 1];
    for node in handed.into_iter().rev() {
        let left = &mut free[parent[node].min(n)];
        end[node] = *left;
        *left -= size[node];
        free[node] = end[node] - 1;
    }
    let mut order = vec![0; n];
    for node in 0..n {
        order[end[node] - 1] = node;
    }
    order
}

/// No column: the parent of a root.
const NONE: usize = usize::MAX;

impl FactorStructure {
    /// Merges every largest subtree of the elimination tree with at most 32 columns into one supernode: the zeros it then stores cost less
    /// than the many small fronts, in factorisation and in solves.
    ///
    /// The rows of a descendant are its ancestors' columns inside the subtree, or rows of the subtree's root: so the rows of the
    /// whole are its columns and the rows below its root.
    pub(super) fn with_small_subtrees_merged(self) -> Self {
        let columns = |s: usize| self.columns(s).len();
        let pieces = self
            .supernode_tree()
            .pieces(columns, |columns| columns <= 32);
        let mut merged = Self {
            permutation: self.permutation.clone(),
            ..Self::empty()
        };
        for piece in pieces {
            let own = self.supernode_columns[piece.start]..self.supernode_columns[piece.end];
            let below = self.front(piece.end - 1).below();
            let height = own.len() + below.len();
            merged
                .value_offsets
                .push(merged.value_count() + height * own.len());
            merged.supernode_columns.push(own.end);
            merged.row_indices.extend(own);
            merged.row_indices.extend_from_slice(below);
            merged.row_offsets.push(merged.row_indices.len());
        }
        merged
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_refuses_what_is_not_a_permutation() {
        assert_eq!(inverse(&[2, 0, 1]), Some(vec![1, 2, 0]));
        assert_eq!(inverse(&[2, 0, 0]), None);
        assert_eq!(inverse(&[3, 0, 1]), None);
    }

    #[test]
    fn postorder_keeps_subtrees_together_and_puts_the_largest_child_last() {
        // roots 5 and 6; 5 has the children 3 (with child 0) and 4 (leaf); 3's other child is 1; 6
        // has 2
        let parent = [3, 3, 6, 5, 5, NONE, NONE];
        let order = postorder(&parent);
        assert_eq!(order, [4, 0, 1, 3, 5, 2, 6]);
    }
}
