//! The measured theory as tables and as JSON.

use std::fmt::Write;

use contact3d::theory::{DisplacementNorm, NormConstants, Theory, TheoryLevel, TrialSpace};
use serde_json::{Value, json};
use units::Units;

/// All tables and the findings.
pub(super) fn words(theory: &Theory, units: Units) -> String {
    let law = &theory.law;
    let length = units.length();
    let mut text = format!(
        "Law: F_min {:.4}, F_max {:.4}, L {:.4e} 1/{length}, kappa {:.3}{}\n\n",
        law.smallest,
        law.largest,
        law.lipschitz,
        law.anisotropy,
        if law.estimated { " (estimates)" } else { "" }
    );
    text += &face_table(&theory.levels, length);
    for (k, norm) in DisplacementNorm::ALL.into_iter().enumerate() {
        let note = match norm {
            DisplacementNorm::FirstSobolev => {
                format!(
                    "Norm of H1, lengths in {length}, forces in {}",
                    units.force()
                )
            }
            DisplacementNorm::Energy => "Energy norm".to_owned(),
        };
        let _ = writeln!(text, "{note}");
        text += &norm_table(&theory.levels, k);
    }
    text += match law.lipschitz > 0.0 {
        true => {
            "q composed is a proof up to rounding; c_tr(4) comes from an ascent, from below, so the other q and what follows from them may be too small\n\n"
        }
        false => {
            "all q are proofs up to rounding: for a law that does not follow the slip they do without c_tr(4)\n\n"
        }
    };
    text += &inf_sup_table(&theory.levels);
    text += &truth_table(&theory.levels);
    text += &threshold_table(&theory.levels);
    text + &theory.findings().to_string()
}

fn face_table(levels: &[TheoryLevel], length: &str) -> String {
    let mut text = format!(
        "Contact face\n\
         n_div  unknowns  panes  h [{length}]     H [{length}]     c_inv(1,0)  c_inv(inf)  c_r |Y^h|  c_r Lagrange, finer x 2, 4, 8  c_r Clement, finer x 2, 4, 8\n"
    );
    for level in levels {
        let face = &level.face;
        let finer = |values: [f64; 3]| values.map(|v| format!("{v:.4}")).join("  ");
        let _ = writeln!(
            text,
            "{:>5}  {:>8}  {:>5}  {:<9.4}  {:<9.4}  {:>10.4}  {:>10.4}  {:>9.4}  {:>30}  {:>29}",
            level.n_div,
            level.n_free,
            level.n_panes,
            face.triangle_size,
            face.pane_size,
            face.inverse_first,
            face.inverse_fourth,
            face.lagrange,
            finer(face.lagrange_finer),
            finer(face.clement_finer)
        );
    }
    text + "\n"
}

fn norm_table(levels: &[TheoryLevel], k: usize) -> String {
    let mut text = String::from(
        "n_div  alpha       M           |l|_*       c_inv(0,-1/2)  c_tr(2)    c_tr(4)    R_1        R_2        q (3.13)   q weighted  q composed  q program\n",
    );
    for level in levels {
        let c: &NormConstants = &level.norms[k];
        let _ = writeln!(
            text,
            "{:>5}  {:<10.4e}  {:<10.4e}  {:<10.4e}  {:<13.4e}  {:<9.3e}  {:<9.3e}  {:<9.3e}  {:<9.3e}  {:<9.3e}  {:<10.3e}  {:<10.3e}  {:<9.3e}",
            level.n_div,
            c.ellipticity,
            c.continuity,
            c.load,
            c.inverse_half,
            c.trace.second,
            c.trace.fourth,
            c.radii.slip,
            c.radii.pressure,
            c.bound.paper,
            c.bound.weighted,
            c.bound.sharp,
            c.bound.averaged
        );
    }
    text + "\n"
}

fn inf_sup_table(levels: &[TheoryLevel]) -> String {
    if levels.iter().all(|level| level.inf_sup.is_empty()) {
        return String::new();
    }
    let mut text = String::from(
        "Multipliers, norm of H1 (beta against the finest mesh)\n\
         n_div  space        H/h  smallest eigenvalue  c_inv(0,-1/2)  beta\n",
    );
    for space in TrialSpace::ALL {
        for level in levels {
            for row in level.inf_sup.iter().filter(|row| row.space == space) {
                let _ = writeln!(
                    text,
                    "{:>5}  {:<11}  {:<3.1}  {:<19.4e}  {:<13.4}  {}",
                    level.n_div,
                    space.words(),
                    row.ratio,
                    row.smallest,
                    row.inverse_half,
                    row.inf_sup
                        .map_or("-".to_owned(), |beta| format!("{beta:.4}"))
                );
            }
        }
    }
    text + "\n"
}

fn truth_table(levels: &[TheoryLevel]) -> String {
    let mut text = String::from(
        "At the solution\n\
         n_div  spectral radius  observed rate  norm, weighted  sampled quotient  steps from 0  |phi|/R_1  |lambda|_*/R_2  index  det R'  j_H/j - 1  excess\n",
    );
    for level in levels {
        let local = level.local.as_ref();
        let figure = |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{v:.5}"));
        let _ = writeln!(
            text,
            "{:>5}  {:>15}  {:>13.5}  {:>14}  {:>16.5}  {:>12}  {:>9.2e}  {:>14.2e}  {:>5}  {:>6}  {:>9}  {:>6}",
            level.n_div,
            figure(local.map(|l| l.spectral_radius)),
            level.observed.rate,
            figure(local.map(|l| l.parts[1].weighted())),
            level.observed.quotient[1],
            level
                .observed
                .steps_from_zero
                .map_or("> 200".to_owned(), |n| n.to_string()),
            level.observed.lemma[1][0],
            level.observed.lemma[1][1],
            local.map_or(0, |l| l.index),
            level.determinant,
            figure(level.functional.map(|f| f.difference)),
            level
                .functional
                .map_or("-".to_owned(), |f| format!("{:.3}", f.excess))
        );
    }
    text + "norms and radii in the energy norm; excess of |F^-1 lambda_t| over g at points of panes, where it holds for means\n\n"
}

fn threshold_table(levels: &[TheoryLevel]) -> String {
    let mut text = String::from(
        "Scales t of the law\n\
         n_div  q = 1, H1   weighted    energy     weighted   composed   norm = 1   spectral radius = 1  det R' = 0\n",
    );
    for level in levels {
        let t = &level.thresholds;
        let reached = |value: Option<f64>| value.map_or("none".to_owned(), |v| format!("{v:.4}"));
        let _ = writeln!(
            text,
            "{:>5}  {:<10.3e}  {:<10.3e}  {:<9.3e}  {:<9.3e}  {:<9.3e}  {:<9}  {:<19}  {}",
            level.n_div,
            t.paper[0],
            t.weighted[0],
            t.paper[1],
            t.weighted[1],
            t.sharp[1],
            reached(t.norm[1]),
            reached(t.spectral_radius),
            reached(t.singular)
        );
    }
    text + "the last three at the solutions followed from the smallest scale; none: not up to 1e6\n\n"
}

/// The same for programs.
pub(super) fn json(theory: &Theory) -> Value {
    let levels: Vec<Value> = theory.levels.iter().map(level_json).collect();
    json!({
        "law": {
            "coefficient_min": theory.law.smallest,
            "coefficient_max": theory.law.largest,
            "lipschitz": theory.law.lipschitz,
            "anisotropy": theory.law.anisotropy,
            "estimated": theory.law.estimated,
        },
        "levels": levels,
        "findings": theory.findings().to_string(),
        "no_proof": no_proof(theory),
    })
}

/// The figures that rest on c_tr(4), which an ascent finds from below.
fn no_proof(theory: &Theory) -> &'static [&'static str] {
    match theory.law.lipschitz > 0.0 {
        true => &[
            "trace_fourth",
            "contraction_bound",
            "contraction_bound_weighted",
            "contraction_bound_averaged",
            "threshold_bound",
            "threshold_bound_weighted",
        ],
        false => &["trace_fourth"],
    }
}

fn level_json(level: &TheoryLevel) -> Value {
    let face = &level.face;
    let local = level.local.as_ref();
    let inf_sup = level.inf_sup.iter().map(|row| {
        json!({
            "space": row.space.words(),
            "size_ratio": row.ratio,
            "smallest_eigenvalue": row.smallest,
            "inverse_half": row.inverse_half,
            "inf_sup": row.inf_sup,
        })
    });
    let norms = (0..level.norms.len()).map(|k| norm_json(level, k));
    json!({
        "n_div": level.n_div,
        "n_free": level.n_free,
        "n_panes": level.n_panes,
        "status": level.status.word(),
        "triangle_size": face.triangle_size,
        "pane_size": face.pane_size,
        "inverse_first": face.inverse_first,
        "inverse_fourth": face.inverse_fourth,
        "axes": face.axes,
        "interpolation_lagrange": face.lagrange,
        "interpolation_lagrange_finer": face.lagrange_finer,
        "interpolation_clement_finer": face.clement_finer,
        "norms": norms.collect::<Vec<_>>(),
        "inf_sup": inf_sup.collect::<Vec<_>>(),
        "spectral_radius": local.map(|l| l.spectral_radius),
        "fixed_point_index": local.map(|l| l.index),
        "determinant_sign": level.determinant,
        "observed_rate": level.observed.rate,
        "observed_rate_steps": level.observed.rate_steps,
        "steps_from_zero": level.observed.steps_from_zero,
        "evaluations": level.observed.evaluations,
        "unsolved": level.observed.unsolved,
        "functional_difference": level.functional.map(|f| f.difference),
        "pointwise_excess": level.functional.map(|f| f.excess),
        "threshold_spectral_radius": level.thresholds.spectral_radius,
        "threshold_singular": level.thresholds.singular,
    })
}

fn norm_json(level: &TheoryLevel, k: usize) -> Value {
    let c = &level.norms[k];
    let parts = level.local.as_ref().map(|l| l.parts[k]);
    let paper = level
        .local
        .as_ref()
        .and_then(|l| Some(l.paper.as_ref()?[k]));
    let t = &level.thresholds;
    json!({
        "norm": c.norm.words(),
        "ellipticity": c.ellipticity,
        "continuity": c.continuity,
        "load": c.load,
        "inverse_half": c.inverse_half,
        "trace_second": c.trace.second,
        "trace_fourth": c.trace.fourth,
        "trace_pointwise": c.trace.pointwise,
        "trace_interpolated": c.trace.interpolated,
        "trace_tangential": c.trace.tangential,
        "slip_radius": c.radii.slip,
        "pressure_radius": c.radii.pressure,
        "contraction_bound": c.bound.paper,
        "contraction_bound_weighted": c.bound.weighted,
        "contraction_bound_sharp": c.bound.sharp,
        "contraction_bound_averaged": c.bound.averaged,
        "share_of_coefficient": c.bound.by_coefficient,
        "lemma_slip": level.observed.lemma[k][0],
        "lemma_pressure": level.observed.lemma[k][1],
        "quotient": level.observed.quotient[k],
        "jacobian_norm": paper,
        "jacobian_norm_weighted": parts.map(|p| p.weighted()),
        "threshold_bound": t.paper[k],
        "threshold_bound_weighted": t.weighted[k],
        "threshold_bound_sharp": t.sharp[k],
        "threshold_jacobian_norm": t.norm[k],
    })
}
