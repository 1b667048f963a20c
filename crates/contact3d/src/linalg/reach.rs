//! Solves restricted to the elimination-tree paths of a few unknowns.

use super::factor::CholeskyFactor;
use super::scalar::Scalar;
use super::solve::Workspace;
use super::structure::FactorStructure;

/// The supernodes on the elimination-tree paths from some unknowns to the roots, ascending.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Reach {
    pub(super) supernodes: Vec<usize>,
    /// Number of unknowns of the factor it belongs to.
    size: usize,
}

impl Reach {
    /// The reached supernodes, ascending.
    #[must_use]
    pub(crate) fn supernodes(&self) -> &[usize] {
        &self.supernodes
    }
}

impl FactorStructure {
    /// The supernodes that a right-hand side nonzero in `rows` (numbering of A) makes nonzero in
    /// L⁻¹Pb.
    ///
    /// # Panics
    /// When a row is not an unknown of the factor.
    #[must_use]
    pub(crate) fn reach(&self, rows: impl Iterator<Item = usize>) -> Reach {
        let new_of_old = self.new_of_old();
        self.reach_of_columns(&self.supernode_of_column(), rows.map(|old| new_of_old[old]))
    }

    /// [`Self::reach`] for columns in the new numbering, given their owners.
    fn reach_of_columns(&self, owner: &[usize], columns: impl Iterator<Item = usize>) -> Reach {
        let mut reached = vec![false; self.supernodes()];
        for column in columns {
            let mut next = Some(owner[column]);
            while let Some(s) = next.filter(|&s| !reached[s]) {
                reached[s] = true;
                next = self.parent(s, owner);
            }
        }
        let supernodes = (0..self.supernodes()).filter(|&s| reached[s]).collect();
        Reach {
            supernodes,
            size: self.size(),
        }
    }
}

impl<T: Scalar> CholeskyFactor<T> {
    /// Solves A x = b in place on the unknowns of the reached supernodes only.
    ///
    /// b must be zero outside the rows `reach` was made from. On return those rows (and all
    /// unknowns of the reached supernodes) hold the solution; other entries of `rhs` are left as
    /// they were.
    ///
    /// # Panics
    /// When `rhs` does not have one entry per unknown or `reach` is from a factor of another size.
    pub(crate) fn solve_reached(&self, reach: &Reach, rhs: &mut [f64], work: &mut Workspace) {
        assert_eq!(rhs.len(), self.size(), "length of the right-hand side");
        assert_eq!(
            reach.size,
            self.size(),
            "unknowns of the factor the reach was made from"
        );
        let mut scratch = T::scratch(work).take(self.size());
        for column in self.columns_of(reach) {
            scratch.unknowns[column] = T::rounded(rhs[self.structure.permutation[column]]);
        }
        self.forward(reach.supernodes.iter().copied(), &mut scratch);
        self.backward(reach.supernodes.iter().rev().copied(), &mut scratch);
        for column in self.columns_of(reach) {
            rhs[self.structure.permutation[column]] = scratch.unknowns[column].to_double();
        }
        T::scratch(work).put(scratch);
    }

    fn columns_of(&self, reach: &Reach) -> impl Iterator<Item = usize> {
        reach
            .supernodes
            .iter()
            .flat_map(|&s| self.structure.columns(s))
    }
}
