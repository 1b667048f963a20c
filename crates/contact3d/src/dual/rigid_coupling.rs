//! What contact does to the rigid modes of a body that floats.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::{
    Assembly,
    motion_spaces::{MotionSpaces, separation_motion},
};
use crate::{
    contact::{Coupling, Interface, MultiplierLayout},
    elasticity::RigidModes,
    linalg::{FEW_ROUNDINGS, add_combination, add_scaled, dot, norm},
    mesh::ContactSurface,
};

/// Share of the largest effect of a rigid motion on the contact face below which it has none: rounding of coordinates, with
/// room, and no motion that a face resists.
pub(super) const NULL_MODE_SHARE: f64 = 1e-10;

/// The rigid motions that contact or weak supports act on, and what they do to the contact face.
///
/// Contact without friction on a plane does not feel motions along it, and a single pane feels no rotation about its centroid. Such
/// motions are the null space of contact: their α are zero in every solution (the least motion), and a load that works on them has no equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidCoupling {
    body: Arc<RigidModes>,
    /// The order of the multipliers.
    pub(crate) layout: MultiplierLayout,
    /// Motions that contact or supports act on, those that supports resist first, in terms of the modes of the body, `[n_active][n_modes]`.
    active: Vec<Vec<f64>>,
    /// What a motion in terms of the modes is in terms of active ones, `[n_active][n_modes]`.
    coordinates: Vec<Vec<f64>>,
    /// The others in terms of the modes, orthonormal, `[n_modes − n_active][n_modes]`.
    null: Vec<Vec<f64>>,
    /// R of the active motions, `[n_active][n_free]`.
    rigid: Vec<Vec<f64>>,
    /// Y of the active motions, likewise; empty where no supports resist.
    spring_response: Vec<Vec<f64>>,
    /// The stiffness D of the supports in each active motion in N/m, `[n_active]`; zeros where none resist.
    pub(crate) support: Vec<f64>,
    /// G = B (Z + Y) of the active motions, `[n_active][n_multipliers]`, in m².
    pub(crate) integrals: Vec<Vec<f64>>,
    /// B Z, likewise: zero where a motion does not move the face, however the body yields to the springs.
    rigid_contact_integrals: Vec<Vec<f64>>,
    /// (u_t1, u_t2) of the active motions at the contact nodes, `[n_active][n_contact_nodes]`.
    pub(crate) slip: Vec<Vec<[f64; 2]>>,
}

/// The condition that contact forces and weak supports balance the load, Gᵀλ + D α = e, with the rigid motions α that belong to it.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidEquilibrium {
    /// G and its motions.
    pub(crate) coupling: Arc<RigidCoupling>,
    /// e = Zᵀl of the active motions, or e − Gᵀλ₀ − D α₀ about an anchor, `[n_active]`, in N.
    pub(crate) resultant: Vec<f64>,
    /// The motion about which α is written, where there is a gap.
    pub(crate) reference: Option<ReferenceMotion>,
    /// A free motion that separates every pane from the foundation and in which the load does not work, `[n_active]`: then λ = 0 is a
    /// solution, and the only one unless panes slide in the motion, which the second tells.
    pub(crate) separation_motion: Option<(Vec<f64>, bool)>,
}

/// The rigid motion α₀ that closes the gap d best, and what remains of it, d − G α₀: written about α₀, a problem whose gap is a
/// thousand times larger than the strained displacement loses no digits of h.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ReferenceMotion {
    /// α₀ in m, `[n_active]`.
    pub(crate) motion: Vec<f64>,
    /// d − G α₀ in m³, `[n_multipliers]`; zero where it is no more than rounding of d.
    pub(crate) distances: Vec<f64>,
}

impl RigidCoupling {
    fn new(
        body: &Arc<RigidModes>,
        coupling: &Coupling,
        surface: &ContactSurface,
        interface: &Interface,
        assembly: &Assembly,
    ) -> Self {
        let of_modes: Vec<Vec<f64>> = body.modes.iter().map(|m| coupling.integrate(m)).collect();
        let spaces = MotionSpaces::new(&of_modes, body, &surface.pane_area, coupling.layout);
        let dofs = &assembly.primal.dofs;
        let motions = || spaces.active.iter().map(|(modes, ..)| modes);
        let rigid: Vec<Vec<f64>> = motions().map(|w| body.rigid_part(w)).collect();
        let spring_response: Vec<Vec<f64>> = match body.support {
            Some(_) => motions().map(|w| body.spring_response_part(w)).collect(),
            None => Vec::new(),
        };
        let integrate = |u: &Vec<f64>| coupling.integrate(u);
        let mut rigid_contact_integrals: Vec<Vec<f64>> = rigid.iter().map(integrate).collect();
        for (own, (.., reach)) in rigid_contact_integrals.iter_mut().zip(&spaces.active) {
            reach.restrict(own, coupling.layout);
        }
        let slip_of = |u: &Vec<f64>| {
            let at_row = |row| dofs.change_at_node(row, u);
            interface.frame.nodal_tangential(surface, dofs, at_row)
        };
        let mut slip: Vec<Vec<[f64; 2]>> = rigid.iter().map(slip_of).collect();
        let mut integrals = rigid_contact_integrals.clone();
        for (p, by_springs) in spring_response.iter().enumerate() {
            add_scaled(&mut integrals[p], 1.0, &integrate(by_springs));
            let by_springs = slip_of(by_springs);
            add_scaled(slip[p].as_flattened_mut(), 1.0, by_springs.as_flattened());
        }
        let mut rigid = Self {
            body: Arc::clone(body),
            layout: coupling.layout,
            coordinates: spaces.coordinates(),
            active: motions().cloned().collect(),
            null: Vec::new(),
            support: spaces
                .active
                .iter()
                .map(|(_, support, _)| *support)
                .collect(),
            rigid,
            spring_response,
            integrals,
            rigid_contact_integrals,
            slip,
        };
        // What rounding left of them on the face, relative to motions of the whole body, would be slips of sticking panes.
        let null_space = spaces.null.into_iter().map(|mut modes| {
            let left = coupling.integrate(&body.rigid_part(&modes));
            let closing = rigid.closing_motion(&left, &surface.pane_area);
            add_scaled(&mut modes, -1.0, &rigid.in_modes(&closing));
            modes
        });
        rigid.null = null_space.collect();
        rigid
    }

    /// Number of motions that contact or supports act on.
    pub(crate) fn n_active(&self) -> usize {
        self.active.len()
    }

    /// Number of active motions that supports resist; they come first.
    pub(crate) fn n_supported(&self) -> usize {
        self.support.iter().filter(|d| **d > 0.0).count()
    }

    /// The motion in terms of the modes of the body, `[n_modes]`, of that in terms of active ones.
    pub(crate) fn in_modes(&self, motion: &[f64]) -> Vec<f64> {
        let mut modes = vec![0.0; self.body.n_modes()];
        add_combination(&mut modes, motion, &self.active);
        modes
    }

    /// (Z + Y)ᵀf of the active motions in N for nodal forces f in N.
    pub(crate) fn work_of(&self, forces: &[f64]) -> Vec<f64> {
        let mut work: Vec<f64> = self.rigid.iter().map(|u| dot(u, forces)).collect();
        for (work, u) in work.iter_mut().zip(&self.spring_response) {
            *work += dot(u, forces);
        }
        work
    }

    /// e = (Z + Y)ᵀl, with zeros for what is rounding of the load: a motion that it does not drive would else be driven by chance.
    fn load_resultant(&self, assembly: &Assembly) -> Vec<f64> {
        let (dofs, load) = (&assembly.primal.dofs, &assembly.primal.load);
        let works = self.work_of(load).into_iter().zip(&self.rigid);
        let active = |(work, u): (f64, &Vec<f64>)| {
            let rounding = 64.0 * f64::EPSILON * dofs.largest_work(u, load);
            if work.abs() <= rounding { 0.0 } else { work }
        };
        works.map(active).collect()
    }

    /// The displacements of the free degrees of freedom in the motions of the null space, `[n_modes − n_active][n_free]`.
    pub(crate) fn null_space_motions(&self) -> Vec<Vec<f64>> {
        let motions = self.null.iter();
        motions.map(|modes| self.body.rigid_part(modes)).collect()
    }

    /// Adds Z α.
    pub(crate) fn add_rigid(&self, motion: &[f64], displacement: &mut [f64]) {
        add_combination(displacement, motion, &self.rigid);
    }

    /// Adds (Z + Y) α: first Y α, which is of the size of strained displacements.
    pub(crate) fn add_motion(&self, motion: &[f64], displacement: &mut [f64]) {
        add_combination(displacement, motion, &self.spring_response);
        self.add_rigid(motion, displacement);
    }

    /// Takes the motions of the null space out of a displacement, by least squares over its degrees of freedom, and out of its α in terms of the
    /// modes.
    pub(crate) fn remove_null_space(&self, displacement: &mut [f64], modes: &mut [f64]) {
        let motions = self.null_space_motions();
        let n = motions.len();
        let gram = DMatrix::from_fn(n, n, |p, q| dot(&motions[p], &motions[q]));
        let along = DVector::from_fn(n, |p, _| dot(&motions[p], displacement));
        let Some(factor) = gram.cholesky() else {
            return;
        };
        for ((motion, weights), by) in motions.iter().zip(&self.null).zip(&factor.solve(&along)) {
            add_scaled(displacement, -by, motion);
            add_scaled(modes, -by, weights);
        }
    }

    /// The motion that closes distances d in m³, `[n_multipliers]`, by least squares over the contact face.
    fn closing_motion(&self, distances: &[f64], areas: &[f64]) -> Vec<f64> {
        if self.n_active() == 0 {
            return Vec::new();
        }
        let weight = |j: usize| areas[self.layout.pane_of(j)].sqrt().recip();
        let n = distances.len();
        let weighted = DMatrix::from_fn(n, self.n_active(), |j, p| {
            self.rigid_contact_integrals[p][j] * weight(j)
        });
        let wanted = DVector::from_fn(n, |j, _| distances[j] * weight(j));
        let svd = weighted.svd(true, true);
        let least = NULL_MODE_SHARE * svd.singular_values.max();
        let motion = svd.solve(&wanted, least);
        motion.map_or_else(|_| vec![0.0; self.n_active()], |a| a.data.into())
    }

    /// d − G α of distances d in m³; zero where it is no more than rounding of its terms.
    fn distances_after(&self, motion: &[f64], distances: &[f64]) -> Vec<f64> {
        let left = distances.iter().enumerate().map(|(j, distance)| {
            let parts = self.integrals.iter().zip(motion).map(|(g, by)| g[j] * by);
            let size = distance.abs() + parts.clone().map(f64::abs).sum::<f64>();
            let left = distance - parts.sum::<f64>();
            if left.abs() <= FEW_ROUNDINGS * f64::EPSILON * size {
                0.0
            } else {
                left
            }
        });
        left.collect()
    }

    /// Gᵀλ + D α in N.
    pub(crate) fn resultant_of(&self, multiplier: &[f64], motion: &[f64]) -> Vec<f64> {
        let motions = self.integrals.iter().zip(&self.support).zip(motion);
        motions
            .map(|((g, support), by)| dot(g, multiplier) + support * by)
            .collect()
    }

    /// G α in m³.
    pub(crate) fn integrals_of(&self, motion: &[f64], n_multipliers: usize) -> Vec<f64> {
        let mut sum = vec![0.0; n_multipliers];
        add_combination(&mut sum, motion, &self.integrals);
        sum
    }

    /// The slip of α at the contact nodes in m.
    pub(crate) fn add_slip(&self, motion: &[f64], slip: &mut [[f64; 2]]) {
        for (mode, by) in self.slip.iter().zip(motion) {
            add_scaled(slip.as_flattened_mut(), *by, mode.as_flattened());
        }
    }
}

impl RigidEquilibrium {
    /// The balance of a body that floats; `None` where its supports hold it.
    #[must_use]
    pub fn new(
        assembly: &Assembly,
        coupling: &Coupling,
        surface: &ContactSurface,
        interface: &Interface,
    ) -> Option<Self> {
        let body = assembly.primal.rigid_modes.as_ref()?;
        let rigid = RigidCoupling::new(body, coupling, surface, interface, assembly);
        let resultant = rigid.load_resultant(assembly);
        Some(Self {
            separation_motion: separation_motion(&rigid, &resultant, &surface.pane_area),
            coupling: Arc::new(rigid),
            resultant,
            reference: None,
        })
    }

    /// The same written about the motion that closes distances d in m³, `[n_multipliers]`.
    pub(super) fn about_closed_gap(&self, distances: &[f64], areas: &[f64]) -> Self {
        let motion = self.coupling.closing_motion(distances, areas);
        let about = self.about(&vec![0.0; distances.len()], &motion);
        Self {
            reference: Some(ReferenceMotion {
                distances: self.coupling.distances_after(&motion, distances),
                motion,
            }),
            ..about
        }
    }

    /// Whether supports resist a motion, so that a motion α strains the body by Y α.
    pub(crate) fn is_supported(&self) -> bool {
        !self.coupling.spring_response.is_empty()
    }

    /// α in terms of the modes of the body, with the reference motion added to it and to the displacement in m.
    pub(crate) fn add_reference(&self, motion: &[f64], displacement: &mut [f64]) -> Vec<f64> {
        let Some(reference) = &self.reference else {
            return self.coupling.in_modes(motion);
        };
        self.coupling.add_motion(&reference.motion, displacement);
        let mut whole = motion.to_vec();
        add_scaled(&mut whole, 1.0, &reference.motion);
        self.coupling.in_modes(&whole)
    }

    /// The unknowns α of motions in terms of the modes of the body.
    #[must_use]
    pub fn unknown_motion(&self, modes: &[f64]) -> Vec<f64> {
        let rows = self.coupling.coordinates.iter();
        let mut motion: Vec<f64> = rows.map(|row| dot(row, modes)).collect();
        if let Some(reference) = &self.reference {
            add_scaled(&mut motion, -1.0, &reference.motion);
        }
        motion
    }

    /// The same about an anchor (λ₀, α₀).
    pub(super) fn about(&self, multiplier: &[f64], motion: &[f64]) -> Self {
        Self {
            resultant: self.equilibrium_residual(multiplier, motion),
            ..self.clone()
        }
    }

    /// The same written about zero again.
    pub(super) fn absolute(&self, multiplier: &[f64], motion: &[f64]) -> Self {
        let opposite = |values: &[f64]| values.iter().map(|v| -v).collect::<Vec<f64>>();
        self.about(&opposite(multiplier), &opposite(motion))
    }

    /// Number of motions that contact or supports act on.
    pub(crate) fn n_active(&self) -> usize {
        self.coupling.n_active()
    }

    /// The same with the force −k (α − α₀) on each active motion, for k in N/m and α₀ in m beside the anchor, `[n_active]`.
    pub(super) fn with_proximal_term(&self, stiffness: &[f64], centre: &[f64]) -> Self {
        let mut coupling = RigidCoupling::clone(&self.coupling);
        add_scaled(&mut coupling.support, 1.0, stiffness);
        let mut resultant = self.resultant.clone();
        let terms = resultant.iter_mut().zip(stiffness).zip(centre);
        terms.for_each(|((e, k), centre)| *e += k * centre);
        Self {
            coupling: Arc::new(coupling),
            resultant,
            ..self.clone()
        }
    }

    /// ρ of the rows Gᵀλ + D α − e in Pa/N: rows times ρ are the distance of λ from the plane Gᵀλ = e; for motions that supports
    /// alone feel as for that which contact feels most.
    pub(crate) fn steplengths(&self) -> impl Iterator<Item = f64> + '_ {
        let norms = || {
            self.coupling
                .rigid_contact_integrals
                .iter()
                .map(|g| norm(g))
        };
        let largest = norms().fold(0.0, f64::max);
        // Where the face feels none, any unit serves: no row has a multiplier.
        let usual = if largest > 0.0 { largest } else { 1.0 };
        norms().map(move |size| {
            if size > NULL_MODE_SHARE * largest {
                size.recip()
            } else {
                usual.recip()
            }
        })
    }

    /// Σ |G α| of a multiplier's row over the motions in m³, whose rounding G α has.
    pub(crate) fn size_of_motion(&self, row: usize, motion: &[f64]) -> f64 {
        let terms = self.coupling.integrals.iter().zip(motion);
        terms.map(|(g, by)| (g[row] * by).abs()).sum()
    }

    /// e − Gᵀλ − D α in N.
    pub(crate) fn equilibrium_residual(&self, multiplier: &[f64], motion: &[f64]) -> Vec<f64> {
        let carried = self.coupling.resultant_of(multiplier, motion);
        let pairs = self.resultant.iter().zip(carried);
        pairs.map(|(e, carried)| e - carried).collect()
    }

    /// ‖e − Gᵀλ‖ / ‖e‖ of the motions that no support resists, mode by mode beside what λ carries; 0 for 0/0.
    pub(crate) fn relative_equilibrium_residual(&self, multiplier: &[f64]) -> f64 {
        let rows = self.coupling.integrals.iter().zip(&self.resultant);
        rows.skip(self.coupling.n_supported())
            .map(|(g, e)| {
                let size = e.abs().max(norm(g) * norm(multiplier));
                match (e - dot(g, multiplier)).abs() {
                    0.0 => 0.0,
                    excess => excess / size,
                }
            })
            .fold(0.0, f64::max)
    }
}
