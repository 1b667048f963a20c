//! What is said of an answer: its surroundings, how its body moves, its quantities with their error bars.

use contact3d::{
    elasticity::{BodyMotion, ToolPlace},
    mesh::{BodyRange, Mesh},
    post::{ContactReport, FunctionalEstimate, StressConcentration},
    scene::{Functional, Scene, escape_control},
    solver::{LocalMapping, Solution},
};
use serde_json::{Value, json};
use units::{Dimension, Unit, Units};

use super::percent;
use crate::format::dimension_of_quantity as dimension;

/// The spectral radius of Ψ' in words.
pub(super) fn radius_words(local: &LocalMapping) -> String {
    let radius = local.spectral_radius;
    if local.is_attracting() {
        format!("{radius:.4}")
    } else {
        format!("{radius:.3e}, not below 1: successive approximations leave this solution")
    }
}

/// What the sign of det R' says about other solutions; `None` where it says nothing.
pub(super) fn sign_words(local: &LocalMapping) -> Option<String> {
    match local.determinant_sign {
        -1 => Some(
            "negative: at least two other solutions exist (`branches --all` searches for them)"
                .to_owned(),
        ),
        0 => Some("zero: other solutions may lie nearby (`branches` follows them)".to_owned()),
        _ => None,
    }
}

/// What the nearness of det R' = 0 says; `None` where it is not near.
pub(super) fn fold_words(local: &LocalMapping) -> Option<String> {
    let distance = local.fold_distance;
    local.is_near_fold().then(|| {
        format!(
            "{distance:.2e}: another solution may be near, and small changes of the data move this one far \
             (`branches` follows it)"
        )
    })
}

/// What is to be said of the rigid motion of a body that only contact holds: the mechanism, or the one nearest to its
/// displacement; `None` where supports hold it.
pub(super) fn motion_words(
    scene: &Scene,
    mesh: &Mesh,
    solution: &Solution,
    report: &ContactReport,
) -> Option<(&'static str, String)> {
    let units = scene.units;
    let rigid = solution.rigid.as_ref()?;
    if let Some(rows) = &rigid.mechanism {
        return Some(("mechanism", rows_in_words(scene, mesh, rows)));
    }
    if rigid.motion.len() == scene.n_free_tool_motions() || !solution.status.is_solved() {
        return None;
    }
    let volumes = mesh.corner_volumes();
    let of_body = |body: BodyRange| {
        let places = &mesh.coordinates[body.nodes.clone()];
        let volumes = &volumes[body.nodes.clone()];
        let motion = BodyMotion::told(places, volumes, &report.displacement[body.nodes]);
        let volume: f64 = volumes.iter().sum();
        let along = |c: usize| {
            places
                .iter()
                .zip(volumes)
                .map(|(x, v)| x[c] * v)
                .sum::<f64>()
        };
        let middle = [0, 1, 2].map(|c| along(c) / volume);
        let shift = units.of(Dimension::LENGTH).told(&motion.at(middle));
        let turn = motion.turn().map_or_else(String::new, |(angle, about)| {
            format!(", turns by {angle:.3e} rad about {about}")
        });
        let words = format!("by {shift} at its middle{turn}");
        match body.name.as_str() {
            "" => words,
            name => format!("{name} {words}"),
        }
    };
    // Beside bodies that nothing holds, others deform only.
    let held = mesh.held_nodes(scene);
    let floats = |group: &Vec<usize>| {
        let mut nodes = group.iter().flat_map(|body| mesh.body_nodes(*body));
        !nodes.any(|node| held[node] == [true; 3])
    };
    let ranges = mesh.body_ranges();
    let floating = mesh.glued_bodies().into_iter().filter(floats).flatten();
    let bodies = floating.map(|body| of_body(ranges[body].clone()));
    let words = bodies.collect::<Vec<_>>().join("; ");
    (!words.is_empty()).then_some(("moves", words))
}

/// A rigid motion of the body and the tools, whose rows follow the nodes, in words.
fn rows_in_words(scene: &Scene, mesh: &Mesh, rows: &[[f64; 3]]) -> String {
    let (body, tools) = rows.split_at(mesh.coordinates.len());
    let length = scene.units.length();
    let is_rounding = |rows: &[[f64; 3]]| rows.as_flattened().iter().all(|u| u.abs() < 1e-9);
    let volumes = mesh.corner_volumes();
    let mut words = Vec::new();
    for range in mesh.body_ranges() {
        let nodes = range.nodes.clone();
        let (places, rows) = (&mesh.coordinates[nodes.clone()], &body[nodes.clone()]);
        if is_rounding(rows) {
            continue;
        }
        let motion = BodyMotion::told(places, &volumes[nodes], rows).describe(length);
        words.push(match range.name.as_str() {
            "" => motion,
            name => format!("{motion} of the body {}", escape_control(name)),
        });
    }
    let places = ToolPlace::of_scene(scene, mesh);
    for (tool, (place, rows)) in places.iter().zip(tools.as_chunks::<2>().0).enumerate() {
        if is_rounding(rows) {
            continue;
        }
        let motion = BodyMotion {
            translation: rows[0],
            rotation: rows[1].map(|row| row / place.arm),
            point: place.point,
        };
        let name = escape_control(&scene.tool_name(tool));
        words.push(format!("{} of the tool {name}", motion.describe(length)));
    }
    words.join("; ")
}

/// The rigid motions of the only body that neither contact nor supports feel, and which the answer leaves at zero.
pub(super) fn null_space_motions(mesh: &Mesh, solution: &Solution) -> Vec<BodyMotion> {
    let null_space = solution.rigid.as_ref().map(|rigid| &rigid.null_space[..]);
    let null_space = null_space.unwrap_or_default();
    let is_longer = |rows: &Vec<_>| rows.len() > mesh.coordinates.len();
    if !mesh.bodies.is_empty() || null_space.iter().any(is_longer) {
        return Vec::new();
    }
    let motions = BodyMotion::telling(&mesh.coordinates, null_space);
    let volumes = mesh.corner_volumes();
    let told = |motion: &Vec<[f64; 3]>| BodyMotion::told(&mesh.coordinates, &volumes, motion);
    motions.iter().map(told).collect()
}

/// The same in words.
pub(super) fn null_space_words(
    scene: &Scene,
    mesh: &Mesh,
    solution: &Solution,
) -> Vec<(&'static str, String)> {
    let n_panes = mesh.contact.as_ref().map_or(0, |surface| surface.n_panes());
    let length = scene.units.length();
    let motions = null_space_motions(mesh, solution).into_iter();
    let motions = motions.map(|motion| motion.describe(length));
    let has_others = !scene.tools.is_empty() || !mesh.bodies.is_empty();
    let rigid = solution.rigid.iter().filter(|_| has_others);
    let with_tools = rigid.flat_map(|rigid| &rigid.null_space);
    let with_tools = with_tools.map(|rows| rows_in_words(scene, mesh, rows));
    let all = motions.chain(with_tools);
    let told = all.map(|words| format!("{words}: none of {n_panes} pane(s) feels it"));
    told.map(|words| ("null space, left at zero", words))
        .collect()
}

/// The name of a quantity for people.
pub(super) fn name_of_quantity(of: Functional) -> String {
    match of {
        Functional::TangentialForce => "friction force".to_owned(),
        Functional::PeakDisplacement => "mean displacement at peak".to_owned(),
        Functional::LargestVonMises => "largest von Mises stress".to_owned(),
        _ => of.word().replace('_', " "),
    }
}

/// Where the largest stress or pressure has no limit.
pub(super) fn edge_words(at: StressConcentration) -> &'static str {
    match at {
        StressConcentration::Notch => "a re-entrant edge",
        StressConcentration::Clamp => "the rim of a clamp",
        StressConcentration::Springs => "the rim of stiff springs",
        StressConcentration::Shear => "the end of a load along the face",
        StressConcentration::Materials => "an interface at the surface",
        StressConcentration::Contact => "an edge of the contact face",
    }
}

/// A value at a place with its error bar, in its unit where the bar is larger than the value, without one that is infinite; `grows` is where
/// it has no limit, with another place than its own.
pub(super) fn with_bar(
    unit: &Unit,
    [value, bar]: [f64; 2],
    place: &str,
    grows: Option<(StressConcentration, Option<String>)>,
) -> String {
    let told = unit.told(&[value]);
    if let Some((what, elsewhere)) = grows {
        let edge = edge_words(what);
        let where_it_grows = match elsewhere {
            None => format!(", {edge} where it grows with every finer mesh"),
            Some(at) => format!(" on this mesh; grows with every finer one at {at}, {edge}"),
        };
        return format!("above {told}{place}{where_it_grows}");
    }
    if bar.is_infinite() {
        return told + place;
    }
    if bar > value.abs() && value != 0.0 {
        let most = unit.told(&[value.abs() + bar]);
        return format!("{told}{place}, not resolved: up to {most} on a finer mesh");
    }
    // Balance of forces knows some to rounding.
    let share = if bar == 0.0 { 0.0 } else { bar / value.abs() };
    let share = if share < 1e-9 { 0.0 } else { share };
    format!("{told} ± {}{place}", percent(share))
}

/// The quantities for programs.
pub(super) fn quantities_json(units: Units, found: &[FunctionalEstimate]) -> Value {
    let row = |it: &FunctionalEstimate| {
        json!({
            "name": it.functional.word(),
            "unit": units.of(dimension(it.functional)).word(),
            "value": it.value,
            "error_bar": it.error_bar(),
            "signed_error": it.signed_error,
            "range": it.range,
            "box": it.corners,
            "kinks": it.kinks,
        })
    };
    found.iter().map(row).collect()
}
