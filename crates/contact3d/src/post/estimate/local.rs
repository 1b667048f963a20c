//! Local problems of the error estimate, in bubbles.
//!
//! The polynomials a quadratic tetrahedron is enriched by: P3 without P2, those cubic ones that
//! vanish at its ten nodes: λ_a λ_b (λ_a − λ_b) on the six edges, λ_a λ_b λ_c on the four sides.

use std::sync::LazyLock;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix3, Vector3, Vector6};

use super::{
    Field,
    boundary::{LoadedBoundary, Neighbour},
};
use crate::{
    elasticity::{MaterialField, Simplex, traction},
    mesh::Mesh,
    post::Solved,
    reference::{TETRAHEDRON_EDGES, quadrature, shape::quadratic_tetrahedron},
    scene::BodyForce,
};

/// Products of slopes of a flat tetrahedron are off by some roundings of the largest.
const ROUNDING: f64 = 16.0;

/// All local problems of a solution.
///
/// Their geometry is that of straight tetrahedra, and stress inside a tetrahedron is interpolated
/// between its corners, which is exact on straight sides.
pub(super) struct LocalProblems<'a> {
    mesh: &'a Mesh,
    body_force: Option<&'a BodyForce>,
    boundary: &'a LoadedBoundary<'a>,
    beyond: &'a [[Neighbour; 4]],
    material: &'a MaterialField<'a>,
    /// Points of integration in a tetrahedron with the bubbles and their slopes there.
    inside: Vec<QuadraturePoint>,
    /// Points of integration on each side, in barycentric coordinates of the tetrahedron.
    on_sides: [Vec<QuadraturePoint>; 4],
}

/// The equations of the local problems of a tetrahedron.
struct LocalSystem {
    stiffness: DMatrix<f64>,
    /// One for each field.
    loads: Vec<DVector<f64>>,
    /// Components of bubbles that are held.
    held: Vec<bool>,
}

/// The local problems of a tetrahedron, ready to be solved.
struct FactorisedProblem {
    /// One for each field.
    loads: Vec<DVector<f64>>,
    factor: Cholesky<f64, Dyn>,
}

/// A field in the bubbles of a tetrahedron.
#[derive(Clone)]
pub(super) struct BubbleField(DVector<f64>);

impl BubbleField {
    /// The field at a point in barycentric coordinates.
    pub(super) fn at(&self, at: &[f64; 4]) -> [f64; 3] {
        let bubbles = values(at);
        std::array::from_fn(|c| {
            let terms = bubbles.iter().enumerate();
            terms.map(|(a, bubble)| bubble * self.0[3 * a + c]).sum()
        })
    }
}

/// The bubbles at a point of integration.
struct QuadraturePoint {
    at: [f64; 4],
    weight: f64,
    values: [f64; BUBBLES],
    slopes: [[f64; 4]; BUBBLES],
}

impl LocalSystem {
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

impl<'a> LocalProblems<'a> {
    pub(super) fn new(
        solved: &Solved<'a>,
        boundary: &'a LoadedBoundary<'a>,
        beyond: &'a [[Neighbour; 4]],
        material: &'a MaterialField<'a>,
    ) -> Self {
        // Slopes are quadratic and stress is linear.
        let inside = quadrature::tetrahedron_5();
        let inside = inside
            .map(|(at, weight)| QuadraturePoint::new(at, weight))
            .collect();
        let on_sides = SIDES.map(|corners| {
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
            beyond,
            material,
            inside,
            on_sides,
        }
    }

    /// a(e, e_k) of a tetrahedron for the error e of the first field and that e_k of each, in J for the first itself.
    pub(super) fn products(&self, t: usize, fields: &[Field<'_>]) -> Vec<f64> {
        let Some(FactorisedProblem { loads, factor }) = self.factorised(t, fields) else {
            return vec![f64::NAN; fields.len()];
        };
        let error = factor.solve(&loads[0]);
        let mut products: Vec<f64> = loads.iter().map(|load| load.dot(&error)).collect();
        products[0] = products[0].max(0.0);
        products
    }

    /// The local errors of fields in a tetrahedron.
    pub(super) fn errors(&self, t: usize, fields: &[Field<'_>]) -> Vec<BubbleField> {
        let Some(FactorisedProblem { loads, factor }) = self.factorised(t, fields) else {
            return vec![BubbleField(DVector::zeros(3 * BUBBLES)); fields.len()];
        };
        let errors = loads.iter().map(|load| BubbleField(factor.solve(load)));
        errors.collect()
    }

    /// The loads of local problems and the factor of their stiffness; `None` where rounding leaves none.
    fn factorised(&self, t: usize, fields: &[Field<'_>]) -> Option<FactorisedProblem> {
        let corners = self.mesh.corners(&self.mesh.tetrahedra[t]);
        let simplex = Simplex::new(&corners);
        let mut system = LocalSystem {
            stiffness: self.stiffness(t, &simplex),
            loads: vec![DVector::zeros(3 * BUBBLES); fields.len()],
            held: vec![false; 3 * BUBBLES],
        };
        for (field, load) in fields.iter().zip(&mut system.loads) {
            self.add_inside(t, &simplex, &corners, field, load);
        }
        for side in 0..4 {
            self.add_side(t, side, &simplex, &corners, fields, &mut system);
        }
        let LocalSystem {
            mut stiffness,
            mut loads,
            held,
        } = system;
        for i in (0..held.len()).filter(|&i| held[i]) {
            stiffness.row_mut(i).fill(0.0);
            stiffness.column_mut(i).fill(0.0);
            stiffness[(i, i)] = 1.0;
            loads.iter_mut().for_each(|load| load[i] = 0.0);
        }
        // Bubbles vanish at the corners, and no rigid motion does; in tetrahedra so flat that rounding hides it, its share is added.
        let factor = stiffness.clone().cholesky().or_else(|| {
            let rounding = ROUNDING * stiffness.nrows() as f64 * f64::EPSILON;
            let diagonal = stiffness.diagonal() * (1.0 + rounding);
            stiffness.set_diagonal(&diagonal);
            stiffness.cholesky()
        });
        factor.map(|factor| FactorisedProblem { loads, factor })
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
        load: &mut DVector<f64>,
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
            for (a, (value, slope)) in sample.values.iter().zip(&sample.slopes).enumerate() {
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
            for (a, value) in values(at).into_iter().enumerate() {
                let mut rows = load.fixed_rows_mut::<3>(3 * a);
                rows += force * value;
            }
        }
    }

    /// ∫ t̄·v over one side, ∫ K w·v and −∫ K u_h·v of its springs, and the components of bubbles that are held there.
    fn add_side(
        &self,
        t: usize,
        side: usize,
        simplex: &Simplex,
        corners: &[[f64; 3]; 4],
        fields: &[Field<'_>],
        system: &mut LocalSystem,
    ) {
        // ∇λ of the opposite corner points inwards with length area/(3 V).
        let area_vector = simplex.gradients[side] * (-3.0 * simplex.volume);
        let touching = (0..BUBBLES).filter(|&a| !vanishes_on(a, side));
        let stress_of = |field: &Field<'_>| match self.beyond[t][side] {
            Neighbour::Tetrahedron(other) => {
                let own = Self::corner_stress(field, t);
                let others = Self::corner_stress(field, other);
                let nodes = &self.mesh.tetrahedra[other];
                let across = |k: usize| {
                    let node = self.mesh.tetrahedra[t][k];
                    nodes.iter().position(|n| *n == node).map(|l| others[l])
                };
                let [ours, theirs] = [t, other].map(|t| self.material.tensor(t).trace());
                // Exactly a half inside a material.
                let share = theirs / (ours + theirs);
                std::array::from_fn::<_, 4, _>(|k| {
                    across(k).map(|other| own[k] * share + other * (1.0 - share))
                })
            }
            Neighbour::Facet(_) => [None; 4],
        };
        if let Neighbour::Facet(facet) = self.beyond[t][side] {
            for a in touching.clone() {
                for c in (0..3).filter(|&c| self.boundary.held[facet][c]) {
                    system.held[3 * a + c] = true;
                }
            }
        }
        let stresses: Vec<[Option<Vector6<f64>>; 4]> = fields.iter().map(stress_of).collect();
        let normal = area_vector.normalize();
        for sample in &self.on_sides[side] {
            let force_on = |field: &Field<'_>, stress: &[Option<Vector6<f64>>; 4]| match self.beyond
                [t][side]
            {
                Neighbour::Tetrahedron(_) => {
                    let here: Vector6<f64> = SIDES[side]
                        .iter()
                        .filter_map(|&k| Some(stress[k]? * sample.at[k]))
                        .sum();
                    traction(&area_vector, &here)
                }
                Neighbour::Facet(facet) => {
                    let nodes = &self.mesh.tetrahedra[t];
                    let share = self.mesh.facets[facet].map(|node| {
                        let k = nodes.iter().position(|n| *n == node);
                        k.map_or(0.0, |k| sample.at[k])
                    });
                    let at = quadrature::point(corners, &sample.at);
                    let area = area_vector.norm();
                    let loads = &field.loads;
                    let mut traction = self.boundary.traction(facet, at, share, &normal, loads);
                    if let Some(spring) = self.boundary.spring(facet, at, &normal) {
                        traction -= spring * self.displacement_at(field, t, &sample.at);
                    }
                    traction * area
                }
            };
            for ((field, stress), load) in fields.iter().zip(&stresses).zip(&mut system.loads) {
                let force = force_on(field, stress);
                for a in touching.clone() {
                    let mut rows = load.fixed_rows_mut::<3>(3 * a);
                    rows += force * (sample.weight * sample.values[a]);
                }
            }
            if let Neighbour::Facet(facet) = self.beyond[t][side] {
                let at = quadrature::point(corners, &sample.at);
                if let Some(spring) = self.boundary.spring(facet, at, &normal) {
                    system.add_spring(sample, spring * (area_vector.norm() * sample.weight));
                }
            }
        }
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
    fn stiffness(&self, t: usize, simplex: &Simplex) -> DMatrix<f64> {
        let tensor = self.material.tensor(t);
        let blocks: [[Matrix3<f64>; 4]; 4] =
            std::array::from_fn(|k| std::array::from_fn(|l| simplex.stiffness_block(tensor, k, l)));
        let products = &*SLOPE_PRODUCTS;
        let mut stiffness = DMatrix::zeros(3 * BUBBLES, 3 * BUBBLES);
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
