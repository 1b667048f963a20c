//! What each stage depends on in the scene, as the TOML text that its input digest is of: what stales what.
//!
//! A key that is added to scenes must not show here while it has its default, or every older file goes stale.

use contact3d::mesh::{RefinedLevel, Refinement};
use contact3d::scene::{
    AssembleSettings, Body, BodyForce, Clamp, Contact, Friction, Functional, Material,
    ModelFeatures, MultiplierSpace, Obstacle, Parameters, Part, Pressure, ProblemPart, Quantity,
    Region, Scene, SlipInterpolation, SolveSettings, Spring, Step, Traction,
};
use serde::Serialize;

use crate::format::Stage;

/// What stages depend on beside the scene, by digests.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BesideScene<'a> {
    /// Of the cuts that lead from the first mesh to this one; `None` for the first.
    pub(super) refinement: Option<&'a str>,
    /// Of the multipliers that a solve starts from; `None` for λ = 0.
    pub(super) start: Option<&'a str>,
}

/// The digest of the multipliers that a solve starts from, `[n_multipliers]` in Pa; `None` for none, which stand for λ = 0.
pub(super) fn start_digest(multiplier: &[f64]) -> Option<String> {
    let bytes: Vec<u8> = multiplier.iter().flat_map(|v| v.to_le_bytes()).collect();
    (!bytes.is_empty()).then(|| blake3::hash(&bytes).to_hex().to_string())
}

/// The digest of the cuts that lead from the first mesh of a scene to another; `None` for the first.
pub(super) fn refinement_digest(refinement: &Refinement) -> Option<String> {
    if refinement.levels.is_empty() {
        return None;
    }
    let mut hasher = blake3::Hasher::new();
    for level in &refinement.levels {
        match level {
            RefinedLevel::Cuts(cuts) => {
                hasher.update(&(cuts.len() as u64).to_le_bytes());
                hasher.update(cuts);
            }
            RefinedLevel::Cells(cells) => {
                hasher.update(format!("cells {cells:?}").as_bytes());
            }
        }
    }
    Some(hasher.finalize().to_hex().to_string())
}

/// The part of a scene that a stage depends on directly, as TOML.
pub(super) fn settings(stage: Stage, scene: &Scene, chosen: BesideScene<'_>) -> String {
    let parts = Parts::of(scene, chosen);
    let text = match stage {
        Stage::Mesh => toml(&parts.mesh),
        Stage::Assemble => toml(&parts.operator),
        Stage::Load => toml(&parts.load),
        Stage::Solve => toml(&parts.solve),
        Stage::Post => toml(&parts.post),
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
    settings(stage, scene, BesideScene::default())
}

/// What tells two scenes apart whose assembled problems differ in more than their loads.
pub fn operator_settings(scene: &Scene) -> String {
    stage_settings(Stage::Mesh, scene) + &stage_settings(Stage::Assemble, scene)
}

fn toml(settings: &impl Serialize) -> String {
    toml::to_string(settings).expect("settings hold only TOML types")
}

/// What each stage depends on.
struct Parts<'a> {
    mesh: MeshPart<'a>,
    operator: OperatorPart<'a>,
    load: LoadPart<'a>,
    solve: SolvePart<'a>,
    post: PostPart<'a>,
}

impl<'a> Parts<'a> {
    fn of(scene: &'a Scene, chosen: BesideScene<'a>) -> Self {
        // Every key by name, so that a new one does not compile before it has a stage.
        let Scene {
            title: _,
            reference: _,
            units: _,
            parameters: _,
            body,
            material,
            regions,
            clamps,
            springs,
            tractions,
            pressures,
            body_force,
            contacts: _,
            friction: _,
            steps,
            assemble,
            solve,
            adapt,
        } = scene;
        let used = |part| scene.parameters_used(|of| of == part);
        let order = scene.contact_order().into_iter();
        let faces: Vec<FaceParts> = order.map(|entry| FaceParts::of(scene, entry)).collect();
        // The stages of a scene with one face are named as those of scenes always were.
        let (only, several) = match faces.as_slice() {
            [only] => (Some(only), [].as_slice()),
            several => (None, several),
        };
        let whole = only.is_some_and(|face| face.mesh.corners.is_none());
        let friction = only.and_then(|face| face.friction);
        let frictions: Vec<_> = several.iter().map(FaceParts::law).collect();
        let load = LoadPart {
            prescribed: if clamps.iter().any(Clamp::is_moved) {
                clamps.iter().map(|clamp| &clamp.value).collect()
            } else {
                Vec::new()
            },
            traction: tractions,
            pressure: pressures,
            body_force: body_force.as_ref(),
            gap: only.map(|face| face.gap),
            gaps: several.iter().map(|face| face.gap).collect(),
            step: steps,
            parameters: used(ProblemPart::Loads),
        };
        Self {
            mesh: MeshPart {
                body,
                refinement: chosen.refinement,
                clamp: clamps.iter().map(Clamp::at_zero).collect(),
                contact_face: only.map(|face| face.mesh.face),
                multipliers: only.map(|face| face.mesh.multipliers),
                obstacle: only.and_then(|face| face.mesh.obstacle),
                parts: regions.iter().map(|region| &region.part).collect(),
                contacts: if whole {
                    Vec::new()
                } else {
                    faces.iter().map(|face| face.mesh).collect()
                },
                parameters: used(ProblemPart::Mesh),
            },
            operator: OperatorPart {
                material,
                spring: springs,
                region: regions,
                axis_1: only.and_then(|face| face.axes.axis_1),
                angle: only.and_then(|face| face.axes.angle),
                friction: scene.has_friction(),
                friction_follows_slip: ModelFeatures::of(scene).follows_slip(),
                assemble,
                contacts: several.iter().map(|face| face.axes).collect(),
                parameters: used(ProblemPart::Operator),
            },
            solve: SolvePart {
                start: chosen.start,
                friction,
                frictions: frictions.clone(),
                slip_interpolation: faces
                    .first()
                    .map(|face| face.slip_interpolation)
                    .filter(|kind| *kind != SlipInterpolation::default()),
                solve,
                of: adapt.and_then(|adapt| adapt.of),
                history: scene.has_history().then(|| load.clone()),
                estimates: scene.has_history() && adapt.is_some(),
                parameters: used(ProblemPart::Law),
            },
            post: PostPart {
                friction,
                frictions,
                parameters: used(ProblemPart::Law),
            },
            load,
        }
    }
}

/// What stages depend on of one contact face.
struct FaceParts<'a> {
    mesh: FaceOfMesh<'a>,
    axes: AxesOfFace<'a>,
    gap: &'a Quantity,
    slip_interpolation: SlipInterpolation,
    friction: Option<&'a Friction>,
}

impl<'a> FaceParts<'a> {
    fn of(scene: &'a Scene, entry: usize) -> Self {
        let contact = &scene.contacts[entry];
        // Every key by name, as those of scenes.
        let Contact {
            face,
            obstacle,
            name: _,
            corners,
            gap,
            axis_1,
            angle,
            multipliers,
            slip_interpolation,
            friction: _,
        } = contact;
        let friction = scene.friction_on(entry).map(|(_, friction)| friction);
        Self {
            mesh: FaceOfMesh {
                name: contact.name(),
                face,
                corners: *corners,
                multipliers: *multipliers,
                obstacle: obstacle.as_ref(),
            },
            axes: AxesOfFace {
                axis_1: axis_1.as_ref(),
                angle: angle.as_ref(),
                friction: friction.is_some(),
            },
            gap,
            slip_interpolation: *slip_interpolation,
            friction,
        }
    }

    fn law(&self) -> FaceFriction<'a> {
        self.friction
            .map_or(FaceFriction::Frictionless {}, FaceFriction::Law)
    }
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
#[derive(Clone, Copy, Serialize)]
struct FaceOfMesh<'a> {
    name: &'a str,
    face: &'a str,
    #[serde(rename = "box")]
    corners: Option<[[f64; 3]; 2]>,
    multipliers: MultiplierSpace,
    #[serde(skip_serializing_if = "Option::is_none")]
    obstacle: Option<&'a Obstacle>,
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
#[derive(Clone, Copy, Serialize)]
struct AxesOfFace<'a> {
    axis_1: Option<&'a [Quantity; 3]>,
    angle: Option<&'a Quantity>,
    friction: bool,
}

/// What `load` depends on.
#[derive(Clone, Serialize)]
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
    /// The quantity that the mesh is refined for, whose error is estimated with the answer.
    #[serde(skip_serializing_if = "Option::is_none")]
    of: Option<Functional>,
    /// All loads of a load history, of which `/load` holds the last ones only.
    #[serde(skip_serializing_if = "Option::is_none")]
    history: Option<LoadPart<'a>>,
    /// Whether every increment of a load history is estimated, as one is whose scene asks for an error.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    estimates: bool,
    /// What the formulas here use.
    #[serde(skip_serializing_if = "Parameters::is_empty")]
    parameters: Parameters,
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

/// The law of one of several contact faces; an empty table without friction, since TOML has no null.
#[derive(Clone, Copy, Serialize)]
#[serde(untagged)]
enum FaceFriction<'a> {
    Law(&'a Friction),
    Frictionless {},
}
