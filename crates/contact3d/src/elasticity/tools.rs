//! Rigid tools as rows beside the nodes of the mesh.
//!
//! A tool moves a place x by T + ω × (x − c). Its rows are T and a ω with the arm a, the farthest that its faces reach from c, so that
//! both are displacements in m; forces on the rows are the force F and M/a.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::{
    linalg::UNIT_ROUNDING,
    mesh::Mesh,
    scene::{InvalidValue, Obstacle, POSITION, Scene, UNDEFINED, Written, place_words},
};

/// Where a tool is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolPlace {
    /// The point c in m.
    pub point: [f64; 3],
    /// The arm a in m.
    pub arm: f64,
}

impl ToolPlace {
    /// The places of the tools of a scene on its mesh.
    #[must_use]
    pub fn of_scene(scene: &Scene, mesh: &Mesh) -> Vec<Self> {
        let tools = 0..scene.tools.len();
        tools.map(|tool| Self::new(scene, mesh, tool)).collect()
    }

    fn new(scene: &Scene, mesh: &Mesh, tool: usize) -> Self {
        let (mut area, mut moment) = (0.0, Vector3::zeros());
        let mut places = Vec::new();
        let bonded = scene.tools[tool].face.as_deref();
        for facet in bonded.into_iter().flat_map(|face| mesh.facets_on(face)) {
            let (whole, integrals) = mesh.side_integrals(facet);
            area += whole;
            for (node, integral) in integrals {
                let at = Vector3::from(mesh.coordinates[node]);
                moment += at * integral;
                places.push(at);
            }
        }
        let order = scene.contact_order();
        if let Some(surface) = &mesh.contact {
            let faces = surface.faces.iter().zip(&order);
            for (face, _) in faces.filter(|(_, entry)| scene.tool_on(**entry) == Some(tool)) {
                let at = |local: usize| Vector3::from(mesh.coordinates[surface.nodes[local]]);
                places.extend(face.nodes.clone().map(at));
                for pane in face.panes.clone() {
                    let whole = surface.pane_area[pane];
                    area += whole;
                    for (local, weight) in surface.pane_weights(pane) {
                        moment += at(local) * (whole * weight);
                    }
                }
            }
        }
        let farthest = |from: &Vector3<f64>| {
            let distances = places.iter().map(|x| (x - from).norm());
            distances.fold(0.0, f64::max)
        };
        let centroid = moment / area;
        let point = scene.tools[tool].point.map(Vector3::from);
        let mut round = order
            .iter()
            .filter(|entry| scene.tool_on(**entry) == Some(tool));
        let round = round.find_map(|entry| match scene.contacts[*entry].obstacle.as_ref()? {
            Obstacle::Sphere(ball) => Some(Vector3::from(ball.centre)),
            Obstacle::Cylinder(rod) => {
                let (point, along) = (Vector3::from(rod.point), Vector3::from(rod.direction));
                let along = (along / along.amax()).normalize();
                Some(point + along * along.dot(&(centroid - point)))
            }
            Obstacle::HalfSpace(_) | Obstacle::Height(_) | Obstacle::Surface(_) => None,
        });
        let point = point.or(round).unwrap_or_else(|| {
            // What is rounding of the extent of the face is zero.
            let digits = UNIT_ROUNDING * farthest(&centroid);
            centroid.map(|x| if x.abs() <= digits { 0.0 } else { x })
        });
        Self {
            arm: farthest(&point),
            point: point.into(),
        }
    }

    /// (x − c)/a: a place x moves by T + aω × that.
    #[must_use]
    pub fn lever(&self, place: [f64; 3]) -> [f64; 3] {
        ((Vector3::from(place) - Vector3::from(self.point)) / self.arm).into()
    }

    /// The rows of a displacement of the point in m and a rotation vector in radians.
    #[must_use]
    pub fn rows(&self, [displacement, turn]: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
        [displacement, turn.map(|angle| angle * self.arm)]
    }
}

/// A point that moves with a tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolPoint {
    /// The tool by its place in the scene.
    pub tool: usize,
    /// The place of the point from that of the tool over its arm ([`ToolPlace::lever`]).
    pub lever: [f64; 3],
}

impl ToolPoint {
    /// The displacement of the point in m by the rows of all tools in m, counted from 0.
    #[must_use]
    pub fn moved(&self, row: impl Fn(usize) -> [f64; 3]) -> [f64; 3] {
        let [shift, turn] = [0, 1].map(|k| Vector3::from(row(2 * self.tool + k)));
        (shift + turn.cross(&Vector3::from(self.lever))).into()
    }

    /// Forces on both rows of the tool that do the work of one at the point.
    #[must_use]
    pub fn on_rows(&self, force: [f64; 3]) -> [[f64; 3]; 2] {
        // force · (turn × lever) = turn · (lever × force)
        let about = Vector3::from(self.lever).cross(&Vector3::from(force));
        [force, about.into()]
    }
}

/// The nodes of the faces that are bonded to tools.
pub(super) fn tied_nodes(scene: &Scene, mesh: &Mesh) -> BTreeMap<usize, ToolPoint> {
    let mut tied = BTreeMap::new();
    for (tool, given) in scene.tools.iter().enumerate() {
        let Some(face) = &given.face else { continue };
        let place = ToolPlace::new(scene, mesh, tool);
        for node in mesh
            .facets_on(face)
            .flat_map(|facet| mesh.facet_nodes(facet))
        {
            let lever = place.lever(mesh.coordinates[node]);
            tied.entry(node).or_insert(ToolPoint { tool, lever });
        }
    }
    tied
}

/// Refuses clamps that hold a node of a bonded face elsewhere than the tool does.
///
/// # Errors
/// The clamp and the place of the first such node.
pub(super) fn require_agreement(
    scene: &Scene,
    mesh: &Mesh,
    clamped: &[[Option<(usize, f64)>; 3]],
    held: &[[f64; 3]],
) -> Result<(), InvalidValue> {
    let free: Vec<[bool; 3]> = held_rows(scene).map(|row| row.map(|held| !held)).collect();
    for (node, point) in tied_nodes(scene, mesh) {
        for (c, clamp) in clamped[node].iter().enumerate() {
            let Some((clamp, value)) = clamp else {
                continue;
            };
            let rows = point.on_rows(std::array::from_fn(|k| if k == c { 1.0 } else { 0.0 }));
            let is_free = (0..2).any(|k| {
                let row = free[2 * point.tool + k];
                (0..3).any(|c| row[c] && rows[k][c].abs() > UNIT_ROUNDING)
            });
            let moved = held[node][c];
            if !is_free && (moved - value).abs() <= UNIT_ROUNDING * moved.abs().max(value.abs()) {
                continue;
            }
            return Err(InvalidValue {
                key: format!("clamp.{clamp}"),
                expected: format!(
                    "nodes that move as the tool {} does, to which {} is bonded",
                    scene.tool_name(point.tool),
                    scene.tools[point.tool].face.as_deref().unwrap_or_default()
                ),
                found: format!(
                    "the node at {}, which the clamp holds at {} along {}, where the tool {}",
                    place_words(mesh.coordinates[node]),
                    Written(value),
                    POSITION[c],
                    if is_free { "is free".to_owned() } else { format!("moves by {}", Written(&moved)) }
                ),
                help: "hold the motions of the tool that would move this node there, or keep the clamp off the face".into(),
            });
        }
    }
    Ok(())
}

/// Which motions of each tool are held, row by row.
pub(super) fn held_rows(scene: &Scene) -> impl Iterator<Item = [bool; 3]> {
    scene
        .tools
        .iter()
        .flat_map(|tool| [0, 3].map(|first| std::array::from_fn(|c| !tool.is_free(first + c))))
}

/// Farthest place of a tool's point over the size of the body: half of the digits of a turn are left on the face.
const FARTHEST_POINT: f64 = 1e8;

/// The places of the tools.
///
/// # Errors
/// A point too far from the faces.
fn near_places(scene: &Scene, mesh: &Mesh) -> Result<Vec<ToolPlace>, InvalidValue> {
    let places = ToolPlace::of_scene(scene, mesh);
    let is_near = |place: &ToolPlace| place.arm <= FARTHEST_POINT * mesh.extent();
    match places.iter().position(|place| !is_near(place)) {
        None => Ok(places),
        Some(tool) => Err(InvalidValue {
            key: format!("tool.{tool}.point"),
            expected: format!(
                "a point within {FARTHEST_POINT:e} times the body's size of its faces"
            ),
            found: Written(&places[tool].point).to_string(),
            help: "check the place of the point, and the unit of lengths".into(),
        }),
    }
}

/// The rows at which the tools are held in m, zero where free.
///
/// # Errors
/// A formula that is not finite, a point too far away.
pub(super) fn prescribed_rows(scene: &Scene, mesh: &Mesh) -> Result<Vec<[f64; 3]>, InvalidValue> {
    let places = near_places(scene, mesh)?;
    let mut rows = Vec::with_capacity(2 * places.len());
    for ((i, tool), place) in scene.tools.iter().enumerate().zip(&places) {
        let [shift, turn] = tool.held_motion();
        finite(i, [("displacement", shift), ("turn", turn)])?;
        rows.extend(place.rows([shift, turn]));
    }
    Ok(rows)
}

/// The forces on the rows of the tools in N.
///
/// # Errors
/// As [`prescribed_rows`].
pub(crate) fn tool_loads(scene: &Scene, mesh: &Mesh) -> Result<Vec<[f64; 3]>, InvalidValue> {
    let places = near_places(scene, mesh)?;
    let mut rows = Vec::with_capacity(2 * places.len());
    for ((i, tool), place) in scene.tools.iter().enumerate().zip(&places) {
        let [force, moment] = tool.load();
        finite(i, [("force", force), ("moment", moment)])?;
        rows.push(force);
        rows.push(moment.map(|moment| moment / place.arm));
    }
    Ok(rows)
}

fn finite(tool: usize, vectors: [(&str, [f64; 3]); 2]) -> Result<(), InvalidValue> {
    let is_infinite = |(_, vector): &(&str, [f64; 3])| !vector.iter().all(|v| v.is_finite());
    match vectors.into_iter().find(is_infinite) {
        None => Ok(()),
        Some((name, vector)) => Err(InvalidValue {
            key: format!("tool.{tool}.{name}"),
            expected: "finite numbers".into(),
            found: Written(&vector).to_string(),
            help: UNDEFINED.into(),
        }),
    }
}
