//! What several studies share.

use contact3d::{AssembledProblem, dual::ExplicitDual, scene::InvalidValue};

/// What an observer of a study sees, in words.
#[derive(Debug, Clone, PartialEq)]
pub enum StudyStep {
    /// A piece of work begins.
    Begin(String),
    /// A first result.
    Figure(String),
}

/// Refuses a body that only contact holds, or weak springs, where `what` needs A⁻¹ itself.
pub(crate) fn refuse_floating(problem: &AssembledProblem, what: &str) -> Result<(), InvalidValue> {
    let Some(body) = &problem.system.assembly.primal.rigid_modes else {
        return Ok(());
    };
    if problem.scene().n_free_tool_motions() > 0 {
        return Err(InvalidValue {
            key: "tool".into(),
            expected: format!("tools whose motions are all given, for {what}"),
            found: "a tool that is free to move".into(),
            help: "leave out free, and give the displacement that a run finds".into(),
        });
    }
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
    Err(InvalidValue {
        key: "clamp".into(),
        expected: format!("a body that its supports hold, for {what}"),
        found: format!("a body that {found}"),
        help: format!("{why}; hold the body with [[clamp]] or solve it with run"),
    })
}

/// S, h and the compliance of a problem that was assembled with contact and the dense operator.
pub(crate) fn dual_of(problem: &AssembledProblem) -> &ExplicitDual {
    let contact = problem.system.contact.as_ref();
    let dual = contact.and_then(|contact| contact.explicit());
    dual.expect("assembled with contact and the dense operator")
}

pub(crate) fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 {
        a
    } else {
        greatest_common_divisor(b, a % b)
    }
}
