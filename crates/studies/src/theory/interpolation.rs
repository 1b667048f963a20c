//! The approximation property (3.3) of interpolation on the contact face.

use std::collections::{BTreeMap, HashMap};

use nalgebra::Vector3;

use super::{
    dense::{inverse, largest_ratio},
    face::{TriangulatedFace, factorised, gradients, product, sum},
};
use crate::shared::matrix_of_columns;
use contact3d::linalg::{CscMatrix, add_scaled};

/// Points along each side of the square of cuts, and how often the square around the best is halved.
const GRID: usize = 33;
const HALVINGS: usize = 40;

/// An interpolation r_h on Y^h.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Interpolation {
    /// Values at the nodes.
    Lagrange,
    /// Means over the triangles around each node, HKL (3.19).
    Clement,
}

/// c_r of Lagrange interpolation where HKL (3.6) uses it, on |φ| of φ ∈ Y^h, triangle by triangle:
/// ‖ |φ| − r_h|φ| ‖_{0,Γ_c} ≤ c_r h ‖∇|φ|‖_{0,Γ_c}. On all of H¹(Γ_c) there is none, since point values are not bounded there.
pub(super) fn lagrange_on_absolute(face: &TriangulatedFace) -> f64 {
    let triangles = (0..face.triangles.len()).map(|t| on_triangle(&face.corners(t)));
    triangles.fold(0.0, f64::max).sqrt() / face.size()
}

/// The largest ‖|φ| − r_h|φ|‖² / ‖∇φ‖² on a triangle. If φ is −1 at one corner and cuts the edges there at shares s and t,
/// the difference is twice that of the negative part, whose norm is known.
fn on_triangle(corners: &[[f64; 3]; 3]) -> f64 {
    let gradients = gradients(corners);
    (0..3)
        .map(|corner| largest_on_square(|s, t| ratio_of_cut(&gradients, corner, s, t)))
        .fold(0.0, f64::max)
}

/// The ratio for one cut.
fn ratio_of_cut(gradients: &[Vector3<f64>; 3], corner: usize, s: f64, t: f64) -> f64 {
    let [next, last] = [1.0 / s - 1.0, 1.0 / t - 1.0];
    let slope =
        gradients[(corner + 1) % 3] * next + gradients[(corner + 2) % 3] * last - gradients[corner];
    2.0 / 3.0 * (1.0 - s * t * (3.0 - s - t)) / slope.norm_squared()
}

/// The largest value of a smooth function on (0, 1]².
fn largest_on_square(f: impl Fn(f64, f64) -> f64) -> f64 {
    let (mut centre, mut half) = ([0.5; 2], 0.5);
    let mut best = 0.0;
    for round in 0..HALVINGS {
        let points = if round == 0 { GRID } else { 5 };
        let along = |c: f64, k: usize| {
            let offset = 2.0 * k as f64 / (points - 1) as f64 - 1.0;
            (c + half * offset).clamp(1e-9, 1.0)
        };
        let around = centre;
        for (i, j) in (0..points * points).map(|k| (k / points, k % points)) {
            let (s, t) = (along(around[0], i), along(around[1], j));
            let value = f(s, t);
            if value > best {
                (best, centre) = (value, [s, t]);
            }
        }
        half *= if round == 0 {
            2.0 / (GRID - 1) as f64
        } else {
            0.5
        };
    }
    best
}

/// c_r of (3.3) on the linear functions of a mesh whose triangles are cut in `parts`² equal ones:
/// sup ‖φ − r_hφ‖_{0,Γ_c} / (h ‖φ‖_{1,Γ_c}); `None` where the forms have no factor.
pub(super) fn on_finer_functions(
    face: &TriangulatedFace,
    parts: usize,
    interpolation: Interpolation,
) -> Option<f64> {
    let cut = CutFace::new(face, parts);
    let forms = cut.fine.forms();
    let factor = factorised(&sum(&forms.mass, &forms.stiffness))?;
    let coarse = cut.interpolation(interpolation);
    let apply = |values: &[f64]| {
        let mut error = values.to_vec();
        add_scaled(&mut error, -1.0, &cut.prolong(&product(&coarse, values)));
        let weighted = product(&forms.mass, &error);
        let mut image = weighted.clone();
        let mut back = vec![0.0; coarse.rows];
        coarse.mul(&cut.restrict(&weighted), &mut back);
        add_scaled(&mut image, -1.0, &back);
        image
    };
    let square = largest_ratio(cut.fine.n_free(), apply, inverse(&factor));
    Some(square.sqrt() / face.size())
}

/// A face with each triangle cut in equal ones.
struct CutFace<'a> {
    fine: TriangulatedFace,
    /// Coarse nodes and barycentric weights of each fine node.
    origin: Vec<Vec<(usize, f64)>>,
    /// Fine triangles of each coarse one.
    children: Vec<Vec<usize>>,
    coarse: &'a TriangulatedFace,
}

impl<'a> CutFace<'a> {
    fn new(face: &'a TriangulatedFace, parts: usize) -> Self {
        let mut numbers: HashMap<Vec<(usize, usize)>, usize> = HashMap::new();
        let mut origin: Vec<Vec<(usize, f64)>> = Vec::new();
        let mut triangles = Vec::new();
        let mut children = vec![Vec::new(); face.triangles.len()];
        for (t, corners) in face.triangles.iter().enumerate() {
            let mut number = |i: usize, j: usize| {
                let weights = [parts - i - j, i, j];
                let pairs = corners.iter().copied().zip(weights);
                let mut key: Vec<(usize, usize)> = pairs.filter(|(_, w)| *w > 0).collect();
                key.sort_unstable();
                let next = numbers.len();
                *numbers.entry(key).or_insert_with_key(|key| {
                    let share = |w: usize| w as f64 / parts as f64;
                    origin.push(key.iter().map(|&(n, w)| (n, share(w))).collect());
                    next
                })
            };
            for (i, j) in (0..parts).flat_map(|i| (0..parts - i).map(move |j| (i, j))) {
                children[t].push(triangles.len());
                triangles.push([number(i, j), number(i + 1, j), number(i, j + 1)]);
                if i + j + 1 < parts {
                    children[t].push(triangles.len());
                    triangles.push([number(i + 1, j + 1), number(i, j + 1), number(i + 1, j)]);
                }
            }
        }
        let at = |weights: &Vec<(usize, f64)>| {
            std::array::from_fn(|c| weights.iter().map(|&(n, w)| w * face.points[n][c]).sum())
        };
        let points = origin.iter().map(at).collect();
        let is_held = |node: usize| origin[node].iter().all(|&(n, _)| face.place[n].is_none());
        Self {
            fine: TriangulatedFace::with_held(points, triangles, is_held),
            children,
            coarse: face,
            origin,
        }
    }

    /// Columns: the functional of each free coarse node on fine functions, `[n_fine_free, n_coarse_free]`.
    fn interpolation(&self, interpolation: Interpolation) -> CscMatrix {
        let stars = self.coarse.stars();
        let functionals = self
            .coarse
            .free_nodes()
            .into_iter()
            .map(|node| match interpolation {
                Interpolation::Lagrange => self.point_value(node),
                Interpolation::Clement => self.mean(&stars[node]),
            });
        matrix_of_columns(self.fine.n_free(), functionals)
    }

    fn point_value(&self, node: usize) -> Vec<(usize, f64)> {
        let mut origins = self.origin.iter();
        let found = origins.position(|weights| *weights == [(node, 1.0)]);
        let place = found.and_then(|fine| self.fine.place[fine]);
        place.map(|fine| (fine, 1.0)).into_iter().collect()
    }

    /// The mean over coarse triangles.
    fn mean(&self, triangles: &[usize]) -> Vec<(usize, f64)> {
        let mut integrals = BTreeMap::new();
        let mut whole = 0.0;
        for &child in triangles.iter().flat_map(|&t| &self.children[t]) {
            let area = self.fine.area(child);
            whole += area;
            for node in self.fine.triangles[child] {
                if let Some(place) = self.fine.place[node] {
                    *integrals.entry(place).or_insert(0.0) += area / 3.0;
                }
            }
        }
        let integrals = integrals.into_iter();
        integrals
            .map(|(n, integral)| (n, integral / whole))
            .collect()
    }

    /// The coarse function of values at the free coarse nodes, at the free fine nodes.
    fn prolong(&self, coarse: &[f64]) -> Vec<f64> {
        self.fine.to_free(|fine| {
            let weights = self.origin[fine].iter();
            let known = weights.filter_map(|&(n, w)| Some(w * coarse[self.coarse.place[n]?]));
            known.sum()
        })
    }

    /// The transpose of [`Self::prolong`].
    fn restrict(&self, fine: &[f64]) -> Vec<f64> {
        let mut coarse = vec![0.0; self.coarse.n_free()];
        for (weights, place) in self.origin.iter().zip(&self.fine.place) {
            let Some(place) = *place else { continue };
            for &(node, weight) in weights {
                if let Some(node) = self.coarse.place[node] {
                    coarse[node] += weight * fine[place];
                }
            }
        }
        coarse
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn right_triangle() -> [[f64; 3]; 3] {
        [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    }

    #[test]
    fn the_difference_of_an_absolute_value_has_its_closed_form() {
        // φ = −1, a, b at the corners; the integral by sampling at midpoints of 4·10⁶ small squares.
        let (s, t) = (0.6, 0.25);
        let (a, b) = (1.0 / s - 1.0, 1.0 / t - 1.0);
        let n = 1000;
        let mut sum = 0.0;
        for (i, j) in (0..n * n)
            .map(|k| (k / n, k % n))
            .filter(|(i, j)| i + j < n)
        {
            let (x, y) = ((i as f64 + 0.5) / n as f64, (j as f64 + 0.5) / n as f64);
            if x + y < 1.0 {
                let phi = -(1.0 - x - y) + a * x + b * y;
                let nodal = (1.0 - x - y) + a * x + b * y;
                sum += (phi.abs() - nodal).powi(2) / (n * n) as f64;
            }
        }
        let closed = 2.0 / 3.0 * 0.5 * (1.0 - s * t * (3.0 - s - t));
        // Squares on the diagonal are counted whole or not at all: an error of 1/n.
        assert!((sum / closed - 1.0).abs() < 5e-3, "{sum} {closed}");
    }

    #[test]
    fn the_constant_of_a_triangle_bounds_samples_and_is_attained() {
        let constant = on_triangle(&right_triangle());
        let gradients = gradients(&right_triangle());
        let mut best: f64 = 0.0;
        for (i, j) in (1..=200).flat_map(|i| (1..=200).map(move |j| (i, j))) {
            let (s, t) = (f64::from(i) / 200.0, f64::from(j) / 200.0);
            for corner in 0..3 {
                let ratio = ratio_of_cut(&gradients, corner, s, t);
                assert!(ratio <= constant * (1.0 + 1e-12));
                best = best.max(ratio);
            }
        }
        // Samples 0.005 apart miss a smooth maximum by some 1e-5.
        assert!(best > constant * (1.0 - 1e-4), "{best} {constant}");
    }

    #[test]
    fn interpolation_reproduces_coarse_functions() {
        let corners = right_triangle().to_vec();
        let face = TriangulatedFace::with_held(corners, vec![[0, 1, 2]], |_| false);
        let cut = CutFace::new(&face, 4);
        assert_eq!((cut.fine.points.len(), cut.fine.triangles.len()), (15, 16));
        let lagrange = cut.interpolation(Interpolation::Lagrange);
        let coarse = [1.0, -2.0, 3.0];
        assert_eq!(product(&lagrange, &cut.prolong(&coarse)), coarse);
        // The mean of a linear function over the only triangle is that of its corners.
        let clement = cut.interpolation(Interpolation::Clement);
        let means = product(&clement, &cut.prolong(&coarse));
        assert!(
            means.iter().all(|mean| (mean - 2.0 / 3.0).abs() < 1e-14),
            "{means:?}"
        );
    }
}
