//! What a tetrahedron contributes to the problem of the error, in bubbles.
//!
//! These are the cubic polynomials that vanish at the corners: λ_a λ_b (λ_a − λ_b) and λ_a λ_b on the six edges, λ_a λ_b λ_c on the
//! four sides. Quadratic elements have the second already, and no residual in them; but in flat ones a smooth error is a small
//! difference of large parts of either kind.

use std::sync::LazyLock;

use nalgebra::{Matrix3, SMatrix, SVector, Vector3, Vector6};

use super::{Field, boundary::LoadedBoundary};
use crate::{
    elasticity::{MaterialField, Simplex, traction},
    mesh::Mesh,
    post::Solved,
    reference::{TETRAHEDRON_EDGES, TETRAHEDRON_SIDES, quadratic_tetrahedron, quadrature},
    scene::BodyForce,
};

/// The bubbles of the elements of a solution, with what loads them.
///
/// Their geometry is that of straight tetrahedra, and stress inside a tetrahedron is interpolated
/// between its corners, which is exact on straight sides.
pub(super) struct BubbleElements<'a> {
    mesh: &'a Mesh,
    body_force: Option<&'a BodyForce>,
    boundary: &'a LoadedBoundary<'a>,
    material: &'a MaterialField<'a>,
    /// Points of integration in a tetrahedron with the bubbles and their slopes there.
    inside: Vec<QuadraturePoint>,
    /// Points of integration on each side, in barycentric coordinates of the tetrahedron.
    on_sides: [Vec<QuadraturePoint>; 4],
}

/// Components of the bubbles of a tetrahedron.
pub(super) const BUBBLE_COMPONENTS: usize = 3 * BUBBLES;

/// Numbers for the components of the bubbles of a tetrahedron.
pub(super) type BubbleVector = SVector<f64, BUBBLE_COMPONENTS>;

/// What a tetrahedron adds to the equations.
pub(super) struct BubbleElement {
    /// a(φ_α, φ_β), springs on its sides included, in N/m.
    pub(super) stiffness: SMatrix<f64, BUBBLE_COMPONENTS, BUBBLE_COMPONENTS>,
    /// The residual of each field in N, `[n_fields]`.
    pub(super) loads: Vec<BubbleVector>,
    /// Components of bubbles that are held.
    pub(super) held: [bool; BUBBLE_COMPONENTS],
}

/// A field in the bubbles of a tetrahedron at a point in barycentric coordinates.
pub(super) fn bubble_field(coefficients: &BubbleVector, at: &[f64; 4]) -> [f64; 3] {
    let bubbles = values(at);
    std::array::from_fn(|c| {
        let terms = bubbles.iter().enumerate();
        terms
            .map(|(a, bubble)| bubble * coefficients[3 * a + c])
            .sum()
    })
}

/// The bubbles at a point of integration.
struct QuadraturePoint {
    at: [f64; 4],
    weight: f64,
    values: [f64; BUBBLES],
    slopes: [[f64; 4]; BUBBLES],
}

impl BubbleElement {
    /// φ_a φ_b K of all bubbles at a point of a side.
    fn add_spring(&mut self, sample: &QuadraturePoint, spring: Matrix3<f64>) {
        for (a, first) in sample.values.iter().enumerate() {
            for (b, second) in sample.values.iter().enumerate() {
                let mut block = self.stiffness.fixed_view_mut::<3, 3>(3 * a, 3 * b);
                block += spring * (first * second);
            }
        }
    }
}

impl QuadraturePoint {
    fn new(at: [f64; 4], weight: f64) -> Self {
        Self {
            at,
            weight,
            values: values(&at),
            slopes: slopes(&at),
        }
    }
}

impl<'a> BubbleElements<'a> {
    pub(super) fn new(
        solved: &Solved<'a>,
        boundary: &'a LoadedBoundary<'a>,
        material: &'a MaterialField<'a>,
    ) -> Self {
        // Slopes are quadratic and stress is linear.
        let inside = quadrature::tetrahedron_5();
        let inside = inside
            .map(|(at, weight)| QuadraturePoint::new(at, weight))
            .collect();
        let on_sides = TETRAHEDRON_SIDES.map(|corners| {
            let points = quadrature::triangle_4().map(|(share, weight)| {
                let mut at = [0.0; 4];
                corners.into_iter().zip(share).for_each(|(c, s)| at[c] = s);
                QuadraturePoint::new(at, weight)
            });
            points.collect()
        });
        Self {
            mesh: solved.mesh,
            body_force: solved.scene.body_force.as_ref(),
            boundary,
            material,
            inside,
            on_sides,
        }
    }

    /// What a tetrahedron adds; `facets` are the boundary triangles opposite to its corners.
    pub(super) fn element(
        &self,
        t: usize,
        facets: [Option<usize>; 4],
        fields: &[Field<'_>],
    ) -> BubbleElement {
        let corners = self.mesh.corners(&self.mesh.tetrahedra[t]);
        let simplex = Simplex::new(&corners);
        let mut element = BubbleElement {
            stiffness: self.stiffness(t, &simplex),
            loads: vec![BubbleVector::zeros(); fields.len()],
            held: [false; BUBBLE_COMPONENTS],
        };
        for (field, load) in fields.iter().zip(&mut element.loads) {
            self.add_inside(t, &simplex, &corners, field, load);
        }
        for (side, facet) in facets.into_iter().enumerate() {
            if let Some(facet) = facet {
                self.add_side([t, side, facet], &simplex, &corners, fields, &mut element);
            }
        }
        for (k, node) in self.mesh.tetrahedron_nodes(t).skip(4).enumerate() {
            for c in 0..3 {
                element.held[3 * (CUBIC + k) + c] = self.boundary.nodes_held[node][c];
            }
        }
        element
    }

    /// Voigt stress at the corners of a tetrahedron in Pa.
    fn corner_stress(field: &Field<'_>, t: usize) -> [Vector6<f64>; 4] {
        field.internal.corner_stress[t].map(Vector6::from)
    }

    /// ∫ f·v − ∫ σ(u_h):ε(v).
    fn add_inside(
        &self,
        t: usize,
        simplex: &Simplex,
        corners: &[[f64; 3]; 4],
        field: &Field<'_>,
        load: &mut BubbleVector,
    ) {
        let stress = Self::corner_stress(field, t);
        for sample in &self.inside {
            let volume = sample.weight * simplex.volume;
            let here: Vector6<f64> = (0..4).map(|k| stress[k] * sample.at[k]).sum();
            let by_corner = simplex.gradients.map(|gradient| traction(&gradient, &here));
            let force = self.body_force.filter(|_| field.loads.of_scene);
            let force = force.map(|force| {
                let at = quadrature::point(corners, &sample.at);
                Vector3::from(std::array::from_fn(|c| force.value[c].at(at)))
            });
            let bubbles = sample.values.iter().zip(&sample.slopes).take(CUBIC);
            for (a, (value, slope)) in bubbles.enumerate() {
                let mut part: Vector3<f64> = (0..4).map(|k| by_corner[k] * -slope[k]).sum();
                if let Some(force) = force {
                    part += force * *value;
                }
                let mut rows = load.fixed_rows_mut::<3>(3 * a);
                rows += part * volume;
            }
        }
        let Some(in_box) = field.loads.in_box else {
            return;
        };
        for (at, weight) in in_box.samples(t) {
            let force = in_box.force() * (weight * simplex.volume);
            for (a, value) in values(at).into_iter().take(CUBIC).enumerate() {
                let mut rows = load.fixed_rows_mut::<3>(3 * a);
                rows += force * value;
            }
        }
    }

    /// ∫ t̄·v over a side on the boundary, ∫ K w·v and −∫ K u_h·v of its springs, and the components of bubbles that are held there.
    fn add_side(
        &self,
        [t, side, facet]: [usize; 3],
        simplex: &Simplex,
        corners: &[[f64; 3]; 4],
        fields: &[Field<'_>],
        element: &mut BubbleElement,
    ) {
        // ∇λ of the opposite corner points inwards with length area/(3 V).
        let area_vector = simplex.gradients[side] * (-3.0 * simplex.volume);
        let (area, normal) = (area_vector.norm(), area_vector.normalize());
        let touching = (0..CUBIC).filter(|&a| !vanishes_on(a, side));
        for a in touching.clone() {
            for c in (0..3).filter(|&c| self.boundary.held[facet][c]) {
                element.held[3 * a + c] = true;
            }
        }
        let nodes = &self.mesh.tetrahedra[t];
        let places = self.mesh.facets[facet].map(|node| nodes.iter().position(|n| *n == node));
        let mut add = |sample: &QuadraturePoint,
                       spring: Option<Matrix3<f64>>,
                       loaded: &dyn Fn(&Field<'_>) -> Vector3<f64>| {
            let weight = area * sample.weight;
            for (field, load) in fields.iter().zip(&mut element.loads) {
                let mut traction = loaded(field);
                if let Some(spring) = spring {
                    traction -= spring * self.displacement_at(field, t, &sample.at);
                }
                let quadratic = (CUBIC..BUBBLES).filter(|_| !field.is_galerkin);
                for a in touching.clone().chain(quadratic) {
                    let mut rows = load.fixed_rows_mut::<3>(3 * a);
                    rows += traction * (weight * sample.values[a]);
                }
            }
            if let Some(spring) = spring {
                element.add_spring(sample, spring * weight);
            }
        };
        for sample in &self.on_sides[side] {
            let at = quadrature::point(corners, &sample.at);
            let share = places.map(|place| place.map_or(0.0, |k| sample.at[k]));
            add(sample, self.boundary.spring(facet, at, &normal), &|field| {
                self.boundary.traction_on(facet, at, share, &normal, field)
            });
        }
        self.boundary.visit_parts(facet, &normal, &mut |point| {
            let mut at = [0.0; 4];
            for (place, share) in places.into_iter().zip(point.share) {
                place.into_iter().for_each(|k| at[k] = share);
            }
            let sample = QuadraturePoint::new(at, point.weight);
            add(&sample, point.stiffness, &|field| {
                point.traction * f64::from(u8::from(field.loads.of_scene))
            });
        });
    }

    /// u_h at a point of a tetrahedron.
    fn displacement_at(&self, field: &Field<'_>, t: usize, at: &[f64; 4]) -> Vector3<f64> {
        let nodes = self
            .mesh
            .tetrahedron_nodes(t)
            .zip(quadratic_tetrahedron(at));
        nodes
            .map(|(node, shape)| Vector3::from(field.displacement[node]) * shape)
            .sum()
    }

    /// ∫ ε(φ_α):C ε(φ_β) from the means of products of slopes.
    fn stiffness(
        &self,
        t: usize,
        simplex: &Simplex,
    ) -> SMatrix<f64, BUBBLE_COMPONENTS, BUBBLE_COMPONENTS> {
        let tensor = self.material.tensor(t);
        let blocks: [[Matrix3<f64>; 4]; 4] =
            std::array::from_fn(|k| std::array::from_fn(|l| simplex.stiffness_block(tensor, k, l)));
        let products = &*SLOPE_PRODUCTS;
        let mut stiffness = SMatrix::<f64, BUBBLE_COMPONENTS, BUBBLE_COMPONENTS>::zeros();
        for a in 0..BUBBLES {
            for b in 0..=a {
                let mut block = Matrix3::zeros();
                for (row, means) in blocks.iter().zip(&products[a][b]) {
                    for (part, mean) in row.iter().zip(means) {
                        block += part * *mean;
                    }
                }
                stiffness
                    .fixed_view_mut::<3, 3>(3 * a, 3 * b)
                    .copy_from(&block);
                stiffness
                    .fixed_view_mut::<3, 3>(3 * b, 3 * a)
                    .copy_from(&block.transpose());
            }
        }
        stiffness
    }
}

/// Number of bubbles.
pub(super) const BUBBLES: usize = 16;

/// The first of them, which quadratic elements do not have: six of edges, then four of sides. The last six are those of edges that
/// they have.
pub(super) const CUBIC: usize = 10;

/// The bubbles at a point in barycentric coordinates.
fn values(at: &[f64; 4]) -> [f64; BUBBLES] {
    std::array::from_fn(|function| match function {
        0..6 => {
            let [a, b] = TETRAHEDRON_EDGES[function];
            at[a] * at[b] * (at[a] - at[b])
        }
        6..CUBIC => TETRAHEDRON_SIDES[function - 6]
            .iter()
            .map(|&corner| at[corner])
            .product(),
        _ => {
            let [a, b] = TETRAHEDRON_EDGES[function - CUBIC];
            at[a] * at[b]
        }
    })
}

/// Their slopes by the barycentric coordinates.
fn slopes(at: &[f64; 4]) -> [[f64; 4]; BUBBLES] {
    std::array::from_fn(|function| {
        let mut slope = [0.0; 4];
        match function {
            0..6 => {
                let [a, b] = TETRAHEDRON_EDGES[function];
                slope[a] = at[b] * (2.0 * at[a] - at[b]);
                slope[b] = at[a] * (at[a] - 2.0 * at[b]);
            }
            6..CUBIC => {
                let [a, b, c] = TETRAHEDRON_SIDES[function - 6];
                slope[a] = at[b] * at[c];
                slope[b] = at[a] * at[c];
                slope[c] = at[a] * at[b];
            }
            _ => {
                let [a, b] = TETRAHEDRON_EDGES[function - CUBIC];
                slope[a] = at[b];
                slope[b] = at[a];
            }
        }
        slope
    })
}

/// Whether a cubic bubble vanishes on the side opposite to a corner.
fn vanishes_on(function: usize, side: usize) -> bool {
    match function.checked_sub(6) {
        None => TETRAHEDRON_EDGES[function].contains(&side),
        Some(own) => own != side,
    }
}

/// mean ∂φ_α/∂λ_k ∂φ_β/∂λ_l over a tetrahedron as `[α][β][k][l]`; the rule of degree 5 is exact for these of degree 4.
static SLOPE_PRODUCTS: LazyLock<[[[[f64; 4]; 4]; BUBBLES]; BUBBLES]> = LazyLock::new(|| {
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
    use crate::reference::quadratic_tetrahedron;

    #[test]
    fn bubbles_vanish_at_the_nodes_of_the_element() {
        let corner = |k: usize| std::array::from_fn(|j| f64::from(u8::from(j == k)));
        let middle =
            |ends: [usize; 2]| std::array::from_fn(|j| if ends.contains(&j) { 0.5 } else { 0.0 });
        let nodes = (0..4).map(corner).chain(TETRAHEDRON_EDGES.map(middle));
        for node in nodes {
            assert_eq!(values(&node)[..CUBIC], [0.0; CUBIC]);
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
            for (k, value) in values(&at).iter().take(CUBIC).enumerate() {
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
