//! The quantity that a mesh is refined for.

use crate::scene::{ElementOrder, Functional, Invalid, Scene};

/// Refuses a quantity that no answer of the scene has.
pub(super) fn check(scene: &Scene, of: Functional) -> Result<(), Invalid> {
    let refused = |expected: &str, help: &str| {
        Err(Invalid {
            key: "adapt.of".into(),
            expected: expected.into(),
            found: of.word().into(),
            help: help.into(),
        })
    };
    let without_contact = "without a contact face there are the strain energy and displacements";
    let without_friction = "without friction tangential forces are zero and no pane sticks";
    match of {
        Functional::NormalForce
        | Functional::LargestPressure
        | Functional::ContactArea
        | Functional::MeanPressure { .. }
            if scene.contacts.is_empty() =>
        {
            return refused("a quantity of a scene without contact", without_contact);
        }
        Functional::TangentialForce | Functional::StickArea if !scene.has_friction() => {
            return refused("a quantity of a scene without friction", without_friction);
        }
        Functional::TangentialForce if scene.contacts.len() > 1 => {
            return refused(
                "a quantity of a scene with several contact faces",
                "tangential forces of several faces, each in axes of its own, have no sum",
            );
        }
        Functional::NormalForce
        | Functional::TangentialForce
        | Functional::LargestPressure
        | Functional::MeanPressure { .. }
            if scene.body.element == ElementOrder::P1 =>
        {
            return refused(
                "a quantity whose error linear tetrahedra show",
                "local errors of linear elements do not reach the contact face: set body.element = \"P2\", with a mesh file of quadratic \
                 tetrahedra (gmsh -order 2), or refine for displacements, the strain energy or areas",
            );
        }
        Functional::Dissipation => {
            return refused(
                "a quantity of one solved problem",
                "friction takes energy over a load history, whose error gathers over all increments: its adjoint runs backwards \
                 through them, which is not available",
            );
        }
        _ => {}
    }
    let Some([low, high]) = of.corners() else {
        return Ok(());
    };
    let is_flat = |c: usize| match of {
        Functional::MeanPressure { .. } => low[c] > high[c],
        _ => low[c] >= high[c],
    };
    let numbers = low.iter().chain(&high).all(|x| x.is_finite());
    if numbers && !(0..3).any(is_flat) {
        return Ok(());
    }
    refused(
        "a box with the smaller coordinates first and a volume",
        "write box = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], for example",
    )
}
