//! `branches`: paths of solutions in a key of the scene, stored, drawn and printed.

use std::{fmt::Write, path::PathBuf};

use clap::Args;
use contact3d::branches::{
    Branches, Certificate, ParameterRange, PathEnd, PathPoint, PointKind, Switch, Undecided,
};
use units::Units;

use super::{
    arguments::{FigureArguments, Output, SceneArguments},
    exit::Exit,
    measured, override_scene, progress,
    terminal::{self, say},
};
use crate::{
    pipeline::{BranchesTask, Followed, SeriesFolder, SeriesKind, StageError, follow_branches},
    views::{Drawing, draw_branches, kind_words},
};

/// Most panes or nodes that a line of the table names.
const MOST_NAMED: usize = 4;

/// Arguments of `branches`.
#[derive(Debug, Args)]
pub struct BranchesArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    /// The run file, created or updated
    pub file: PathBuf,
    /// The key of the scene that changes, a number such as friction.coefficient.constant or traction.0.value.2
    #[arg(long, value_name = "KEY")]
    pub parameter: String,
    /// Its value where paths begin
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    pub from: f64,
    /// Its value at the other end of the range
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    pub to: f64,
    /// Search for all solutions at both ends of the range, and follow each
    #[arg(long)]
    pub all: bool,
    /// Folder for the points of each path as a series that ParaView plays, path_1.vtkhdf and so on
    #[arg(long, value_name = "FOLDER")]
    pub series: Option<PathBuf>,
    #[command(flatten)]
    pub(super) figures: FigureArguments,
}

/// `branches`: follows the paths, stores and draws them, and lists their special points.
pub(super) fn branches(
    arguments: &BranchesArguments,
    output: &Output,
    threads: usize,
) -> Result<Exit, StageError> {
    let (scene, inputs) = override_scene::read_with_inputs(&arguments.scene)?;
    let units = scene.scene.units;
    inputs.refuse(&arguments.file)?;
    let claim = |folder: &PathBuf| SeriesFolder::claim(folder, SeriesKind::Paths, &inputs);
    let series = arguments.series.as_ref().map(claim).transpose()?;
    let pictures = arguments
        .figures
        .claim(&arguments.file, Drawing::Branches, inputs)?;
    let task = BranchesTask {
        range: ParameterRange {
            key: arguments.parameter.clone(),
            from: arguments.from,
            to: arguments.to,
        },
        all: arguments.all,
    };
    let spinner = progress::spinner("branches", output);
    let mut observe = |branches: &Branches| spinner.set_message(where_it_stands(branches));
    let followed = follow_branches(
        &arguments.file,
        scene,
        &task,
        series.as_ref(),
        threads,
        &mut observe,
    );
    spinner.finish_and_clear();
    let Followed {
        branches,
        series: files,
    } = followed?;
    if let Some(folder) = &arguments.series {
        say(
            output,
            &format!("series    {} files in {}", files.len(), folder.display()),
        );
    }
    measured::draw(pictures.as_ref(), output, |folder| {
        draw_branches(folder, &branches, units)
    })?;
    measured::print(
        output,
        units,
        || json(&branches),
        || words(&branches, units),
    );
    match shortcoming(&branches) {
        None => Ok(Exit::Done),
        Some(reason) => {
            terminal::message(&format!("NOT CONVERGED: {reason}"));
            Ok(Exit::NotConverged)
        }
    }
}

/// Why the search did not end as it should; `None` where it did.
fn shortcoming(branches: &Branches) -> Option<String> {
    if branches.left_out > 0 {
        return Some(format!(
            "{} half paths from branch points are not followed; choose a smaller range",
            branches.left_out
        ));
    }
    if !branches.is_followed() {
        return Some("a path ends where Newton's method does not settle; see its end".to_owned());
    }
    branches.lacks().then(|| {
        "signs of det R' at an end of the range do not add up to 1, so a solution there is missing or not regular, and no other start leads to it; \
         move the end a little with --from or --to, or follow another key with --parameter".to_owned()
    })
}

fn where_it_stands(branches: &Branches) -> String {
    let last = branches.paths.last();
    let point = last.and_then(|path| path.points.last());
    let parameter = point.map_or(branches.range.from, |point| point.parameter);
    let points: usize = branches.paths.iter().map(|path| path.points.len()).sum();
    format!(
        "path {}, point {points}, {} = {parameter:.6}",
        branches.paths.len(),
        branches.range.key
    )
}

/// The special points of all paths, and the solutions at both ends.
fn words(branches: &Branches, units: Units) -> String {
    let force = units.force();
    let mut text = format!(
        "Paths of solutions over {} from {} to {}\n\
         path  point  what             parameter            open stick slip  det R'  rho(Psi')  residual  normal [{force}]     tangential 1 [{force}]  what changes\n",
        branches.range.key, branches.range.from, branches.range.to,
    );
    for (k, path) in branches.paths.iter().enumerate() {
        for (i, point) in path.points.iter().enumerate() {
            if point.kind != PointKind::Regular {
                let _ = writeln!(text, "{:>4}  {:>5}  {}", k + 1, i + 1, line(point));
            }
        }
        let _ = writeln!(
            text,
            "{:>4}  {} points; {}",
            k + 1,
            path.points.len(),
            end_words(path.end)
        );
    }
    for parameter in ends(branches) {
        let _ = write!(text, "\n{}", solutions_words(branches, parameter));
    }
    text
}

fn ends(branches: &Branches) -> [f64; 2] {
    [branches.range.from, branches.range.to]
}

fn solutions_words(branches: &Branches, parameter: f64) -> String {
    let solutions = branches.end_solutions(parameter);
    let degree = branches.degree(parameter);
    let mut text = format!("Solutions at {parameter}, sum of signs {degree}: ");
    let end = usize::from(parameter == branches.range.to);
    text += &match branches.certificates[end] {
        Ok(all) => certificate_words(&all, solutions.len()),
        Err(undecided @ Undecided::NotAsked) => undecided.to_string(),
        Err(undecided) => format!("{}; {undecided}", degree_words(degree)),
    };
    text.push('\n');
    for at in solutions {
        let point = &branches.paths[at.path].points[at.point];
        let _ = writeln!(
            text,
            "{:>4}  {:>5}  {}",
            at.path + 1,
            at.point + 1,
            line(point)
        );
    }
    text
}

/// What the sum of signs tells without a proof.
fn degree_words(degree: i32) -> &'static str {
    match degree {
        1 => "some may be missing; the sum is 1 where none is, and may be 1 where some are",
        _ => "one is missing or not regular, since the sum is not 1",
    }
}

fn certificate_words(all: &Certificate, found: usize) -> String {
    let complete = match all.solutions == found {
        true => "complete by enumeration".to_owned(),
        false => format!("{} exist by enumeration", all.solutions),
    };
    format!(
        "{complete} ({} choices of states, {} boxes, each with no solution or exactly one; \
         least determinant {:.1e}, margin {:.1e}; S and h to {:.0e})",
        all.states, all.boxes, all.determinant, all.margin, all.uncertainty
    )
}

fn line(point: &PathPoint) -> String {
    let [open, stick, slip] = point.zones;
    format!(
        "{:<15}  {:<19.12e}  {open:>4} {stick:>5} {slip:>4}  {:>6}  {:>9.4}  {:>8.1e}  {:<16.9e}  {:<20.9e}  {}",
        kind_words(point.kind),
        point.parameter,
        point.determinant,
        point.spectral_radius,
        point.residual,
        point.normal_force,
        point.tangential_force[0],
        switches_words(&point.switches)
    )
    .trim_end()
    .to_owned()
}

fn switches_words(switches: &[Switch]) -> String {
    let named = switches.iter().take(MOST_NAMED).map(|switch| match switch {
        Switch::Opening(pane) => format!("pane {pane} opens or closes"),
        Switch::Slipping(pane) => format!("pane {pane} sticks or slips"),
        Switch::Cap(pane) => format!("pane {pane} reaches the cap"),
        Switch::Reversal(node, axis) => format!("node {node} turns along t{}", axis + 1),
        Switch::Knot(node, k) => format!("node {node} reaches a knot of F{}", k + 1),
    });
    let mut text = named.collect::<Vec<_>>().join(", ");
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
fn json(branches: &Branches) -> serde_json::Value {
    let point = |path: usize, point: &PathPoint| {
        serde_json::json!({
            "path": path,
            "kind": kind_words(point.kind),
            "parameter": point.parameter,
            "determinant_sign": point.determinant,
            "spectral_radius": point.spectral_radius,
            "attracting": point.is_attracting(),
            "residual": point.residual,
            "zone_counts": point.zones,
            "normal_force": point.normal_force,
            "tangential_force": point.tangential_force,
            "largest_pressure": point.largest_pressure,
            "switches": switches_words(&point.switches),
        })
    };
    let paths = branches.paths.iter().enumerate().map(|(k, path)| {
        let points = path.points.iter().map(|p| point(k, p));
        serde_json::json!({
            "end": end_words(path.end),
            "points": points.collect::<Vec<_>>(),
        })
    });
    let solutions = ends(branches).map(|parameter| {
        let certificate = branches.certificates[usize::from(parameter == branches.range.to)];
        let solutions = branches.end_solutions(parameter);
        let solutions = solutions
            .iter()
            .map(|at| point(at.path, &branches.paths[at.path].points[at.point]));
        serde_json::json!({
            "parameter": parameter,
            "degree": branches.degree(parameter),
            "enumerated": branches.is_enumerated(usize::from(parameter == branches.range.to)),
            "certificate": certificate.ok(),
            "no_proof": certificate.err().map(|undecided| undecided.to_string()),
            "solutions": solutions.collect::<Vec<_>>(),
        })
    });
    serde_json::json!({
        "key": branches.range.key,
        "from": branches.range.from,
        "to": branches.range.to,
        "all": branches.all,
        "enumerated": branches.is_enumerated(0) && branches.is_enumerated(1),
        "left_out": branches.left_out,
        "followed": branches.is_followed(),
        "complete": branches.is_complete(),
        "paths": paths.collect::<Vec<_>>(),
        "solutions": solutions,
    })
}
