//! A preconditioner of R' where S is implicit: the panes, and their aggregates.
//!
//! R' = 1 − E (1 − ρ S) with a small block E for each pane. With the compliance S_d of a pane against its neighbours and
//! S ≈ S_d + Y S_c⁻¹Yᵀ ([`Aggregates`]) it is M + U S_c⁻¹Yᵀ with the blocks M = 1 − E (1 − ρ S_d) and U = E ρ Y, whose inverse is
//!
//! (1 − M⁻¹U (S_c + YᵀM⁻¹U)⁻¹Yᵀ) M⁻¹.

use faer::{Mat, MatRef};
use nalgebra::Matrix3;
use rayon::prelude::*;

use super::conditions::{Conditions, Evaluation};
use crate::{
    contact::{Coupling, MultiplierLayout},
    dual::{Aggregates, Assembly},
    linalg::{DenseLu, add_scaled, product},
};

/// Columns and rows of a block of Y and U, of which threads take one after another; their number changes no sum.
const AGGREGATE_COLUMNS: usize = 32;
const AGGREGATE_ROWS: usize = 4096;

/// What is known of an implicit S: its aggregates, and the compliance of panes.
pub(super) struct PaneLevels {
    aggregates: Aggregates,
    /// S_d in m³/Pa, 0 where a component moves nothing, `[n_multipliers]`.
    compliance: Vec<f64>,
    /// ρ = 1/S_ii in Pa/m³, of which the aggregates give the part of S_ii that panes share, 0 where a component moves nothing.
    pub(super) steplengths: Vec<f64>,
}

impl PaneLevels {
    /// From the stiffness of each pane against its neighbours in Pa/m³.
    pub(super) fn new(assembly: &Assembly, coupling: &Coupling, stiffness: &[f64]) -> Self {
        let aggregates = Aggregates::new(assembly, coupling);
        let inverse = |value: f64| if value > 0.0 { value.recip() } else { 0.0 };
        let compliance: Vec<f64> = stiffness.iter().map(|rho| inverse(*rho)).collect();
        let shared = aggregates.diagonal(coupling.layout);
        let both = compliance.iter().zip(&shared);
        let steplengths = both.map(|(own, shared)| match *own {
            0.0 => 0.0,
            own => inverse(own + shared),
        });
        Self {
            steplengths: steplengths.collect(),
            aggregates,
            compliance,
        }
    }
}

/// The inverse of M + U S_c⁻¹Yᵀ at one λ.
pub(super) struct TwoLevels<'a> {
    layout: MultiplierLayout,
    /// M⁻¹, one block for each pane; of a pane without friction the first entry.
    blocks: Vec<Matrix3<f64>>,
    products: MatRef<'a, f64>,
    /// M⁻¹U and the factor of S_c + YᵀM⁻¹U; `None` where that is singular, and the panes stand alone.
    coarse: Option<(Mat<f64>, DenseLu)>,
}

impl<'a> TwoLevels<'a> {
    /// At a λ where the conditions were evaluated, on a face with so many nodes.
    pub(super) fn at(
        levels: &'a PaneLevels,
        conditions: &Conditions<'_>,
        at: &Evaluation,
        n_nodes: usize,
    ) -> Self {
        let no_slip = vec![[0.0; 2]; n_nodes];
        let derivative = |direction: &[f64], gradient: &[f64]| {
            conditions.derivative(at, direction, gradient, &no_slip)
        };
        Self::new(levels, conditions.layout, derivative)
    }

    /// Of ρ S_νν alone, for a face that slides freely and does not lift off.
    pub(super) fn bilateral_frictionless(levels: &'a PaneLevels, layout: MultiplierLayout) -> Self {
        Self::new(levels, layout, |direction, gradient| {
            let mut change = direction.to_vec();
            for pane in layout.normals() {
                change[pane] = levels.steplengths[pane] * gradient[pane];
            }
            change
        })
    }

    /// From R' v = `derivative`(v, S v), pane by pane.
    fn new(
        PaneLevels {
            aggregates,
            compliance,
            ..
        }: &'a PaneLevels,
        layout: MultiplierLayout,
        derivative: impl Fn(&[f64], &[f64]) -> Vec<f64>,
    ) -> Self {
        let products = aggregates.products.as_ref();
        let mut levels = Self {
            layout,
            blocks: inverse_blocks(layout, compliance, &derivative),
            products,
            coarse: None,
        };
        let at_rest = vec![0.0; products.nrows()];
        let mut response = Mat::zeros(products.nrows(), products.ncols());
        for j in 0..products.ncols() {
            let mut change = derivative(&at_rest, aggregates.products.col_as_slice(j));
            levels.apply_each(&mut change, |block| *block);
            response.col_as_slice_mut(j).copy_from_slice(&change);
        }
        let sum = &aggregates.operator + product(products.transpose(), response.as_ref());
        levels.coarse = DenseLu::of(sum).map(|factor| (response, factor));
        levels
    }

    pub(super) fn apply(&self, v: &[f64]) -> Vec<f64> {
        let mut x = v.to_vec();
        self.apply_each(&mut x, |block| *block);
        if let Some((response, factor)) = &self.coarse {
            let mut products = transposed_product(self.products, &x);
            factor.solve(&mut products);
            subtract(response.as_ref(), &products, &mut x);
        }
        x
    }

    /// The same with the transposed inverse.
    pub(super) fn apply_transposed(&self, v: &[f64]) -> Vec<f64> {
        let mut x = v.to_vec();
        if let Some((response, factor)) = &self.coarse {
            let mut products = transposed_product(response.as_ref(), v);
            factor.solve_transposed(&mut products);
            subtract(self.products, &products, &mut x);
        }
        self.apply_each(&mut x, Matrix3::transpose);
        x
    }

    fn apply_each(&self, x: &mut [f64], turned: impl Fn(&Matrix3<f64>) -> Matrix3<f64>) {
        for (pane, block) in self.blocks.iter().enumerate() {
            let block = turned(block);
            let normal = self.layout.normal(pane);
            match self.layout.tangential(pane) {
                None => x[normal] *= block[(0, 0)],
                Some([first, second]) => {
                    let at = [normal, first, second];
                    let y = block * nalgebra::Vector3::from(at.map(|i| x[i]));
                    at.into_iter().zip(&y).for_each(|(i, y)| x[i] = *y);
                }
            }
        }
    }
}

/// Yᵀx.
fn transposed_product(columns: MatRef<'_, f64>, x: &[f64]) -> Vec<f64> {
    let x = MatRef::from_column_major_slice(x, x.len(), 1);
    let mut products = vec![0.0; columns.ncols()];
    let blocks = products.par_chunks_mut(AGGREGATE_COLUMNS).enumerate();
    blocks.for_each(|(k, part)| {
        let columns = columns.subcols(k * AGGREGATE_COLUMNS, part.len());
        part.copy_from_slice(product(columns.transpose(), x).col_as_slice(0));
    });
    products
}

/// x − Y a.
fn subtract(columns: MatRef<'_, f64>, factors: &[f64], x: &mut [f64]) {
    let factors = MatRef::from_column_major_slice(factors, factors.len(), 1);
    x.par_chunks_mut(AGGREGATE_ROWS)
        .enumerate()
        .for_each(|(k, x)| {
            let change = product(columns.subrows(k * AGGREGATE_ROWS, x.len()), factors);
            add_scaled(x, -1.0, change.col_as_slice(0));
        });
}

/// M⁻¹ of every pane; 1 where M is singular.
fn inverse_blocks(
    layout: MultiplierLayout,
    compliance: &[f64],
    derivative: &impl Fn(&[f64], &[f64]) -> Vec<f64>,
) -> Vec<Matrix3<f64>> {
    let components = |pane: usize| {
        let pair = layout.tangential(pane).into_iter().flatten();
        std::iter::once(layout.normal(pane)).chain(pair)
    };
    let mut blocks = vec![Matrix3::identity(); layout.n_panes()];
    for column in 0..3 {
        let mut direction = vec![0.0; layout.n_multipliers()];
        let chosen = (0..layout.n_panes()).filter_map(|pane| components(pane).nth(column));
        chosen.for_each(|i| direction[i] = 1.0);
        let gradient: Vec<f64> = direction
            .iter()
            .zip(compliance)
            .map(|(v, d)| v * d)
            .collect();
        let change = derivative(&direction, &gradient);
        for (pane, block) in blocks.iter_mut().enumerate() {
            if components(pane).nth(column).is_some() {
                let rows = components(pane).enumerate();
                rows.for_each(|(row, i)| block[(row, column)] = change[i]);
            }
        }
    }
    let inverse = |block: Matrix3<f64>| block.try_inverse().unwrap_or_else(Matrix3::identity);
    blocks.into_iter().map(inverse).collect()
}
