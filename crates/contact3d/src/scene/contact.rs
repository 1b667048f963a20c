//! A contact face, its initial gap, its axes, its friction and the space of its multipliers.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    Friction, Measure, Obstacle, ProblemPart, Quantity, Scene, entry_key, is_default,
    varying::varies,
};

/// A contact face, or a part of one, above a rigid half-space of its own or against a rigid obstacle.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// The face that may touch the foundation or the obstacle; it must be flat where there is no obstacle. Not given beside `between`.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub face: String,
    /// Two faces of different bodies that may touch each other. The contact stresses belong to the softer one, of the same softness to
    /// that with the finer mesh.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub between: Option<[String; 2]>,
    /// Whether the faces in `between` are bonded, as by glue or a weld: they move as one wherever they face each other, without any law of
    /// contact. The meshes need not match; the nodes of one face are moved onto the other and follow it.
    #[serde(default, skip_serializing_if = "is_default")]
    pub glued: bool,
    /// The one of the faces in `between` that the contact stresses belong to, in place of the softer one; of glued faces the one whose nodes
    /// follow the other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub panes_on: Option<String>,
    /// The rigid obstacle in the place of the foundation, which is the half-space behind the flat face.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub obstacle: Option<Obstacle>,
    /// The name of the `[[tool]]` that the obstacle, or the foundation without one, is part of and moves with; it rests when not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool: Option<String>,
    /// Where the normals and distances of the obstacle of a tool are taken in a load history; when not given at each increment of round
    /// obstacles, heights and surfaces whose tool is displaced sideways or turned, else where they begin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub follow: Option<Follow>,
    /// What results call this face; the name of the face when not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Two opposite corners [min, max] in m: only the triangles of the face between them are in contact. The sides of the box
    /// follow edges of triangles and, on a brick, of panes.
    #[serde(rename = "box", default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("measures" = Measure::Length))]
    pub corners: Option<[[f64; 3]; 2]>,
    /// Initial gap d ≥ 0 between body and foundation in m, or negative with `interference`: a number, or an expression in x, y, z. It adds to
    /// the distance from an obstacle.
    #[serde(default, skip_serializing_if = "is_default")]
    #[schemars(extend("part" = ProblemPart::Loads, "measures" = Measure::Displacement))]
    pub gap: Quantity,
    /// Whether what touches may overlap at first and is pressed apart, as a ring and the shaft that it is shrunk on.
    #[serde(default, skip_serializing_if = "is_default")]
    pub interference: bool,
    /// First principal axis t₁ of friction, a vector of any length in the plane of the face:
    /// numbers, or expressions in x, y, z. Where normals vary it is projected on the tangent plane of each contact node.
    /// When not given, the global x axis projected on the face (the y axis on a face perpendicular to x).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("part" = ProblemPart::Operator))]
    pub axis_1: Option<[Quantity; 3]>,
    /// Angle in degrees by which the default t₁ is turned towards t₂ = t₁ × ν, with ν the outward
    /// normal: counterclockwise seen from inside the body, on z_min from x towards y. A number, or
    /// an expression in x, y, z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("part" = ProblemPart::Operator))]
    pub angle: Option<Quantity>,
    /// The space of the contact stresses.
    #[serde(default)]
    pub multipliers: MultiplierSpace,
    /// The law of friction on this face; that of the table `friction` when not given, and none without either.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("part" = ProblemPart::Law))]
    pub friction: Option<Friction>,
}

varies!(Contact: obstacle, gap, axis_1, angle, friction);

impl Contact {
    /// What results call this face.
    #[must_use]
    pub fn name(&self) -> String {
        let name = self.name.clone();
        name.unwrap_or_else(|| self.faces().join("-"))
    }

    /// The name of the body of its first face, where there are several bodies.
    #[must_use]
    pub fn first_body(&self) -> &str {
        let face = self.faces()[0];
        face.split_once('.').map_or(face, |(body, _)| body)
    }

    /// The face, or the two that may touch each other.
    #[must_use]
    pub fn faces(&self) -> Vec<&str> {
        match &self.between {
            Some(pair) => pair.each_ref().map(String::as_str).to_vec(),
            None => vec![&self.face],
        }
    }
}

/// Where the normals and distances of an obstacle are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Follow {
    /// Where the body and the tool begin, for slides that are short beside the obstacle's radius.
    Start,
    /// Where they are when an increment begins, for long slides: choose increments shorter than a twentieth of the radius.
    Increment,
}

/// The space L^H of the contact stresses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MultiplierSpace {
    /// Constant on panes, groups of triangles (FE2 of HKL §3).
    #[default]
    Panes,
    /// One value per contact node, with lumped integration (FE1 of HKL Remark 3.1): contact and
    /// friction hold for the forces and displacements of every node.
    Nodal,
}

impl Scene {
    /// The key of a contact face in messages: `contact`, or `contact.1` for the second of several.
    #[must_use]
    pub fn contact_key(&self, entry: usize) -> String {
        entry_key("contact", self.contacts.len(), entry)
    }

    /// The law of friction of a contact face with its key; `None` where it is frictionless or glued.
    #[must_use]
    pub fn friction_on(&self, entry: usize) -> Option<(String, &Friction)> {
        let contact = self.contacts.get(entry).filter(|contact| !contact.glued)?;
        match (contact.friction.as_ref(), &self.friction) {
            (Some(own), _) => Some((format!("{}.friction", self.contact_key(entry)), own)),
            (None, Some(common)) => Some(("friction".to_owned(), common)),
            (None, None) => None,
        }
    }

    /// The tables that hold laws of friction, with their keys.
    pub(super) fn friction_tables(&self) -> impl Iterator<Item = (String, &Friction)> {
        let contacts = self.contacts.iter().enumerate();
        let own = contacts.filter_map(|(entry, contact)| {
            let key = format!("{}.friction", self.contact_key(entry));
            Some((key, contact.friction.as_ref()?))
        });
        let common = self.friction.iter();
        own.chain(common.map(|friction| ("friction".to_owned(), friction)))
    }

    /// Whether any contact is between two bodies.
    #[must_use]
    pub fn bodies_touch(&self) -> bool {
        self.contacts
            .iter()
            .any(|contact| contact.between.is_some() && !contact.glued)
    }

    /// Whether any face may touch something: glued ones do not.
    #[must_use]
    pub fn has_contact(&self) -> bool {
        self.contacts.iter().any(|contact| !contact.glued)
    }

    /// Whether faces of two bodies touch each other or are glued.
    #[must_use]
    pub fn has_pairs(&self) -> bool {
        self.contacts
            .iter()
            .any(|contact| contact.between.is_some())
    }

    /// The pairs of glued faces with their numbers in the scene.
    pub fn glued_pairs(&self) -> impl Iterator<Item = (usize, &[String; 2])> {
        let contacts = self.contacts.iter().enumerate();
        let glued = contacts.filter(|(_, contact)| contact.glued);
        glued.filter_map(|(entry, contact)| Some((entry, contact.between.as_ref()?)))
    }

    /// Whether any contact face has friction.
    #[must_use]
    pub fn has_friction(&self) -> bool {
        (0..self.contacts.len()).any(|entry| self.friction_on(entry).is_some())
    }

    /// The contact faces in the order of their multipliers, as numbers in the scene's own order: those with friction come
    /// first; glued ones have none.
    #[must_use]
    pub fn contact_order(&self) -> Vec<usize> {
        let entries = (0..self.contacts.len()).filter(|entry| !self.contacts[*entry].glued);
        let (with, without): (Vec<usize>, Vec<usize>) =
            entries.partition(|entry| self.friction_on(*entry).is_some());
        [with, without].concat()
    }

    /// Whether any part of a face may touch a foundation.
    #[must_use]
    pub(crate) fn is_in_contact(&self, face: &str) -> bool {
        self.contacts
            .iter()
            .any(|contact| contact.faces().contains(&face))
    }
}
