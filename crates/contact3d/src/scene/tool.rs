//! Rigid tools, which move and are loaded.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    Follow, Measure, Obstacle, ProblemPart, Quantity, Scene, StepValue, is_default, varying::varies,
};

units::worded! {
    /// A degree of freedom of a rigid tool.
    #[derive(Serialize, Deserialize, JsonSchema)]
    #[serde(rename_all = "snake_case")]
    pub enum ToolMotion {
        /// Along x.
        X = "x",
        /// Along y.
        Y = "y",
        /// Along z.
        Z = "z",
        /// About an axis along x through the point of the tool.
        TurnX = "turn_x",
        /// About an axis along y.
        TurnY = "turn_y",
        /// About an axis along z.
        TurnZ = "turn_z",
    }
}

/// A rigid tool: the obstacles of the contact faces that name it, and the face that is bonded to it, move as one,
/// u(x) = `displacement` + `turn` × (x − `point`). Each of its six motions is held where these say, or free under `force` and `moment`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tool {
    /// What `contact.tool`, steps and results call it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The face of the body that is bonded to the tool: it moves with it and keeps its shape. Without one the tool only touches.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub face: Option<String>,
    /// The point in m that `displacement` is of, about which the tool turns and at which the force acts; when not given the centre
    /// of its sphere, the place on the axis of its cylinder nearest to the centroid of its faces, or that centroid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Length))]
    pub point: Option<[f64; 3]>,
    /// The motions that are free, under the force and the moment given; the others are held.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub free: Vec<ToolMotion>,
    /// The displacement of the point in m along x, y and z: numbers, or expressions of parameters; zero where free.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(extend("part" = ProblemPart::Loads, "measures" = Measure::Displacement))]
    pub displacement: [Quantity; 3],
    /// The rotation vector in radians, which is small: numbers, or expressions of parameters; zero where free.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(extend("part" = ProblemPart::Loads, "measures" = Measure::Angle))]
    pub turn: [Quantity; 3],
    /// The force on the tool in N along x, y and z: numbers, or expressions of parameters; zero where held.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(extend("part" = ProblemPart::Loads, "measures" = Measure::Force))]
    pub force: [Quantity; 3],
    /// The moment on the tool about its point in N·m: numbers, or expressions of parameters; zero where held.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(extend("part" = ProblemPart::Loads, "measures" = Measure::Moment))]
    pub moment: [Quantity; 3],
}

varies!(Tool named name: displacement, turn, force, moment);

impl Tool {
    /// Its keys with three components each.
    pub(super) fn vectors(&self) -> [(&'static str, &[Quantity; 3]); 4] {
        [
            ("displacement", &self.displacement),
            ("turn", &self.turn),
            ("force", &self.force),
            ("moment", &self.moment),
        ]
    }

    /// Whether a motion, counted from 0, is free.
    #[must_use]
    pub fn is_free(&self, motion: usize) -> bool {
        self.free.contains(&ToolMotion::ALL[motion])
    }

    /// Displacement in m and rotation vector in radians where they are held; zero where they are free.
    #[must_use]
    pub fn held_motion(&self) -> [[f64; 3]; 2] {
        [&self.displacement, &self.turn].map(numbers)
    }

    /// Force in N and moment in N·m where the motions are free; zero where they are held.
    #[must_use]
    pub fn load(&self) -> [[f64; 3]; 2] {
        [&self.force, &self.moment].map(numbers)
    }

    /// Whether it is held elsewhere than at rest; by a formula it is taken to be.
    #[must_use]
    pub fn is_moved(&self) -> bool {
        !is_default(&self.displacement) || !is_default(&self.turn)
    }
}

/// What does not depend on the place, at any place.
fn numbers(vector: &[Quantity; 3]) -> [f64; 3] {
    vector.each_ref().map(|value| value.at([0.0; 3]))
}

impl Scene {
    /// The tool, by its place in the scene, that the obstacle of a contact belongs to; `None` where it rests.
    #[must_use]
    pub fn tool_on(&self, entry: usize) -> Option<usize> {
        let name = self.contacts.get(entry)?.tool.as_deref()?;
        let mut tools = self.tools.iter();
        tools.position(|tool| tool.name.as_deref() == Some(name))
    }

    /// Whether the normals and distances of any obstacle follow a tool from increment to increment.
    #[must_use]
    pub fn follows_tools(&self) -> bool {
        let mut entries = 0..self.contacts.len();
        entries.any(|entry| self.follow_of(entry) == Follow::Increment)
    }

    /// Displacements and turns of the tools where the scene drives them to; free motions stay where they are. Normals are those there: forces
    /// are those of the end of an increment, and along normals of its beginning they would pull by N Δx / R for a pressing force N and a way Δx
    /// over a radius R.
    #[must_use]
    pub fn driven(&self, motions: &[[[f64; 3]; 2]]) -> Vec<[[f64; 3]; 2]> {
        let of_tool = |(tool, from): (&Tool, &[[f64; 3]; 2])| {
            let to = tool.held_motion();
            let motion = |k: usize, c: usize| match tool.is_free(3 * k + c) {
                true => from[k][c],
                false => to[k][c],
            };
            [0, 1].map(|k| [0, 1, 2].map(|c| motion(k, c)))
        };
        self.tools.iter().zip(motions).map(of_tool).collect()
    }

    /// Where the normals and distances of a contact are taken: where it says, or by how its tool moves. Those of a tool that is only pressed
    /// on the flat side of a brick stay: nodes at its rim would leave a sharp edge by the little that the body widens.
    #[must_use]
    pub fn follow_of(&self, entry: usize) -> Follow {
        let contact = &self.contacts[entry];
        let pressed = self.brick_face(&contact.face).map(|(_, face)| face.axis());
        let drives = |turns: bool, motion: &[Quantity; 3]| {
            let mut parts = motion.iter().enumerate();
            parts.any(|(c, part)| *part != Quantity::Constant(0.0) && (turns || Some(c) != pressed))
        };
        let is_driven = |tool: usize| {
            let given = &self.tools[tool];
            let name = self.tool_name(tool);
            let motions = [("displacement", &given.displacement), ("turn", &given.turn)];
            motions.into_iter().any(|(motion, at_first)| {
                let turns = motion == "turn";
                let key = format!("{name}.{motion}");
                let mut steps = self.steps.iter().filter_map(|step| step.value.get(&key));
                drives(turns, at_first)
                    || steps.any(|value| match value {
                        StepValue::Vector(to) => drives(turns, to),
                        StepValue::Number(_) => false,
                    })
            })
        };
        let is_flat = matches!(contact.obstacle, None | Some(Obstacle::HalfSpace(_)));
        let follows =
            !self.steps.is_empty() && !is_flat && self.tool_on(entry).is_some_and(is_driven);
        contact.follow.unwrap_or(if follows {
            Follow::Increment
        } else {
            Follow::Start
        })
    }

    /// Number of free motions of all tools.
    #[must_use]
    pub fn n_free_tool_motions(&self) -> usize {
        let all = 0..ToolMotion::ALL.len();
        let free = |tool: &Tool| all.clone().filter(|motion| tool.is_free(*motion)).count();
        self.tools.iter().map(free).sum()
    }

    /// What messages and results call a tool: its name, or its key.
    #[must_use]
    pub fn tool_name(&self, tool: usize) -> String {
        let name = self.tools[tool].name.clone();
        name.unwrap_or_else(|| format!("tool.{tool}"))
    }
}
