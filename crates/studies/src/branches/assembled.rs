//! The assembled problem of one scene of a family, and the scenes that have none.

use std::path::Path;

use contact3d::{
    AssembledProblem, Problem, ProblemError,
    dual::ExplicitDual,
    scene::{DualOperatorKind, FactorPrecision, Invalid, Scene},
};

pub(super) fn explicit(mut scene: Scene) -> Scene {
    scene.assemble.dual_operator = DualOperatorKind::Explicit;
    scene.assemble.factor = FactorPrecision::Double;
    scene
}

pub(super) fn assemble(scene: &Scene, folder: &Path) -> Result<AssembledProblem, ProblemError> {
    match scene.contacts.as_slice() {
        [_] if scene.has_friction() => {}
        [] | [_] => return Err(no_friction().into()),
        several => return Err(several_faces(several.len()).into()),
    }
    let assembled = Problem::in_folder(explicit(scene.clone()), folder)?.assemble()?;
    crate::floating::refuse_floating(&assembled, "paths of solutions")?;
    Ok(assembled)
}

pub(super) fn dual_of(problem: &AssembledProblem) -> &ExplicitDual {
    let contact = problem.system().contact.as_ref();
    let dual = contact.and_then(|contact| contact.explicit());
    dual.expect("assembled with contact and the dense operator")
}

fn several_faces(found: usize) -> Invalid {
    Invalid {
        key: "contact".into(),
        expected: "one contact face, whose zones and segments of its law name the pieces of a path"
            .into(),
        found: format!("{found} faces"),
        help: "leave all but one out, or solve at single values with a sweep".into(),
    }
}

pub(super) fn no_friction() -> Invalid {
    Invalid {
        key: "friction".into(),
        expected: "Coulomb friction on a contact face, at every value of the parameter".into(),
        found: "a scene without".into(),
        help: "without friction, or with a given slip bound, there is one solution for every value; a sweep solves for them".into(),
    }
}
