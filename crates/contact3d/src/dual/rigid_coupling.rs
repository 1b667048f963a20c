//! What contact does to the rigid modes of a body that floats.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::Assembly;
use crate::{
    contact::{Coupling, Interface, MultiplierLayout, nodal_tangential_change},
    elasticity::FloatingBody,
    linalg::{dot, norm},
    mesh::ContactSurface,
};

/// Share of the largest effect of a rigid motion on the contact face below which it has none: rounding of coordinates, with
/// room, and no motion that a face resists.
const UNFELT: f64 = 1e-10;

/// The rigid motions that contact feels, and what they do to the contact face.
///
/// Contact without friction on a plane does not feel motions along it; those α are zero in every answer (the least motion), and
/// a load that works on them has no equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidCoupling {
    body: Arc<FloatingBody>,
    /// The order of the multipliers.
    pub(crate) layout: MultiplierLayout,
    /// Motions that contact feels, in terms of the modes of the body, `[n_felt][n_modes]`.
    felt: Vec<Vec<f64>>,
    /// The others, orthonormal, `[n_modes − n_felt][n_modes]`.
    unfelt: Vec<Vec<f64>>,
    /// G = B R of the felt motions, `[n_felt][n_multipliers]`, in m².
    pub(crate) integrals: Vec<Vec<f64>>,
    /// (u_t1, u_t2) of the felt motions at the contact nodes, `[n_felt][n_contact_nodes]`.
    pub(crate) slip: Vec<Vec<[f64; 2]>>,
}

/// The condition that contact forces balance the load, Gᵀλ = e, with the rigid motions α that belong to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Balance {
    /// G and its motions.
    pub(crate) coupling: Arc<RigidCoupling>,
    /// e = Rᵀl of the felt motions, or e − Gᵀλ₀ about an anchor, `[n_felt]`, in N.
    pub(crate) resultant: Vec<f64>,
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
        let (felt, unfelt) = split(&of_modes, &surface.pane_area, coupling);
        let combined = |weights: &[f64]| {
            let mut displacement = vec![0.0; body.grounded.cols];
            body.add_motion(weights, &mut displacement);
            displacement
        };
        let dofs = &assembly.primal.dofs;
        let slip_of = |u: &[f64]| nodal_tangential_change(surface, &interface.frame, dofs, u);
        let displacements: Vec<Vec<f64>> = felt.iter().map(|w| combined(w)).collect();
        Self {
            integrals: displacements
                .iter()
                .map(|u| coupling.integrate(u))
                .collect(),
            slip: displacements.iter().map(|u| slip_of(u)).collect(),
            body: Arc::clone(body),
            layout: coupling.layout,
            felt,
            unfelt,
        }
    }

    /// Number of motions that contact feels.
    pub(crate) fn n_felt(&self) -> usize {
        self.felt.len()
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

    /// The motions that contact does not feel, in terms of the modes, orthonormal.
    pub(crate) fn unfelt(&self) -> &[Vec<f64>] {
        &self.unfelt
    }

    /// Adds R α.
    pub(crate) fn add_motion(&self, motion: &[f64], displacement: &mut [f64]) {
        self.body.add_motion(&self.in_modes(motion), displacement);
    }

    /// Gᵀλ in N.
    pub(crate) fn resultant_of(&self, multiplier: &[f64]) -> Vec<f64> {
        self.integrals.iter().map(|g| dot(g, multiplier)).collect()
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
        })
    }

    /// The same about an anchor λ₀.
    pub(super) fn anchored(&self, multiplier: &[f64]) -> Self {
        let carried = self.coupling.resultant_of(multiplier);
        let pairs = self.resultant.iter().zip(carried);
        Self {
            coupling: Arc::clone(&self.coupling),
            resultant: pairs.map(|(e, carried)| e - carried).collect(),
        }
    }

    /// The same written about zero again.
    pub(super) fn without_anchor(&self, anchor: &[f64]) -> Self {
        let opposite: Vec<f64> = anchor.iter().map(|l| -l).collect();
        self.anchored(&opposite)
    }

    /// Number of motions that contact feels.
    pub(crate) fn n_felt(&self) -> usize {
        self.coupling.n_felt()
    }

    /// ρ of the rows Gᵀλ − e in Pa/N: rows times ρ are the distance of λ from the plane Gᵀλ = e.
    pub(crate) fn steplengths(&self) -> impl Iterator<Item = f64> + '_ {
        self.coupling.integrals.iter().map(|g| norm(g).recip())
    }

    /// e − Gᵀλ in N.
    pub(crate) fn excess(&self, multiplier: &[f64]) -> Vec<f64> {
        let carried = self.coupling.resultant_of(multiplier);
        self.resultant
            .iter()
            .zip(carried)
            .map(|(e, g)| e - g)
            .collect()
    }

    /// ‖e − Gᵀλ‖ / ‖e‖, mode by mode beside what λ carries; 0 for 0/0.
    pub(crate) fn relative_excess(&self, multiplier: &[f64]) -> f64 {
        let rows = self.coupling.integrals.iter().zip(&self.resultant);
        rows.map(|(g, e)| {
            let size = e.abs().max(norm(g) * norm(multiplier));
            match (e - dot(g, multiplier)).abs() {
                0.0 => 0.0,
                excess => excess / size,
            }
        })
        .fold(0.0, f64::max)
    }
}

/// The motions that the contact face feels and those that it does not, by the eigenvectors of GᵀG over areas.
fn split(
    of_modes: &[Vec<f64>],
    areas: &[f64],
    coupling: &Coupling,
) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let k = of_modes.len();
    let area = |j: usize| areas[coupling.layout.pane_of(j)];
    let product = |a: &[f64], b: &[f64]| -> f64 {
        let terms = a.iter().zip(b).enumerate();
        terms.map(|(j, (a, b))| a * b / area(j)).sum()
    };
    let gram = DMatrix::from_fn(k, k, |p, q| product(&of_modes[p], &of_modes[q]));
    let eigen = gram.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let is_felt = |value: f64| value > UNFELT * UNFELT * largest && value > 0.0;
    if eigen.eigenvalues.iter().all(|value| is_felt(*value)) {
        let unit = |p: usize| (0..k).map(|q| if p == q { 1.0 } else { 0.0 }).collect();
        return ((0..k).map(unit).collect(), Vec::new());
    }
    let vectors = |wanted: bool| -> Vec<Vec<f64>> {
        (0..k)
            .filter(|&p| is_felt(eigen.eigenvalues[p]) == wanted)
            .map(|p| eigen.eigenvectors.column(p).iter().copied().collect())
            .collect()
    };
    (vectors(true), vectors(false))
}
