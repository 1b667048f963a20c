//! Half-solved sparse columns, L⁻¹P[b₁ b₂ …], each kept on the supernodes that it reaches.

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
