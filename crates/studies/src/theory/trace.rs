//! Norms of the trace of V^h on the contact face.

use faer::Mat;
use nalgebra::Vector3;

use super::{
    dense::{largest, largest_ratio},
    face::{ElementSums, FaceForms, FaceGram, TriangulatedFace},
    quartic::triangle_rule,
};
use contact3d::{
    elasticity::DofMap,
    linalg::{CscMatrix, dot, norm},
    mesh::{Mesh, tetrahedron_volume},
};

/// Steps of one ascent, and the growth at which it ends.
const MOST_ASCENTS: usize = 500;
const SETTLED: f64 = 1e-12;

/// Nodes whose point loads start an ascent.
const POINT_STARTS: usize = 6;

/// Bounds of the trace of v ∈ V^h on Γ_c by ‖v‖.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TraceConstants {
    /// c_tr⁽²⁾: ‖v‖_{0,Γ_c} ≤ c ‖v‖, below HKL's norm on all of H¹(Ω)³ and ∂Ω.
    pub second: f64,
    /// c_tr⁽⁴⁾: ‖v‖_{0,4,Γ_c} ≤ c ‖v‖; the best local maximum of an ascent from several starts, so a lower bound.
    pub fourth: f64,
    /// max |v| ≤ c ‖v‖ on Γ_c, in place of c_inv⁽∞⁾ c_tr⁽⁴⁾ / √h.
    pub pointwise: f64,
    /// ‖(r_h|v_t1|, r_h|v_t2|)‖_{0,Γ_c} ≤ c ‖v‖ for Lagrange interpolation, from the lumped mass, in place of
    /// c_tr⁽²⁾ (c_inv⁽¹'⁰⁾ c_r c_t + 1).
    pub interpolated: f64,
    /// The same for Clément's interpolation, which does not increase this bound of the norm: ‖v_t‖_{0,Γ_c} ≤ c ‖v‖.
    pub tangential: f64,
}

impl TraceConstants {
    pub(super) fn new(gram: &FaceGram, face: &TriangulatedFace, forms: &FaceForms) -> Self {
        let lumped = face.lumped();
        let mass = |values: &[f64]| face.mass_product(&forms.mass, values, 3);
        let of_tangential = |form: &dyn Fn(&[f64]) -> Vec<f64>| {
            let tangential =
                |values: &[f64]| without_normal(form(&without_normal(values.to_vec())));
            largest_ratio(3 * gram.n_nodes(), tangential, |f| gram.apply(&f)).sqrt()
        };
        let weighted = |values: &[f64]| -> Vec<f64> {
            let values = values.iter().enumerate();
            values.map(|(i, v)| lumped[i / 3] * v).collect()
        };
        Self {
            second: largest_ratio(3 * gram.n_nodes(), mass, |f| gram.apply(&f)).sqrt(),
            fourth: fourth(gram, face),
            pointwise: pointwise(gram).into_iter().fold(0.0, f64::max).sqrt(),
            interpolated: of_tangential(&weighted),
            tangential: of_tangential(&mass),
        }
    }
}

fn without_normal(mut values: Vec<f64>) -> Vec<f64> {
    values.iter_mut().step_by(3).for_each(|v| *v = 0.0);
    values
}

/// sup |v(x)|²/‖v‖² at each node: the largest eigenvalue of its block.
fn pointwise(gram: &FaceGram) -> Vec<f64> {
    let block = |node| Mat::from_fn(3, 3, |c, d| gram.entry([node, c], [node, d]));
    (0..gram.n_nodes())
        .map(|node| largest(&block(node)))
        .collect()
}

/// The largest ‖v‖_{0,4} over ‖v‖ = 1 that ascents find: v ← X⁻¹f'(v), normed, increases the convex f = ‖v‖⁴.
fn fourth(gram: &FaceGram, face: &TriangulatedFace) -> f64 {
    let peaks = pointwise(gram);
    let mut nodes: Vec<usize> = (0..peaks.len()).collect();
    nodes.sort_by(|a, b| peaks[*b].total_cmp(&peaks[*a]).then(a.cmp(b)));
    let every = nodes.len().div_ceil(POINT_STARTS).max(1);
    let points = nodes
        .iter()
        .step_by(every)
        .map(|node| 3 * node..3 * node + 1);
    let everywhere = (0..3).map(|c| c..3 * peaks.len());
    let reached = everywhere.chain(points).map(|places| {
        let mut start = vec![0.0; 3 * peaks.len()];
        places.step_by(3).for_each(|place| start[place] = 1.0);
        ascend(gram, face, start)
    });
    reached.fold(0.0, f64::max).powf(0.25)
}

/// The largest f = ∫|v|⁴ over ‖v‖ = 1 on the way up from nodal forces.
fn ascend(gram: &FaceGram, face: &TriangulatedFace, mut forces: Vec<f64>) -> f64 {
    let mut last = 0.0;
    for _ in 0..MOST_ASCENTS {
        let size = norm(&forces);
        if size == 0.0 {
            return last;
        }
        forces.iter_mut().for_each(|f| *f /= size);
        let moved = gram.apply(&forces);
        let length = dot(&moved, &forces).sqrt();
        if length.is_nan() || length == 0.0 {
            return last;
        }
        let values: Vec<f64> = moved.iter().map(|v| v / length).collect();
        let (value, slope) = fourth_power(face, &values);
        if value - last <= SETTLED * value {
            return value.max(last);
        }
        (last, forces) = (value, slope);
    }
    last
}

/// ∫|v|⁴ over the face and a quarter of its gradient.
fn fourth_power(face: &TriangulatedFace, values: &[f64]) -> (f64, Vec<f64>) {
    let rule = triangle_rule();
    let (mut total, mut slope) = (0.0, vec![0.0; values.len()]);
    for (t, nodes) in face.triangles.iter().enumerate() {
        let area = face.area(t);
        for (weight, shape) in &rule {
            let at: [f64; 3] = std::array::from_fn(|c| {
                let terms = nodes.iter().zip(shape);
                terms.map(|(n, s)| s * values[3 * n + c]).sum()
            });
            let square: f64 = at.iter().map(|v| v * v).sum();
            total += area * weight * square * square;
            for (n, s) in nodes.iter().zip(shape) {
                for c in 0..3 {
                    slope[3 * n + c] += area * weight * s * square * at[c];
                }
            }
        }
    }
    (total, slope)
}

/// ∫ u·v + ∫ ∇u:∇v over the free degrees of freedom of linear tetrahedra, `[n_free, n_free]`; lengths in the unit of
/// the scene, which decides what the first term weighs beside the second.
pub(super) fn first_sobolev_gram(mesh: &Mesh, dofs: &DofMap) -> CscMatrix {
    let mut gram = ElementSums::new(dofs.n_free);
    for nodes in &mesh.tetrahedra {
        let corners = mesh.corners(nodes);
        let volume = tetrahedron_volume(&corners);
        let gradients = gradients(&corners, volume);
        for (a, &row) in nodes.iter().enumerate() {
            for (b, &column) in nodes.iter().enumerate() {
                // ∫ λ_a λ_b = V/20, and V/10 for a = b.
                let mass = volume / if a == b { 10.0 } else { 20.0 };
                let value = mass + volume * gradients[a].dot(&gradients[b]);
                for (row, column) in dofs.dof[row].iter().zip(dofs.dof[column]) {
                    if let (Some(row), Some(column)) = (*row, column) {
                        gram.add(row, column, value);
                    }
                }
            }
        }
    }
    gram.matrix()
}

/// Gradients of the four barycentric coordinates: inward normals of the faces, their length area/(3 V).
fn gradients(corners: &[[f64; 3]; 4], volume: f64) -> [Vector3<f64>; 4] {
    let [a, b, c, d] = corners.map(Vector3::from);
    let scale = 1.0 / (6.0 * volume);
    let first = (c - a).cross(&(d - a)) * scale;
    let second = (d - a).cross(&(b - a)) * scale;
    let third = (b - a).cross(&(c - a)) * scale;
    [-(first + second + third), first, second, third]
}

/// The logarithm of the ratio of two weights is searched this far to both sides, to an accuracy whose square is rounding.
const REACH: f64 = 40.0;
const VALLEY: f64 = 1e-6;

/// ‖μ‖ with ‖μ‖² = μᵀFμ.
pub(super) fn norm_by(form: &Mat<f64>, multiplier: &[f64]) -> f64 {
    let terms = (0..form.ncols()).map(|j| {
        let column = (0..form.nrows()).map(|i| form[(i, j)] * multiplier[i]);
        multiplier[j] * column.sum::<f64>()
    });
    terms.sum::<f64>().max(0.0).sqrt()
}

/// Norms of the four parts of Ψ′: how much slip and pressure move with slip and pressure.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PartNorms {
    /// ‖∂φ′/∂φ‖.
    pub slip_by_slip: f64,
    /// ‖∂φ′/∂g‖.
    pub slip_by_pressure: f64,
    /// ‖∂λ_ν′/∂φ‖.
    pub pressure_by_slip: f64,
    /// ‖∂λ_ν′/∂g‖.
    pub pressure_by_pressure: f64,
}

impl PartNorms {
    /// The largest eigenvalue of the 2 × 2 matrix of the norms: the least bound of ‖Ψ′‖ in w ‖φ‖ + ‖μ‖ over all weights w,
    /// as far as norms of parts tell.
    #[must_use]
    pub fn weighted(self) -> f64 {
        let (a, d) = (self.slip_by_slip, self.pressure_by_pressure);
        let mixed = self.slip_by_pressure * self.pressure_by_slip;
        0.5 * (a + d) + (0.25 * (a - d) * (a - d) + mixed).sqrt()
    }

    /// The weight w for which w ‖φ‖ + ‖μ‖ has that bound; 0 where nothing depends on the slip.
    #[must_use]
    pub fn weight(self) -> f64 {
        let rest = self.weighted() - self.slip_by_slip;
        if self.pressure_by_slip == 0.0 || rest <= 0.0 {
            return 0.0;
        }
        self.pressure_by_slip / rest
    }
}

/// The squared norms of the slip and of the pressure that Ψ′ makes of unit vectors, of slip, and of pressure.
pub(super) type Blocks = [[Mat<f64>; 2]; 2];

pub(super) fn part_norms([by_slip, by_pressure]: &Blocks) -> PartNorms {
    let norm = |form: &Mat<f64>| largest(form).max(0.0).sqrt();
    PartNorms {
        slip_by_slip: norm(&by_slip[0]),
        pressure_by_slip: norm(&by_slip[1]),
        slip_by_pressure: norm(&by_pressure[0]),
        pressure_by_pressure: norm(&by_pressure[1]),
    }
}

/// The norm on the sum: the unit ball of ‖φ‖ + ‖μ‖ is the convex hull of the two unit balls.
pub(super) fn norm_on_sum([by_slip, by_pressure]: &Blocks) -> f64 {
    sum_norm(by_slip).max(sum_norm(by_pressure))
}

/// sup √(xᵀAx) + √(xᵀBx) over |x| = 1: the least λ_max(A/s + B/(1−s)) over 0 < s < 1, squared, since the pairs (xᵀAx, xᵀBx)
/// fill a convex set (L. Brickman, *Proc. Am. Math. Soc.* 12 (1961) 61).
fn sum_norm([first, second]: &[Mat<f64>; 2]) -> f64 {
    if first.nrows() == 0 {
        return 0.0;
    }
    let bound = |logit: f64| {
        let weights = [1.0 + (-logit).exp(), 1.0 + logit.exp()];
        let sum = Mat::from_fn(first.nrows(), first.nrows(), |i, j| {
            first[(i, j)] * weights[0] + second[(i, j)] * weights[1]
        });
        largest(&sum)
    };
    // At the best share s/(1 − s) = √(xᵀAx / xᵀBx): the logarithm of that is searched around its value for the largest of each.
    let size = |form: &Mat<f64>| largest(form).max(f64::MIN_POSITIVE).ln();
    let middle = 0.5 * (size(first) - size(second));
    least_by_golden_section(middle - REACH, middle + REACH, bound)
        .max(0.0)
        .sqrt()
}

/// The least value of a function with one valley.
fn least_by_golden_section(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let mut at = [high - golden * (high - low), low + golden * (high - low)];
    let mut values = at.map(&f);
    while high - low > VALLEY {
        if values[0] <= values[1] {
            high = at[1];
            (at[1], values[1]) = (at[0], values[0]);
            at[0] = high - golden * (high - low);
            values[0] = f(at[0]);
        } else {
            low = at[0];
            (at[0], values[0]) = (at[1], values[1]);
            at[1] = low + golden * (high - low);
            values[1] = f(at[1]);
        }
    }
    values[0].min(values[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::theory::face::product;
    use contact3d::scene::{Body, Material, Scene};

    #[test]
    fn the_norm_of_linear_fields_is_known() {
        let body = Body::brick([2.0, 1.0, 1.0], [2, 2, 2]);
        let scene = Scene::new(body, Material::isotropic(1.0, 0.3));
        let mesh = Mesh::of_scene(&scene, std::path::Path::new("")).expect("a brick");
        let dofs = DofMap::new(&vec![[false; 3]; mesh.coordinates.len()]);
        let gram = first_sobolev_gram(&mesh, &dofs);
        // u = (x, 0, 2): ∫ x² + 4 + 1 over (0,2)×(0,1)² = 8/3 + 8 + 2.
        let field: Vec<[f64; 3]> = mesh.coordinates.iter().map(|x| [x[0], 0.0, 2.0]).collect();
        let field = dofs.to_free(&field);
        let square = dot(&field, &product(&gram, &field));
        assert!((square - (8.0 / 3.0 + 10.0)).abs() < 1e-12, "{square}");
    }
}
