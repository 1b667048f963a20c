//! Tests of half-solved coupling rows and the dual operator made from them.

use super::{CholeskyFactor, CscMatrix, Work};
use crate::linalg::test_brick::Brick;
use crate::linalg::{Workspace, expand_to_unknowns, nested_dissection};

struct Case {
    coupling: CscMatrix,
    selection: CscMatrix,
    factor: CholeskyFactor,
}

fn case(n: usize) -> Case {
    let brick = Brick::new(n);
    let (indptr, indices) = brick.graph();
    let nodes = nested_dissection(&indptr, &indices, &brick.points).expect("a graph");
    let order = expand_to_unknowns(&nodes, |node| 3 * node..3 * node + 3);
    let factor =
        CholeskyFactor::<f64>::factorise(&brick.stiffness(), order).expect("positive definite");
    Case {
        coupling: brick.coupling(),
        selection: brick.contact_selection(),
        factor,
    }
}

/// C A⁻¹ Bᵀ by one full solve per row of B, column-major.
fn by_columns(factor: &CholeskyFactor, c: &CscMatrix, b: &CscMatrix) -> Vec<f64> {
    let by_rows = b.transpose();
    let mut work = Workspace::default();
    let mut result = vec![0.0; c.rows * b.rows];
    for (row, column) in result.chunks_exact_mut(c.rows).enumerate() {
        let mut x = vec![0.0; factor.size()];
        let (unknowns, coefficients) = by_rows.column(row);
        unknowns
            .iter()
            .zip(coefficients)
            .for_each(|(&unknown, &value)| x[unknown] = value);
        factor.solve_in_place(&mut x, &mut work);
        c.mul(&x, column);
    }
    result
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| x.abs().max(m))
}

fn assert_close(x: &[f64], y: &[f64]) {
    let difference: Vec<f64> = x.iter().zip(y).map(|(x, y)| x - y).collect();
    // two ways round the same factor: they differ by rounding, which 1e-12 allows to grow some
    // thousandfold
    assert!(
        largest(&difference) < 1e-12 * largest(y),
        "{:e}",
        largest(&difference) / largest(y)
    );
}

/// Of twice the operations that were counted, half are done in the end.
#[test]
fn every_counted_operation_is_done_once() {
    let Case {
        coupling, factor, ..
    } = case(10);
    let structure = factor.structure();
    let work = Work::of(2.0 * structure.operations());
    let matrix = Brick::new(10).stiffness();
    CholeskyFactor::<f64>::of_structure(structure.clone(), &matrix, &work).expect("a factor");
    // Both counts are whole numbers below 2^53.
    assert_eq!(work.share(), 0.5);
    let count = structure.count_forward_rows(&coupling);
    let work = Work::of(2.0 * (count.solve_operations + count.gram_operations));
    let rows = factor.forward_rows(&coupling, &work);
    assert!(work.share() < 0.5);
    assert_eq!(rows.gram().len(), coupling.rows * coupling.rows);
    assert_eq!(work.share(), 0.5);
}

#[test]
fn products_equal_solves_column_by_column() {
    let Case {
        coupling,
        selection,
        factor,
    } = case(10);
    let work = Work::default();
    let rows = factor.forward_rows(&coupling, &work);
    let gram = rows.gram();
    assert_close(&gram, &by_columns(&factor, &coupling, &coupling));
    assert_close(
        &rows.compliance(&selection),
        &by_columns(&factor, &selection, &coupling),
    );
    for i in 0..coupling.rows {
        for j in 0..i {
            assert!(gram[i * coupling.rows + j] == gram[j * coupling.rows + i]);
        }
    }
}

#[test]
fn products_have_the_same_bits_at_one_and_two_threads() {
    let Case {
        coupling,
        selection,
        factor,
    } = case(10);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("pool");
        pool.install(|| {
            let work = Work::default();
            let rows = factor.forward_rows(&coupling, &work);
            (rows.gram(), rows.compliance(&selection))
        })
    };
    assert!(run(1) == run(2));
}

#[test]
fn empty_rows_give_zeros() {
    let Case { factor, .. } = case(2);
    let size = factor.size();
    let none = CscMatrix::new(2, size, vec![0; size + 1], vec![], vec![]).expect("valid");
    let work = Work::default();
    let rows = factor.forward_rows(&none, &work);
    assert_eq!(rows.gram(), [0.0; 4]);
    assert_eq!(rows.compliance(&none), [0.0; 4]);
    let nothing = CscMatrix::new(0, size, vec![0; size + 1], vec![], vec![]).expect("valid");
    assert!(rows.compliance(&nothing).is_empty());
    assert!(
        factor
            .forward_rows(&nothing, &Work::default())
            .gram()
            .is_empty()
    );
}
