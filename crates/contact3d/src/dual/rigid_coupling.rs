//! What contact does to the rigid modes of a body that floats.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::Assembly;
use crate::{
    contact::{Coupling, Interface, MultiplierLayout, nodal_tangential_change},
    elasticity::FloatingBody,
    linalg::{add_scaled, dot, norm},
    mesh::ContactSurface,
};

/// Share of the largest effect of a rigid motion on the contact face below which it has none: rounding of coordinates, with
/// room, and no motion that a face resists.
const UNFELT: f64 = 1e-10;

/// Share of the largest stiffness of the supports in a motion below which they do not resist it: rounding.
const UNRESISTED: f64 = 1e-13;

/// The rigid motions that contact or weak supports feel, and what they do to the contact face.
///
/// Contact without friction on a plane does not feel motions along it, and a single pane feels no rotation about its centroid. Such
/// motions are neutral: their α are zero in every answer (the least motion), and a load that works on them has no equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidCoupling {
    body: Arc<FloatingBody>,
    /// The order of the multipliers.
    pub(crate) layout: MultiplierLayout,
    /// Motions that contact or supports feel, orthonormal in terms of the modes of the body, `[n_felt][n_modes]`.
    felt: Vec<Vec<f64>>,
    /// The others, likewise, `[n_modes − n_felt][n_modes]`.
    unfelt: Vec<Vec<f64>>,
    /// The stiffness D of the supports in each felt motion in N/m, `[n_felt]`; zeros where none resist.
    pub(crate) support: Vec<f64>,
    /// G = B R of the felt motions, `[n_felt][n_multipliers]`, in m².
    pub(crate) integrals: Vec<Vec<f64>>,
    /// (u_t1, u_t2) of the felt motions at the contact nodes, `[n_felt][n_contact_nodes]`.
    pub(crate) slip: Vec<Vec<[f64; 2]>>,
}

/// The condition that contact forces and weak supports balance the load, Gᵀλ + D α = e, with the rigid motions α that belong to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Balance {
    /// G and its motions.
    pub(crate) coupling: Arc<RigidCoupling>,
    /// e = Rᵀl of the felt motions, or e − Gᵀλ₀ − D α₀ about an anchor, `[n_felt]`, in N.
    pub(crate) resultant: Vec<f64>,
    /// The motion that closes the gap, where the motions α are counted from it.
    pub(crate) closed: Option<ClosedGap>,
}

/// The rigid motion α₀ that closes the gap d best, and what it leaves, d − G α₀: with the motions counted from α₀ a gap of a thousand
/// times what the body is strained takes no digits from h.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ClosedGap {
    /// α₀ in m, `[n_felt]`.
    pub(crate) motion: Vec<f64>,
    /// d − G α₀ in m³, `[n_multipliers]`; zero where it is no more than rounding of d.
    pub(crate) left: Vec<f64>,
}

impl RigidCoupling {
    fn new(
        body: &Arc<FloatingBody>,
        coupling: &Coupling,
        surface: &ContactSurface,
        interface: &Interface,
        assembly: &Assembly,
    ) -> Self {
        let of_modes: Vec<Vec<f64>> = body.modes.iter().map(|m| coupling.integrate(m)).collect();
        let MotionSpaces {
            felt,
            unfelt,
            support,
        } = MotionSpaces::new(
            &of_modes,
            body.support.as_ref(),
            &surface.pane_area,
            coupling,
        );
        let combined = |weights: &[f64]| {
            let mut displacement = vec![0.0; body.grounded.cols];
            body.add_motion(weights, &mut displacement);
            displacement
        };
        let dofs = &assembly.primal.dofs;
        let slip_of = |u: &[f64]| nodal_tangential_change(surface, &interface.frame, dofs, u);
        let displacements: Vec<Vec<f64>> = felt.iter().map(|w| combined(w)).collect();
        let mut rigid = Self {
            integrals: displacements
                .iter()
                .map(|u| coupling.integrate(u))
                .collect(),
            slip: displacements.iter().map(|u| slip_of(u)).collect(),
            body: Arc::clone(body),
            layout: coupling.layout,
            felt,
            unfelt: Vec::new(),
            support,
        };
        // What rounding left of them on the face, relative to motions of the whole body, would be slips of sticking panes.
        let neutral = unfelt.into_iter().map(|mut modes| {
            let left = coupling.integrate(&combined(&modes));
            let closed = rigid.closing(&left, &surface.pane_area);
            add_scaled(&mut modes, -1.0, &rigid.in_modes(&closed.motion));
            modes
        });
        rigid.unfelt = neutral.collect();
        rigid
    }

    /// Number of motions that contact or supports feel.
    pub(crate) fn n_felt(&self) -> usize {
        self.felt.len()
    }

    /// Number of felt motions that supports resist; they come first.
    pub(crate) fn n_resisted(&self) -> usize {
        self.support.iter().filter(|d| **d > 0.0).count()
    }

    /// The motion in terms of the modes of the body, `[n_modes]`, of that in terms of felt ones.
    pub(crate) fn in_modes(&self, motion: &[f64]) -> Vec<f64> {
        let mut modes = vec![0.0; self.body.n_modes()];
        for (weights, by) in self.felt.iter().zip(motion) {
            for (sum, weight) in modes.iter_mut().zip(weights) {
                *sum += by * weight;
            }
        }
        modes
    }

    /// The motion in terms of felt ones of that in terms of the modes of the body.
    pub(crate) fn in_felt(&self, modes: &[f64]) -> Vec<f64> {
        self.felt
            .iter()
            .map(|weights| dot(weights, modes))
            .collect()
    }

    /// The displacements of the free degrees of freedom in the neutral motions, `[n_modes − n_felt][n_free]`.
    pub(crate) fn neutral_motions(&self) -> Vec<Vec<f64>> {
        let motion = |modes: &Vec<f64>| {
            let mut displacement = vec![0.0; self.body.grounded.cols];
            self.body.add_motion(modes, &mut displacement);
            displacement
        };
        self.unfelt.iter().map(motion).collect()
    }

    /// Adds R α.
    pub(crate) fn add_motion(&self, motion: &[f64], displacement: &mut [f64]) {
        self.body.add_motion(&self.in_modes(motion), displacement);
    }

    /// Takes the neutral motions out of a displacement, by least squares over its degrees of freedom, and out of its α in terms of the
    /// modes.
    pub(crate) fn remove_neutral(&self, displacement: &mut [f64], modes: &mut [f64]) {
        let motions = self.neutral_motions();
        let n = motions.len();
        let gram = DMatrix::from_fn(n, n, |p, q| dot(&motions[p], &motions[q]));
        let along = DVector::from_fn(n, |p, _| dot(&motions[p], displacement));
        let Some(factor) = gram.cholesky() else {
            return;
        };
        for ((motion, weights), by) in motions.iter().zip(&self.unfelt).zip(&factor.solve(&along)) {
            add_scaled(displacement, -by, motion);
            add_scaled(modes, -by, weights);
        }
    }

    /// The motion that closes distances d in m³, `[n_multipliers]`, by least squares over the contact face.
    fn closing(&self, distances: &[f64], areas: &[f64]) -> ClosedGap {
        const ROUNDINGS: f64 = 16.0;
        if self.n_felt() == 0 {
            return ClosedGap {
                motion: Vec::new(),
                left: distances.to_vec(),
            };
        }
        let weight = |j: usize| areas[self.layout.pane_of(j)].sqrt().recip();
        let n = distances.len();
        let weighted = DMatrix::from_fn(n, self.n_felt(), |j, p| self.integrals[p][j] * weight(j));
        let wanted = DVector::from_fn(n, |j, _| distances[j] * weight(j));
        let svd = weighted.svd(true, true);
        let least = UNFELT * svd.singular_values.max();
        let motion = svd.solve(&wanted, least);
        let motion = motion.map_or_else(|_| vec![0.0; self.n_felt()], |a| a.data.into());
        let left = distances.iter().enumerate().map(|(j, distance)| {
            let parts = self.integrals.iter().zip(&motion).map(|(g, by)| g[j] * by);
            let size = distance.abs() + parts.clone().map(f64::abs).sum::<f64>();
            let left = distance - parts.sum::<f64>();
            if left.abs() <= ROUNDINGS * f64::EPSILON * size {
                0.0
            } else {
                left
            }
        });
        ClosedGap {
            left: left.collect(),
            motion,
        }
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
        for (integrals, by) in self.integrals.iter().zip(motion) {
            for (sum, g) in sum.iter_mut().zip(integrals) {
                *sum += by * g;
            }
        }
        sum
    }

    /// The slip of α at the contact nodes in m.
    pub(crate) fn add_slip(&self, motion: &[f64], slip: &mut [[f64; 2]]) {
        for (mode, by) in self.slip.iter().zip(motion) {
            for (slip, moved) in slip.iter_mut().zip(mode) {
                slip[0] += by * moved[0];
                slip[1] += by * moved[1];
            }
        }
    }
}

impl Balance {
    /// The balance of a body that floats; `None` where its supports hold it.
    #[must_use]
    pub fn new(
        assembly: &Assembly,
        coupling: &Coupling,
        surface: &ContactSurface,
        interface: &Interface,
    ) -> Option<Self> {
        let body = assembly.primal.floating.as_ref()?;
        let rigid = RigidCoupling::new(body, coupling, surface, interface, assembly);
        let resultant = rigid.in_felt(&body.resultant(&assembly.primal.load));
        Some(Self {
            coupling: Arc::new(rigid),
            resultant,
            closed: None,
        })
    }

    /// The same with motions counted from that which closes distances d in m³, `[n_multipliers]`.
    pub(super) fn with_closed_gap(&self, distances: &[f64], areas: &[f64]) -> Self {
        let closed = self.coupling.closing(distances, areas);
        let nothing = vec![0.0; distances.len()];
        Self {
            closed: Some(closed.clone()),
            ..self.anchored(&nothing, &closed.motion)
        }
    }

    /// α of the motions counted from zero, in terms of the modes of the body, and R α₀ of the closed gap added to the displacement.
    pub(crate) fn counted_from_zero(&self, motion: &[f64], displacement: &mut [f64]) -> Vec<f64> {
        let Some(closed) = &self.closed else {
            return self.coupling.in_modes(motion);
        };
        self.coupling.add_motion(&closed.motion, displacement);
        let sums = motion.iter().zip(&closed.motion).map(|(a, by)| a + by);
        self.coupling.in_modes(&sums.collect::<Vec<f64>>())
    }

    /// The unknowns α of motions in terms of the modes of the body.
    pub(crate) fn unknown_motion(&self, modes: &[f64]) -> Vec<f64> {
        let mut motion = self.coupling.in_felt(modes);
        if let Some(closed) = &self.closed {
            add_scaled(&mut motion, -1.0, &closed.motion);
        }
        motion
    }

    /// The same about an anchor (λ₀, α₀).
    pub(super) fn anchored(&self, multiplier: &[f64], motion: &[f64]) -> Self {
        Self {
            coupling: Arc::clone(&self.coupling),
            resultant: self.excess(multiplier, motion),
            closed: self.closed.clone(),
        }
    }

    /// The same written about zero again.
    pub(super) fn without_anchor(&self, multiplier: &[f64], motion: &[f64]) -> Self {
        let opposite = |values: &[f64]| values.iter().map(|v| -v).collect::<Vec<f64>>();
        self.anchored(&opposite(multiplier), &opposite(motion))
    }

    /// Number of motions that contact or supports feel.
    pub(crate) fn n_felt(&self) -> usize {
        self.coupling.n_felt()
    }

    /// The same with springs at the pins beside the supports, `share` times those of A_κ.
    pub(super) fn on_springs(&self, share: f64) -> Self {
        let mut coupling = RigidCoupling::clone(&self.coupling);
        let spring = share * coupling.body.spring;
        coupling.support.iter_mut().for_each(|d| *d += spring);
        Self {
            coupling: Arc::new(coupling),
            resultant: self.resultant.clone(),
            closed: self.closed.clone(),
        }
    }

    /// ‖D α‖ beside the load ‖e‖: what the supports carry.
    pub(crate) fn share_of_supports(&self, motion: &[f64]) -> f64 {
        let carried = self
            .coupling
            .support
            .iter()
            .zip(motion)
            .map(|(d, by)| d * by);
        norm(&carried.collect::<Vec<f64>>()) / norm(&self.resultant)
    }

    /// ρ of the rows Gᵀλ + D α − e in Pa/N: rows times ρ are the distance of λ from the plane Gᵀλ = e; for motions that supports
    /// alone feel as for that which contact feels most.
    pub(crate) fn steplengths(&self) -> impl Iterator<Item = f64> + '_ {
        let norms = || self.coupling.integrals.iter().map(|g| norm(g));
        let largest = norms().fold(0.0, f64::max);
        norms().map(move |size| match size > UNFELT * largest {
            true => size.recip(),
            false => largest.recip(),
        })
    }

    /// e − Gᵀλ − D α in N.
    pub(crate) fn excess(&self, multiplier: &[f64], motion: &[f64]) -> Vec<f64> {
        let carried = self.coupling.resultant_of(multiplier, motion);
        let pairs = self.resultant.iter().zip(carried);
        pairs.map(|(e, carried)| e - carried).collect()
    }

    /// ‖e − Gᵀλ‖ / ‖e‖ of the motions that no support resists, mode by mode beside what λ carries; 0 for 0/0.
    pub(crate) fn relative_excess(&self, multiplier: &[f64]) -> f64 {
        let rows = self.coupling.integrals.iter().zip(&self.resultant);
        rows.skip(self.coupling.n_resisted())
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

/// Where all motions are felt and no support resists, the modes themselves.
struct MotionSpaces {
    felt: Vec<Vec<f64>>,
    unfelt: Vec<Vec<f64>>,
    support: Vec<f64>,
}

impl MotionSpaces {
    /// From B R, `[n_modes][n_multipliers]`, and D. A motion is felt if it moves the contact face, in the mean square over it, or
    /// supports resist it.
    fn new(
        of_modes: &[Vec<f64>],
        support: Option<&Vec<Vec<f64>>>,
        areas: &[f64],
        coupling: &Coupling,
    ) -> Self {
        let k = of_modes.len();
        let weight = |j: usize| areas[coupling.layout.pane_of(j)].sqrt().recip();
        // As many rows as columns at least, so that no vector is missing.
        let n_rows = coupling.layout.n_multipliers().max(k);
        let on_face = DMatrix::from_fn(n_rows, k, |j, p| {
            of_modes[p].get(j).map_or(0.0, |value| value * weight(j))
        });
        let felt_of = |space: &DMatrix<f64>, largest: f64| {
            let svd = (&on_face * space).svd(false, true);
            let largest = largest.max(svd.singular_values.max());
            let vectors = space * svd.v_t.expect("asked for").transpose();
            let is_felt = |p: &usize| svd.singular_values[*p] > UNFELT * largest;
            let (felt, unfelt): (Vec<usize>, Vec<usize>) = (0..space.ncols()).partition(is_felt);
            let [felt, unfelt] = [felt, unfelt].map(|columns| vectors.select_columns(&columns));
            (felt, unfelt)
        };
        let whole = DMatrix::identity(k, k);
        let Some(support) = support else {
            let (on_face, off_face) = felt_of(&whole, 0.0);
            let felt = if off_face.ncols() == 0 {
                whole
            } else {
                on_face
            };
            return Self {
                support: vec![0.0; felt.ncols()],
                felt: columns(&felt),
                unfelt: columns(&off_face),
            };
        };
        let support = &DMatrix::from_fn(k, k, |p, q| support[p][q]);
        // What supports resist first: of the rest, contact feels no more motions than it has multipliers.
        let (held, free, stiffness) = by_support(support);
        let (free, unfelt) = if free.ncols() == 0 {
            (free.clone(), free)
        } else {
            felt_of(&free, on_face.singular_values().max())
        };
        Self {
            support: [stiffness, vec![0.0; free.ncols()]].concat(),
            felt: [columns(&held), columns(&free)].concat(),
            unfelt: columns(&unfelt),
        }
    }
}

/// Orthonormal bases of the motions that supports resist and of those that they do not, and the stiffness of the former in N/m.
fn by_support(support: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>, Vec<f64>) {
    let eigen = support.clone().symmetric_eigen();
    let least = UNRESISTED * support.diagonal().max();
    let (held, free): (Vec<usize>, Vec<usize>) =
        (0..support.ncols()).partition(|&p| eigen.eigenvalues[p] > least);
    (
        eigen.eigenvectors.select_columns(&held),
        eigen.eigenvectors.select_columns(&free),
        held.iter().map(|&p| eigen.eigenvalues[p]).collect(),
    )
}

fn columns(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let columns = matrix.column_iter();
    columns.map(|c| c.iter().copied().collect()).collect()
}
