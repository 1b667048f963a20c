//! The words and tables that people read; no computing here.

use std::fmt::Write;

use crate::{
    dual::{AssemblySeconds, OperatorEstimate},
    mesh::Mesh,
    post::{ContactReport, Zone},
    scene::Scene,
    solver::{Progress, Solution, SolvedBy, Status},
    stages::Performed,
};

/// One line per stage done.
pub(super) fn stage_line(performed: &Performed) -> String {
    let stage = performed.stage.group();
    let computed = format!("{stage:<9} done in {:.3} s", performed.compute_seconds);
    match performed.store_seconds {
        0.0 => format!("{computed}, stored with the next stage"),
        seconds => format!("{computed}, stored in {seconds:.3} s"),
    }
}

/// How the dual operator is held, and what either form costs.
pub(super) fn operator_line(estimate: &OperatorEstimate, dense: bool) -> String {
    format!(
        "{:<9} {} (dense: {:.1} MB and {:.2e} operations to form; factor: {:.1} MB, {:.2e} operations an action)",
        "dual",
        if dense { "explicit" } else { "implicit" },
        estimate.explicit_bytes / 1e6,
        estimate.explicit_operations,
        estimate.factor_bytes / 1e6,
        estimate.action_operations,
    )
}

/// Progress of a solve.
pub(super) fn progress(progress: Progress<'_>) -> String {
    match progress {
        Progress::Outer(k, step) => {
            format!(
                "outer step {}, change {:.1e}, {} actions",
                k + 1,
                step.change,
                step.actions
            )
        }
        Progress::Newton(k, step) => {
            let how = if step.fallback { "safeguard" } else { "Newton" };
            format!("{how} step {}, residual {:.1e}", k + 1, step.residual)
        }
        Progress::Between(_) => String::new(),
    }
}

/// What a status means to a person.
pub(super) fn status(solution: &Solution) -> String {
    let accuracy = solution.accuracy;
    match solution.status {
        Status::Converged => format!("converged to {accuracy:.1e}"),
        Status::RoundingLimit => {
            format!("stopped at the attainable accuracy {accuracy:.1e}: rounding forbids more")
        }
        Status::MaxOuterSteps => {
            "NOT CONVERGED: out of outer steps; raise max_outer_steps or epsilon".into()
        }
        Status::MaxInnerActions => {
            "NOT CONVERGED: an inner problem ran out of actions; raise max_inner_actions or epsilon"
                .into()
        }
        Status::NumericalError => {
            "NOT CONVERGED: a value is not finite; check loads and material".into()
        }
        Status::MaxNewtonSteps => {
            "NOT CONVERGED: Newton's method gave up; choose method auto or fixed-point".into()
        }
    }
}

/// The status as programs see it.
pub(super) fn status_word(status: Status) -> &'static str {
    match status {
        Status::Converged => "converged",
        Status::MaxOuterSteps => "max_outer_steps",
        Status::MaxInnerActions => "max_inner_actions",
        Status::NumericalError => "numerical_error",
        Status::RoundingLimit => "rounding_limit",
        Status::MaxNewtonSteps => "max_newton_steps",
    }
}

/// Steps of each algorithm that ran.
fn steps(solution: &Solution) -> String {
    let fallbacks = solution.newton.iter().filter(|step| step.fallback).count();
    match (solution.newton.len(), solution.history.len()) {
        (0, 0) => "one solve".into(),
        (0, outer) => format!("{outer} outer"),
        (newton, 0) => format!("{newton} Newton, {fallbacks} of them safeguards"),
        (newton, 1) if solution.solved_by == SolvedBy::Minimisation => format!("{newton} Newton"),
        (newton, outer) => format!("{newton} Newton, given up, then {outer} outer"),
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
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "  {name:<26} {value}");
    };
    line("status", status(solution));
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
    line("actions n_A", solution.actions.to_string());
    if let Some(change) = solution.mapping_change {
        line("moved by the mapping Psi", format!("{change:.1e}"));
    }
    if let Some(contact) = &r.contact {
        line(
            "panes open, slip, stick",
            format!(
                "{}, {}, {}",
                report.count(Zone::Open),
                report.count(Zone::Slip),
                report.count(Zone::Stick)
            ),
        );
        line(
            "normal contact force",
            format!("{:.9e} N", contact.normal_force),
        );
        if let Some([along_1, along_2]) = contact.tangential_force {
            line(
                "tangential contact force",
                format!("{along_1:.6e}, {along_2:.6e} N (multipliers, along t1, t2)"),
            );
        }
        line(
            "largest pressure",
            format!("{:.9e} Pa", contact.largest_pressure),
        );
    }
    if report.friction.is_some() {
        let [f1, f2] = friction_ranges(report);
        line(
            "friction on panes",
            format!(
                "F1 {:.4} to {:.4}, F2 {:.4} to {:.4}",
                f1[0], f1[1], f2[0], f2[1]
            ),
        );
    }
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
    let coefficients = || {
        let panes = report.panes.iter();
        panes.filter_map(|pane| Some(pane.friction?.coulomb?.0))
    };
    [0, 1].map(|i| {
        coefficients().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], f| {
            [low.min(f[i]), high.max(f[i])]
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
    assembly_seconds: Option<AssemblySeconds>,
) -> serde_json::Value {
    let r = &report.resultants;
    let certificate: serde_json::Map<String, serde_json::Value> = report
        .certificate
        .figures()
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value.into()))
        .collect();
    let parts = assembly_seconds.map(|seconds| {
        let parts = seconds.parts().into_iter();
        parts
            .map(|(name, s)| (name.to_owned(), s.into()))
            .collect::<serde_json::Map<_, _>>()
    });
    serde_json::json!({
        "title": scene.title,
        "assembly_seconds": parts,
        "newton_seconds": solution.newton.iter().map(|step| step.seconds).sum::<f64>(),
        "status": status_word(solution.status),
        "n_nodes": mesh.coordinates.len(),
        "n_free": solution.displacement.len(),
        "n_multipliers": solution.multiplier.len(),
        "n_panes": report.panes.len(),
        "outer_steps": solution.history.len(),
        "newton_steps": solution.newton.len(),
        "actions": solution.actions,
        "accuracy": solution.accuracy,
        "mapping_change": solution.mapping_change,
        "open": report.count(Zone::Open),
        "slip": report.count(Zone::Slip),
        "stick": report.count(Zone::Stick),
        "normal_force": r.contact.map(|c| c.normal_force),
        "tangential_force": r.contact.and_then(|c| c.tangential_force),
        "largest_pressure": r.contact.map(|c| c.largest_pressure),
        "energy": r.strain_energy - r.load_work,
        "law_evaluations": solution.law_evaluations,
        "projections": solution.projections,
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
