//! A dense dual operator of inner problems.

use contact3d::{
    dual::DualOperator,
    linalg::{add_scaled, norm},
    solver::FeasibleSet,
};
use nalgebra::{DMatrix, DVector};

pub(super) const PANES: usize = 4;
pub(super) const N: usize = 3 * PANES;

/// A dense S; from application `broken_from` on it gives NaN.
pub(super) struct Dense {
    pub(super) matrix: DMatrix<f64>,
    pub(super) rhs: Vec<f64>,
    pub(super) applications: usize,
    pub(super) broken_from: usize,
}

impl Dense {
    /// S = GᵀG + I, with zero rows and columns where `idle` says so.
    pub(super) fn new(entries: &[f64], rhs: &[f64], idle: &[usize]) -> Self {
        let g = DMatrix::from_column_slice(N, N, entries);
        let mut matrix = g.transpose() * &g + DMatrix::identity(N, N);
        for &i in idle {
            matrix.row_mut(i).fill(0.0);
            matrix.column_mut(i).fill(0.0);
        }
        Self {
            matrix,
            rhs: rhs.to_vec(),
            applications: 0,
            broken_from: usize::MAX,
        }
    }

    pub(super) fn gradient(&mut self, multiplier: &[f64]) -> Vec<f64> {
        let mut r = self.apply(multiplier);
        add_scaled(&mut r, -1.0, &self.rhs);
        r
    }
}

impl DualOperator for Dense {
    fn dimension(&self) -> usize {
        self.rhs.len()
    }
    fn rhs(&self) -> &[f64] {
        &self.rhs
    }
    fn apply(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.applications += 1;
        let product = &self.matrix * DVector::from_column_slice(multiplier);
        let broken = self.applications >= self.broken_from;
        let factor = if broken { f64::NAN } else { 1.0 };
        product.iter().map(|v| factor * v).collect()
    }
    fn applications(&self) -> usize {
        self.applications
    }
}

pub(super) fn set_of(semi_axes: Vec<[f64; 2]>) -> FeasibleSet {
    FeasibleSet::new(PANES, semi_axes)
}

/// ‖λ − P(λ − s r)‖, which vanishes for every s > 0 exactly at the minimiser.
pub(super) fn projected_step(set: &FeasibleSet, multiplier: &[f64], r: &[f64], s: f64) -> f64 {
    let mut step = multiplier.to_vec();
    add_scaled(&mut step, -s, r);
    set.project(&mut step);
    add_scaled(&mut step, -1.0, multiplier);
    norm(&step)
}
