//! Tables and JSON of checks.

use std::fmt::Write;

use contact3d::{robustness::Check, solver::SolvedBy};
use units::Dimension;

use super::results_json::unit_words;
use crate::format::StabilityRow;

/// Headings of the columns.
const HEADINGS: [&str; 13] = [
    "case",
    "verdict",
    "status",
    "factor",
    "steps",
    "certificate",
    "(bound)",
    "cond A",
    "λmin/λmax S",
    "‖R'⁻¹‖",
    "disagree",
    "vary",
    "seconds",
];

/// The table for a terminal; findings below their case.
pub(super) fn table(rows: &[StabilityRow]) -> String {
    let mut text = line(&HEADINGS.map(str::to_owned));
    let mut family = "";
    for row in rows {
        if row.family != family {
            family = &row.family;
            let _ = writeln!(text, "{family}");
        }
        text += &line(&cells(row));
        for remark in remarks(row) {
            let _ = writeln!(text, "    {remark}");
        }
    }
    text
}

/// The table for a page.
pub(super) fn markdown(rows: &[StabilityRow]) -> String {
    let mut text = format!(
        "| {} |\n|{}\n",
        HEADINGS.join(" | "),
        "---|".repeat(HEADINGS.len())
    );
    for row in rows {
        let _ = writeln!(text, "| {} |", cells(row).join(" | "));
    }
    text += "\n";
    for row in rows {
        for remark in remarks(row) {
            let _ = writeln!(text, "* **{}**: {remark}", row.name);
        }
    }
    text
}

fn line(cells: &[String; 13]) -> String {
    const WIDTHS: [usize; 13] = [28, 8, 15, 6, 7, 12, 8, 8, 12, 8, 9, 8, 8];
    let mut text = String::new();
    for (cell, width) in cells.iter().zip(WIDTHS) {
        let _ = write!(text, "{cell:<width$} ");
    }
    text.trim_end().to_owned() + "\n"
}

fn cells(row: &StabilityRow) -> [String; 13] {
    let Ok(check) = &row.outcome else {
        let mut cells: [String; 13] = Default::default();
        cells[0].clone_from(&row.name);
        cells[1] = row.word().to_owned();
        return cells;
    };
    [
        row.name.clone(),
        row.word().to_owned(),
        check.status.word().replace('_', " "),
        check.precision.word().to_owned(),
        steps(check),
        short(check.certificate),
        short(check.rounding_bound.certificate),
        short(check.conditioning.stiffness),
        short(check.conditioning.dual.ratio()),
        format!(
            "{}{}",
            ["−", "0 ", "+"][(check.linearisation.determinant + 1) as usize],
            short(check.linearisation.sensitivity)
        ),
        short(check.disagreement()),
        check.variation().map_or("-".to_owned(), short),
        format!("{:.2}", check.seconds),
    ]
}

/// Newton steps, and outer steps of successive approximations where these were taken.
fn steps(check: &Check) -> String {
    match (check.solved_by, check.steps) {
        (SolvedBy::FixedPoint, [newton, outer]) => format!("{newton}+{outer}"),
        (_, [newton, _]) => newton.to_string(),
    }
}

fn short(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value:.0e}")
    }
}

fn remarks(row: &StabilityRow) -> Vec<String> {
    let mut remarks = Vec::new();
    if !row.findings().is_empty() {
        remarks.push(row.findings());
    }
    if !row.open.is_empty() {
        remarks.push(format!("open: {}", row.open));
    }
    remarks
}

/// Each case in full.
pub(super) fn details(rows: &[StabilityRow]) -> String {
    rows.iter().map(detail).collect()
}

fn detail(row: &StabilityRow) -> String {
    let check = match &row.outcome {
        Ok(check) => check,
        Err(reason) => return format!("{}: refused: {reason}\n", row.name),
    };
    let mut text = String::new();
    let mut say = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<34} {value}");
    };
    let c = &check.conditioning;
    say(
        "unknowns, multipliers",
        format!("{}, {}", check.n_free, check.n_multipliers),
    );
    say(
        "status",
        format!("{} to {:.1e}", check.status.word(), check.accuracy),
    );
    say(
        "panes open, sticking, slipping",
        check.zones.map(|count| count.to_string()).join(", "),
    );
    say("factor", format!("in {} precision", check.precision.word()));
    say("condition of A (scaled)", short(c.stiffness));
    say(
        "eigenvalues of S",
        format!(
            "{:.3e} to {:.3e} {}",
            c.dual.smallest,
            c.dual.largest,
            row.units.word(Dimension::DUAL)
        ),
    );
    say("  ratio", format!("{:.3e}", c.dual.ratio()));
    say(
        "  ratio, scaled by pane areas",
        format!("{:.3e}", c.dual_by_area.ratio()),
    );
    say(
        "Newton's matrix R'",
        format!(
            "det {}, inverse {:.1e}",
            ["< 0", "= 0", "> 0"][(check.linearisation.determinant + 1) as usize],
            check.linearisation.sensitivity
        ),
    );
    say(
        "contraction of the mapping Ψ",
        format!("{:.4}", check.linearisation.contraction),
    );
    say(
        "distance from a fold",
        format!("{:.4}", check.linearisation.fold_distance),
    );
    say(
        "certificate",
        format!(
            "{:.1e}, rounding allows {:.0e}",
            check.certificate, check.rounding_bound.certificate
        ),
    );
    for cross_check in &check.cross_checks {
        say(
            &cross_check.cross_check.to_string(),
            format!(
                "{}, {} steps, differs by {:.1e}",
                cross_check.status.word(),
                cross_check.steps,
                cross_check.disagreement
            ),
        );
    }
    for result in &check.invariances {
        say(
            &result.invariance.to_string(),
            format!("{:.1e}", result.difference),
        );
    }
    say(
        "rounding of λ",
        format!("{:.0e}", check.rounding_bound.multiplier),
    );
    say("verdict", check.verdict().to_string());
    text
}

/// All rows for programs.
pub(super) fn json(rows: &[StabilityRow]) -> serde_json::Value {
    let row = |row: &StabilityRow| {
        let check = row.outcome.as_ref().ok();
        serde_json::json!({
            "name": row.name,
            "units": unit_words(row.units),
            "family": row.family,
            "verdict": row.word(),
            "findings": row.findings(),
            "open": row.open,
            "result": check.map(|check| serde_json::json!({
                "unknowns": check.n_free,
                "multipliers": check.n_multipliers,
                "factor_precision": check.precision.word(),
                "status": check.status.word(),
                "steps": check.steps,
                "accuracy": check.accuracy,
                "certificate": check.certificate,
                "certificate_floor": check.rounding_bound.certificate,
                "stiffness_condition": check.conditioning.stiffness,
                "dual_ratio": check.conditioning.dual.ratio(),
                "dual_ratio_by_area": check.conditioning.dual_by_area.ratio(),
                "determinant_sign": check.linearisation.determinant,
                "sensitivity": check.linearisation.sensitivity,
                "spectral_radius": check.linearisation.contraction,
                "fold_distance": check.linearisation.fold_distance,
                "multiplier_floor": check.rounding_bound.multiplier,
                "rivals": check.cross_checks.iter().map(|cross_check| serde_json::json!({
                    "algorithm": cross_check.cross_check.to_string(),
                    "status": cross_check.status.word(),
                    "steps": cross_check.steps,
                    "disagreement": cross_check.disagreement,
                    "residual": cross_check.residual,
                })).collect::<Vec<_>>(),
                "variation": check.invariances.iter()
                    .map(|result| (result.invariance.word().to_owned(), result.difference.into()))
                    .collect::<serde_json::Map<String, serde_json::Value>>(),
                "seconds": check.seconds,
            })),
        })
    };
    rows.iter().map(row).collect()
}
