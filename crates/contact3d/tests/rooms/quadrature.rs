//! Rules of integration against monomials, and shape functions at their nodes.

use contact3d::reference::{TETRAHEDRON_EDGES, quadratic_tetrahedron, quadrature::*};

fn factorial(n: i32) -> f64 {
    (1..=n).map(f64::from).product()
}

#[test]
fn monomials_on_a_triangle_are_exact() {
    for i in 0..=6 {
        for j in 0..=6 - i {
            let sum: f64 = triangle()
                .map(|(x, w)| w * x[0].powi(i) * x[2].powi(j))
                .sum();
            let exact = 2.0 * factorial(i) * factorial(j) / factorial(i + j + 2);
            // Sixteen roundings of numbers below 1.
            assert!((sum - exact).abs() < 1e-15, "{i} {j}");
        }
    }
}

#[test]
fn six_points_on_a_triangle_are_exact_to_degree_four() {
    for i in 0..=4 {
        for j in 0..=4 - i {
            let sum: f64 = triangle_4()
                .map(|(x, w)| w * x[0].powi(i) * x[2].powi(j))
                .sum();
            let exact = 2.0 * factorial(i) * factorial(j) / factorial(i + j + 2);
            // The constants have fifteen digits.
            assert!((sum - exact).abs() < 1e-14, "{i} {j}");
        }
    }
}

fn assert_exact_on_a_tetrahedron(rule: &[([f64; 4], f64)], degree: i32) {
    for i in 0..=degree {
        for j in 0..=degree - i {
            for k in 0..=degree - i - j {
                let monomial = |x: &[f64; 4]| x[0].powi(i) * x[1].powi(j) * x[3].powi(k);
                let sum: f64 = rule.iter().map(|(x, w)| w * monomial(x)).sum();
                let exact =
                    6.0 * factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 3);
                // Up to sixty-four roundings of numbers below 1.
                assert!((sum - exact).abs() < 1e-14, "{i} {j} {k}");
            }
        }
    }
}

#[test]
fn monomials_on_a_tetrahedron_are_exact() {
    assert_exact_on_a_tetrahedron(&tetrahedron().collect::<Vec<_>>(), 5);
    assert_exact_on_a_tetrahedron(&TETRAHEDRON_2, 2);
    assert_exact_on_a_tetrahedron(&tetrahedron_5().collect::<Vec<_>>(), 5);
    assert_exact_on_a_tetrahedron(&eight_tetrahedra().collect::<Vec<_>>(), 5);
}

#[test]
fn quadratic_functions_are_one_at_their_node_and_sum_to_one() {
    let corners = (0..4).map(|k| (k, [k, k]));
    for (k, node) in corners.chain((4..).zip(TETRAHEDRON_EDGES)) {
        let mut at = [0.0; 4];
        node.iter().for_each(|&corner| at[corner] += 0.5);
        let values = quadratic_tetrahedron(&at);
        assert!((0..10).all(|j| values[j] == f64::from(u8::from(j == k))));
    }
    let sum: f64 = quadratic_tetrahedron(&[0.1, 0.2, 0.3, 0.4]).iter().sum();
    // Ten roundings of numbers below 1.
    assert!((sum - 1.0).abs() < 1e-15);
}
