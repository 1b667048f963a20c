//! The tangential displacement of the contact nodes as a function of the multipliers.

use std::sync::Arc;

use super::dense::subtract_product;
use crate::{contact::ContactFrame, elasticity::DofMap, linalg::CscMatrix, mesh::ContactSurface};

/// The tangential displacement of the contact nodes, affine in λ: u_t = `slip_free` − G (λ − λ₀)
/// with the anchor λ₀ of the dual problem.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactCompliance {
    /// G = C A⁻¹ Bᵀ with the rows u_t1, u_t2 of contact node after contact node, column-major,
    /// `[2 n_contact_nodes, 3 n_panes]`, in m/Pa; shared as S is.
    pub matrix: Arc<Vec<f64>>,
    /// (u_t1, u_t2) of A⁻¹l, or of the displacement at the anchor, at the contact nodes, signed,
    /// `[n_contact_nodes]`, in m.
    pub slip_free: Vec<[f64; 2]>,
}

impl ContactCompliance {
    /// One column of G, `[2 n_contact_nodes]`.
    #[must_use]
    pub fn column(&self, j: usize) -> &[f64] {
        let rows = 2 * self.slip_free.len();
        &self.matrix[j * rows..(j + 1) * rows]
    }

    /// slip_free − G λ at the contact nodes, `[n_contact_nodes]`, in m.
    pub(super) fn tangential_displacement(&self, multiplier: &[f64]) -> Vec<[f64; 2]> {
        let mut slip = self.slip_free.concat();
        subtract_product(&self.matrix, multiplier, &mut slip);
        pairs(&slip)
    }
}

/// Cᵀ of C u = (u_t1, u_t2) node by node; columns of held degrees of freedom are empty.
pub(super) fn tangential_selection(
    surface: &ContactSurface,
    frame: &ContactFrame,
    dofs: &DofMap,
) -> CscMatrix {
    let mut transposed = CscMatrix {
        rows: dofs.n_free,
        cols: 2 * surface.nodes.len(),
        indptr: vec![0],
        indices: Vec::new(),
        data: Vec::new(),
    };
    for (local, &node) in surface.nodes.iter().enumerate() {
        for axis in frame.axes_at(local) {
            for (dof, &direction) in dofs.dof[node].iter().zip(axis) {
                if let (Some(dof), true) = (*dof, direction != 0.0) {
                    transposed.indices.push(dof);
                    transposed.data.push(direction);
                }
            }
            transposed.indptr.push(transposed.indices.len());
        }
    }
    transposed
}

/// (u_t1, u_t2) at the contact nodes of a displacement in m, held nodes as they are held.
pub(super) fn free_slip(
    selection: &CscMatrix,
    unconstrained: &[f64],
    surface: &ContactSurface,
    frame: &ContactFrame,
    dofs: &DofMap,
) -> Vec<[f64; 2]> {
    let mut slip = vec![0.0; selection.cols];
    selection.mul_transposed(unconstrained, &mut slip);
    let mut slip = pairs(&slip);
    if dofs.prescribed.is_some() {
        for (local, (slip, &node)) in slip.iter_mut().zip(&surface.nodes).enumerate() {
            let held = frame.tangential(local, dofs.held_at(node));
            *slip = [slip[0] + held[0], slip[1] + held[1]];
        }
    }
    slip
}

pub(super) fn pairs(flat: &[f64]) -> Vec<[f64; 2]> {
    flat.chunks_exact(2).map(|p| [p[0], p[1]]).collect()
}
