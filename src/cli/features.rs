//! The model features of a scene in words: what is computed, what it costs in unknowns, what is absent.

use std::fmt::Write;

use contact3d::scene::{ContactModel, FrictionLaw, FrictionModel, ModelFeatures, MultiplierSpace};

use crate::format::Sizes;

/// One feature that a scene calls for or lacks.
struct Feature {
    name: &'static str,
    /// What it adds; `None` where it is absent.
    present: Option<Cost>,
}

/// What a feature adds.
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

/// A feature without unknowns of its own.
fn data(present: bool, words: &str) -> Option<Cost> {
    present.then(|| Cost {
        words: format!("{words}, no unknowns"),
        unknowns: Some(0),
    })
}

/// All features, in the order in which they build on each other.
fn list(features: &ModelFeatures, sizes: &Sizes) -> Vec<Feature> {
    let feature = |name, present| Feature { name, present };
    let mut list = vec![
        feature("elasticity", unknowns(sizes.n_free, "displacements")),
        feature("anisotropy", data(features.anisotropy, "21 moduli")),
        feature(
            "regions",
            data(
                features.regions > 0,
                &format!("{} besides the body's own material", features.regions),
            ),
        ),
        feature(
            "prescribed displacements",
            data(
                features.prescribed_displacements > 0,
                &format!("by {} of the clamps", features.prescribed_displacements),
            ),
        ),
        feature("body force", data(features.body_force, "loads every node")),
    ];
    let (friction, gap, turning_frame, contact) = match &features.contact {
        ContactModel::Absent => (&FrictionModel::Frictionless, false, false, None),
        ContactModel::Present(face) => {
            let what = match face.space {
                MultiplierSpace::Panes => "normal multipliers (panes)",
                MultiplierSpace::Nodal => "normal multipliers (nodes)",
            };
            let contact = unknowns(sizes.n_panes, what);
            (
                &face.friction,
                face.gap.is_some(),
                face.turning_frame,
                contact,
            )
        }
    };
    list.push(feature("contact", contact));
    list.push(feature(
        "initial gap",
        data(gap, "one value a contact node"),
    ));
    list.extend(friction_features(friction, sizes));
    list.push(feature(
        "turning frame",
        data(turning_frame, "one pair of axes a contact node"),
    ));
    list
}

fn friction_features(friction: &FrictionModel, sizes: &Sizes) -> [Feature; 3] {
    let coefficients = friction.coefficients();
    let tangential = friction.name().zip(coefficients).and_then(|(law, f)| {
        let what = format!("tangential multipliers ({} {law})", f.shape());
        unknowns(sizes.n_panes.map(|m| 2 * m), &what)
    });
    let varies = coefficients.is_some_and(FrictionLaw::depends_on_place);
    let slips = friction.follows_slip().then(|| {
        let count = sizes.n_contact_nodes.map(|n| 2 * n);
        unknowns(count, "slips of contact nodes")
    });
    [
        Feature {
            name: "friction",
            present: tangential,
        },
        Feature {
            name: "slip-dependent coefficients",
            present: slips.flatten(),
        },
        Feature {
            name: "place-dependent coefficients",
            present: data(varies, "evaluated at every contact node"),
        },
    ]
}

/// One line for each feature present, and one that names the absent ones.
pub(super) fn lines(features: &ModelFeatures, sizes: &Sizes) -> String {
    let mut text = String::new();
    let mut absent = Vec::new();
    for feature in list(features, sizes) {
        match feature.present {
            Some(cost) => {
                let _ = writeln!(text, "  {:<28} {}", feature.name, cost.words);
            }
            None => absent.push(feature.name),
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

/// The features for programs.
pub(super) fn json(features: &ModelFeatures, sizes: &Sizes) -> serde_json::Value {
    let (present, absent): (Vec<_>, Vec<_>) = list(features, sizes)
        .into_iter()
        .partition(|feature| feature.present.is_some());
    let present: Vec<_> = present
        .into_iter()
        .filter_map(|feature| {
            let Cost { words, unknowns } = feature.present?;
            Some(serde_json::json!({ "effect": feature.name, "cost": words, "unknowns": unknowns }))
        })
        .collect();
    let absent: Vec<_> = absent.iter().map(|feature| feature.name).collect();
    serde_json::json!({ "present": present, "absent": absent })
}
