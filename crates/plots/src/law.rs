//! A law of friction alone: coefficients over the slips on axes of their own, and over the contact face at zero slip.

use units::{Dimension, Unit, Units};

use super::{
    FrictionKind, PAGE_TITLE_HEIGHT, PAGE_TITLE_SIZE,
    canvas::{Anchor, Canvas, Colour, Point, Stroke},
    colour::{ColourKey, ColourMap, ValueRange},
    layout::{
        KEY_WIDTH, KeySide, LABEL_SIZE, PANEL_WIDTH, PictureLayout, TITLE_HEIGHT, TITLE_SIZE,
        fitting_ticks, titled_panel,
    },
    line_chart::{TICK_LENGTH, TickedAxis, draw_ticked_frame, log_label, log_ticks},
    panels::semi_axis_map,
    panes::pane_shapes,
    picture::{ContactPicture, FigureError, Picture},
    scale::{Ticks, UnitScale},
    text::{Label, fitted},
};

/// Height of a chart over slips.
const CHART_HEIGHT: f64 = 360.0;
/// Vertical space of the note below the page title.
const NOTE_HEIGHT: f64 = 24.0;
/// Pixels by which the cells of a map reach below their neighbours.
const OVERLAP: f64 = 0.8;

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
    /// F of an isotropic law over |u_t|.
    Isotropic(SlipCurve),
    /// F₁ over |u_t1| and F₂ over |u_t2|, at slips of one axis.
    Own([SlipCurve; 2]),
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

    /// Where a slip lies on the axis, from 0 to 1.
    fn fraction(self, slip: f64) -> f64 {
        let fraction = match self {
            Self::Linear(high) => slip / high,
            Self::Logarithmic(low, high) => (slip / low).ln() / (high / low).ln(),
        };
        fraction.clamp(0.0, 1.0)
    }

    /// The axis of this length over slips in `units`, named by a symbol.
    fn axis(self, symbol: &Label, units: Units, pixels: f64) -> TickedAxis {
        let unit = units.of(Dimension::LENGTH);
        match self {
            Self::Linear(high) => {
                let scale = UnitScale::new(high, &unit);
                let scaled = scale.scaled(high);
                let ticks = fitting_ticks(0.0, scaled, pixels);
                TickedAxis::linear(scale.title(symbol), &ticks, [0.0, scaled])
            }
            Self::Logarithmic(low, high) => {
                let (major, _) = log_ticks(low, high, MOST_DECADES);
                let label = |value: f64| (self.fraction(value), log_label(value));
                TickedAxis {
                    title: UnitScale::new(1.0, &unit).title(symbol),
                    ticks: major.into_iter().map(label).collect(),
                }
            }
        }
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
/// # Errors
/// [`FigureError`] when the arrays of the contact face do not fit together.
pub fn law_page(picture: &LawPicture<'_>) -> Result<Picture, FigureError> {
    let units = picture.units;
    let mut rows = vec![match picture.over_slip {
        OverSlip::Isotropic(curve) => vec![curve_panel(std::slice::from_ref(curve), true, units)],
        OverSlip::Own(curves) => vec![curve_panel(curves, false, units)],
        OverSlip::Both(maps) => map_panels(maps, units).to_vec(),
    }];
    if let Some(face) = &picture.at_rest {
        let isotropic = matches!(picture.over_slip, OverSlip::Isotropic(_));
        let maps = face_panels(face, isotropic)?;
        if isotropic {
            rows[0].extend(maps);
        } else {
            rows.push(maps);
        }
    }
    Ok(Picture::new(joined(picture, &rows), picture.title))
}

/// The coefficients over the contact face.
fn face_panels(face: &ContactPicture<'_>, isotropic: bool) -> Result<Vec<Canvas>, FigureError> {
    face.validate()?;
    let symbols = [0, 1].map(|axis| law_symbol(axis, isotropic));
    let titles = symbols.each_ref().map(|symbol| {
        Label::plain("Coefficient of friction ")
            .then(symbol)
            .upright(" at zero slip")
    });
    let friction = face.friction.unwrap_or((FrictionKind::OverPressure, &[]));
    let shapes = pane_shapes(face);
    let (kind, panes) = friction;
    let friction = (panes, &kind.unit(face.units));
    let layout = PictureLayout::new(face);
    let count = if isotropic { 1 } else { 2 };
    let maps = (0..count).map(|axis| {
        let face = (&layout, shapes.as_slice());
        semi_axis_map(friction, face, axis, &titles[axis], &symbols[axis])
    });
    Ok(maps.collect())
}

/// Rows of panels below the title; a shorter row sits in the middle.
fn joined(picture: &LawPicture<'_>, rows: &[Vec<Canvas>]) -> Canvas {
    let height = |row: &[Canvas]| row.iter().map(|canvas| canvas.height).fold(0.0, f64::max);
    let width = |row: &[Canvas]| row.len() as f64 * PANEL_WIDTH;
    let note_height = if picture.note.is_empty() {
        0.0
    } else {
        NOTE_HEIGHT
    };
    let mut top = PAGE_TITLE_HEIGHT + note_height;
    let mut page = Canvas::new(
        rows.iter().map(|row| width(row)).fold(0.0, f64::max),
        top + rows.iter().map(|row| height(row)).sum::<f64>(),
    );
    let mut line = |text: &str, baseline: f64, size: f64| {
        let text = fitted(text, size, page.width - 60.0);
        let centre = [page.width / 2.0, baseline];
        page.text(centre, &Label::plain(text), size, Anchor::Middle);
    };
    line(picture.title, 31.0, PAGE_TITLE_SIZE);
    if note_height > 0.0 {
        line(picture.note, 31.0 + NOTE_HEIGHT, TITLE_SIZE);
    }
    for row in rows {
        let left = (page.width - width(row)) / 2.0;
        for (column, canvas) in row.iter().enumerate() {
            page.place(canvas, [left + column as f64 * PANEL_WIDTH, top]);
        }
        top += height(row);
    }
    page
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
fn curve_panel(curves: &[SlipCurve], isotropic: bool, units: Units) -> Canvas {
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
    let mut canvas = titled_panel([PANEL_WIDTH, CHART_HEIGHT], &Label::plain(title));
    let values = curves.iter().flat_map(|curve| &curve.points);
    let values = ValueRange::of(values.map(|point| point[1]));
    let (low, high) = match values {
        ValueRange::Interval(low, high) => (low, high),
        ValueRange::Constant(value) => (0.5 * value, 1.5 * value),
        ValueRange::Nothing => (0.0, 1.0),
    };
    let margin = 0.06 * (high - low);
    let (low, high) = ((low - margin).max(0.0), high + margin);
    let vertical = coefficient_axis(low, high, &joined_symbols(&symbols));
    let range = curves[0].range;
    let horizontal = |pixels: f64| range.axis(&slip, units, pixels);
    let frame = LawFrame::new(horizontal, vertical, PLOT_HEIGHT, RIGHT_MARGIN);
    let point = |[slip, value]: [f64; 2]| {
        let up = (value - low) / (high - low);
        [
            frame.corner[0] + range.fraction(slip) * frame.size[0],
            frame.corner[1] + (1.0 - up) * frame.size[1],
        ]
    };
    let strokes = [
        Stroke::solid(Colour(0x00, 0x55, 0x9c), 2.2),
        Stroke::dashed(Colour(0xc4, 0x4e, 0x00), 2.2, 7.0),
    ];
    for (curve, stroke) in curves.iter().zip(strokes) {
        let points = curve.points.iter().filter(|point| point[1].is_finite());
        canvas.polylines(&[points.map(|p| point(*p)).collect()], stroke);
    }
    frame.draw(&mut canvas);
    if !isotropic {
        frame.draw_legend(&mut canvas, &symbols, &strokes);
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
    let mut canvas = titled_panel([PANEL_WIDTH, CHART_HEIGHT + 40.0], title);
    let [first, second] = map.ranges;
    let height = PLOT_HEIGHT + 40.0;
    let horizontal = |pixels: f64| first.axis(&slip_symbol("1"), units, pixels);
    let vertical = second.axis(&slip_symbol("2"), units, height);
    let frame = LawFrame::new(horizontal, vertical, height, RIGHT_MARGIN + KEY_WIDTH);
    let [left, top] = frame.corner;
    let size = frame.size.map(|length| length / map.cells as f64);
    for (index, &value) in map.values.iter().enumerate() {
        let [column, row] = [index % map.cells, index / map.cells];
        // Cells reach below those drawn after them, so that no seam shows.
        let overlap = [column, row].map(|k| if k + 1 < map.cells { OVERLAP } else { 0.0 });
        let corner = [
            left + column as f64 * size[0],
            top + (map.cells - 1 - row) as f64 * size[1] - overlap[1],
        ];
        let size = [size[0] + overlap[0], size[1] + overlap[1]];
        canvas.rectangle(corner, size, key.fill(value), None);
    }
    frame.draw(&mut canvas);
    let corner = [left + frame.size[0] + 28.0, top];
    key.draw(&mut canvas, KeySide::Right, corner, frame.size[1]);
    canvas
}

/// Left of a plot with short tick labels, and room for the name of the vertical axis.
const LEFT: f64 = 84.0;
const NAME_WIDTH: f64 = 46.0;
const RIGHT_MARGIN: f64 = 28.0;
const PLOT_HEIGHT: f64 = 258.0;
/// Most labelled decades of a logarithmic axis.
const MOST_DECADES: usize = 7;

/// An axis over coefficients between two values.
fn coefficient_axis(low: f64, high: f64, symbol: &Label) -> TickedAxis {
    let scale = UnitScale::new(high, &Unit::none());
    let interval = [low, high].map(|value| scale.scaled(value));
    let ticks = Ticks::new(interval[0], interval[1], 7);
    TickedAxis::linear(scale.title(symbol), &ticks, interval)
}

/// The frame of a drawing over slips.
struct LawFrame {
    corner: Point,
    size: Point,
    axes: [TickedAxis; 2],
}

impl LawFrame {
    /// A frame of a height and a margin at its right; the one at its left fits its tick labels.
    fn new(
        horizontal: impl FnOnce(f64) -> TickedAxis,
        vertical: TickedAxis,
        height: f64,
        right: f64,
    ) -> Self {
        let left = LEFT.max(NAME_WIDTH + vertical.widest());
        let width = PANEL_WIDTH - left - right;
        Self {
            corner: [left, TITLE_HEIGHT],
            size: [width, height],
            axes: [horizontal(width), vertical],
        }
    }

    /// Draws frame, ticks and labels.
    fn draw(&self, canvas: &mut Canvas) {
        let name_x = self.corner[0] - TICK_LENGTH - 16.0 - self.axes[1].widest();
        let below = [21.0, 42.0];
        draw_ticked_frame(canvas, (self.corner, self.size), &self.axes, below, name_x);
    }

    /// Draws the strokes of two curves with their names above the plot, at its right.
    fn draw_legend(&self, canvas: &mut Canvas, names: &[Label], strokes: &[Stroke]) {
        let baseline = self.corner[1] - 12.0;
        let right = self.corner[0] + self.size[0];
        for (index, (name, stroke)) in names.iter().zip(strokes).enumerate() {
            let x = right - 70.0 * (names.len() - index) as f64;
            let y = baseline - 4.0;
            canvas.line([x, y], [x + 34.0, y], *stroke);
            canvas.text([x + 40.0, baseline], name, LABEL_SIZE, Anchor::Start);
        }
    }
}
