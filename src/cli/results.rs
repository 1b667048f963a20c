//! The results of a run, as a table for people and as JSON for programs; no computing here.

use std::fmt::Write;

use contact3d::{
    dual::Assembly,
    elasticity::BodyMotion,
    mesh::Mesh,
    post::{ContactReport, ErrorEstimate, FaceResultants, Zone},
    scene::{ModelFeatures, Scene, shown},
    solver::{Solution, SolvedBy},
};
use units::Units;

use super::{features, report::status};
use crate::{
    format::Sizes,
    pipeline::Performed,
    views::{fold_words, motion_words, radius_words, sign_words},
};

/// Estimates above this share of the energy norm were down to 0.66 of the error on meshes of some hundred unknowns; below
/// it they were between 0.7 and 1.5 times the error (docs/accuracy.md).
const TRUSTED_ESTIMATE: f64 = 0.25;

/// With nine tenths of the squared estimate in flat tetrahedra it was three to four times the error (docs/accuracy.md).
const MOSTLY_FLAT: f64 = 0.5;

/// The numbers of unknowns of a solved problem.
fn sizes(mesh: &Mesh, solution: &Solution) -> Sizes {
    let contact = mesh.contact.as_ref();
    Sizes {
        n_free: Some(solution.displacement.len()),
        panes: contact.map(|surface| surface.faces.iter().map(|f| f.panes.len()).collect()),
        contact_nodes: contact.map(|surface| surface.faces.iter().map(|f| f.nodes.len()).collect()),
        n_rigid_modes: Some(solution.rigid_motion.len()).filter(|n| *n > 0),
    }
}

/// Steps of each algorithm that ran.
fn steps(solution: &Solution) -> String {
    let fallbacks = solution.newton.iter().filter(|step| step.fallback).count();
    let eased = solution.newton.iter().filter(|step| step.law_share < 1.0);
    let eased = match eased.count() {
        0 => String::new(),
        count => format!(", {count} on the way from an easier law"),
    };
    match (solution.newton.len(), solution.history.len()) {
        (0, 0) => "one solve".into(),
        (0, outer) => format!("{outer} outer"),
        (newton, 0) => format!("{newton} Newton, {fallbacks} of them safeguards{eased}"),
        (newton, 1) if solution.solved_by == SolvedBy::Minimisation => format!("{newton} Newton"),
        (newton, outer) => format!("{newton} Newton, given up, then {outer} outer"),
    }
}

/// The table printed after a run.
pub(super) fn table(
    scene: &Scene,
    mesh: &Mesh,
    solution: &Solution,
    report: &ContactReport,
) -> String {
    let mut text = String::new();
    let r = &report.resultants;
    let [ux, uy, uz] = r.largest_displacement;
    let units = scene.units;
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "  {name:<27} {value}");
    };
    line("status", status(solution, scene));
    line(
        "nodes, tetrahedra, panes",
        format!(
            "{}, {}, {}",
            mesh.coordinates.len(),
            mesh.tetrahedra.len(),
            report.panes.len()
        ),
    );
    line(
        "unknowns (primal, dual)",
        format!(
            "{}, {}",
            solution.displacement.len(),
            solution.multiplier.len()
        ),
    );
    line("steps", steps(solution));
    line("applications n_A", solution.applications.to_string());
    if let Some(change) = solution.mapping_change {
        line("moved by the mapping Psi", format!("{change:.1e}"));
    }
    if let Some(local) = &solution.local_mapping {
        line("spectral radius of Psi'", radius_words(local));
        if let Some(words) = sign_words(local) {
            line("sign of det R'", words.to_owned());
        }
        if let Some(words) = fold_words(local) {
            line("distance from a fold", words);
        }
    }
    if let Some(contact) = &r.contact {
        line(
            "panes open, stick, slip",
            format!(
                "{}, {}, {}",
                report.count(Zone::Open),
                report.count(Zone::Stick),
                report.count(Zone::Slip)
            ),
        );
        line(
            "normal contact force",
            format!("{:.9e} {}", contact.normal_force, units.force()),
        );
        if let Some([along_1, along_2]) = contact.tangential_force {
            line(
                "tangential contact force",
                format!(
                    "{along_1:.6e}, {along_2:.6e} {} (multipliers, along t1, t2)",
                    units.force()
                ),
            );
        }
        line(
            "largest pressure",
            format!("{:.9e} {}", contact.largest_pressure, units.stress()),
        );
    }
    for (face, has) in report.faces.iter().zip(ModelFeatures::of(scene).contact) {
        line(&format!("on {}", shown(&has.name)), face_words(face, units));
    }
    if let Some([f1, f2]) = friction_ranges(report) {
        line(
            "friction on panes",
            format!(
                "F1 {:.4} to {:.4}, F2 {:.4} to {:.4}",
                f1[0], f1[1], f2[0], f2[1]
            ),
        );
    }
    if let Some((name, words)) = motion_words(units, mesh, solution, report) {
        line(name, words);
    }
    for row in &report.forces {
        let [x, y, z] = row.force;
        line(
            &format!("force of {}", row.source),
            format!("{x:.6e}, {y:.6e}, {z:.6e} {}", units.force()),
        );
    }
    line(
        "strain energy",
        format!("{:.9e} {}", r.strain_energy, units.energy()),
    );
    line(
        "largest displacement",
        format!("{ux:.6e}, {uy:.6e}, {uz:.6e} {}", units.length()),
    );
    line(
        "force, moment imbalance",
        format!("{:.1e}, {:.1e}", r.force_imbalance, r.moment_imbalance),
    );
    line(
        "discretisation error",
        estimate_words(&report.discretisation_error, mesh),
    );
    for (name, value) in report.certificate.figures() {
        line(&format!("certificate {name}"), format!("{value:.1e}"));
    }
    let features = features::lines(&ModelFeatures::of(scene), &sizes(mesh, solution));
    format!(
        "{}\nmodel features\n{features}results\n{text}",
        scene.shown_title()
    )
}

/// The estimate, and why it may be no more than a guess.
fn estimate_words(estimate: &ErrorEstimate, mesh: &Mesh) -> String {
    let error = estimate.relative();
    let flat = estimate.share_of_flat(mesh);
    let caution = match flat.filter(|share| *share > MOSTLY_FLAT) {
        Some(share) => format!(
            ", likely too much: {} of its square is in flat tetrahedra",
            percent(share)
        ),
        None if error > TRUSTED_ESTIMATE => ", a rough guess: the mesh is coarse".to_owned(),
        None => String::new(),
    };
    format!("about {} in the energy norm{caution}", percent(error))
}

/// What happens on one of several contact faces.
fn face_words(face: &FaceResultants, units: Units) -> String {
    let [open, stick, slip] = face.zone_counts;
    let tangential = match face.contact.tangential_force {
        Some([along_1, along_2]) => format!(", tangential {along_1:.6e}, {along_2:.6e}"),
        None => String::new(),
    };
    format!(
        "open, stick, slip {open}, {stick}, {slip}; normal {:.9e}{tangential} {}",
        face.contact.normal_force,
        units.force()
    )
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

/// A share in percent with two digits.
pub(super) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        10.0.. => format!("{percent:.0} %"),
        1.0..10.0 => format!("{percent:.1} %"),
        _ => format!("{percent:.1e} %"),
    }
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

/// Smallest and largest F₁ and F₂ over the panes; `None` where none was evaluated.
fn friction_ranges(report: &ContactReport) -> Option<[[f64; 2]; 2]> {
    let coefficients = || {
        let panes = report.panes.iter();
        panes.filter_map(|pane| Some(pane.friction?.coulomb?.coefficients))
    };
    coefficients().next()?;
    Some([0, 1].map(|i| {
        coefficients().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], f| {
            [low.min(f[i]), high.max(f[i])]
        })
    }))
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
    let motion = BodyMotion::fitted(&mesh.coordinates, displacement);
    serde_json::json!({
        "translation": motion.translation,
        "rotation": motion.rotation,
        "point": motion.point,
    })
}

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
        "discretisation_error": relative_parts(report),
        "certificate": certificate,
        "motion": (!solution.rigid_motion.is_empty()).then(|| motion_json(mesh, &report.displacement)),
        "unstopped_motion": solution.unstopped_motion.as_ref().map(|motion| motion_json(mesh, motion)),
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
