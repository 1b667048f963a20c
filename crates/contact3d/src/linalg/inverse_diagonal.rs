//! The diagonal of the inverse of a factorised matrix.

use super::{factor::CholeskyFactor, sparse::CscMatrix, work::Work};

/// Unit vectors that are solved together: neighbours in the elimination tree reach much the same supernodes.
const TOGETHER: usize = 512;

impl CholeskyFactor {
    /// (A⁻¹)_jj = ‖L⁻¹P e_j‖² for all j, by forward solves on the supernodes that each e_j reaches.
    #[must_use]
    pub(crate) fn inverse_diagonal(&self) -> Vec<f64> {
        let mut diagonal = vec![0.0; self.size()];
        for unknowns in self.structure().permutation.chunks(TOGETHER) {
            let mut unknowns = unknowns.to_vec();
            unknowns.sort_unstable();
            let rows = selection(&unknowns, self.size());
            let work = Work::default();
            let half_solved = self.forward_rows(&rows, &work);
            for (&unknown, length) in unknowns.iter().zip(half_solved.squared_lengths()) {
                diagonal[unknown] = length;
            }
        }
        diagonal
    }
}

/// The rows of the identity at ascending places.
fn selection(places: &[usize], size: usize) -> CscMatrix {
    let pointer = |column: usize| places.partition_point(|&place| place < column);
    CscMatrix {
        rows: places.len(),
        cols: size,
        indptr: (0..=size).map(pointer).collect(),
        indices: (0..places.len()).collect(),
        data: vec![1.0; places.len()],
    }
}

#[cfg(test)]
mod tests {
    use crate::linalg::{CholeskyFactor, amd, test_brick::Brick};

    #[test]
    fn it_is_the_diagonal_of_the_inverse() {
        let a = Brick::new(5).stiffness();
        let factor = CholeskyFactor::factorise(&a, amd(&a).unwrap()).unwrap();
        let diagonal = factor.inverse_diagonal();
        for j in (0..a.cols).step_by(7) {
            let mut unit = vec![0.0; a.cols];
            unit[j] = 1.0;
            factor.solve_in_place(&mut unit, &mut Default::default());
            // Both are rounded some hundred times.
            assert!((diagonal[j] / unit[j] - 1.0).abs() < 1e-12);
        }
    }
}
