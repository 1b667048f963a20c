//! Contact springs in the stiffness, for slender bodies that lie on their foundation and are clamped: the augmented Lagrangian.
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

use super::{
    Assembly, AssemblySeconds, ContactSystem, DualSystem, OperatorEstimate, OperatorForm,
    PrimalSystem, Requirement, SMALL_MEMORY, pane_stiffness,
};
use crate::{
    contact::Interface,
    linalg::{CscMatrix, Doubled, Factor, FactorStructure, Precision, Work, add_scaled, ratio},
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

impl DualSystem {
    /// The problem with contact springs, if gaps lose their digits without them; `None` for others, for bodies without a factor in double
    /// precision or without supports that hold them, and where S is not dense. Its load is l + Bᵀσ gap.
    #[must_use]
    pub(crate) fn with_contact_springs(&self, face: (&ContactSurface, &Interface)) -> Option<Self> {
        let Assembly { primal, factor, .. } = &self.assembly;
        let contact = self.contact.as_ref()?;
        let dual = contact.explicit()?;
        if factor.precision() == Precision::Single || primal.rigid_modes.is_some() {
            return None;
        }
        let stiffness = pane_stiffness(primal, &contact.coupling);
        let panes = stiffness.iter().enumerate();
        let ratio = panes.map(|(j, own)| own * dual.diagonal(j));
        if ratio.fold(0.0, f64::max) < LEAST_RATIO
            || self.rounding_of_gaps(contact, &stiffness, face.0) < GAP_ROUNDING
        {
            return None;
        }
        let shared = || self.make_contact_springs(contact, &stiffness, face);
        let mut system = self.contact_springs.get_or_init(shared).clone()?;
        let springs = system
            .contact
            .as_ref()?
            .explicit()?
            .contact_springs
            .clone()?;
        let distances = contact.distances(&primal.dofs, face.0, face.1);
        let closing: Vec<f64> = distances
            .iter()
            .zip(&*springs)
            .map(|(d, s)| d * s)
            .collect();
        let PrimalSystem { dofs, load, .. } = &mut system.assembly.primal;
        dofs.prescribed.clone_from(&primal.dofs.prescribed);
        *load = contact.coupling.nodal_forces(&closing);
        add_scaled(load, 1.0, &primal.load);
        system.update_rhs(face);
        Some(system)
    }

    /// A_σ with its factor, S_σ and H, which all loads share; `None` where they take memory that matters, which nothing admitted.
    fn make_contact_springs(
        &self,
        contact: &ContactSystem,
        stiffness: &[f64],
        face: (&ContactSurface, &Interface),
    ) -> Option<Self> {
        let Assembly { primal, factor, .. } = &self.assembly;
        let coupling = contact.coupling.clone();
        let springs: Vec<f64> = stiffness.iter().map(|own| SPRING_SHARE * own).collect();
        let a = added(&primal.stiffness, &coupling.transposed, &springs);
        let order = factor.structure().permutation.clone();
        let structure = FactorStructure::analyse(&a, order).ok()?;
        let dense = OperatorEstimate::new(&structure, &coupling, face.0.nodes.len());
        let need = Requirement::of_factor(&a, &structure, Precision::Double, Some(&dense));
        if need.memory as f64 > SMALL_MEMORY {
            return None;
        }
        let unwatched = Work::default();
        let factor = Factor::of_structure(structure, &a, Precision::Double, &unwatched).ok()?;
        let assembly = Assembly {
            primal: PrimalSystem {
                stiffness: Arc::new(a),
                ..primal.clone()
            },
            factor: Arc::new(factor),
            seconds: AssemblySeconds::default(),
        };
        let mut contact = ContactSystem {
            coupling,
            unconstrained: Vec::new(),
            form: OperatorForm::implicit(Vec::new()),
        };
        contact.make_explicit(&assembly, &primal.load, face, &unwatched);
        contact.explicit_mut()?.contact_springs = Some(Arc::new(springs));
        Some(Self::of(assembly, Some(contact)))
    }

    /// What rounding of A⁻¹l makes of contact stresses, relative to the stress that the load is on the face.
    fn rounding_of_gaps(
        &self,
        contact: &ContactSystem,
        stiffness: &[f64],
        surface: &ContactSurface,
    ) -> f64 {
        let assembly = &self.assembly;
        let PrimalSystem {
            stiffness: a, load, ..
        } = &assembly.primal;
        let solved = Doubled::from(assembly.unconstrained());
        let error = assembly.solve(&a.symmetric_residual(&solved, load));
        let moved = contact.coupling.integrate(&error);
        let stresses = moved.iter().zip(stiffness).map(|(r, rho)| (r * rho).abs());
        let area: f64 = surface.pane_area.iter().sum();
        let forces: f64 = load.iter().map(|force| force.abs()).sum();
        ratio(stresses.fold(0.0, f64::max) * area, forces)
    }
}

/// A + Bᵀ diag(σ) B for Bᵀ, symmetric to the last bit as A is.
fn added(a: &CscMatrix, transposed: &CscMatrix, springs: &[f64]) -> CscMatrix {
    let panes = transposed.transpose();
    let mut sum = CscMatrix::empty(a.rows);
    for column in 0..a.cols {
        let mut entries: BTreeMap<usize, f64> = a.entries(column).collect();
        for (pane, here) in panes.entries(column) {
            for (row, there) in transposed.entries(pane) {
                *entries.entry(row).or_default() += springs[pane] * (here * there);
            }
        }
        sum.push_column(entries);
    }
    sum
}
