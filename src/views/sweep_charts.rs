//! What varies in a sweep.

use plots::{AxisScale, ChartAxis, ChartPoint, LineChart, Series};
use units::Unit;

use super::{charts::logarithmic, sweep_table::SweepTable};

/// Results worth a chart: column, quantity.
const RESULTS: [(&str, &str); 17] = [
    ("normal_force", "normal contact force"),
    ("tangential_force_1", "tangential contact force along t1"),
    ("tangential_force_2", "tangential contact force along t2"),
    ("open", "open panes"),
    ("stick", "sticking panes"),
    ("slip", "slipping panes"),
    ("largest_pressure", "largest contact pressure"),
    ("largest_displacement_x", "largest |u_x|"),
    ("largest_displacement_y", "largest |u_y|"),
    ("largest_displacement_z", "largest |u_z|"),
    ("strain_energy", "strain energy"),
    ("accuracy", "relative error of the multipliers"),
    ("certificate_fixed_point", "distance to the fixed point"),
    ("outer_steps", "outer steps"),
    ("newton_steps", "Newton steps"),
    ("actions", "applications of the dual operator"),
    ("seconds", "time of the solve"),
];

/// Columns of positive values that span more than this factor are drawn by their logarithms.
const WIDE: f64 = 30.0;

/// A chart with the name of its column.
pub(super) struct SweepChart {
    pub(super) column: &'static str,
    pub(super) chart: LineChart,
}

/// The columns of all results that may be drawn.
pub(super) fn columns() -> impl Iterator<Item = &'static str> {
    RESULTS.iter().map(|(column, ..)| *column)
}

/// One chart for each result that varies, over the setting with the most different numbers; the
/// other varying settings tell the lines apart.
pub(super) fn charts(table: &SweepTable) -> Vec<SweepChart> {
    let settings = table.varying_settings();
    let most_values = settings
        .iter()
        .copied()
        .rev()
        .max_by_key(|&column| table.numbers(column).len());
    let Some(x) = most_values.filter(|&column| table.numbers(column).len() > 1) else {
        return Vec::new();
    };
    let lines = Lines::new(table, settings.into_iter().filter(|&c| c != x).collect());
    RESULTS
        .iter()
        .filter_map(|&(column, label)| {
            let y = table.column(column)?;
            let varies = table.numbers(y).len() > 1;
            varies.then(|| SweepChart {
                column,
                chart: chart(table, &lines, x, (y, label)),
            })
        })
        .collect()
}

/// The line that each row belongs to.
struct Lines {
    /// The settings that tell them apart.
    heading: String,
    /// One name a row.
    names: Vec<String>,
}

impl Lines {
    fn new(table: &SweepTable, settings: Vec<usize>) -> Self {
        let parts: Vec<Vec<String>> = settings.iter().map(|&c| table.names(c)).collect();
        let name = |row: usize| {
            let words: Vec<&str> = parts.iter().map(|names| names[row].as_str()).collect();
            words.join(" · ")
        };
        let keys: Vec<&str> = settings
            .iter()
            .map(|&c| last_words(&table.head[c]))
            .collect();
        Self {
            heading: keys.join(" · "),
            names: (0..table.rows.len()).map(name).collect(),
        }
    }
}

/// The end of a key, from its last word that is a name of its own in the scene.
fn last_words(key: &str) -> &str {
    let says_little = |word: &str| {
        ["value", "constant", "expression"].contains(&word) || word.parse::<usize>().is_ok()
    };
    let mut start = key.len();
    for word in key.rsplit('.') {
        start -= word.len();
        if !says_little(word) {
            break;
        }
        start = start.saturating_sub(1);
    }
    &key[start..]
}

fn chart(table: &SweepTable, lines: &Lines, x: usize, result: (usize, &str)) -> LineChart {
    let (y, label) = result;
    let unit = table.unit(&table.head[y]);
    let mut series: Vec<Series> = Vec::new();
    for (row, name) in lines.names.iter().enumerate() {
        let (Some(at), Some(value)) = (table.number(row, x), table.number(row, y)) else {
            continue;
        };
        let point = ChartPoint {
            x: at,
            y: value,
            text: format!(
                "{name}\n{} {at}\n{} {value}{}",
                table.head[x],
                table.head[y],
                unit.beside()
            ),
        };
        match series.iter_mut().find(|series| series.name == *name) {
            Some(series) => series.points.push(point),
            None => series.push(Series {
                name: name.clone(),
                points: vec![point],
            }),
        }
    }
    for series in &mut series {
        series.points.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
    LineChart {
        title: label.to_owned(),
        x: axis(&table.head[x], Unit::none(), &table.numbers(x)),
        y: axis(label, unit, &table.numbers(y)),
        legend: lines.heading.clone(),
        series,
    }
}

fn axis(label: &str, unit: Unit, values: &[f64]) -> ChartAxis {
    ChartAxis {
        scale: scale(values),
        ..logarithmic(label, unit)
    }
}

/// Logarithmic for positive numbers that span a wide range or whose ratios are more alike than
/// their differences.
fn scale(rising: &[f64]) -> AxisScale {
    let (Some(&low), Some(&high)) = (rising.first(), rising.last()) else {
        return AxisScale::Linear;
    };
    let spread = |step: fn(f64, f64) -> f64| {
        let steps = rising.windows(2).map(|pair| step(pair[0], pair[1]));
        let (least, most) = steps.fold((f64::INFINITY, 0.0_f64), |(a, b), s| (a.min(s), b.max(s)));
        most / least
    };
    let geometric = || spread(|a, b| (b / a).ln()) < 0.5 * spread(|a, b| b - a);
    if low > 0.0 && (high > WIDE * low || geometric()) {
        AxisScale::Logarithmic
    } else {
        AxisScale::Linear
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_decide_the_scale() {
        assert_eq!(scale(&[0.05, 0.1, 0.2, 0.4]), AxisScale::Logarithmic);
        assert_eq!(scale(&[0.1, 0.2, 0.3, 0.4]), AxisScale::Linear);
        assert_eq!(scale(&[1.0, 31.0]), AxisScale::Logarithmic);
        assert_eq!(scale(&[-1.0, 31.0]), AxisScale::Linear);
    }

    #[test]
    fn keys_are_named_by_their_ends() {
        assert_eq!(last_words("friction.coefficient_2"), "coefficient_2");
        assert_eq!(
            last_words("friction.coefficient_1.constant"),
            "coefficient_1.constant"
        );
        assert_eq!(last_words("traction.0.value"), "traction.0.value");
        assert_eq!(last_words("title"), "title");
    }
}
