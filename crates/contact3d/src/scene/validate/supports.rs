//! Checks of clamps and loads.

use units::Dimension;

use super::{check_box, holds, require};
use crate::scene::{BrickFace, Clamp, Component, InvalidValue, Quantity, Scene, Written};

pub(super) fn check(scene: &Scene) -> Result<(), InvalidValue> {
    check_clamps(scene)?;
    check_springs(scene)?;
    let stress = scene.units.stress();
    for (i, traction) in scene.tractions.iter().enumerate() {
        check_vector(&traction.value, format!("traction.{i}.value"), &stress)?;
        check_loaded_face(scene, &traction.face, format!("traction.{i}.face"))?;
    }
    for (i, pressure) in scene.pressures.iter().enumerate() {
        require(
            holds(&pressure.value, f64::is_finite),
            format!("pressure.{i}.value"),
            &format!("a finite number [{stress}] or an expression in x, y, z"),
            Written(&pressure.value),
            "a positive pressure pushes into the body",
        )?;
        check_loaded_face(scene, &pressure.face, format!("pressure.{i}.face"))?;
    }
    match &scene.body_force {
        Some(force) => {
            let unit = scene.units.word(Dimension::BODY_FORCE);
            check_vector(&force.value, "body_force.value".into(), &unit)
        }
        None => Ok(()),
    }
}

fn check_clamps(scene: &Scene) -> Result<(), InvalidValue> {
    let length = scene.units.length();
    for (i, clamp) in scene.clamps.iter().enumerate() {
        require(
            !clamp.components.is_empty(),
            format!("clamp.{i}.components"),
            "at least one of x, y, z",
            Written(&clamp.components),
            "leave the key out to hold all three components",
        )?;
        check_place(scene, clamp, i)?;
        check_vector(&clamp.value, format!("clamp.{i}.value"), length)?;
        let free = Component::ALL.into_iter().find(|component| {
            let moved = clamp.value[*component as usize].constant() != Some(0.0);
            moved && !clamp.components.contains(component)
        });
        require(
            free.is_none(),
            format!("clamp.{i}.value"),
            &format!(
                "0.0 along {}, which this clamp leaves free",
                free.map_or("", Component::name)
            ),
            Written(&clamp.value),
            "value goes along x, y and z; add the axis to components to hold it there",
        )?;
    }
    require(
        !scene.clamps.is_empty() || !scene.springs.is_empty() || !scene.contacts.is_empty(),
        "clamp",
        "at least one [[clamp]], a [[spring]], or [contact]",
        "none",
        "an unheld body can move as a rigid one; add [[clamp]] with a face, or [contact] with the face that it rests on",
    )
}

fn check_springs(scene: &Scene) -> Result<(), InvalidValue> {
    let unit = scene.units.word(Dimension::BODY_FORCE);
    for (i, spring) in scene.springs.iter().enumerate() {
        check_loaded_face(scene, &spring.face, format!("spring.{i}.face"))?;
        let of_face = [
            ("normal", &spring.normal),
            ("tangential", &spring.tangential),
        ];
        require(
            of_face.iter().any(|(_, given)| given.is_some()) != spring.tensor.is_some(),
            format!("spring.{i}"),
            "either normal and tangential, one of them or both, or tensor",
            if spring.tensor.is_some() {
                "both"
            } else {
                "neither"
            },
            "normal and tangential follow the face, tensor the axes x, y, z",
        )?;
        for (name, given) in of_face {
            let Some(given) = given else { continue };
            require(
                holds(given, |k| k >= 0.0 && k.is_finite()),
                format!("spring.{i}.{name}"),
                &format!("a finite number >= 0 [{unit}] or an expression in x, y, z"),
                Written(given),
                "a spring pushes back; leave the key out for none",
            )?;
        }
        for row in spring.tensor.iter().flatten() {
            check_vector(row, format!("spring.{i}.tensor"), &unit)?;
        }
    }
    Ok(())
}

fn check_place(scene: &Scene, clamp: &Clamp, i: usize) -> Result<(), InvalidValue> {
    match (&clamp.face, &clamp.corners) {
        (Some(face), None) => {
            let key = format!("clamp.{i}.face");
            check_name(scene, face, key.clone())?;
            require(
                !scene.is_in_contact(face),
                key,
                "a face other than the contact face",
                Written(face),
                "a face is either held or in contact",
            )
        }
        (None, Some(corners)) => check_box(scene, format!("clamp.{i}.box"), corners),
        (face, corners) => require(
            false,
            format!("clamp.{i}"),
            "either face or box",
            if face.is_some() && corners.is_some() {
                "both"
            } else {
                "neither"
            },
            "face holds a whole face, box = [[x, y, z], [x, y, z]] the nodes between two corners",
        ),
    }
}

fn check_vector(value: &[Quantity; 3], key: String, unit: &str) -> Result<(), InvalidValue> {
    require(
        value.iter().all(|p| holds(p, f64::is_finite)),
        key,
        &format!("three finite numbers [{unit}] or expressions in x, y, z"),
        Written(value),
        "give the vector's three components",
    )
}

/// Refuses a face that a brick does not have; the groups of a Gmsh file are checked with the mesh.
pub(super) fn check_name(scene: &Scene, face: &str, key: String) -> Result<(), InvalidValue> {
    require(
        scene.body.as_brick().is_none() || BrickFace::named(face).is_some(),
        key,
        &format!("one of {}", BrickFace::NAMES.join(", ")),
        Written(&face),
        "a brick has these six faces; named groups come with Gmsh meshes",
    )
}

fn check_loaded_face(scene: &Scene, face: &str, key: String) -> Result<(), InvalidValue> {
    check_name(scene, face, key.clone())?;
    let held = scene
        .clamps
        .iter()
        .any(|c| c.is_face(face) && c.components.len() >= 3);
    require(
        !scene.is_in_contact(face) && !held,
        key,
        "a face that is neither held nor in contact",
        Written(&face),
        "loads act on free faces only",
    )
}
