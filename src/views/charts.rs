//! What the charts of a run file show: its solve, its levels, and the studies of its scene.

use std::path::PathBuf;

use contact3d::{adaptation::AdaptiveLevel, scene::unit_of_key, solver::Solution};
use plots::{Chart, ChartAxis, ChartPoint, Series, SeriesStyle};
use studies::{
    accuracy::{Accuracy, AlgebraicStudy, DiscretisationStudy, Level, SolverRun},
    branches::{Branches, Path, PathEnd, PathPoint, PointKind},
};
use units::{Dimension, Unit, Units};

use super::PictureFolder;
use crate::pipeline::StageError;

/// Names of the pictures.
pub(super) const WORK_PRECISION: &str = "work_precision";
pub(super) const CONVERGENCE: &str = "convergence";

/// Those of `accuracy`.
pub(super) const ACCURACY: [&str; 2] = [WORK_PRECISION, CONVERGENCE];

/// Draws the work-precision and the convergence diagram as SVG and PNG; returns the files.
pub fn draw_accuracy(
    folder: &PictureFolder,
    accuracy: &Accuracy,
    units: Units,
) -> Result<Vec<PathBuf>, StageError> {
    let algebraic = accuracy.algebraic.as_ref().map(work_precision);
    // The finest mesh is what the others are compared with, and one point is no line.
    let study = &accuracy.discretisation;
    let discretisation = (study.levels.len() > 2).then(|| convergence(study, units));
    let charts = [(WORK_PRECISION, algebraic), (CONVERGENCE, discretisation)];
    let drawn = charts
        .into_iter()
        .filter_map(|(name, chart)| Some((name, chart?)));
    folder.save_charts(drawn)
}

/// Energy error of each solve against its seconds.
pub(super) fn work_precision(study: &AlgebraicStudy) -> Chart {
    let series = study.series().into_iter().map(|entries| {
        let points = entries.iter().filter_map(entry_point);
        Series::new(&series_name(&entries[0]), points)
    });
    let time = ChartAxis::logarithmic("time of the solve", Units::SI.of(Dimension::Time));
    let error = "algebraic error of u in the energy norm, relative";
    let error = ChartAxis::logarithmic(error, Unit::none());
    Chart::new(
        "Work and precision on the scene's mesh",
        time,
        error,
        series,
    )
}

fn entry_point(entry: &SolverRun) -> Option<ChartPoint> {
    let result = entry.result?;
    Some(ChartPoint {
        x: result.cost.seconds,
        y: result.energy_error,
        text: format!(
            "{}, epsilon {:.0e}: energy error {:.2e}, multiplier error {:.2e}, {:.3} s, {} applications",
            series_name(entry),
            entry.epsilon,
            result.energy_error,
            result.multiplier_error,
            result.cost.seconds,
            result.applications
        ),
    })
}

/// Method and operator of a series.
fn series_name(entry: &SolverRun) -> String {
    [entry.method.word(), entry.operator.word()].join(", ")
}

/// Errors of the meshes against their size.
pub(super) fn convergence(study: &DiscretisationStudy, units: Units) -> Chart {
    let points = |value: &dyn Fn(&Level) -> Option<f64>| -> Vec<ChartPoint> {
        let levels = study.levels.iter();
        let values = levels.filter_map(|level| Some((level, value(level)?)));
        let point = |(level, error): (&Level, f64)| ChartPoint {
            x: level.size,
            y: error,
            text: format!("{}: {error:.3e}", level.name()),
        };
        values.map(point).collect()
    };
    let limit = study.potential_energy.limit;
    let energy = points(&|level| Some((level.potential_energy / limit? - 1.0).abs()));
    let series = [
        (
            "u, energy norm, to the finest",
            points(&|level| Some(level.energy_difference)),
        ),
        (
            "u, energy norm, to the limit",
            points(&|level| level.energy_error),
        ),
        ("J, to the limit", energy),
    ];
    let series = series.map(|(name, points)| Series::new(name, points));
    let size = ChartAxis::logarithmic("h", units.of(Dimension::LENGTH));
    let error = ChartAxis::logarithmic("relative error", Unit::none());
    Chart::new("Discretisation error", size, error, series)
}

/// The estimated error of the levels of an adaptive mesh against their unknowns, and against the time until each, with what was asked for.
pub(super) fn adaptation(levels: &[AdaptiveLevel], target: f64) -> [Chart; 2] {
    let mut seconds = 0.0;
    let until = levels.iter().map(|level| {
        seconds += level.seconds;
        seconds
    });
    let unknowns = levels.iter().map(|level| level.n_free as f64);
    [
        (unknowns.collect::<Vec<_>>(), "unknowns", Unit::none()),
        (
            until.collect(),
            "time until the level",
            Units::SI.of(Dimension::Time),
        ),
    ]
    .map(|(along, name, unit)| {
        let point = |(number, (level, &x)): (usize, (&AdaptiveLevel, &f64))| ChartPoint {
            x,
            y: level.estimated_error,
            text: format!(
                "level {number}: {} unknowns, error {:.2e}",
                level.n_free, level.estimated_error
            ),
        };
        let points = levels.iter().zip(&along).enumerate().map(point);
        let ends = along.first().into_iter().chain(along.last());
        let asked = ends.map(|&x| ChartPoint {
            x,
            y: target,
            text: format!("asked for: {target:.2e}"),
        });
        let series = [
            Series::new("levels", points),
            Series::new("asked for", asked),
        ];
        let error = ChartAxis::logarithmic("estimated relative error", Unit::none());
        Chart::new(
            "Levels of the adaptive mesh",
            ChartAxis::logarithmic(name, unit),
            error,
            series,
        )
    })
}

/// How the solve reached its answer, step by step.
pub(super) fn history(solution: &Solution) -> Chart {
    let line = |name: &str, values: Vec<f64>| {
        let points = (1..).zip(values).map(|(step, value)| ChartPoint {
            x: f64::from(step),
            y: value,
            text: format!("step {step}: {value:.3e}"),
        });
        Series::new(name, points)
    };
    let outer = &solution.trace.history;
    let most = outer.len().max(solution.trace.newton.len()).max(1);
    let series = [
        line(
            "Newton: |R| / |λ|",
            solution
                .trace
                .newton
                .iter()
                .map(|step| step.residual)
                .collect(),
        ),
        line(
            "outer: change of λ",
            outer.iter().map(|step| step.change).collect(),
        ),
        line(
            "outer: inner residual",
            outer.iter().map(|step| step.inner_residual).collect(),
        ),
    ];
    let ticks = (1..=most).step_by(most.div_ceil(12)).map(|k| k as f64);
    let step = ChartAxis::linear("step", Unit::none()).with_ticks(ticks);
    let size = ChartAxis::logarithmic("relative size", Unit::none());
    Chart::new("Convergence of the solve", step, size, series)
}

/// Those of `branches`.
pub(super) const BRANCHES: [&str; 2] = ["branches_normal_force", "branches_tangential_force"];

/// Draws the normal and the first tangential force over the parameter as SVG and PNG; returns the files.
pub fn draw_branches(
    folder: &PictureFolder,
    branches: &Branches,
    units: Units,
) -> Result<Vec<PathBuf>, StageError> {
    folder.save_charts(BRANCHES.into_iter().zip(diagrams(branches, units)))
}

/// The normal and the first tangential force over the parameter.
pub(super) fn diagrams(branches: &Branches, units: Units) -> [Chart; 2] {
    [
        diagram(branches, units, "normal contact force", |point| {
            point.normal_force
        }),
        diagram(branches, units, "friction force along t1", |point| {
            point.tangential_force[0]
        }),
    ]
}

fn diagram(
    branches: &Branches,
    units: Units,
    label: &str,
    quantity: fn(&PathPoint) -> f64,
) -> Chart {
    let range = &branches.range;
    let along = if range.is_logarithmic() && range.from > 0.0 {
        ChartAxis::logarithmic
    } else {
        ChartAxis::linear
    };
    let parts = branches.paths.iter().flat_map(|path| parts(path, quantity));
    let marks = branches.paths.iter().flat_map(|path| marks(path, quantity));
    Chart::new(
        &format!("Solutions over {}", range.key),
        along(&range.key, unit_of_key(&range.key, units)),
        ChartAxis::linear(label, units.of(Dimension::FORCE)),
        parts.chain(marks),
    )
}

fn place(point: &PathPoint, quantity: fn(&PathPoint) -> f64, text: String) -> ChartPoint {
    ChartPoint {
        x: point.parameter,
        y: quantity(point),
        text,
    }
}

/// A path cut where its solutions begin to behave otherwise.
fn parts(path: &Path, quantity: fn(&PathPoint) -> f64) -> Vec<Series> {
    let mut parts: Vec<Series> = Vec::new();
    for point in &path.points {
        let at = place(point, quantity, String::new());
        // A fold belongs to the side that the path comes from.
        let style = match (point.kind, parts.last()) {
            (PointKind::Fold, Some(part)) => part.style,
            _ => style_of(point),
        };
        match parts.last_mut() {
            Some(part) if part.style == style => part.points.push(at),
            last => {
                let before = last.and_then(|part| part.points.last().cloned());
                let points = before.into_iter().chain([at]).collect();
                parts.push(Series::of_path(style, points));
            }
        }
    }
    parts
}

fn style_of(point: &PathPoint) -> SeriesStyle {
    if point.determinant < 0 {
        SeriesStyle::NegativeDeterminant
    } else if point.is_attracting() {
        SeriesStyle::Attracting
    } else {
        SeriesStyle::Repelling
    }
}

fn marks(path: &Path, quantity: fn(&PathPoint) -> f64) -> Vec<Series> {
    let last = path.points.len().saturating_sub(1);
    let points = path.points.iter().enumerate().filter_map(|(k, point)| {
        let style = match point.kind {
            PointKind::Fold | PointKind::KinkFold => SeriesStyle::Fold,
            PointKind::Kink => SeriesStyle::Kink,
            PointKind::BranchPoint => SeriesStyle::BranchPoint,
            PointKind::End if k == last && path.end != PathEnd::Range => SeriesStyle::End,
            PointKind::Start | PointKind::Regular | PointKind::End => return None,
        };
        let text = format!("{} {:.9e}", point.kind.word(), point.parameter);
        let point = place(point, quantity, text);
        Some(Series::of_path(style, vec![point]))
    });
    points.collect()
}
