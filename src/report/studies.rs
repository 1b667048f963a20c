//! What studies found: the errors of solvers and of meshes, the bound of the discretisation error, paths of solutions and their points.

use std::fmt::Write;

use contact3d::{
    post::StressConcentration,
    scene::{Quantity, Scene},
};
use serde_json::{Value, json};
use studies::{
    accuracy::{Accuracy, AlgebraicStudy, Cost, DiscretisationStudy, SolverRun},
    bound::BoundParts,
    branches::{Branches, PathEnd, PathPoint, PointKind, Switch},
};
use units::{Dimension, Units};

use super::{
    Digits::{Fixed, Scientific},
    FigureTable, Figures,
    answer::{edge_words, name_of_quantity},
    percent,
};
use crate::format::dimension_of_quantity as dimension;

/// The advice, then the tables; that of the solves, which is long, is in the page and in JSON.
pub fn accuracy_text(accuracy: &Accuracy, scene: &Scene) -> String {
    let (study, units) = (&accuracy.discretisation, scene.units);
    let tables = [
        levels(study, units),
        quantities(study, units),
        limits(study, units),
    ];
    let tables = tables.map(|table| table.text() + "\n");
    let advice = accuracy.advice(scene.element());
    let mut text = format!("{advice}\n\n{}", tables.concat());
    if let Some(study) = &accuracy.algebraic {
        let count = study.entries.len();
        let _ = write!(
            text,
            "{count} solves by method, operator and epsilon: `report` and --json list them"
        );
    }
    text.trim_end().to_owned()
}

/// The same for programs.
pub fn accuracy_json(accuracy: &Accuracy, scene: &Scene) -> Value {
    let (algebraic, study) = (&accuracy.algebraic, &accuracy.discretisation);
    let units = scene.units;
    let rows = levels(study, units).rows.into_iter();
    let rows = rows.zip(quantities(study, units).rows);
    json!({
        "solves": algebraic.as_ref().map_or_else(|| json!([]), |study| entries(study, units).json()),
        "levels": rows.map(|(level, quantities)| level.with(quantities).json()).collect::<Value>(),
        "limits": limits(study, units).json(),
        "advice": accuracy.advice(scene.element()).to_string(),
    })
}

/// The solves of the algebraic study.
pub fn entries(study: &AlgebraicStudy, units: Units) -> FigureTable {
    let rows = study.entries.iter().map(|row| solver_run(row, units));
    let mut note = String::new();
    for (operator, cost) in ["implicit", "explicit"].iter().zip(&study.assembly) {
        let _ = writeln!(
            note,
            "assembly, {operator}: {:.3} s (median of {}), peak {} MB",
            cost.seconds,
            cost.repeats,
            megabytes(cost)
        );
    }
    let caption = format!(
        "Algebraic error, against Newton's method to {:.1e} ({})",
        study.reference_accuracy,
        study.reference_status.word()
    );
    FigureTable::new(&caption, rows).with_note(note)
}

#[rustfmt::skip]
fn solver_run(entry: &SolverRun, units: Units) -> Figures {
    let result = entry.result.as_ref();
    let mut figures = Figures::new(units);
    figures.plain("method", "method", entry.method.word());
    figures.plain("operator", "operator", entry.operator.word());
    figures.number("epsilon", "epsilon", Scientific(0), entry.epsilon);
    figures.number("energy_error", "error of u", Scientific(2), result.map(|r| r.energy_error));
    figures.number("multiplier_error", "error of λ", Scientific(2), result.map(|r| r.multiplier_error));
    figures.plain("applications", "applications", result.map(|r| r.applications));
    cost(&mut figures, result.map(|r| &r.cost));
    figures.json_only("cost", result.map(|r| r.cost));
    let (shown, word) = match result {
        Some(result) => (result.status.word(), result.status.word()),
        None => ("not run: over the budget", "not_run_over_budget"),
    };
    figures.described("status", "status", Some(shown.to_owned()), word);
    figures
}

/// The meshes of the discretisation study.
#[rustfmt::skip]
pub fn levels(study: &DiscretisationStudy, units: Units) -> FigureTable {
    let rows = study.levels.iter().enumerate().map(|(k, level)| {
        let mut figures = Figures::new(units);
        figures.human_only("mesh", Some(level.name()));
        figures.json_only("n_div", level.cells.and_then(|cells| cells.into_iter().min()));
        figures.json_only("cells", level.cells);
        figures.json_only("n_tetrahedra", level.n_tetrahedra);
        figures.add("size", "h", Dimension::LENGTH, Scientific(3), level.size);
        figures.plain("n_free", "unknowns", level.n_free);
        figures.number("energy_difference", "error to finest", Fixed(4), known(level.energy_difference));
        figures.number("energy_error", "error to limit", Fixed(4), level.energy_error);
        figures.number("energy_order", "order", Fixed(2), study.energy_norm.orders[k]);
        figures.add("potential_energy", "potential energy", Dimension::Energy, Scientific(8), level.potential_energy);
        figures.number("potential_energy_order", "order", Fixed(2), study.potential_energy.orders[k]);
        figures.plain("applications", "applications", level.applications);
        cost(&mut figures, Some(&level.cost));
        figures.json_only("cost", level.cost);
        figures.plain("status", "status", level.status.word());
        figures
    });
    let caption = "Discretisation error (relative, energy norm; orders from each mesh and the two before)";
    FigureTable::new(caption, rows)
}

/// What the meshes make of quantities.
pub fn quantities(study: &DiscretisationStudy, units: Units) -> FigureTable {
    let rows = study.levels.iter().enumerate().map(|(k, level)| {
        let mut figures = Figures::new(units);
        figures.human_only("mesh", Some(level.name()));
        for ((of, trend), value) in study.quantities.iter().zip(&level.quantities) {
            let (name, key) = (name_of_quantity(*of), of.word());
            figures.add(key, &name, dimension(*of), Scientific(5), known(*value));
            figures.number(&format!("{key}_order"), "order", Fixed(2), trend.orders[k]);
        }
        figures
    });
    FigureTable::new("Quantities of the meshes (\"-\" where there is none)", rows)
}

/// What values would be on ever finer meshes.
#[rustfmt::skip]
pub fn limits(study: &DiscretisationStudy, units: Units) -> FigureTable {
    let own = &study.levels[study.scene_level];
    let energy = ("potential_energy", "potential energy".to_owned(), Dimension::Energy, own.potential_energy, &study.potential_energy);
    let quantities = study.quantities.iter().zip(&own.quantities);
    let quantities = quantities.map(|((of, trend), value)| (of.word(), name_of_quantity(*of), dimension(*of), *value, trend));
    let rows = [energy].into_iter().chain(quantities).map(|(key, name, dimension, value, trend)| {
        let unit = units.of(dimension);
        let told = trend.limit.map(|limit| match trend.is_confirmed() {
            true => unit.told(&[limit]),
            false => format!("about {}, by three meshes", unit.told(&[limit])),
        });
        let grows = trend.grows.map(|at| format!("grows with every finer mesh at {}", edge_words(at)));
        let mut figures = Figures::new(units);
        figures.described("name", "quantity", Some(name), key);
        figures.described("limit", "limit", told.or(grows), trend.limit);
        figures.json_only("unit", unit.word());
        figures.human_only("from the scene's mesh", trend.limit.map(|limit| percent((value / limit - 1.0).abs())));
        figures.json_only("concentration", trend.grows.map(StressConcentration::word));
        figures
    });
    FigureTable::new("Limits, of energies by three meshes, of all else by four (\"-\": too few, or differences do not fall with h)", rows)
}

fn known(value: f64) -> Option<f64> {
    Some(value).filter(|value| !value.is_nan())
}

/// What a solve costs, for people.
#[rustfmt::skip]
fn cost(figures: &mut Figures, cost: Option<&Cost>) {
    figures.add("", "time", Dimension::Time, Fixed(4), cost.map(|cost| cost.seconds));
    figures.plain("", "runs timed", cost.map(|cost| cost.repeats));
    figures.human_only("peak MB", cost.map(megabytes));
}

fn megabytes(cost: &Cost) -> String {
    known(cost.peak_bytes).map_or("unknown".to_owned(), |bytes| format!("{:.0}", bytes / 1e6))
}

/// The bound and its parts, and an estimate of the same error where there is one.
pub fn bound(bound: &BoundParts, scene: &Scene, estimate: Option<f64>) -> Figures {
    let mut figures = Figures::new(scene.units);
    let whole = "error in the energy norm";
    add(&mut figures, "total", whole, bound.total);
    if bound.total.is_none() {
        let why = why_none(scene);
        let words = format!("no bound: {why}, and the contact stresses have an error of their own");
        figures.human_only(whole, Some(words));
    }
    let under = "under these contact stresses";
    add(&mut figures, "elements", under, Some(bound.elements));
    if bound.lifting.is_some() {
        add(&mut figures, "lifting", "of it penetration", bound.lifting);
        let on_gaps = bound.complementarity;
        add(
            &mut figures,
            "complementarity",
            "of it pressure on gaps",
            on_gaps,
        );
        add(&mut figures, "friction", "of it slip", bound.friction);
    }
    let shown = estimate.map(|share| format!("about {}", percent(share)));
    figures.described("estimate", "estimated", shown, estimate);
    figures
}

fn add(figures: &mut Figures, key: &str, words: &str, share: Option<f64>) {
    let shown = share.map(|share| {
        let percent = percent(rounded_up(share));
        format!("guaranteed at most {percent}, rounded up")
    });
    figures.described(key, words, shown, share);
}

/// Why only the error for the contact stresses as they are has a bound.
fn why_none(scene: &Scene) -> &'static str {
    if scene
        .contacts
        .iter()
        .any(|face| face.gap.depends_on_place())
    {
        return "a gap is a formula";
    }
    let laws = (0..scene.contacts.len()).filter_map(|entry| scene.friction_on(entry));
    let mut bounds = laws.map(|(_, law)| law.slip_bound.as_ref());
    if bounds.clone().any(|bound| bound.is_none()) {
        return "friction follows the pressure";
    }
    match bounds.any(|bound| bound.is_some_and(Quantity::depends_on_place)) {
        true => "a slip bound is a formula",
        false => "friction in a load history",
    }
}

/// The next larger number of two digits.
fn rounded_up(share: f64) -> f64 {
    let unit = 10_f64.powf(share.log10().floor() - 1.0);
    if unit > 0.0 {
        (share / unit).ceil() * unit
    } else {
        share
    }
}

/// Most panes or nodes that a line of the table names.
const MOST_NAMED: usize = 4;

/// The special points of all paths, and the solutions at both ends.
pub fn branches_text(branches: &Branches, units: Units) -> String {
    let tables = branches_tables(branches, units);
    tables.map(|table| table.text()).join("\n")
}

/// The special points of all paths, and the solutions at both ends, each with what is known of others.
pub fn branches_tables(branches: &Branches, units: Units) -> [FigureTable; 3] {
    let range = &branches.range;
    let caption = format!(
        "Paths of solutions over {} from {} to {}",
        range.key, range.from, range.to
    );
    let points = branches.paths.iter().enumerate().flat_map(|(path, found)| {
        let points = found.points.iter().enumerate();
        let special = points.filter(|(_, point)| point.kind != PointKind::Regular);
        special.map(move |(number, point)| point_figures(path, number, point, units))
    });
    let mut table = FigureTable::new(&caption, points);
    for (number, path) in (1..).zip(&branches.paths) {
        let _ = writeln!(
            table.note,
            "path {number}: {} points; {}",
            path.points.len(),
            end_words(path.end)
        );
    }
    let [from, to] =
        ends(branches).map(|parameter| solutions_with_words(branches, parameter, units));
    [table, from, to]
}

fn ends(branches: &Branches) -> [f64; 2] {
    [branches.range.from, branches.range.to]
}

/// The solutions at one end of the range, and what is known of others.
fn solutions_with_words(branches: &Branches, parameter: f64, units: Units) -> FigureTable {
    let degree = branches.degree(parameter);
    let others = match (branches.all, degree) {
        (false, _) => "those on the paths; --all searches for others",
        (true, 1) => {
            "others may exist: the sum is 1 where none is missing, and may be 1 where some are"
        }
        (true, _) => "at least one is missing or not regular, since the sum is not 1",
    };
    FigureTable {
        caption: format!("Solutions at {parameter}, sum of signs {degree}: {others}"),
        ..solutions(branches, parameter, units)
    }
}

fn solutions(branches: &Branches, parameter: f64, units: Units) -> FigureTable {
    let solutions = branches.end_solutions(parameter).into_iter();
    let rows = solutions.map(|([path, number], point)| point_figures(path, number, point, units));
    FigureTable::new("", rows)
}

/// A point of a path, by their numbers from 0 on.
#[rustfmt::skip]
fn point_figures(path: usize, number: usize, point: &PathPoint, units: Units) -> Figures {
    let [open, stick, slip] = point.zones;
    let mut figures = Figures::new(units);
    figures.described("path", "path", Some((path + 1).to_string()), path);
    figures.plain("", "point", number + 1);
    figures.plain("kind", "what", point.kind.word());
    figures.number("parameter", "parameter", Scientific(12), point.parameter);
    figures.counts("open, stick, slip", [("", open), ("", stick), ("", slip)]);
    figures.json_only("zone_counts", point.zones);
    figures.plain("determinant_sign", "det R'", point.determinant);
    figures.number("spectral_radius", "rho(Psi')", Fixed(4), point.spectral_radius);
    figures.json_only("attracting", point.is_attracting());
    figures.number("residual", "residual", Scientific(1), point.residual);
    figures.add("normal_force", "normal", Dimension::FORCE, Scientific(9), point.normal_force);
    let first = point.tangential_force[0];
    figures.add("", "tangential 1", Dimension::FORCE, Scientific(9), first);
    figures.json_only("tangential_force", point.tangential_force);
    figures.json_only("largest_pressure", point.largest_pressure);
    figures.plain("switches", "what changes", switches_words(&point.switches));
    figures
}

fn switches_words(switches: &[Switch]) -> String {
    let named = switches.iter().take(MOST_NAMED).map(|switch| match switch {
        Switch::Opening(pane) => format!("pane {pane} opens or closes"),
        Switch::Slipping(pane) => format!("pane {pane} sticks or slips"),
        Switch::Cap(pane) => format!("pane {pane} reaches the cap"),
        Switch::Reversal(node, axis) => format!("node {node} turns along t{}", axis + 1),
        Switch::Knot(node, k) => format!("node {node} reaches a knot of F{}", k + 1),
    });
    let mut text = named.collect::<Vec<String>>().join(", ");
    if switches.len() > MOST_NAMED {
        let _ = write!(text, ", {} more", switches.len() - MOST_NAMED);
    }
    text
}

/// Where a path led.
pub fn end_words(end: PathEnd) -> &'static str {
    match end {
        PathEnd::Range => "to the end of the range",
        PathEnd::Closed => "closed",
        PathEnd::KnownPoint => "to a branch point that is known",
        PathEnd::Degenerate => "to a point where so many panes change that no path leaves it",
        PathEnd::Stuck => "stuck: Newton's method does not settle at the smallest step",
        PathEnd::Uncertified => {
            "to a point with too large a residual, as where the load almost vanishes"
        }
        PathEnd::TooLong => "too long",
    }
}

/// The same for programs.
pub fn branches_json(branches: &Branches, units: Units) -> Value {
    let paths = branches.paths.iter().enumerate().map(|(k, path)| {
        let points = path.points.iter().enumerate();
        let points = points.map(|(number, point)| point_figures(k, number, point, units).json());
        json!({ "end": end_words(path.end), "points": points.collect::<Value>() })
    });
    let at_ends = ends(branches).map(|parameter| {
        json!({
            "parameter": parameter,
            "degree": branches.degree(parameter),
            "solutions": solutions(branches, parameter, units).json(),
        })
    });
    json!({
        "key": branches.range.key,
        "from": branches.range.from,
        "to": branches.range.to,
        "all": branches.all,
        "left_out": branches.left_out,
        "followed": branches.is_followed(),
        "paths": paths.collect::<Value>(),
        "solutions": at_ends,
    })
}
