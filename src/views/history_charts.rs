//! The charts of a load history: loops of friction, force and displacement, energies.

use contact3d::history::StepRecord;
use plots::{Chart, ChartAxis, ChartPoint, Series};
use units::{Dimension, Units};

use crate::report::shown_time;

/// Names of the pictures.
const FRICTION_LOOP: &str = "friction_loop";
const FORCE_DISPLACEMENT: &str = "force_displacement";
const ENERGIES: &str = "energies";

/// Those that a run with a load history may have.
pub(super) const HISTORY: [&str; 3] = [FRICTION_LOOP, FORCE_DISPLACEMENT, ENERGIES];

/// A force or an energy that is this share of the largest, or less, is none.
const NEGLIGIBLE: f64 = 1e-9;

/// The charts with their names; none of what does not happen.
pub(super) fn charts(
    records: &[StepRecord],
    units: Units,
) -> impl Iterator<Item = (&'static str, Chart)> {
    let records = StepRecord::solved(records);
    let all = [
        (FRICTION_LOOP, friction_loop(records, units)),
        (FORCE_DISPLACEMENT, force_displacement(records, units)),
        (ENERGIES, energies(records, units)),
    ];
    let has_points = |chart: &Chart| !chart.series.is_empty();
    all.into_iter().filter(move |(_, chart)| has_points(chart))
}

/// The friction force on the body over the mean tangential displacement of its face against what it touches.
fn friction_loop(records: &[StepRecord], units: Units) -> Chart {
    let series = [0, 1].into_iter().filter_map(|k| {
        let name = format!("along t{}", k + 1);
        let at = |record: &StepRecord| {
            [
                record.contact_displacement[k],
                -record.multiplier_force[k + 1],
            ]
        };
        series(&name, records, largest_force(records), at)
    });
    Chart::new(
        "Friction and slip of the contact face",
        ChartAxis::linear(
            "mean slip of the contact face against its foundation",
            units.of(Dimension::LENGTH),
        ),
        ChartAxis::linear("friction force on the body", units.of(Dimension::FORCE)),
        series,
    )
}

/// The force of loads and moving clamps over the mean displacement of their faces, along directions in which something happens: loads
/// that are held, and directions that hardly move, are left out beside them.
fn force_displacement(records: &[StepRecord], units: Units) -> Chart {
    let span = |values: &mut dyn Iterator<Item = f64>| {
        let ends = |[low, high]: [f64; 2], value: f64| [low.min(value), high.max(value)];
        let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], ends);
        high - low
    };
    let ways = [0, 1, 2].map(|c| span(&mut records.iter().map(|r| r.loaded_displacement[c])));
    let farthest = ways.into_iter().fold(0.0, f64::max);
    let happens = |c: &usize| {
        let forces = span(&mut records.iter().map(|r| r.loaded_force[*c]));
        // A direction that moves by this share of the farthest one, or less, hardly moves.
        forces > NEGLIGIBLE * largest_force(records) && ways[*c] > 0.01 * farthest
    };
    let mut directions: Vec<usize> = (0..3).filter(happens).collect();
    if directions.is_empty() {
        directions = vec![0, 1, 2];
    }
    let series = directions.into_iter().filter_map(|c| {
        let name = format!("along {}", ["x", "y", "z"][c]);
        let at = |record: &StepRecord| [record.loaded_displacement[c], record.loaded_force[c]];
        series(&name, records, largest_force(records), at)
    });
    let force = "force of loads and moving clamps";
    Chart::new(
        "Force and displacement of the loaded faces",
        ChartAxis::linear(
            "mean displacement of all loaded faces",
            units.of(Dimension::LENGTH),
        ),
        ChartAxis::linear(force, units.of(Dimension::FORCE)),
        series,
    )
}

/// Energies over time, works summed up.
fn energies(records: &[StepRecord], units: Units) -> Chart {
    let names = [
        "work of loads",
        "friction took",
        "normal work",
        "energy imbalance",
    ];
    let sums: [fn(&StepRecord) -> f64; 4] = [
        |record| record.energies.load_work,
        |record| record.energies.dissipation,
        |record| record.energies.normal_work,
        |record| record.energies.imbalance,
    ];
    let energy = |record: &StepRecord| record.energies.strain.abs();
    let largest = records.iter().map(energy).fold(0.0, f64::max);
    let strain = |record: &StepRecord| [record.increment.time, record.energies.strain];
    let mut all = vec![series("strain energy", records, 0.0, strain)];
    for (name, energy) in names.into_iter().zip(sums) {
        let mut sum = 0.0;
        // Sums of roundings are not drawn.
        let sums = |record: &StepRecord| {
            sum += energy(record);
            [record.increment.time, sum]
        };
        all.push(series(name, records, largest, sums));
    }
    let time = ChartAxis::linear("time", Units::SI.of(Dimension::Time));
    let energy = ChartAxis::linear("energy", units.of(Dimension::Energy));
    Chart::new("Energies", time, energy, all.into_iter().flatten())
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
    name: &str,
    records: &[StepRecord],
    scale: f64,
    at: impl FnMut(&StepRecord) -> [f64; 2],
) -> Option<Series> {
    let points: Vec<[f64; 2]> = records.iter().map(at).collect();
    let largest = points
        .iter()
        .fold(0.0_f64, |most, [_, y]| most.max(y.abs()));
    if largest <= NEGLIGIBLE * scale {
        return None;
    }
    let origin = ChartPoint {
        x: 0.0,
        y: 0.0,
        text: "before the first step".to_owned(),
    };
    let points = records
        .iter()
        .zip(points)
        .map(|(record, [x, y])| ChartPoint {
            x,
            y,
            text: format!(
                "step {}, increment {}, t = {}: {x:.4e}, {y:.4e}",
                record.increment.step + 1,
                record.increment.number,
                shown_time(record.increment.time)
            ),
        });
    Some(Series::new(name, [origin].into_iter().chain(points)))
}
