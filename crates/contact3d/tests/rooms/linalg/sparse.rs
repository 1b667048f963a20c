//! Compressed columns.

use contact3d::linalg::CscMatrix;
use proptest::prelude::*;

/// A random matrix of at most 7 × 7 as a dense table.
fn dense() -> impl Strategy<Value = Vec<Vec<f64>>> {
    let entry = prop_oneof![Just(0.0), -4.0..4.0_f64];
    (1..8usize, 1..8usize).prop_flat_map(move |(r, c)| {
        prop::collection::vec(prop::collection::vec(entry.clone(), c), r)
    })
}

fn compress(table: &[Vec<f64>]) -> CscMatrix {
    let (rows, cols) = (table.len(), table[0].len());
    let (mut indptr, mut indices, mut data) = (vec![0], vec![], vec![]);
    for column in 0..cols {
        for (row, line) in table
            .iter()
            .enumerate()
            .filter(|(_, line)| line[column] != 0.0)
        {
            indices.push(row);
            data.push(line[column]);
        }
        indptr.push(indices.len());
    }
    CscMatrix {
        rows,
        cols,
        indptr,
        indices,
        data,
    }
}

proptest! {
    #[test]
    fn products_agree_with_the_dense_table(table in dense()) {
        let matrix = compress(&table);
        let x: Vec<f64> = (0..matrix.cols).map(|j| 1.0 + j as f64).collect();
        let mut y = vec![0.0; matrix.rows];
        matrix.mul(&x, &mut y);
        for (row, line) in table.iter().enumerate() {
            let expected: f64 = line.iter().zip(&x).map(|(a, b)| a * b).sum();
            // at most 7 products below 28: rounding is far below 1e-12
            prop_assert!((y[row] - expected).abs() < 1e-12);
        }
        let mut by_transpose = vec![0.0; matrix.rows];
        matrix.transpose().mul_transposed(&x, &mut by_transpose);
        // same terms in the same order
        prop_assert_eq!(&y, &by_transpose);
        prop_assert_eq!(matrix.transpose().transpose(), matrix);
    }
}
