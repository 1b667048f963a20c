//! The structure of a Cholesky factor: supernodes, their rows, the elimination tree.

use std::ops::{AddAssign, Range};

use thiserror::Error;

/// The supernodes of L in PAPᵀ = LLᵀ and the rows of each.
///
/// Row i of PAPᵀ is row `permutation[i]` of A (new → old), that is (Px)ᵢ = x\[permutation\[i\]\].
/// Supernode s owns the consecutive columns `supernode_columns[s]..supernode_columns[s + 1]` of L. They share the rows
/// `row_indices[row_offsets[s]..row_offsets[s + 1]]`, strictly increasing, the first of which are the columns
/// themselves. Their coefficients are a dense column-major panel of shape (rows, columns) at
/// `value_offsets[s]..value_offsets[s + 1]`; the strict upper triangle of its leading square is zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FactorStructure {
    /// New → old.
    pub permutation: Vec<usize>,
    /// First column of each supernode and, last, the number of unknowns.
    pub supernode_columns: Vec<usize>,
    /// Start of each supernode's rows, one more than there are supernodes.
    pub row_offsets: Vec<usize>,
    /// Rows of each supernode, its own columns first, strictly increasing inside a supernode.
    pub row_indices: Vec<usize>,
    /// Start of each supernode's panel, one more than there are supernodes.
    pub value_offsets: Vec<usize>,
}

/// Rows and columns of one supernode: `width` columns from `first` over `rows`.
#[derive(Clone, Copy)]
pub(super) struct Front<'a> {
    pub(super) first: usize,
    pub(super) width: usize,
    pub(super) rows: &'a [usize],
}

impl FactorStructure {
    /// The structure of the matrix without unknowns.
    pub(super) fn empty() -> Self {
        Self {
            supernode_columns: vec![0],
            row_offsets: vec![0],
            value_offsets: vec![0],
            ..Self::default()
        }
    }

    /// Number of unknowns.
    #[must_use]
    pub fn size(&self) -> usize {
        self.permutation.len()
    }

    /// Number of supernodes.
    #[must_use]
    pub fn supernodes(&self) -> usize {
        self.supernode_columns.len() - 1
    }

    /// Number of coefficients.
    #[must_use]
    pub fn value_count(&self) -> usize {
        self.value_offsets.last().copied().unwrap_or(0)
    }

    /// Multiplications and additions that compute the coefficients, Σ (rows from the diagonal on)² over the columns.
    #[must_use]
    pub fn operations(&self) -> f64 {
        (0..self.supernodes())
            .map(|s| self.front(s).operations())
            .sum()
    }

    pub(super) fn front(&self, s: usize) -> Front<'_> {
        let columns = self.columns(s);
        Front {
            first: columns.start,
            width: columns.len(),
            rows: &self.row_indices[self.row_offsets[s]..self.row_offsets[s + 1]],
        }
    }

    /// The columns of one supernode.
    pub(super) fn columns(&self, s: usize) -> std::ops::Range<usize> {
        self.supernode_columns[s]..self.supernode_columns[s + 1]
    }

    /// The supernode that owns each column.
    pub(super) fn supernode_of_column(&self) -> Vec<usize> {
        let mut owner = vec![0; self.size()];
        for s in 0..self.supernodes() {
            owner[self.columns(s)].fill(s);
        }
        owner
    }

    /// New number of each unknown of A.
    pub(super) fn new_of_old(&self) -> Vec<usize> {
        inverse(&self.permutation).expect("a checked permutation")
    }
}

impl<'a> Front<'a> {
    /// Rows below the supernode's own columns.
    pub(super) fn below(&self) -> &'a [usize] {
        &self.rows[self.width..]
    }

    pub(super) fn operations(&self) -> f64 {
        let height = self.rows.len();
        (0..self.width).map(|k| ((height - k) as f64).powi(2)).sum()
    }

    /// Multiplications and additions of a forward pass with some right-hand sides.
    pub(super) fn solve_operations(&self, columns: usize) -> f64 {
        let (width, height) = (self.width as f64, self.rows.len() as f64);
        columns as f64 * width * (2.0 * height - width)
    }
}

/// The inverse of a permutation, or `None` when `permutation` is not one of 0..n.
pub(super) fn inverse(permutation: &[usize]) -> Option<Vec<usize>> {
    let mut result = vec![usize::MAX; permutation.len()];
    for (new, &old) in permutation.iter().enumerate() {
        let place = result.get_mut(old)?;
        if *place != usize::MAX {
            return None;
        }
        *place = new;
    }
    Some(result)
}

/// Places of the entries of an ascending list in an ascending list that contains them.
pub(super) fn positions(entries: &[usize], list: &[usize]) -> Vec<usize> {
    let mut next = 0;
    let place = |entry: &usize| {
        while list[next] < *entry {
            next += 1;
        }
        next
    };
    entries.iter().map(place).collect()
}

/// The supernodal elimination tree.
#[derive(Clone, Debug)]
pub(super) struct SupernodeTree {
    /// The supernode of each column of the factor.
    pub(super) owner: Vec<usize>,
    /// The parent of each supernode: the owner of its first row below the diagonal block.
    pub(super) parent: Vec<Option<usize>>,
}

impl FactorStructure {
    /// The supernodal elimination tree.
    pub(super) fn supernode_tree(&self) -> SupernodeTree {
        let owner = self.supernode_of_column();
        let first_below = |s: usize| self.front(s).below().first().copied();
        let parent = |s| first_below(s).map(|row| owner[row]);
        let parent = (0..self.supernodes()).map(parent).collect();
        SupernodeTree { owner, parent }
    }
}

impl SupernodeTree {
    /// Cuts the tree: every largest subtree whose weight, summed over its supernodes, `is_small` accepts is one piece, and every
    /// supernode above them is one; in postorder.
    pub(super) fn pieces<W: Copy + AddAssign>(
        &self,
        weight: impl Fn(usize) -> W,
        is_small: impl Fn(W) -> bool,
    ) -> Vec<Range<usize>> {
        let count = self.parent.len();
        let mut subtree: Vec<W> = (0..count).map(weight).collect();
        let mut first: Vec<usize> = (0..count).collect();
        for s in 0..count {
            if let Some(parent) = self.parent[s] {
                let below = subtree[s];
                subtree[parent] += below;
                first[parent] = first[parent].min(first[s]);
            }
        }
        let is_small = |s: usize| is_small(subtree[s]);
        (0..count)
            .filter(|&s| !(is_small(s) && self.parent[s].is_some_and(is_small)))
            .map(|s| {
                if is_small(s) {
                    first[s]..s + 1
                } else {
                    s..s + 1
                }
            })
            .collect()
    }
}

/// Why a matrix was not ordered or factorised.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FactorError {
    /// The matrix is not square.
    #[error("an ordering and a Cholesky factor need a square matrix, got {rows} × {cols}")]
    NotSquare {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        cols: usize,
    },
    /// The ordering is not a permutation of the unknowns.
    #[error("the ordering of {length} entries is not a permutation of 0..{size}")]
    NotAPermutation {
        /// Length of the given ordering.
        length: usize,
        /// Number of unknowns.
        size: usize,
    },
    /// A pivot was negative, zero, not a number, or positive by rounding only.
    #[error("the matrix is not positive definite (pivot {pivot:e} at unknown {column})")]
    NotPositiveDefinite {
        /// The unknown, in the numbering of A, whose pivot failed.
        column: usize,
        /// The failed pivot, the square of the diagonal coefficient it would have given.
        pivot: f64,
    },
    /// Pointers and neighbours do not describe a graph of the given nodes.
    #[error("adjacency arrays do not describe a graph of {nodes} nodes")]
    NotAGraph {
        /// Number of nodes.
        nodes: usize,
    },
    /// Work space could not be allocated, or an index overflowed.
    #[error("not enough memory to order or factorise {size} unknowns")]
    OutOfMemory {
        /// Number of unknowns.
        size: usize,
    },
}

/// A rule of [`FactorStructure`] that stored arrays break.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("expected {rule}, which supernode {supernode} contradicts")]
pub struct PartsError {
    /// The rule.
    pub rule: &'static str,
    /// The first supernode that breaks it.
    pub supernode: usize,
}

impl FactorStructure {
    /// Checks every rule stated above, for so many coefficients.
    pub(super) fn check(&self, n_values: usize) -> Result<(), PartsError> {
        let broken = |supernode, rule| Err(PartsError { rule, supernode });
        if inverse(&self.permutation).is_none() {
            return broken(0, "an ordering that is a permutation");
        }
        let columns = &self.supernode_columns;
        let ends = columns.first() == Some(&0) && columns.last() == Some(&self.size());
        if !ends || !columns.windows(2).all(|pair| pair[0] < pair[1]) {
            return broken(0, "columns that rise from 0 to the number of unknowns");
        }
        if let Some(s) = self.first_misplaced(n_values) {
            return broken(s, "offsets that fit rows and columns");
        }
        let owner = self.supernode_of_column();
        let mut unsound = (0..self.supernodes()).filter(|&s| !self.rows_are_sound(s, &owner));
        match unsound.next() {
            Some(s) => broken(s, "rows that agree with the elimination tree"),
            None => Ok(()),
        }
    }

    /// The first supernode whose offsets do not leave (rows × columns) values to it; they start at 0 and end with their arrays.
    fn first_misplaced(&self, n_values: usize) -> Option<usize> {
        let supernodes = self.supernodes();
        let (rows, values) = (&self.row_offsets, &self.value_offsets);
        let ends = |offsets: &[usize], length| {
            offsets.len() == supernodes + 1 && offsets[0] == 0 && offsets[supernodes] == length
        };
        if !ends(rows, self.row_indices.len()) || !ends(values, n_values) {
            return Some(0);
        }
        (0..supernodes).find(|&s| {
            let width = self.columns(s).len();
            let height = rows[s + 1].checked_sub(rows[s]).filter(|h| *h >= width);
            let entries = values[s + 1].checked_sub(values[s]);
            let expected = height.and_then(|height| height.checked_mul(width));
            let inside = rows[s + 1] <= self.row_indices.len() && values[s + 1] <= n_values;
            expected.is_none() || entries != expected || !inside
        })
    }

    /// Own columns first, strictly increasing, below the size, and every row past the parent's
    /// first column a row of the parent.
    fn rows_are_sound(&self, s: usize, owner: &[usize]) -> bool {
        let panel = self.front(s);
        let (own, below) = panel.rows.split_at(panel.width);
        let increasing = panel.rows.windows(2).all(|pair| pair[0] < pair[1]);
        let inside = panel.rows.last().is_some_and(|&row| row < self.size());
        if !increasing || !inside || !own.iter().copied().eq(self.columns(s)) {
            return false;
        }
        let Some(&next) = below.first() else {
            return true;
        };
        let mut parent_rows = self.front(owner[next]).rows.iter();
        let mut below = below.iter();
        below.all(|row| parent_rows.any(|candidate| candidate == row))
    }
}
