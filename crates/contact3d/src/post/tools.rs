//! What rigid tools do.

use nalgebra::Vector3;

use super::{Solved, resultants::NodalForces};
use crate::{
    contact::Counterpart,
    elasticity::{ToolPlace, ToolPoint},
};

/// A tool at a solution.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ToolState {
    /// The point that it turns about in m.
    pub point: [f64; 3],
    /// Displacement of the point in m.
    pub displacement: [f64; 3],
    /// Rotation vector in radians.
    pub turn: [f64; 3],
    /// Force of the tool on the body in N, which is that on the tool from outside.
    pub force: [f64; 3],
    /// Its moment in N·m about the point, where equilibrium is taken: where it begins, or where the increment drives it to if normals follow it.
    pub moment: [f64; 3],
}

impl ToolState {
    /// Those of the tools of a scene.
    pub(super) fn of(solved: &Solved<'_>, forces: &NodalForces) -> Vec<Self> {
        let rows = solved.system.dofs.tool_rows(&solved.solution.displacement);
        let places = ToolPlace::of_scene(solved.scene, solved.mesh);
        let states = places.iter().zip(rows.as_chunks::<2>().0);
        let state = |(place, [shift, turn]): (&ToolPlace, &[[f64; 3]; 2])| Self {
            point: place.point,
            displacement: *shift,
            turn: turn.map(|row| row / place.arm),
            ..Self::default()
        };
        let mut tools: Vec<Self> = states.map(state).collect();
        let mut add = |point: &ToolPoint, force: Vector3<f64>| {
            let lever = Vector3::from(point.lever) * places[point.tool].arm;
            let tool = &mut tools[point.tool];
            tool.force = (Vector3::from(tool.force) + force).into();
            tool.moment = (Vector3::from(tool.moment) + lever.cross(&force)).into();
        };
        for (node, point) in &*solved.system.dofs.tied {
            let force = forces.tools.as_ref().map_or([0.0; 3], |all| all[*node]);
            add(point, force.into());
        }
        let Some(contact) = &solved.contact else {
            return tools;
        };
        let (surface, frame) = (contact.state.surface, &contact.state.interface.frame);
        let (multiplier, layout) = (&solved.solution.multiplier, contact.coupling.layout);
        for pane in 0..layout.n_panes() {
            for (local, weight) in surface.pane_weights(pane) {
                let Some(Counterpart::Tool(opposite)) = frame.opposite.get(local) else {
                    continue;
                };
                let tangential = layout.pair(multiplier, pane);
                let stress = frame.vector(local, multiplier[layout.normal(pane)], tangential);
                let area = weight * surface.pane_area[pane];
                add(opposite, Vector3::from(stress) * -area);
            }
        }
        tools
    }

    /// The displacement in m of a place that moves with the tool.
    #[must_use]
    pub fn displacement_at(&self, place: [f64; 3]) -> [f64; 3] {
        let arm = Vector3::from(place) - Vector3::from(self.point);
        (Vector3::from(self.displacement) + Vector3::from(self.turn).cross(&arm)).into()
    }

    /// Work in J of the forces from outside along a straight way from an earlier state.
    pub(crate) fn work_since(&self, before: &Self) -> f64 {
        let mean_work = |[now, earlier]: [[f64; 3]; 2], [to, from]: [[f64; 3]; 2]| {
            let works = (0..3).map(|c| 0.5 * (now[c] + earlier[c]) * (to[c] - from[c]));
            works.sum::<f64>()
        };
        mean_work(
            [self.force, before.force],
            [self.displacement, before.displacement],
        ) + mean_work([self.moment, before.moment], [self.turn, before.turn])
    }
}
