//! Checks of the contact face.

use super::{holds, obstacle, require, supports::check_name};
use crate::scene::{ElementOrder, Invalid, Scene, SlipInterpolation, Written};

pub(super) fn check(scene: &Scene) -> Result<(), Invalid> {
    let Some(contact) = &scene.contact else {
        return Ok(());
    };
    check_name(scene, &contact.face, "contact.face".into())?;
    require(
        holds(&contact.gap, |d| d >= 0.0 && d.is_finite()),
        "contact.gap",
        &format!(
            "a gap d >= 0 [{}] or an expression in x, y, z",
            scene.units.length()
        ),
        Written(&contact.gap),
        "the body may not start inside the foundation",
    )?;
    if let Some(obstacle) = &contact.obstacle {
        obstacle::check(obstacle, scene)?;
    }
    require(
        contact.axis_1.is_none() || contact.angle.is_none(),
        "contact.angle",
        "either axis_1 or angle",
        "both",
        "axis_1 is the direction of t1 itself, angle turns the default one",
    )?;
    require(
        contact.slip_interpolation == SlipInterpolation::Lagrange
            || scene.body.element == ElementOrder::P1,
        "contact.slip_interpolation",
        "\"lagrange\" for quadratic tetrahedra",
        "\"clement\"",
        "means over the triangles around a node are made for linear functions; set body.element = \"P1\" or leave the key out",
    )?;
    if let Some(angle) = &contact.angle {
        require(
            holds(angle, f64::is_finite),
            "contact.angle",
            "a finite angle [degrees] or an expression in x, y, z",
            Written(angle),
            "the angle turns t1 towards t2",
        )?;
    }
    if let Some(axis) = &contact.axis_1 {
        let constants: Option<Vec<f64>> = axis.iter().map(|a| a.constant()).collect();
        let usable = constants
            .is_none_or(|a| a.iter().all(|v| v.is_finite()) && a.iter().any(|v| *v != 0.0));
        require(
            usable,
            "contact.axis_1",
            "a non-zero vector in the plane of the contact face",
            Written(axis),
            "t1 must be tangential, for example [1.0, 0.0, 0.0] on z_min",
        )?;
    }
    Ok(())
}
