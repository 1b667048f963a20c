//! The stiffness of single panes from the stiffness of single nodes, without S.

use std::collections::{BTreeMap, BTreeSet};

use super::PrimalSystem;
use crate::contact::Coupling;

/// An upper bound of the local stiffness (S⁻¹)_ii of every pane, within a small factor, in Pa/m³,
/// `[n_multipliers]`; 0 where a component moves nothing.
///
/// (S⁻¹)_ii is the least energy vᵀA v of a displacement with (B v)_i = 1 that moves no other pane,
/// so the displacement of a single node n that belongs to pane i alone bounds it: with the entries
/// b of (B)_i at that node v_n = b/|b|² and vᵀA v = bᵀA_nn b/|b|⁴. Panes of bricks, and nodes, have
/// such a node; where a pane has none, the nodes that it shares give a scale, though no bound. A
/// tangential pair takes the mean of its two.
#[must_use]
pub fn pane_stiffness(primal: &PrimalSystem, coupling: &Coupling) -> Vec<f64> {
    let node_of = nodes_of_freedom(primal);
    let columns = &coupling.transposed;
    let mut panes_at: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for column in 0..columns.cols {
        for k in columns.indptr[column]..columns.indptr[column + 1] {
            let node = node_of[columns.indices[k]];
            panes_at
                .entry(node)
                .or_default()
                .insert(coupling.layout.pane_of(column));
        }
    }
    let mut stiffness: Vec<f64> = (0..columns.cols)
        .map(|column| {
            let mut entries: BTreeMap<usize, Vec<(usize, f64)>> = BTreeMap::new();
            for k in columns.indptr[column]..columns.indptr[column + 1] {
                let dof = columns.indices[k];
                let entry = (dof, columns.data[k]);
                entries.entry(node_of[dof]).or_default().push(entry);
            }
            let least = |own: bool| {
                let nodes = entries.iter();
                nodes
                    .filter(|(node, _)| panes_at[*node].len() == 1 || !own)
                    .map(|(_, entries)| energy(primal, entries))
                    .fold(f64::INFINITY, f64::min)
            };
            [least(true), least(false)]
                .into_iter()
                .find(|least| least.is_finite())
                .unwrap_or(0.0)
        })
        .collect();
    for pair in coupling.layout.split_mut(&mut stiffness).1 {
        if pair[0] > 0.0 && pair[1] > 0.0 {
            *pair = [0.5 * (pair[0] + pair[1]); 2];
        }
    }
    stiffness
}

/// bᵀA_nn b / |b|⁴ for the entries b of a node.
fn energy(primal: &PrimalSystem, entries: &[(usize, f64)]) -> f64 {
    let square: f64 = entries.iter().map(|(_, b)| b * b).sum();
    let a = &primal.stiffness;
    let mut energy = 0.0;
    for (column, right) in entries {
        for k in a.indptr[*column]..a.indptr[column + 1] {
            if let Some((_, left)) = entries.iter().find(|(row, _)| *row == a.indices[k]) {
                energy += left * a.data[k] * right;
            }
        }
    }
    energy / square / square
}

/// The node of every free degree of freedom.
fn nodes_of_freedom(primal: &PrimalSystem) -> Vec<usize> {
    let mut nodes = vec![0; primal.dofs.n_free];
    for (node, dofs) in primal.dofs.dof.iter().enumerate() {
        for dof in dofs.iter().flatten() {
            nodes[*dof] = node;
        }
    }
    nodes
}
