//! The order of multipliers, and the coupling B = [N; T] between them and displacements (HKL (4.1)).

use std::{collections::BTreeMap, ops::Range};

use super::ContactFrame;
use crate::{
    elasticity::DofMap,
    linalg::{CscMatrix, UNIT_ROUNDING},
    mesh::ContactSurface,
};

/// The order of the components of a multiplier λ: the m normal ones first, then the tangential pairs of the panes with
/// friction, which come before those without. All that is indexed by multipliers (B, S, h, residuals, stiffness) follows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MultiplierLayout {
    n_panes: usize,
    n_pairs: usize,
}

impl MultiplierLayout {
    /// The layout for m panes, of which the first `n_pairs` have friction.
    #[must_use]
    pub fn new(n_panes: usize, n_pairs: usize) -> Self {
        Self { n_panes, n_pairs }
    }

    /// Number of panes m.
    #[must_use]
    pub fn n_panes(self) -> usize {
        self.n_panes
    }

    /// Number of tangential pairs: that of the panes with friction.
    #[must_use]
    pub fn n_pairs(self) -> usize {
        self.n_pairs
    }

    /// Whether there are tangential pairs.
    #[must_use]
    pub fn has_friction(self) -> bool {
        self.n_pairs > 0
    }

    /// Number of multipliers: 3m where all panes have friction, m where none has.
    #[must_use]
    pub fn n_multipliers(self) -> usize {
        self.n_panes + 2 * self.n_pairs
    }

    /// The normal component of a pane.
    #[must_use]
    pub fn normal(self, pane: usize) -> usize {
        pane
    }

    /// The tangential pair of a pane; `None` without friction.
    #[must_use]
    pub fn tangential(self, pane: usize) -> Option<[usize; 2]> {
        (pane < self.n_pairs).then(|| {
            let first = self.n_panes + 2 * pane;
            [first, first + 1]
        })
    }

    /// The pane that a component belongs to.
    #[must_use]
    pub fn pane_of(self, component: usize) -> usize {
        if component < self.n_panes {
            component
        } else {
            (component - self.n_panes) / 2
        }
    }

    /// The normal components.
    #[must_use]
    pub fn normals(self) -> Range<usize> {
        0..self.n_panes
    }

    /// The tangential components; none without friction.
    #[must_use]
    pub fn tangentials(self) -> Range<usize> {
        self.n_panes..self.n_multipliers()
    }

    /// The tangential pair of a pane in a vector of multipliers; zero without friction.
    #[must_use]
    pub fn pair(self, vector: &[f64], pane: usize) -> [f64; 2] {
        self.tangential(pane)
            .map_or([0.0; 2], |pair| pair.map(|j| vector[j]))
    }

    /// The normal components, `[n_panes]`, and the tangential pairs of a vector of multipliers, `[n_pairs]`. What follows them, the
    /// rigid motions of a body that floats, is left out.
    #[must_use]
    pub fn split<T>(self, vector: &[T]) -> (&[T], &[[T; 2]]) {
        let (normal, rest) = vector.split_at(self.n_panes);
        (normal, rest[..self.tangentials().len()].as_chunks().0)
    }

    /// As [`Self::split`], to write to.
    #[must_use]
    pub fn split_mut<T>(self, vector: &mut [T]) -> (&mut [T], &mut [[T; 2]]) {
        let n_tangential = self.tangentials().len();
        let (normal, rest) = vector.split_at_mut(self.n_panes);
        (normal, rest[..n_tangential].as_chunks_mut().0)
    }
}

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

/// The components of ν, t₁ or t₂ along the free axes of a half-held node, without roundings: an axis along a held component has
/// no row in B, and one of roundings would be as good as parallel to another.
fn free_of_rounding(direction: [f64; 3], dofs: &[Option<usize>; 3]) -> [f64; 3] {
    if dofs.iter().any(Option::is_none) {
        direction.map(|part| {
            if part.abs() > UNIT_ROUNDING {
                part
            } else {
                0.0
            }
        })
    } else {
        direction
    }
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
        let mut push_column = |pane: usize, axis: &dyn Fn(usize) -> [f64; 3]| {
            let is_nodal = surface.faces[surface.face_of_pane(pane)].is_nodal;
            let mut sums: BTreeMap<usize, f64> = BTreeMap::new();
            let mut add = |area: f64, (dof, direction): (usize, f64)| {
                *sums.entry(dof).or_insert(0.0) += area * direction;
            };
            for (local, weight) in surface.pane_weights(pane) {
                let area = weight * surface.pane_area[pane];
                let node = surface.nodes[local];
                if surface.touches_body(pane) {
                    let terms = dofs.terms(node, axis(local));
                    terms.for_each(|term| add(area, term));
                    continue;
                }
                let axis = if is_nodal {
                    free_of_rounding(axis(local), &dofs.dof[node])
                } else {
                    axis(local)
                };
                let terms = frame.terms(surface, dofs, local, axis);
                terms.for_each(|term| add(area, term));
            }
            for (local, node, area) in surface.products(pane) {
                let terms = dofs.terms(*node, axis(*local));
                terms.for_each(|term| add(-area, term));
            }
            transposed.push_column(sums);
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

    /// B u of the contact nodes and tools that are held, as they are held, `[n_multipliers]`, in m³; empty where clamps hold at zero.
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
            let whole = surface.pane_area[pane];
            let mut add = |area: f64, [normal, first, second]: [f64; 3]| {
                integrals[self.layout.normal(pane)] += area * normal;
                if let Some(pair) = self.layout.tangential(pane) {
                    for (j, along) in pair.into_iter().zip([first, second]) {
                        integrals[j] += area * along;
                    }
                }
            };
            if surface.touches_body(pane) {
                let held = |node| dofs.held_at(node);
                add(
                    whole,
                    frame.pane_relative(surface, pane, held, |_| [0.0; 3]),
                );
                continue;
            }
            for (local, weight) in surface.pane_weights(pane) {
                let held = frame.held(surface, dofs, local);
                add(weight * whole, frame.components(local, held));
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
