//! Orderings of graphs.

use contact3d::linalg::{
    CholeskyFactor, CscMatrix, FactorError, amd, expand_to_unknowns, nested_dissection,
};
use proptest::prelude::*;

use super::brick::Brick;

fn is_permutation(order: &[usize], length: usize) -> bool {
    let mut sorted = order.to_vec();
    sorted.sort_unstable();
    sorted.into_iter().eq(0..length)
}

#[test]
fn roundings_of_the_coordinates_change_nothing() {
    let brick = Brick::new(6);
    let (indptr, indices) = brick.graph();
    let jitter = |x: f64, node: usize| x * (1.0 + f64::EPSILON * (node % 5) as f64);
    let rounded: Vec<[f64; 3]> = brick
        .points
        .iter()
        .enumerate()
        .map(|(node, point)| point.map(|x| jitter(x, node)))
        .collect();
    let order = nested_dissection(&indptr, &indices, &rounded).expect("a graph");
    assert_eq!(order, ordering(&brick));
}

fn ordering(brick: &Brick) -> Vec<usize> {
    let (indptr, indices) = brick.graph();
    nested_dissection(&indptr, &indices, &brick.points).expect("a graph")
}

fn entries(brick: &Brick, order: Vec<usize>) -> usize {
    CholeskyFactor::<f64>::factorise(&brick.stiffness(), order)
        .expect("positive definite")
        .values()
        .len()
}

#[test]
fn dissection_beats_minimum_degree() {
    let brick = Brick::new(12);
    let order = expand_to_unknowns(&ordering(&brick), |node| 3 * node..3 * node + 3);
    let minimum_degree = amd(&brick.stiffness()).expect("square");
    // measured savings in stored entries: 34 % at 16 cells per edge, 47 % at 24; a bound of 10
    // % leaves room at 12
    assert!(entries(&brick, order) * 10 < entries(&brick, minimum_degree) * 9);
}

#[test]
fn stretching_changes_nothing() {
    assert_eq!(
        ordering(&Brick::new(6)),
        ordering(&Brick::stretched(6, [1024.0, 1.0, 0.25]))
    );
}

#[test]
fn order_does_not_depend_on_threads() {
    let brick = Brick::new(10);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("pool");
        pool.install(|| ordering(&brick))
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn graph_alone_suffices_when_all_points_coincide() {
    let brick = Brick::new(6);
    let (indptr, indices) = brick.graph();
    let points = vec![[0.0; 3]; brick.points.len()];
    let order = nested_dissection(&indptr, &indices, &points).expect("a graph");
    assert!(is_permutation(&order, points.len()));
    let natural = expand_to_unknowns(&(0..points.len()).collect::<Vec<_>>(), |node| {
        3 * node..3 * node + 3
    });
    let order = expand_to_unknowns(&order, |node| 3 * node..3 * node + 3);
    assert!(entries(&brick, order) < entries(&brick, natural));
}

#[test]
fn what_is_no_graph_is_refused() {
    let failure = Err(FactorError::NotAGraph { nodes: 2 });
    let points = [[0.0; 3]; 2];
    assert_eq!(nested_dissection(&[0, 1, 2], &[1, 2], &points), failure);
    assert_eq!(nested_dissection(&[0, 2, 1], &[1], &points), failure);
    assert_eq!(nested_dissection(&[0, 1], &[1], &points), failure);
    assert_eq!(nested_dissection(&[0], &[], &[]), Ok(vec![]));
}

proptest! {
    #[test]
    fn any_graph_gives_a_permutation(
        edges in prop::collection::vec((0..400_usize, 0..400_usize), 0..1500),
        seed in 0..1000_usize,
    ) {
        let mut lists = vec![vec![]; 400];
        edges.iter().for_each(|&(a, b)| lists[a].push(b));
        let mut indptr = vec![0];
        lists.iter().for_each(|list| indptr.push(indptr[indptr.len() - 1] + list.len()));
        let indices = lists.concat();
        let point = |i: usize| [(i * seed % 7) as f64, f64::NAN, (i * 31 % 11) as f64 * 1e200];
        let points: Vec<[f64; 3]> = (0..400).map(point).collect();
        prop_assert!(is_permutation(&nested_dissection(&indptr, &indices, &points).expect("a graph"), 400));
    }
}

#[test]
fn amd_is_a_permutation() {
    let stiffness = Brick::new(2).stiffness();
    let mut order = amd(&stiffness).expect("square");
    order.sort_unstable();
    assert!(order.iter().copied().eq(0..stiffness.cols));
}

#[test]
fn rectangles_are_refused() {
    let matrix = CscMatrix::empty(1);
    assert_eq!(
        amd(&matrix),
        Err(FactorError::NotSquare { rows: 1, cols: 0 })
    );
}

#[test]
fn empty_matrix_has_the_empty_ordering() {
    let matrix = CscMatrix::empty(0);
    assert_eq!(amd(&matrix), Ok(vec![]));
}
