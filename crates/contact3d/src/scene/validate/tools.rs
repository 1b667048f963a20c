//! Checks of rigid tools.

use super::require;
use crate::scene::{Follow, InvalidValue, Quantity, Scene, Tool, ToolMotion, Written, nearest};

pub(super) fn check(scene: &Scene) -> Result<(), InvalidValue> {
    let names: Vec<&str> = scene
        .tools
        .iter()
        .filter_map(|tool| tool.name.as_deref())
        .collect();
    for (entry, contact) in scene.contacts.iter().enumerate() {
        let Some(name) = contact.tool.as_deref() else {
            require(
                contact.follow != Some(Follow::Increment),
                format!("{}.follow", scene.contact_key(entry)),
                "\"start\" where the obstacle rests",
                Written(&Follow::Increment),
                "name the [[tool]] that moves with contact.tool",
            )?;
            continue;
        };
        require(
            names.contains(&name),
            format!("{}.tool", scene.contact_key(entry)),
            &format!("the name of a [[tool]]: {}", names.join(", ")),
            Written(&name),
            &(nearest(name, &names).unwrap_or_default()
                + "give a [[tool]] this name, or leave the key out where the obstacle rests"),
        )?;
    }
    for (i, tool) in scene.tools.iter().enumerate() {
        let of_tool = |entry| scene.tool_on(entry) == Some(i);
        require(
            tool.face.is_some() || (0..scene.contacts.len()).any(of_tool),
            format!("tool.{i}"),
            "a tool with a face, or one that a contact names",
            tool.name.as_deref().unwrap_or("one without a name"),
            "write face = \"...\" to bond it to a face, or give it a name and write contact.tool = \"...\" with it",
        )?;
        let face = tool.face.as_deref().unwrap_or_default();
        let mut others = scene.tools[..i].iter();
        let is_taken = others.any(|other| other.face == tool.face);
        let is_held = scene.clamps.iter().any(|clamp| clamp.is_face(face));
        require(
            tool.face.is_none() || !(is_taken || is_held || scene.is_in_contact(face)),
            format!("tool.{i}.face"),
            "a face that no clamp, no contact and no other tool has",
            Written(&face),
            "a face is held, in contact, or bonded to one tool; give the tool the motions of the clamp",
        )?;
        check_motions(tool, i)?;
    }
    Ok(())
}

/// Refuses formulas of the place, and what is given of motions for which the other of motion and load is.
fn check_motions(tool: &Tool, i: usize) -> Result<(), InvalidValue> {
    for (number, (name, vector)) in tool.vectors().into_iter().enumerate() {
        require(
            !vector.iter().any(Quantity::depends_on_place),
            format!("tool.{i}.{name}"),
            "numbers, or expressions of parameters",
            Written(vector),
            "a tool is rigid: it moves and is loaded as a whole",
        )?;
        let (first, is_motion) = (3 * (number % 2), number < 2);
        let given = (0..3).find(|c| {
            let value = vector[*c].constant();
            value != Some(0.0) && tool.is_free(first + c) == is_motion
        });
        let Some(c) = given else { continue };
        let motion = ToolMotion::ALL[first + c].word();
        let (is, other) = match is_motion {
            true => ("free", ["force", "moment"]),
            false => ("held", ["displacement", "turn"]),
        };
        let other = other[number % 2];
        require(
            false,
            format!("tool.{i}.{name}"),
            &format!("0.0 for {motion}, which is {is}"),
            Written(vector),
            &format!(
                "a motion is given or free under a load: write its {other}, or change free = [...]"
            ),
        )?;
    }
    Ok(())
}
