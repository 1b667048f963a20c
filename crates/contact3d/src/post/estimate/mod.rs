//! How far a discrete solution lies from the body it models: an estimate of the error in the energy
//! norm, element by element.
//!
//! With the multipliers λ_h as tractions on Γ_c, u_h is the Galerkin solution of a linear problem.
//! * For linear tetrahedra its error is how far its stress is from a smoother one (`post/recovery.rs`).
//! * For quadratic ones it is that of the same problem in cubic polynomials that vanish at the corners, joined between the
//!   tetrahedra (`bubbles`, `hierarchical`).
//!
//! What the multipliers themselves are wrong by is the residual of the contact conditions *inside*
//! panes (`contact`), δλ = P(λ + k (u − d)) − λ with the local stiffness k in Pa/m, worth ∫ δλ²/k. Quadratic tetrahedra that are softer
//! there, such as those of plates, answer to δλ with more work than that; then k is as many times smaller.
//!
//! Both are estimates and no bounds: near singularities the better stress or the next polynomials see
//! only part of the error.

mod boundary;
mod box_load;
mod bubbles;
mod contact;
mod contact_points;
mod facing;
mod hierarchical;
mod joint;

use std::f64::consts::PI;

use nalgebra::{Vector3, Vector6};
use rayon::prelude::*;

use super::{PaneState, Solved, concentration::Concentrations, recovery::StressRecovery};
use crate::{
    elasticity::{InternalForces, MaterialField, MissedForce, SurfaceLoad, missed_body_forces},
    mesh::tetrahedron_volume,
    reference::quadrature,
};

pub use boundary::LoadedBoundary;
pub(super) use boundary::{FieldLoads, multipliers_at};
pub(super) use box_load::{BoxLoad, BoxedFaces};

use bubbles::{BubbleElements, BubbleVector, bubble_field};
pub(super) use contact::displacements;
use contact::{Correction, PointConditions};
pub(super) use contact_points::ContactPoints;
use hierarchical::HierarchicalErrors;
pub(super) use joint::{joint_sides, opposite_in};

/// The estimated discretisation error of a solution, in the energy norm ‖v‖_A = √a(v, v), √J.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ErrorEstimate {
    /// What each tetrahedron contributes, contact included, in √J, `[n_tetrahedra]`; the squares sum
    /// to that of [`Self::total`].
    pub indicator: Vec<f64>,
    /// Error of the displacement for the multipliers as they are, in √J.
    pub elements: f64,
    /// The contact conditions inside panes; `None` without contact.
    pub contact: Option<ContactError>,
    /// ‖u_h‖_A in √J; 0, and all parts with it, where it is no more than rounding: a body at rest, or moved as a whole. Of such a body
    /// with a part of the obstacle between its nodes it is the whole estimate, so that all of the solution counts as missed.
    pub displacement: f64,
}

/// What the multipliers are wrong by, as the conditions they violate inside panes, in √J.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ContactError {
    /// Places inside the foundation.
    pub penetration: f64,
    /// Pressure across a gap.
    pub complementarity: f64,
    /// Slip where the face sticks, and stress in another direction than the slip's; `None`
    /// without friction.
    pub friction: Option<f64>,
}

/// Relative error in the energy norm above which quantities have no error bars: their errors go as its square, so it is a quarter of them
/// where what the mesh sees of the solution is all there is.
pub const MAX_RELIABLE_ESTIMATE: f64 = 0.5;

/// A field whose error is estimated: the solution, or the adjoint of a functional.
#[derive(Clone, Copy)]
pub(super) struct Field<'a> {
    /// Nodal displacement, `[n_nodes]`.
    pub(super) displacement: &'a [[f64; 3]],
    /// Rows of the tools, `[2 n_tools]`; none where their motion does not count.
    pub(super) tools: &'a [[f64; 3]],
    /// Its stress.
    pub(super) internal: &'a InternalForces,
    /// What loads it.
    pub(super) loads: FieldLoads<'a>,
    /// Q_λ of the functional it is the adjoint of, `[n_multipliers]`; empty for the solution.
    pub(super) by_multiplier: &'a [f64],
    /// Whether it solves the discrete problem, so that its residual vanishes on quadratic functions.
    pub(super) is_galerkin: bool,
    /// The part of the contact faces that Q is the mean pressure of; `None` for other functionals.
    pub(super) over: Option<BoxedFaces>,
}

/// What is known of a solution already.
pub(super) struct SolutionData<'a> {
    /// Nodal displacement in m, `[n_nodes]`.
    pub(super) displacement: &'a [[f64; 3]],
    /// Rows of the tools in m, `[2 n_tools]`.
    pub(super) tools: &'a [[f64; 3]],
    /// Its stress.
    pub(super) internal: &'a InternalForces,
    /// The same at the nodes of each material in Pa, `[n_material_nodes]`.
    pub(super) nodal_stress: &'a [[f64; 6]],
    /// What recovered it.
    pub(super) recovery: &'a StressRecovery,
    /// State of each pane.
    pub(super) panes: &'a [PaneState],
    /// Where its stress has no bound.
    pub(super) concentrations: &'a Concentrations<'a>,
    /// Local stiffness ρ in Pa/m³, `[n_multipliers]`.
    pub(super) stiffness: &'a [f64],
    /// ½ uᵀAu in J.
    pub(super) strain_energy: f64,
    /// What rounding alone makes of uᵀAu in J.
    pub(super) rounding: f64,
}

impl ContactError {
    /// That of conditions, added to the squares in J of the tetrahedra behind the contact triangles.
    fn new(conditions: &PointConditions<'_>, behind: &[usize], squares: &mut [f64]) -> Self {
        let mut sum = [0.0; 3];
        for (&tetrahedron, energies) in behind.iter().zip(conditions.residuals()) {
            for (sum, energy) in sum.iter_mut().zip(energies) {
                *sum += energy;
                squares[tetrahedron] += energy;
            }
        }
        let [penetration, complementarity, friction] = sum.map(f64::sqrt);
        Self {
            penetration,
            complementarity,
            friction: conditions.has_friction().then_some(friction),
        }
    }

    fn squares(&self) -> f64 {
        let friction = self.friction.unwrap_or(0.0);
        let parts = [self.penetration, self.complementarity, friction];
        parts.iter().map(|part| part * part).sum()
    }
}

/// What the mesh contributes to Q(u) − Q(u_h).
pub(super) struct FunctionalError {
    /// Of each tetrahedron, `[n_tetrahedra]`.
    pub(super) of_tetrahedra: Vec<f64>,
    /// The part of the contact conditions in the sum.
    pub(super) of_contact: f64,
    /// That of loads inside triangles.
    pub(super) of_loads: f64,
    /// What cancels in the part of contact where data differ inside panes and among linear tetrahedra, and what local errors are off by, as if
    /// those of tetrahedra were independent: the root of the sum of the squares of their parts.
    pub(super) uncertain: f64,
}

impl ErrorEstimate {
    /// Estimates the error of a solved problem.
    pub(super) fn new(solved: &Solved<'_>, known: &SolutionData<'_>) -> Self {
        Self::with_adjoints(solved, known, &[], &[]).0
    }

    /// As [`Self::new`], with what the mesh contributes to Q(u) − Q(u_h) of functionals whose adjoints are given: a_T(e, e_z) of the local
    /// errors of solution and adjoint (for linear tetrahedra of their recovered stresses), and −∫ (z − q)·δλ, with what the local errors
    /// add to displacements there. Last the largest pressure in Pa of a point inside panes, for the stiffness of each in Pa/m as a half-space;
    /// 0 without it.
    pub(super) fn with_adjoints(
        solved: &Solved<'_>,
        known: &SolutionData<'_>,
        adjoints: &[Field<'_>],
        stiffness: &[f64],
    ) -> (Self, Vec<FunctionalError>, f64) {
        let mesh = solved.mesh;
        let behind = mesh.behind_contact();
        let conditions = solved.contact.as_ref();
        let conditions = conditions.map(|contact| PointConditions::new(solved, contact, known));
        if 2.0 * known.strain_energy <= known.rounding {
            return (
                Self::of_undeformed_body(solved, known, conditions, &behind),
                Vec::new(),
                0.0,
            );
        }
        let with_stiffness = conditions.as_ref().filter(|_| !stiffness.is_empty());
        let inside = with_stiffness.map_or(0.0, |it| it.largest_pressure(stiffness));
        let correction = conditions.as_ref().filter(|_| mesh.mid_edges.is_some());
        let correction = correction.map(PointConditions::correction);
        let (products, at_contact, response) =
            local_errors(solved, known, adjoints, correction.as_ref(), &behind);
        let conditions = conditions.map(|it| match &correction {
            Some(correction) => it.with_response(correction, response),
            None => it,
        });
        let mut squares: Vec<f64> = products.iter().map(|of| of[0]).collect();
        let (missed, unresolved) = missed_works(solved, known, adjoints);
        // e with a(e, v) = δl·v is no smaller than |a(e, u)|/‖u‖; what loads miss in one place is not made good in another.
        let whole: f64 = missed.iter().map(|(_, works)| works[0].abs()).sum();
        for (tetrahedron, works) in &missed {
            squares[*tetrahedron] += whole * works[0].abs() / (2.0 * known.strain_energy);
        }
        for (tetrahedron, energy) in &unresolved {
            squares[*tetrahedron] += energy;
        }
        let elements: f64 = squares.iter().sum();
        let of_elements = squares.clone();
        let contact = conditions
            .as_ref()
            .map(|it| ContactError::new(it, &behind, &mut squares));
        let shares = adjoints.iter().enumerate().map(|(k, adjoint)| {
            let mut of_tetrahedra: Vec<f64> = products.iter().map(|of| of[k + 1]).collect();
            let [mut quadratic, mut of_sides, mut of_loads, mut sizes] = [0.0; 4];
            // The adjoint of the strain energy, U(u) − U(u_h) = U'(u) e − ½ ‖e‖² = U'(u_h) e + ½ ‖e‖²: local errors e give the first, for they
            // know the loads, and contact the second, for its adjoint knows λ_h alone.
            if adjoint.loads.of_scene {
                let squares = of_elements.iter().zip(&squares);
                for (share, (elements, whole)) in of_tetrahedra.iter_mut().zip(squares) {
                    *share += 0.5 * (whole - 2.0 * elements);
                    quadratic += 0.5 * (whole - elements);
                }
                for (tetrahedron, energy) in &unresolved {
                    of_tetrahedra[*tetrahedron] += energy;
                    of_loads += 0.5 * energy;
                }
            }
            for (tetrahedron, works) in &missed {
                of_tetrahedra[*tetrahedron] += works[k + 1];
                of_loads += works[k + 1];
            }
            if let Some(conditions) = &conditions {
                let errors = |place: usize, at: &[f64; 4]| {
                    let of: Option<&Vec<BubbleVector>> = at_contact.get(place);
                    of.map_or([[0.0; 3]; 2], |of| {
                        [0, k + 1].map(|k| bubble_field(&of[k], at))
                    })
                };
                let sides = conditions.weighted(adjoint, errors);
                for (tetrahedron, share) in behind.iter().zip(sides) {
                    of_tetrahedra[*tetrahedron] += share;
                    of_sides += share;
                    sizes += share.abs();
                }
            }
            let parts = || products.iter().map(|of| of[k + 1]);
            // Local errors of each tetrahedron are off by about themselves.
            let mut uncertain = parts().map(|part| part * part).sum::<f64>().sqrt();
            let contact = conditions.as_ref();
            if contact.is_some_and(PointConditions::has_formulas) {
                uncertain += sizes - f64::abs(of_sides);
            }
            if mesh.mid_edges.is_none() {
                // Stresses of linear tetrahedra that bend are wrong everywhere alike, recovered ones too.
                uncertain += parts().map(f64::abs).sum::<f64>() - parts().sum::<f64>().abs();
            }
            FunctionalError {
                of_tetrahedra,
                of_contact: of_sides + quadratic,
                of_loads,
                uncertain,
            }
        });
        let shares = shares.collect();
        let estimate = Self {
            indicator: squares.into_iter().map(f64::sqrt).collect(),
            elements: elements.sqrt(),
            contact,
            displacement: (2.0 * known.strain_energy).sqrt(),
        };
        (estimate, shares, inside)
    }

    /// Of no deformation: none, or where the body lies in the obstacle between its nodes all of what the true solution is.
    fn of_undeformed_body(
        solved: &Solved<'_>,
        known: &SolutionData<'_>,
        conditions: Option<PointConditions<'_>>,
        behind: &[usize],
    ) -> Self {
        let mut squares = vec![0.0; solved.mesh.tetrahedra.len()];
        let touches = |it: &PointConditions<'_>| it.deepest() <= solved.touching_depth();
        let only_touches = conditions.as_ref().is_none_or(touches);
        let contact = conditions.map(|it| ContactError::new(&it, behind, &mut squares));
        let missed: f64 = squares.iter().sum();
        if only_touches || missed <= known.rounding {
            return Self {
                indicator: vec![0.0; squares.len()],
                contact: contact.map(|it| ContactError {
                    friction: it.friction.map(|_| 0.0),
                    ..ContactError::default()
                }),
                ..Self::default()
            };
        }
        Self {
            indicator: squares.into_iter().map(f64::sqrt).collect(),
            elements: 0.0,
            contact,
            displacement: missed.sqrt(),
        }
    }

    /// The whole estimate in √J.
    #[must_use]
    pub fn total(&self) -> f64 {
        (self.elements * self.elements + self.contact_square()).sqrt()
    }

    /// The whole estimate and its parts over ‖u_h‖_A, with their names.
    #[must_use]
    pub fn relative_parts(&self) -> Vec<(&'static str, f64)> {
        let mut parts = vec![("total", self.total()), ("elements", self.elements)];
        if let Some(contact) = &self.contact {
            parts.push(("penetration", contact.penetration));
            parts.push(("complementarity", contact.complementarity));
            parts.extend(contact.friction.map(|friction| ("friction", friction)));
        }
        let relative = |(name, part): &(&'static str, f64)| (*name, part / self.displacement);
        parts.iter().map(relative).collect()
    }

    /// The whole estimate over ‖u_h‖_A; 0 for a body at rest, or moved as a whole.
    #[must_use]
    pub fn relative(&self) -> f64 {
        self.over_displacement(self.total())
    }

    /// Whether the error is so large that the mesh sees too little of the solution to tell the error of a quantity.
    #[must_use]
    pub fn is_unreliable(&self) -> bool {
        self.relative() >= MAX_RELIABLE_ESTIMATE
    }

    /// What the multipliers are wrong by over ‖u_h‖_A; 0 without contact.
    #[must_use]
    pub fn relative_contact(&self) -> f64 {
        self.over_displacement(self.contact_square().sqrt())
    }

    /// What the multipliers are wrong by, in J.
    pub(super) fn contact_square(&self) -> f64 {
        self.contact.map_or(0.0, |contact| contact.squares())
    }

    fn over_displacement(&self, error: f64) -> f64 {
        if error == 0.0 {
            0.0
        } else {
            error / self.displacement
        }
    }
}

/// Works in J of the solution and of each adjoint, by tetrahedra.
type Works = Vec<(usize, Vec<f64>)>;

/// The works in J of what the quadrature of the loads misses of their formulas, δl·u and δl·z of each adjoint, by tetrahedra.
///
/// And a(e, e) in J of what loads on faces do inside triangles beyond what shape functions can be: under waves p of a pressure with the number
/// κ a half-space has ∫ 2 p²/(E* κ). Linear functions do not see waves as long as a triangle is wide, quadratic ones those of two thirds of it.
fn missed_works(
    solved: &Solved<'_>,
    known: &SolutionData<'_>,
    adjoints: &[Field<'_>],
) -> (Works, Vec<(usize, f64)>) {
    let mesh = solved.mesh;
    let fields = || {
        let adjoints = adjoints.iter().map(|adjoint| adjoint.displacement);
        std::iter::once(known.displacement).chain(adjoints)
    };
    let works = |forces: &[MissedForce]| -> Vec<f64> {
        let work = |field: &[[f64; 3]]| {
            let terms = forces.iter();
            let terms = terms.map(|f| f.missed.dot(&Vector3::from(field[f.node])));
            terms.sum()
        };
        fields().map(work).collect()
    };
    let behind = mesh.behind(0..mesh.facets.len());
    let (mut missed, mut unresolved) = (Vec::new(), Vec::new());
    let material = MaterialField::new(solved.scene, mesh);
    let waves = mesh.mid_edges.as_ref().map_or(1.0, |_| 1.5);
    let energy = |(facet, square): (usize, f64)| {
        let wave_number = 2.0 * PI * waves / (2.0 * mesh.facet_area(facet)).sqrt();
        let stiffness = material.plane_strain_modulus(behind[facet]) * wave_number;
        (behind[facet], 2.0 * square / stiffness)
    };
    // What is not finite was refused before the solve.
    let loads = solved.scene.face_loads();
    for load in loads.filter_map(|load| SurfaceLoad::new(load, mesh).ok()) {
        let on_sides = load.missed_forces(mesh);
        missed.extend(on_sides.map(|(facet, forces)| (behind[facet], works(&forces))));
        unresolved.extend(load.unresolved(mesh).map(energy));
    }
    if let Some(force) = &solved.scene.body_force {
        let inside = missed_body_forces(force, mesh);
        missed.extend(inside.map(|(tetrahedron, forces)| (tetrahedron, works(&forces))));
    }
    (missed, unresolved)
}

/// The local errors of the solution and of adjoints; `behind` are the tetrahedra of the contact triangles.
///
/// * a_T(e, e) of the solution and a_T(e, e_z) with each adjoint, `[n_tetrahedra, 1 + n_adjoints]`,
/// * the errors themselves behind each contact triangle, `[n_contact_facets, 1 + n_adjoints]`, none for linear tetrahedra and without
///   adjoints,
/// * the work in J of the tractions of a correction in quadratic tetrahedra.
fn local_errors(
    solved: &Solved<'_>,
    known: &SolutionData<'_>,
    adjoints: &[Field<'_>],
    correction: Option<&Correction>,
    behind: &[usize],
) -> (Vec<Vec<f64>>, Vec<Vec<BubbleVector>>, f64) {
    let mesh = solved.mesh;
    let material = MaterialField::new(solved.scene, mesh);
    let solution = Field {
        displacement: known.displacement,
        tools: known.tools,
        internal: known.internal,
        loads: FieldLoads::of_scene(solved),
        by_multiplier: &[],
        is_galerkin: true,
        over: None,
    };
    let correction = correction.iter().map(|correction| correction.field());
    let fields = std::iter::once(solution).chain(adjoints.iter().copied());
    let fields: Vec<Field<'_>> = fields.chain(correction).collect();
    if mesh.mid_edges.is_none() {
        return (
            recovered_errors(solved, &material, known, &fields),
            Vec::new(),
            0.0,
        );
    }
    let boundary = LoadedBoundary::new(solved);
    let elements = BubbleElements::new(solved, &boundary, &material);
    let errors = HierarchicalErrors::new(mesh, &elements, &fields);
    let shared = behind.iter().filter(|_| !adjoints.is_empty());
    let fields = 0..=adjoints.len();
    let at_contact = shared.map(|t| {
        fields
            .clone()
            .map(|field| errors.field(*t, field))
            .collect()
    });
    let at_contact = at_contact.collect();
    let response = errors.energies.last().copied().unwrap_or_default();
    (errors.products, at_contact, response)
}

/// ∫ (σ* − σ_h):C⁻¹(σ* − σ_h)_k over every tetrahedron for the first field, whose σ* is given, and each, `[n_tetrahedra][n_fields]`, in J
/// for the first itself.
fn recovered_errors(
    solved: &Solved<'_>,
    material: &MaterialField<'_>,
    known: &SolutionData<'_>,
    fields: &[Field<'_>],
) -> Vec<Vec<f64>> {
    let (mesh, recovery) = (solved.mesh, known.recovery);
    let others = fields[1..].iter();
    let others = others.map(|it| recovery.recovered(mesh, &it.internal.stress));
    let at_rows: Vec<Vec<[f64; 6]>> = std::iter::once(known.nodal_stress.to_vec())
        .chain(others)
        .collect();
    let compliances = material.compliances();
    (0..mesh.tetrahedra.len())
        .into_par_iter()
        .map(|t| {
            let volume = tetrahedron_volume(&mesh.corners(&mesh.tetrahedra[t]));
            let corners = recovery.nodes.of_tetrahedron(t);
            let difference = |k: usize, at: &[f64; 4]| -> Vector6<f64> {
                let at_corner = |c: usize| Vector6::from(at_rows[k][corners[c]]);
                let smooth: Vector6<f64> = (0..4).map(|c| at_corner(c) * at[c]).sum();
                smooth - Vector6::from(fields[k].internal.stress[t])
            };
            let product = |k: usize| -> f64 {
                let at = |(at, weight): ([f64; 4], f64)| {
                    let strain = compliances[material.region(t)] * difference(k, &at);
                    weight * difference(0, &at).dot(&strain)
                };
                volume * quadrature::TETRAHEDRON_2.into_iter().map(at).sum::<f64>()
            };
            (0..fields.len()).map(product).collect()
        })
        .collect()
}
