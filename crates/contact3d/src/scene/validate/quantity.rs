//! Checks of the quantity that the mesh is refined for.

use super::require;
use crate::scene::{ElementOrder, Functional, InvalidValue, Scene};

/// Refuses a quantity that no solution of the scene has.
pub(super) fn check(scene: &Scene, of: Functional) -> Result<(), InvalidValue> {
    let has_volume = of.corners().is_none_or(|[low, high]| {
        let may_be_flat = matches!(of, Functional::MeanPressure { .. });
        (0..3).all(|c| low[c] < high[c] || may_be_flat && low[c] == high[c])
    });
    let refusal = match of {
        Functional::NormalForce
        | Functional::LargestPressure
        | Functional::ContactArea
        | Functional::MeanPressure { .. }
            if scene.contacts.is_empty() =>
        {
            Some((
                "a quantity of a scene without contact",
                "without a contact face there are the strain energy and displacements",
            ))
        }
        Functional::TangentialForce | Functional::StickArea if !scene.has_friction() => Some((
            "a quantity of a scene without friction",
            "without friction tangential forces are zero and no pane sticks",
        )),
        Functional::TangentialForce if scene.contacts.len() > 1 => Some((
            "a quantity of a scene with several contact faces",
            "tangential forces of several faces, each in axes of its own, have no sum",
        )),
        Functional::NormalForce
        | Functional::TangentialForce
        | Functional::LargestPressure
        | Functional::MeanPressure { .. }
            if scene.body.element == ElementOrder::P1 =>
        {
            Some((
                "a quantity whose error linear tetrahedra show",
                "local errors of linear elements do not reach the contact face: set body.element = \"P2\", with a mesh file of quadratic \
                 tetrahedra (gmsh -order 2), or refine for displacements, the strain energy or areas",
            ))
        }
        Functional::Dissipation => Some((
            "a quantity of one increment or of a static problem",
            "friction takes energy over a load history, whose error gathers over all increments: its adjoint runs backwards \
             through them, which is not available; refine for the energy norm or a force, and compare two targets",
        )),
        _ if !has_volume => Some((
            "a box with the smaller coordinates first and a volume",
            "write box = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], for example",
        )),
        _ => None,
    };
    let (expected, help) = refusal.unwrap_or_default();
    require(refusal.is_none(), "adapt.of", expected, of.word(), help)
}
