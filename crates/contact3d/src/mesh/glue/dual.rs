//! What the nodes of a glued face follow: dual functions on what its triangles have in common with the other face.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::{
    mesh::{
        Mesh,
        opposite::{Boxes, Face, Overlap},
    },
    reference::TRIANGLE_EDGES,
};

/// α: what the function of a corner takes of those in the middle of its edges.
pub(super) const CORNER_SHARE: f64 = 0.2;

/// The share of a triangle that the other face covers below which its nodes do not follow for its sake: what a sliver would tell of them is
/// extrapolated over the whole triangle.
pub(super) const LEAST_COVER: f64 = 0.01;

/// How many rings of triangles away a dual function may be taken by another one: the corner of a face has two, whose nodes two other faces take.
const NEAR: usize = 2;

/// Shares below this are roundings of none, where meshes match.
pub(super) const ROUNDED_SHARE: f64 = 1e-13;

/// What triangles of a face have in common with another one, without slivers.
pub(super) fn covered(side: &Face<'_>, other: &Face<'_>) -> Vec<Overlap> {
    let boxes = Boxes::of(other);
    let overlaps = side.facets.par_iter();
    let overlaps = overlaps.map(|&facet| Overlap::of(side, facet, other, &boxes));
    let is_covered = |overlap: &Overlap| {
        let (whole, _) = side.mesh.side_integrals(overlap.triangle.facet);
        overlap.triangle.area > LEAST_COVER * whole
    };
    overlaps.filter(is_covered).collect()
}

/// What ũ of a node follows: ∫ φ̃_j, and ∫ ψ_j φ_k over it by joints and nodes k of their other faces; nodes of the own one have any joint.
pub(super) type Row = (f64, BTreeMap<(usize, usize), f64>);

/// Gives ψ_t of nodes without a row to those beside them that have one, for triangles with the corners of edges at their `ends`. Returns the
/// nodes whose ψ_t no node within [`NEAR`] rings of triangles takes.
pub(super) fn pass_on(
    mesh: &Mesh,
    facets: &BTreeSet<usize>,
    ends: &BTreeMap<usize, [usize; 2]>,
    rowless: &BTreeSet<usize>,
    rows: &mut BTreeMap<usize, Row>,
) -> BTreeSet<usize> {
    let mut lost = BTreeSet::new();
    for t in rowless {
        let mut ring = BTreeSet::from([*t]);
        let mut n_rings = 0;
        let beside: Vec<usize> = loop {
            let found = ring.difference(rowless);
            let found: Vec<usize> = found.copied().filter(|j| rows.contains_key(j)).collect();
            let n_before = ring.len();
            let beside =
                (facets.iter()).filter(|&&f| mesh.facet_nodes(f).any(|node| ring.contains(&node)));
            let wider: Vec<usize> = beside.flat_map(|&facet| mesh.facet_nodes(facet)).collect();
            ring.extend(wider);
            if !found.is_empty() || ring.len() == n_before {
                break found;
            }
            n_rings += 1;
        };
        if beside.is_empty() || n_rings > NEAR {
            lost.insert(*t);
        }
        let (integral, mut jump) = rows[t].clone();
        let entry = jump.keys().next().map_or(0, |(entry, _)| *entry);
        let own = match ends.get(t) {
            Some(ends) if ends.iter().any(|end| !rowless.contains(end)) => continue,
            Some([a, b]) => {
                let rest = 1.0 - 2.0 * CORNER_SHARE;
                vec![
                    (*t, -1.0 / rest),
                    (*a, CORNER_SHARE / rest),
                    (*b, CORNER_SHARE / rest),
                ]
            }
            None => vec![(*t, -1.0)],
        };
        for (node, part) in own {
            *jump.entry((entry, node)).or_insert(0.0) += part;
        }
        // By their integrals, so that slivers take little.
        let part = integral / beside.iter().map(|j| rows[j].0).sum::<f64>();
        for (_, (_, row)) in rows.iter_mut().filter(|(j, _)| beside.contains(j)) {
            for (node, share) in &jump {
                *row.entry(*node).or_insert(0.0) += part * share;
            }
        }
    }
    lost
}

/// The rows of the nodes of a face by what its triangles have in common with the other faces of some joints.
pub(super) fn dual_rows(mesh: &Mesh, overlaps: &[(usize, &Overlap)]) -> BTreeMap<usize, Row> {
    let mut by_facet: BTreeMap<usize, Vec<(usize, &Overlap)>> = BTreeMap::new();
    for (entry, overlap) in overlaps {
        let facet = overlap.triangle.facet;
        by_facet.entry(facet).or_default().push((*entry, overlap));
    }
    let mut sums: BTreeMap<usize, Row> = BTreeMap::new();
    for (facet, overlaps) in by_facet {
        let nodes: Vec<usize> = mesh.facet_nodes(facet).collect();
        let others = overlaps.iter().flat_map(|(entry, overlap)| {
            let others = overlap.products.keys();
            others.map(|(_, other)| (*entry, *other))
        });
        let others: Vec<(usize, usize)> = others.collect::<BTreeSet<_>>().into_iter().collect();
        let product = |node: usize, (of, other): (usize, usize)| {
            let own = overlaps.iter().filter(|(entry, _)| *entry == of);
            own.filter_map(|(_, overlap)| overlap.products.get(&(node, other)))
                .sum()
        };
        let with_integrals = with_integrals(nodes.len());
        let masses = DMatrix::from_fn(nodes.len(), nodes.len(), |i, j| {
            overlaps.iter().map(|(_, it)| it.masses[i][j]).sum()
        });
        let masses = &with_integrals * masses * with_integrals.transpose();
        let products = DMatrix::from_fn(nodes.len(), others.len(), |j, k| {
            product(nodes[j], others[k])
        });
        let integrals: Vec<f64> = masses.row_iter().map(|row| row.sum()).collect();
        let Some(factor) = masses.cholesky() else {
            continue;
        };
        let shares = factor.solve(&(with_integrals * products));
        for (j, node) in nodes.iter().enumerate() {
            let (whole, row) = sums.entry(*node).or_default();
            *whole += integrals[j];
            for (k, other) in others.iter().enumerate() {
                *row.entry(*other).or_insert(0.0) += integrals[j] * shares[(j, k)];
            }
        }
    }
    for (whole, row) in sums.values_mut() {
        row.values_mut().for_each(|share| *share /= *whole);
    }
    sums
}

/// φ̃ of a triangle with three or six nodes by its φ.
fn with_integrals(n: usize) -> DMatrix<f64> {
    let mut rows = DMatrix::identity(n, n);
    for (middle, ends) in (3..n).zip(TRIANGLE_EDGES) {
        rows[(middle, middle)] = 1.0 - 2.0 * CORNER_SHARE;
        ends.into_iter()
            .for_each(|end| rows[(end, middle)] = CORNER_SHARE);
    }
    rows
}

/// Shares without roundings of none, whose sum is 1.
pub(crate) fn whole<K: Ord>(mut shares: BTreeMap<K, f64>) -> Vec<(K, f64)> {
    shares.retain(|_, share| share.abs() > ROUNDED_SHARE);
    let mut shares: Vec<(K, f64)> = shares.into_iter().collect();
    let sum: f64 = shares.iter().map(|(_, share)| share).sum();
    let largest = shares.iter_mut().max_by(|a, b| a.1.total_cmp(&b.1));
    largest
        .into_iter()
        .for_each(|(_, share)| *share += 1.0 - sum);
    shares
}
