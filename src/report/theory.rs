//! The measured theory.

use serde_json::{Value, json};
use studies::theory::{InfSup, Theory, TheoryLevel, TrialSpace};
use units::{Dimension, Units};

use super::{
    Digits::{Fixed, Scientific},
    FigureTable, Figures,
};

/// All tables and the findings.
pub fn text(theory: &Theory, units: Units) -> String {
    let law = &theory.law;
    let head = format!(
        "Law: F_min {:.4}, F_max {:.4}, L {:.4e} 1/{}, kappa {:.3}{}\n\n",
        law.smallest,
        law.largest,
        law.lipschitz,
        units.length(),
        law.anisotropy,
        if law.estimated { " (estimates)" } else { "" }
    );
    let tables: Vec<String> = tables(theory, units)
        .iter()
        .map(FigureTable::text)
        .collect();
    format!("{head}{}\n{}", tables.join("\n"), theory.findings())
}

/// The constants of the theory, and what is true at the solution and for scaled laws.
pub fn tables(theory: &Theory, units: Units) -> Vec<FigureTable> {
    let mut tables = vec![table("Contact face", theory, |level| face(level, units))];
    tables.extend(norms(theory, units));
    tables.extend(inf_sups(theory, units));
    let note = "norms and radii in the energy norm; excess of |F^-1 lambda_t| over g at points of panes, where it holds for means\n";
    let at_solution = table("At the solution", theory, |level| solution(level, units));
    tables.push(at_solution.with_note(note));
    let scales = table("Scales t of the law", theory, |level| limits(level, units));
    tables.push(scales.with_note(
        "the last three at the solutions followed from the smallest scale; none: not up to 1e6\n",
    ));
    tables
}

/// The same for programs.
pub fn json(theory: &Theory, units: Units) -> Value {
    let levels = theory.levels.iter().map(|level| level_json(level, units));
    json!({
        "law": {
            "coefficient_min": theory.law.smallest,
            "coefficient_max": theory.law.largest,
            "lipschitz": theory.law.lipschitz,
            "anisotropy": theory.law.anisotropy,
            "estimated": theory.law.estimated,
        },
        "levels": levels.collect::<Value>(),
        "findings": theory.findings().to_string(),
        "no_proof": no_proof(theory),
    })
}

fn level_json(level: &TheoryLevel, units: Units) -> Value {
    let norms = (0..level.norms.len()).map(|k| norm(level, k, units).json());
    let inf_sups = level
        .inf_sup
        .iter()
        .map(|row| inf_sup(level, row, units).json());
    let mut figures = Figures::new(units);
    figures.json_only("status", level.status.word());
    figures.json_only("norms", norms.collect::<Value>());
    figures.json_only("inf_sup", inf_sups.collect::<Value>());
    let measured = face(level, units).with(solution(level, units));
    measured.with(limits(level, units)).with(figures).json()
}

/// The figures that rest on c_tr(4), which an ascent finds from below.
fn no_proof(theory: &Theory) -> &'static [&'static str] {
    let all = &[
        "trace_fourth",
        "contraction_bound",
        "contraction_bound_weighted",
        "contraction_bound_averaged",
        "threshold_bound",
        "threshold_bound_weighted",
    ];
    if theory.law.lipschitz > 0.0 {
        all
    } else {
        &all[..1]
    }
}

/// A row of each mesh.
fn table(caption: &str, theory: &Theory, row: impl Fn(&TheoryLevel) -> Figures) -> FigureTable {
    FigureTable::new(caption, theory.levels.iter().map(row))
}

/// A row that begins with its mesh.
fn of_mesh(level: &TheoryLevel, units: Units) -> Figures {
    let mut figures = Figures::new(units);
    figures.plain("", "n_div", level.n_div);
    figures
}

#[rustfmt::skip]
fn face(level: &TheoryLevel, units: Units) -> Figures {
    let face = &level.face;
    let mut figures = Figures::new(units);
    figures.plain("n_div", "n_div", level.n_div);
    figures.plain("n_free", "unknowns", level.n_free);
    figures.plain("n_panes", "panes", level.n_panes);
    figures.add("triangle_size", "h", Dimension::LENGTH, Fixed(4), face.triangle_size);
    figures.add("pane_size", "H", Dimension::LENGTH, Fixed(4), face.pane_size);
    figures.number("inverse_first", "c_inv(1,0)", Fixed(4), face.inverse_first);
    figures.number("inverse_fourth", "c_inv(inf)", Fixed(4), face.inverse_fourth);
    figures.json_only("axes", face.axes);
    figures.number("interpolation_lagrange", "c_r |Y^h|", Fixed(4), face.lagrange);
    let finer = "c_r Lagrange, finer x 2, 4, 8";
    figures.number("interpolation_lagrange_finer", finer, Fixed(4), face.lagrange_finer);
    let finer = "c_r Clement, finer x 2, 4, 8";
    figures.number("interpolation_clement_finer", finer, Fixed(4), face.clement_finer);
    figures
}

/// A table for each norm of displacements.
fn norms(theory: &Theory, units: Units) -> [FigureTable; 2] {
    let proofs = if theory.law.lipschitz > 0.0 {
        "q composed is a proof up to rounding; c_tr(4) comes from an ascent, from below, so the other q and what follows from them may be too small\n"
    } else {
        "all q are proofs up to rounding: for a law that does not follow the slip they do without c_tr(4)\n"
    };
    let of_norm = |caption: &str, k| table(caption, theory, |level| norm(level, k, units));
    let (length, force) = (units.length(), units.force());
    let sobolev = format!("Norm of H1, lengths in {length}, forces in {force}");
    [
        of_norm(&sobolev, 0),
        of_norm("Energy norm", 1).with_note(proofs),
    ]
}

#[rustfmt::skip]
fn norm(level: &TheoryLevel, k: usize, units: Units) -> Figures {
    let (c, t) = (&level.norms[k], &level.thresholds);
    let local = level.local.as_ref();
    let mut figures = of_mesh(level, units);
    figures.json_only("norm", c.norm.words());
    for (key, words, digits, value) in [
        ("ellipticity", "alpha", 4, c.ellipticity),
        ("continuity", "M", 4, c.continuity),
        ("load", "|l|_*", 4, c.load),
        ("inverse_half", "c_inv(0,-1/2)", 4, c.inverse_half),
        ("trace_second", "c_tr(2)", 3, c.trace.second),
        ("trace_fourth", "c_tr(4)", 3, c.trace.fourth),
        ("slip_radius", "R_1", 3, c.radii.slip),
        ("pressure_radius", "R_2", 3, c.radii.pressure),
        ("contraction_bound", "q (3.13)", 3, c.bound.paper),
        ("contraction_bound_weighted", "q weighted", 3, c.bound.weighted),
        ("contraction_bound_sharp", "q composed", 3, c.bound.sharp),
        ("contraction_bound_averaged", "q program", 3, c.bound.averaged),
    ] {
        figures.number(key, words, Scientific(digits), value);
    }
    figures.json_only("trace_pointwise", c.trace.pointwise);
    figures.json_only("trace_interpolated", c.trace.interpolated);
    figures.json_only("trace_tangential", c.trace.tangential);
    figures.json_only("share_of_coefficient", c.bound.by_coefficient);
    figures.json_only("lemma_slip", level.observed.lemma[k][0]);
    figures.json_only("lemma_pressure", level.observed.lemma[k][1]);
    figures.json_only("quotient", level.observed.quotient[k]);
    figures.json_only("jacobian_norm", local.and_then(|l| Some(l.paper.as_ref()?[k])));
    figures.json_only("jacobian_norm_weighted", local.map(|l| l.parts[k].weighted()));
    figures.json_only("threshold_bound", t.paper[k]);
    figures.json_only("threshold_bound_weighted", t.weighted[k]);
    figures.json_only("threshold_bound_sharp", t.sharp[k]);
    figures.json_only("threshold_jacobian_norm", t.norm[k]);
    figures
}

/// Spaces of multipliers; `None` where none was measured.
fn inf_sups(theory: &Theory, units: Units) -> Option<FigureTable> {
    let rows = TrialSpace::ALL.into_iter().flat_map(|space| {
        theory.levels.iter().flat_map(move |level| {
            let rows = level.inf_sup.iter().filter(move |row| row.space == space);
            rows.map(move |row| inf_sup(level, row, units))
        })
    });
    let table = FigureTable::new(
        "Multipliers, norm of H1 (beta against the finest mesh)",
        rows,
    );
    (!table.rows.is_empty()).then_some(table)
}

#[rustfmt::skip]
fn inf_sup(level: &TheoryLevel, row: &InfSup, units: Units) -> Figures {
    let mut figures = of_mesh(level, units);
    figures.plain("space", "space", row.space.words());
    figures.number("size_ratio", "H/h", Fixed(1), row.ratio);
    figures.number("smallest_eigenvalue", "smallest eigenvalue", Scientific(4), row.smallest);
    figures.number("inverse_half", "c_inv(0,-1/2)", Fixed(4), row.inverse_half);
    figures.number("inf_sup", "beta", Fixed(4), row.inf_sup);
    figures
}

/// What Ψ does at the solution.
#[rustfmt::skip]
fn solution(level: &TheoryLevel, units: Units) -> Figures {
    let (local, observed) = (level.local.as_ref(), &level.observed);
    let mut figures = of_mesh(level, units);
    let radius = local.map(|l| l.spectral_radius);
    figures.number("spectral_radius", "spectral radius", Fixed(5), radius);
    figures.number("observed_rate", "observed rate", Fixed(5), observed.rate);
    figures.json_only("observed_rate_steps", observed.rate_steps);
    let norm = local.map(|l| l.parts[1].weighted());
    figures.number("", "norm, weighted", Fixed(5), norm);
    figures.number("", "sampled quotient", Fixed(5), observed.quotient[1]);
    let steps = observed.steps_from_zero;
    let shown = steps.map_or("> 200".to_owned(), |n| n.to_string());
    figures.described("steps_from_zero", "steps from 0", Some(shown), steps);
    figures.number("", "|phi|/R_1", Scientific(2), observed.lemma[1][0]);
    figures.number("", "|lambda|_*/R_2", Scientific(2), observed.lemma[1][1]);
    figures.plain("fixed_point_index", "index", local.map(|l| l.index));
    figures.plain("determinant_sign", "det R'", level.determinant);
    figures.json_only("evaluations", observed.evaluations);
    figures.json_only("unsolved", observed.unsolved);
    let functional = level.functional.as_ref();
    figures.number("functional_difference", "j_H/j - 1", Fixed(5), functional.map(|f| f.difference));
    figures.number("pointwise_excess", "excess", Fixed(3), functional.map(|f| f.excess));
    figures
}

/// Scales of the law at which bounds and truth reach 1.
#[rustfmt::skip]
fn limits(level: &TheoryLevel, units: Units) -> Figures {
    let t = &level.thresholds;
    let mut figures = of_mesh(level, units);
    for (words, value) in [
        ("q = 1, H1", t.paper[0]),
        ("weighted", t.weighted[0]),
        ("energy", t.paper[1]),
        ("weighted", t.weighted[1]),
        ("composed", t.sharp[1]),
    ] {
        figures.number("", words, Scientific(3), value);
    }
    for (key, words, value) in [
        ("", "norm = 1", t.norm[1]),
        ("threshold_spectral_radius", "spectral radius = 1", t.spectral_radius),
        ("threshold_singular", "det R' = 0", t.singular),
    ] {
        let shown = value.map_or("none".to_owned(), |scale| format!("{scale:.4}"));
        figures.described(key, words, Some(shown), value);
    }
    figures
}
