//! A law of friction alone: coefficients over the slips, and over the contact face at zero slip.

use units::{Unit, Units};

use super::canvas::{Anchor, Canvas, Colour, Stroke};
use super::colour::{ColourMap, ValueRange};
use super::colour_bar::ColourKey;
use super::law_axes::{LawFrame, SlipAxis};
use super::layout::{KeySide, PANEL_WIDTH, PictureLayout, TITLE_SIZE, titled_panel};
use super::panels::semi_axis_map;
use super::panes::pane_shapes;
use super::picture::Picture;
use super::picture::{ContactPicture, FigureError};
use super::text::{Label, fitted};
use super::{FrictionKind, PAGE_TITLE_HEIGHT, PAGE_TITLE_SIZE};

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
    let friction = face.friction.unwrap_or((FrictionKind::Coulomb, &[]));
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
        FrictionKind::Coulomb.semi_axis_symbol(axis)
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
        let symbol = FrictionKind::Coulomb.semi_axis_symbol(axis);
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
