//! Where the coefficients of a factor stand.

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

    /// Parent of a supernode in the elimination tree: the owner of its first row below the diagonal block.
    pub(super) fn parent(&self, s: usize, owner: &[usize]) -> Option<usize> {
        self.front(s).below().first().map(|&row| owner[row])
    }

    /// New number of each unknown of A.
    pub(super) fn new_of_old(&self) -> Vec<usize> {
        let mut result = vec![0; self.size()];
        for (new, &old) in self.permutation.iter().enumerate() {
            result[old] = new;
        }
        result
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
