//! Which right-hand sides reach which supernodes, and the order in which fronts can be solved.

use std::ops::{AddAssign, Range};

use super::analysis::FactorStructure;

/// A sparse right-hand side: unknowns (new numbering, ascending) and their coefficients.
pub(super) type SparseColumn = Vec<(usize, f64)>;

/// The supernodal elimination tree.
#[derive(Clone, Debug)]
pub(super) struct SupernodeTree {
    /// The supernode of each column of the factor.
    pub(super) owner: Vec<usize>,
    /// The parent of each supernode: the owner of its first row below the diagonal block.
    pub(super) parent: Vec<Option<usize>>,
}

/// The reached supernodes with their right-hand sides, and who passes its update to whom.
pub(super) struct FrontPlan {
    /// Supernode and right-hand sides, ascending.
    pub(super) reached: Vec<(usize, Vec<usize>)>,
    /// The part of each one's parent.
    pub(super) parent: Vec<Option<usize>>,
    pub(super) children: Vec<Vec<usize>>,
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

impl FrontPlan {
    /// Passes each right-hand side up the tree from the unknowns it is nonzero on.
    pub(super) fn new(
        supernodes: usize,
        tree: &SupernodeTree,
        right_hand_sides: &[SparseColumn],
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
