//! The Cholesky factor of S, dense or sparse as S is.

use faer::{Mat, MatMut, Par, linalg::triangular_inverse::invert_lower_triangular};

use super::{DualMatrix, ExplicitDual};
use crate::linalg::{
    CholeskyFactor, CscMatrix, DenseCholesky, FactorStructure, Work, Workspace, amd, shifts,
};

/// LLᵀ = D S D + shift for D = diag(1/√S_ii) over the components whose rows do not vanish.
#[derive(Debug, Clone)]
pub(super) struct StiffnessFactor {
    /// Those components, ascending.
    pub(super) kept: Vec<usize>,
    /// 1/√S_ii of them.
    pub(super) scale: Vec<f64>,
    factor: Triangle,
}

#[derive(Debug, Clone)]
enum Triangle {
    /// `None` of numbers that are not finite.
    Dense(Option<DenseCholesky>),
    Sparse(Box<SparseTriangle>),
}

/// Sparse factors; `None` of numbers that are not finite.
#[derive(Debug, Clone)]
struct SparseTriangle {
    /// Of all components.
    all: Option<CholeskyFactor>,
    /// Of the first ones, the normal ones, whose factor is no part of the other; none where there are no others.
    normal: Option<CholeskyFactor>,
}

impl StiffnessFactor {
    /// A third of n³ operations for n multipliers of a dense S.
    pub(super) fn new(dual: &ExplicitDual) -> Self {
        let (kept, scale) = units(dual);
        let factor = match &dual.operator {
            DualMatrix::Dense(_) => {
                Triangle::Dense(DenseCholesky::shifted(&unit_diagonal(dual, &kept, &scale)))
            }
            DualMatrix::Sparse(matrix) => {
                let n_normal = kept.partition_point(|&j| j < dual.n_panes());
                let leading = |count: usize| leading(matrix, &kept[..count], &scale);
                let are_all = n_normal == kept.len();
                Triangle::Sparse(Box::new(SparseTriangle {
                    all: shifted_sparse(leading(kept.len())),
                    normal: match are_all {
                        true => None,
                        false => shifted_sparse(leading(n_normal)),
                    },
                }))
            }
        };
        Self {
            kept,
            scale,
            factor,
        }
    }

    /// S⁻¹h in Pa for h in m³.
    pub(super) fn solve(&self, rhs: &[f64]) -> Vec<f64> {
        self.solve_first(rhs, self.kept.len())
    }

    /// S_νν⁻¹h_ν in Pa, and zeros.
    pub(super) fn solve_normal(&self, rhs: &[f64], n_panes: usize) -> Vec<f64> {
        self.solve_first(rhs, self.kept.partition_point(|&j| j < n_panes))
    }

    /// Solves with the first `count` kept components; the others are zero.
    fn solve_first(&self, rhs: &[f64], count: usize) -> Vec<f64> {
        let scaled = (0..count).map(|i| self.scale[i] * rhs[self.kept[i]]);
        let mut x: Vec<f64> = scaled.collect();
        self.factor.solve(&mut x);
        let mut solution = vec![0.0; rhs.len()];
        for (i, x) in x.iter().enumerate() {
            solution[self.kept[i]] = self.scale[i] * x;
        }
        solution
    }

    /// The diagonal of (LLᵀ)⁻¹.
    pub(super) fn inverse_diagonal(&self) -> Vec<f64> {
        match &self.factor {
            Triangle::Dense(None) => vec![f64::NAN; self.kept.len()],
            Triangle::Dense(Some(factor)) => inverse_diagonal(factor),
            Triangle::Sparse(factors) => match &factors.all {
                None => vec![f64::NAN; self.kept.len()],
                Some(factor) => factor.inverse_diagonal(),
            },
        }
    }
}

impl Triangle {
    /// Solves with the leading part of as many components as x has.
    fn solve(&self, x: &mut [f64]) {
        match self {
            Self::Dense(None) => x.fill(f64::NAN),
            Self::Dense(Some(factor)) => factor.solve(x),
            Self::Sparse(factors) => {
                let is_whole = |factor: &CholeskyFactor| factor.size() == x.len();
                let factor = match factors.all.as_ref().is_none_or(is_whole) {
                    true => &factors.all,
                    false => &factors.normal,
                };
                match factor {
                    None => x.fill(f64::NAN),
                    Some(factor) => factor.solve_in_place(x, &mut Workspace::default()),
                }
            }
        }
    }
}

/// The components whose rows of S do not vanish, and 1/√S_ii of those.
pub(super) fn units(dual: &ExplicitDual) -> (Vec<usize>, Vec<f64>) {
    let kept = (0..dual.dimension()).filter(|&j| dual.diagonal(j) > 0.0);
    kept.map(|j| (j, dual.diagonal(j).sqrt().recip())).unzip()
}

/// D S D of a dense S over some components.
pub(super) fn unit_diagonal(dual: &ExplicitDual, kept: &[usize], scale: &[f64]) -> Mat<f64> {
    Mat::from_fn(kept.len(), kept.len(), |i, j| {
        scale[i] * dual.column(kept[j])[kept[i]] * scale[j]
    })
}

/// D S D of a sparse S over some ascending components.
fn leading(matrix: &CscMatrix, kept: &[usize], scale: &[f64]) -> CscMatrix {
    let n = kept.len();
    let mut scaled = CscMatrix::empty(n);
    scaled.cols = n;
    for (&j, by_column) in kept.iter().zip(scale) {
        let (rows, values) = matrix.column(j);
        for (row, value) in rows.iter().zip(values) {
            if let Ok(i) = kept.binary_search(row) {
                scaled.indices.push(i);
                scaled.data.push(scale[i] * value * by_column);
            }
        }
        scaled.indptr.push(scaled.indices.len());
    }
    scaled
}

/// The Cholesky factor of a sparse matrix with diagonal 1, shifted as little as it takes to have one; `None` of one that is not
/// finite.
fn shifted_sparse(mut matrix: CscMatrix) -> Option<CholeskyFactor> {
    let structure = FactorStructure::analyse(&matrix, amd(&matrix).ok()?).ok()?;
    let exact = matrix.data.clone();
    shifts(matrix.cols).find_map(|shift| {
        matrix.data.copy_from_slice(&exact);
        matrix.add_to_diagonal(shift);
        CholeskyFactor::of_structure(structure.clone(), &matrix, &Work::default()).ok()
    })
}

/// The diagonal of (LLᵀ)⁻¹: squared lengths of the columns of L⁻¹.
fn inverse_diagonal(factor: &DenseCholesky) -> Vec<f64> {
    let n = factor.lower().nrows();
    let mut inverse = Mat::<f64>::zeros(n, n);
    invert_lower_triangular(
        inverse.as_mut() as MatMut<'_, f64>,
        factor.lower(),
        Par::Seq,
    );
    (0..n)
        .map(|j| (j..n).map(|i| inverse[(i, j)].powi(2)).sum())
        .collect()
}
