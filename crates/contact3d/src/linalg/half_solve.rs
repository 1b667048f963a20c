//! Half-solved sparse columns, L⁻¹P[b₁ b₂ …], each kept on the supernodes that it reaches; with those of a coupling, W = L⁻¹PBᵀ, the dual
//! operator S = BA⁻¹Bᵀ = WᵀW.

use std::ops::Range;

use faer::{
    Accum, MatMut, MatRef, Par,
    linalg::triangular_solve::solve_lower_triangular_in_place,
    reborrow::{Reborrow, ReborrowMut},
};
use rayon::prelude::*;

use super::{
    cholesky::CholeskyFactor,
    dense::multiply,
    precision::Scalar,
    sparse::CscMatrix,
    structure::{FactorStructure, Front, SupernodeTree, positions},
    tasks::Work,
};

/// Columns that are solved, multiplied or sent back together; multiples of 48 fill the tiles of the AVX-512 kernels.
pub(super) const BLOCK_COLUMNS: usize = 144;

/// The reached supernodes with their right-hand sides, and who passes its update to whom.
pub(super) struct FrontPlan {
    /// Supernode and right-hand sides, ascending.
    pub(super) reached: Vec<(usize, Vec<usize>)>,
    /// The part of each one's parent.
    pub(super) parent: Vec<Option<usize>>,
    pub(super) children: Vec<Vec<usize>>,
}

impl FrontPlan {
    /// Passes each right-hand side, given by unknowns (new numbering, ascending) and their coefficients, up the tree from the unknowns it is
    /// nonzero on.
    pub(super) fn new(
        supernodes: usize,
        tree: &SupernodeTree,
        right_hand_sides: &[Vec<(usize, f64)>],
        included: impl Fn(usize) -> bool,
    ) -> Self {
        let mut columns: Vec<Vec<usize>> = vec![Vec::new(); supernodes];
        for (column, entries) in right_hand_sides.iter().enumerate() {
            for &(unknown, _) in entries {
                let mut next = Some(tree.owner[unknown]);
                while let Some(s) =
                    next.filter(|&s| included(s) && columns[s].last() != Some(&column))
                {
                    columns[s].push(column);
                    next = tree.parent[s];
                }
            }
        }
        let reached = columns.into_iter().enumerate();
        let reached = reached.filter(|(_, columns)| !columns.is_empty());
        let reached: Vec<(usize, Vec<usize>)> = reached.collect();
        let part_of = |s: usize| reached.binary_search_by_key(&s, |part| part.0).ok();
        let parents = reached
            .iter()
            .map(|(s, _)| tree.parent[*s].and_then(part_of));
        let parent: Vec<Option<usize>> = parents.collect();
        let mut children = vec![Vec::new(); reached.len()];
        for (k, parent) in parent.iter().enumerate() {
            if let Some(parent) = *parent {
                children[parent].push(k);
            }
        }
        Self {
            reached,
            parent,
            children,
        }
    }

    /// The parts by their height in the forest, leaves first.
    pub(super) fn levels(&self) -> Vec<Vec<usize>> {
        let mut height = vec![0; self.reached.len()];
        let mut levels: Vec<Vec<usize>> = Vec::new();
        for k in 0..self.reached.len() {
            if height[k] == levels.len() {
                levels.push(Vec::new());
            }
            levels[height[k]].push(k);
            if let Some(parent) = self.parent[k] {
                height[parent] = height[parent].max(height[k] + 1);
            }
        }
        levels
    }
}

/// Some columns of L⁻¹ on one supernode.
#[derive(Clone, Debug)]
pub(super) struct SupernodeColumns<T> {
    pub(super) supernode: usize,
    /// The right-hand sides that reach it, ascending.
    pub(super) columns: Vec<usize>,
    /// Their solutions, column-major, shape (columns of the supernode, `columns`).
    pub(super) values: Vec<T>,
    /// What a solved subtree adds to the rows below its root, column-major, shape (rows below, columns); empty elsewhere.
    pub(super) update: Vec<T>,
}

impl<T: Scalar> SupernodeColumns<T> {
    /// Number of columns of the supernode.
    pub(super) fn width(&self) -> usize {
        self.values.len() / self.columns.len()
    }

    /// The right-hand sides in `range` and their solutions.
    pub(super) fn columns_in(&self, range: &std::ops::Range<usize>) -> (&[usize], MatRef<'_, T>) {
        let width = self.width();
        let first = self.columns.partition_point(|&c| c < range.start);
        let last = self.columns.partition_point(|&c| c < range.end);
        let values = &self.values[first * width..last * width];
        (
            &self.columns[first..last],
            MatRef::from_column_major_slice(values, width, last - first),
        )
    }
}

impl<T: Scalar> CholeskyFactor<T> {
    /// Solves with L on the supernodes that `included` accepts, which must contain the subtrees below their members: one part
    /// for each of them that a right-hand side reaches, ascending.
    ///
    /// A multifrontal forward pass: every supernode adds the updates of its children, solves with
    /// its diagonal block and passes its own update on. Fronts of one level of the tree, and fixed
    /// chunks of columns, run in parallel, each sum in a fixed order, so the bits do not depend on
    /// the thread count.
    pub(super) fn half_solve(
        &self,
        tree: &SupernodeTree,
        right_hand_sides: &[Vec<(usize, f64)>],
        included: impl Fn(usize) -> bool,
        work: &Work,
    ) -> Vec<SupernodeColumns<T>> {
        let count = self.structure.supernodes();
        let plan = FrontPlan::new(count, tree, right_hand_sides, included);
        let mut fronts: Vec<Vec<T>> = vec![Vec::new(); plan.reached.len()];
        let mut own: Vec<Vec<T>> = vec![Vec::new(); plan.reached.len()];
        for level in plan.levels() {
            let solved: Vec<_> = level
                .par_iter()
                .map(|&k| self.solve_front(&plan, k, &fronts, right_hand_sides))
                .collect();
            for (&k, (front, values)) in level.iter().zip(solved) {
                plan.children[k]
                    .iter()
                    .for_each(|&child| fronts[child] = Vec::new());
                (fronts[k], own[k]) = (front, values);
                let (s, columns) = &plan.reached[k];
                let front = self.structure.front(*s);
                work.add(front.solve_operations(columns.len()));
            }
        }
        // Those of all fronts but the roots were given to their parents.
        let parts = plan.reached.into_iter().zip(fronts).zip(own);
        let parts = parts.map(|(((supernode, columns), front), values)| {
            let Front { width, rows, .. } = self.structure.front(supernode);
            let below = front.chunks_exact(rows.len()).flat_map(|c| &c[width..]);
            SupernodeColumns {
                supernode,
                columns,
                values,
                update: below.copied().collect(),
            }
        });
        parts.collect()
    }

    /// The front of part k (rows of the supernode × right-hand sides, column-major) after
    /// elimination, and its leading rows.
    fn solve_front(
        &self,
        plan: &FrontPlan,
        k: usize,
        fronts: &[Vec<T>],
        right_hand_sides: &[Vec<(usize, f64)>],
    ) -> (Vec<T>, Vec<T>) {
        let (s, columns) = &plan.reached[k];
        let (panel, values) = self.panel(*s);
        let height = panel.rows.len();
        let matrix = MatRef::from_column_major_slice(values, height, panel.width);
        let (diagonal, below) = matrix.split_at_row(panel.width);
        let update_of = |&child: &usize| {
            let (s, child_columns) = &plan.reached[child];
            let below = self.structure.front(*s);
            ChildUpdate {
                rows: positions(below.below(), panel.rows),
                columns: positions(child_columns, columns),
                height: below.rows.len(),
                front: &fronts[child],
            }
        };
        let children: Vec<ChildUpdate<'_, T>> = plan.children[k].iter().map(update_of).collect();
        let mut front = vec![T::default(); height * columns.len()];
        front
            .par_chunks_mut(height * BLOCK_COLUMNS)
            .enumerate()
            .for_each(|(chunk, front)| {
                let start = chunk * BLOCK_COLUMNS;
                let count = front.len() / height;
                let own = panel.first..panel.first + panel.width;
                for (target, &column) in front.chunks_exact_mut(height).zip(&columns[start..]) {
                    let entries = &right_hand_sides[column];
                    let first = entries.partition_point(|entry| entry.0 < own.start);
                    for &(unknown, value) in entries[first..].iter().take_while(|e| e.0 < own.end) {
                        target[unknown - own.start] = T::rounded(value);
                    }
                }
                for child in &children {
                    child.add_to(front, height, start..start + count);
                }
                let front = MatMut::from_column_major_slice_mut(front, height, count);
                let (mut own, update) = front.split_at_row_mut(panel.width);
                solve_lower_triangular_in_place(diagonal, own.rb_mut(), Par::Seq);
                multiply(update, Accum::Add, -1.0, below, own.rb());
            });
        let own = front
            .chunks_exact(height)
            .flat_map(|column| &column[..panel.width])
            .copied()
            .collect();
        (front, own)
    }
}

/// The update of a child with its places in the front of the parent.
struct ChildUpdate<'a, T> {
    rows: Vec<usize>,
    columns: Vec<usize>,
    /// Rows of the child's front, the last of which are the update.
    height: usize,
    front: &'a [T],
}

impl<T: Scalar> ChildUpdate<'_, T> {
    /// Adds it to the columns `range` of a parent's front of the given height.
    fn add_to(&self, front: &mut [T], height: usize, range: std::ops::Range<usize>) {
        let first = self.columns.partition_point(|&c| c < range.start);
        let own = self.height - self.rows.len();
        for (&column, source) in self.columns[first..]
            .iter()
            .zip(self.front[first * self.height..].chunks_exact(self.height))
            .take_while(|pair| *pair.0 < range.end)
        {
            let target = &mut front[(column - range.start) * height..][..height];
            for (&row, value) in self.rows.iter().zip(&source[own..]) {
                target[row] += *value;
            }
        }
    }
}

impl FactorStructure {
    /// The supernodes, ascending, that a right-hand side nonzero in `rows` (numbering of A) makes nonzero in L⁻¹Pb: those on the
    /// paths of the elimination tree from there to the roots.
    ///
    /// # Panics
    /// When a row is not an unknown of the factor.
    pub(crate) fn reach(&self, rows: impl Iterator<Item = usize>) -> Vec<usize> {
        let new_of_old = self.new_of_old();
        let SupernodeTree { owner, parent } = self.supernode_tree();
        let mut reached = vec![false; self.supernodes()];
        for row in rows {
            let mut next = Some(owner[new_of_old[row]]);
            while let Some(s) = next.filter(|&s| !reached[s]) {
                reached[s] = true;
                next = parent[s];
            }
        }
        (0..self.supernodes()).filter(|&s| reached[s]).collect()
    }
}

/// W = L⁻¹PBᵀ for a sparse B, each column kept on the supernodes its row of B reaches only.
///
/// Every sum has a fixed order, so all products have the same bits at any thread count.
#[derive(Clone, Debug)]
pub(crate) struct ForwardRows<'a, T> {
    pub(super) factor: &'a CholeskyFactor<T>,
    pub(super) tree: SupernodeTree,
    /// The row of B of each column of W: rows that lie close in the elimination tree are
    /// neighbours.
    pub(super) order: Vec<usize>,
    pub(super) half_solved: Vec<SupernodeColumns<T>>,
    pub(super) work: &'a Work,
}

impl FactorStructure {
    /// Of W = L⁻¹PBᵀ for a B of shape (rows, unknowns): entries on the supernodes that its columns reach, multiplications and additions of
    /// the solves, and those of one triangle of WᵀW.
    ///
    /// # Panics
    /// When B does not have one column per unknown.
    pub(crate) fn count_forward_rows(&self, b: &CscMatrix) -> [f64; 3] {
        let (_, right_hand_sides) = self.sorted_rows(b);
        let tree = self.supernode_tree();
        let plan = FrontPlan::new(self.supernodes(), &tree, &right_hand_sides, |_| true);
        let [mut entries, mut of_solves, mut of_products] = [0.0; 3];
        for (s, columns) in &plan.reached {
            let front = self.front(*s);
            of_solves += front.solve_operations(columns.len());
            let (width, columns) = (front.width as f64, columns.len() as f64);
            entries += width * columns;
            of_products += width * columns * columns;
        }
        [entries, of_solves, of_products]
    }

    /// The rows of B in the new numbering, those that lie close in the elimination tree neighbours, and which each one is.
    fn sorted_rows(&self, b: &CscMatrix) -> (Vec<usize>, Vec<Vec<(usize, f64)>>) {
        assert_eq!(b.cols, self.size(), "columns of the coupling");
        let by_rows = b.transpose();
        let new_of_old = self.new_of_old();
        let mut rows: Vec<(usize, Vec<(usize, f64)>)> = (0..b.rows)
            .map(|row| {
                let entries = by_rows.entries(row);
                let new = entries.map(|(old, coefficient)| (new_of_old[old], coefficient));
                let mut entries: Vec<(usize, f64)> = new.collect();
                entries.sort_unstable_by_key(|entry| entry.0);
                (row, entries)
            })
            .collect();
        rows.sort_by_key(|(row, entries)| {
            (entries.first().map_or(usize::MAX, |entry| entry.0), *row)
        });
        rows.into_iter().unzip()
    }
}

impl<T: Scalar> CholeskyFactor<T> {
    /// Solves W = L⁻¹PBᵀ for all rows of B (shape: rows, unknowns); `work` is told of what [`FactorStructure::count_forward_rows`]
    /// counts, of the solves now and of the products in [`ForwardRows::gram`].
    ///
    /// # Panics
    /// When B does not have one column per unknown.
    pub(crate) fn forward_rows<'a>(&'a self, b: &CscMatrix, work: &'a Work) -> ForwardRows<'a, T> {
        let (order, right_hand_sides) = self.structure.sorted_rows(b);
        let tree = self.structure.supernode_tree();
        let half_solved = self.half_solve(&tree, &right_hand_sides, |_| true, work);
        ForwardRows {
            factor: self,
            tree,
            order,
            half_solved,
            work,
        }
    }
}

impl<T: Scalar> ForwardRows<'_, T> {
    /// The dual operator S = BA⁻¹Bᵀ = WᵀW, column-major, shape (rows of B, rows of B), exactly
    /// symmetric.
    pub(crate) fn gram(&self) -> Vec<f64> {
        let rows = self.order.len();
        let count = rows.div_ceil(BLOCK_COLUMNS);
        let range = |i: usize| i * BLOCK_COLUMNS..((i + 1) * BLOCK_COLUMNS).min(rows);
        let pairs: Vec<(Range<usize>, Range<usize>)> = (0..count)
            .flat_map(|j| (j..count).map(move |i| (range(i), range(j))))
            .collect();
        let tiles: Vec<Vec<T>> = pairs
            .par_iter()
            .map(|(left, right)| self.tile(left, right))
            .collect();
        let mut gram = vec![0.0; rows * rows];
        for ((left, right), tile) in pairs.into_iter().zip(&tiles) {
            for (b, line) in right.zip(tile.chunks_exact(left.len())) {
                let column = self.order[b];
                for (a, &value) in left.clone().zip(line).filter(|pair| pair.0 >= b) {
                    let row = self.order[a];
                    let value = value.to_double();
                    gram[column * rows + row] = value;
                    gram[row * rows + column] = value;
                }
            }
        }
        gram
    }

    /// Multiplications and additions of the solves.
    pub(super) fn solve_operations(&self) -> f64 {
        let structure = &self.factor.structure;
        let operations = |part: &SupernodeColumns<T>| {
            let front = structure.front(part.supernode);
            front.solve_operations(part.columns.len())
        };
        self.half_solved.iter().map(operations).sum()
    }

    /// The products of two ranges of columns of W, column-major, supernode by supernode.
    fn tile(&self, left: &Range<usize>, right: &Range<usize>) -> Vec<T> {
        let mut tile = vec![T::default(); left.len() * right.len()];
        let mut product = Vec::new();
        for part in &self.half_solved {
            let (rows, w_left) = part.columns_in(left);
            let (columns, w_right) = part.columns_in(right);
            if rows.is_empty() || columns.is_empty() {
                continue;
            }
            product.resize(rows.len() * columns.len(), T::default());
            let target =
                MatMut::from_column_major_slice_mut(&mut product, rows.len(), columns.len());
            multiply(target, Accum::Replace, 1.0, w_left.transpose(), w_right);
            let sides = if left == right { 1.0 } else { 2.0 };
            self.work
                .add(sides * (rows.len() * columns.len() * w_left.nrows()) as f64);
            for (column, line) in columns.iter().zip(product.chunks_exact(rows.len())) {
                let target = &mut tile[(column - right.start) * left.len()..][..left.len()];
                for (row, value) in rows.iter().zip(line) {
                    target[row - left.start] += *value;
                }
            }
        }
        tile
    }
}
