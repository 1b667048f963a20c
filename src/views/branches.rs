//! The diagrams of paths of solutions.

use contact3d::scene::unit_of_key;
use std::path::PathBuf;

use plots::{BranchDiagram, ChartAxis, Curve, CurveKind, Mark, MarkKind, Picture};
use studies::branches::{Branches, Path, PathEnd, PathPoint, PointKind};
use units::{Dimension, Units};

use super::PictureFolder;
use crate::{pipeline::StageError, report::branches::kind_words};

/// Width in pixels.
const WIDTH: u32 = 1720;

/// Names of the pictures.
const NORMAL: &str = "branches_normal_force";
const TANGENTIAL: &str = "branches_tangential_force";

/// Those of `branches`.
pub(super) const BRANCHES: [&str; 2] = [NORMAL, TANGENTIAL];

/// Draws the normal and the first tangential force over the parameter as SVG and PNG; returns the files.
pub fn draw_branches(
    folder: &PictureFolder,
    branches: &Branches,
    units: Units,
) -> Result<Vec<PathBuf>, StageError> {
    let [normal, tangential] = diagrams(branches, units);
    folder.save([(NORMAL, normal, WIDTH), (TANGENTIAL, tangential, WIDTH)])
}

/// The normal and the first tangential force over the parameter.
pub(super) fn diagrams(branches: &Branches, units: Units) -> [Picture; 2] {
    type Quantity = fn(&PathPoint) -> f64;
    let quantities: [(&str, Quantity); 2] = [
        ("normal contact force", |point| point.normal_force),
        ("tangential multiplier force along t1", |point| {
            point.tangential_force[0]
        }),
    ];
    quantities.map(|(label, quantity)| diagram(branches, units, label, quantity).figure())
}

fn diagram(
    branches: &Branches,
    units: Units,
    label: &str,
    quantity: fn(&PathPoint) -> f64,
) -> BranchDiagram {
    let along = if branches.range.is_logarithmic() && branches.range.from > 0.0 {
        ChartAxis::logarithmic
    } else {
        ChartAxis::linear
    };
    let paths = || branches.paths.iter();
    BranchDiagram {
        title: format!("Solutions over {}", branches.range.key),
        x: along(&branches.range.key, unit_of_key(&branches.range.key, units)),
        y: ChartAxis::linear(label, units.of(Dimension::FORCE)),
        curves: paths().flat_map(|path| curves(path, quantity)).collect(),
        marks: paths().flat_map(|path| marks(path, quantity)).collect(),
    }
}

/// A path cut where its solutions begin to behave otherwise.
fn curves(path: &Path, quantity: fn(&PathPoint) -> f64) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    let mut last: Option<[f64; 2]> = None;
    for point in &path.points {
        let at = [point.parameter, quantity(point)];
        // A fold belongs to the side that the path comes from.
        let kind = match (point.kind, curves.last()) {
            (PointKind::Fold, Some(curve)) => curve.kind,
            _ => kind_of(point),
        };
        match curves.last_mut() {
            Some(curve) if curve.kind == kind => curve.points.push(at),
            _ => curves.push(Curve {
                kind,
                points: last.into_iter().chain([at]).collect(),
            }),
        }
        last = Some(at);
    }
    curves
}

fn kind_of(point: &PathPoint) -> CurveKind {
    if point.determinant < 0 {
        CurveKind::NegativeDeterminant
    } else if point.is_attracting() {
        CurveKind::Attracting
    } else {
        CurveKind::Repelling
    }
}

fn marks(path: &Path, quantity: fn(&PathPoint) -> f64) -> Vec<Mark> {
    let last = path.points.len().saturating_sub(1);
    let points = path.points.iter().enumerate().filter_map(|(k, point)| {
        let kind = match point.kind {
            PointKind::Fold | PointKind::KinkFold => MarkKind::Fold,
            PointKind::Kink => MarkKind::Kink,
            PointKind::BranchPoint => MarkKind::BranchPoint,
            PointKind::End if k == last && path.end != Some(PathEnd::Range) => MarkKind::End,
            PointKind::Start | PointKind::Regular | PointKind::End => return None,
        };
        let text = format!("{} {:.9e}", kind_words(point.kind), point.parameter);
        Some(Mark {
            kind,
            at: [point.parameter, quantity(point)],
            text,
        })
    });
    points.collect()
}
