//! Line charts with linear or logarithmic axes, a legend, and values that show when pointed at.

use std::slice;

use units::Unit;

use super::{
    canvas::{Anchor, Canvas, Colour, Fill, Point, Stroke},
    layout::{
        LABEL_SIZE, PANEL_WIDTH, PictureLayout, TICK_SIZE, TITLE_SIZE, fitting_ticks, titled_panel,
    },
    panes::PaneShape,
    picture::Picture,
    scale::{Ticks, UnitScale},
    svg::bounds,
    text::{Label, fitted},
};

pub(super) const WIDTH: f64 = 860.0;
pub(super) const HEIGHT: f64 = 480.0;
pub(super) const LEFT: f64 = 92.0;
pub(super) const TOP: f64 = 48.0;
pub(super) const BOTTOM: f64 = 64.0;
/// Room for the legend, and the margin without one.
pub(super) const LEGEND_WIDTH: f64 = 250.0;
const RIGHT_MARGIN: f64 = 28.0;
pub(super) const LEGEND_LINE: f64 = 22.0;
/// Radius of markers.
const MARKER: f64 = 4.2;
/// Radius of markers that are close to each other.
const LEAST_MARKER: f64 = 1.2;

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

/// How values are placed along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisScale {
    /// In proportion.
    Linear,
    /// By their logarithm; values that are not positive are left out.
    Logarithmic,
}

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

    /// Whether a value has a place on the axis.
    pub(super) fn shows(&self, value: f64) -> bool {
        value.is_finite() && (self.scale == AxisScale::Linear || value > 0.0)
    }

    /// The axis with these values labelled.
    #[must_use]
    pub fn with_ticks(self, ticks: impl IntoIterator<Item = f64>) -> Self {
        Self {
            ticks: ticks.into_iter().collect(),
            ..self
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

/// Points joined by a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Points in the order of the line.
    pub points: Vec<ChartPoint>,
}

impl Series {
    /// A line through points.
    #[must_use]
    pub fn new(name: &str, points: impl IntoIterator<Item = ChartPoint>) -> Self {
        Self {
            name: name.to_owned(),
            points: points.into_iter().collect(),
        }
    }
}

/// A chart of several series.
#[derive(Clone, Debug, PartialEq)]
pub struct LineChart {
    /// Title above the chart.
    pub title: String,
    /// Horizontal axis.
    pub x: ChartAxis,
    /// Vertical axis.
    pub y: ChartAxis,
    /// Heading of the legend; none when empty.
    pub legend: String,
    /// The series; those after the seventh repeat colours with other markers.
    pub series: Vec<Series>,
}

/// An axis with its interval and its place in pixels.
pub(super) struct PlacedAxis<'a> {
    axis: &'a ChartAxis,
    /// How the values of a linear axis are printed.
    unit: UnitScale,
    low: f64,
    high: f64,
    /// Pixels of `low` and `high`.
    pixels: [f64; 2],
}

impl LineChart {
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

    /// Draws the chart. Points that no axis can show are left out.
    #[must_use]
    pub fn figure(&self) -> Picture {
        let legend = self.series.iter().any(|series| !series.name.is_empty());
        let right = WIDTH - if legend { LEGEND_WIDTH } else { RIGHT_MARGIN };
        let mut canvas = titled_canvas(&self.title);
        let x = PlacedAxis::new(&self.x, self.drawn().map(|p| p.x), [LEFT, right]);
        let vertical = [HEIGHT - BOTTOM, TOP];
        let y = PlacedAxis::new(&self.y, self.drawn().map(|p| p.y), vertical);
        draw_frame(&mut canvas, &x, &y);
        for (number, series) in self.series.iter().enumerate() {
            let points = series.points.iter().filter(|p| self.is_drawn(p));
            let placed: Vec<(Point, &str)> = points
                .map(|p| ([x.pixel(p.x), y.pixel(p.y)], p.text.as_str()))
                .collect();
            draw_series(&mut canvas, number, &placed);
        }
        if legend {
            self.draw_legend(&mut canvas, right + 16.0);
        }
        Picture::new(canvas, &self.title)
    }

    fn draw_legend(&self, canvas: &mut Canvas, x: f64) {
        let mut y = TOP + 14.0;
        if !self.legend.is_empty() {
            let heading = Label::plain(fitted(&self.legend, TICK_SIZE, LEGEND_WIDTH - 24.0));
            let baseline = [x, y + 0.36 * TICK_SIZE];
            canvas.text(baseline, &heading, TICK_SIZE, Anchor::Start);
            y += LEGEND_LINE;
        }
        for (number, series) in self.series.iter().enumerate() {
            draw_entry(canvas, number, &series.name, [x, y]);
            y += LEGEND_LINE;
        }
    }

    fn is_drawn(&self, point: &ChartPoint) -> bool {
        self.x.shows(point.x) && self.y.shows(point.y)
    }

    fn drawn(&self) -> impl Iterator<Item = &ChartPoint> {
        let points = self.series.iter().flat_map(|series| &series.points);
        points.filter(|point| self.is_drawn(point))
    }
}

impl<'a> PlacedAxis<'a> {
    /// The interval of some values, with a margin.
    pub(super) fn new(
        axis: &'a ChartAxis,
        values: impl Iterator<Item = f64>,
        pixels: [f64; 2],
    ) -> Self {
        let mut values = values.chain(axis.ticks.iter().copied()).peekable();
        let (low, high) = match values.peek() {
            Some(_) => bounds(values),
            None => (1.0, 10.0),
        };
        let (low, high) = match axis.scale {
            AxisScale::Logarithmic => {
                let margin = (high / low).powf(0.05).max(1.2);
                (low / margin, high * margin)
            }
            AxisScale::Linear => {
                let span = (high - low).max(1e-3 * high.abs().max(low.abs()));
                let margin = if span > 0.0 { 0.05 * span } else { 1.0 };
                (low - margin, high + margin)
            }
        };
        Self {
            axis,
            unit: match axis.scale {
                AxisScale::Linear => UnitScale::new(high.abs().max(low.abs()), &axis.unit),
                AxisScale::Logarithmic => UnitScale::new(1.0, &axis.unit),
            },
            low,
            high,
            pixels,
        }
    }

    pub(super) fn pixel(&self, value: f64) -> f64 {
        let share = match self.axis.scale {
            AxisScale::Linear => (value - self.low) / (self.high - self.low),
            AxisScale::Logarithmic => (value / self.low).ln() / (self.high / self.low).ln(),
        };
        self.pixels[0] + share * (self.pixels[1] - self.pixels[0])
    }

    /// Quantity, unit and power of ten.
    fn title(&self) -> Label {
        self.unit.title(&Label::plain(self.axis.label.as_str()))
    }

    /// Labelled values with their labels, and values with a short tick only.
    fn ticks(&self) -> (Vec<(f64, Label)>, Vec<f64>) {
        let length = (self.pixels[1] - self.pixels[0]).abs();
        match (self.axis.scale, self.axis.ticks.as_slice()) {
            (AxisScale::Linear, []) => {
                let [low, high] = [self.low, self.high].map(|v| self.unit.scaled(v));
                let ticks: Ticks = fitting_ticks(low, high, length);
                let back = (self.high - self.low) / (high - low);
                let labels = ticks.values.iter();
                let labels = labels.map(|&v| (v * back, Label::plain(ticks.text(v))));
                (labels.collect(), Vec::new())
            }
            (AxisScale::Logarithmic, []) => {
                let (major, minor) = log_ticks(self.low, self.high, 8);
                let labels = major.into_iter().map(|v| (v, log_label(v)));
                (labels.collect(), minor)
            }
            (_, given) => {
                let labels = given.iter().map(|&v| (v, log_label(v)));
                (labels.collect(), Vec::new())
            }
        }
    }
}

/// An empty chart with its title.
pub(super) fn titled_canvas(title: &str) -> Canvas {
    let title = Label::plain(fitted(title, TITLE_SIZE * 1.1, WIDTH - 32.0));
    titled_panel([WIDTH, HEIGHT], &title)
}

/// The name of an entry of the legend whose line begins at a point.
pub(super) fn draw_name(canvas: &mut Canvas, name: &str, [x, y]: Point) {
    let label = Label::plain(fitted(name, TICK_SIZE, LEGEND_WIDTH - 62.0));
    let position = [x + 34.0, y + 0.36 * TICK_SIZE];
    canvas.text(position, &label, TICK_SIZE, Anchor::Start);
}

pub(super) fn draw_frame(canvas: &mut Canvas, x: &PlacedAxis<'_>, y: &PlacedAxis<'_>) {
    let grid = Stroke::solid(Colour(0xdd, 0xdd, 0xdd), 0.7);
    let faint = Stroke::solid(Colour(0xf0, 0xf0, 0xf0), 0.6);
    let [left, right] = x.pixels;
    let [bottom, top] = y.pixels;
    for (axis, [from, to], is_upright) in [(x, y.pixels, true), (y, x.pixels, false)] {
        let (major, minor) = axis.ticks();
        let line = |canvas: &mut Canvas, at: f64, stroke: Stroke| {
            let ends = [from, to].map(|end| if is_upright { [at, end] } else { [end, at] });
            canvas.line(ends[0], ends[1], stroke);
        };
        for value in minor {
            line(canvas, axis.pixel(value), faint);
        }
        for (value, label) in &major {
            let at = axis.pixel(*value);
            line(canvas, at, grid);
            let (position, anchor) = if is_upright {
                ([at, bottom + 19.0], Anchor::Middle)
            } else {
                ([left - 8.0, at + 0.36 * TICK_SIZE], Anchor::End)
            };
            canvas.text(position, label, TICK_SIZE, anchor);
        }
    }
    let frame = Stroke::solid(Colour::BLACK, 0.8);
    let size = [right - left, bottom - top];
    canvas.rectangle([left, top], size, Fill::Empty, Some(frame));
    let centre = [f64::midpoint(left, right), bottom + 44.0];
    canvas.text(centre, &x.title(), LABEL_SIZE, Anchor::Middle);
    let centre = [24.0, f64::midpoint(top, bottom)];
    canvas.vertical_text(centre, &y.title(), LABEL_SIZE);
}

fn colour(number: usize) -> Colour {
    COLOURS[number % COLOURS.len()]
}

fn draw_series(canvas: &mut Canvas, number: usize, points: &[(Point, &str)]) {
    let line: Vec<Point> = points.iter().map(|(point, _)| *point).collect();
    if line.len() > 1 {
        canvas.polylines(slice::from_ref(&line), Stroke::solid(colour(number), 1.6));
    }
    // Markers of many points get smaller, so that they hide neither each other nor other lines.
    let steps = line.windows(2).map(|ends| {
        let [[ax, ay], [bx, by]] = [ends[0], ends[1]];
        (bx - ax).hypot(by - ay)
    });
    let spacing = steps.sum::<f64>() / (line.len().max(2) - 1) as f64;
    let radius = if line.len() > 2 {
        MARKER.min((0.2 * spacing).max(LEAST_MARKER))
    } else {
        MARKER
    };
    for (point, text) in points {
        canvas.titled(text, |canvas| draw_marker(canvas, number, *point, radius));
    }
}

/// Circle, square, triangle, diamond, in turn.
fn draw_marker(canvas: &mut Canvas, number: usize, [x, y]: Point, r: f64) {
    let fill = Fill::Plain(colour(number));
    let edge = Some(Stroke::solid(Colour::WHITE, 0.8 * r / MARKER));
    let polygon = |canvas: &mut Canvas, corners: &[[f64; 2]]| {
        let corners = corners.iter().map(|[a, b]| [x + a * r, y + b * r]);
        canvas.region(&[corners.collect()], fill, edge);
    };
    match number % 4 {
        0 => canvas.ellipse([x, y], [r; 2], fill, edge),
        1 => polygon(
            canvas,
            &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
        ),
        2 => polygon(canvas, &[[0.0, -1.2], [1.1, 0.8], [-1.1, 0.8]]),
        _ => polygon(canvas, &[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]]),
    }
}

fn draw_entry(canvas: &mut Canvas, number: usize, name: &str, [x, y]: Point) {
    canvas.line([x, y], [x + 26.0, y], Stroke::solid(colour(number), 1.6));
    draw_marker(canvas, number, [x + 13.0, y], MARKER);
    draw_name(canvas, name, [x, y]);
}

pub(super) const TICK_LENGTH: f64 = 5.0;

/// The name of an axis and its ticks, as fractions of its length.
#[derive(Clone, Debug)]
pub(super) struct TickedAxis {
    pub(super) title: Label,
    pub(super) ticks: Vec<(f64, Label)>,
}

impl TickedAxis {
    /// An axis in proportion from `low` to `high`.
    pub(super) fn linear(title: Label, ticks: &Ticks, [low, high]: [f64; 2]) -> Self {
        let tick = |&v: &f64| ((v - low) / (high - low), Label::plain(ticks.text(v)));
        Self {
            title,
            ticks: ticks.values.iter().map(tick).collect(),
        }
    }

    /// Width of the widest tick label.
    pub(super) fn widest(&self) -> f64 {
        let widths = self.ticks.iter().map(|(_, label)| label.width(TICK_SIZE));
        widths.fold(0.0, f64::max)
    }
}

/// Draws a frame with ticks outside; `below` it are the baselines of the horizontal axis's tick labels and name, and the name
/// of the vertical axis is at `name_x`.
pub(super) fn draw_ticked_frame(
    canvas: &mut Canvas,
    (corner, size): (Point, Point),
    [horizontal, vertical]: &[TickedAxis; 2],
    below: [f64; 2],
    name_x: f64,
) {
    let ([left, top], [width, height]) = (corner, size);
    let bottom = top + height;
    let frame = Stroke::solid(Colour::BLACK, 0.8);
    canvas.rectangle(corner, size, Fill::Empty, Some(frame));
    for (fraction, label) in &horizontal.ticks {
        let x = left + fraction * width;
        canvas.line([x, bottom], [x, bottom + TICK_LENGTH], frame);
        canvas.text([x, bottom + below[0]], label, TICK_SIZE, Anchor::Middle);
    }
    for (fraction, label) in &vertical.ticks {
        let y = bottom - fraction * height;
        canvas.line([left, y], [left - TICK_LENGTH, y], frame);
        let position = [left - TICK_LENGTH - 4.0, y + 0.36 * TICK_SIZE];
        canvas.text(position, label, TICK_SIZE, Anchor::End);
    }
    let position = [left + width / 2.0, bottom + below[1]];
    canvas.text(position, &horizontal.title, LABEL_SIZE, Anchor::Middle);
    canvas.vertical_text([name_x, top + height / 2.0], &vertical.title, LABEL_SIZE);
}

/// Draws frame, ticks, labels and the note on stretching.
pub(super) fn draw_axes(canvas: &mut Canvas, layout: &PictureLayout) {
    let name_x = layout.corner[0] - (TICK_LENGTH + 14.0 + layout.axes[1].widest());
    let frame = (layout.corner, layout.size);
    draw_ticked_frame(canvas, frame, &layout.axes, [19.0, 37.0], name_x);
    if let Some(note) = &layout.note {
        let position = [PANEL_WIDTH - 16.0, 40.5];
        canvas.text(position, note, TICK_SIZE, Anchor::End);
    }
}

/// Draws every pane with its fill and the text it shows when pointed at, and thin outlines of the
/// given colour over all of them.
pub(super) fn draw_panes(
    canvas: &mut Canvas,
    layout: &PictureLayout,
    shapes: &[PaneShape],
    outline: Colour,
    fill: impl Fn(usize) -> Fill,
    hover: impl Fn(usize) -> String,
) {
    let mut outlines = Vec::new();
    for shape in shapes {
        let pixels = |line: &Vec<[f64; 2]>| line.iter().map(|&p| layout.point(p)).collect();
        let mut loops: Vec<Vec<_>> = shape.outline.iter().map(pixels).collect();
        let fill = fill(shape.pane);
        // A stroke in the colour of the pane closes the seam to its neighbours.
        let seam = match fill {
            Fill::Plain(colour) => Some(Stroke::solid(colour, 0.4)),
            Fill::Empty | Fill::NoValue | Fill::Open => None,
        };
        canvas.titled(&hover(shape.pane), |canvas| {
            canvas.region(&loops, fill, seam);
        });
        for points in &mut loops {
            points.extend(points.first().copied());
        }
        outlines.append(&mut loops);
    }
    let width = outline_width(layout, shapes);
    if width > 0.05 {
        canvas.polylines(&outlines, Stroke::solid(outline, width));
    }
}

/// Pane outlines get thinner with the panes so that they never cover them.
fn outline_width(layout: &PictureLayout, shapes: &[PaneShape]) -> f64 {
    (0.025 * typical_pane_size(layout, shapes)).min(0.5)
}

/// Lower quartile over the panes of the smaller side of their bounding boxes in pixels.
pub(super) fn typical_pane_size(layout: &PictureLayout, shapes: &[PaneShape]) -> f64 {
    let scale = layout.pixels_per_length();
    let mut sizes: Vec<f64> = shapes
        .iter()
        .map(|shape| (shape.extent[0] * scale[0]).min(shape.extent[1] * scale[1]))
        .collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() / 4).copied().unwrap_or(0.0)
}

/// Values with a label, at most `most` powers of ten at equal distances, and values without one; where fewer than three powers
/// fit, also their doubles and fivefolds have labels.
pub(super) fn log_ticks(low: f64, high: f64, most: usize) -> (Vec<f64>, Vec<f64>) {
    let (first, last) = (decade(low), decade(high) + 1);
    let decades: Vec<f64> = (first..=last).map(|k| 10_f64.powi(k)).collect();
    let inside = |v: &f64| *v >= low * (1.0 - 1e-9) && *v <= high * (1.0 + 1e-9);
    let within = |values: Vec<f64>| values.into_iter().filter(inside).collect::<Vec<f64>>();
    let powers = within(decades.clone());
    if powers.len() >= 3 {
        let stride = i32::try_from(powers.len().div_ceil(most.max(2))).unwrap_or(1);
        let is_labelled = |v: &f64| decade(*v).rem_euclid(stride) == 0;
        return powers.into_iter().partition(is_labelled);
    }
    let times = |factors: &[f64]| {
        let products = decades
            .iter()
            .flat_map(|d| factors.iter().map(move |f| f * d));
        within(products.collect())
    };
    let minor = times(&[3.0, 4.0, 6.0, 7.0, 8.0, 9.0]);
    (times(&[1.0, 2.0, 5.0]), minor)
}

/// The printed form of a tick: plain from 10⁻² to 10⁴, else with a power of ten.
pub(super) fn log_label(value: f64) -> Label {
    if (0.99e-2..1.01e4).contains(&value) {
        let text = format!("{value:.4}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        return Label::plain(text);
    }
    let exponent = decade(value);
    let mantissa = value / 10_f64.powi(exponent);
    let digits = exponent.to_string().replace('-', "−");
    let factor = if (mantissa - 1.0).abs() < 1e-6 {
        Label::plain("10")
    } else {
        Label::plain(format!("{mantissa:.0}·10"))
    };
    factor.superscript(digits)
}

/// ⌊log₁₀ v⌋, a hair of rounding allowed.
fn decade(value: f64) -> i32 {
    #[expect(clippy::cast_possible_truncation, reason = "at most 324 in size")]
    let decade = (value.log10() + 1e-9).floor() as i32;
    decade
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_decades_are_thinned_and_few_are_divided() {
        let (major, minor) = log_ticks(1e-13, 1.0, 7);
        assert!((3..=7).contains(&major.len()), "{major:?}");
        assert_eq!(major.len() + minor.len(), 14);
        let (major, minor) = log_ticks(3.0, 40.0, 7);
        assert_eq!(major, [5.0, 10.0, 20.0]);
        assert_eq!(minor, [3.0, 4.0, 6.0, 7.0, 8.0, 9.0, 30.0, 40.0]);
    }

    #[test]
    fn labels_are_plain_or_powers_of_ten() {
        assert_eq!(log_label(0.05), Label::plain("0.05"));
        assert_eq!(log_label(1e-6), Label::plain("10").superscript("−6"));
        let label = Label::plain("2·10").superscript("5");
        assert_eq!(log_label(2e5), label);
    }
}
