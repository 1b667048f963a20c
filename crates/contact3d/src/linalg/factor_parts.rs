//! A Cholesky factor from stored arrays, checked so that damaged ones cannot be used.

use thiserror::Error;

use super::elimination_tree::inverse;
use super::factor::CholeskyFactor;

/// Which rule of [`CholeskyFactor`]'s layout stored arrays break.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PartsError {
    /// `permutation` is not a permutation.
    #[error("the stored ordering is not a permutation")]
    Permutation,
    /// `supernode_columns` does not rise strictly from 0 to the number of unknowns.
    #[error("supernode columns do not rise from 0 to the {size} unknowns")]
    SupernodeColumns {
        /// Number of unknowns.
        size: usize,
    },
    /// `row_offsets` or `value_offsets` does not fit its array.
    #[error("offsets of supernode {supernode} do not fit its rows and columns")]
    Offsets {
        /// The first offending supernode.
        supernode: usize,
    },
    /// Rows do not start with the supernode's columns, do not increase, or are not rows of its
    /// parent.
    #[error("rows of supernode {supernode} contradict the elimination tree")]
    Rows {
        /// The first offending supernode.
        supernode: usize,
    },
    /// A coefficient is not finite, or a diagonal one not positive, or one above the diagonal not
    /// zero.
    #[error("coefficients of supernode {supernode} are not those of a Cholesky factor")]
    Values {
        /// The first offending supernode.
        supernode: usize,
    },
}

impl CholeskyFactor {
    /// Rebuilds a factor from the arrays described at [`CholeskyFactor`], checking every rule
    /// stated there.
    ///
    /// # Errors
    /// [`PartsError`] names the first rule broken; a factor that was accepted cannot cause a panic
    /// in a solve.
    pub fn from_parts(
        permutation: Vec<usize>,
        supernode_columns: Vec<usize>,
        row_offsets: Vec<usize>,
        row_indices: Vec<usize>,
        value_offsets: Vec<usize>,
        values: Vec<f64>,
    ) -> Result<Self, PartsError> {
        inverse(&permutation).ok_or(PartsError::Permutation)?;
        let factor = Self {
            permutation,
            supernode_columns,
            row_offsets,
            row_indices,
            value_offsets,
            values,
        };
        factor.check_supernode_columns()?;
        factor.check_offsets()?;
        let owner = factor.supernode_of_column();
        for supernode in 0..factor.supernodes() {
            if !factor.rows_are_sound(supernode, &owner) {
                return Err(PartsError::Rows { supernode });
            }
            if !factor.values_are_sound(supernode) {
                return Err(PartsError::Values { supernode });
            }
        }
        Ok(factor)
    }

    fn check_supernode_columns(&self) -> Result<(), PartsError> {
        let size = self.size();
        let columns = &self.supernode_columns;
        let ends = columns.first() == Some(&0) && columns.last() == Some(&size);
        if ends && columns.windows(2).all(|pair| pair[0] < pair[1]) {
            Ok(())
        } else {
            Err(PartsError::SupernodeColumns { size })
        }
    }

    /// Row and value offsets start at 0, end with their arrays, and leave (rows × columns) values
    /// to each supernode.
    fn check_offsets(&self) -> Result<(), PartsError> {
        let supernodes = self.supernodes();
        let (rows, values) = (&self.row_offsets, &self.value_offsets);
        let ends = |offsets: &[usize], length| {
            offsets.len() == supernodes + 1 && offsets[0] == 0 && offsets[supernodes] == length
        };
        if !ends(rows, self.row_indices.len()) || !ends(values, self.values.len()) {
            return Err(PartsError::Offsets { supernode: 0 });
        }
        for s in 0..supernodes {
            let width = self.supernode_columns[s + 1] - self.supernode_columns[s];
            let height = rows[s + 1]
                .checked_sub(rows[s])
                .filter(|&height| height >= width);
            let entries = values[s + 1].checked_sub(values[s]);
            let expected = height.and_then(|height| height.checked_mul(width));
            let inside =
                rows[s + 1] <= self.row_indices.len() && values[s + 1] <= self.values.len();
            if expected.is_none() || entries != expected || !inside {
                return Err(PartsError::Offsets { supernode: s });
            }
        }
        Ok(())
    }

    /// Own columns first, strictly increasing, below the size, and every row past the parent's
    /// first column a row of the parent.
    fn rows_are_sound(&self, s: usize, owner: &[usize]) -> bool {
        let panel = self.panel(s);
        let (own, below) = panel.rows.split_at(panel.width);
        let increasing = panel.rows.windows(2).all(|pair| pair[0] < pair[1]);
        let inside = panel.rows.last().is_some_and(|&row| row < self.size());
        if !increasing
            || !inside
            || !own
                .iter()
                .copied()
                .eq(panel.first..panel.first + panel.width)
        {
            return false;
        }
        let Some(&next) = below.first() else {
            return true;
        };
        let mut parent_rows = self.panel(owner[next]).rows.iter();
        below
            .iter()
            .all(|row| parent_rows.any(|candidate| candidate == row))
    }

    fn values_are_sound(&self, s: usize) -> bool {
        let panel = self.panel(s);
        panel
            .values
            .chunks_exact(panel.rows.len())
            .enumerate()
            .all(|(k, column)| {
                let (above, rest) = column.split_at(k);
                above.iter().all(|&value| value == 0.0)
                    && rest[0] > 0.0
                    && rest.iter().all(|value| value.is_finite())
            })
    }

    /// The supernode that owns each column.
    pub(super) fn supernode_of_column(&self) -> Vec<usize> {
        let mut owner = vec![0; self.size()];
        for s in 0..self.supernodes() {
            owner[self.supernode_columns[s]..self.supernode_columns[s + 1]].fill(s);
        }
        owner
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::ordering::amd;
    use crate::linalg::test_brick::Brick;
    use proptest::prelude::*;

    fn factor() -> CholeskyFactor {
        let stiffness = Brick::new(2).stiffness();
        let order = amd(&stiffness).expect("square");
        CholeskyFactor::factorise(&stiffness, order, 1).expect("positive definite")
    }

    fn rebuild(f: CholeskyFactor) -> Result<CholeskyFactor, PartsError> {
        CholeskyFactor::from_parts(
            f.permutation,
            f.supernode_columns,
            f.row_offsets,
            f.row_indices,
            f.value_offsets,
            f.values,
        )
    }

    #[test]
    fn sound_parts_give_the_same_factor() {
        assert_eq!(rebuild(factor()), Ok(factor()));
    }

    #[test]
    fn empty_parts_are_sound() {
        let factor = CholeskyFactor::from_parts(vec![], vec![0], vec![0], vec![], vec![0], vec![]);
        assert_eq!(factor.map(|factor| factor.size()), Ok(0));
        assert!(
            CholeskyFactor::from_parts(vec![], vec![], vec![], vec![], vec![], vec![]).is_err()
        );
    }

    #[test]
    fn coefficients_of_no_factor_are_refused() {
        for (place, value) in [(0, -1.0), (0, 0.0), (0, f64::NAN), (1, f64::INFINITY)] {
            let mut damaged = factor();
            damaged.values[place] = value;
            assert_eq!(rebuild(damaged), Err(PartsError::Values { supernode: 0 }));
        }
    }

    proptest! {
        #[test]
        fn any_changed_index_is_refused(array in 0..5_usize, place in 0.0..1.0_f64, value in prop_oneof![0..400_usize, Just(usize::MAX)]) {
            let mut damaged = factor();
            let target = match array {
                0 => &mut damaged.permutation,
                1 => &mut damaged.supernode_columns,
                2 => &mut damaged.row_offsets,
                3 => &mut damaged.row_indices,
                _ => &mut damaged.value_offsets,
            };
            let place = (place * target.len() as f64) as usize;
            prop_assume!(target[place] != value);
            target[place] = value;
            // a changed row index may still describe a (different) sound factor; then a solve must
            // not panic
            if let Ok(other) = rebuild(damaged) {
                prop_assert_eq!(array, 3);
                let mut rhs = vec![1.0; other.size()];
                other.solve_in_place(&mut rhs, &mut crate::linalg::Workspace::default());
            }
        }

        #[test]
        fn shortened_arrays_are_refused(array in 0..6_usize) {
            let mut damaged = factor();
            match array {
                0 => drop(damaged.permutation.pop()),
                1 => drop(damaged.supernode_columns.pop()),
                2 => drop(damaged.row_offsets.pop()),
                3 => drop(damaged.row_indices.pop()),
                4 => drop(damaged.value_offsets.pop()),
                _ => drop(damaged.values.pop()),
            }
            prop_assert!(rebuild(damaged).is_err());
        }
    }
}
