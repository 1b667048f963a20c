//! Dense Cholesky factors on one thread: the same bits at any number of threads.

use faer::{
    Mat, MatMut, MatRef, Par,
    dyn_stack::{MemBuffer, MemStack},
    linalg::{
        cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch},
        triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place},
    },
};

/// How much is added to a diagonal of ones when rounding has made a matrix indefinite, in units of n ε, and by which factor this
/// grows until a factor exists.
const SHIFT: f64 = 1.0;
const SHIFT_GROWTH: f64 = 16.0;

/// LLᵀ of a positive definite matrix.
#[derive(Debug, Clone)]
pub(crate) struct DenseCholesky {
    /// L; the upper part means nothing.
    factor: Mat<f64>,
}

impl DenseCholesky {
    /// The factor of a matrix with diagonal 1, shifted as little as it takes to have one; `None` of one that is not finite.
    pub(crate) fn shifted(matrix: &Mat<f64>) -> Option<Self> {
        let n = matrix.nrows();
        let scratch = cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default());
        let mut memory = MemBuffer::new(scratch);
        shifts(n).find_map(|shift| {
            let mut factor = matrix.clone();
            for i in 0..n {
                factor[(i, i)] += shift;
            }
            let stack = MemStack::new(&mut memory);
            let lower = factor.as_mut();
            cholesky_in_place(
                lower,
                Default::default(),
                Par::Seq,
                stack,
                Default::default(),
            )
            .ok()?;
            Some(Self { factor })
        })
    }

    /// L.
    pub(crate) fn lower(&self) -> MatRef<'_, f64> {
        self.factor.as_ref()
    }

    /// x ← (LLᵀ)⁻¹x, for the leading part of as many components as x has.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        let n = x.len();
        let l = self.factor.as_ref().submatrix(0, 0, n, n);
        let mut x = MatMut::from_column_major_slice_mut(x, n, 1);
        solve_lower_triangular_in_place(l, x.as_mut(), Par::Seq);
        solve_upper_triangular_in_place(l.transpose(), x.as_mut(), Par::Seq);
    }
}

/// Shifts from n ε on to n, beyond which a matrix of unit diagonal is diagonally dominant.
pub(crate) fn shifts(n: usize) -> impl Iterator<Item = f64> {
    let n = n as f64;
    let grown = move |shift: &f64| (*shift < n).then_some(shift * SHIFT_GROWTH);
    std::iter::successors(Some(SHIFT * n * f64::EPSILON), grown)
}
