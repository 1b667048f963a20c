//! Checks of the contact faces, their obstacles and their laws of friction.

use super::{check_box, require};
use crate::scene::{
    Coefficient, Contact, Friction, Grid, Height, InvalidValue, MultiplierSpace, Obstacle,
    POSITION, Quantity, Scene, Table, Written,
};

pub(super) fn check(scene: &Scene) -> Result<(), InvalidValue> {
    for (entry, contact) in scene.contacts.iter().enumerate() {
        check_face(scene, contact, &scene.contact_key(entry))?;
        check_pair(scene, contact, &scene.contact_key(entry))?;
        check_glued(contact, &scene.contact_key(entry))?;
        check_beside_others(scene, contact, entry)?;
    }
    check_common_friction(scene)?;
    for (key, friction) in scene.friction_tables() {
        check_friction(friction, &key)?;
    }
    Ok(())
}

fn check_face(scene: &Scene, contact: &Contact, key: &str) -> Result<(), InvalidValue> {
    if let Some(corners) = &contact.corners {
        check_box(scene, format!("{key}.box"), corners)?;
    }
    if let Some(obstacle) = &contact.obstacle {
        check_obstacle(obstacle, &format!("{key}.obstacle.{}", obstacle.word()))?;
    }
    let gap = contact.gap.constant();
    require(
        gap.is_none_or(|gap| gap >= 0.0 || contact.interference && gap.is_finite()),
        format!("{key}.gap"),
        "a finite number >= 0 or an expression in x, y, z",
        Written(&contact.gap),
        "bodies that are pressed apart where they cut into each other have interference = true",
    )?;
    check_axes(contact, key)
}

/// What a contact of two bodies says, and what it leaves to obstacles.
fn check_pair(scene: &Scene, contact: &Contact, key: &str) -> Result<(), InvalidValue> {
    require(
        contact.between.is_some() == contact.face.is_empty(),
        key,
        "exactly one of face, between",
        if contact.between.is_some() {
            "both"
        } else {
            "none"
        },
        "face touches a rigid foundation or obstacle, between = [\"a.face\", \"b.face\"] are faces of two bodies",
    )?;
    let Some(pair) = &contact.between else {
        return require(
            contact.panes_on.is_none(),
            format!("{key}.panes_on"),
            "no panes_on without between",
            Written(&contact.panes_on),
            "the contact stresses belong to the only face",
        );
    };
    let body = |face: &str| {
        let mut bodies = 0..scene.bodies.len();
        bodies.find(|body| face.starts_with(&scene.face_prefix(*body)))
    };
    require(
        scene.bodies.len() > 1 && body(&pair[0]) != body(&pair[1]),
        format!("{key}.between"),
        "faces of two different bodies",
        Written(pair),
        "a body that touches itself is not modelled; give each body a table [[body]] with a name, and write NAME.FACE",
    )?;
    require(
        contact
            .panes_on
            .as_ref()
            .is_none_or(|face| pair.contains(face)),
        format!("{key}.panes_on"),
        &format!("{} or {}", Written(&pair[0]), Written(&pair[1])),
        Written(&contact.panes_on),
        "it is the face of the two that the contact stresses belong to",
    )?;
    let others = [
        (
            "obstacle",
            contact.obstacle.is_some(),
            "the other body takes the place of the obstacle",
        ),
        (
            "tool",
            contact.tool.is_some(),
            "a tool is rigid: give the obstacle a contact of its own",
        ),
        (
            "box",
            contact.corners.is_some(),
            "parts that nothing lies opposite of are left out by themselves",
        ),
        (
            "multipliers",
            contact.multipliers == MultiplierSpace::Nodal,
            "between bodies contact stresses are constant on panes",
        ),
    ];
    match others.into_iter().find(|(_, given, _)| *given) {
        None => Ok(()),
        Some((name, _, help)) => require(
            false,
            format!("{key}.{name}"),
            &format!("no {name} beside between"),
            "one",
            help,
        ),
    }
}

/// What glued faces, which keep together, leave to faces that touch.
fn check_glued(contact: &Contact, key: &str) -> Result<(), InvalidValue> {
    let others = [
        ("face", !contact.face.is_empty()),
        ("friction", contact.friction.is_some()),
        ("gap", contact.gap != Quantity::Constant(0.0)),
        ("interference", contact.interference),
        ("axis_1", contact.axis_1.is_some()),
        ("angle", contact.angle.is_some()),
    ];
    match others
        .into_iter()
        .find(|(_, given)| contact.glued && *given)
    {
        None => Ok(()),
        Some((name, _)) => require(
            false,
            format!("{key}.{name}"),
            &format!("no {name} beside glued = true"),
            "one",
            "glued faces, two of them in between, neither part nor slip: leave out the one or the other",
        ),
    }
}

fn check_axes(contact: &Contact, key: &str) -> Result<(), InvalidValue> {
    require(
        contact.axis_1.is_none() || contact.angle.is_none(),
        format!("{key}.angle"),
        "either axis_1 or angle",
        "both",
        "axis_1 is the direction of t1 itself, angle turns the default one",
    )?;
    if let Some(axis) = &contact.axis_1 {
        let constants: Option<Vec<f64>> = axis.iter().map(|a| a.constant()).collect();
        let usable = constants.is_none_or(|a| a.iter().any(|v| *v != 0.0));
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
        let mut shared = contact.faces().into_iter();
        let shared = shared.find(|face| first.faces().contains(face));
        require(
            shared.is_none()
                || first.corners.is_some() && contact.corners.is_some()
                || first.between.is_some() && contact.between.is_some(),
            format!(
                "{key}.{}",
                if contact.between.is_some() {
                    "between"
                } else {
                    "face"
                }
            ),
            "a face, or a part of one, that is in no other contact",
            Written(&shared.unwrap_or_default()),
            &format!(
                "{other} has this face as well; give both the part that is theirs by box = [[x, y, z], [x, y, z]]"
            ),
        )?;
        let is_same_pair = contact
            .faces()
            .iter()
            .all(|face| first.faces().contains(face));
        require(
            !(is_same_pair && (first.glued || contact.glued)),
            format!("{key}.between"),
            "faces that are glued, or that touch",
            Written(&contact.faces()),
            &format!("{other} has both as well: leave one of the two out"),
        )?;
        require(
            first.name() != contact.name(),
            format!("{key}.name"),
            "a name of its own",
            Written(&contact.name()),
            &format!("{other} has this name as well; write name = \"...\" in one of them"),
        )?;
    }
    Ok(())
}

/// Checks the directions of an obstacle and the formula of its height.
fn check_obstacle(obstacle: &Obstacle, key: &str) -> Result<(), InvalidValue> {
    let direction = |name: &str, along: &[f64; 3]| {
        require(
            along.iter().any(|c| *c != 0.0),
            format!("{key}.{name}"),
            "a non-zero vector of three finite numbers",
            Written(along),
            "only its direction counts, for example [0.0, 0.0, 1.0]",
        )
    };
    match obstacle {
        Obstacle::HalfSpace(half) => direction("normal", &half.normal),
        Obstacle::Sphere(_) | Obstacle::Surface(_) => Ok(()),
        Obstacle::Cylinder(cylinder) => direction("direction", &cylinder.direction),
        Obstacle::Height(height) => check_height(height, &format!("{key}.value")),
    }
}

/// A height is a function of the two coordinates across its direction.
fn check_height(height: &Height, key: &str) -> Result<(), InvalidValue> {
    let own = POSITION[height.direction.axis().0];
    let uses_own = match &height.value {
        Quantity::Varying(formula) => formula.uses(own),
        Quantity::Constant(_) => false,
    };
    require(
        !uses_own,
        key,
        &format!("a number or an expression without {own}"),
        Written(&height.value),
        &format!("the height is {own} itself as a function of the two other coordinates"),
    )
}

fn check_common_friction(scene: &Scene) -> Result<(), InvalidValue> {
    if scene.friction.is_some() {
        require(
            scene.has_contact(),
            "friction",
            "a [contact] table that is not glued beside [friction]",
            "none",
            "friction acts on the contact face; name it in [contact]",
        )?;
        let order = scene.contact_order();
        let own = order
            .iter()
            .filter(|entry| scene.contacts[**entry].friction.is_some())
            .map(|entry| format!("{}.friction", scene.contact_key(*entry)));
        let own: Vec<String> = own.collect();
        require(
            own.len() < order.len(),
            "friction",
            "a contact face that it can be the law of",
            format!("none, for each has {} in its place", own.join(" or ")),
            "[friction] is for contact faces without friction of their own: leave one of the two out",
        )?;
    }
    Ok(())
}

fn check_friction(friction: &Friction, key: &str) -> Result<(), InvalidValue> {
    check_choice(friction, key)?;
    for (name, coefficient) in friction.given() {
        let key = format!("{key}.{name}");
        check_coefficient(coefficient, &key)?;
        check_variables(coefficient, name == "coefficient", &key)?;
    }
    if friction.slip_bound.is_some() {
        check_tresca(friction, key)?;
    }
    Ok(())
}

fn check_choice(friction: &Friction, key: &str) -> Result<(), InvalidValue> {
    let names: Vec<&str> = friction.given().map(|(name, _)| name).collect();
    require(
        friction.law().is_some(),
        key,
        "coefficient (isotropic), or coefficient_1 and coefficient_2 (orthotropic)",
        match names.as_slice() {
            [] => "none of them".to_owned(),
            names => names.join(" and "),
        },
        "give one isotropic coefficient or both orthotropic ones; leave [friction] out for frictionless contact",
    )
}

fn check_tresca(friction: &Friction, key: &str) -> Result<(), InvalidValue> {
    for (name, coefficient) in friction.given() {
        require(
            matches!(coefficient, Coefficient::Constant(_)),
            format!("{key}.{name}"),
            "a constant beside slip_bound",
            Written(coefficient),
            "for coefficients that vary use Coulomb's law: leave slip_bound out",
        )?;
    }
    require(
        friction.pressure_cap.is_none(),
        format!("{key}.pressure_cap"),
        "no pressure_cap beside slip_bound",
        Written(&friction.pressure_cap),
        "Tresca's law has a given bound and follows no pressure: leave one of the two out",
    )
}

fn check_coefficient(coefficient: &Coefficient, key: &str) -> Result<(), InvalidValue> {
    match coefficient {
        Coefficient::Table(table) => check_table(table, &format!("{key}.table")),
        Coefficient::Grid(grid) => check_grid(grid, &format!("{key}.grid")),
        // Formulas are checked where they are evaluated.
        Coefficient::Constant(_) | Coefficient::Ramp(_) | Coefficient::Expression(_) => Ok(()),
    }
}

fn check_slips(slips: &[f64], key: String) -> Result<(), InvalidValue> {
    require(
        slips.first() == Some(&0.0) && slips.windows(2).all(|w| w[0] < w[1]),
        key,
        "increasing slips from 0 on",
        Written(&slips),
        "the first slip is 0, the law is constant beyond the last",
    )
}

fn check_table(table: &Table, key: &str) -> Result<(), InvalidValue> {
    check_slips(&table.slip, format!("{key}.slip"))?;
    require(
        table.value.len() == table.slip.len(),
        format!("{key}.value"),
        &format!(
            "{} positive coefficients, one for each slip",
            table.slip.len()
        ),
        Written(&table.value),
        "straight lines lead from one to the next",
    )
}

fn check_grid(grid: &Grid, key: &str) -> Result<(), InvalidValue> {
    for (name, slips) in [("slip_1", &grid.slip_1), ("slip_2", &grid.slip_2)] {
        check_slips(slips, format!("{key}.{name}"))?;
    }
    let shaped = grid.value.len() == grid.slip_1.len()
        && grid.value.iter().all(|row| row.len() == grid.slip_2.len());
    require(
        shaped,
        format!("{key}.value"),
        &format!(
            "{} rows of {} positive coefficients",
            grid.slip_1.len(),
            grid.slip_2.len()
        ),
        Written(&grid.value),
        "one row for each slip_1, one column for each slip_2",
    )
}

/// An isotropic law is a function of |u_t| = s alone, an orthotropic one of s1 and s2.
fn check_variables(
    coefficient: &Coefficient,
    isotropic: bool,
    key: &str,
) -> Result<(), InvalidValue> {
    let (wrong, expected): (&[&str], _) = if isotropic {
        (&["s1", "s2"], "the slip s = |u_t| in an isotropic law")
    } else {
        (&["s"], "the slips s1 and s2 in an orthotropic law")
    };
    let used = match coefficient {
        Coefficient::Expression(formula) => wrong.iter().any(|v| formula.expression().uses(v)),
        Coefficient::Grid(_) => isotropic,
        Coefficient::Constant(_) | Coefficient::Ramp(_) | Coefficient::Table(_) => false,
    };
    require(
        !used,
        format!("{key}.{}", coefficient.kind()),
        expected,
        wrong.join(", "),
        "use coefficient for F(|u_t|), coefficient_1 and coefficient_2 for F(|u_t1|, |u_t2|)",
    )
}
