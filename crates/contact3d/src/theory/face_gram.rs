//! What a norm of displacements makes of the contact face.

use faer::Mat;

use super::dense::{Factor, alone, symmetric};
use crate::{
    contact::ContactFrame,
    elasticity::DofMap,
    linalg::{CholeskyFactor, CscMatrix, Work},
    mesh::ContactSurface,
};

/// The Gram matrix E X⁻¹ Eᵀ of the displacements (u_ν, u_t1, u_t2) at the contact nodes for a norm ‖v‖² = vᵀXv of V^h:
/// for nodal forces f on the face fᵀ E X⁻¹ Eᵀ f = sup (f·v)²/‖v‖². For the energy norm, X = A, it is the compliance of the face.
pub(super) struct FaceGram {
    /// `[3 n_contact_nodes, 3 n_contact_nodes]`; rows of held components vanish.
    matrix: Vec<f64>,
    n_nodes: usize,
}

/// Multipliers in terms of nodal values: row i holds ∫_{Rⁱ} φ_j over contact nodes j.
#[derive(Debug, Clone)]
pub(super) struct PaneRows(pub(super) Vec<Vec<(usize, f64)>>);

impl PaneRows {
    /// The panes of the scene.
    pub(super) fn of_surface(surface: &ContactSurface) -> Self {
        let panes = surface.pane_area.iter().enumerate();
        let row = |(pane, area): (usize, &f64)| {
            let weights = surface.pane_weights(pane);
            weights
                .map(|(node, weight)| (node, weight * area))
                .collect()
        };
        Self(panes.map(row).collect())
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// ∫ 1 over each pane.
    pub(super) fn areas(&self) -> Vec<f64> {
        let rows = self.0.iter();
        rows.map(|row| row.iter().map(|(_, integral)| integral).sum())
            .collect()
    }
}

impl FaceGram {
    /// By half solves with the factor of X on the supernodes that the face reaches.
    pub(super) fn new(
        factor: &CholeskyFactor,
        surface: &ContactSurface,
        frame: &ContactFrame,
        dofs: &DofMap,
    ) -> Self {
        let selection = selection(surface, frame, dofs);
        Self {
            matrix: factor.forward_rows(&selection, &Work::default()).gram(),
            n_nodes: surface.nodes.len(),
        }
    }

    pub(super) fn n_nodes(&self) -> usize {
        self.n_nodes
    }

    /// The entry of components c, d (0 for ν, 1 and 2 for the tangents) at two nodes.
    pub(super) fn entry(&self, [a, c]: [usize; 2], [b, d]: [usize; 2]) -> f64 {
        self.matrix[(3 * b + d) * 3 * self.n_nodes + 3 * a + c]
    }

    /// G f for nodal forces in the order of the rows, `[3 n_contact_nodes]`.
    pub(super) fn apply(&self, forces: &[f64]) -> Vec<f64> {
        let columns = self.matrix.chunks_exact(forces.len().max(1));
        // Symmetric: each entry is the product of one column.
        columns
            .map(|column| crate::linalg::dot(column, forces))
            .collect()
    }

    /// W G_ab Wᵀ for components a and b of displacements.
    fn between(&self, rows: &PaneRows, a: usize, b: usize) -> Mat<f64> {
        let cross = self.cross(rows, a, b);
        Mat::from_fn(rows.len(), rows.len(), |i, j| {
            rows.0[j]
                .iter()
                .map(|&(node, integral)| integral * cross[(i, node)])
                .sum()
        })
    }

    /// W G_ab, `[m, n_contact_nodes]`.
    fn cross(&self, rows: &PaneRows, a: usize, b: usize) -> Mat<f64> {
        Mat::from_fn(rows.len(), self.n_nodes, |i, node| {
            let row = rows.0[i].iter();
            row.map(|&(other, integral)| integral * self.entry([other, a], [node, b]))
                .sum()
        })
    }

    /// Q = N X⁻¹ Nᵀ: μᵀQμ = sup (μ, v_ν)²/‖v‖² over V^h.
    pub(super) fn normal(&self, rows: &PaneRows) -> Mat<f64> {
        symmetric(self.between(rows, 0, 0))
    }

    /// The same over V₀^h, the displacements without tangential part on Γ_c, which is what the proofs of HKL Lemma 3.3 and
    /// Proposition 3.1 need. It is Q where X does not couple components and all are held on the same nodes, as in
    /// H¹(Ω)³; in the energy norm it is smaller. `None` where the tangential block is singular.
    pub(super) fn normal_glued(&self, rows: &PaneRows) -> Option<Mat<f64>> {
        let moving: Vec<[usize; 2]> = (0..self.n_nodes)
            .flat_map(|node| [[node, 1], [node, 2]])
            .filter(|&at| self.entry(at, at) > 0.0)
            .collect();
        let n = moving.len();
        let block = Mat::from_fn(n, n, |i, j| self.entry(moving[i], moving[j]));
        let parts = [1, 2].map(|b| self.cross(rows, 0, b));
        let cross = Mat::from_fn(n, rows.len(), |i, pane| {
            let [node, component] = moving[i];
            parts[component - 1][(pane, node)]
        });
        let solved = Factor::new(&block)?.solve(&cross);
        Some(symmetric(alone(|| {
            self.normal(rows) - cross.transpose() * &solved
        })))
    }

    /// The compliance of the tangential displacements by the multipliers of a scene with friction, column-major,
    /// `[2 n_contact_nodes, 3 m]`: u_t1 and u_t2 node by node, against m normal multipliers, then m pairs.
    pub(super) fn tangential_by_multipliers(&self, rows: &PaneRows) -> Mat<f64> {
        let m = rows.len();
        let parts: Vec<[Mat<f64>; 2]> = (0..3)
            .map(|a| [1, 2].map(|b| self.cross(rows, a, b)))
            .collect();
        Mat::from_fn(2 * self.n_nodes, 3 * m, |row, column| {
            let (pane, component) = match column.checked_sub(m) {
                None => (column, 0),
                Some(pair) => (pair / 2, 1 + pair % 2),
            };
            parts[component][row % 2][(pane, row / 2)]
        })
    }
}

/// E: rows u_ν, u_t1, u_t2 of contact node after contact node, `[3 n_contact_nodes, n_free]`.
fn selection(surface: &ContactSurface, frame: &ContactFrame, dofs: &DofMap) -> CscMatrix {
    let mut transposed = CscMatrix::empty(dofs.n_free);
    for (local, &node) in surface.nodes.iter().enumerate() {
        let [first, second] = *frame.axes_at(local);
        for axis in [frame.normal_at(local), first, second] {
            for (dof, direction) in dofs.dof[node].iter().zip(axis) {
                if let (Some(dof), true) = (*dof, direction != 0.0) {
                    transposed.indices.push(dof);
                    transposed.data.push(direction);
                }
            }
            transposed.indptr.push(transposed.indices.len());
            transposed.cols += 1;
        }
    }
    transposed.transpose()
}
