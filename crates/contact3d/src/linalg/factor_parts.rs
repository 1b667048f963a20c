//! A Cholesky factor from stored arrays, checked so that damaged ones cannot be used.

use thiserror::Error;

use super::elimination_tree::inverse;
use super::factor::CholeskyFactor;
use super::scalar::Scalar;
use super::structure::FactorStructure;

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

impl<T: Scalar> CholeskyFactor<T> {
    /// Rebuilds a factor from its arrays, checking every rule stated at [`FactorStructure`].
    ///
    /// # Errors
    /// [`PartsError`] names the first rule broken; a factor that was accepted cannot cause a panic
    /// in a solve.
    pub fn from_parts(structure: FactorStructure, values: Vec<T>) -> Result<Self, PartsError> {
        inverse(&structure.permutation).ok_or(PartsError::Permutation)?;
        structure.check_supernode_columns()?;
        structure.check_offsets(values.len())?;
        let factor = Self { structure, values };
        let owner = factor.structure.supernode_of_column();
        for supernode in 0..factor.structure.supernodes() {
            if !factor.structure.rows_are_sound(supernode, &owner) {
                return Err(PartsError::Rows { supernode });
            }
            if !factor.values_are_sound(supernode) {
                return Err(PartsError::Values { supernode });
            }
        }
        Ok(factor)
    }

    fn values_are_sound(&self, s: usize) -> bool {
        let panel = self.panel(s);
        panel
            .values
            .chunks_exact(panel.rows.len())
            .enumerate()
            .all(|(k, column)| {
                let (above, rest) = column.split_at(k);
                above.iter().all(|&value| value == T::default())
                    && rest[0] > T::default()
                    && rest.iter().all(|value| value.to_double().is_finite())
            })
    }
}

impl FactorStructure {
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
    fn check_offsets(&self, n_values: usize) -> Result<(), PartsError> {
        let supernodes = self.supernodes();
        let (rows, values) = (&self.row_offsets, &self.value_offsets);
        let ends = |offsets: &[usize], length| {
            offsets.len() == supernodes + 1 && offsets[0] == 0 && offsets[supernodes] == length
        };
        if !ends(rows, self.row_indices.len()) || !ends(values, n_values) {
            return Err(PartsError::Offsets { supernode: 0 });
        }
        for s in 0..supernodes {
            let width = self.supernode_columns[s + 1] - self.supernode_columns[s];
            let height = rows[s + 1]
                .checked_sub(rows[s])
                .filter(|&height| height >= width);
            let entries = values[s + 1].checked_sub(values[s]);
            let expected = height.and_then(|height| height.checked_mul(width));
            let inside = rows[s + 1] <= self.row_indices.len() && values[s + 1] <= n_values;
            if expected.is_none() || entries != expected || !inside {
                return Err(PartsError::Offsets { supernode: s });
            }
        }
        Ok(())
    }

    /// Own columns first, strictly increasing, below the size, and every row past the parent's
    /// first column a row of the parent.
    fn rows_are_sound(&self, s: usize, owner: &[usize]) -> bool {
        let panel = self.front(s);
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
        let mut parent_rows = self.front(owner[next]).rows.iter();
        below
            .iter()
            .all(|row| parent_rows.any(|candidate| candidate == row))
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
        CholeskyFactor::factorise(&stiffness, order).expect("positive definite")
    }

    fn rebuild(f: CholeskyFactor) -> Result<CholeskyFactor, PartsError> {
        CholeskyFactor::from_parts(f.structure, f.values)
    }

    #[test]
    fn sound_parts_give_the_same_factor() {
        assert_eq!(rebuild(factor()), Ok(factor()));
    }

    #[test]
    fn empty_parts_are_sound() {
        let factor = CholeskyFactor::<f64>::from_parts(FactorStructure::empty(), vec![]);
        assert_eq!(factor.map(|factor| factor.size()), Ok(0));
        assert!(CholeskyFactor::<f64>::from_parts(FactorStructure::default(), vec![]).is_err());
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
                0 => &mut damaged.structure.permutation,
                1 => &mut damaged.structure.supernode_columns,
                2 => &mut damaged.structure.row_offsets,
                3 => &mut damaged.structure.row_indices,
                _ => &mut damaged.structure.value_offsets,
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
                0 => drop(damaged.structure.permutation.pop()),
                1 => drop(damaged.structure.supernode_columns.pop()),
                2 => drop(damaged.structure.row_offsets.pop()),
                3 => drop(damaged.structure.row_indices.pop()),
                4 => drop(damaged.structure.value_offsets.pop()),
                _ => drop(damaged.values.pop()),
            }
            prop_assert!(rebuild(damaged).is_err());
        }
    }
}
