//! Checks of hard cases.

use std::fmt::Write;

use contact3d::solver::SolvedBy;
use serde_json::{Map, Value};
use studies::stability::Check;
use units::{Dimension, Units};

use super::{
    Digits::{Fixed, Scientific},
    FigureTable, Figures, unit_words,
};
use crate::format::StabilityRow;

/// The table for a terminal; findings below their case.
pub fn table(rows: &[StabilityRow]) -> String {
    let mut lines = all(rows).lines().into_iter();
    let mut text = lines.next().unwrap_or_default();
    let mut family = "";
    for (row, line) in rows.iter().zip(lines) {
        if row.family != family {
            family = &row.family;
            let _ = writeln!(text, "{family}");
        }
        text += &line;
        for remark in remarks(row) {
            let _ = writeln!(text, "    {remark}");
        }
    }
    text
}

/// The table for a page.
pub fn markdown(rows: &[StabilityRow]) -> String {
    let mut text = all(rows).markdown() + "\n";
    for row in rows {
        for remark in remarks(row) {
            let _ = writeln!(text, "* **{}**: {remark}", row.name);
        }
    }
    text
}

fn all(rows: &[StabilityRow]) -> FigureTable {
    FigureTable::new("", rows.iter().map(short_row))
}

/// The figures of a case that tell it from others; `-` for those of a refused one.
#[rustfmt::skip]
fn short_row(row: &StabilityRow) -> Figures {
    let check = row.outcome.as_ref().ok();
    let mut figures = Figures::new(row.units);
    let mut say = |name: &str, of: &dyn Fn(&Check) -> String| figures.human_only(name, check.map(of));
    say("status", &|c| c.status.word().replace('_', " "));
    say("factor", &|c| c.precision.word().to_owned());
    say("steps", &steps);
    say("certificate", &|c| short(c.certificate));
    say("(bound)", &|c| short(c.rounding_bound.certificate));
    say("cond A", &|c| short(c.conditioning.stiffness));
    say("λmin/λmax S", &|c| short(c.conditioning.dual.ratio()));
    say("‖R'⁻¹‖", &|c| sign(c, ["−", "0 ", "+"]) + &short(c.linearisation.sensitivity));
    say("disagree", &|c| short(c.disagreement()));
    say("vary", &|c| c.variation().map_or("-".to_owned(), short));
    say("seconds", &|c| format!("{:.2}", c.seconds));
    let mut named = Figures::new(row.units);
    named.plain("", "case", row.name.as_str());
    named.plain("", "verdict", row.word());
    named.with(figures)
}

/// Newton steps, and outer steps of successive approximations where these were taken.
fn steps(check: &Check) -> String {
    match (check.solved_by, check.steps) {
        (SolvedBy::FixedPoint, [newton, outer]) => format!("{newton}+{outer}"),
        (_, [newton, _]) => newton.to_string(),
    }
}

/// A word for each sign of det R'.
fn sign(check: &Check, words: [&str; 3]) -> String {
    words[(check.linearisation.determinant_sign + 1) as usize].to_owned()
}

fn short(value: f64) -> String {
    if value == 0.0 {
        "0".to_owned()
    } else {
        format!("{value:.0e}")
    }
}

fn remarks(row: &StabilityRow) -> Vec<String> {
    let open = (!row.open.is_empty()).then(|| format!("open: {}", row.open));
    let findings = Some(row.findings()).filter(|findings| !findings.is_empty());
    findings.into_iter().chain(open).collect()
}

/// Each case in full.
pub fn details(rows: &[StabilityRow]) -> String {
    let detail = |row: &StabilityRow| match &row.outcome {
        // Width of names in the details of a case.
        Ok(check) => figures(check, row.units).text(0, 34),
        Err(reason) => format!("{}: refused: {reason}\n", row.name),
    };
    rows.iter().map(detail).collect()
}

/// All rows for programs.
pub fn json(rows: &[StabilityRow]) -> Value {
    let row = |row: &StabilityRow| {
        let check = row.outcome.as_ref().ok();
        serde_json::json!({
            "name": row.name,
            "units": unit_words(row.units),
            "family": row.family,
            "verdict": row.word(),
            "findings": row.findings(),
            "open": row.open,
            "result": check.map(|check| figures(check, row.units).json()),
        })
    };
    rows.iter().map(row).collect()
}

/// All figures of a check.
#[rustfmt::skip]
fn figures(check: &Check, units: Units) -> Figures {
    let [open, stick, slip] = check.zones;
    let mut figures = Figures::new(units);
    figures.counts("unknowns, multipliers", [("unknowns", check.n_free), ("multipliers", check.n_multipliers)]);
    let word = check.status.word();
    let status = format!("{word} to {:.1e}", check.accuracy);
    figures.described("status", "status", Some(status), word);
    figures.json_only("accuracy", check.accuracy);
    figures.json_only("steps", check.steps);
    figures.counts("panes open, sticking, slipping", [("", open), ("", stick), ("", slip)]);
    let precision = check.precision.word();
    let factor = Some(format!("in {precision} precision"));
    figures.described("factor_precision", "factor", factor, precision);
    let conditioning = figures.with(of_matrices(check, units));
    conditioning.with(of_answers(check, units))
}

#[rustfmt::skip]
fn of_matrices(check: &Check, units: Units) -> Figures {
    let (c, l) = (&check.conditioning, &check.linearisation);
    let mut figures = Figures::new(units);
    figures.number("stiffness_condition", "condition of A (scaled)", Scientific(0), c.stiffness);
    let (smallest, largest) = (c.dual.smallest, c.dual.largest);
    let unit = units.word(Dimension::DUAL);
    let range = format!("{smallest:.3e} to {largest:.3e} {unit}");
    figures.human_only("eigenvalues of S", Some(range));
    figures.number("dual_ratio", "  ratio", Scientific(3), c.dual.ratio());
    let by_area = "  ratio, scaled by pane areas";
    figures.number("dual_ratio_by_area", by_area, Scientific(3), c.dual_by_area.ratio());
    let determinant = sign(check, ["< 0", "= 0", "> 0"]);
    let shown = format!("det {determinant}, inverse {:.1e}", l.sensitivity);
    figures.described("sensitivity", "Newton's matrix R'", Some(shown), l.sensitivity);
    figures.json_only("determinant_sign", l.determinant_sign);
    figures.number("spectral_radius", "contraction of the mapping Ψ", Fixed(4), l.contraction);
    figures.number("fold_distance", "distance from a fold", Fixed(4), l.fold_distance);
    figures
}

#[rustfmt::skip]
fn of_answers(check: &Check, units: Units) -> Figures {
    let bound = check.rounding_bound;
    let mut figures = Figures::new(units);
    let certificate = format!("{:.1e}, rounding allows {:.0e}", check.certificate, bound.certificate);
    figures.described("certificate", "certificate", Some(certificate), check.certificate);
    figures.json_only("certificate_rounding", bound.certificate);
    let rivals = check.cross_checks.iter().map(|rival| {
        let (algorithm, status) = (rival.cross_check.word(), rival.status.word());
        let words = format!("{status}, {} steps, differs by {:.1e}", rival.steps, rival.disagreement);
        figures.human_only(algorithm, Some(words));
        serde_json::json!({
            "algorithm": algorithm,
            "status": status,
            "steps": rival.steps,
            "disagreement": rival.disagreement,
            "residual": rival.residual,
        })
    });
    let rivals: Value = rivals.collect();
    figures.json_only("rivals", rivals);
    figures.json_only("variation", Map::new());
    for result in &check.invariances {
        let key = format!("variation.{}", result.invariance.word());
        figures.number(&key, &result.invariance.word().replace('_', " "), Scientific(1), result.difference);
    }
    let (digits, wanted) = (check.trusted_digits(), check.wanted);
    let trusted = format!("{digits}, {:.0} asked for", -wanted.log10());
    figures.described("trusted_digits", "digits to trust", Some(trusted), digits);
    figures.number("multiplier_rounding", "rounding of λ", Scientific(0), bound.multiplier);
    figures.json_only("seconds", check.seconds);
    figures.human_only("verdict", Some(check.verdict().to_string()));
    figures
}
