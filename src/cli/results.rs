//! The results of a run as a table for people; no computing here.

use std::fmt::Write;

use contact3d::{
    mesh::Mesh,
    post::{ContactReport, ErrorEstimate, FaceResultants, Zone},
    scene::{ModelFeatures, Scene, shown},
    solver::{Solution, SolvedBy},
};
use units::Units;

use super::{features, report::status};
use crate::{
    format::Sizes,
    views::{ESTIMATE_OF_REST, fold_words, motion_words, neutral_words, radius_words, sign_words},
};

/// Estimates above this share of the energy norm were down to 0.66 of the error on meshes of some hundred unknowns; below
/// it they were between 0.7 and 1.5 times the error (docs/explanation/errors.md).
const TRUSTED_ESTIMATE: f64 = 0.25;

/// With nine tenths of the squared estimate in flat tetrahedra it was three to four times the error (docs/explanation/errors.md).
const MOSTLY_FLAT: f64 = 0.5;

/// The numbers of unknowns of a solved problem.
pub(super) fn sizes(mesh: &Mesh, solution: &Solution) -> Sizes {
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
    for (name, words) in neutral_words(units, mesh, solution) {
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
    if solution.has_answer() {
        line(
            "discretisation error",
            estimate_words(&report.discretisation_error, mesh),
        );
        for (name, value) in report.certificate.figures() {
            line(&format!("certificate {name}"), format!("{value:.1e}"));
        }
    }
    let features = features::lines(&ModelFeatures::of(scene), &sizes(mesh, solution));
    format!(
        "{}\nmodel features\n{features}results\n{text}",
        scene.shown_title()
    )
}

/// The estimate, and why it may be no more than a guess.
fn estimate_words(estimate: &ErrorEstimate, mesh: &Mesh) -> String {
    if estimate.displacement == 0.0 {
        return ESTIMATE_OF_REST.to_owned();
    }
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

/// A share in percent with two digits.
pub(super) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        10.0.. => format!("{percent:.0} %"),
        1.0..10.0 => format!("{percent:.1} %"),
        _ => format!("{percent:.1e} %"),
    }
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
