//! The local Neumann problem of one quadratic tetrahedron.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3, Vector6};

use super::{
    boundary::Boundary,
    bubbles::{BUBBLES, SIDES, SLOPE_PRODUCTS, slopes, values, vanishes_on},
    surroundings::Beyond,
};
use crate::{
    elasticity::{InternalForces, MaterialField, Simplex, traction},
    mesh::Mesh,
    post::Solved,
    reference::{quadrature, shape::quadratic_tetrahedron},
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
    /// Nodal displacement in m, `[n_nodes]`.
    displacement: &'a [[f64; 3]],
    internal: &'a InternalForces,
    boundary: &'a Boundary<'a>,
    beyond: &'a [[Beyond; 4]],
    material: &'a MaterialField<'a>,
    /// Points of integration in a tetrahedron with the bubbles and their slopes there.
    inside: Vec<Sample>,
    /// Points of integration on each side, in barycentric coordinates of the tetrahedron.
    on_sides: [Vec<Sample>; 4],
}

/// The equations of one local problem.
struct LocalSystem {
    stiffness: DMatrix<f64>,
    load: DVector<f64>,
    /// Components of bubbles that are held.
    held: Vec<bool>,
}

/// The bubbles at a point of integration.
struct Sample {
    at: [f64; 4],
    weight: f64,
    values: [f64; BUBBLES],
    slopes: [[f64; 4]; BUBBLES],
}

impl LocalSystem {
    /// φ_a φ_b K of all bubbles at a point of a side.
    fn add_spring(&mut self, sample: &Sample, spring: Matrix3<f64>) {
        for (a, first) in sample.values.iter().enumerate() {
            for (b, second) in sample.values.iter().enumerate() {
                let mut block = self.stiffness.fixed_view_mut::<3, 3>(3 * a, 3 * b);
                block += spring * (first * second);
            }
        }
    }
}

impl Sample {
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
        displacement: &'a [[f64; 3]],
        internal: &'a InternalForces,
        boundary: &'a Boundary<'a>,
        beyond: &'a [[Beyond; 4]],
        material: &'a MaterialField<'a>,
    ) -> Self {
        // Slopes are quadratic and stress is linear.
        let inside = quadrature::tetrahedron_5();
        let inside = inside.map(|(at, weight)| Sample::new(at, weight)).collect();
        let on_sides = SIDES.map(|corners| {
            let points = quadrature::triangle_4().map(|(share, weight)| {
                let mut at = [0.0; 4];
                corners.into_iter().zip(share).for_each(|(c, s)| at[c] = s);
                Sample::new(at, weight)
            });
            points.collect()
        });
        Self {
            mesh: solved.mesh,
            body_force: solved.scene.body_force.as_ref(),
            displacement,
            internal,
            boundary,
            beyond,
            material,
            inside,
            on_sides,
        }
    }

    /// a(e, e) in J of a tetrahedron.
    pub(super) fn energy(&self, t: usize) -> f64 {
        let corners = self.mesh.corners(&self.mesh.tetrahedra[t]);
        let simplex = Simplex::new(&corners);
        let mut system = LocalSystem {
            stiffness: self.stiffness(t, &simplex),
            load: DVector::zeros(3 * BUBBLES),
            held: vec![false; 3 * BUBBLES],
        };
        self.add_inside(t, &simplex, &corners, &mut system.load);
        for side in 0..4 {
            self.add_side(t, side, &simplex, &corners, &mut system);
        }
        let LocalSystem {
            mut stiffness,
            mut load,
            held,
        } = system;
        for i in (0..held.len()).filter(|&i| held[i]) {
            stiffness.row_mut(i).fill(0.0);
            stiffness.column_mut(i).fill(0.0);
            stiffness[(i, i)] = 1.0;
            load[i] = 0.0;
        }
        // Bubbles vanish at the corners, and no rigid motion does; in tetrahedra so flat that rounding hides it, its share is added.
        let factor = stiffness.clone().cholesky().or_else(|| {
            let rounding = ROUNDING * stiffness.nrows() as f64 * f64::EPSILON;
            let diagonal = stiffness.diagonal() * (1.0 + rounding);
            stiffness.set_diagonal(&diagonal);
            stiffness.cholesky()
        });
        factor.map_or(f64::NAN, |factor| load.dot(&factor.solve(&load)).max(0.0))
    }

    /// Voigt stress at the corners of a tetrahedron in Pa.
    fn corner_stress(&self, t: usize) -> [Vector6<f64>; 4] {
        self.internal.corner_stress[t].map(Vector6::from)
    }

    /// ∫ f·v − ∫ σ(u_h):ε(v).
    fn add_inside(
        &self,
        t: usize,
        simplex: &Simplex,
        corners: &[[f64; 3]; 4],
        load: &mut DVector<f64>,
    ) {
        let stress = self.corner_stress(t);
        for sample in &self.inside {
            let volume = sample.weight * simplex.volume;
            let here: Vector6<f64> = (0..4).map(|k| stress[k] * sample.at[k]).sum();
            let by_corner = simplex.gradients.map(|gradient| traction(&gradient, &here));
            let force = self.body_force.map(|force| {
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
    }

    /// ∫ t̄·v over one side, ∫ K w·v and −∫ K u_h·v of its springs, and the components of bubbles that are held there.
    fn add_side(
        &self,
        t: usize,
        side: usize,
        simplex: &Simplex,
        corners: &[[f64; 3]; 4],
        system: &mut LocalSystem,
    ) {
        // ∇λ of the opposite corner points inwards with length area/(3 V).
        let area_vector = simplex.gradients[side] * (-3.0 * simplex.volume);
        let own = self.corner_stress(t);
        let touching = (0..BUBBLES).filter(|&a| !vanishes_on(a, side));
        let stress = match self.beyond[t][side] {
            Beyond::Tetrahedron(other) => {
                let others = self.corner_stress(other);
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
            Beyond::Facet(facet) => {
                for a in touching.clone() {
                    for c in (0..3).filter(|&c| self.boundary.held[facet][c]) {
                        system.held[3 * a + c] = true;
                    }
                }
                [None; 4]
            }
        };
        let normal = area_vector.normalize();
        for sample in &self.on_sides[side] {
            let force = match self.beyond[t][side] {
                Beyond::Tetrahedron(_) => {
                    let here: Vector6<f64> = SIDES[side]
                        .iter()
                        .filter_map(|&k| Some(stress[k]? * sample.at[k]))
                        .sum();
                    traction(&area_vector, &here)
                }
                Beyond::Facet(facet) => {
                    let nodes = &self.mesh.tetrahedra[t];
                    let share = self.mesh.facets[facet].map(|node| {
                        let k = nodes.iter().position(|n| *n == node);
                        k.map_or(0.0, |k| sample.at[k])
                    });
                    let at = quadrature::point(corners, &sample.at);
                    let area = area_vector.norm();
                    let mut traction = self.boundary.traction(facet, at, share, &normal);
                    if let Some(spring) = self.boundary.spring(facet, at, &normal) {
                        traction -= spring * self.displacement_at(t, &sample.at);
                        system.add_spring(sample, spring * (area * sample.weight));
                    }
                    traction * area
                }
            };
            for a in touching.clone() {
                let mut rows = system.load.fixed_rows_mut::<3>(3 * a);
                rows += force * (sample.weight * sample.values[a]);
            }
        }
    }

    /// u_h at a point of a tetrahedron.
    fn displacement_at(&self, t: usize, at: &[f64; 4]) -> Vector3<f64> {
        let nodes = self
            .mesh
            .tetrahedron_nodes(t)
            .zip(quadratic_tetrahedron(at));
        nodes
            .map(|(node, shape)| Vector3::from(self.displacement[node]) * shape)
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
