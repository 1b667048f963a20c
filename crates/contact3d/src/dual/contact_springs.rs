//! Contact springs in the stiffness, for slender bodies that contact holds: the augmented Lagrangian.
//!
//! A long strip on its foundation bends so easily without it that S = B A⁻¹Bᵀ and h are some 10¹⁰ times larger than what panes feel of each
//! other, and gaps lose that many digits. With springs σ between panes and foundation,
//!
//!   A_σ = A + Bᵀ diag(σ) B,   S_σ = B A_σ⁻¹Bᵀ,   h_σ = B A_σ⁻¹(l + Bᵀσ gap) − gap,
//!
//! and the unknown μ = λ + σ r, the same gap is r = S_σ μ − h_σ, and λ = μ − σ r are the contact stresses: exact for any σ > 0, since
//! A_σ u = l + Bᵀσ gap − Bᵀμ is A u = l − Bᵀλ. Eigenvalues of S_σ are at most 1/σ: with σ a share s of the panes' stiffness its
//! condition is about 1/s where that of S is 10¹⁰. Tangential components have springs too.
//!
//! Source: R. Glowinski, P. Le Tallec, *Augmented Lagrangian and Operator-Splitting Methods in Nonlinear Mechanics*, SIAM 1989.

use std::{collections::BTreeMap, sync::Arc};

use super::{Assembly, AssemblySeconds, ContactSystem, DualSystem, PrimalSystem, pane_stiffness};
use crate::{
    contact::Interface,
    linalg::{
        CholeskyFactor, CscMatrix, Doubled, Factor, Precision, Work, add_scaled, norm, ratio,
    },
    mesh::ContactSurface,
};

/// σ as a share of the stiffness of single panes. Strips of 100 : 1 to 4000 : 1 keep ten digits with 5e-4 to 5e-6. With 0.05 the springs of
/// panes that are far open hide the stresses of others.
const SPRING_SHARE: f64 = 1e-5;

/// The rounding of gaps as a share of the load's stress from which springs are worth a second factor: ordinary scenes have 1e-10, strips 1e-2.
const GAP_ROUNDING: f64 = 1e-8;

/// Most times further that a pane moves with the body than against its neighbours where rounding of gaps cannot reach [`GAP_ROUNDING`]: those
/// 1e-16 of a displacement are 1e-8 of a stress from 1e8 on, and solves lose some digits.
const LEAST_RATIO: f64 = 1e4;

impl ContactSystem {
    /// The assembled problem with contact springs, if gaps lose their digits without them; `None` for others, for bodies without a
    /// factor in double precision or without supports that hold them, and where S is not dense.
    #[must_use]
    pub(crate) fn with_springs(
        &self,
        assembly: &Assembly,
        face: (&ContactSurface, &Interface),
    ) -> Option<DualSystem> {
        let primal = &assembly.primal;
        let dual = self.explicit()?;
        if assembly.factor.precision() == Precision::Single || primal.floating.is_some() {
            return None;
        }
        let mut springs = pane_stiffness(primal, &self.coupling);
        let panes = springs.iter().enumerate();
        let ratio = panes.map(|(j, own)| own * dual.diagonal(j));
        if ratio.fold(0.0, f64::max) < LEAST_RATIO
            || self.rounding_of_gaps(assembly, &springs, face.0) < GAP_ROUNDING
        {
            return None;
        }
        springs.iter_mut().for_each(|own| *own *= SPRING_SHARE);
        let (surface, interface) = face;
        let mut distances = self.distances(&primal.dofs, surface, interface);
        distances.resize(springs.len(), 0.0);
        let stiffness = added(&primal.stiffness, &self.coupling.transposed, &springs);
        let order = assembly.factor.structure().permutation.clone();
        let factor = CholeskyFactor::factorise(&stiffness, order).ok()?;
        // A and l stay as they are: residuals in twice the working precision know the springs by their forces.
        let assembly = Assembly {
            primal: primal.clone(),
            factor: Arc::new(Factor::Double(factor)),
            seconds: AssemblySeconds::default(),
        };
        let closing: Vec<f64> = distances.iter().zip(&springs).map(|(d, s)| d * s).collect();
        let mut forces = self.coupling.nodal_forces(&closing);
        add_scaled(&mut forces, 1.0, &primal.load);
        let unconstrained = assembly.solve(&forces);
        let (coupling, dofs) = (self.coupling.clone(), &assembly.primal.dofs);
        let mut contact = Self::new(coupling, &unconstrained, dofs, surface, interface);
        contact.make_explicit(&assembly, &unconstrained, face, &Work::default());
        contact.explicit_mut()?.springs = Some(Arc::new(springs));
        Some(DualSystem {
            assembly,
            contact: Some(contact),
        })
    }

    /// What rounding of A⁻¹l makes of contact stresses, relative to the stress that the load is on the face.
    fn rounding_of_gaps(
        &self,
        assembly: &Assembly,
        stiffness: &[f64],
        surface: &ContactSurface,
    ) -> f64 {
        let PrimalSystem {
            stiffness: a, load, ..
        } = &assembly.primal;
        let solved = Doubled::from(assembly.unconstrained());
        let error = assembly.solve(&a.symmetric_residual(&solved, load));
        let moved = self.coupling.integrate(&error);
        let stresses = moved.iter().zip(stiffness).map(|(r, rho)| (r * rho).abs());
        let area: f64 = surface.pane_area.iter().sum();
        let forces: f64 = load.iter().map(|force| force.abs()).sum();
        ratio(stresses.fold(0.0, f64::max) * area, forces)
    }

    /// u = A_σ⁻¹(l + Bᵀσ gap − Bᵀμ) by iterative refinement: the residual is l − Bᵀλ − A u with λ = μ − σ r of the last u.
    pub(super) fn refined_with_springs(
        &self,
        springs: &[f64],
        assembly: &Assembly,
        multiplier: &[f64],
        (surface, interface): (&ContactSurface, &Interface),
    ) -> Doubled {
        let PrimalSystem {
            stiffness,
            load,
            dofs,
            ..
        } = &assembly.primal;
        let mut distances = self.distances(dofs, surface, interface);
        distances.resize(springs.len(), 0.0);
        let mut displacement = Doubled::from(vec![0.0; load.len()]);
        let mut last = f64::INFINITY;
        loop {
            let closed = self
                .coupling
                .transposed
                .transposed_excess(&displacement, &distances);
            let mut stresses = multiplier.to_vec();
            for ((stress, spring), closed) in stresses.iter_mut().zip(springs).zip(closed) {
                *stress += spring * closed;
            }
            let mut forces = self.coupling.nodal_forces(&stresses);
            for (force, load) in forces.iter_mut().zip(load) {
                *force = load - *force;
            }
            let correction = assembly.solve(&stiffness.symmetric_residual(&displacement, &forces));
            let size = norm(&correction);
            // NaN ends here too.
            if !(size > 0.0 && size < 0.5 * last) {
                return displacement;
            }
            displacement.add(&correction);
            last = size;
        }
    }

    /// μ = λ + σ r of stresses with their displacement.
    #[must_use]
    pub(crate) fn augmented(
        &self,
        multiplier: &[f64],
        displacement: &[f64],
        assembly: &Assembly,
        (surface, interface): (&ContactSurface, &Interface),
    ) -> Vec<f64> {
        let mut unknowns = multiplier.to_vec();
        let springs = self.explicit().and_then(|dual| dual.springs.as_ref());
        if let Some(springs) = springs {
            let dofs = &assembly.primal.dofs;
            let closed = self.gap_residual(displacement, dofs, surface, interface);
            for ((unknown, spring), closed) in unknowns.iter_mut().zip(springs.iter()).zip(closed) {
                *unknown -= spring * closed;
            }
        }
        unknowns
    }
}

/// A + Bᵀ diag(σ) B for Bᵀ, symmetric to the last bit as A is.
fn added(a: &CscMatrix, transposed: &CscMatrix, springs: &[f64]) -> CscMatrix {
    let panes = transposed.transpose();
    let mut sum = CscMatrix::empty(a.rows);
    sum.cols = a.cols;
    for column in 0..a.cols {
        let mut entries: BTreeMap<usize, f64> = a.entries(column).collect();
        for (pane, here) in panes.entries(column) {
            for (row, there) in transposed.entries(pane) {
                *entries.entry(row).or_default() += springs[pane] * (here * there);
            }
        }
        sum.indices.extend(entries.keys());
        sum.data.extend(entries.values());
        sum.indptr.push(sum.indices.len());
    }
    sum
}
