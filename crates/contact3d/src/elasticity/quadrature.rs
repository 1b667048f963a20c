//! Gauss–Legendre products on collapsed coordinates: barycentric points and weights that sum to 1.

/// Abscissae and weights of the four-point Gauss–Legendre rule on (0, 1), exact to degree 7.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// 16 points on a triangle, exact for polynomials of degree 6.
pub(super) fn triangle() -> impl Iterator<Item = ([f64; 3], f64)> {
    GAUSS.into_iter().flat_map(|(u, wu)| {
        GAUSS.into_iter().map(move |(v, wv)| {
            let rest = 1.0 - u;
            ([u, v * rest, (1.0 - v) * rest], 2.0 * wu * wv * rest)
        })
    })
}

/// 64 points on a tetrahedron, exact for polynomials of degree 5.
pub(super) fn tetrahedron() -> impl Iterator<Item = ([f64; 4], f64)> {
    GAUSS.into_iter().flat_map(|(u, wu)| {
        triangle().map(move |([a, b, c], weight)| {
            let rest = 1.0 - u;
            (
                [u, a * rest, b * rest, c * rest],
                3.0 * wu * weight * rest * rest,
            )
        })
    })
}

/// The point with given barycentric coordinates.
pub(super) fn point<const K: usize>(corners: &[[f64; 3]; K], weights: &[f64; K]) -> [f64; 3] {
    std::array::from_fn(|c| corners.iter().zip(weights).map(|(x, w)| w * x[c]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn monomials_on_a_tetrahedron_are_exact() {
        for i in 0..=5 {
            for j in 0..=5 - i {
                let sum: f64 = tetrahedron()
                    .map(|(x, w)| w * x[0].powi(i) * x[3].powi(j))
                    .sum();
                let exact = 6.0 * factorial(i) * factorial(j) / factorial(i + j + 3);
                // Sixty-four roundings of numbers below 1.
                assert!((sum - exact).abs() < 1e-14, "{i} {j}");
            }
        }
    }
}
