//! The stage `assemble`: matrices, factor and perhaps the dense dual operator, for any loads.

use std::sync::Arc;

use contact3d::{
    dual::{AssemblyError, DualSystem, Need, Shortage},
    linalg::Work,
    mesh::Mesh,
    scene::{
        AssembleSettings, Material, ModelFeatures, Parameters, Quantity, Region, Scene, SceneFile,
        Spring,
    },
};
use serde::Serialize;

use super::{
    StageError,
    mesh::{only_contact, several_contacts},
};

/// What the stage depends on.
pub(super) struct Inputs<'a> {
    pub(super) input: &'a SceneFile,
    pub(super) mesh: &'a Mesh,
    /// Decides whether a step may begin.
    pub(super) admit: &'a dyn Fn(Need) -> Result<(), Shortage>,
    /// Learns how far long steps are.
    pub(super) begun: &'a dyn Fn(&'static str, &Arc<Work>),
}

/// Assembles and factorises; the loads of the scene are applied, too.
///
/// # Errors
/// A stiffness that is not positive definite, a formula without a value, what `admit` refuses.
pub(super) fn run(inputs: &Inputs<'_>) -> Result<DualSystem, StageError> {
    let Inputs { input, mesh, .. } = inputs;
    let system = DualSystem::watched(&input.scene, mesh, inputs.admit, inputs.begun);
    system.map_err(|error| match error {
        AssemblyError::Scene(invalid) => input.refuse(invalid).into(),
        error => error.into(),
    })
}

/// The part of a scene that the stage depends on directly.
#[derive(Serialize)]
pub(super) struct Settings<'a> {
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
    contacts: Vec<FaceSettings<'a>>,
    /// What the formulas here use.
    #[serde(skip_serializing_if = "Parameters::is_empty")]
    parameters: Parameters,
}

/// What A⁻¹Bᵀ depends on of one of several contact faces.
#[derive(Serialize)]
struct FaceSettings<'a> {
    axis_1: Option<&'a [Quantity; 3]>,
    angle: Option<&'a Quantity>,
    friction: bool,
}

impl<'a> Settings<'a> {
    pub(super) fn of(scene: &'a Scene) -> Self {
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
                .map(|(entry, contact)| FaceSettings {
                    axis_1: contact.axis_1.as_ref(),
                    angle: contact.angle.as_ref(),
                    friction: scene.friction_on(entry).is_some(),
                })
                .collect(),
            parameters: scene.parameters_used(of_operator),
        }
    }
}

/// Whether a key is one of the axes of friction, which are part of T, or of springs, which are part of A.
pub(super) fn of_operator(key: &str) -> bool {
    let of_frame = key.ends_with(".axis_1") || key.ends_with(".angle");
    key.starts_with("contact.") && of_frame || key.starts_with("spring.")
}
