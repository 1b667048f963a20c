//! Compressed columns.

use contact3d::linalg::{CscMatrix, SparseError};
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
    CscMatrix::new(rows, cols, indptr, indices, data).expect("valid by construction")
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

#[test]
fn damaged_arrays_are_refused() {
    let build = |indptr: &[usize], indices: &[usize]| {
        CscMatrix::new(3, 2, indptr.to_vec(), indices.to_vec(), vec![1.0; 3]).map(|_| ())
    };
    assert_eq!(build(&[0, 1, 3], &[0, 1, 2]), Ok(()));
    let pointers = Err(SparseError::ColumnPointers {
        cols: 2,
        entries: 3,
    });
    for indptr in [
        &[0, 1][..],
        &[1, 1, 3],
        &[0, 2, 1],
        &[0, 4, 3],
        &[0, 1, 2],
        &[],
    ] {
        assert_eq!(build(indptr, &[0, 1, 2]), pointers);
    }
    let rows = Err(SparseError::RowIndices { column: 1, rows: 3 });
    for indices in [[0, 1, 3], [0, 1, 1], [0, 2, 1]] {
        assert_eq!(build(&[0, 1, 3], &indices), rows);
    }
    assert_eq!(
        build(&[0, 1, 2], &[0, 1]),
        Err(SparseError::Lengths {
            indices: 2,
            data: 3
        })
    );
}
