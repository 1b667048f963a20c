//! The error of a solution: its distance to the solution that refined residuals lead to.

mod error;
mod refinement;

pub(in crate::solver) use error::{
    DISPLACEMENT_TOLERANCE, GMRES_MAX_APPLICATIONS, GMRES_TOLERANCE,
};
pub(crate) use error::{is_significant, load_stress};
pub(in crate::solver) use refinement::Refined;
