//! Dense systems by LU with partial pivoting, and the signs of their determinants.

use faer::{
    Conj, MatMut, Par,
    dyn_stack::{MemBuffer, MemStack},
    linalg::lu::partial_pivoting::{factor, solve},
    mat::Mat,
    perm::Perm,
};

use super::parity::transpositions;

/// A factorised square matrix, on one thread: the same bits at any number of threads.
pub(crate) struct DenseLu {
    lu: Mat<f64>,
    permutation: Perm<usize>,
    sign: i8,
}

impl DenseLu {
    /// Factorises a column-major matrix of order n; `None` where a pivot vanishes or is no number.
    pub(crate) fn new(matrix: &[f64], n: usize) -> Option<Self> {
        let mut lu = Mat::from_fn(n, n, |i, j| matrix[j * n + i]);
        let (mut forward, mut backward) = (vec![0_usize; n], vec![0_usize; n]);
        let mut memory = MemBuffer::new(factor::lu_in_place_scratch::<usize, f64>(
            n,
            n,
            Par::Seq,
            Default::default(),
        ));
        factor::lu_in_place(
            lu.as_mut(),
            &mut forward,
            &mut backward,
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
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

    /// The sign of the determinant.
    pub(crate) fn sign(&self) -> i8 {
        self.sign
    }

    /// Solves in place for the columns of a column-major right-hand side.
    pub(crate) fn solve(&self, rhs: &mut [f64]) {
        let n = self.lu.nrows();
        let columns = rhs.len() / n.max(1);
        let mut memory = MemBuffer::new(solve::solve_in_place_scratch::<usize, f64>(
            n,
            columns,
            Par::Seq,
        ));
        solve::solve_in_place_with_conj(
            self.lu.as_ref(),
            self.lu.as_ref(),
            self.permutation.as_ref(),
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, n, columns),
            Par::Seq,
            MemStack::new(&mut memory),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::DenseLu;

    #[test]
    fn solutions_and_signs_of_small_systems() {
        let lu = DenseLu::new(&[0.0, 2.0, 1.0, 3.0], 2).unwrap();
        assert_eq!(lu.sign(), -1);
        let mut x = [1.0, 8.0];
        lu.solve(&mut x);
        assert_eq!(x, [2.5, 1.0]);
        assert!(DenseLu::new(&[1.0, 2.0, 2.0, 4.0], 2).is_none());
    }
}
