//! The coupling B = [N; T] between multipliers and displacements (HKL (4.1)).

use std::ops::Range;

use super::{ContactFrame, MultiplierLayout, held_nodes::free_of_rounding};
use crate::{elasticity::DofMap, linalg::CscMatrix, mesh::ContactSurface};

/// The coupling B = [N; T] between multipliers and displacements; B = N without friction.
///
/// Rows of N hold ∫_{Rⁱ} v_ν, rows of T the pairs ∫_{Rⁱ} v_t1, ∫_{Rⁱ} v_t2 (HKL (4.1)), exact for
/// P1 displacements on panes, lumped for nodal multipliers; columns follow [`MultiplierLayout`].
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling {
    /// Bᵀ, `[n_free, n_multipliers]`, in m².
    pub transposed: CscMatrix,
    /// The order of its columns.
    pub layout: MultiplierLayout,
}

impl Coupling {
    /// Assembles N, and T for the first `n_pairs` panes, which have friction, over the free degrees of freedom.
    #[must_use]
    pub fn new(
        surface: &ContactSurface,
        frame: &ContactFrame,
        n_pairs: usize,
        dofs: &DofMap,
    ) -> Self {
        let layout = MultiplierLayout::new(surface.n_panes(), n_pairs);
        let mut transposed = CscMatrix::empty(dofs.n_free);
        transposed.cols = layout.n_multipliers();
        let mut push_column = |pane: usize, axis: &dyn Fn(usize) -> [f64; 3]| {
            let is_nodal = surface.faces[surface.face_of_pane(pane)].is_nodal;
            for (local, weight) in surface.pane_weights(pane) {
                let node = dofs.dof[surface.nodes[local]];
                let axis = if is_nodal {
                    free_of_rounding(axis(local), &node)
                } else {
                    axis(local)
                };
                for (dof, direction) in node.iter().zip(axis) {
                    if let (Some(dof), true) = (*dof, direction != 0.0) {
                        transposed.indices.push(dof);
                        let area = weight * surface.pane_area[pane];
                        transposed.data.push(area * direction);
                    }
                }
            }
            transposed.indptr.push(transposed.indices.len());
        };
        for pane in 0..layout.n_panes() {
            push_column(pane, &|node| frame.normal_at(node));
        }
        for pane in 0..layout.n_pairs() {
            push_column(pane, &|node| frame.axes_at(node)[0]);
            push_column(pane, &|node| frame.axes_at(node)[1]);
        }
        Self { transposed, layout }
    }

    /// Number of multipliers: 3m where all panes have friction, m where none has.
    #[must_use]
    pub fn n_multipliers(&self) -> usize {
        self.layout.n_multipliers()
    }

    /// Nᵀ, `[n_free, n_panes]`, and Tᵀ, `[n_free, 2 n_panes]`, which is empty without friction.
    #[must_use]
    pub fn parts(&self) -> [CscMatrix; 2] {
        let columns = |part: Range<usize>| {
            let (from, to) = (part.start, part.end);
            let (start, end) = (self.transposed.indptr[from], self.transposed.indptr[to]);
            CscMatrix {
                rows: self.transposed.rows,
                cols: to - from,
                indptr: self.transposed.indptr[from..=to]
                    .iter()
                    .map(|p| p - start)
                    .collect(),
                indices: self.transposed.indices[start..end].to_vec(),
                data: self.transposed.data[start..end].to_vec(),
            }
        };
        [
            columns(self.layout.normals()),
            columns(self.layout.tangentials()),
        ]
    }

    /// Puts B together again from Nᵀ and Tᵀ.
    #[must_use]
    pub fn from_parts(normal: &CscMatrix, tangential: &CscMatrix) -> Self {
        let entries = normal.data.len();
        let tangential_ptr = tangential.indptr.iter().skip(1).map(|p| p + entries);
        let transposed = CscMatrix {
            rows: normal.rows,
            cols: normal.cols + tangential.cols,
            indptr: normal
                .indptr
                .iter()
                .copied()
                .chain(tangential_ptr)
                .collect(),
            indices: [&normal.indices[..], &tangential.indices].concat(),
            data: [&normal.data[..], &tangential.data].concat(),
        };
        Self {
            transposed,
            layout: MultiplierLayout::new(normal.cols, tangential.cols / 2),
        }
    }

    /// B u of the held contact nodes as they are held, `[n_multipliers]`, in m³; empty where clamps hold at zero.
    #[must_use]
    pub fn held_integrals(
        &self,
        surface: &ContactSurface,
        frame: &ContactFrame,
        dofs: &DofMap,
    ) -> Vec<f64> {
        if dofs.prescribed.is_none() {
            return Vec::new();
        }
        let mut integrals = vec![0.0; self.n_multipliers()];
        for pane in 0..self.layout.n_panes() {
            for (local, weight) in surface.pane_weights(pane) {
                let held = dofs.held_at(surface.nodes[local]);
                let area = weight * surface.pane_area[pane];
                integrals[self.layout.normal(pane)] += area * frame.normal_part(local, held);
                if let Some(pair) = self.layout.tangential(pane) {
                    for (j, along) in pair.into_iter().zip(frame.tangential(local, held)) {
                        integrals[j] += area * along;
                    }
                }
            }
        }
        integrals
    }

    /// B u of the free degrees of freedom, `[n_multipliers]`.
    pub(crate) fn integrate(&self, displacement: &[f64]) -> Vec<f64> {
        let mut result = vec![0.0; self.n_multipliers()];
        self.transposed.mul_transposed(displacement, &mut result);
        result
    }

    /// Bᵀλ in N, `[n_free]`.
    #[must_use]
    pub fn nodal_forces(&self, multiplier: &[f64]) -> Vec<f64> {
        let mut result = vec![0.0; self.transposed.rows];
        self.transposed.mul(multiplier, &mut result);
        result
    }
}
