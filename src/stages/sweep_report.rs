//! The report of a sweep: its table, and charts of what varies in it.

use std::path::Path;

use super::{StageError, charts::logarithmic, report::footer};
use crate::{
    figures::{AxisScale, ChartAxis, ChartPoint, LineChart, Series},
    report::{Page, Part, Section, Table},
};

/// The table of a sweep's folder.
const SUMMARY: &str = "summary.csv";

/// The column that parts settings, before it, from results, after it.
const STATUS: &str = "status";

/// Most charts on a page.
const MOST_CHARTS: usize = 8;

/// Columns of positive values that span more than this factor are drawn by their logarithms.
const WIDE: f64 = 30.0;

/// The page of a folder with a `summary.csv`: the column `id`, settings, `status`, results.
///
/// # Errors
/// A folder without that table, or one that is no table.
pub(super) fn page(folder: &Path) -> Result<Page, StageError> {
    let summary = Summary::read(&folder.join(SUMMARY))?;
    let charts = summary.charts();
    let mut sections = vec![Section {
        name: "summary",
        heading: "Runs".into(),
        parts: vec![Part::Table(Table {
            caption: String::new(),
            head: summary.head.clone(),
            rows: summary.rows.clone(),
        })],
    }];
    if !charts.is_empty() {
        sections.push(Section {
            name: "charts",
            heading: "What varies".into(),
            parts: charts.iter().map(|c| Part::Figure(c.svg())).collect(),
        });
    }
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    Ok(Page {
        title: format!("Sweep {name}"),
        subtitle: format!("{} runs", summary.rows.len()),
        footer: footer(folder),
        sections,
    })
}

/// A table of texts, every row as long as the head.
struct Summary {
    head: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Summary {
    fn read(path: &Path) -> Result<Self, StageError> {
        let refuse = |error: csv::Error| StageError::Sweep {
            file: path.to_owned(),
            reason: error.to_string(),
        };
        let mut reader = csv::Reader::from_path(path).map_err(refuse)?;
        let head = reader.headers().map_err(refuse)?;
        let head = head.iter().map(str::to_owned).collect();
        let rows = reader.records().map(|record| {
            let record = record.map_err(refuse)?;
            Ok(record.iter().map(str::to_owned).collect())
        });
        Ok(Self {
            head,
            rows: rows.collect::<Result<_, StageError>>()?,
        })
    }

    fn number(&self, row: usize, column: usize) -> Option<f64> {
        let value: f64 = self.rows[row][column].trim().parse().ok()?;
        value.is_finite().then_some(value)
    }

    /// Whether a column has two different numbers, and nothing else but gaps.
    fn is_varying_number(&self, column: usize) -> bool {
        let texts = self.rows.iter().map(|row| row[column].trim());
        let readable = texts.filter(|text| !text.is_empty());
        let all_numbers = readable.clone().all(|text| text.parse::<f64>().is_ok());
        let values: Vec<f64> = (0..self.rows.len())
            .filter_map(|row| self.number(row, column))
            .collect();
        all_numbers && values.iter().any(|value| *value != values[0])
    }

    fn varies(&self, column: usize) -> bool {
        self.rows
            .iter()
            .any(|row| row[column] != self.rows[0][column])
    }

    /// One chart per varying result, over the first varying number among the settings; the other
    /// varying settings tell the lines apart.
    fn charts(&self) -> Vec<LineChart> {
        let Some(status) = self.head.iter().position(|name| name == STATUS) else {
            return Vec::new();
        };
        let settings: Vec<usize> = (0..status)
            .filter(|&column| self.head[column] != "id" && self.varies(column))
            .collect();
        let mut numbers = settings.iter().copied();
        let Some(x) = numbers.find(|&column| self.is_varying_number(column)) else {
            return Vec::new();
        };
        let others: Vec<usize> = settings.into_iter().filter(|&c| c != x).collect();
        (status + 1..self.head.len())
            .filter(|&column| self.is_varying_number(column))
            .take(MOST_CHARTS)
            .map(|y| self.chart(x, y, &others))
            .collect()
    }

    fn chart(&self, x: usize, y: usize, others: &[usize]) -> LineChart {
        let mut series: Vec<Series> = Vec::new();
        for (number, row) in self.rows.iter().enumerate() {
            let (Some(at), Some(value)) = (self.number(number, x), self.number(number, y)) else {
                continue;
            };
            let setting = |&c: &usize| format!("{} {}", self.head[c], row[c]);
            let name = others.iter().map(setting).collect::<Vec<_>>().join(", ");
            let point = ChartPoint {
                x: at,
                y: value,
                text: format!("{name} {} {at}: {} {value}", self.head[x], self.head[y]),
            };
            match series.iter_mut().find(|series| series.name == name) {
                Some(series) => series.points.push(point),
                None => series.push(Series {
                    name,
                    points: vec![point],
                }),
            }
        }
        for series in &mut series {
            series.points.sort_by(|a, b| a.x.total_cmp(&b.x));
        }
        LineChart {
            title: format!("{} over {}", self.head[y], self.head[x]),
            x: self.axis(x),
            y: self.axis(y),
            series,
        }
    }

    fn axis(&self, column: usize) -> ChartAxis {
        let values = (0..self.rows.len()).filter_map(|row| self.number(row, column));
        let low = values.clone().fold(f64::INFINITY, f64::min);
        let high = values.fold(f64::NEG_INFINITY, f64::max);
        ChartAxis {
            scale: if low > 0.0 && high > WIDE * low {
                AxisScale::Logarithmic
            } else {
                AxisScale::Linear
            },
            ..logarithmic(&self.head[column])
        }
    }
}
