//! The results of a run as JSON for programs; no computing here.

use contact3d::{
    dual::Assembly,
    elasticity::BodyMotion,
    mesh::Mesh,
    post::{ContactReport, Zone},
    scene::{ModelFeatures, Scene},
    solver::Solution,
};
use units::Units;

use super::{features, results::sizes};
use crate::{pipeline::Performed, views::neutral_motions};

/// The results for programs.
pub(super) fn json(
    scene: &Scene,
    mesh: &Mesh,
    solution: &Solution,
    report: &ContactReport,
    performed: &[Performed],
    assembly: Option<serde_json::Value>,
) -> serde_json::Value {
    let r = &report.resultants;
    let certificate: serde_json::Map<String, serde_json::Value> = report
        .certificate
        .figures()
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value.into()))
        .collect();
    let figures = serde_json::json!({
        "title": scene.title,
        "units": unit_words(scene.units),
        "effects": features::json(&ModelFeatures::of(scene), &sizes(mesh, solution)),
        "assembly_seconds": assembly.as_ref().map(|assembly| &assembly["seconds"]),
        "factor": assembly.as_ref().map(|assembly| &assembly["factor"]),
        "n_panes": report.panes.len(),
        "open": report.count(Zone::Open),
        "stick": report.count(Zone::Stick),
        "slip": report.count(Zone::Slip),
        "normal_force": r.contact.map(|c| c.normal_force),
        "tangential_force": r.contact.and_then(|c| c.tangential_force),
        "largest_pressure": r.contact.map(|c| c.largest_pressure),
        "forces": forces_json(report),
        "energy": r.strain_energy - r.load_work,
        "strain_energy": r.strain_energy,
        "largest_displacement": r.largest_displacement,
        "discretisation_error": solution.has_answer().then(|| relative_parts(report)),
        "certificate": solution.has_answer().then_some(certificate),
        "motion": (!solution.rigid_motion.is_empty()).then(|| motion_json(mesh, &report.displacement)),
        "unstopped_motion": solution.unstopped_motion.as_ref().map(|motion| motion_json(mesh, motion)),
        "neutral_motions": (!solution.rigid_motion.is_empty()).then(|| {
            let motions = neutral_motions(mesh, solution);
            motions.iter().map(rigid_json).collect::<Vec<_>>()
        }),
        "faces": faces_json(scene, report),
        "stages": performed.iter().map(|p| serde_json::json!({
            "stage": p.stage.word(),
            "compute_seconds": p.compute_seconds,
            "store_seconds": p.store_seconds,
        })).collect::<Vec<_>>(),
    });
    joined([figures, solving_json(mesh, solution)])
}

/// How the solve went, and what surrounds its answer.
fn solving_json(mesh: &Mesh, solution: &Solution) -> serde_json::Value {
    serde_json::json!({
        "newton_seconds": solution.newton.iter().map(|step| step.seconds).sum::<f64>(),
        "status": solution.status.word(),
        "n_nodes": mesh.coordinates.len(),
        "n_free": solution.displacement.len(),
        "n_multipliers": solution.multiplier.len(),
        "n_contact_nodes": mesh.contact.as_ref().map(|surface| surface.nodes.len()),
        "outer_steps": solution.history.len(),
        "newton_steps": solution.newton.len(),
        "actions": solution.applications,
        "accuracy": solution.accuracy,
        "mapping_change": solution.mapping_change,
        "spectral_radius": solution.local_mapping.map(|local| local.spectral_radius),
        "determinant_sign": solution.local_mapping.map(|local| local.determinant),
        "fold_distance": solution.local_mapping.map(|local| local.fold_distance),
        "law_evaluations": solution.law_evaluations,
        "projections": solution.projections,
    })
}

/// The figures of two objects in one.
fn joined(objects: [serde_json::Value; 2]) -> serde_json::Value {
    let figures = objects.iter().filter_map(serde_json::Value::as_object);
    let figures = figures.flatten();
    figures
        .map(|(name, value)| (name.clone(), value.clone()))
        .collect()
}

/// What happens on each of several contact faces, for programs.
fn faces_json(scene: &Scene, report: &ContactReport) -> Option<serde_json::Value> {
    let features = ModelFeatures::of(scene).contact;
    let faces = report.faces.iter().zip(features).map(|(face, has)| {
        let [open, stick, slip] = face.zone_counts;
        serde_json::json!({
            "name": has.name,
            "law": has.friction.word(),
            "open": open,
            "stick": stick,
            "slip": slip,
            "normal_force": face.contact.normal_force,
            "tangential_force": face.contact.tangential_force,
            "contact_force": face.contact.contact_force,
            "largest_pressure": face.contact.largest_pressure,
        })
    });
    let faces: Vec<_> = faces.collect();
    (!faces.is_empty()).then(|| faces.into())
}

/// The estimated discretisation error and its parts; figures of a body at rest are `null`.
fn relative_parts(report: &ContactReport) -> serde_json::Value {
    let parts = report.discretisation_error.relative_parts().into_iter();
    let finite = |value: f64| value.is_finite().then_some(value);
    parts
        .map(|(name, value)| (name.to_owned(), serde_json::Value::from(finite(value))))
        .collect()
}

/// The forces on the body by their sources.
fn forces_json(report: &ContactReport) -> Vec<serde_json::Value> {
    let rows = report.forces.iter();
    rows.map(|row| {
        serde_json::json!({
            "source": row.source,
            "face": row.face,
            "force": row.force,
            "moment": row.moment,
        })
    })
    .collect()
}

/// What the parts of an assembly took, and the factor: its precision, its coefficients, and the operations that made it.
pub(super) fn assembly_json(assembly: &Assembly) -> serde_json::Value {
    let parts = assembly.seconds.parts().into_iter();
    let seconds: serde_json::Map<String, serde_json::Value> =
        parts.map(|(name, s)| (name.to_owned(), s.into())).collect();
    let structure = assembly.factor.structure();
    serde_json::json!({
        "seconds": seconds,
        "factor": {
            "precision": assembly.factor.precision().word(),
            "coefficients": structure.value_count(),
            "operations": structure.operations(),
        },
    })
}

/// A rigid motion: translation of a point, rotation vector, the point.
fn motion_json(mesh: &Mesh, displacement: &[[f64; 3]]) -> serde_json::Value {
    rigid_json(&BodyMotion::fitted(&mesh.coordinates, displacement))
}

fn rigid_json(motion: &BodyMotion) -> serde_json::Value {
    serde_json::json!({
        "translation": motion.translation,
        "rotation": motion.rotation,
        "point": motion.point,
    })
}

/// The units of results, for programs.
pub(super) fn unit_words(units: Units) -> serde_json::Value {
    serde_json::json!({
        "length": units.length(),
        "force": units.force(),
        "stress": units.stress(),
        "energy": units.energy(),
    })
}
