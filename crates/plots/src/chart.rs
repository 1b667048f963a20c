//! Charts of lines and marks with linear or logarithmic axes, a legend, and values that show when pointed at.

use units::Unit;

use super::{
    axis::{Axis, AxisScale, PlotFrame},
    canvas::{Anchor, Canvas, Colour, Fill, Point, Stroke},
    layout::{RIGHT_MARGIN, TICK_SIZE, TITLE_SIZE, titled_panel},
    picture::Picture,
    scale::bounds,
    text::{Label, fitted},
};

/// Width and height of a chart in pixels.
const CHART_SIZE: [f64; 2] = [860.0, 480.0];
/// Upper left corner of its plot.
const PLOT_CORNER: Point = [92.0, 48.0];
/// Room for the legend, and the height of an entry.
const LEGEND_WIDTH: f64 = 250.0;
const LEGEND_LINE: f64 = 22.0;
/// Radii of markers, and of those that are close to each other.
const MARKER_RADIUS: f64 = 4.2;
const SMALL_MARKER_RADIUS: f64 = 1.2;

/// The palette of M. Okabe and K. Ito, which people with colour-deficient sight can tell apart.
pub(super) const COLOURS: [Colour; 7] = [
    Colour(0x00, 0x72, 0xb2),
    Colour(0xd5, 0x5e, 0x00),
    Colour(0x00, 0x9e, 0x73),
    Colour(0xcc, 0x79, 0xa7),
    Colour(0xe6, 0x9f, 0x00),
    Colour(0x56, 0xb4, 0xe9),
    Colour(0x44, 0x44, 0x44),
];

/// One axis of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartAxis {
    /// Quantity.
    pub label: String,
    /// Its unit, which gets an SI prefix on a linear axis.
    pub unit: Unit,
    /// How values are placed.
    pub scale: AxisScale,
    /// Values to label; round ones when empty.
    pub ticks: Vec<f64>,
}

impl ChartAxis {
    /// A linear axis with round ticks.
    #[must_use]
    pub fn linear(label: &str, unit: Unit) -> Self {
        Self {
            label: label.to_owned(),
            unit,
            scale: AxisScale::Linear,
            ticks: Vec::new(),
        }
    }

    /// A logarithmic axis with round ticks.
    #[must_use]
    pub fn logarithmic(label: &str, unit: Unit) -> Self {
        Self {
            scale: AxisScale::Logarithmic,
            ..Self::linear(label, unit)
        }
    }

    /// The axis with these values labelled.
    #[must_use]
    pub fn with_ticks(self, ticks: impl IntoIterator<Item = f64>) -> Self {
        Self {
            ticks: ticks.into_iter().collect(),
            ..self
        }
    }

    /// Whether a value has a place on the axis.
    fn shows(&self, value: f64) -> bool {
        value.is_finite() && (self.scale == AxisScale::Linear || value > 0.0)
    }

    /// The axis over some values and a margin, of a length in pixels.
    fn over(&self, values: impl Iterator<Item = f64>, pixels: f64) -> Axis {
        let mut values = values.chain(self.ticks.iter().copied()).peekable();
        let (low, high) = match values.peek() {
            Some(_) => bounds(values),
            None => (1.0, 10.0),
        };
        let interval = match self.scale {
            AxisScale::Logarithmic => {
                let margin = (high / low).powf(0.05).max(1.2);
                [low / margin, high * margin]
            }
            AxisScale::Linear => {
                let span = (high - low).max(1e-3 * high.abs().max(low.abs()));
                let margin = if span > 0.0 { 0.05 * span } else { 1.0 };
                [low - margin, high + margin]
            }
        };
        let label = Label::plain(self.label.as_str());
        let quantity = (&label, &self.unit);
        // Most labelled decades of a logarithmic axis.
        let axis = Axis::new(self.scale, interval, quantity, pixels, 8);
        match self.ticks.as_slice() {
            [] => axis,
            ticks => axis.with_ticks(ticks),
        }
    }
}

/// One point of a series.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartPoint {
    /// Value along the horizontal axis.
    pub x: f64,
    /// Value along the vertical axis.
    pub y: f64,
    /// What it says when pointed at.
    pub text: String,
}

/// How a series looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeriesStyle {
    /// Markers joined by a line, in the colour of its number; those after the seventh repeat colours with other markers.
    Numbered,
    /// A part of a path of solutions to which successive approximations converge.
    Attracting,
    /// One to which they do not, and det R' > 0.
    Repelling,
    /// A part of a path with det R' < 0.
    NegativeDeterminant,
    /// Points at which the parameter turns back.
    Fold,
    /// Points at which panes or nodes change.
    Kink,
    /// Points at which paths meet.
    BranchPoint,
    /// Ends of paths inside the range.
    End,
}

/// Points of one style.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its name in the legend, where several of one name and style are one entry.
    pub name: String,
    /// How it looks.
    pub style: SeriesStyle,
    /// Points in the order of the line.
    pub points: Vec<ChartPoint>,
}

impl Series {
    /// Markers joined by a line.
    #[must_use]
    pub fn new(name: &str, points: impl IntoIterator<Item = ChartPoint>) -> Self {
        Self {
            name: name.to_owned(),
            style: SeriesStyle::Numbered,
            points: points.into_iter().collect(),
        }
    }

    /// A part of a path or marks on it.
    #[must_use]
    pub fn of_path(style: SeriesStyle, points: Vec<ChartPoint>) -> Self {
        let name = match style {
            SeriesStyle::Numbered => "",
            SeriesStyle::Attracting => "attracting, ρ(Ψ') < 1",
            SeriesStyle::Repelling => "not attracting, det R' > 0",
            SeriesStyle::NegativeDeterminant => "det R' < 0",
            SeriesStyle::Fold => "fold",
            SeriesStyle::Kink => "kink",
            SeriesStyle::BranchPoint => "branch point",
            SeriesStyle::End => "end inside the range",
        };
        Self {
            style,
            ..Self::new(name, points)
        }
    }
}

/// A chart of several series.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Title above the chart.
    pub title: String,
    /// Horizontal axis.
    pub x: ChartAxis,
    /// Vertical axis.
    pub y: ChartAxis,
    /// Heading of the legend; none when empty.
    pub legend: String,
    /// The series.
    pub series: Vec<Series>,
}

impl Chart {
    /// A chart of the series that have points.
    #[must_use]
    pub fn new(
        title: &str,
        x: ChartAxis,
        y: ChartAxis,
        series: impl IntoIterator<Item = Series>,
    ) -> Self {
        let series = series.into_iter();
        Self {
            title: title.to_owned(),
            x,
            y,
            legend: String::new(),
            series: series.filter(|series| !series.points.is_empty()).collect(),
        }
    }

    /// Draws the chart. Points that no axis can show are left out, and lines have gaps there; a cross below tells of a point without a
    /// value.
    #[must_use]
    pub fn figure(&self) -> Picture {
        let has_gaps = self
            .series
            .iter()
            .any(|series| series.points.iter().any(|p| p.y.is_nan()));
        let has_names = self.series.iter().any(|series| !series.name.is_empty());
        let has_legend = has_names || has_gaps;
        let [width, height] = CHART_SIZE;
        let right = width
            - if has_legend {
                LEGEND_WIDTH
            } else {
                RIGHT_MARGIN
            };
        let title = Label::plain(fitted(&self.title, TITLE_SIZE * 1.1, width - 32.0));
        let mut canvas = titled_panel(CHART_SIZE, &title);
        let [left, top] = PLOT_CORNER;
        // What is below the plot.
        let size = [right - left, height - 64.0 - top];
        let drawn = || self.series.iter().flat_map(|series| self.drawn(series));
        let all = self.series.iter().flat_map(|series| &series.points);
        let placed = all.filter(|p| self.x.shows(p.x) && (p.y.is_nan() || self.y.shows(p.y)));
        let x = self.x.over(placed.map(|point| point.x), size[0]);
        let y = self.y.over(drawn().map(|point| point.y), size[1]);
        let frame = PlotFrame {
            corner: PLOT_CORNER,
            size,
            axes: [x, y],
            has_grid: true,
        };
        frame.draw(&mut canvas, [19.0, 44.0], 24.0);
        for (number, series) in self.series.iter().enumerate() {
            let is_drawn = |p: &ChartPoint| self.x.shows(p.x) && self.y.shows(p.y);
            let parts = series.points.split(|point| !is_drawn(point));
            let parts: Vec<Vec<(Point, &str)>> = parts
                .map(|part| {
                    part.iter()
                        .map(|p: &ChartPoint| (frame.pixel([p.x, p.y]), p.text.as_str()))
                        .collect()
                })
                .collect();
            draw_series(&mut canvas, (series.style, number), &parts);
            let missing = series
                .points
                .iter()
                .filter(|p| p.y.is_nan() && self.x.shows(p.x));
            for point in missing {
                let [x, _] = frame.pixel([point.x, 0.0]);
                canvas.titled(&point.text, |canvas| {
                    SeriesStyle::End.mark(canvas, 0, [x, top + size[1]], MARKER_RADIUS)
                });
            }
        }
        if has_legend {
            self.draw_legend(&mut canvas, right + 16.0, has_gaps);
        }
        Picture::new(canvas, &self.title)
    }

    /// The points of a series that both axes can show.
    fn drawn<'a>(&self, series: &'a Series) -> impl Iterator<Item = &'a ChartPoint> {
        let points = series.points.iter();
        points.filter(|point| self.x.shows(point.x) && self.y.shows(point.y))
    }

    fn draw_legend(&self, canvas: &mut Canvas, x: f64, has_gaps: bool) {
        let mut y = PLOT_CORNER[1] + 14.0;
        let text = |canvas: &mut Canvas, words: &str, indent: f64, y: f64| {
            let label = Label::plain(fitted(words, TICK_SIZE, LEGEND_WIDTH - 28.0 - indent));
            let baseline = [x + indent, y + 0.36 * TICK_SIZE];
            canvas.text(baseline, &label, TICK_SIZE, Anchor::Start);
        };
        if !self.legend.is_empty() {
            text(canvas, &self.legend, 0.0, y);
            y += LEGEND_LINE;
        }
        for (number, series) in self.series.iter().enumerate() {
            let is_alike = |other: &Series| {
                series.style != SeriesStyle::Numbered && other.style == series.style
            };
            if series.name.is_empty() || self.series[..number].iter().any(is_alike) {
                continue;
            }
            if let Some(stroke) = series.style.line(number) {
                canvas.line([x, y], [x + 26.0, y], stroke);
            }
            let style = series.style;
            style.mark(canvas, number, [x + 13.0, y], MARKER_RADIUS);
            text(canvas, &series.name, 34.0, y);
            y += LEGEND_LINE;
        }
        if has_gaps {
            SeriesStyle::End.mark(canvas, 0, [x + 13.0, y], MARKER_RADIUS);
            text(canvas, "no solution", 34.0, y);
        }
    }
}

impl SeriesStyle {
    /// The line of the series with a number; `None` for special points.
    fn line(self, number: usize) -> Option<Stroke> {
        match self {
            Self::Numbered => Some(Stroke::solid(COLOURS[number % COLOURS.len()], 1.6)),
            Self::Attracting => Some(Stroke::solid(COLOURS[0], 2.0)),
            Self::Repelling => Some(Stroke::dashed(COLOURS[2], 1.8, 5.0)),
            Self::NegativeDeterminant => Some(Stroke::dashed(COLOURS[1], 1.8, 1.8)),
            Self::Fold | Self::Kink | Self::BranchPoint | Self::End => None,
        }
    }

    /// Draws a point of the series with a number: circle, square, triangle and diamond in turn, then hollow ones; nothing on paths.
    fn mark(self, canvas: &mut Canvas, number: usize, [x, y]: Point, radius: f64) {
        let edge = Some(Stroke::solid(Colour::BLACK, 1.0));
        let r = MARKER_RADIUS;
        match self {
            Self::Numbered => {
                let colour = COLOURS[number % COLOURS.len()];
                let (inside, rim) = match number / 4 % 2 {
                    0 => (colour, Colour::WHITE),
                    _ => (Colour::WHITE, colour),
                };
                let edge = Some(Stroke::solid(rim, 0.8 * radius / MARKER_RADIUS));
                let corners: &[Point] = match number % 4 {
                    0 => return canvas.ellipse([x, y], [radius; 2], Fill::Plain(inside), edge),
                    1 => &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
                    2 => &[[0.0, -1.2], [1.1, 0.8], [-1.1, 0.8]],
                    _ => &DIAMOND,
                };
                polygon(canvas, [x, y], radius, corners, inside, edge);
            }
            Self::Attracting | Self::Repelling | Self::NegativeDeterminant => {}
            Self::Fold => canvas.ellipse([x, y], [r; 2], Fill::Plain(Colour::WHITE), edge),
            Self::Kink => canvas.ellipse([x, y], [0.6 * r; 2], Fill::Plain(Colour::GREY), None),
            Self::BranchPoint => polygon(canvas, [x, y], r, &DIAMOND, Colour::BLACK, None),
            Self::End => {
                let black = Stroke::solid(Colour::BLACK, 1.6);
                canvas.line([x - r, y - r], [x + r, y + r], black);
                canvas.line([x - r, y + r], [x + r, y - r], black);
            }
        }
    }
}

fn draw_series(
    canvas: &mut Canvas,
    (style, number): (SeriesStyle, usize),
    parts: &[Vec<(Point, &str)>],
) {
    let points = || parts.iter().flatten();
    let line: Vec<Point> = points().map(|(point, _)| *point).collect();
    // Markers of many points get smaller, so that they hide neither each other nor other lines.
    let steps = line.windows(2).map(|ends| {
        let [[ax, ay], [bx, by]] = [ends[0], ends[1]];
        (bx - ax).hypot(by - ay)
    });
    let spacing = steps.sum::<f64>() / (line.len().max(2) - 1) as f64;
    let radius = if line.len() > 2 {
        MARKER_RADIUS.min((0.2 * spacing).max(SMALL_MARKER_RADIUS))
    } else {
        MARKER_RADIUS
    };
    let joined = parts.iter().filter(|part| part.len() > 1);
    let lines: Vec<Vec<Point>> = joined
        .map(|part| part.iter().map(|(point, _)| *point).collect())
        .collect();
    if let Some(stroke) = style.line(number).filter(|_| !lines.is_empty()) {
        canvas.polylines(&lines, stroke);
    }
    let is_path = style != SeriesStyle::Numbered && style.line(number).is_some();
    for (point, text) in points().filter(|_| !is_path) {
        canvas.titled(text, |canvas| style.mark(canvas, number, *point, radius));
    }
}

const DIAMOND: [Point; 4] = [[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]];

fn polygon(
    canvas: &mut Canvas,
    [x, y]: Point,
    radius: f64,
    corners: &[Point],
    colour: Colour,
    edge: Option<Stroke>,
) {
    let corners = corners
        .iter()
        .map(|[a, b]| [x + a * radius, y + b * radius]);
    canvas.region(&[corners.collect()], Fill::Plain(colour), edge);
}
