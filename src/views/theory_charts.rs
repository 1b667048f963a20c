//! The diagrams of the theory.

use std::path::PathBuf;

use plots::{ChartAxis, ChartPoint, LineChart, Series};
use studies::theory::{ScaledPoint, Theory, TheoryLevel};
use units::{Dimension, Unit, Units};

use super::PictureFolder;
use crate::pipeline::StageError;

/// Names of the pictures.
const THRESHOLDS: &str = "theory_thresholds";
const SCALED: &str = "theory_scaled_law";
const CONSTANTS: &str = "theory_constants";
pub(super) const NAMES: [&str; 3] = [THRESHOLDS, SCALED, CONSTANTS];

/// Draws thresholds against H, the contraction against the scale of the law, and the constants against H, as SVG and PNG.
pub fn draw_theory(
    folder: &PictureFolder,
    theory: &Theory,
    units: Units,
) -> Result<Vec<PathBuf>, StageError> {
    folder.save_charts([
        (THRESHOLDS, thresholds(theory, units)),
        (SCALED, scaled(theory)),
        (CONSTANTS, constants(theory, units)),
    ])
}

/// H of the meshes.
fn pane_axis(levels: &[TheoryLevel], units: Units) -> ChartAxis {
    let axis = ChartAxis::logarithmic("diameter H of a pane", units.of(Dimension::LENGTH));
    axis.with_ticks(levels.iter().map(|level| level.face.pane_size))
}

/// A figure of each mesh where it is positive and finite.
fn against_pane(
    levels: &[TheoryLevel],
    name: &str,
    figure: impl Fn(&TheoryLevel) -> f64,
) -> Series {
    let points = levels.iter().filter_map(|level| {
        let value = figure(level);
        (value > 0.0 && value.is_finite()).then(|| ChartPoint {
            x: level.face.pane_size,
            y: value,
            text: match level.n_div {
                0 => format!("{name}, {} unknowns: {value:.3e}", level.n_free),
                n_div => format!("{name}, n_div {n_div}: {value:.3e}"),
            },
        })
    });
    Series::new(name, points)
}

/// A power of the mesh size through the finest value of another series.
fn guide(
    levels: &[TheoryLevel],
    name: &str,
    through: &Series,
    size: impl Fn(&TheoryLevel) -> f64,
) -> Series {
    let Some((last, point)) = levels.last().zip(through.points.last()) else {
        return Series::new(name, []);
    };
    against_pane(levels, name, |level| point.y * size(level) / size(last))
}

/// Scales of the law at which each bound and each truth reaches 1, against H, with √H and √(hH).
pub(super) fn thresholds(theory: &Theory, units: Units) -> LineChart {
    let levels = &theory.levels;
    let limit = |scale: Option<f64>| scale.unwrap_or(f64::NAN);
    let weighted = against_pane(levels, "q = 1, energy norm", |l| l.thresholds.weighted[1]);
    let root = guide(levels, "like √H", &weighted, |l| l.face.pane_size.sqrt());
    let roots = guide(levels, "like √(hH)", &weighted, |l| {
        (l.face.pane_size * l.face.triangle_size).sqrt()
    });
    let series = [
        against_pane(levels, "spectral radius = 1", |l| {
            limit(l.thresholds.spectral_radius)
        }),
        against_pane(levels, "det R\u{2032} = 0", |l| {
            limit(l.thresholds.singular)
        }),
        against_pane(levels, "norm of \u{3a8}\u{2032} = 1", |l| {
            limit(l.thresholds.norm[1])
        }),
        against_pane(levels, "q = 1, composed", |l| l.thresholds.sharp[1]),
        root,
        roots,
        against_pane(levels, "q = 1, H1 norm", |l| l.thresholds.weighted[0]),
        weighted,
    ];
    chart(
        "Where the scaled law reaches the limits of the theory",
        pane_axis(levels, units),
        "scale t of the law",
        series,
    )
}

/// Spectral radius and norm on the finest mesh against the scale of the law.
pub(super) fn scaled(theory: &Theory) -> LineChart {
    let points = theory.levels.last().map_or(&[][..], |level| &level.scaled);
    let line = |name: &str, figure: &dyn Fn(&ScaledPoint) -> f64| {
        // Rounding makes a spectral radius of some 1e-15 where all panes stick.
        let is_drawn = |point: &&ScaledPoint| point.solved && figure(point) > 1e-12;
        let points = points.iter().filter(is_drawn).map(|point| ChartPoint {
            x: point.scale,
            y: figure(point),
            text: format!("t = {:.3e}: {name} {:.3e}", point.scale, figure(point)),
        });
        Series::new(name, points)
    };
    let bound = theory
        .levels
        .last()
        .map_or(f64::NAN, |level| level.norms[1].bound.weighted);
    let series = [
        line("spectral radius of \u{3a8}\u{2032}", &|p| p.spectral_radius),
        line("norm of \u{3a8}\u{2032}, energy norm", &|p| p.norm[1]),
        line("norm of \u{3a8}\u{2032}, H1 norm", &|p| p.norm[0]),
        line("bound q, energy norm", &|p| p.scale * bound),
    ];
    chart(
        "Contraction for the law scaled by t, finest mesh",
        ChartAxis::logarithmic("scale t of the law", Unit::none()),
        "factor",
        series,
    )
}

/// The constants that should not depend on the mesh.
pub(super) fn constants(theory: &Theory, units: Units) -> LineChart {
    let levels = &theory.levels;
    let series = [
        against_pane(levels, "c_inv(1,0)", |l| l.face.inverse_first),
        against_pane(levels, "c_inv(\u{221e})", |l| l.face.inverse_fourth),
        against_pane(levels, "c_inv(0,\u{2212}1/2), H1", |l| {
            l.norms[0].inverse_half
        }),
        against_pane(levels, "c_tr(2), H1", |l| l.norms[0].trace.second),
        against_pane(levels, "c_tr(4), H1", |l| l.norms[0].trace.fourth),
        against_pane(levels, "c_r Lagrange", |l| l.face.lagrange_finer[2]),
        against_pane(levels, "c_r Cl\u{e9}ment", |l| l.face.clement_finer[2]),
        against_pane(levels, "c_r Lagrange on |Y|", |l| l.face.lagrange),
    ];
    chart(
        "Constants that should settle",
        pane_axis(levels, units),
        "constant",
        series,
    )
}

fn chart(
    title: &str,
    x: ChartAxis,
    y: &str,
    series: impl IntoIterator<Item = Series>,
) -> LineChart {
    LineChart::new(title, x, ChartAxis::logarithmic(y, Unit::none()), series)
}
