//! The diagrams of paths of solutions.

use std::path::PathBuf;

use contact3d::scene::unit_of_key;
use plots::{Chart, ChartAxis, ChartPoint, Series, SeriesStyle};
use studies::branches::{Branches, Path, PathEnd, PathPoint, PointKind};
use units::{Dimension, Units};

use super::PictureFolder;
use crate::{pipeline::StageError, report::branches::kind_words};

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
            PointKind::End if k == last && path.end != Some(PathEnd::Range) => SeriesStyle::End,
            PointKind::Start | PointKind::Regular | PointKind::End => return None,
        };
        let text = format!("{} {:.9e}", kind_words(point.kind), point.parameter);
        let point = place(point, quantity, text);
        Some(Series::of_path(style, vec![point]))
    });
    points.collect()
}
