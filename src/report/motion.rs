//! How a body that only contact holds moves, in words.

use contact3d::{elasticity::BodyMotion, mesh::Mesh, post::ContactReport, solver::Solution};
use units::Units;

/// What is to be said of the rigid motion of a body that only contact holds: that which nothing stops, or the one nearest to its
/// displacement; `None` where supports hold it.
pub(super) fn motion_words(
    units: Units,
    mesh: &Mesh,
    solution: &Solution,
    report: &ContactReport,
) -> Option<(&'static str, String)> {
    if let Some(motion) = &solution.unstopped_motion {
        let motion = BodyMotion::told(&mesh.coordinates, motion);
        return Some(("nothing stops", motion.describe(units.length())));
    }
    if solution.rigid_motion.is_empty() {
        return None;
    }
    let motion = BodyMotion::told(&mesh.coordinates, &report.displacement);
    Some(("moves on the whole", motion.sized(units.length())))
}

/// The rigid motions that neither contact nor supports feel, and which the answer leaves at zero.
pub(super) fn neutral_motions(mesh: &Mesh, solution: &Solution) -> Vec<BodyMotion> {
    let motions = BodyMotion::telling(&mesh.coordinates, &solution.neutral_motions);
    let told = |motion: &Vec<[f64; 3]>| BodyMotion::told(&mesh.coordinates, motion);
    motions.iter().map(told).collect()
}

/// The same in words.
pub(super) fn neutral_words(
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
    let motions = neutral_motions(mesh, solution);
    let line = |motion: &BodyMotion| {
        let words = motion.describe(units.length());
        (
            "neutral, left at zero",
            format!("{words}: none of {n_panes} {panes} it"),
        )
    };
    motions.iter().map(line).collect()
}
