//! What each stage depends on in the scene, as the TOML text that its input digest is of: what stales what.
//!
//! A key that is added to scenes must not show here while it has its default, or every older file goes stale.

use contact3d::scene::{
    AssembleSettings, Body, BodyForce, Clamp, Contact, Friction, Material, ModelFeatures,
    MultiplierSpace, Obstacle, Parameters, Part, Pressure, Quantity, Region, Scene,
    SlipInterpolation, SolveSettings, Spring, Step, Traction,
};
use serde::Serialize;

use crate::format::Stage;

/// What stages depend on beside the scene, by digests.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Chosen<'a> {
    /// Of the cuts that lead from the first mesh to this one; `None` for the first.
    pub(super) refinement: Option<&'a str>,
    /// Of the multipliers that a solve starts from; `None` for λ = 0.
    pub(super) start: Option<&'a str>,
}

/// The part of a scene that a stage depends on directly, as TOML.
pub(super) fn settings(stage: Stage, scene: &Scene, chosen: Chosen<'_>) -> String {
    let text = match stage {
        Stage::Mesh => toml(&MeshPart::of(scene, chosen.refinement)),
        Stage::Assemble => toml(&OperatorPart::of(scene)),
        Stage::Load => toml(&LoadPart::of(scene)),
        Stage::Solve => toml(&SolvePart::of(scene, chosen.start)),
        Stage::Post => toml(&PostPart::of(scene)),
    };
    if scene.units.is_default() {
        // The stages of a scene that names no units keep the digests they had before units could be named.
        return text;
    }
    format!("{text}\n[units]\n{}", toml(&scene.units))
}

/// The part of a scene that a stage depends on directly, as TOML, for the body's own mesh and a solve that starts from λ = 0.
#[must_use]
pub fn stage_settings(stage: Stage, scene: &Scene) -> String {
    settings(stage, scene, Chosen::default())
}

/// What tells two scenes apart whose assembled problems differ in more than their loads.
#[must_use]
pub fn operator_settings(scene: &Scene) -> String {
    stage_settings(Stage::Mesh, scene) + &stage_settings(Stage::Assemble, scene)
}

fn toml(settings: &impl Serialize) -> String {
    toml::to_string(settings).expect("settings hold only TOML types")
}

/// What `mesh` depends on.
#[derive(Serialize)]
struct MeshPart<'a> {
    body: &'a Body,
    /// Digest of the refinement; none for the body's own mesh.
    refinement: Option<&'a str>,
    /// At zero: the mesh does not depend on the displacements of clamps.
    clamp: Vec<Clamp>,
    contact_face: Option<&'a str>,
    multipliers: Option<MultiplierSpace>,
    #[serde(skip_serializing_if = "Option::is_none")]
    obstacle: Option<&'a Obstacle>,
    parts: Vec<&'a Part>,
    /// The contact faces, where they are more than one whole face.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    contacts: Vec<FaceOfMesh<'a>>,
    /// What the formulas of obstacles use.
    #[serde(skip_serializing_if = "Parameters::is_empty")]
    parameters: Parameters,
}

/// What the mesh depends on of one of several contact faces, in the order of their multipliers.
#[derive(Serialize)]
struct FaceOfMesh<'a> {
    name: &'a str,
    face: &'a str,
    #[serde(rename = "box")]
    corners: Option<[[f64; 3]; 2]>,
    multipliers: MultiplierSpace,
    #[serde(skip_serializing_if = "Option::is_none")]
    obstacle: Option<&'a Obstacle>,
}

impl<'a> MeshPart<'a> {
    fn of(scene: &'a Scene, refinement: Option<&'a str>) -> Self {
        Self {
            body: &scene.body,
            refinement,
            clamp: scene.clamps.iter().map(Clamp::at_zero).collect(),
            contact_face: only_contact(scene).map(|c| c.face.as_str()),
            multipliers: only_contact(scene).map(|c| c.multipliers),
            obstacle: only_contact(scene).and_then(|c| c.obstacle.as_ref()),
            parts: scene.regions.iter().map(|region| &region.part).collect(),
            contacts: match only_contact(scene) {
                Some(contact) if contact.corners.is_none() => Vec::new(),
                _ => contacts_in_order(scene).map(FaceOfMesh::of).collect(),
            },
            parameters: scene.parameters_used(of_obstacle),
        }
    }
}

impl<'a> FaceOfMesh<'a> {
    fn of(contact: &'a Contact) -> Self {
        Self {
            name: contact.name(),
            face: &contact.face,
            corners: contact.corners,
            multipliers: contact.multipliers,
            obstacle: contact.obstacle.as_ref(),
        }
    }
}

/// The contact face of a scene with one, whose stages are named as those of scenes always were.
fn only_contact(scene: &Scene) -> Option<&Contact> {
    match scene.contacts.as_slice() {
        [only] => Some(only),
        _ => None,
    }
}

/// The contact faces of a scene with several, in the order of their multipliers; none for one.
fn several_contacts(scene: &Scene) -> impl Iterator<Item = (usize, &Contact)> {
    let order = match scene.contacts.len() {
        1 => Vec::new(),
        _ => scene.contact_order(),
    };
    order.into_iter().map(|i| (i, &scene.contacts[i]))
}

fn contacts_in_order(scene: &Scene) -> impl Iterator<Item = &Contact> {
    let order = scene.contact_order().into_iter();
    order.map(|i| &scene.contacts[i])
}

/// What `assemble` depends on.
#[derive(Serialize)]
struct OperatorPart<'a> {
    material: &'a Material,
    #[serde(skip_serializing_if = "<[Spring]>::is_empty")]
    spring: &'a [Spring],
    region: &'a [Region],
    axis_1: Option<&'a [Quantity; 3]>,
    angle: Option<&'a Quantity>,
    /// Whether T is assembled, and whether G is.
    friction: bool,
    friction_follows_slip: bool,
    assemble: &'a AssembleSettings,
    /// The axes of several contact faces, and whether T has rows for them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    contacts: Vec<AxesOfFace<'a>>,
    /// What the formulas here use.
    #[serde(skip_serializing_if = "Parameters::is_empty")]
    parameters: Parameters,
}

/// What A⁻¹Bᵀ depends on of one of several contact faces.
#[derive(Serialize)]
struct AxesOfFace<'a> {
    axis_1: Option<&'a [Quantity; 3]>,
    angle: Option<&'a Quantity>,
    friction: bool,
}

impl<'a> OperatorPart<'a> {
    fn of(scene: &'a Scene) -> Self {
        let contact = only_contact(scene);
        Self {
            material: &scene.material,
            spring: &scene.springs,
            region: &scene.regions,
            axis_1: contact.and_then(|c| c.axis_1.as_ref()),
            angle: contact.and_then(|c| c.angle.as_ref()),
            friction: scene.has_friction(),
            friction_follows_slip: ModelFeatures::of(scene).follows_slip(),
            assemble: &scene.assemble,
            contacts: several_contacts(scene)
                .map(|(entry, contact)| AxesOfFace {
                    axis_1: contact.axis_1.as_ref(),
                    angle: contact.angle.as_ref(),
                    friction: scene.friction_on(entry).is_some(),
                })
                .collect(),
            parameters: scene.parameters_used(of_operator),
        }
    }
}

/// What `load` depends on.
#[derive(Serialize)]
struct LoadPart<'a> {
    /// The displacements of all clamps, where one of them is not held at zero.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    prescribed: Vec<&'a [Quantity; 3]>,
    traction: &'a [Traction],
    pressure: &'a [Pressure],
    body_force: Option<&'a BodyForce>,
    gap: Option<&'a Quantity>,
    /// The gaps of several contact faces.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    gaps: Vec<&'a Quantity>,
    #[serde(skip_serializing_if = "<[Step]>::is_empty")]
    step: &'a [Step],
    /// What the formulas here use.
    #[serde(skip_serializing_if = "Parameters::is_empty")]
    parameters: Parameters,
}

impl<'a> LoadPart<'a> {
    fn of(scene: &'a Scene) -> Self {
        Self {
            prescribed: if scene.clamps.iter().any(Clamp::is_moved) {
                scene.clamps.iter().map(|clamp| &clamp.value).collect()
            } else {
                Vec::new()
            },
            traction: &scene.tractions,
            pressure: &scene.pressures,
            body_force: scene.body_force.as_ref(),
            gap: only_contact(scene).map(|c| &c.gap),
            gaps: several_contacts(scene).map(|(_, c)| &c.gap).collect(),
            step: &scene.steps,
            parameters: scene
                .parameters_used(|key| !of_operator(key) && !of_friction(key) && !of_obstacle(key)),
        }
    }
}

/// What `solve` depends on.
#[derive(Serialize)]
struct SolvePart<'a> {
    /// Digest of the multipliers the solve started from; none for λ = 0.
    start: Option<&'a str>,
    friction: Option<&'a Friction>,
    /// The laws of several contact faces.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    frictions: Vec<FaceFriction<'a>>,
    /// None for the default.
    #[serde(skip_serializing_if = "Option::is_none")]
    slip_interpolation: Option<SlipInterpolation>,
    solve: &'a SolveSettings,
    /// All loads of a load history, of which `/load` holds the last ones only.
    #[serde(skip_serializing_if = "Option::is_none")]
    history: Option<LoadPart<'a>>,
    /// What the formulas here use.
    #[serde(skip_serializing_if = "Parameters::is_empty")]
    parameters: Parameters,
}

impl<'a> SolvePart<'a> {
    fn of(scene: &'a Scene, start: Option<&'a str>) -> Self {
        Self {
            start,
            friction: only_friction(scene),
            frictions: several_frictions(scene),
            slip_interpolation: scene
                .contacts
                .first()
                .map(|contact| contact.slip_interpolation)
                .filter(|kind| *kind != SlipInterpolation::default()),
            solve: &scene.solve,
            history: scene.has_history().then(|| LoadPart::of(scene)),
            parameters: scene.parameters_used(of_friction),
        }
    }
}

/// The law of the only contact face; `None` where there are several.
fn only_friction(scene: &Scene) -> Option<&Friction> {
    only_contact(scene)?;
    scene.friction_on(0).map(|(_, friction)| friction)
}

/// The law of one of several contact faces; an empty table without friction, since TOML has no null.
#[derive(Serialize)]
#[serde(untagged)]
enum FaceFriction<'a> {
    Law(&'a Friction),
    Frictionless {},
}

/// The laws of several contact faces, in the order of their multipliers; none for one.
fn several_frictions(scene: &Scene) -> Vec<FaceFriction<'_>> {
    let law = |entry| match scene.friction_on(entry) {
        Some((_, friction)) => FaceFriction::Law(friction),
        None => FaceFriction::Frictionless {},
    };
    several_contacts(scene)
        .map(|(entry, _)| law(entry))
        .collect()
}

/// What `post` depends on.
#[derive(Serialize)]
struct PostPart<'a> {
    friction: Option<&'a Friction>,
    /// The laws of several contact faces.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    frictions: Vec<FaceFriction<'a>>,
    /// What the formulas here use.
    #[serde(skip_serializing_if = "Parameters::is_empty")]
    parameters: Parameters,
}

impl<'a> PostPart<'a> {
    fn of(scene: &'a Scene) -> Self {
        Self {
            friction: only_friction(scene),
            frictions: several_frictions(scene),
            parameters: scene.parameters_used(of_friction),
        }
    }
}

/// Whether a key is one of an obstacle, whose normals and distances are part of the mesh.
fn of_obstacle(key: &str) -> bool {
    key.starts_with("contact.") && key.contains(".obstacle.")
}

/// Whether a key is one of the axes of friction, which are part of T, or of springs, which are part of A.
fn of_operator(key: &str) -> bool {
    let of_frame = key.ends_with(".axis_1") || key.ends_with(".angle");
    key.starts_with("contact.") && of_frame || key.starts_with("spring.")
}

/// Whether a key is part of a law of friction.
fn of_friction(key: &str) -> bool {
    key.starts_with("friction.") || key.starts_with("contact.") && key.contains(".friction.")
}
