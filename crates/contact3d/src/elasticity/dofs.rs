//! Numbering of the free degrees of freedom.

/// Numbering of the free degrees of freedom: node by node, x before y before z, held ones left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DofMap {
    /// Degree of freedom of each node and component, `[n_nodes, 3]`; `None` where held at zero.
    pub dof: Vec<[Option<usize>; 3]>,
    /// Number of free degrees of freedom.
    pub n_free: usize,
}

impl DofMap {
    /// Eliminates the held components of each node, `[n_nodes, 3]`.
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
        Self { dof, n_free }
    }

    /// Spreads a vector of free degrees of freedom over the nodes, zero where held.
    #[must_use]
    pub fn to_nodes(&self, free: &[f64]) -> Vec<[f64; 3]> {
        self.dof
            .iter()
            .map(|node| node.map(|dof| dof.map_or(0.0, |d| free[d])))
            .collect()
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
