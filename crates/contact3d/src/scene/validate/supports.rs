//! Checks of clamps, springs, loads and their histories.

use std::collections::BTreeSet;

use super::{check_box, require};
use crate::scene::{
    BrickFace, Clamp, Component, FacePart, InvalidValue, MOST_INCREMENTS, Quantity, Scene,
    SlipMeasure, Written, nearest,
};

pub(super) fn check(scene: &Scene) -> Result<(), InvalidValue> {
    for (key, face) in scene.named_faces() {
        check_name(scene, &face, &key)?;
    }
    check_parts(scene)?;
    check_clamps(scene)?;
    check_springs(scene)
}

/// Refuses loads and springs where there is contact or a clamp, boxes whose corners are not in order, and forces that are no numbers.
fn check_parts(scene: &Scene) -> Result<(), InvalidValue> {
    for (key, part) in scene.face_parts() {
        check_loaded_face(scene, &part, format!("{key}.face"))?;
        if let Some(corners) = &part.corners {
            check_box(scene, format!("{key}.box"), corners)?;
        }
        require(
            part.corners.is_none() || part.disc.is_none(),
            key,
            "box or disc, or neither for the whole face",
            "both",
            "leave one of the two out",
        )?;
    }
    for (i, force) in scene.forces.iter().enumerate() {
        for (name, value) in [("value", &force.value), ("moment", &force.moment)] {
            require(
                !value.iter().any(Quantity::depends_on_place),
                format!("force.{i}.{name}"),
                "numbers, or expressions of parameters",
                Written(value),
                "a total force has no place; for a load that varies over the face write a [[traction]]",
            )?;
        }
    }
    Ok(())
}

fn check_clamps(scene: &Scene) -> Result<(), InvalidValue> {
    for (i, clamp) in scene.clamps.iter().enumerate() {
        require(
            !clamp.components.is_empty(),
            format!("clamp.{i}.components"),
            "at least one of x, y, z",
            Written(&clamp.components),
            "leave the key out to hold all three components",
        )?;
        check_place(scene, clamp, i)?;
        let free = Component::ALL.into_iter().find(|component| {
            let moved = clamp.value[*component as usize].constant() != Some(0.0);
            moved && !clamp.components.contains(component)
        });
        require(
            free.is_none(),
            format!("clamp.{i}.value"),
            &format!(
                "0.0 along {}, which this clamp leaves free",
                free.map_or("", Component::word)
            ),
            Written(&clamp.value),
            "value goes along x, y and z; add the axis to components to hold it there",
        )?;
    }
    let is_bonded = scene.tools.iter().any(|tool| tool.face.is_some());
    require(
        is_bonded || !scene.clamps.is_empty() || !scene.springs.is_empty() || scene.has_contact(),
        "clamp",
        "at least one [[clamp]], a [[spring]], or [contact]",
        "none",
        "an unheld body can move as a rigid one; add [[clamp]] with a face, or [contact] with the face that it rests on",
    )
}

fn check_springs(scene: &Scene) -> Result<(), InvalidValue> {
    for (i, spring) in scene.springs.iter().enumerate() {
        let follows_face = spring.normal.is_some() || spring.tangential.is_some();
        require(
            follows_face != spring.tensor.is_some(),
            format!("spring.{i}"),
            "either normal and tangential, one of them or both, or tensor",
            if spring.tensor.is_some() {
                "both"
            } else {
                "neither"
            },
            "normal and tangential follow the face, tensor the axes x, y, z",
        )?;
    }
    Ok(())
}

fn check_place(scene: &Scene, clamp: &Clamp, i: usize) -> Result<(), InvalidValue> {
    if let Some(corners) = &clamp.corners {
        check_box(scene, format!("clamp.{i}.box"), corners)?;
    }
    let face = clamp.face.as_deref();
    require(
        !face.is_some_and(|face| scene.is_in_contact(face)),
        format!("clamp.{i}.face"),
        "a face other than the contact face",
        Written(&face.unwrap_or_default()),
        "a face is either held or in contact",
    )?;
    require(
        face.is_some() || clamp.corners.is_some(),
        format!("clamp.{i}"),
        "face or box",
        "neither",
        "face holds a whole face, box = [[x, y, z], [x, y, z]] the nodes between two corners",
    )
}

/// Refuses a face that a brick does not have; the groups of a Gmsh file are checked with the mesh.
fn check_name(scene: &Scene, face: &str, key: &str) -> Result<(), InvalidValue> {
    let bodies = || 0..scene.bodies.len();
    let mut of_file = bodies().filter(|body| scene.bodies[*body].brick.is_none());
    if of_file.any(|body| face.starts_with(&scene.face_prefix(body))) {
        return Ok(());
    }
    let bricks = bodies().filter(|body| scene.bodies[*body].brick.is_some());
    let known = bricks.flat_map(|body| {
        let prefix = scene.face_prefix(body);
        BrickFace::ALL.map(|face| format!("{prefix}{}", face.word()))
    });
    let mut known: Vec<String> = known.collect();
    let is_known = known.iter().any(|name| name == face);
    let files = bodies().filter(|body| scene.bodies[*body].brick.is_none());
    known.extend(files.map(|body| format!("{}NAME", scene.face_prefix(body))));
    let help = if scene.bodies.iter().all(|body| body.brick.is_none()) {
        "faces of several bodies are named BODY.FACE"
    } else {
        "a brick has these six faces; named groups come with Gmsh meshes"
    };
    require(
        is_known,
        key,
        &format!("one of {}", known.join(", ")),
        Written(&face),
        &(nearest(face, &known).unwrap_or_default() + help),
    )
}

fn check_loaded_face(scene: &Scene, part: &FacePart<'_>, key: String) -> Result<(), InvalidValue> {
    let mut clamps = scene.clamps.iter();
    let held = clamps.any(|c| c.is_face(part.face) && c.components.len() >= 3);
    let mut contacts = scene.contacts.iter();
    let in_contact = contacts.any(|c| c.faces().contains(&part.face) && part.may_meet(c.corners));
    require(
        !in_contact && !held,
        key,
        "a face, or a part of one, that is neither held nor in contact",
        Written(&part.face),
        "loads act on free faces only",
    )
}

pub(super) fn check_history(scene: &Scene) -> Result<(), InvalidValue> {
    check_names(scene)?;
    for (key, friction) in scene.friction_tables() {
        require(
            scene.has_history() || friction.follows == SlipMeasure::default(),
            format!("{key}.follows"),
            "a scene with [[step]]",
            "none",
            "without a history there is one slip to follow; leave the key out, or add a [[step]]",
        )?;
        require(
            friction.follows == scene.slip_measure(),
            format!("{key}.follows"),
            "the same on all contact faces",
            Written(&friction.follows),
            "give all tables of friction the same word",
        )?;
    }
    if !scene.has_history() {
        return Ok(());
    }
    check_times(scene)?;
    let mut increments = 0_usize;
    for (k, step) in scene.steps.iter().enumerate() {
        increments = increments.saturating_add(step.increments);
        require(
            increments <= MOST_INCREMENTS,
            format!("step.{k}.increments"),
            &format!("at most {MOST_INCREMENTS} increments in all steps together"),
            increments,
            "use fewer increments",
        )?;
    }
    check_ends(scene)
}

/// Every step must end in a scene that a problem of one step could have.
fn check_ends(scene: &Scene) -> Result<(), InvalidValue> {
    for (step, end) in scene.at_ends().enumerate() {
        end?.validate().map_err(|invalid| invalid.in_step(step))?;
    }
    Ok(())
}

fn check_times(scene: &Scene) -> Result<(), InvalidValue> {
    if scene.steps.iter().all(|step| step.time.is_none()) {
        return Ok(());
    }
    let mut before = 0.0;
    for (k, step) in scene.steps.iter().enumerate() {
        let key = format!("step.{k}.time");
        let Some(time) = step.time else {
            return require(
                false,
                key,
                "a time, as other steps have one",
                "none",
                "give every step a time, or none",
            );
        };
        require(
            time > before,
            key,
            &format!(
                "a time [s] after {}, when the step begins",
                Written(&before)
            ),
            Written(&time),
            "times of steps grow, and the first begins at 0",
        )?;
        before = time;
    }
    Ok(())
}

fn check_names(scene: &Scene) -> Result<(), InvalidValue> {
    let mut known = BTreeSet::new();
    for (key, name) in scene.given_names() {
        require(
            !name.is_empty() && !name.contains('.') && name != "body_force",
            key.clone(),
            "a name without dots",
            Written(&name),
            "keys such as traction.0 have dots, names do not",
        )?;
        require(
            known.insert(name.clone()),
            key,
            "a name that no other load has",
            Written(&name),
            "steps could not tell the two apart",
        )?;
    }
    Ok(())
}
