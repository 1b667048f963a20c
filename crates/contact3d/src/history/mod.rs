//! Load histories: problems solved one after the other, each from where the one before left the body.
//!
//! Quasi-static friction in backward differences: in step n the conditions of friction hold for the slip
//! u_tⁿ − u_tⁿ⁻¹ of the step. In the dual problem that moves h_t by −T uⁿ⁻¹ ([`crate::contact::PreviousIncrement`]) and nothing else, so
//! all steps share the factor, S and the compliance of the contact face. Coefficients follow the total slip, that of the step, or
//! the path of sliding, as [`crate::scene::SlipMeasure`] says. [`crate::AssembledProblem::run`] solves them one after the other.

mod energies;
mod record;

pub(crate) use energies::EnergyLedger;
pub use energies::StepEnergies;
pub use record::{HistoryErrors, StepPane, StepRecord, largest_norm};
