//! The polynomials a quadratic tetrahedron is enriched by: P3 without P2, those cubic ones that
//! vanish at its ten nodes: λ_a λ_b (λ_a − λ_b) on the six edges, λ_a λ_b λ_c on the four sides.

use std::sync::LazyLock;

use crate::reference::{TETRAHEDRON_EDGES, quadrature};

/// Corners of the four sides, side k opposite to corner k.
pub(super) const SIDES: [[usize; 3]; 4] = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];

/// Number of bubbles.
pub(super) const BUBBLES: usize = 10;

/// mean ∂φ_α/∂λ_k ∂φ_β/∂λ_l over a tetrahedron as `[α][β][k][l]`.
pub(super) type SlopeProducts = [[[[f64; 4]; 4]; BUBBLES]; BUBBLES];

/// The bubbles at a point in barycentric coordinates.
pub(super) fn values(at: &[f64; 4]) -> [f64; BUBBLES] {
    std::array::from_fn(|function| match function.checked_sub(6) {
        None => {
            let [a, b] = TETRAHEDRON_EDGES[function];
            at[a] * at[b] * (at[a] - at[b])
        }
        Some(side) => SIDES[side].iter().map(|&corner| at[corner]).product(),
    })
}

/// Their slopes by the barycentric coordinates.
pub(super) fn slopes(at: &[f64; 4]) -> [[f64; 4]; BUBBLES] {
    std::array::from_fn(|function| {
        let mut slope = [0.0; 4];
        match function.checked_sub(6) {
            None => {
                let [a, b] = TETRAHEDRON_EDGES[function];
                slope[a] = at[b] * (2.0 * at[a] - at[b]);
                slope[b] = at[a] * (at[a] - 2.0 * at[b]);
            }
            Some(side) => {
                let [a, b, c] = SIDES[side];
                slope[a] = at[b] * at[c];
                slope[b] = at[a] * at[c];
                slope[c] = at[a] * at[b];
            }
        }
        slope
    })
}

/// Whether a bubble vanishes on the side opposite to a corner.
pub(super) fn vanishes_on(function: usize, side: usize) -> bool {
    match function.checked_sub(6) {
        None => TETRAHEDRON_EDGES[function].contains(&side),
        Some(own) => own != side,
    }
}

/// Means of products of slopes; the rule of degree 5 is exact for these of degree 4.
pub(super) static SLOPE_PRODUCTS: LazyLock<SlopeProducts> = LazyLock::new(|| {
    let mut products = [[[[0.0; 4]; 4]; BUBBLES]; BUBBLES];
    for (at, weight) in quadrature::tetrahedron_5() {
        let slopes = slopes(&at);
        for (first, row) in slopes.iter().zip(&mut products) {
            for (second, entry) in slopes.iter().zip(row) {
                for (k, line) in entry.iter_mut().enumerate() {
                    for (l, value) in line.iter_mut().enumerate() {
                        *value += weight * first[k] * second[l];
                    }
                }
            }
        }
    }
    products
});

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::shape::quadratic_tetrahedron;

    #[test]
    fn bubbles_vanish_at_the_nodes_of_the_element() {
        let corner = |k: usize| std::array::from_fn(|j| f64::from(u8::from(j == k)));
        let middle =
            |ends: [usize; 2]| std::array::from_fn(|j| if ends.contains(&j) { 0.5 } else { 0.0 });
        let nodes = (0..4).map(corner).chain(TETRAHEDRON_EDGES.map(middle));
        for node in nodes {
            assert_eq!(values(&node), [0.0; BUBBLES]);
        }
    }

    #[test]
    fn slopes_are_those_of_the_values() {
        const STEP: f64 = 1e-6;
        let at = [0.1, 0.2, 0.3, 0.4];
        let slopes = slopes(&at);
        for corner in 0..4 {
            let moved = |by: f64| {
                let mut at = at;
                at[corner] += by;
                values(&at)
            };
            let (up, down) = (moved(STEP), moved(-STEP));
            for (k, slope) in slopes.iter().enumerate() {
                let difference = (up[k] - down[k]) / (2.0 * STEP);
                // Roundings of 1e-17 over the step, and its square.
                assert!((difference - slope[corner]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn sides_on_which_bubbles_vanish() {
        for side in 0..4 {
            let mut at = [0.2, 0.3, 0.4, 0.1];
            at[side] = 0.0;
            for (k, value) in values(&at).iter().enumerate() {
                assert_eq!(vanishes_on(k, side), *value == 0.0, "{k} {side}");
            }
        }
    }

    #[test]
    fn bubbles_and_quadratic_functions_are_independent() {
        // Twenty points in general position.
        let point = |k: usize| {
            let (s, t) = (0.21 + 0.031 * k as f64, 0.17 + 0.013 * (k * k % 17) as f64);
            let u = 0.11 + 0.019 * (k * k * k % 23) as f64;
            [s, t, u, 1.0 - s - t - u]
        };
        let rows = nalgebra::DMatrix::from_fn(20, 20, |i, j| match j.checked_sub(10) {
            None => quadratic_tetrahedron(&point(i))[j],
            Some(bubble) => values(&point(i))[bubble],
        });
        assert_eq!(rows.rank(1e-9), 20);
    }
}
