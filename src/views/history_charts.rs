//! The charts of a load history: loops of friction, force and displacement, energies.

use std::path::PathBuf;

use contact3d::history::StepRecord;
use plots::{AxisScale, ChartAxis, ChartPoint, LineChart, Series};
use units::{Dimension, Unit, Units};

use super::PictureFolder;
use crate::pipeline::StageError;

/// Names of the pictures.
const FRICTION_LOOP: &str = "friction_loop";
const FORCE_DISPLACEMENT: &str = "force_displacement";
const ENERGIES: &str = "energies";

/// Those that a run with a load history may have.
pub(super) const HISTORY: [&str; 3] = [FRICTION_LOOP, FORCE_DISPLACEMENT, ENERGIES];

/// A force or an energy that is this share of the largest, or less, is none.
const NEGLIGIBLE: f64 = 1e-9;

/// Draws the charts of a history as SVG and PNG; returns the files.
///
/// # Errors
/// A folder that cannot be written.
pub(super) fn draw(
    folder: &PictureFolder,
    records: &[StepRecord],
    units: Units,
) -> Result<Vec<PathBuf>, StageError> {
    folder.save_charts(charts(records, units))
}

/// The charts with their names; none of what does not happen.
pub(super) fn charts(
    records: &[StepRecord],
    units: Units,
) -> impl Iterator<Item = (&'static str, LineChart)> {
    let all = [
        (FRICTION_LOOP, friction_loop(records, units)),
        (FORCE_DISPLACEMENT, force_displacement(records, units)),
        (ENERGIES, energies(records, units)),
    ];
    let has_points = |chart: &LineChart| !chart.series.is_empty();
    all.into_iter().filter(move |(_, chart)| has_points(chart))
}

/// The tangential force on the face over its mean tangential displacement.
fn friction_loop(records: &[StepRecord], units: Units) -> LineChart {
    let series = [0, 1].into_iter().filter_map(|k| {
        let name = format!("along t{}", k + 1);
        let at = |record: &StepRecord| {
            [
                record.contact_displacement[k],
                record.multiplier_force[k + 1],
            ]
        };
        series(name, records, largest_force(records), at)
    });
    LineChart {
        title: "Friction and displacement of the contact face".to_owned(),
        x: axis("mean tangential displacement", units.of(Dimension::LENGTH)),
        y: axis("tangential multiplier force", units.of(Dimension::FORCE)),
        legend: String::new(),
        series: series.collect(),
    }
}

/// The force of loads and moving clamps over the mean displacement of their faces.
fn force_displacement(records: &[StepRecord], units: Units) -> LineChart {
    let series = [0, 1, 2].into_iter().filter_map(|c| {
        let name = format!("along {}", ["x", "y", "z"][c]);
        let at = |record: &StepRecord| [record.loaded_displacement[c], record.loaded_force[c]];
        series(name, records, largest_force(records), at)
    });
    LineChart {
        title: "Force and displacement of the loaded faces".to_owned(),
        x: axis("mean displacement", units.of(Dimension::LENGTH)),
        y: axis(
            "force of loads and moving clamps",
            units.of(Dimension::FORCE),
        ),
        legend: String::new(),
        series: series.collect(),
    }
}

/// Energies over time, works summed up.
fn energies(records: &[StepRecord], units: Units) -> LineChart {
    type Energy = fn(&StepRecord) -> f64;
    let sums: [(&str, Energy); 4] = [
        ("work of the loads", |record| record.energies.load_work),
        ("dissipated", |record| record.energies.dissipation),
        ("work on the foundation", |record| {
            record.energies.normal_work
        }),
        ("missing", |record| record.energies.imbalance),
    ];
    let energy = |record: &StepRecord| record.energies.strain.abs();
    let largest = records.iter().map(energy).fold(0.0, f64::max);
    let strain = |record: &StepRecord| [record.increment.time, record.energies.strain];
    let mut all = vec![series("strain energy".to_owned(), records, 0.0, strain)];
    for (name, energy) in sums {
        let mut sum = 0.0;
        let points = records.iter().map(|record| {
            sum += energy(record);
            [record.increment.time, sum]
        });
        let points: Vec<[f64; 2]> = points.collect();
        // Sums of roundings are not drawn.
        let size = points
            .iter()
            .fold(0.0_f64, |most, [_, y]| most.max(y.abs()));
        if size > NEGLIGIBLE * largest {
            all.push(Some(line(name.to_owned(), records, &points)));
        }
    }
    LineChart {
        title: "Energies".to_owned(),
        x: axis("time", Units::SI.of(Dimension::Time)),
        y: axis("energy", units.of(Dimension::Energy)),
        legend: String::new(),
        series: all.into_iter().flatten().collect(),
    }
}

/// The largest force of any kind, in N.
fn largest_force(records: &[StepRecord]) -> f64 {
    let forces = records.iter().flat_map(|record| {
        [record.loaded_force, record.multiplier_force]
            .concat()
            .into_iter()
    });
    forces.fold(0.0, |most, force| most.max(force.abs()))
}

/// A line from the origin through all increments; `None` where the ordinate vanishes beside `scale`.
fn series(
    name: String,
    records: &[StepRecord],
    scale: f64,
    at: impl Fn(&StepRecord) -> [f64; 2],
) -> Option<Series> {
    let points: Vec<[f64; 2]> = records.iter().map(at).collect();
    let largest = points
        .iter()
        .fold(0.0_f64, |most, [_, y]| most.max(y.abs()));
    (largest > NEGLIGIBLE * scale).then(|| line(name, records, &points))
}

fn line(name: String, records: &[StepRecord], points: &[[f64; 2]]) -> Series {
    let origin = ChartPoint {
        x: 0.0,
        y: 0.0,
        text: "before the first step".to_owned(),
    };
    let points = records
        .iter()
        .zip(points)
        .map(|(record, [x, y])| ChartPoint {
            x: *x,
            y: *y,
            text: format!(
                "step {}, increment {}, t = {}: {x:.4e}, {y:.4e}",
                record.increment.step + 1,
                record.increment.number,
                record.increment.time
            ),
        });
    Series {
        name,
        points: [origin].into_iter().chain(points).collect(),
    }
}

fn axis(label: &str, unit: Unit) -> ChartAxis {
    ChartAxis {
        label: label.to_owned(),
        unit,
        scale: AxisScale::Linear,
        ticks: Vec::new(),
    }
}
