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
        let owner = self.supernode_of_column();
        let count = self.supernodes();
        let parents: Vec<Option<usize>> = (0..count).map(|s| self.parent(s, &owner)).collect();
        let mut columns: Vec<usize> = (0..count).map(|s| self.columns(s).len()).collect();
        let mut first: Vec<usize> = (0..count).map(|s| self.supernode_columns[s]).collect();
        for s in 0..count {
            if let Some(parent) = parents[s] {
                columns[parent] += columns[s];
                first[parent] = first[parent].min(first[s]);
            }
        }
        let is_small = |s: usize| columns[s] <= SMALLEST;
        let mut merged = Self {
            permutation: self.permutation.clone(),
            ..Self::empty()
        };
        for s in 0..count {
            if is_small(s) && parents[s].is_some_and(is_small) {
                continue;
            }
            let start = if is_small(s) {
                first[s]
            } else {
                self.supernode_columns[s]
            };
            let own = start..self.supernode_columns[s + 1];
            let height = own.len() + self.front(s).below().len();
            merged
                .value_offsets
                .push(merged.value_count() + height * own.len());
            merged.supernode_columns.push(own.end);
            merged.row_indices.extend(own);
            merged.row_indices.extend_from_slice(self.front(s).below());
            merged.row_offsets.push(merged.row_indices.len());
        }
        merged
    }
}
