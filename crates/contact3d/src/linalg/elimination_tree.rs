//! Elimination tree of a permuted symmetric matrix and its postorder.

use super::sparse::CscMatrix;

const NONE: usize = usize::MAX;

/// The inverse of a permutation, or `None` when `permutation` is not one of 0..n.
pub(super) fn inverse(permutation: &[usize]) -> Option<Vec<usize>> {
    let mut result = vec![NONE; permutation.len()];
    for (new, &old) in permutation.iter().enumerate() {
        let place = result.get_mut(old)?;
        if *place != NONE {
            return None;
        }
        *place = new;
    }
    Some(result)
}

/// Reorders `permutation` (new → old) by a postorder of its elimination tree: the same fill and the
/// same operations, but the columns of every subtree become neighbours, which lets supernodes
/// merge. The largest child comes last.
pub(super) fn postordered(a: &CscMatrix, permutation: &[usize], inverse: &[usize]) -> Vec<usize> {
    let parent = elimination_tree(a, permutation, inverse);
    postorder(&parent)
        .into_iter()
        .map(|new| permutation[new])
        .collect()
}

/// Parent of each column of the factor of PAPᵀ (Liu's algorithm with path compression); roots have
/// `NONE`.
fn elimination_tree(a: &CscMatrix, permutation: &[usize], inverse: &[usize]) -> Vec<usize> {
    let n = permutation.len();
    let mut parent = vec![NONE; n];
    let mut ancestor = vec![NONE; n];
    for new in 0..n {
        for &old_row in a.column(permutation[new]).0 {
            let mut node = inverse[old_row];
            while node != NONE && node < new {
                let next = ancestor[node];
                ancestor[node] = new;
                if next == NONE {
                    parent[node] = new;
                }
                node = next;
            }
        }
    }
    parent
}

/// Postorder of a forest whose parents have larger numbers than their children.
fn postorder(parent: &[usize]) -> Vec<usize> {
    let n = parent.len();
    let mut size = vec![1_usize; n];
    for node in (0..n).filter(|&node| parent[node] != NONE) {
        size[parent[node]] += size[node];
    }
    // The place of a subtree's root is the end of the subtree's range; ranges are handed out from
    // the last root down.
    let mut children: Vec<usize> = (0..n).collect();
    children.sort_by_key(|&node| (size[node], node));
    let mut end = vec![0_usize; n];
    let mut free_end_of_roots = n;
    let mut by_parent = ChildLists::new(parent, &children);
    for node in (0..n).rev() {
        if parent[node] == NONE {
            end[node] = free_end_of_roots;
            free_end_of_roots -= size[node];
        }
        let mut free_end = end[node].saturating_sub(1);
        while let Some(child) = by_parent.pop(node) {
            end[child] = free_end;
            free_end -= size[child];
        }
    }
    let mut order = vec![0; n];
    for node in 0..n {
        order[end[node] - 1] = node;
    }
    order
}

/// Linked lists of children, popped in the reverse of the order they were given in.
struct ChildLists {
    head: Vec<usize>,
    next: Vec<usize>,
}

impl ChildLists {
    fn new(parent: &[usize], nodes: &[usize]) -> Self {
        let mut lists = Self {
            head: vec![NONE; parent.len()],
            next: vec![NONE; parent.len()],
        };
        for &node in nodes.iter().filter(|&&node| parent[node] != NONE) {
            lists.next[node] = lists.head[parent[node]];
            lists.head[parent[node]] = node;
        }
        lists
    }

    fn pop(&mut self, parent: usize) -> Option<usize> {
        let child = self.head[parent];
        if child == NONE {
            return None;
        }
        self.head[parent] = self.next[child];
        Some(child)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_refuses_what_is_not_a_permutation() {
        assert_eq!(inverse(&[2, 0, 1]), Some(vec![1, 2, 0]));
        assert_eq!(inverse(&[2, 0, 0]), None);
        assert_eq!(inverse(&[3, 0, 1]), None);
    }

    #[test]
    fn postorder_keeps_subtrees_together_and_puts_the_largest_child_last() {
        // roots 5 and 6; 5 has the children 3 (with child 0) and 4 (leaf); 3's other child is 1; 6
        // has 2
        let parent = [3, 3, 6, 5, 5, NONE, NONE];
        let order = postorder(&parent);
        assert_eq!(order, [4, 0, 1, 3, 5, 2, 6]);
    }
}
