//! Quadrature on triangles and tetrahedra: barycentric points and weights that sum to 1.
//!
//! Without another source rules are Gauss–Legendre products on collapsed coordinates.

use super::TETRAHEDRON_EDGES;

/// Abscissae and weights of the four-point Gauss–Legendre rule on (0, 1), exact to degree 7.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// 16 points on a triangle, exact for polynomials of degree 6.
pub fn triangle() -> impl Iterator<Item = ([f64; 3], f64)> {
    GAUSS.into_iter().flat_map(|(u, wu)| {
        GAUSS.into_iter().map(move |(v, wv)| {
            let rest = 1.0 - u;
            ([u, v * rest, (1.0 - v) * rest], 2.0 * wu * wv * rest)
        })
    })
}

/// Six points on a triangle, exact for polynomials of degree 4 (G. Strang, G. Fix, An analysis of the
/// finite element method, 1973, table 4.1).
pub fn triangle_4() -> impl Iterator<Item = ([f64; 3], f64)> {
    const ORBITS: [(f64, f64); 2] = [
        (0.445_948_490_915_965, 0.223_381_589_678_011),
        (0.091_576_213_509_771, 0.109_951_743_655_322),
    ];
    ORBITS.into_iter().flat_map(|(rest, weight)| {
        (0..3).map(move |k| {
            let at = |j| if j == k { 1.0 - 2.0 * rest } else { rest };
            (std::array::from_fn(at), weight)
        })
    })
}

/// 64 points on a tetrahedron, exact for polynomials of degree 5.
pub fn tetrahedron() -> impl Iterator<Item = ([f64; 4], f64)> {
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

/// [`tetrahedron_5`] on the eight parts of a tetrahedron whose edges are halved: its corners, and four around an axis of the octahedron between.
pub fn eight_tetrahedra() -> impl Iterator<Item = ([f64; 4], f64)> {
    let corner = |a: usize| std::array::from_fn(|k| if k == a { 1.0 } else { 0.0 });
    let middle = |[a, b]: [usize; 2]| -> [f64; 4] {
        std::array::from_fn(|k| if k == a || k == b { 0.5 } else { 0.0 })
    };
    let at_corner = move |a: usize| {
        let others = (0..4).filter(move |b| *b != a).map(move |b| middle([a, b]));
        let mut corners = [corner(a); 4];
        corners
            .iter_mut()
            .skip(1)
            .zip(others)
            .for_each(|(at, it)| *at = it);
        corners
    };
    const AROUND: [[usize; 2]; 4] = [[0, 2], [0, 3], [1, 3], [1, 2]];
    let inside = move |k: usize| {
        let [one, next] = [AROUND[k], AROUND[(k + 1) % 4]].map(middle);
        [middle([0, 1]), middle([2, 3]), one, next]
    };
    let parts = (0..4).map(at_corner).chain((0..4).map(inside));
    parts.flat_map(|part| {
        tetrahedron_5().map(move |(at, weight)| {
            let place = std::array::from_fn(|c| (0..4).map(|k| at[k] * part[k][c]).sum());
            (place, weight / 8.0)
        })
    })
}

/// Four points of a tetrahedron, exact for polynomials of degree 2: λ_k = (5 + 3√5)/20 at one corner,
/// (5 − √5)/20 at the others.
pub const TETRAHEDRON_2: [([f64; 4], f64); 4] = {
    let (far, near) = (0.138_196_601_125_010_5, 0.585_410_196_624_968_5);
    [
        ([near, far, far, far], 0.25),
        ([far, near, far, far], 0.25),
        ([far, far, near, far], 0.25),
        ([far, far, far, near], 0.25),
    ]
};

/// 14 points of a tetrahedron, exact for polynomials of degree 5 (N. J. Walkington, Quadrature on
/// simplices of arbitrary dimension, 2000).
pub fn tetrahedron_5() -> impl Iterator<Item = ([f64; 4], f64)> {
    const CORNERS: [(f64, f64); 2] = [
        (0.310_885_919_263_300_6, 0.112_687_925_718_015_85),
        (0.092_735_250_310_891_23, 0.073_493_043_116_361_94),
    ];
    const EDGE: (f64, f64) = (0.045_503_704_125_649_65, 0.042_546_020_777_081_47);
    let corners = CORNERS.into_iter().flat_map(|(rest, weight)| {
        (0..4).map(move |k| {
            let at = |j| if j == k { 1.0 - 3.0 * rest } else { rest };
            (std::array::from_fn(at), weight)
        })
    });
    let edges = TETRAHEDRON_EDGES.into_iter().map(|[a, b]| {
        let (rest, weight) = EDGE;
        let at = |j| if j == a || j == b { 0.5 - rest } else { rest };
        (std::array::from_fn(at), weight)
    });
    corners.chain(edges)
}

/// The point with given barycentric coordinates.
#[must_use]
pub fn point<const K: usize>(corners: &[[f64; 3]; K], weights: &[f64; K]) -> [f64; 3] {
    std::array::from_fn(|c| corners.iter().zip(weights).map(|(x, w)| w * x[c]).sum())
}
