//! Norms of Y^h × Y^h and of L^H, and of the parts of Ψ′ between them.

use faer::Mat;

use super::{
    dense::{Factor, largest},
    scatter::factorised,
};
use crate::linalg::{CholeskyFactor, CscMatrix};

/// The logarithm of the ratio of two weights is searched this far to both sides, to an accuracy whose square is rounding.
const REACH: f64 = 40.0;
const VALLEY: f64 = 1e-6;

/// The norms of Y^h × Y^h and of L^H.
pub(super) struct SpaceNorms {
    /// M_Γ of scalar functions, over the free nodes.
    pub(super) mass: CscMatrix,
    pub(super) mass_factor: CholeskyFactor,
    /// ‖·‖²_{*,h} in each norm of displacements, `[m, m]`, and its factor.
    pub(super) pressure: Vec<(Mat<f64>, Factor)>,
}

impl SpaceNorms {
    /// `None` where a form has no factor.
    pub(super) fn new(mass: CscMatrix, pressure: Vec<Mat<f64>>) -> Option<Self> {
        let factors = pressure.into_iter().map(|form| {
            let factor = Factor::new(&form)?;
            Some((form, factor))
        });
        Some(Self {
            mass_factor: factorised(&mass)?,
            pressure: factors.collect::<Option<_>>()?,
            mass,
        })
    }

    pub(super) fn mass(&self) -> &CscMatrix {
        &self.mass
    }

    /// ‖μ‖_{*,h} in one of the norms of displacements.
    pub(super) fn of_pressure(&self, norm: usize, multiplier: &[f64]) -> f64 {
        let form = &self.pressure[norm].0;
        let terms = (0..form.ncols()).map(|j| {
            let column = (0..form.nrows()).map(|i| form[(i, j)] * multiplier[i]);
            multiplier[j] * column.sum::<f64>()
        });
        terms.sum::<f64>().max(0.0).sqrt()
    }
}

/// Norms of the four parts of Ψ′: how much slip and pressure move with slip and pressure.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PartNorms {
    /// ‖∂φ′/∂φ‖.
    pub slip_by_slip: f64,
    /// ‖∂φ′/∂g‖.
    pub slip_by_pressure: f64,
    /// ‖∂λ_ν′/∂φ‖.
    pub pressure_by_slip: f64,
    /// ‖∂λ_ν′/∂g‖.
    pub pressure_by_pressure: f64,
}

impl PartNorms {
    /// The largest eigenvalue of the 2 × 2 matrix of the norms: the least bound of ‖Ψ′‖ in w ‖φ‖ + ‖μ‖ over all weights w,
    /// as far as norms of parts tell.
    #[must_use]
    pub fn weighted(self) -> f64 {
        let (a, d) = (self.slip_by_slip, self.pressure_by_pressure);
        let mixed = self.slip_by_pressure * self.pressure_by_slip;
        0.5 * (a + d) + (0.25 * (a - d) * (a - d) + mixed).sqrt()
    }

    /// The weight w for which w ‖φ‖ + ‖μ‖ has that bound; 0 where nothing depends on the slip.
    #[must_use]
    pub fn weight(self) -> f64 {
        let rest = self.weighted() - self.slip_by_slip;
        if self.pressure_by_slip == 0.0 || rest <= 0.0 {
            return 0.0;
        }
        self.pressure_by_slip / rest
    }
}

/// The squared norms of the slip and of the pressure that Ψ′ makes of unit vectors of slip and of pressure.
pub(super) struct Blocks {
    pub(super) by_slip: [Mat<f64>; 2],
    pub(super) by_pressure: [Mat<f64>; 2],
}

impl Blocks {
    pub(super) fn part_norms(&self) -> PartNorms {
        let norm = |form: &Mat<f64>| largest(form).max(0.0).sqrt();
        PartNorms {
            slip_by_slip: norm(&self.by_slip[0]),
            pressure_by_slip: norm(&self.by_slip[1]),
            slip_by_pressure: norm(&self.by_pressure[0]),
            pressure_by_pressure: norm(&self.by_pressure[1]),
        }
    }

    /// The norm on the sum: the unit ball of ‖φ‖ + ‖μ‖ is the convex hull of the two unit balls.
    pub(super) fn paper(&self) -> f64 {
        sum_norm(&self.by_slip).max(sum_norm(&self.by_pressure))
    }
}

/// sup √(xᵀAx) + √(xᵀBx) over |x| = 1: the least λ_max(A/s + B/(1−s)) over 0 < s < 1, squared, since the pairs (xᵀAx, xᵀBx)
/// fill a convex set (L. Brickman, *Proc. Am. Math. Soc.* 12 (1961) 61).
fn sum_norm([first, second]: &[Mat<f64>; 2]) -> f64 {
    if first.nrows() == 0 {
        return 0.0;
    }
    let bound = |logit: f64| {
        let weights = [1.0 + (-logit).exp(), 1.0 + logit.exp()];
        let sum = Mat::from_fn(first.nrows(), first.nrows(), |i, j| {
            first[(i, j)] * weights[0] + second[(i, j)] * weights[1]
        });
        largest(&sum)
    };
    // At the best share s/(1 − s) = √(xᵀAx / xᵀBx): the logarithm of that is searched around its value for the largest of each.
    let size = |form: &Mat<f64>| largest(form).max(f64::MIN_POSITIVE).ln();
    let middle = 0.5 * (size(first) - size(second));
    least_by_golden_section(middle - REACH, middle + REACH, bound)
        .max(0.0)
        .sqrt()
}

/// The least value of a function with one valley.
fn least_by_golden_section(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let mut at = [high - golden * (high - low), low + golden * (high - low)];
    let mut values = at.map(&f);
    while high - low > VALLEY {
        if values[0] <= values[1] {
            high = at[1];
            (at[1], values[1]) = (at[0], values[0]);
            at[0] = high - golden * (high - low);
            values[0] = f(at[0]);
        } else {
            low = at[0];
            (at[0], values[0]) = (at[1], values[1]);
            at[1] = low + golden * (high - low);
            values[1] = f(at[1]);
        }
    }
    values[0].min(values[1])
}
