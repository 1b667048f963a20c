//! S on aggregates of panes, and what it says of S on all of them.
//!
//! With P the stresses that are constant on each aggregate, Y = S P and S_c = PᵀS P, Nyström's approximation is S ≈ Y S_c⁻¹Yᵀ. It is
//! exact on the range of P, and what it leaves out is local: stresses that cancel on every aggregate move their surroundings only.

use std::collections::BTreeMap;

use faer::Mat;

use super::{Assembly, explicit::formed};
use crate::{
    contact::{Coupling, MultiplierLayout},
    linalg::{CscMatrix, DenseLu, Work},
};

/// Y = S P and S_c = PᵀS P for 2 √m aggregates of √m / 2 panes each, so that neither level is much larger than the other.
pub(crate) struct Aggregates {
    /// Y, `[n_multipliers, n_coarse]`, in m³/Pa.
    pub(crate) products: Mat<f64>,
    /// S_c, `[n_coarse, n_coarse]`, in m³/Pa.
    pub(crate) operator: Mat<f64>,
}

impl Aggregates {
    /// One solve with the factor for each of up to 6 √m stresses, side by side, in the precision of the factor.
    pub(crate) fn new(assembly: &Assembly, coupling: &Coupling) -> Self {
        let coarse = Coupling {
            transposed: summed(coupling, &groups(assembly, coupling)),
            layout: coupling.layout,
        };
        let (selection, work) = (Some(&coupling.transposed), &Work::default());
        let (operator, products) = formed(&assembly.factor, &coarse, selection, work);
        let products = products.unwrap_or_default();
        let (n, count) = (coupling.n_multipliers(), coarse.transposed.cols);
        Self {
            products: Mat::from_fn(n, count, |i, j| products[j * n + i]),
            operator: Mat::from_fn(count, count, |i, j| operator[j * count + i]),
        }
    }

    /// The diagonal of Y S_c⁻¹Yᵀ in m³/Pa, the mean of the two on the pair of a pane, `[n_multipliers]`; 0 where S_c is singular.
    pub(crate) fn diagonal(&self, layout: MultiplierLayout) -> Vec<f64> {
        let (n, count) = (self.products.nrows(), self.products.ncols());
        let mut solved = Mat::from_fn(count, n, |k, i| self.products[(i, k)]);
        let Some(factor) = DenseLu::of(self.operator.clone()) else {
            return vec![0.0; n];
        };
        for i in 0..n {
            factor.solve(solved.col_as_slice_mut(i));
        }
        let along = |i: usize| -> f64 {
            (0..count)
                .map(|k| self.products[(i, k)] * solved[(k, i)])
                .sum()
        };
        let mut diagonal: Vec<f64> = (0..n).map(along).collect();
        for pair in layout.split_mut(&mut diagonal).1 {
            *pair = [0.5 * (pair[0] + pair[1]); 2];
        }
        diagonal
    }
}

/// Panes in groups of neighbours: those that follow each other in the order of elimination, in which nested dissection keeps the
/// nodes of each part of the body together.
fn groups(assembly: &Assembly, coupling: &Coupling) -> Vec<Vec<usize>> {
    let permutation = &assembly.factor.structure().permutation;
    let mut place = vec![0; permutation.len()];
    for (new, &old) in permutation.iter().enumerate() {
        place[old] = new;
    }
    let first = |pane: usize| {
        let entries = coupling.transposed.entries(coupling.layout.normal(pane));
        entries.map(|(dof, _)| place[dof]).min()
    };
    let mut panes: Vec<usize> = (0..coupling.layout.n_panes()).collect();
    panes.sort_by_key(|&pane| (first(pane), pane));
    let size = (0.5 * (panes.len() as f64).sqrt()).ceil().max(1.0) as usize;
    panes.chunks(size).map(<[usize]>::to_vec).collect()
}

/// BᵀP: the columns of Bᵀ summed over the normal and over either tangential component of each group; none that vanish.
fn summed(coupling: &Coupling, groups: &[Vec<usize>]) -> CscMatrix {
    let mut sums = CscMatrix::empty(coupling.transposed.rows);
    for group in groups {
        let normals = group.iter().map(|&pane| coupling.layout.normal(pane));
        let tangential = |k: usize| {
            let pairs = group
                .iter()
                .filter_map(|&pane| coupling.layout.tangential(pane));
            pairs.map(move |pair| pair[k]).collect()
        };
        for components in [normals.collect::<Vec<_>>(), tangential(0), tangential(1)] {
            let mut sum: BTreeMap<usize, f64> = BTreeMap::new();
            for (dof, value) in components
                .iter()
                .flat_map(|&j| coupling.transposed.entries(j))
            {
                *sum.entry(dof).or_default() += value;
            }
            if sum.values().any(|value| *value != 0.0) {
                sums.push_column(sum);
            }
        }
    }
    sums
}
