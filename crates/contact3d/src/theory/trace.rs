//! Norms of the trace of V^h on the contact face.

use faer::Mat;

use super::{
    dense,
    face::{Face, FaceForms},
    face_gram::FaceGram,
    pencil::largest_ratio,
    quartic::triangle_rule,
    scatter::product,
};
use crate::linalg::{dot, norm};

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
    pub(super) fn new(gram: &FaceGram, face: &Face, forms: &FaceForms) -> Self {
        let lumped = face.lumped();
        let mass = |values: &[f64]| mass_product(face, forms, values);
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

/// M_Γ of each component of a field at the contact nodes.
fn mass_product(face: &Face, forms: &FaceForms, values: &[f64]) -> Vec<f64> {
    let mut image = vec![0.0; values.len()];
    for c in 0..3 {
        let free = product(&forms.mass, &face.to_free(|node| values[3 * node + c]));
        for (node, place) in face.place.iter().enumerate() {
            image[3 * node + c] = place.map_or(0.0, |p| free[p]);
        }
    }
    image
}

fn without_normal(mut values: Vec<f64>) -> Vec<f64> {
    values.iter_mut().step_by(3).for_each(|v| *v = 0.0);
    values
}

/// sup |v(x)|²/‖v‖² at each node: the largest eigenvalue of its block.
fn pointwise(gram: &FaceGram) -> Vec<f64> {
    let block = |node| Mat::from_fn(3, 3, |c, d| gram.entry([node, c], [node, d]));
    (0..gram.n_nodes())
        .map(|node| dense::largest(&block(node)))
        .collect()
}

/// The largest ‖v‖_{0,4} over ‖v‖ = 1 that ascents find: v ← X⁻¹f'(v), normed, increases the convex f = ‖v‖⁴.
fn fourth(gram: &FaceGram, face: &Face) -> f64 {
    let peaks = pointwise(gram);
    let mut nodes: Vec<usize> = (0..peaks.len()).collect();
    nodes.sort_by(|a, b| peaks[*b].total_cmp(&peaks[*a]).then(a.cmp(b)));
    let spread = |c: usize| {
        let mut start = vec![0.0; 3 * peaks.len()];
        start.iter_mut().skip(c).step_by(3).for_each(|v| *v = 1.0);
        start
    };
    let point = |&node: &usize| {
        let mut start = vec![0.0; 3 * peaks.len()];
        start[3 * node] = 1.0;
        start
    };
    let every = nodes.len().div_ceil(POINT_STARTS).max(1);
    let points = nodes.iter().step_by(every).map(point);
    let starts = (0..3).map(spread).chain(points);
    let reached = starts.map(|start| ascend(gram, face, start));
    reached.fold(0.0, f64::max).powf(0.25)
}

/// The largest f = ∫|v|⁴ over ‖v‖ = 1 on the way up from nodal forces.
fn ascend(gram: &FaceGram, face: &Face, mut forces: Vec<f64>) -> f64 {
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
fn fourth_power(face: &Face, values: &[f64]) -> (f64, Vec<f64>) {
    let rule = triangle_rule();
    let (mut total, mut slope) = (0.0, vec![0.0; values.len()]);
    for (t, nodes) in face.triangles.iter().enumerate() {
        let area = face.area(t);
        for (weight, shape) in &rule {
            let at: [f64; 3] = std::array::from_fn(|c| {
                nodes
                    .iter()
                    .zip(shape)
                    .map(|(n, s)| s * values[3 * n + c])
                    .sum()
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
