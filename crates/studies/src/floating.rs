//! Bodies that a study does not cover.

use contact3d::{AssembledProblem, scene::Invalid};

/// Refuses a body that only contact holds, or weak springs, where `what` needs A⁻¹ itself.
pub(crate) fn refuse_floating(problem: &AssembledProblem, what: &str) -> Result<(), Invalid> {
    let Some(body) = &problem.system().assembly.primal.floating else {
        return Ok(());
    };
    let (found, why) = match body.support {
        None => (
            "only contact holds",
            "A is singular: there is no S = B A^-1 B^T, no unique mapping of contact forces to displacements",
        ),
        Some(_) => (
            "only contact and weak springs hold",
            "springs far softer than the body leave S = B A^-1 B^T no digits of the body's own compliance",
        ),
    };
    Err(Invalid {
        key: "clamp".into(),
        expected: format!("a body that its supports hold, for {what}"),
        found: format!("a body that {found}"),
        help: format!("{why}; hold the body with [[clamp]] or solve it with run"),
    })
}
