//! A law of friction alone: coefficients over the slips on axes of their own, and over the contact face at zero slip.

use units::{Dimension, Unit, Units};

use super::{
    FrictionKind, PAGE_TITLE_HEIGHT, PAGE_TITLE_SIZE,
    canvas::{Anchor, Canvas, Colour, Fill, Point, Stroke},
    colour::{ColourKey, ColourMap, ValueRange},
    layout::{
        KEY_WIDTH, KeySide, LABEL_SIZE, PANEL_WIDTH, PictureLayout, TICK_SIZE, TITLE_HEIGHT,
        TITLE_SIZE, fitting_ticks, titled_panel,
    },
    line_chart::LogTicks,
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
    pub over_slip: OverSlip<'a>,
    /// The contact face with the coefficients at zero slip, for laws that depend on the place.
    pub at_rest: Option<ContactPicture<'a>>,
}

/// The coefficients over the slips.
#[derive(Clone, Copy, Debug)]
pub enum OverSlip<'a> {
    /// F of an isotropic law over |u_t|.
    Isotropic(&'a SlipCurve),
    /// F₁ over |u_t1| and F₂ over |u_t2|, at slips of one axis.
    Own(&'a [SlipCurve; 2]),
    /// F₁ and F₂ over both slips.
    Both(&'a [SlipCoefficientMap; 2]),
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
    let horizontal = SlipAxis::new(curves[0].range, &slip, units);
    let frame = LawFrame::chart(horizontal, values, &joined_symbols(&symbols));
    let strokes = [
        Stroke::solid(Colour(0x00, 0x55, 0x9c), 2.2),
        Stroke::dashed(Colour(0xc4, 0x4e, 0x00), 2.2, 7.0),
    ];
    for (curve, stroke) in curves.iter().zip(strokes) {
        let points = curve.points.iter().filter(|point| point[1].is_finite());
        canvas.polylines(&[points.map(|p| frame.point(*p)).collect()], stroke);
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
    let ranges = own[0].shared(own[1]).map_or(own, |common| [common; 2]);
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
    let axis = |k: usize, index: &str| SlipAxis::new(map.ranges[k], &slip_symbol(index), units);
    let frame = LawFrame::map(axis(0, "1"), axis(1, "2"));
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

const TICK_LENGTH: f64 = 5.0;
/// Left of a plot with short tick labels, and room for the name of the vertical axis.
const LEFT: f64 = 84.0;
const NAME_WIDTH: f64 = 46.0;
const RIGHT_MARGIN: f64 = 28.0;
const PLOT_HEIGHT: f64 = 258.0;
/// Most labelled decades of a logarithmic axis.
const MOST_DECADES: usize = 7;

/// One axis with its ticks as fractions of its length.
pub(super) struct SlipAxis {
    range: SlipRange,
    label: Label,
    scale: UnitScale,
}

impl SlipAxis {
    /// An axis over slips in `units`, named by a symbol.
    pub(super) fn new(range: SlipRange, symbol: &Label, units: Units) -> Self {
        let unit = units.of(Dimension::LENGTH);
        let scale = match range {
            SlipRange::Linear(high) => UnitScale::new(high, &unit),
            SlipRange::Logarithmic(..) => UnitScale::new(1.0, &unit),
        };
        Self {
            range,
            label: scale.title(symbol),
            scale,
        }
    }

    /// Where a slip lies on the axis, from 0 to 1.
    fn fraction(&self, slip: f64) -> f64 {
        let fraction = match self.range {
            SlipRange::Linear(high) => slip / high,
            SlipRange::Logarithmic(low, high) => (slip / low).ln() / (high / low).ln(),
        };
        fraction.clamp(0.0, 1.0)
    }

    fn ticks(&self, pixels: f64) -> Vec<(f64, Label)> {
        match self.range {
            SlipRange::Linear(high) => {
                let scaled = self.scale.scaled(high);
                let ticks = fitting_ticks(0.0, scaled, pixels);
                let label = |&value: &f64| (value / scaled, Label::plain(ticks.text(value)));
                ticks.values.iter().map(label).collect()
            }
            SlipRange::Logarithmic(low, high) => {
                let major = LogTicks::new(low, high, MOST_DECADES).major;
                let label = |value: f64| (self.fraction(value), LogTicks::label(value));
                major.into_iter().map(label).collect()
            }
        }
    }
}

/// What the vertical axis of a frame shows.
enum Vertical {
    Slip(SlipAxis),
    /// Coefficients between two values.
    Coefficient {
        low: f64,
        high: f64,
        symbol: Label,
    },
}

/// The frame of a drawing over slips.
pub(super) struct LawFrame {
    pub(super) corner: Point,
    pub(super) size: Point,
    horizontal: SlipAxis,
    vertical: Vertical,
}

impl LawFrame {
    /// A chart of coefficients; the range of values gets a margin, and a constant a little room.
    pub(super) fn chart(horizontal: SlipAxis, values: ValueRange, symbol: &Label) -> Self {
        let (low, high) = match values {
            ValueRange::Interval(low, high) => (low, high),
            ValueRange::Constant(value) => (0.5 * value, 1.5 * value),
            ValueRange::Nothing => (0.0, 1.0),
        };
        let margin = 0.06 * (high - low);
        let vertical = Vertical::Coefficient {
            low: (low - margin).max(0.0),
            high: high + margin,
            symbol: symbol.clone(),
        };
        Self::new(horizontal, vertical, PLOT_HEIGHT, RIGHT_MARGIN)
    }

    /// A map over both slips, with room for a colour bar at its right.
    pub(super) fn map(horizontal: SlipAxis, vertical: SlipAxis) -> Self {
        let right = RIGHT_MARGIN + KEY_WIDTH;
        Self::new(
            horizontal,
            Vertical::Slip(vertical),
            PLOT_HEIGHT + 40.0,
            right,
        )
    }

    /// A frame of a height and a margin at its right; the one at its left fits its tick labels.
    fn new(horizontal: SlipAxis, vertical: Vertical, height: f64, right: f64) -> Self {
        let mut frame = Self {
            corner: [LEFT, TITLE_HEIGHT],
            size: [0.0, height],
            horizontal,
            vertical,
        };
        let left = LEFT.max(NAME_WIDTH + widest(&frame.vertical_ticks().1));
        frame.corner[0] = left;
        frame.size[0] = PANEL_WIDTH - left - right;
        frame
    }

    /// Pixel of a slip and a coefficient.
    pub(super) fn point(&self, [slip, value]: [f64; 2]) -> Point {
        let right = self.horizontal.fraction(slip);
        let up = match &self.vertical {
            Vertical::Slip(axis) => axis.fraction(value),
            Vertical::Coefficient { low, high, .. } => (value - low) / (high - low),
        };
        [
            self.corner[0] + right * self.size[0],
            self.corner[1] + (1.0 - up) * self.size[1],
        ]
    }

    fn vertical_ticks(&self) -> (Label, Vec<(f64, Label)>) {
        match &self.vertical {
            Vertical::Slip(axis) => (axis.label.clone(), axis.ticks(self.size[1])),
            Vertical::Coefficient { low, high, symbol } => {
                let scale = UnitScale::new(*high, &Unit::none());
                let [low, high] = [low, high].map(|&value| scale.scaled(value));
                let ticks = Ticks::new(low, high, 7);
                let label = |&value: &f64| {
                    let fraction = (value - low) / (high - low);
                    (fraction, Label::plain(ticks.text(value)))
                };
                (
                    scale.title(symbol),
                    ticks.values.iter().map(label).collect(),
                )
            }
        }
    }

    /// Draws frame, ticks and labels.
    pub(super) fn draw(&self, canvas: &mut Canvas) {
        let [left, top] = self.corner;
        let [width, height] = self.size;
        let bottom = top + height;
        let frame = Stroke::solid(Colour::BLACK, 0.8);
        canvas.rectangle(self.corner, self.size, Fill::Empty, Some(frame));
        for (fraction, label) in self.horizontal.ticks(width) {
            let x = left + fraction * width;
            canvas.line([x, bottom], [x, bottom + TICK_LENGTH], frame);
            canvas.text([x, bottom + 21.0], &label, TICK_SIZE, Anchor::Middle);
        }
        let (name, ticks) = self.vertical_ticks();
        for (fraction, label) in &ticks {
            let y = bottom - fraction * height;
            canvas.line([left, y], [left - TICK_LENGTH, y], frame);
            let position = [left - TICK_LENGTH - 4.0, y + 0.36 * TICK_SIZE];
            canvas.text(position, label, TICK_SIZE, Anchor::End);
        }
        let position = [left + width / 2.0, bottom + 42.0];
        canvas.text(position, &self.horizontal.label, LABEL_SIZE, Anchor::Middle);
        let position = [
            left - TICK_LENGTH - 16.0 - widest(&ticks),
            top + height / 2.0,
        ];
        canvas.vertical_text(position, &name, LABEL_SIZE);
    }

    /// Draws the strokes of two curves with their names above the plot, at its right.
    pub(super) fn draw_legend(&self, canvas: &mut Canvas, names: &[Label], strokes: &[Stroke]) {
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

/// Width of the widest tick label.
fn widest(ticks: &[(f64, Label)]) -> f64 {
    let widths = ticks.iter().map(|(_, label)| label.width(TICK_SIZE));
    widths.fold(0.0, f64::max)
}
