//! The free degrees of freedom, and the displacements of the others.

use std::sync::Arc;

/// Numbering of the free degrees of freedom: node by node, x before y before z, held ones left out; with the
/// displacements at which these are held.
#[derive(Debug, Clone, PartialEq)]
pub struct DofMap {
    /// Degree of freedom of each node and component, `[n_nodes, 3]`; `None` where held.
    pub dof: Vec<[Option<usize>; 3]>,
    /// Number of free degrees of freedom.
    pub n_free: usize,
    /// u_c in m, `[n_nodes, 3]`, zero where free; `None` where all clamps hold at zero.
    pub prescribed: Option<Arc<Vec<[f64; 3]>>>,
}

impl DofMap {
    /// Eliminates the held components of each node, `[n_nodes, 3]`, which are held at zero.
    #[must_use]
    pub fn new(held: &[[bool; 3]]) -> Self {
        let mut n_free = 0;
        let dof = held
            .iter()
            .map(|node| {
                node.map(|is_held| {
                    (!is_held).then(|| {
                        n_free += 1;
                        n_free - 1
                    })
                })
            })
            .collect();
        Self {
            dof,
            n_free,
            prescribed: None,
        }
    }

    /// The displacement of a node in m: free components from their degrees of freedom, the others as they are held.
    #[must_use]
    pub fn at_node(&self, node: usize, free: &[f64]) -> [f64; 3] {
        let held = self.held_at(node);
        let dof = &self.dof[node];
        std::array::from_fn(|c| dof[c].map_or(held[c], |d| free[d]))
    }

    /// The displacement u_c in m at which a node is held; zero for its free components.
    #[must_use]
    pub fn held_at(&self, node: usize) -> [f64; 3] {
        let prescribed = self.prescribed.as_ref();
        prescribed.map_or([0.0; 3], |held| held[node])
    }

    /// The change of a node's displacement in m with changes of the free degrees of freedom: zero where held.
    #[must_use]
    pub fn change_at_node(&self, node: usize, free: &[f64]) -> [f64; 3] {
        self.dof[node].map(|dof| dof.map_or(0.0, |d| free[d]))
    }

    /// The displacement of all nodes in m, `[n_nodes]`, from the free degrees of freedom.
    #[must_use]
    pub fn to_nodes(&self, free: &[f64]) -> Vec<[f64; 3]> {
        let nodes = 0..self.dof.len();
        nodes.map(|node| self.at_node(node, free)).collect()
    }

    /// Gathers the free degrees of freedom of a nodal field.
    #[must_use]
    pub fn to_free(&self, nodal: &[[f64; 3]]) -> Vec<f64> {
        let mut free = vec![0.0; self.n_free];
        for (dofs, values) in self.dof.iter().zip(nodal) {
            for (dof, value) in dofs.iter().zip(values) {
                if let Some(d) = *dof {
                    free[d] = *value;
                }
            }
        }
        free
    }
}
