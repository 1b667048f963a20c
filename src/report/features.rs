//! The model features of a scene in words: what is computed, what it costs in unknowns, what is absent.

use contact3d::scene::{ContactFeatures, FrictionLaw, Material, MultiplierSpace, Obstacle, Scene};

use serde_json::Value;

use super::Figures;
use crate::format::StageSizes;

/// What a feature adds in words, and its unknowns, once the mesh is known: their number and what they are.
fn unknowns(count: Option<usize>, what: &str) -> Option<(String, Value)> {
    let number = count.map_or(String::new(), |count| format!("{count} "));
    Some((number + what, count.into()))
}

/// A feature without unknowns of its own.
fn data(present: bool, words: impl std::fmt::Display) -> Option<(String, Value)> {
    present.then(|| (format!("{words}, no unknowns"), 0.into()))
}

/// All features, in the order in which they build on each other.
fn list(scene: &Scene, sizes: &StageSizes) -> Vec<(&'static str, Option<(String, Value)>)> {
    let faces = &scene.contact_features();
    let clamps = scene.clamps.iter().filter(|clamp| clamp.is_moved()).count();
    let (regions, springs) = (scene.regions.len(), scene.springs.len());
    let mut materials = scene.materials();
    let is_anisotropic = materials.any(|(_, material)| !matches!(material, Material::Isotropic(_)));
    let has_gap = faces.iter().any(|face| face.gap.is_some());
    let turns = faces.iter().any(|face| face.turning_frame);
    let besides = format!("{regions} besides the body's own material");
    let by_clamps = format!("by {clamps} of the clamps");
    let on_faces = format!("on {}", counted(springs, "face"));
    let motions = if springs > 0 {
        "motions that only contact or soft springs stop"
    } else {
        "motions that only contact stops"
    };
    let of_tools = scene.n_free_tool_motions();
    let of_body = sizes.n_rigid_modes.map(|n| n.saturating_sub(of_tools));
    let rigid = of_body
        .filter(|n| *n > 0)
        .map(|n| unknowns(Some(n), motions));
    let tools = (!scene.tools.is_empty()).then(|| {
        let count = counted(scene.tools.len(), "tool");
        unknowns(Some(of_tools), &format!("free motions of {count}"))
    });
    let [friction, follows_slip, varies] = friction_features(faces, sizes);
    let pairs = scene.glued_pairs().count();
    let joints = data(
        pairs > 0,
        format!("{}, nodes follow others", counted(pairs, "pair")),
    );
    let glued = joints.map(|cost| ("glued faces", Some(cost)));
    let mut found = vec![
        ("elasticity", unknowns(sizes.n_free, "displacements")),
        ("anisotropy", data(is_anisotropic, "21 moduli")),
        ("regions", data(regions > 0, besides)),
        ("prescribed displacements", data(clamps > 0, by_clamps)),
        ("springs", data(springs > 0, on_faces)),
        (
            "body force",
            data(scene.body_force.is_some(), "loads every node"),
        ),
        ("contact", contact(faces, sizes)),
        ("obstacle", obstacles(faces)),
        ("initial gap", data(has_gap, "one value a contact node")),
        ("friction", friction),
        ("slip-dependent coefficients", follows_slip),
        ("place-dependent coefficients", varies),
        (
            "turning frame",
            data(turns, "one pair of axes a contact node"),
        ),
        ("rigid motions", rigid.flatten()),
        ("tools", tools.flatten()),
    ];
    found.extend(glued);
    found
}

/// The obstacles; `None` where all foundations are those of flat faces.
fn obstacles(faces: &[ContactFeatures]) -> Option<(String, Value)> {
    let obstacles: Vec<&Obstacle> = faces.iter().filter_map(|f| f.obstacle.as_ref()).collect();
    let mut words: Vec<&str> = obstacles.iter().map(|obstacle| obstacle.word()).collect();
    words.dedup();
    let varies = |obstacle: &&Obstacle| !matches!(obstacle, Obstacle::HalfSpace(_));
    let what = if obstacles.iter().any(varies) {
        "one normal and distance a contact node"
    } else {
        "one distance a contact node"
    };
    data(
        !obstacles.is_empty(),
        format!("{}, {what}", words.join(", ").replace('_', "-")),
    )
}

/// The normal multipliers; `None` without contact.
fn contact(faces: &[ContactFeatures], sizes: &StageSizes) -> Option<(String, Value)> {
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

/// Tangential multipliers, coefficients that follow the slip, and those that vary with the place.
fn friction_features(
    faces: &[ContactFeatures],
    sizes: &StageSizes,
) -> [Option<(String, Value)>; 3] {
    let mut laws: Vec<String> = Vec::new();
    for face in faces {
        if let Some(law) = &face.friction {
            let words = format!("{} {}", law.coefficients.shape(), law.bound.words().name);
            if !laws.contains(&words) {
                laws.push(words);
            }
        }
    }
    // Faces with friction come first.
    let with = faces.iter().filter(|face| face.friction.is_some()).count();
    let of_faces = |sizes: &Option<Vec<usize>>, faces: usize| {
        let sizes = sizes.as_ref()?.iter();
        Some(2 * sizes.take(faces).sum::<usize>())
    };
    let tangential = (!laws.is_empty()).then(|| {
        let what = format!("tangential multipliers ({})", laws.join(", "));
        unknowns(of_faces(&sizes.panes, with), &what)
    });
    let friction = faces.iter().filter_map(|face| face.friction.as_ref());
    let mut coefficients = friction.map(|law| &law.coefficients);
    let follows = coefficients.clone().any(FrictionLaw::depends_on_slip);
    let varies = coefficients.any(FrictionLaw::depends_on_place);
    let slips = follows.then(|| {
        let count = of_faces(&sizes.contact_nodes, faces.len());
        unknowns(count, "slips of contact nodes")
    });
    let varies = data(varies, "evaluated at every contact node");
    [tangential.flatten(), slips.flatten(), varies]
}

/// The features present with their costs, and the names of the absent ones.
pub fn features(scene: &Scene, sizes: &StageSizes) -> Figures {
    let mut figures = Figures::new(scene.units);
    let (mut present, mut absent) = (Vec::new(), Vec::new());
    for (name, cost) in list(scene, sizes) {
        let Some((words, unknowns)) = cost else {
            absent.push(name);
            continue;
        };
        present.push(serde_json::json!({ "effect": name, "cost": words, "unknowns": unknowns }));
        figures.human_only(name, Some(words));
    }
    let none = if absent.is_empty() {
        "nothing".to_owned()
    } else {
        absent.join(", ")
    };
    figures.human_only("absent, not computed", Some(none));
    figures.json_only("present", present);
    figures.json_only("absent", absent);
    figures
}

/// A number with what it counts.
fn counted(n: usize, what: &str) -> String {
    let ending = if n == 1 { "" } else { "s" };
    format!("{n} {what}{ending}")
}
