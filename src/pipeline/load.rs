//! The stage `load`: the loads of the scene on the assembled problem.

use std::sync::Arc;

use contact3d::{
    dual::DualSystem,
    mesh::Mesh,
    scene::{BodyForce, Clamp, Parameters, Pressure, Quantity, Scene, SceneFile, Step, Traction},
};
use runfile::Reader;
use serde::Serialize;

use super::{
    StageError,
    assemble::of_operator,
    mesh::{of_obstacle, only_contact, several_contacts},
    solve::of_friction,
};
use crate::format;

/// What the stage depends on.
pub(super) struct Inputs<'a> {
    pub(super) input: &'a SceneFile,
    pub(super) mesh: &'a Mesh,
    /// The assembled problem, copied first if others hold it.
    pub(super) operator: Arc<DualSystem>,
}

/// Applies the loads, those of the last increment of a load history.
///
/// # Errors
/// A load that is not finite.
pub(super) fn run(inputs: Inputs<'_>) -> Result<DualSystem, StageError> {
    let input = inputs.input;
    let mut system = Arc::unwrap_or_clone(inputs.operator);
    let scene = input.scene.at_end();
    scene
        .and_then(|scene| system.apply_loads(&scene, inputs.mesh))
        .map_err(|invalid| input.refuse(invalid))?;
    Ok(system)
}

/// Reads the stored loads.
///
/// # Errors
/// Missing or altered datasets.
pub(super) fn read(reader: &Reader, operator: Arc<DualSystem>) -> Result<DualSystem, StageError> {
    let mut system = Arc::unwrap_or_clone(operator);
    format::read_loads(reader, &mut system)?;
    Ok(system)
}

/// The part of a scene that the stage depends on directly.
#[derive(Serialize)]
pub(super) struct Settings<'a> {
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

impl<'a> Settings<'a> {
    pub(super) fn of(scene: &'a Scene) -> Self {
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
