//! What the charts show.

use std::path::PathBuf;

use contact3d::{adaptation::AdaptiveLevel, solver::Solution};
use plots::{Chart, ChartAxis, ChartPoint, Series};
use studies::accuracy::{Accuracy, AlgebraicStudy, DiscretisationStudy, Level, SolverRun};
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
) -> Result<Vec<PathBuf>, StageError> {
    let algebraic = accuracy.algebraic.as_ref().map(work_precision);
    // The finest mesh is what the others are compared with, and one point is no line.
    let nested = accuracy.discretisation.as_ref();
    let discretisation = nested
        .filter(|study| study.levels.len() > 2)
        .map(convergence);
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
    format!("{}, {}", entry.method, entry.operator)
}

/// Errors of the meshes against n_div.
pub(super) fn convergence(study: &DiscretisationStudy) -> Chart {
    let levels = &study.levels;
    let points = |value: &dyn Fn(&Level) -> Option<f64>| -> Vec<ChartPoint> {
        let values = levels
            .iter()
            .filter_map(|level| Some((level, value(level)?)));
        let point = |(level, error): (&Level, f64)| ChartPoint {
            x: level.n_div as f64,
            y: error,
            text: format!("n_div {}: {error:.3e}", level.n_div),
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
    let n_div = ChartAxis::logarithmic("n_div", Unit::none());
    let n_div = n_div.with_ticks(levels.iter().map(|level| level.n_div as f64));
    let error = ChartAxis::logarithmic("relative error", Unit::none());
    Chart::new("Discretisation error", n_div, error, series)
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
