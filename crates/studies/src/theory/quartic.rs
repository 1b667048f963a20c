//! The inverse inequality between L^∞ and L⁴ of Y^h, HKL (3.17).

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, DVector};

use super::face::{TriangulatedFace, distance};

/// Rings of nodes around a node that are added until its value settles to this share.
const SETTLED: f64 = 1e-10;
const MOST_RINGS: usize = 8;

/// Rings that decide whether the surroundings of two nodes are the same, and roundings of their places.
const ALIKE_RINGS: usize = 4;
const ALIKE: f64 = 1e-7;

/// Steps of Newton's method on one ring.
const MOST_STEPS: usize = 60;

/// Points of a rule on a triangle of area 1, exact for polynomials of degree 5 (J. Radon, *Monatsh. Math.* 52 (1948) 286).
pub(super) fn triangle_rule() -> [(f64, [f64; 3]); 7] {
    let root = 15.0_f64.sqrt();
    let rotated = |weight: f64, a: f64| {
        let b = 1.0 - 2.0 * a;
        [
            (weight, [b, a, a]),
            (weight, [a, b, a]),
            (weight, [a, a, b]),
        ]
    };
    let [p, q, r] = rotated((155.0 - root) / 1200.0, (6.0 - root) / 21.0);
    let [s, t, u] = rotated((155.0 + root) / 1200.0, (6.0 + root) / 21.0);
    [(9.0 / 40.0, [1.0 / 3.0; 3]), p, q, r, s, t, u]
}

/// c_inv⁽∞⁾ / √h: sup max|ψ| / ‖ψ‖_{0,4} over Y^h. A linear function on triangles is largest at a node, where a vector
/// field may be replaced by its component along its value; so it is one over the least norm of a function that is 1 at a node.
pub(super) fn largest_over_fourth(face: &TriangulatedFace) -> f64 {
    let surroundings = Surroundings::new(face);
    let mut known = BTreeSet::new();
    let free = face.free_nodes().into_iter();
    let distinct = free.filter(|&node| known.insert(surroundings.signature(node)));
    let least = distinct.map(|node| surroundings.least_fourth(node));
    least.fold(f64::INFINITY, f64::min).powf(-0.25)
}

/// A face with the triangles around each node.
struct Surroundings<'a> {
    face: &'a TriangulatedFace,
    star: Vec<Vec<usize>>,
    size: f64,
}

impl<'a> Surroundings<'a> {
    fn new(face: &'a TriangulatedFace) -> Self {
        Self {
            face,
            star: face.stars(),
            size: face.size(),
        }
    }

    /// The nodes at most so many edges away, by rings.
    fn rings(&self, node: usize, count: usize) -> Vec<Vec<usize>> {
        let mut seen = BTreeSet::from([node]);
        let mut rings = vec![vec![node]];
        for k in 0..count {
            let around = rings[k].iter().flat_map(|&n| &self.star[n]);
            let nodes: BTreeSet<usize> = around.flat_map(|&t| self.face.triangles[t]).collect();
            rings.push(nodes.into_iter().filter(|&n| seen.insert(n)).collect());
        }
        rings
    }

    /// The triangles around a node, moved to it: equal ones give equal minima.
    fn signature(&self, node: usize) -> Vec<[[i64; 3]; 3]> {
        let origin = self.face.points[node];
        let place = |n: usize| -> [i64; 3] {
            let held = i64::from(self.face.place[n].is_none());
            let x = self.face.points[n];
            let near = |c: usize| ((x[c] - origin[c]) / (ALIKE * self.size)).round() as i64;
            // Held nodes are moved out of the way of all others.
            [near(0) + held * (1 << 40), near(1), near(2)]
        };
        let nodes = self.rings(node, ALIKE_RINGS).into_iter().flatten();
        let triangles: BTreeSet<usize> = nodes.flat_map(|n| self.star[n].iter().copied()).collect();
        let mut signature: Vec<[[i64; 3]; 3]> = triangles
            .into_iter()
            .map(|t| {
                let mut corners = self.face.triangles[t].map(place);
                corners.sort_unstable();
                corners
            })
            .collect();
        signature.sort_unstable();
        signature
    }

    /// min ∫ψ⁴ over ψ ∈ Y^h with ψ = 1 at a node, in m², with more and more rings of nodes that do not vanish.
    fn least_fourth(&self, node: usize) -> f64 {
        let mut values = BTreeMap::from([(node, 1.0)]);
        let mut last = self.minimise(node, &mut values);
        for ring in self.rings(node, MOST_RINGS).into_iter().skip(1) {
            let free = ring.into_iter().filter(|&n| self.face.place[n].is_some());
            values.extend(free.map(|n| (n, 0.0)));
            let next = self.minimise(node, &mut values);
            if last - next <= SETTLED * next {
                return next;
            }
            last = next;
        }
        last
    }

    /// Newton's method with halving for the values other than that of the node.
    fn minimise(&self, node: usize, values: &mut BTreeMap<usize, f64>) -> f64 {
        let others: Vec<usize> = values.keys().copied().filter(|&n| n != node).collect();
        let (mut value, mut slope, mut curvature) = self.fourth_power(values, &others);
        for _ in 0..MOST_STEPS {
            let shift = f64::EPSILON * curvature.trace();
            let n = others.len();
            let shifted = &curvature + DMatrix::identity(n, n) * shift;
            let Some(step) = shifted.cholesky().map(|factor| factor.solve(&slope)) else {
                return value;
            };
            let mut share = 1.0;
            let (next, moved) = loop {
                let mut moved = values.clone();
                for (n, step) in others.iter().zip(step.iter()) {
                    *moved.entry(*n).or_insert(0.0) -= share * step;
                }
                let next = self.fourth_power(&moved, &others);
                if next.0 <= value || share < 1e-6 {
                    break (next, moved);
                }
                share *= 0.5;
            };
            let fell = value - next.0;
            if fell.is_nan() || fell <= 0.0 {
                return value;
            }
            *values = moved;
            (value, slope, curvature) = next;
            if fell <= f64::EPSILON * value {
                return value;
            }
        }
        value
    }

    /// ∫ψ⁴, its gradient and its Hessian by the values at `others`.
    fn fourth_power(
        &self,
        values: &BTreeMap<usize, f64>,
        others: &[usize],
    ) -> (f64, DVector<f64>, DMatrix<f64>) {
        let rule = triangle_rule();
        let n = others.len();
        let (mut total, mut slope) = (0.0, DVector::zeros(n));
        let mut curvature = DMatrix::zeros(n, n);
        let triangles: BTreeSet<usize> = values
            .keys()
            .flat_map(|&n| self.star[n].iter().copied())
            .collect();
        for t in triangles {
            let nodes = self.face.triangles[t];
            let area = self.face.area(t);
            let at = nodes.map(|n| others.binary_search(&n).ok());
            let local = nodes.map(|n| values.get(&n).copied().unwrap_or(0.0));
            for (weight, shape) in &rule {
                let psi: f64 = shape.iter().zip(local).map(|(s, v)| s * v).sum();
                let scale = area * weight;
                total += scale * psi.powi(4);
                for (a, i) in at.iter().enumerate() {
                    let Some(i) = *i else { continue };
                    slope[i] += 4.0 * scale * psi.powi(3) * shape[a];
                    for (b, j) in at.iter().enumerate() {
                        if let Some(j) = *j {
                            curvature[(i, j)] += 12.0 * scale * psi * psi * shape[a] * shape[b];
                        }
                    }
                }
            }
        }
        (total, slope, curvature)
    }
}

/// The largest distance of two points of a set.
pub(super) fn diameter(points: &[[f64; 3]]) -> f64 {
    let pairs = points.iter().enumerate().flat_map(|(i, a)| {
        let later = points[i + 1..].iter();
        later.map(|b| distance(*a, *b))
    });
    pairs.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_is_exact_to_degree_five() {
        // ∫ λ₀^i λ₁^j λ₂^k = 2 i! j! k! / (i + j + k + 2)! on a triangle of area 1.
        let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
        for (i, j, k) in [
            (0, 0, 0),
            (1, 0, 0),
            (2, 1, 0),
            (2, 2, 0),
            (4, 0, 0),
            (2, 2, 1),
            (5, 0, 0),
        ] {
            let exact = 2.0 * factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 2);
            let sum: f64 = triangle_rule()
                .iter()
                .map(|(w, s)| w * s[0].powi(i as i32) * s[1].powi(j as i32) * s[2].powi(k as i32))
                .sum();
            assert!((sum - exact).abs() < 1e-15, "{i} {j} {k}: {sum} {exact}");
        }
    }

    #[test]
    fn one_triangle_has_a_known_minimum() {
        // Values (1, b, b) on a triangle of area ½: minimise a polynomial of b by sampling.
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let face = TriangulatedFace::with_held(points, vec![[0, 1, 2]], |_| false);
        let power = |b: f64| -> f64 {
            // |T|/15 of the complete symmetric polynomial of degree 4 of (1, b, b).
            let complete: f64 = (0..=4).map(|k| f64::from(k + 1) * b.powi(k)).sum();
            0.5 / 15.0 * complete
        };
        let sampled = (-10_000..0)
            .map(|k| power(f64::from(k) * 1e-4))
            .fold(f64::INFINITY, f64::min);
        let constant = largest_over_fourth(&face);
        // Samples 1e-4 apart miss a minimum with unit curvature by 1e-9.
        assert!(
            (constant.powi(-4) / sampled - 1.0).abs() < 1e-7,
            "{constant}"
        );
    }
}
