//! The model features of a scene in words: what is computed, what it costs in unknowns, what is absent.

use std::fmt::Write;

use contact3d::scene::{ContactFeatures, FrictionLaw, ModelFeatures, MultiplierSpace, Obstacle};

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
        feature(
            "springs",
            data(
                features.springs > 0,
                &format!("on {} faces", features.springs),
            ),
        ),
        feature("body force", data(features.body_force, "loads every node")),
    ];
    let faces = &features.contact;
    list.push(feature("contact", contact(faces, sizes)));
    list.push(feature("obstacle", obstacles(faces)));
    list.push(feature(
        "initial gap",
        data(
            faces.iter().any(|face| face.gap.is_some()),
            "one value a contact node",
        ),
    ));
    list.extend(friction_features(faces, sizes));
    list.push(feature(
        "turning frame",
        data(
            faces.iter().any(|face| face.turning_frame),
            "one pair of axes a contact node",
        ),
    ));
    let what = match features.springs {
        0 => "motions that only contact stops",
        _ => "motions that only contact or soft springs stop",
    };
    let rigid = sizes.n_rigid_modes.map(|n| unknowns(Some(n), what));
    list.push(feature("rigid motions", rigid.flatten()));
    list
}

/// The obstacles; `None` where all foundations are those of flat faces.
fn obstacles(faces: &[ContactFeatures]) -> Option<Cost> {
    let obstacles: Vec<&Obstacle> = faces.iter().filter_map(|f| f.obstacle.as_ref()).collect();
    let mut words: Vec<&str> = obstacles.iter().map(|obstacle| obstacle.word()).collect();
    words.dedup();
    let varies = |obstacle: &&Obstacle| !matches!(obstacle, Obstacle::HalfSpace(_));
    let what = match obstacles.iter().any(varies) {
        true => "one normal and distance a contact node",
        false => "one distance a contact node",
    };
    data(
        !obstacles.is_empty(),
        &format!("{}, {what}", words.join(", ").replace('_', "-")),
    )
}

/// The normal multipliers; `None` without contact.
fn contact(faces: &[ContactFeatures], sizes: &Sizes) -> Option<Cost> {
    let has = |space| faces.iter().any(|face| face.space == space);
    let space = match [MultiplierSpace::Panes, MultiplierSpace::Nodal].map(has) {
        [true, true] => "panes and nodes",
        [true, false] => "panes",
        [false, true] => "nodes",
        [false, false] => return None,
    };
    let on = match faces.len() {
        1 => String::new(),
        n => format!(" on {n} faces"),
    };
    let count = sizes.panes.as_ref().map(|panes| panes.iter().sum());
    unknowns(count, &format!("normal multipliers{on} ({space})"))
}

fn friction_features(faces: &[ContactFeatures], sizes: &Sizes) -> [Feature; 3] {
    let mut laws: Vec<String> = Vec::new();
    for face in faces {
        if let Some((law, f)) = face.friction.name().zip(face.friction.coefficients()) {
            let words = format!("{} {law}", f.shape());
            if !laws.contains(&words) {
                laws.push(words);
            }
        }
    }
    // Faces with friction come first.
    let with = faces.iter().filter(|face| face.friction.name().is_some());
    let with = with.count();
    let of_faces = |sizes: &Option<Vec<usize>>, faces: usize| {
        let sizes = sizes.as_ref()?.iter();
        Some(2 * sizes.take(faces).sum::<usize>())
    };
    let tangential = (!laws.is_empty()).then(|| {
        let what = format!("tangential multipliers ({})", laws.join(", "));
        unknowns(of_faces(&sizes.panes, with), &what)
    });
    let mut coefficients = faces.iter().filter_map(|face| face.friction.coefficients());
    let varies = coefficients.any(FrictionLaw::depends_on_place);
    let follows = faces.iter().any(|face| face.friction.follows_slip());
    let slips = follows.then(|| {
        let count = of_faces(&sizes.contact_nodes, faces.len());
        unknowns(count, "slips of contact nodes")
    });
    [
        Feature {
            name: "friction",
            present: tangential.flatten(),
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
