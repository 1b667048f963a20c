//! The reference triangle and tetrahedron: edges, quadratic shape functions in barycentric coordinates, quadrature.

pub mod quadrature;

/// Corners of the six edges of a tetrahedron, in the order of its mid-edge nodes (that of VTK).
pub const TETRAHEDRON_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// Corners of the four sides of a tetrahedron, side k opposite to corner k.
pub const TETRAHEDRON_SIDES: [[usize; 3]; 4] = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];

/// Corners of the three edges of a triangle, in the order of its mid-edge nodes (that of VTK).
pub const TRIANGLE_EDGES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

/// Barycentric coordinates of the nodes of a quadratic triangle: its corners, then the middles of [`TRIANGLE_EDGES`].
pub(crate) const QUADRATIC_TRIANGLE_NODES: [[f64; 3]; 6] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.5],
    [0.5, 0.0, 0.5],
];

/// Values of the linear or quadratic shape functions of a simplex with K corners: those of the
/// corners, then those of the edges if `edges` lists any.
///
/// Quadratic ones are λ_a (2λ_a − 1) at corner a and 4 λ_a λ_b on the edge between a and b.
fn values<const K: usize, const E: usize, const N: usize>(
    edges: &[[usize; 2]; E],
    at: &[f64; K],
) -> [f64; N] {
    debug_assert_eq!(N, K + E, "a shape function for every corner and edge");
    std::array::from_fn(|k| match k.checked_sub(K) {
        None => at[k] * (2.0 * at[k] - 1.0),
        Some(e) => {
            let [a, b] = edges[e];
            4.0 * at[a] * at[b]
        }
    })
}

/// The ten quadratic shape functions of a tetrahedron at a point.
#[must_use]
pub fn quadratic_tetrahedron(at: &[f64; 4]) -> [f64; 10] {
    values(&TETRAHEDRON_EDGES, at)
}

/// The six quadratic shape functions of a triangle at a point.
pub(crate) fn quadratic_triangle(at: &[f64; 3]) -> [f64; 6] {
    values(&TRIANGLE_EDGES, at)
}

/// Derivatives of the quadratic shape functions by the barycentric coordinates, `[N][K]`.
fn derivatives<const K: usize, const E: usize, const N: usize>(
    edges: &[[usize; 2]; E],
    at: &[f64; K],
) -> [[f64; K]; N] {
    debug_assert_eq!(N, K + E, "a shape function for every corner and edge");
    std::array::from_fn(|k| {
        let mut slopes = [0.0; K];
        match k.checked_sub(K) {
            None => slopes[k] = 4.0 * at[k] - 1.0,
            Some(e) => {
                let [a, b] = edges[e];
                slopes[a] = 4.0 * at[b];
                slopes[b] = 4.0 * at[a];
            }
        }
        slopes
    })
}

/// ∂φ/∂λ_k of the ten quadratic shape functions of a tetrahedron at a point.
pub(crate) fn quadratic_tetrahedron_slopes(at: &[f64; 4]) -> [[f64; 4]; 10] {
    derivatives(&TETRAHEDRON_EDGES, at)
}

/// ∂φ/∂λ_k of the six quadratic shape functions of a triangle at a point.
pub(crate) fn quadratic_triangle_slopes(at: &[f64; 3]) -> [[f64; 3]; 6] {
    derivatives(&TRIANGLE_EDGES, at)
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINT: [f64; 4] = [0.1, 0.2, 0.3, 0.4];

    #[test]
    fn slopes_are_those_of_the_values() {
        const STEP: f64 = 1e-6;
        let slopes = quadratic_tetrahedron_slopes(&POINT);
        for corner in 0..4 {
            let moved = |by: f64| {
                let mut at = POINT;
                at[corner] += by;
                quadratic_tetrahedron(&at)
            };
            let (up, down) = (moved(STEP), moved(-STEP));
            for k in 0..10 {
                let difference = (up[k] - down[k]) / (2.0 * STEP);
                // Central differences of quadratics are exact but for roundings of 1e-16 over the step.
                assert!((difference - slopes[k][corner]).abs() < 1e-9);
            }
        }
    }
}
