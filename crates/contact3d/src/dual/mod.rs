//! The dual operator S = B A⁻¹ Bᵀ and right-hand side h = B A⁻¹ l − gap (HKL (4.5)).
//!
//! Eliminating u = A⁻¹(l − Bᵀλ) leaves a problem for the multipliers alone: minimise ½ λᵀSλ − λᵀh. S has two forms:
//! dense, S = WᵀW with W = L⁻¹PBᵀ, beside the compliance H = C A⁻¹Bᵀ that gives contact displacements without the
//! body; or implicit, two triangular solves for each application, where a dense one does not fit. [`Requirement`] counts
//! memory, disk and operations of either before they are spent.
//!
//! Where the factor is in single precision, so are S and H, except in the few modes of the body's motion as a whole, where they come from
//! solves in double precision.
//!
//! [`LocalStiffness`] is (S⁻¹)_ii, what one pane feels apart from the motion of the body as a whole: the unit in which
//! residuals are judged, since 1/S_ii says nothing on a body that nearly floats.

mod aggregates;
mod assembly;
mod contact;
mod contact_springs;
mod dense;
mod explicit;
mod local_stiffness;
mod motion_spaces;
mod need;
mod operators;
mod rigid_coupling;
mod system;

pub(crate) use aggregates::Aggregates;
pub use assembly::{Assembly, AssemblyError, AssemblySeconds, PrimalSystem};
pub use contact::{ContactCompliance, ContactSystem, OperatorForm};
pub use explicit::ExplicitDual;
pub(crate) use explicit::stresses_between;
pub(crate) use local_stiffness::friction_stiffness;
pub use local_stiffness::{LocalStiffness, pane_stiffness};
pub(crate) use need::SMALL_MEMORY;
pub use need::{InsufficientResource, OperatorEstimate, Requirement, Resource};
pub use operators::{BalancedOperator, ContactOperator};
pub use rigid_coupling::{RigidCoupling, RigidEquilibrium};
pub use system::{Assembling, DualSystem};

use crate::linalg::add_scaled;

/// Applications of the dual problem: minimise ½ λᵀSλ − λᵀh over the admissible multipliers.
pub trait DualOperator {
    /// Number of multipliers: 3m, or m without friction.
    fn dimension(&self) -> usize;
    /// The right-hand side h in m³.
    fn rhs(&self) -> &[f64];
    /// S λ in m³ (λ in Pa).
    fn apply(&mut self, multiplier: &[f64]) -> Vec<f64>;
    /// r = S λ − h in m³.
    fn gradient(&mut self, multiplier: &[f64]) -> Vec<f64> {
        let mut gradient = self.apply(multiplier);
        add_scaled(&mut gradient, -1.0, self.rhs());
        gradient
    }
    /// Applications of A⁻¹ so far (n_A of HKL §4), those of a dense S included.
    fn applications(&self) -> usize;
}

/// A dual operator with a body behind it.
pub trait PrimalOperator: DualOperator {
    /// The displacement u = A⁻¹(l − Bᵀλ) over the free degrees of freedom in m.
    fn to_primal(&mut self, multiplier: &[f64]) -> Vec<f64>;
    /// Signed (u_t1, u_t2) at the contact nodes in m, `[n_contact_nodes]`, when the operator knows
    /// them without a solve over the body; `None` when only [`Self::to_primal`] gives them.
    fn tangential_displacement(&mut self, multiplier: &[f64]) -> Option<Vec<[f64; 2]>>;
}

/// The dual operator of a body.
pub enum BodyOperator<'o, 'a> {
    /// Of one that its supports hold.
    Constrained(&'o mut (dyn PrimalOperator + 'a)),
    /// Of one that floats.
    Floating(&'o mut BalancedOperator<'a>),
}

impl BodyOperator<'_, '_> {
    /// Its applications.
    pub fn as_dual(&mut self) -> &mut dyn DualOperator {
        self.as_primal()
    }

    /// Its displacements.
    pub fn as_primal(&mut self) -> &mut dyn PrimalOperator {
        match self {
            Self::Constrained(operator) => *operator,
            Self::Floating(operator) => *operator,
        }
    }
}
