//! The words and tables that people read; no computing here.

use std::fmt::Write;

use crate::{
    mesh::Mesh,
    post::{ContactReport, Zone},
    scene::Scene,
    solver::{OuterStep, Solution, Status},
    stages::Performed,
};

/// One line per stage done.
pub(super) fn stage_line(performed: &Performed) -> String {
    format!(
        "{:<9} done in {:.3} s, stored in {:.3} s",
        performed.stage.group(),
        performed.compute_seconds,
        performed.store_seconds
    )
}

/// Progress of the outer loop.
pub(super) fn outer_step(k: usize, step: &OuterStep) -> String {
    format!(
        "outer step {}, change {:.1e}, {} actions",
        k + 1,
        step.change,
        step.actions
    )
}

/// What a status means to a person.
pub(super) fn status(status: Status) -> &'static str {
    match status {
        Status::Converged => "converged",
        Status::MaxOuterSteps => {
            "NOT CONVERGED: out of outer steps; raise max_outer_steps or epsilon"
        }
        Status::MaxInnerActions => {
            "NOT CONVERGED: an inner problem ran out of actions; raise max_inner_actions or epsilon"
        }
        Status::NumericalError => "NOT CONVERGED: a value is not finite; check loads and material",
    }
}

/// The status as programs see it.
pub(super) fn status_word(status: Status) -> &'static str {
    match status {
        Status::Converged => "converged",
        Status::MaxOuterSteps => "max_outer_steps",
        Status::MaxInnerActions => "max_inner_actions",
        Status::NumericalError => "numerical_error",
    }
}

/// The table printed after a run.
pub(super) fn results(
    scene: &Scene,
    mesh: &Mesh,
    solution: &Solution,
    report: &ContactReport,
) -> String {
    let mut text = String::new();
    let r = &report.resultants;
    let [ux, uy, uz] = r.largest_displacement;
    let [f1, f2] = friction_ranges(report);
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "  {name:<26} {value}");
    };
    line("status", status(solution.status).into());
    line(
        "nodes, tetrahedra, panes",
        format!(
            "{}, {}, {}",
            mesh.coordinates.len(),
            mesh.tetrahedra.len(),
            mesh.contact.n_panes()
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
    line(
        "outer steps, n_A",
        format!("{}, {}", solution.history.len(), solution.actions()),
    );
    line(
        "panes open, slip, stick",
        format!(
            "{}, {}, {}",
            report.count(Zone::Open),
            report.count(Zone::Slip),
            report.count(Zone::Stick)
        ),
    );
    line("normal contact force", format!("{:.9e} N", r.normal_force));
    line(
        "tangential contact force",
        format!(
            "{:.6e}, {:.6e} N (multipliers, along t1, t2)",
            r.tangential_force[0], r.tangential_force[1]
        ),
    );
    line("largest pressure", format!("{:.9e} Pa", r.largest_pressure));
    line(
        "friction on panes",
        format!(
            "F1 {:.4} to {:.4}, F2 {:.4} to {:.4}",
            f1[0], f1[1], f2[0], f2[1]
        ),
    );
    line("strain energy", format!("{:.9e} J", r.strain_energy));
    line(
        "largest displacement",
        format!("{ux:.6e}, {uy:.6e}, {uz:.6e} m"),
    );
    line(
        "force, moment imbalance",
        format!("{:.1e}, {:.1e}", r.force_imbalance, r.moment_imbalance),
    );
    for (name, value) in report.certificate.figures() {
        line(&format!("certificate {name}"), format!("{value:.1e}"));
    }
    format!("{}\n{text}", scene.title)
}

/// Smallest and largest F₁ and F₂ over the panes.
fn friction_ranges(report: &ContactReport) -> [[f64; 2]; 2] {
    [0, 1].map(|i| {
        report
            .panes
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], pane| {
                [low.min(pane.friction[i]), high.max(pane.friction[i])]
            })
    })
}

/// The results for programs.
pub(super) fn json(
    scene: &Scene,
    mesh: &Mesh,
    solution: &Solution,
    report: &ContactReport,
    performed: &[Performed],
) -> serde_json::Value {
    let r = &report.resultants;
    let certificate: serde_json::Map<String, serde_json::Value> = report
        .certificate
        .figures()
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value.into()))
        .collect();
    serde_json::json!({
        "title": scene.title,
        "status": status_word(solution.status),
        "n_nodes": mesh.coordinates.len(),
        "n_free": solution.displacement.len(),
        "n_multipliers": solution.multiplier.len(),
        "n_panes": mesh.contact.n_panes(),
        "outer_steps": solution.history.len(),
        "actions": solution.actions(),
        "open": report.count(Zone::Open),
        "slip": report.count(Zone::Slip),
        "stick": report.count(Zone::Stick),
        "normal_force": r.normal_force,
        "tangential_force": r.tangential_force,
        "largest_pressure": r.largest_pressure,
        "strain_energy": r.strain_energy,
        "largest_displacement": r.largest_displacement,
        "certificate": certificate,
        "stages": performed.iter().map(|p| serde_json::json!({
            "stage": p.stage.group(),
            "compute_seconds": p.compute_seconds,
            "store_seconds": p.store_seconds,
        })).collect::<Vec<_>>(),
    })
}
