//! How a body that only contact holds moves, in words.

use contact3d::{elasticity::BodyMotion, mesh::Mesh, post::ContactReport, solver::Solution};
use units::Units;

/// What is to be said of the rigid motion of a body that only contact holds: that which nothing stops, or the one nearest to its
/// displacement; `None` where supports hold it.
pub(crate) fn motion_words(
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
