//! Checks of the contact faces and their obstacles.

use super::{check_box, holds, positive, require, supports::check_name};
use crate::scene::{
    Contact, ElementOrder, Height, InvalidValue, Obstacle, POSITION, Quantity, Scene,
    SlipInterpolation, Written,
};

pub(super) fn check(scene: &Scene) -> Result<(), InvalidValue> {
    for (entry, contact) in scene.contacts.iter().enumerate() {
        check_face(scene, contact, &scene.contact_key(entry))?;
        check_beside_others(scene, contact, entry)?;
    }
    Ok(())
}

fn check_face(scene: &Scene, contact: &Contact, key: &str) -> Result<(), InvalidValue> {
    check_name(scene, &contact.face, format!("{key}.face"))?;
    if let Some(corners) = &contact.corners {
        check_box(scene, format!("{key}.box"), corners)?;
    }
    require(
        holds(&contact.gap, |d| d >= 0.0 && d.is_finite()),
        format!("{key}.gap"),
        &format!(
            "a gap d >= 0 [{}] or an expression in x, y, z",
            scene.units.length()
        ),
        Written(&contact.gap),
        "the body may not start inside the foundation",
    )?;
    if let Some(obstacle) = &contact.obstacle {
        check_obstacle(obstacle, scene, key)?;
    }
    require(
        contact.slip_interpolation == SlipInterpolation::Lagrange
            || scene.body.element == ElementOrder::P1,
        format!("{key}.slip_interpolation"),
        "\"lagrange\" for quadratic tetrahedra",
        "\"clement\"",
        "means over the triangles around a node are made for linear functions; set body.element = \"P1\" or leave the key out",
    )?;
    check_axes(contact, key)
}

fn check_axes(contact: &Contact, key: &str) -> Result<(), InvalidValue> {
    require(
        contact.axis_1.is_none() || contact.angle.is_none(),
        format!("{key}.angle"),
        "either axis_1 or angle",
        "both",
        "axis_1 is the direction of t1 itself, angle turns the default one",
    )?;
    if let Some(angle) = &contact.angle {
        require(
            holds(angle, f64::is_finite),
            format!("{key}.angle"),
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
            format!("{key}.axis_1"),
            "a non-zero vector in the plane of the contact face",
            Written(axis),
            "t1 must be tangential, for example [1.0, 0.0, 0.0] on z_min",
        )?;
    }
    Ok(())
}

/// What several contact faces owe each other: names, parts of their own, one interpolation of slips.
fn check_beside_others(scene: &Scene, contact: &Contact, entry: usize) -> Result<(), InvalidValue> {
    let key = scene.contact_key(entry);
    require(
        !contact.name().is_empty() && !contact.name().contains(char::is_control),
        format!("{key}.name"),
        "a name of one line",
        Written(&contact.name()),
        "results and pictures call the contact face by it",
    )?;
    let before = &scene.contacts[..entry];
    for (other, first) in before.iter().enumerate() {
        let other = scene.contact_key(other);
        require(
            first.face != contact.face || first.corners.is_some() && contact.corners.is_some(),
            format!("{key}.face"),
            "a face, or a part of one, that is in no other contact",
            Written(&contact.face),
            &format!(
                "{other} has this face as well; give both the part that is theirs by box = [[x, y, z], [x, y, z]]"
            ),
        )?;
        require(
            first.name() != contact.name(),
            format!("{key}.name"),
            "a name of its own",
            Written(&contact.name()),
            &format!("{other} has this name as well; write name = \"...\" in one of them"),
        )?;
        require(
            first.slip_interpolation == contact.slip_interpolation,
            format!("{key}.slip_interpolation"),
            "the same on all contact faces",
            Written(&contact.slip_interpolation),
            &format!("{other} has the other one; it belongs to the discretisation, not to a face"),
        )?;
    }
    Ok(())
}

/// Checks the obstacle of the contact face under a key.
fn check_obstacle(obstacle: &Obstacle, scene: &Scene, face: &str) -> Result<(), InvalidValue> {
    let key = |name: &str| format!("{face}.obstacle.{}.{name}", obstacle.word());
    let length = scene.units.length();
    let point = |name: &str, at: &[f64; 3]| {
        require(
            at.iter().all(|x| x.is_finite()),
            key(name),
            &format!("three finite numbers [{length}]"),
            Written(at),
            "give the coordinates x, y, z of a point",
        )
    };
    let direction = |name: &str, along: &[f64; 3]| {
        require(
            along.iter().all(|c| c.is_finite()) && along.iter().any(|c| *c != 0.0),
            key(name),
            "a non-zero vector of three finite numbers",
            Written(along),
            "only its direction counts, for example [0.0, 0.0, 1.0]",
        )
    };
    let radius = |radius: f64| {
        require(
            positive(radius),
            key("radius"),
            &format!("a number > 0 [{length}]"),
            radius,
            "side = \"inside\" makes the hollow of a sphere or cylinder the obstacle",
        )
    };
    match obstacle {
        Obstacle::HalfSpace(half) => {
            point("point", &half.point)?;
            direction("normal", &half.normal)
        }
        Obstacle::Sphere(sphere) => {
            point("centre", &sphere.centre)?;
            radius(sphere.radius)
        }
        Obstacle::Cylinder(cylinder) => {
            point("point", &cylinder.point)?;
            direction("direction", &cylinder.direction)?;
            radius(cylinder.radius)
        }
        Obstacle::Height(height) => check_height(height, &key("value"), length),
    }
}

/// A height is a function of the two coordinates across its direction.
fn check_height(height: &Height, key: &str, length: &str) -> Result<(), InvalidValue> {
    let own = POSITION[height.direction.axis().0];
    let uses_own = match &height.value {
        Quantity::Varying(formula) => formula.uses(own),
        Quantity::Constant(_) | Quantity::Function(_) => false,
    };
    require(
        holds(&height.value, f64::is_finite) && !uses_own,
        key,
        &format!("a finite number [{length}] or an expression without {own}"),
        Written(&height.value),
        &format!("the height is {own} itself as a function of the two other coordinates"),
    )
}
