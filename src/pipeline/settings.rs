//! What each stage depends on in the scene, as the TOML text that its input digest is of: what stales what.
//!
//! Every key of the scene says beside its field which part of the problem it belongs to.

use contact3d::mesh::RefinedLevel;
use contact3d::scene::{ProblemPart, Scene};
use toml::{Table, Value};

use crate::format::Stage;

/// The digest of the multipliers that a solve starts from, `[n_multipliers]` in Pa; `None` for none, which stand for λ = 0.
pub(super) fn start_digest(multiplier: &[f64]) -> Option<String> {
    let bytes: Vec<u8> = multiplier.iter().flat_map(|v| v.to_le_bytes()).collect();
    (!bytes.is_empty()).then(|| blake3::hash(&bytes).to_hex().to_string())
}

/// The digest of the cuts that lead from the first mesh of a scene to another; `None` for the first.
pub(super) fn refinement_digest(refinement: &[RefinedLevel]) -> Option<String> {
    if refinement.is_empty() {
        return None;
    }
    let mut hasher = blake3::Hasher::new();
    for level in refinement {
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

/// What a stage depends on directly, as TOML: in the scene, and beside it the digests of [`refinement_digest`] and [`start_digest`].
pub(super) fn settings(
    stage: Stage,
    scene: &Scene,
    refinement: Option<&str>,
    start: Option<&str>,
) -> String {
    let has_history = scene.has_history();
    let parts: &[ProblemPart] = match stage {
        Stage::Mesh => &[ProblemPart::Mesh],
        Stage::Assemble => &[ProblemPart::Operator],
        Stage::Load => &[ProblemPart::Loads],
        // Of the loads of a history `/load` holds the last ones only.
        Stage::Solve if has_history => &[ProblemPart::Law, ProblemPart::Solve, ProblemPart::Loads],
        Stage::Solve => &[ProblemPart::Law, ProblemPart::Solve],
        Stage::Post => &[ProblemPart::Law],
    };
    let mut beside = Table::new();
    let mut add = |key: &str, value: Option<Value>| {
        beside.extend(value.map(|value| (key.to_owned(), value)));
    };
    match stage {
        Stage::Mesh => {
            add("refinement", refinement.map(Into::into));
            // Where bodies touch or are glued, the side of panes or of nodes that follow, and normals, depend on the stiffness of both.
            let moduli = scene.materials().map(|(_, it)| it.contact_modulus());
            let has_pairs = scene.has_pairs();
            let moduli = has_pairs.then(|| moduli.collect::<Vec<_>>().into());
            add("moduli", moduli);
        }
        Stage::Assemble => {
            // T has rows for faces with friction, and H is made for laws that follow the slip.
            let faces = 0..scene.contacts.len();
            let with_friction: Vec<bool> = faces
                .map(|face| scene.friction_on(face).is_some())
                .collect();
            add("friction", Some(with_friction.into()));
            let follows_slip = scene.follows_slip();
            add("friction_follows_slip", Some(follows_slip.into()));
        }
        Stage::Solve => {
            add("start", start.map(Into::into));
            // Every increment of a history whose scene asks for an error is estimated.
            let estimates = has_history && scene.adapt.is_some();
            add("estimates", estimates.then(|| true.into()));
        }
        Stage::Load | Stage::Post => {}
    }
    let mut table = scene.part(parts);
    table.insert("beside".to_owned(), Value::Table(beside));
    table.to_string()
}

/// What a stage depends on in the scene directly, as TOML, for the body's own mesh and a solve that starts from λ = 0.
#[must_use]
pub fn stage_settings(stage: Stage, scene: &Scene) -> String {
    settings(stage, scene, None, None)
}

/// What tells two scenes apart whose assembled problems differ in more than their loads.
pub fn operator_settings(scene: &Scene) -> String {
    stage_settings(Stage::Mesh, scene) + &stage_settings(Stage::Assemble, scene)
}
