//! The effects of a scene in words: what is computed, what it costs in unknowns, what is absent.

use std::fmt::Write;

use contact3d::scene::{ContactEffect, Effects, FrictionEffect, MultiplierSpace};

use crate::format::Sizes;

/// One effect that a scene calls for or lacks.
struct Effect {
    name: &'static str,
    /// What it adds; `None` where it is absent.
    present: Option<Cost>,
}

/// What an effect adds.
struct Cost {
    words: String,
    /// Unknowns it adds, once the mesh is known.
    unknowns: Option<usize>,
}

/// A cost in unknowns: their number and what they are.
fn unknowns(count: Option<usize>, what: &str) -> Option<Cost> {
    Some(Cost {
        words: match count {
            Some(count) => format!("{count} {what}"),
            None => what.to_owned(),
        },
        unknowns: count,
    })
}

/// An effect without unknowns of its own.
fn data(present: bool, words: &str) -> Option<Cost> {
    present.then(|| Cost {
        words: format!("{words}, no unknowns"),
        unknowns: Some(0),
    })
}

/// All effects, in the order in which they build on each other.
fn list(effects: &Effects, sizes: &Sizes) -> Vec<Effect> {
    let effect = |name, present| Effect { name, present };
    let mut list = vec![
        effect("elasticity", unknowns(sizes.n_free, "displacements")),
        effect("anisotropy", data(effects.anisotropy, "21 moduli")),
        effect(
            "regions",
            data(
                effects.regions > 0,
                &format!("{} besides the body's own material", effects.regions),
            ),
        ),
        effect("body force", data(effects.body_force, "loads every node")),
    ];
    let (friction, gap, turning_frame, contact) = match effects.contact {
        ContactEffect::Absent => (FrictionEffect::Frictionless, false, false, None),
        ContactEffect::Present {
            friction,
            gap,
            turning_frame,
            space,
        } => {
            let what = match space {
                MultiplierSpace::Panes => "normal multipliers (panes)",
                MultiplierSpace::Nodal => "normal multipliers (nodes)",
            };
            let contact = unknowns(sizes.n_panes, what);
            (friction, gap, turning_frame, contact)
        }
    };
    list.push(effect("contact", contact));
    list.push(effect("initial gap", data(gap, "one value a contact node")));
    list.extend(friction_effects(friction, sizes));
    list.push(effect(
        "turning frame",
        data(turning_frame, "one pair of axes a contact node"),
    ));
    list
}

fn friction_effects(friction: FrictionEffect, sizes: &Sizes) -> [Effect; 3] {
    let (law, orthotropic, follows_slip, varies) = match friction {
        FrictionEffect::Frictionless => (None, false, false, false),
        FrictionEffect::Tresca { orthotropic } => (Some("Tresca"), orthotropic, false, false),
        FrictionEffect::Coulomb {
            orthotropic,
            slip_dependent,
            place_dependent,
        } => (
            Some("Coulomb"),
            orthotropic,
            slip_dependent,
            place_dependent,
        ),
    };
    let shape = if orthotropic {
        "orthotropic"
    } else {
        "isotropic"
    };
    let tangential = law.and_then(|law| {
        let what = format!("tangential multipliers ({shape} {law})");
        unknowns(sizes.n_panes.map(|m| 2 * m), &what)
    });
    let slips = follows_slip.then(|| {
        let count = sizes.n_contact_nodes.map(|n| 2 * n);
        unknowns(count, "slips of contact nodes")
    });
    [
        Effect {
            name: "friction",
            present: tangential,
        },
        Effect {
            name: "slip-dependent coefficients",
            present: slips.flatten(),
        },
        Effect {
            name: "place-dependent coefficients",
            present: data(varies, "evaluated at every contact node"),
        },
    ]
}

/// One line for each effect present, and one that names the absent ones.
pub(super) fn lines(effects: &Effects, sizes: &Sizes) -> String {
    let mut text = String::new();
    let mut absent = Vec::new();
    for effect in list(effects, sizes) {
        match effect.present {
            Some(cost) => {
                let _ = writeln!(text, "  {:<28} {}", effect.name, cost.words);
            }
            None => absent.push(effect.name),
        }
    }
    if absent.is_empty() {
        absent.push("nothing");
    }
    let _ = writeln!(
        text,
        "  {:<28} {}",
        "absent, not computed",
        absent.join(", ")
    );
    text
}

/// The effects for programs.
pub(super) fn json(effects: &Effects, sizes: &Sizes) -> serde_json::Value {
    let (present, absent): (Vec<_>, Vec<_>) = list(effects, sizes)
        .into_iter()
        .partition(|effect| effect.present.is_some());
    let present: Vec<_> = present
        .into_iter()
        .filter_map(|effect| {
            let Cost { words, unknowns } = effect.present?;
            Some(serde_json::json!({ "effect": effect.name, "cost": words, "unknowns": unknowns }))
        })
        .collect();
    let absent: Vec<_> = absent.iter().map(|effect| effect.name).collect();
    serde_json::json!({ "present": present, "absent": absent })
}
