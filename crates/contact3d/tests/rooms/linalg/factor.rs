//! Tests of factorisation and solves on the clamped elastic brick.

use contact3d::linalg::{CholeskyFactor, CscMatrix, FactorError, amd};

use super::brick::Brick;

fn stiffness_and_factor(n: usize) -> (CscMatrix, CholeskyFactor) {
    let stiffness = Brick::new(n).stiffness();
    let order = amd(&stiffness).expect("square");
    let factor = CholeskyFactor::<f64>::factorise(&stiffness, order).expect("positive definite");
    (stiffness, factor)
}

/// Reproducible numbers in (−1, 1).
fn noise(length: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    let mut next = || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..length).map(|_| next()).collect()
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn distance(x: &[f64], y: &[f64]) -> f64 {
    x.iter()
        .zip(y)
        .map(|(x, y)| (x - y).powi(2))
        .sum::<f64>()
        .sqrt()
}

/// L Lᵀ x in the new numbering, straight from the documented layout.
fn multiply(factor: &CholeskyFactor, x: &[f64]) -> Vec<f64> {
    let mut triplets = vec![];
    for s in 0..factor.structure().supernodes() {
        let rows = &factor.structure().row_indices
            [factor.structure().row_offsets[s]..factor.structure().row_offsets[s + 1]];
        for (k, column) in (factor.structure().supernode_columns[s]
            ..factor.structure().supernode_columns[s + 1])
            .enumerate()
        {
            for (i, &row) in rows.iter().enumerate() {
                triplets.push((
                    row,
                    column,
                    factor.values()[factor.structure().value_offsets[s] + k * rows.len() + i],
                ));
            }
        }
    }
    let (mut z, mut y) = (vec![0.0; x.len()], vec![0.0; x.len()]);
    triplets
        .iter()
        .for_each(|&(row, column, value)| z[column] += value * x[row]);
    triplets
        .iter()
        .for_each(|&(row, column, value)| y[row] += value * z[column]);
    y
}

#[test]
fn factor_reproduces_the_permuted_matrix() {
    let (stiffness, factor) = stiffness_and_factor(4);
    for seed in 0..3 {
        let x = noise(stiffness.cols, seed);
        let permuted = |x: &[f64]| -> Vec<f64> {
            factor
                .structure()
                .permutation
                .iter()
                .map(|&old| x[old])
                .collect()
        };
        let mut expected = vec![0.0; x.len()];
        stiffness.mul(&x, &mut expected);
        let (x, expected) = (permuted(&x), permuted(&expected));
        // backward error of a Cholesky factorisation: a few units of rounding times ‖A‖‖x‖
        assert!(distance(&multiply(&factor, &x), &expected) < 1e-13 * norm(&expected));
    }
}

#[test]
fn solves_have_small_residuals() {
    let (stiffness, factor) = stiffness_and_factor(6);
    for b in noise(5 * stiffness.cols, 7).chunks_exact(stiffness.cols) {
        let mut x = b.to_vec();
        factor.solve_in_place(&mut x);
        let mut product = vec![0.0; b.len()];
        stiffness.mul(&x, &mut product);
        // relative residual ≈ rounding × ‖A‖‖x‖/‖b‖, which 1e-12 allows to be some thousands
        assert!(
            distance(&product, b) < 1e-12 * norm(b),
            "{}",
            distance(&product, b) / norm(b)
        );
    }
}

#[test]
fn factor_has_the_same_bits_at_one_and_two_threads() {
    let brick = Brick::new(8);
    let stiffness = brick.stiffness();
    let order = amd(&stiffness).expect("square");
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| {
            CholeskyFactor::<f64>::factorise(&stiffness, order.clone()).expect("positive definite")
        })
    };
    let (one, two) = (on(1), on(2));
    assert!(one == two);
}

#[test]
fn a_factor_in_single_precision_has_the_same_bits_at_one_and_three_threads() {
    let stiffness = Brick::new(8).stiffness();
    let order = amd(&stiffness).expect("square");
    let b = noise(stiffness.cols, 5);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| {
            let factor = CholeskyFactor::<f32>::factorise(&stiffness, order.clone())
                .expect("positive definite");
            let mut x = b.clone();
            factor.solve_in_place(&mut x);
            (factor, x)
        })
    };
    assert!(on(1) == on(3));
}

#[test]
fn small_subtrees_are_one_supernode_each() {
    let (stiffness, factor) = stiffness_and_factor(6);
    let structure = factor.structure();
    let columns = |s: usize| structure.supernode_columns[s]..structure.supernode_columns[s + 1];
    let owner = |row: &usize| {
        structure
            .supernode_columns
            .partition_point(|first| first <= row)
            - 1
    };
    let mut subtree: Vec<usize> = (0..structure.supernodes())
        .map(|s| columns(s).len())
        .collect();
    for s in 0..structure.supernodes() {
        let alone = columns(s).len() == subtree[s];
        assert!(
            alone || subtree[s] > 32,
            "a subtree of {} columns has several supernodes",
            subtree[s]
        );
        // The parent owns the first row below the supernode's own columns.
        let rows = &structure.row_indices[structure.row_offsets[s]..structure.row_offsets[s + 1]];
        if let Some(row) = rows.get(columns(s).len()) {
            subtree[owner(row)] += subtree[s];
        }
    }
    // Merging changes no row of a matrix, so the factor passes the checks of stored ones.
    let values = factor.values().to_vec();
    assert_eq!(
        CholeskyFactor::from_parts(structure.clone(), values).as_ref(),
        Ok(&factor)
    );
    assert_eq!(structure.size(), stiffness.cols);
}

#[test]
fn indefinite_matrices_name_the_unknown_and_the_pivot() {
    // [[4, 2], [2, 0.5]]: pivots 4 and 0.5 − 1 = −0.5
    let matrix = CscMatrix {
        rows: 2,
        cols: 2,
        indptr: vec![0, 2, 4],
        indices: vec![0, 1, 0, 1],
        data: vec![4.0, 2.0, 2.0, 0.5],
    };
    let failure = CholeskyFactor::<f64>::factorise(&matrix, vec![0, 1]);
    assert_eq!(
        failure,
        Err(FactorError::NotPositiveDefinite {
            column: 1,
            pivot: -0.5
        })
    );
    let mut stiffness = Brick::new(4).stiffness();
    let column = 500;
    let place = stiffness.indptr[column]
        + stiffness
            .column(column)
            .0
            .binary_search(&column)
            .expect("diagonal");
    for value in [-1.0, 0.0, f64::NAN] {
        stiffness.data[place] = value;
        let order = amd(&stiffness).expect("square");
        let failure = CholeskyFactor::<f64>::factorise(&stiffness, order);
        assert!(
            matches!(failure, Err(FactorError::NotPositiveDefinite { .. })),
            "{value}"
        );
    }
}

#[test]
fn floating_bodies_are_singular() {
    // a chain of springs with both ends free
    let n = 500;
    let (mut indptr, mut indices, mut data) = (vec![0], vec![], vec![]);
    for j in 0..n {
        for i in j.max(1) - 1..(j + 2).min(n) {
            indices.push(i);
            data.push(if i != j {
                -0.3
            } else if j == 0 || j == n - 1 {
                0.3
            } else {
                0.6
            });
        }
        indptr.push(indices.len());
    }
    let chain = CscMatrix {
        rows: n,
        cols: n,
        indptr,
        indices,
        data,
    };
    let failure = CholeskyFactor::<f64>::factorise(&chain, amd(&chain).expect("square"));
    assert!(matches!(
        failure,
        Err(FactorError::NotPositiveDefinite { .. })
    ));
}

#[test]
fn wrong_shapes_and_orderings_are_refused() {
    let rectangle = CscMatrix::empty(1);
    assert_eq!(
        CholeskyFactor::<f64>::factorise(&rectangle, vec![]),
        Err(FactorError::NotSquare { rows: 1, cols: 0 })
    );
    let one = CscMatrix {
        rows: 1,
        cols: 1,
        indptr: vec![0, 1],
        indices: vec![0],
        data: vec![1.0],
    };
    for order in [vec![], vec![1], vec![0, 0]] {
        let length = order.len();
        let failure = CholeskyFactor::<f64>::factorise(&one, order);
        assert_eq!(
            failure,
            Err(FactorError::NotAPermutation { length, size: 1 })
        );
    }
}

#[test]
fn empty_system_is_solved() {
    let empty = CscMatrix::empty(0);
    let factor = CholeskyFactor::<f64>::factorise(&empty, vec![]).expect("empty");
    factor.solve_in_place(&mut []);
}
