//! Sparse systems by LU with partial pivoting.

use faer::{
    Conj, MatMut, Par,
    dyn_stack::{MemBuffer, MemStack},
    sparse::{
        SparseColMatRef,
        linalg::{
            SupernodalThreshold,
            lu::{LuSymbolicParams, NumericLu, factorize_symbolic_lu},
        },
    },
};

use super::{factor::pattern, sparse::CscMatrix};

/// Coefficients of the last factor, whose memory the next one takes.
#[derive(Debug, Default)]
pub(crate) struct SparseLuMemory(NumericLu<usize, f64>);

/// Solves M x = b in place on one thread, the columns ordered by COLAMD; `None` for a singular M.
pub(crate) fn solve_sparse(
    matrix: &CscMatrix,
    rhs: &mut [f64],
    coefficients: &mut SparseLuMemory,
) -> Option<()> {
    let n = rhs.len();
    if n == 0 {
        return Some(());
    }
    let pattern = pattern(matrix);
    // The other kind cannot take the memory of a factor of another size.
    let by_supernodes = LuSymbolicParams {
        supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
        ..LuSymbolicParams::default()
    };
    let structure = factorize_symbolic_lu(pattern, by_supernodes).ok()?;
    let need = structure.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default());
    let mut memory = MemBuffer::try_new(need).ok()?;
    let values = SparseColMatRef::new(pattern, &matrix.data);
    let stack = MemStack::new(&mut memory);
    let lu = structure
        .factorize_numeric_lu(
            &mut coefficients.0,
            values,
            Par::Seq,
            stack,
            Default::default(),
        )
        .ok()?;
    let mut memory =
        MemBuffer::try_new(structure.solve_in_place_scratch::<f64>(1, Par::Seq)).ok()?;
    lu.solve_in_place_with_conj(
        Conj::No,
        MatMut::from_column_major_slice_mut(rhs, n, 1),
        Par::Seq,
        MemStack::new(&mut memory),
    );
    rhs.iter().all(|value| value.is_finite()).then_some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The second difference with a circulation, and a zero on the diagonal that asks for another row.
    fn circulation(n: usize) -> CscMatrix {
        let entry = |i: usize, j: usize| match (i, j) {
            (0, 0) => 0.0,
            (i, j) if i == j => 2.0,
            (i, j) if i == j + 1 => -1.5,
            (i, j) if j == i + 1 => -0.5,
            _ => 0.0,
        };
        let mut matrix = CscMatrix::empty(n);
        for j in 0..n {
            for i in (0..n).filter(|&i| entry(i, j) != 0.0) {
                matrix.indices.push(i);
                matrix.data.push(entry(i, j));
            }
            matrix.indptr.push(matrix.indices.len());
        }
        matrix.cols = n;
        matrix
    }

    #[test]
    fn solutions_of_unsymmetric_systems_of_any_size_in_one_memory() {
        let memory = &mut SparseLuMemory::default();
        for n in [50, 7, 200, 199, 3, 50] {
            let matrix = circulation(n);
            let wanted: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
            let mut x = vec![0.0; n];
            matrix.mul(&wanted, &mut x);
            let mut alone = x.clone();
            solve_sparse(&matrix, &mut x, memory).unwrap();
            solve_sparse(&matrix, &mut alone, &mut SparseLuMemory::default()).unwrap();
            assert_eq!(x, alone);
            // A condition number of some thousand.
            assert!(x.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-10));
        }
    }

    #[test]
    fn singular_systems_are_refused() {
        let zero = CscMatrix::new(2, 2, vec![0, 2, 4], vec![0, 1, 0, 1], vec![1.0; 4]).unwrap();
        let memory = &mut SparseLuMemory::default();
        assert_eq!(solve_sparse(&zero, &mut [1.0, 2.0], memory), None);
    }
}
