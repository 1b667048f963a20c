//! The rows of a glued face: dual functions on what its triangles have in common with the other faces.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::Joint;
use crate::{
    mesh::{
        Mesh,
        opposite::{Boxes, Face, Overlap},
    },
    reference::TRIANGLE_EDGES,
};

/// α: what the function of a corner takes of those in the middle of its edges.
const CORNER_SHARE: f64 = 0.2;

/// The share of a triangle that other faces cover below which ψ are constant there: what a sliver tells of its nodes is extrapolated.
const LEAST_COVER: f64 = 0.01;

/// The share of a triangle whose cover is rounding.
const NO_COVER: f64 = 1e-9;

/// Shares below this are roundings of none, where meshes match.
pub(super) const ROUNDED_SHARE: f64 = 1e-13;

/// ∫ ψ (u_m − u_s) in m² by nodes and joints; the sum over each joint is 0.
pub(super) type Row = BTreeMap<(usize, usize), f64>;

/// What triangles of a face have in common with another one.
pub(super) fn covered(side: &Face<'_>, other: &Face<'_>) -> Vec<Overlap> {
    let boxes = Boxes::of(other);
    let overlaps = side.facets.par_iter();
    let overlaps = overlaps.map(|&facet| Overlap::of(side, facet, other, &boxes));
    let is_covered = |overlap: &Overlap| {
        let (whole, _) = side.mesh.side_integrals(overlap.triangle.facet);
        overlap.triangle.area > NO_COVER * whole
    };
    overlaps.filter(is_covered).collect()
}

/// The rows of a face that follows the other ones of some joints by nodes, with ∫ ψ in m².
pub(super) fn dual_rows(mesh: &Mesh, joints: &[Joint<'_>]) -> BTreeMap<usize, (f64, Row)> {
    let mut by_facet: BTreeMap<usize, Vec<(usize, &Overlap)>> = BTreeMap::new();
    for joint in joints {
        for overlap in &joint.overlaps[joint.follows] {
            let facet = overlap.triangle.facet;
            by_facet
                .entry(facet)
                .or_default()
                .push((joint.entry, overlap));
        }
    }
    let mut rows: BTreeMap<usize, (f64, Row)> = BTreeMap::new();
    for (facet, overlaps) in by_facet {
        let nodes: Vec<usize> = mesh.facet_nodes(facet).collect();
        let n = nodes.len();
        let masses_of = |overlap: &Overlap| DMatrix::from_fn(n, n, |i, j| overlap.masses[i][j]);
        let masses = overlaps.iter().map(|(_, it)| masses_of(it)).sum();
        let area: f64 = overlaps.iter().map(|(_, it)| it.triangle.area).sum();
        let is_sliver = area <= LEAST_COVER * mesh.side_integrals(facet).0;
        let functions = dual(&masses).filter(|_| !is_sliver);
        let functions = functions.unwrap_or_else(|| constant(&masses));
        for (entry, overlap) in overlaps {
            let others: BTreeSet<usize> = overlap.products.keys().map(|(_, k)| *k).collect();
            let others: Vec<usize> = others.into_iter().collect();
            let product = |j: usize, k: usize| overlap.products.get(&(nodes[j], others[k]));
            let products = DMatrix::from_fn(n, others.len(), |j, k| {
                product(j, k).copied().unwrap_or(0.0)
            });
            let [products, own] = [products, -masses_of(overlap)].map(|it| &functions * it);
            for (j, node) in nodes.iter().enumerate() {
                let (integral, row) = rows.entry(*node).or_default();
                *integral += products.row(j).sum();
                let others = others.iter().enumerate();
                let others = others.map(|(k, other)| (*other, products[(j, k)]));
                let own = nodes
                    .iter()
                    .enumerate()
                    .map(|(i, node)| (*node, own[(j, i)]));
                for (k, part) in others.chain(own) {
                    *row.entry((k, entry)).or_insert(0.0) += part;
                }
            }
        }
    }
    rows
}

/// ψ by φ on a triangle with some masses.
fn dual(masses: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let with_integrals = with_integrals(masses.nrows());
    let masses = &with_integrals * masses * with_integrals.transpose();
    let integrals = DMatrix::from_diagonal(&masses.column_sum());
    Some(integrals * masses.cholesky()?.solve(&with_integrals))
}

/// The means of the barycentric coordinates in the place of these.
fn constant(masses: &DMatrix<f64>) -> DMatrix<f64> {
    let n = masses.nrows();
    let mut means = masses.column_sum() / masses.sum();
    for (middle, ends) in (3..n).zip(TRIANGLE_EDGES) {
        let half = means[middle] / 2.0;
        ends.into_iter().for_each(|end| means[end] += half);
        means[middle] = 0.0;
    }
    DMatrix::from_fn(n, n, |j, _| means[j])
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
