//! Clamps, springs, tractions, pressures and body forces.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::linalg::UNIT_ROUNDING;

use super::{Measure, ProblemPart, Quantity, Scene, is_default, varying::varies};

units::worded! {
    /// A displacement component in the global axes.
    #[derive(Serialize, Deserialize, JsonSchema)]
    #[serde(rename_all = "snake_case")]
    pub enum Component {
        /// u_x.
        X = "x",
        /// u_y.
        Y = "y",
        /// u_z.
        Z = "z",
    }
}

/// Displacement components held at given values, zero when not given, at the nodes of a face, inside a box, or both; at least
/// one of `face` and `box` is given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Clamp {
    /// A name that steps may use.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("part" = ProblemPart::Loads))]
    pub name: Option<String>,
    /// The held face: x_min … z_max of a brick, or a physical surface of a Gmsh file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub face: Option<String>,
    /// Two opposite corners [min, max] in m: the nodes between them, borders included, are held. A
    /// box may be as flat as an edge or a point; nodes that coordinates do not hit exactly need
    /// some width.
    #[serde(rename = "box", default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Length))]
    pub corners: Option<[[f64; 3]; 2]>,
    /// The held components; all three when not given.
    #[serde(default = "all_components")]
    pub components: Vec<Component>,
    /// The displacement u_c in m along x, y and z: numbers, or expressions in x, y, z; components that are not held
    /// have a zero.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(extend("part" = ProblemPart::Loads, "measures" = Measure::Displacement))]
    pub value: [Quantity; 3],
}

impl Clamp {
    /// Whether the held components are held somewhere else than at zero; by a formula they are taken to be.
    #[must_use]
    pub fn is_moved(&self) -> bool {
        !is_default(&self.value)
    }

    /// Whether this is the whole face of that name.
    #[must_use]
    pub(crate) fn is_face(&self, name: &str) -> bool {
        self.face.as_deref() == Some(name) && self.corners.is_none()
    }

    /// Whether a point lies in the box, up to the roundings of its coordinates; without one all do.
    #[must_use]
    pub(crate) fn holds(&self, point: &[f64; 3]) -> bool {
        // Cells are no narrower than 1e-9 of the body.
        let slack = UNIT_ROUNDING * point.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let holds = |c: usize, [low, high]: [[f64; 3]; 2]| {
            low[c] - slack <= point[c] && point[c] <= high[c] + slack
        };
        self.corners
            .is_none_or(|corners| (0..3).all(|c| holds(c, corners)))
    }
}

fn all_components() -> Vec<Component> {
    vec![Component::X, Component::Y, Component::Z]
}

varies!(Clamp named name: value);
varies!(Traction named name: value);
varies!(Pressure named name: value);
varies!(Force named name: value, moment);
varies!(BodyForce: value);
varies!(Spring: normal, tangential, tensor);

/// A surface traction σν = p.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Traction {
    /// A name that steps may use.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The loaded face.
    pub face: String,
    /// Two opposite corners [min, max] in m: only the part of the face between them is loaded. Triangles that the box cuts
    /// count with what lies inside.
    #[serde(rename = "box", default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Length))]
    pub corners: Option<[[f64; 3]; 2]>,
    /// The disc on the face that is loaded, in place of a box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disc: Option<Disc>,
    /// The traction vector p in Pa: numbers, or expressions in x, y, z.
    #[schemars(extend("measures" = Measure::Stress))]
    pub value: [Quantity; 3],
}

/// A pressure σν = −p ν, which pushes into the body where positive.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pressure {
    /// A name that steps may use.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The loaded face.
    pub face: String,
    /// Two opposite corners [min, max] in m: only the part of the face between them is loaded. Triangles that the box cuts
    /// count with what lies inside.
    #[serde(rename = "box", default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Length))]
    pub corners: Option<[[f64; 3]; 2]>,
    /// The disc on the face that is loaded, in place of a box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disc: Option<Disc>,
    /// The pressure p in Pa: a number, or an expression in x, y, z.
    #[schemars(extend("measures" = Measure::Stress))]
    pub value: Quantity,
}

/// A force and a moment on a face in all, spread as the traction σν = a + ω × (x − x_c) with the centroid x_c of the loaded part: uniform
/// where the force acts there and there is no moment.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Force {
    /// A name that steps may use.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The loaded face.
    pub face: String,
    /// Two opposite corners [min, max] in m: only the part of the face between them is loaded. Triangles that the box cuts
    /// count with what lies inside.
    #[serde(rename = "box", default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Length))]
    pub corners: Option<[[f64; 3]; 2]>,
    /// The disc on the face that is loaded, in place of a box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disc: Option<Disc>,
    /// The force in N along x, y and z: numbers, or expressions of parameters.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(extend("measures" = Measure::Force))]
    pub value: [Quantity; 3],
    /// The moment in N·m about `point`: numbers, or expressions of parameters.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(extend("measures" = Measure::Moment))]
    pub moment: [Quantity; 3],
    /// The point in m at which the force acts, and about which the moment does; the centroid of the loaded part when not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Length))]
    pub point: Option<[f64; 3]>,
}

/// A disc on a face: its points within a radius of a centre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disc {
    /// The centre in m, a point of the face.
    #[schemars(extend("measures" = Measure::Length))]
    pub centre: [f64; 3],
    /// The radius > 0 in m: stress under a load at a point has no bound.
    #[schemars(extend("measures" = Measure::Length, "exclusiveMinimum" = 0))]
    pub radius: f64,
}

/// A face, or the part of it inside a box or a disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacePart<'a> {
    /// The name of the face.
    pub face: &'a str,
    /// The corners of the box in m.
    pub corners: Option<[[f64; 3]; 2]>,
    /// The disc.
    pub disc: Option<Disc>,
}

impl FacePart<'_> {
    /// Whether it is no whole face.
    #[must_use]
    pub fn is_cut(&self) -> bool {
        self.corners.is_some() || self.disc.is_some()
    }

    /// Whether it may share an area with the part of its face between two corners in m, or with the whole face.
    pub(super) fn may_meet(&self, other: Option<[[f64; 3]; 2]>) -> bool {
        let around = |disc: Disc| {
            let corner = |sign: f64| disc.centre.map(|x| x + sign * disc.radius);
            [corner(-1.0), corner(1.0)]
        };
        let own = self.corners.or(self.disc.map(around));
        let (Some([low, high]), Some([from, to])) = (own, other) else {
            return true;
        };
        (0..3).all(|c| {
            let is_flat = low[c] == high[c] || from[c] == to[c];
            let common = high[c].min(to[c]) - low[c].max(from[c]);
            common > 0.0 || is_flat && common == 0.0
        })
    }
}

/// Gives tables with a face, a box and a disc the part that these make.
macro_rules! on_parts {
    ($($table:ident),+) => {
        $(impl $table {
            /// Where it acts.
            #[must_use]
            pub fn part(&self) -> FacePart<'_> {
                FacePart {
                    face: &self.face,
                    corners: self.corners,
                    disc: self.disc,
                }
            }
        })+
    };
}
on_parts!(Traction, Pressure, Force, Spring);

/// A load on a face, with its place among those of its kind.
#[derive(Debug, Clone, Copy)]
pub enum FaceLoad<'a> {
    /// A traction.
    Traction(usize, &'a Traction),
    /// A pressure.
    Pressure(usize, &'a Pressure),
    /// A total force.
    Force(usize, &'a Force),
}

impl<'a> FaceLoad<'a> {
    /// Its key in the scene, such as `traction.0`.
    #[must_use]
    pub fn key(&self) -> String {
        match self {
            Self::Traction(i, _) => format!("traction.{i}"),
            Self::Pressure(i, _) => format!("pressure.{i}"),
            Self::Force(i, _) => format!("force.{i}"),
        }
    }

    /// Where it acts.
    #[must_use]
    pub fn part(&self) -> FacePart<'a> {
        match self {
            Self::Traction(_, load) => load.part(),
            Self::Pressure(_, load) => load.part(),
            Self::Force(_, load) => load.part(),
        }
    }
}

impl Scene {
    /// The loads on faces: tractions, pressures, then total forces.
    pub fn face_loads(&self) -> impl Iterator<Item = FaceLoad<'_>> {
        let tractions = self.tractions.iter().enumerate();
        let pressures = self.pressures.iter().enumerate();
        let forces = self.forces.iter().enumerate();
        let tractions = tractions.map(|(i, load)| FaceLoad::Traction(i, load));
        let pressures = pressures.map(|(i, load)| FaceLoad::Pressure(i, load));
        tractions
            .chain(pressures)
            .chain(forces.map(|(i, load)| FaceLoad::Force(i, load)))
    }

    /// The parts of faces on which loads and springs act, with their keys.
    pub(crate) fn face_parts(&self) -> impl Iterator<Item = (String, FacePart<'_>)> {
        let springs = self.springs.iter().enumerate();
        let springs = springs.map(|(i, spring)| (format!("spring.{i}"), spring.part()));
        let loads = self.face_loads().map(|load| (load.key(), load.part()));
        loads.chain(springs)
    }
}

/// A force f per volume, such as weight.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyForce {
    /// The force vector f in N/m³: numbers, or expressions in x, y, z.
    #[schemars(extend("measures" = Measure::ForceDensity))]
    pub value: [Quantity; 3],
}

/// Springs between a face and points that do not move: σν = −K u with a stiffness K per area. Either `tensor` or at least
/// one of `normal` and `tangential` is given.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spring {
    /// The face on springs.
    pub face: String,
    /// Two opposite corners [min, max] in m: only the part of the face between them is on springs. Triangles that the box cuts
    /// count with what lies inside.
    #[serde(rename = "box", default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Length))]
    pub corners: Option<[[f64; 3]; 2]>,
    /// The disc on the face that is on springs, in place of a box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disc: Option<Disc>,
    /// Stiffness ≥ 0 along the normal in Pa/m: a number, or an expression in x, y, z; none when not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::SpringStiffness, "minimum" = 0))]
    pub normal: Option<Quantity>,
    /// Stiffness ≥ 0 along the face, the same in all its directions, in Pa/m: a number, or an expression in x, y, z; none when
    /// not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::SpringStiffness, "minimum" = 0))]
    pub tangential: Option<Quantity>,
    /// Symmetric positive semidefinite stiffness over the axes x, y, z in Pa/m: rows of numbers, or expressions in x, y, z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::SpringStiffness))]
    pub tensor: Option<[[Quantity; 3]; 3]>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_on_a_side_of_a_box_lies_in_it() {
        let clamp: Clamp =
            toml::from_str("box = [[0.3, 0.0, 0.0], [0.6, 0.0, 1.0]]").expect("a clamp");
        // The planes of ten equal cells.
        let [third, sixth] = [0.1, 0.2].map(|step: f64| step * 3.0);
        assert_ne!([third, sixth], [0.3, 0.6]);
        for (x, inside) in [
            (third, true),
            (sixth, true),
            (0.3 - 1e-9, false),
            (0.6 + 1e-9, false),
        ] {
            assert_eq!(clamp.holds(&[x, 0.0, 0.5]), inside, "{x}");
        }
    }
}
