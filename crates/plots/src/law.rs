//! A law of friction alone: coefficients over the slips on axes of their own, and over the contact face at zero slip.

use units::{Dimension, Unit, Units};

use super::{
    FrictionKind,
    axis::{Axis, AxisScale, PlotFrame},
    canvas::{Anchor, Canvas, Colour, Stroke},
    colour::{ColourKey, ColourMap, ValueRange},
    layout::{
        KEY_WIDTH, KeySide, LABEL_SIZE, PANEL_WIDTH, PictureLayout, RIGHT_MARGIN, TITLE_HEIGHT,
        titled_panel,
    },
    panels::semi_axis_map,
    panes::pane_shapes,
    picture::{ContactPicture, Picture},
    scale::{Ticks, UnitScale},
    text::Label,
    titled_page,
};

/// Height of a chart over slips, and of its plot.
const LAW_HEIGHT: f64 = 360.0;
const PLOT_HEIGHT: f64 = 258.0;

/// What a law is drawn from.
#[derive(Clone, Copy, Debug)]
pub struct LawPicture<'a> {
    /// Title of the page.
    pub title: &'a str,
    /// The units of the slips.
    pub units: Units,
    /// A line below it, such as the place at which slips are varied; empty for none.
    pub note: &'a str,
    /// The coefficients over the slips.
    pub over_slip: &'a OverSlip,
    /// The contact face with the coefficients at zero slip, for laws that depend on the place.
    pub at_rest: Option<ContactPicture<'a>>,
}

/// The coefficients over the slips.
#[derive(Clone, Debug)]
pub enum OverSlip {
    /// F of an isotropic law over |u_t|, or F₁ over |u_t1| and F₂ over |u_t2|, at slips of one axis.
    Own(Vec<SlipCurve>),
    /// F₁ and F₂ over both slips.
    Both([SlipCoefficientMap; 2]),
}

/// Which slips an axis of a drawing shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SlipRange {
    /// From 0 to a slip \[m\].
    Linear(f64),
    /// Between two positive slips \[m\], by powers of ten.
    Logarithmic(f64, f64),
}

impl SlipRange {
    /// The slip at a fraction of the axis from 0 to 1.
    #[must_use]
    pub fn at(self, fraction: f64) -> f64 {
        match self {
            Self::Linear(high) => fraction * high,
            Self::Logarithmic(low, high) => low * (high / low).powf(fraction),
        }
    }

    /// The axis of this length over slips in `units`, named by a symbol.
    fn axis(self, symbol: &Label, units: Units, pixels: f64) -> Axis {
        let (scale, interval) = match self {
            Self::Linear(high) => (AxisScale::Linear, [0.0, high]),
            Self::Logarithmic(low, high) => (AxisScale::Logarithmic, [low, high]),
        };
        let unit = units.of(Dimension::LENGTH);
        // Most labelled decades of a logarithmic axis.
        Axis::new(scale, interval, (symbol, &unit), pixels, 7)
    }
}

/// A coefficient over a slip.
#[derive(Clone, Debug, PartialEq)]
pub struct SlipCurve {
    /// The slips shown.
    pub range: SlipRange,
    /// (slip \[m\], coefficient), by increasing slip.
    pub points: Vec<[f64; 2]>,
}

/// A coefficient over both slips.
#[derive(Clone, Debug, PartialEq)]
pub struct SlipCoefficientMap {
    /// The slips |u_t1| and |u_t2| shown.
    pub ranges: [SlipRange; 2],
    /// Number of cells along each axis.
    pub cells: usize,
    /// The coefficient at the centre of each cell; the first slip varies fastest.
    pub values: Vec<f64>,
}

/// Draws a law as one figure.
///
/// # Panics
/// Where arrays of the contact face do not fit together.
#[must_use]
pub fn law_page(picture: &LawPicture<'_>) -> Picture {
    let units = picture.units;
    let mut rows = vec![match picture.over_slip {
        OverSlip::Own(curves) => vec![curve_panel(curves, units)],
        OverSlip::Both(maps) => map_panels(maps, units).to_vec(),
    }];
    let isotropic = matches!(picture.over_slip, OverSlip::Own(curves) if curves.len() == 1);
    if let Some(face) = &picture.at_rest {
        let maps = face_panels(face, isotropic);
        if isotropic {
            rows[0].extend(maps);
        } else {
            rows.push(maps);
        }
    }
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let page = titled_page([picture.title, picture.note], &rows, columns, 0.5);
    Picture::new(&page, picture.title)
}

/// The coefficients over the contact face.
fn face_panels(face: &ContactPicture<'_>, isotropic: bool) -> Vec<Canvas> {
    let (kind, panes) = face.friction.unwrap_or((FrictionKind::OverPressure, &[]));
    let (shapes, layout) = (pane_shapes(face), PictureLayout::new(face));
    let unit = kind.unit(face.units);
    let panel = |axis: usize| {
        let symbol = law_symbol(axis, isotropic);
        let title = Label::plain("Coefficient of friction ");
        let title = title.then(&symbol).upright(" at zero slip");
        semi_axis_map((panes, &unit), (&layout, &shapes), axis, &title, &symbol)
    };
    (0..if isotropic { 1 } else { 2 }).map(panel).collect()
}

/// F with an index, or without one in an isotropic law.
fn law_symbol(axis: usize, isotropic: bool) -> Label {
    if isotropic {
        Label::default().italic("F")
    } else {
        FrictionKind::OverPressure.semi_axis_symbol(axis)
    }
}

/// |u_t| with an index, or without one in an isotropic law.
fn slip_symbol(index: &str) -> Label {
    Label::plain("|")
        .italic("u")
        .subscript(format!("t{index}"))
        .upright("|")
}

/// One or two coefficients over their own slips in one chart.
fn curve_panel(curves: &[SlipCurve], units: Units) -> Canvas {
    let isotropic = curves.len() == 1;
    let symbols: Vec<Label> = (0..curves.len())
        .map(|axis| law_symbol(axis, isotropic))
        .collect();
    let (title, slip) = if isotropic {
        ("Coefficient of friction over the slip", slip_symbol(""))
    } else {
        (
            "Coefficients of friction over their own slips",
            slip_symbol("1").upright(", ").then(&slip_symbol("2")),
        )
    };
    let mut canvas = titled_panel([PANEL_WIDTH, LAW_HEIGHT], &Label::plain(title));
    let values = curves.iter().flat_map(|curve| &curve.points);
    let values = ValueRange::of(values.map(|point| point[1]));
    let (low, high) = match values {
        ValueRange::Interval(low, high) => (low, high),
        ValueRange::Constant(value) => (0.5 * value, 1.5 * value),
        ValueRange::Nothing => (0.0, 1.0),
    };
    let margin = 0.06 * (high - low);
    let interval = [(low - margin).max(0.0), high + margin];
    let scale = UnitScale::new(interval[1], &Unit::none());
    let scaled = interval.map(|value| scale.scaled(value));
    let title = scale.title(&joined_symbols(&symbols));
    let vertical = Axis::linear(title, &Ticks::new(scaled[0], scaled[1], 7), scaled);
    let horizontal = |pixels: f64| curves[0].range.axis(&slip, units, pixels);
    let frame = law_frame(horizontal, vertical, PLOT_HEIGHT, RIGHT_MARGIN);
    let strokes = [
        Stroke::solid(Colour(0x00, 0x55, 0x9c), 2.2),
        Stroke::dashed(Colour(0xc4, 0x4e, 0x00), 2.2, 7.0),
    ];
    for (curve, stroke) in curves.iter().zip(strokes) {
        let points = curve.points.iter().filter(|point| point[1].is_finite());
        let points = points.map(|[slip, value]| frame.pixel([*slip, scale.scaled(*value)]));
        canvas.polylines(&[points.collect()], stroke);
    }
    draw_frame(&mut canvas, &frame);
    if !isotropic {
        draw_legend(&mut canvas, &frame, symbols.iter().zip(strokes));
    }
    canvas
}

fn joined_symbols(symbols: &[Label]) -> Label {
    match symbols {
        [first, second] => first.clone().upright(", ").then(second),
        [only] => only.clone(),
        _ => Label::default(),
    }
}

/// F₁ and F₂ as colour maps over both slips, with common colours unless these would hide one.
fn map_panels(maps: &[SlipCoefficientMap; 2], units: Units) -> [Canvas; 2] {
    let own = maps
        .each_ref()
        .map(|map| ValueRange::of(map.values.iter().copied()));
    let ranges = ValueRange::shared(own);
    [0, 1].map(|axis| {
        let symbol = FrictionKind::OverPressure.semi_axis_symbol(axis);
        let key = ColourKey::with_range(
            ranges[axis],
            false,
            ColourMap::Cividis,
            &symbol,
            &Unit::none(),
        );
        let title = Label::plain("Coefficient of friction ")
            .then(&symbol)
            .upright(" over both slips");
        map_panel(&maps[axis], &key, &title, units)
    })
}

fn map_panel(map: &SlipCoefficientMap, key: &ColourKey, title: &Label, units: Units) -> Canvas {
    let mut canvas = titled_panel([PANEL_WIDTH, LAW_HEIGHT + 40.0], title);
    let [first, second] = map.ranges;
    let height = PLOT_HEIGHT + 40.0;
    let horizontal = |pixels: f64| first.axis(&slip_symbol("1"), units, pixels);
    let vertical = second.axis(&slip_symbol("2"), units, height);
    let frame = law_frame(horizontal, vertical, height, RIGHT_MARGIN + KEY_WIDTH);
    let [left, top] = frame.corner;
    let size = frame.size.map(|length| length / map.cells as f64);
    for (index, &value) in map.values.iter().enumerate() {
        let [column, row] = [index % map.cells, index / map.cells];
        // Cells reach some pixels below those drawn after them, so that no seam shows.
        let overlap = [column, row].map(|k| if k + 1 < map.cells { 0.8 } else { 0.0 });
        let corner = [
            left + column as f64 * size[0],
            top + (map.cells - 1 - row) as f64 * size[1] - overlap[1],
        ];
        let size = [size[0] + overlap[0], size[1] + overlap[1]];
        canvas.rectangle(corner, size, key.fill(value), None);
    }
    draw_frame(&mut canvas, &frame);
    let corner = [left + frame.size[0] + 28.0, top];
    key.draw(&mut canvas, KeySide::Right, corner, frame.size[1]);
    canvas
}

/// The frame of a plot over slips with a margin at its right; the one at its left fits its tick labels.
fn law_frame(
    horizontal: impl FnOnce(f64) -> Axis,
    vertical: Axis,
    height: f64,
    right: f64,
) -> PlotFrame {
    let left = (46.0 + vertical.widest()).max(84.0);
    let width = PANEL_WIDTH - left - right;
    PlotFrame {
        corner: [left, TITLE_HEIGHT],
        size: [width, height],
        axes: [horizontal(width), vertical],
        has_grid: false,
    }
}

fn draw_frame(canvas: &mut Canvas, frame: &PlotFrame) {
    frame.draw(canvas, [21.0, 42.0], frame.name_x(16.0));
}

/// Draws the strokes of two curves with their names above the plot, at its right.
fn draw_legend<'a>(
    canvas: &mut Canvas,
    frame: &PlotFrame,
    curves: impl Iterator<Item = (&'a Label, Stroke)>,
) {
    let baseline = frame.corner[1] - 12.0;
    let right = frame.corner[0] + frame.size[0];
    for (index, (name, stroke)) in curves.enumerate() {
        let x = right - 70.0 * (2 - index) as f64;
        let y = baseline - 4.0;
        canvas.line([x, y], [x + 34.0, y], stroke);
        canvas.text([x + 40.0, baseline], name, LABEL_SIZE, Anchor::Start);
    }
}
