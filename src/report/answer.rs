//! What is said of an answer: its surroundings, how its body moves, its quantities with their error bars.

use contact3d::{
    elasticity::BodyMotion,
    mesh::Mesh,
    post::{ContactReport, FunctionalEstimate},
    scene::Functional,
    solver::{LocalMapping, Solution},
};
use serde_json::{Value, json};
use units::{Dimension, Units};

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
    units: Units,
    mesh: &Mesh,
    solution: &Solution,
    report: &ContactReport,
) -> Option<(&'static str, String)> {
    let rigid = solution.rigid.as_ref()?;
    if let Some(motion) = &rigid.mechanism {
        let motion = BodyMotion::told(&mesh.coordinates, motion);
        return Some(("mechanism", motion.describe(units.length())));
    }
    let motion = BodyMotion::told(&mesh.coordinates, &report.displacement);
    Some(("moves on the whole", motion.sized(units.length())))
}

/// The rigid motions that neither contact nor supports feel, and which the answer leaves at zero.
pub(super) fn null_space_motions(mesh: &Mesh, solution: &Solution) -> Vec<BodyMotion> {
    let null_space = solution.rigid.as_ref().map(|rigid| &rigid.null_space[..]);
    let motions = BodyMotion::telling(&mesh.coordinates, null_space.unwrap_or_default());
    let told = |motion: &Vec<[f64; 3]>| BodyMotion::told(&mesh.coordinates, motion);
    motions.iter().map(told).collect()
}

/// The same in words.
pub(super) fn null_space_words(
    units: Units,
    mesh: &Mesh,
    solution: &Solution,
) -> Vec<(&'static str, String)> {
    let n_panes = mesh.contact.as_ref().map_or(0, |surface| surface.n_panes());
    let panes = if n_panes == 1 {
        "pane feels"
    } else {
        "panes feel"
    };
    let motions = null_space_motions(mesh, solution);
    let line = |motion: &BodyMotion| {
        let words = motion.describe(units.length());
        (
            "null space, left at zero",
            format!("{words}: none of {n_panes} {panes} it"),
        )
    };
    motions.iter().map(line).collect()
}

/// The name of a quantity and what it is by the estimate, for people; of forces not above `noise` 0.
pub(super) fn quantity_words(
    units: Units,
    it: &FunctionalEstimate,
    has_few_panes: bool,
    noise: f64,
) -> (String, String) {
    let unit = units.of(dimension(it.functional));
    let name = match (it.functional, it.corners) {
        (Functional::LargestDisplacement, Some(_)) => "mean displacement near peak".to_owned(),
        (of, _) if of.is_area() => of.word().replace('_', " "),
        (of, _) => format!("{}, error bar", of.word().replace('_', " ")),
    };
    let value = match it.functional {
        Functional::ContactArea | Functional::StickArea => {
            let [low, high] = it.range;
            let few = if has_few_panes { ", on few panes" } else { "" };
            format!(
                "{:.4e} {} ({low:.4e} to {high:.4e}{few})",
                it.value,
                unit.word()
            )
        }
        Functional::LargestPressure => {
            let place = place_of_pane(units, it);
            if it.range[1].is_finite() {
                format!(
                    "{:.4e} {} ± {}{place}",
                    it.value,
                    unit.word(),
                    bar(it, unit.word())
                )
            } else {
                format!(
                    "above {:.4e} {}{place}, an edge of the contact face where it grows with every finer mesh",
                    it.value,
                    unit.word()
                )
            }
        }
        Functional::TangentialForce if it.value.abs() <= noise => format!("0 {}", unit.word()),
        _ => format!(
            "{:.4e} {} ± {}{}",
            it.value,
            unit.word(),
            bar(it, unit.word()),
            cautions(units, it)
        ),
    };
    (name, value)
}

/// An error bar relative to its value, or in a unit where the value is no more than the bar.
fn bar(it: &FunctionalEstimate, unit: &str) -> String {
    let [low, high] = it.range;
    match it.relative() {
        share @ ..=1.0 => percent(share),
        _ => format!("{:.1e} {unit}", (high - it.value).max(it.value - low)),
    }
}

/// The middle of the box of the largest pressure.
fn place_of_pane(units: Units, it: &FunctionalEstimate) -> String {
    it.corners.map_or_else(String::new, |[low, high]| {
        let [x, y, z] = [0, 1, 2].map(|c| (low[c] + high[c]) / 2.0);
        let unit = units.of(Dimension::LENGTH);
        format!(" at ({x:.4}, {y:.4}, {z:.4}) {}", unit.word())
    })
}

/// The box of a mean, and panes at kinks.
fn cautions(units: Units, it: &FunctionalEstimate) -> String {
    let mean = it.corners.map_or_else(String::new, |[low, high]| {
        let unit = units.of(Dimension::LENGTH);
        let corner = |[x, y, z]: [f64; 3]| format!("({x:.4}, {y:.4}, {z:.4})");
        format!(
            ", mean from {} to {} {}",
            corner(low),
            corner(high),
            unit.word()
        )
    });
    let kinks = match it.kinks {
        0 => String::new(),
        1 => ", 1 pane at a kink".into(),
        many => format!(", {many} panes at kinks"),
    };
    mean + &kinks
}

/// The quantities for programs.
pub(super) fn quantities_json(units: Units, found: &[FunctionalEstimate]) -> Value {
    let row = |it: &FunctionalEstimate| {
        json!({
            "name": it.functional.word(),
            "unit": units.of(dimension(it.functional)).word(),
            "value": it.value,
            "error": it.error,
            "range": it.range,
            "box": it.corners,
            "kinks": it.kinks,
        })
    };
    found.iter().map(row).collect()
}
