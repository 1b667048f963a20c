//! Tests of solves on a part of the elimination tree, of solves with a factor in single precision, and of half-solved coupling
//! rows with the dual operator made from them.

use super::{test_brick::Brick, *};

fn stiffness_and_factor(n: usize) -> (CscMatrix, CholeskyFactor) {
    let stiffness = Brick::new(n).stiffness();
    let order = amd(&stiffness).expect("square");
    let factor = CholeskyFactor::<f64>::factorise(&stiffness, order).expect("positive definite");
    (stiffness, factor)
}

/// Numbers in [−1, 1] without a pattern.
fn noise(length: usize, seed: u64) -> Vec<f64> {
    (0..length)
        .map(|i| (1e3 * (i as f64 + seed as f64)).sin())
        .collect()
}

#[test]
fn reached_solve_equals_the_full_solve() {
    let brick = Brick::new(6);
    let (_, factor) = stiffness_and_factor(6);
    let rows: Vec<usize> = brick
        .contact_nodes
        .iter()
        .flat_map(|&node| 3 * node..3 * node + 3)
        .take(60)
        .collect();
    let reach = factor.structure().reach(rows.iter().copied());
    assert!(reach.len() < factor.structure().supernodes());
    let mut full = vec![0.0; factor.size()];
    rows.iter()
        .zip(noise(rows.len(), 3))
        .for_each(|(&row, value)| full[row] = value);
    let mut reached = full.clone();
    // leftovers of an earlier solve in the work space must not matter
    factor.solve_in_place(&mut noise(factor.size(), 4));
    factor.solve_reached(&reach, &mut reached);
    factor.solve_in_place(&mut full);
    for row in rows {
        // The same sums in the same order.
        assert_eq!(full[row], reached[row]);
    }
}

#[test]
fn conjugate_gradients_reach_double_precision_with_a_factor_in_single() {
    let stiffness = Brick::new(8).stiffness();
    let order = amd(&stiffness).expect("square");
    let exact =
        CholeskyFactor::<f64>::factorise(&stiffness, order.clone()).expect("positive definite");
    let factor =
        Factor::Single(CholeskyFactor::factorise(&stiffness, order).expect("positive definite"));
    let b = noise(stiffness.cols, 9);
    let mut expected = b.clone();
    exact.solve_in_place(&mut expected);
    let mut rough = b.clone();
    factor.solve_in_place(&mut rough);
    let [solved] = &conjugate_gradients(&stiffness, &factor, &[&b], 1e-12, 0.0)[..] else {
        panic!("one right-hand side");
    };
    // Rounding in single precision times the condition number, some thousands; then that of double precision.
    assert!((1e-8..1e-2).contains(&(norm(&difference(&rough, &expected)) / norm(&expected))));
    assert!(norm(&difference(&solved.solution, &expected)) < 1e-11 * norm(&expected));
    assert!(
        solved.steps <= 6 && solved.contraction() < 0.1,
        "{solved:?}"
    );
}

struct SolveCase {
    coupling: CscMatrix,
    selection: CscMatrix,
    factor: CholeskyFactor,
}

fn case(n: usize) -> SolveCase {
    let brick = Brick::new(n);
    let (indptr, indices) = brick.graph();
    let nodes = nested_dissection(&indptr, &indices, &brick.points).expect("a graph");
    let order = expand_to_unknowns(&nodes, |node| 3 * node..3 * node + 3);
    let factor =
        CholeskyFactor::<f64>::factorise(&brick.stiffness(), order).expect("positive definite");
    SolveCase {
        coupling: coupling(&brick, n),
        selection: contact_selection(&brick),
        factor,
    }
}

/// Pane couplings B (rows: normal, t₁, t₂ of each 2 × 2 pane), clamped nodes left out.
fn coupling(brick: &Brick, n: usize) -> CscMatrix {
    let panes = 3 * n * n / 4;
    let area = 4.0 / (n * n) as f64;
    let mut rows: Vec<Vec<(usize, f64)>> = vec![];
    for (component, sign) in [(2, -1.0), (0, 1.0), (1, 1.0)] {
        for pane in 0..panes {
            let (ci, cj) = (2 * (pane / (n / 2)) + 1, 2 * (pane % (n / 2)) + 1);
            let mut row = vec![];
            for i in ci - 1..=ci + 1 {
                for j in (cj - 1..=cj + 1).filter(|_| i > 0) {
                    let weight = if (i, j) == (ci, cj) { 4.0 } else { 1.0 };
                    let node = ((i - 1) * (n + 1) + j) * (n + 1);
                    row.push((3 * node + component, sign * area / 12.0 * weight));
                }
            }
            rows.push(row);
        }
    }
    from_rows(3 * brick.points.len(), &rows)
}

/// The selection of all displacement components of the contact nodes.
fn contact_selection(brick: &Brick) -> CscMatrix {
    let unknowns = brick
        .contact_nodes
        .iter()
        .flat_map(|node| 3 * node..3 * node + 3);
    let rows: Vec<Vec<(usize, f64)>> = unknowns.map(|unknown| vec![(unknown, 1.0)]).collect();
    from_rows(3 * brick.points.len(), &rows)
}

/// A matrix given by rows of (column, value), columns increasing.
fn from_rows(cols: usize, rows: &[Vec<(usize, f64)>]) -> CscMatrix {
    let mut indptr = vec![0];
    let (mut indices, mut data) = (vec![], vec![]);
    for row in rows {
        indices.extend(row.iter().map(|entry| entry.0));
        data.extend(row.iter().map(|entry| entry.1));
        indptr.push(indices.len());
    }
    let transposed = CscMatrix {
        rows: cols,
        cols: rows.len(),
        indptr,
        indices,
        data,
    };
    transposed.transpose()
}

/// C A⁻¹ Bᵀ by one full solve per row of B, column-major.
fn by_columns(factor: &CholeskyFactor, c: &CscMatrix, b: &CscMatrix) -> Vec<f64> {
    let by_rows = b.transpose();
    let mut result = vec![0.0; c.rows * b.rows];
    for (row, column) in result.chunks_exact_mut(c.rows).enumerate() {
        let mut x = vec![0.0; factor.size()];
        for (unknown, value) in by_rows.entries(row) {
            x[unknown] = value;
        }
        factor.solve_in_place(&mut x);
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
    let SolveCase {
        coupling, factor, ..
    } = case(10);
    let structure = factor.structure();
    let work = Work::of(2.0 * structure.operations());
    let matrix = Brick::new(10).stiffness();
    CholeskyFactor::<f64>::of_structure(structure.clone(), &matrix, &work).expect("a factor");
    // Both counts are whole numbers below 2^53.
    assert_eq!(work.share(), 0.5);
    let [_, of_solves, of_products] = structure.count_forward_rows(&coupling);
    let work = Work::of(2.0 * (of_solves + of_products));
    let rows = factor.forward_rows(&coupling, &work);
    assert!(work.share() < 0.5);
    assert_eq!(rows.gram().len(), coupling.rows * coupling.rows);
    assert_eq!(work.share(), 0.5);
}

#[test]
fn products_equal_solves_column_by_column() {
    let SolveCase {
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
    let SolveCase {
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
    let SolveCase { factor, .. } = case(2);
    let size = factor.size();
    let none = from_rows(size, &[vec![], vec![]]);
    let work = Work::default();
    let rows = factor.forward_rows(&none, &work);
    assert_eq!(rows.gram(), [0.0; 4]);
    assert_eq!(rows.compliance(&none), [0.0; 4]);
    let nothing = from_rows(size, &[]);
    assert!(rows.compliance(&nothing).is_empty());
    assert!(
        factor
            .forward_rows(&nothing, &Work::default())
            .gram()
            .is_empty()
    );
}
