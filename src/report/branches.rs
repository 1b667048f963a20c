//! Paths of solutions and their points.

use std::fmt::Write;

use serde_json::{Value, json};
use studies::branches::{Branches, PathEnd, PathPoint, PointKind, Switch};
use units::{Dimension, Units};

use super::{
    Digits::{Fixed, Scientific},
    FigureTable, Figures,
};

/// Most panes or nodes that a line of the table names.
const MOST_NAMED: usize = 4;

/// The special points of all paths, and the solutions at both ends.
pub fn text(branches: &Branches, units: Units) -> String {
    let tables = tables(branches, units);
    tables.map(|table| table.text()).join("\n")
}

/// The special points of all paths, and the solutions at both ends, each with what is known of others.
pub fn tables(branches: &Branches, units: Units) -> [FigureTable; 3] {
    let range = &branches.range;
    let caption = format!(
        "Paths of solutions over {} from {} to {}",
        range.key, range.from, range.to
    );
    let points = branches.paths.iter().enumerate().flat_map(|(path, found)| {
        let points = found.points.iter().enumerate();
        let special = points.filter(|(_, point)| point.kind != PointKind::Regular);
        special.map(move |(number, point)| figures(path, number, point, units))
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
    let rows = solutions.map(|at| figures(at.path, at.number, at.point, units));
    FigureTable::new("", rows)
}

/// A point of a path, by their numbers from 0 on.
#[rustfmt::skip]
fn figures(path: usize, number: usize, point: &PathPoint, units: Units) -> Figures {
    let [open, stick, slip] = point.zones;
    let mut figures = Figures::new(units);
    figures.described("path", "path", Some((path + 1).to_string()), path);
    figures.plain("", "point", number + 1);
    figures.plain("kind", "what", kind_words(point.kind));
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

fn end_words(end: Option<PathEnd>) -> &'static str {
    match end {
        None => "unfinished",
        Some(PathEnd::Range) => "to the end of the range",
        Some(PathEnd::Closed) => "closed",
        Some(PathEnd::KnownPoint) => "to a branch point that is known",
        Some(PathEnd::Degenerate) => "to a point where so many panes change that no path leaves it",
        Some(PathEnd::Stuck) => "stuck: Newton's method does not settle at the smallest step",
        Some(PathEnd::Uncertified) => "to a point that the natural map does not certify",
        Some(PathEnd::TooLong) => "too long",
    }
}

/// The same for programs.
pub fn json(branches: &Branches, units: Units) -> Value {
    let paths = branches.paths.iter().enumerate().map(|(k, path)| {
        let points = path.points.iter().enumerate();
        let points = points.map(|(number, point)| figures(k, number, point, units).json());
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

/// A kind of point in words.
pub fn kind_words(kind: PointKind) -> &'static str {
    match kind {
        PointKind::Start => "start",
        PointKind::Regular => "regular",
        PointKind::Kink => "kink",
        PointKind::Fold => "fold",
        PointKind::KinkFold => "fold at a kink",
        PointKind::BranchPoint => "branch point",
        PointKind::End => "end",
    }
}
