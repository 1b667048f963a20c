//! Supernodes large enough to be worth a front.

use super::structure::FactorStructure;

/// A subtree of at most this many columns becomes one supernode: the zeros it then stores cost less than the many small fronts,
/// in factorisation and in solves.
const SMALLEST: usize = 32;

impl FactorStructure {
    /// Merges every largest subtree of the elimination tree with at most [`SMALLEST`] columns into one supernode.
    ///
    /// The rows of a descendant are its ancestors' columns inside the subtree, or rows of the subtree's root: so the rows of the
    /// whole are its columns and the rows below its root.
    pub(super) fn with_small_subtrees_merged(self) -> Self {
        let columns = |s: usize| self.columns(s).len();
        let pieces = self
            .supernode_tree()
            .pieces(columns, |columns| columns <= SMALLEST);
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
