//! Dense products and factors, with the same bits at any number of threads: LU with the sign of its determinant, and Cholesky.

use faer::{
    Accum, Conj, MatMut, MatRef, Par,
    dyn_stack::{MemBuffer, MemStack},
    linalg::{
        cholesky::llt::factor::{LltError, cholesky_in_place, cholesky_in_place_scratch},
        lu::partial_pivoting::{factor, solve},
        matmul::matmul,
        triangular_inverse::invert_lower_triangular,
        triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place},
    },
    mat::Mat,
    perm::Perm,
};

use super::precision::Scalar;

/// C = factor A B, or C += factor A B.
pub(super) fn multiply<T: Scalar>(
    c: MatMut<'_, T>,
    accum: Accum,
    factor: f64,
    a: MatRef<'_, T>,
    b: MatRef<'_, T>,
) {
    matmul(c, accum, a, b, T::rounded(factor), Par::Seq);
}

/// A B.
pub(crate) fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut c = Mat::zeros(a.nrows(), b.ncols());
    multiply(c.as_mut(), Accum::Replace, 1.0, a, b);
    c
}

/// L of LLᵀ in the lower triangle of a matrix; the first column whose pivot is not positive where there is none.
pub(super) fn cholesky<T: Scalar>(matrix: MatMut<'_, T>) -> Result<(), usize> {
    let (n, options) = (matrix.nrows(), Default::default());
    let mut memory = MemBuffer::new(cholesky_in_place_scratch::<T>(n, Par::Seq, options));
    let stack = MemStack::new(&mut memory);
    cholesky_in_place(matrix, Default::default(), Par::Seq, stack, options)
        .map(|_| ())
        .map_err(|LltError::NonPositivePivot { index }| index)
}

/// The threads for a dense matrix of order n: several factorise it faster than one from about 1000 on, in 14 ms against 17 at 1,296, 62
/// against 96 at 2,304 on two. They share the entries of products but no sum, so the bits are those of one thread.
fn threads_for(n: usize) -> Par {
    if n < 1000 || rayon::current_num_threads() < 2 {
        Par::Seq
    } else {
        Par::rayon(0)
    }
}

/// A factorised square matrix.
pub struct DenseLu {
    lu: Mat<f64>,
    permutation: Perm<usize>,
    /// The sign of the determinant.
    pub sign: i8,
}

impl DenseLu {
    /// Factorises a column-major matrix of order n; `None` where a pivot vanishes or is no number.
    #[must_use]
    pub fn new(matrix: &[f64], n: usize) -> Option<Self> {
        Self::of(Mat::from_fn(n, n, |i, j| matrix[j * n + i]))
    }

    /// Factorises a matrix in its place; `None` as for [`Self::new`].
    pub(crate) fn of(mut lu: Mat<f64>) -> Option<Self> {
        let n = lu.nrows();
        let (mut forward, mut backward) = (vec![0_usize; n], vec![0_usize; n]);
        let (threads, options) = (threads_for(n), Default::default());
        let need = factor::lu_in_place_scratch::<usize, f64>(n, n, threads, options);
        let mut memory = MemBuffer::new(need);
        let stack = MemStack::new(&mut memory);
        let (to, from) = (&mut forward, &mut backward);
        factor::lu_in_place(lu.as_mut(), to, from, threads, stack, options);
        let mut negative = transpositions(&forward);
        for i in 0..n {
            let pivot = lu[(i, i)];
            if pivot == 0.0 || !pivot.is_finite() {
                return None;
            }
            negative += usize::from(pivot < 0.0);
        }
        Some(Self {
            lu,
            permutation: Perm::new_checked(forward.into(), backward.into(), n),
            sign: if negative.is_multiple_of(2) { 1 } else { -1 },
        })
    }

    /// Solves in place for the columns of a column-major right-hand side.
    pub fn solve(&self, rhs: &mut [f64]) {
        let (n, columns) = self.shape_of(rhs);
        let need = solve::solve_in_place_scratch::<usize, f64>(n, columns, Par::Seq);
        solve::solve_in_place_with_conj(
            self.lu.as_ref(),
            self.lu.as_ref(),
            self.permutation.as_ref(),
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, n, columns),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(need)),
        );
    }

    /// Solves in place with the transposed matrix for the columns of a column-major right-hand side.
    pub fn solve_transposed(&self, rhs: &mut [f64]) {
        let (n, columns) = self.shape_of(rhs);
        let need = solve::solve_transpose_in_place_scratch::<usize, f64>(n, columns, Par::Seq);
        solve::solve_transpose_in_place_with_conj(
            self.lu.as_ref(),
            self.lu.as_ref(),
            self.permutation.as_ref(),
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, n, columns),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(need)),
        );
    }

    fn shape_of(&self, rhs: &[f64]) -> (usize, usize) {
        let n = self.lu.nrows();
        (n, rhs.len() / n.max(1))
    }
}

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
        shifts(n).find_map(|shift| {
            let mut factor = matrix.clone();
            for i in 0..n {
                factor[(i, i)] += shift;
            }
            cholesky(factor.as_mut()).ok()?;
            Some(Self { factor })
        })
    }

    /// The diagonal of (LLᵀ)⁻¹: squared lengths of the columns of L⁻¹.
    pub(crate) fn inverse_diagonal(&self) -> Vec<f64> {
        let n = self.factor.nrows();
        let mut inverse = Mat::<f64>::zeros(n, n);
        invert_lower_triangular(inverse.as_mut(), self.factor.as_ref(), Par::Seq);
        let square = |j: usize| (j..n).map(|i| inverse[(i, j)].powi(2)).sum();
        (0..n).map(square).collect()
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

/// What is added to a diagonal of ones until a matrix that rounding has made indefinite has a factor: from n ε_M on, each 16 times the
/// one before, to n, beyond which it is diagonally dominant.
fn shifts(n: usize) -> impl Iterator<Item = f64> {
    let n = n as f64;
    let grown = move |shift: &f64| (*shift < n).then_some(16.0 * shift);
    std::iter::successors(Some(n * f64::EPSILON), grown)
}

/// The number of transpositions that a permutation is made of, up to an even number.
pub(crate) fn transpositions(permutation: &[usize]) -> usize {
    let mut seen = vec![false; permutation.len()];
    let mut count = 0;
    for start in 0..permutation.len() {
        let mut at = start;
        while !seen[at] {
            seen[at] = true;
            at = permutation[at];
            count += usize::from(!seen[at]);
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::{DenseLu, transpositions};

    #[test]
    fn the_bits_of_a_factor_are_the_same_at_any_number_of_threads() {
        for n in [999, 1000, 1203] {
            let entry = |k: usize| (k as f64 * 0.754_877_666).fract() - 0.5;
            let matrix: Vec<f64> = (0..n * n).map(entry).collect();
            let factor = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                let pool = pool.build().expect("threads");
                let lu = pool.install(|| DenseLu::new(&matrix, n)).expect("a factor");
                let mut solution: Vec<f64> = (0..n).map(|k| entry(k + 17)).collect();
                lu.solve(&mut solution);
                solution
            };
            let alone = factor(1);
            for threads in [2, 3, 8] {
                assert!(alone == factor(threads), "n = {n}, {threads} threads");
            }
        }
    }

    #[test]
    fn permutations_have_the_parity_of_their_cycles() {
        assert_eq!(transpositions(&[0, 1, 2]) % 2, 0);
        assert_eq!(transpositions(&[1, 0, 2]) % 2, 1);
        assert_eq!(transpositions(&[1, 2, 0]) % 2, 0);
        assert_eq!(transpositions(&[1, 0, 3, 2]) % 2, 0);
    }
}
