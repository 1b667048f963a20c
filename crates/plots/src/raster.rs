//! A canvas as PNG.

use tiny_skia::{
    Color, FillRule, FilterQuality, LineCap, LineJoin, Paint, Path, PathBuilder, Pattern, Pixmap,
    Rect, SpreadMode, Stroke, StrokeDash, Transform,
};

use super::canvas::{
    self, Anchor, Canvas, Colour, DrawnElement, Fill, Outline, Point, Setting, Text,
};
use super::colour::Hatch;
use super::picture::FigureError;
use super::text::{Typeface, single};

/// Bytes of a PNG up to the end of its header.
const HEADER: usize = 33;
/// The chunk that names this program: length, type, keyword, text, check sum.
const SOFTWARE: &[u8] = b"\0\0\0\x17tEXtSoftware\0contact3d-pipe\x2a\xc3\xa9\x06";

/// Draws a canvas as a PNG of the given width; the height follows from its shape.
///
/// # Errors
/// [`FigureError::Width`] when the picture would be empty or too large, [`FigureError::Png`] when the encoder fails.
pub(super) fn png(canvas: &Canvas, pixels_wide: u32) -> Result<Vec<u8>, FigureError> {
    let scale = f64::from(pixels_wide) / canvas.width;
    let height = (scale * canvas.height).round();
    let mut painter = Painter::new(pixels_wide, height, scale)?;
    let transform = Transform::from_scale(single(scale), single(scale));
    painter.draw(&canvas.elements, transform);
    let png = painter.pixmap.encode_png();
    let mut png = png.map_err(|error| FigureError::Png(error.to_string()))?;
    png.splice(HEADER..HEADER, SOFTWARE.iter().copied());
    Ok(png)
}

struct Painter {
    pixmap: Pixmap,
    typeface: Typeface,
    no_value: Pixmap,
    open: Pixmap,
}

impl Painter {
    /// A white picture.
    fn new(pixels_wide: u32, height: f64, scale: f64) -> Result<Self, FigureError> {
        let blank = |width: f64, height: f64, colour: Colour| {
            let fits = |side: f64| (1.0..1e5).contains(&side);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "checked on the same line"
            )]
            let pixmap = (fits(width) && fits(height))
                .then(|| Pixmap::new(width as u32, height as u32))
                .flatten();
            let mut pixmap = pixmap.ok_or(FigureError::Width(pixels_wide))?;
            pixmap.fill(opaque(colour));
            Ok(pixmap)
        };
        let tile = |hatch: Hatch| {
            let side = (scale * hatch.period).round().max(1.0);
            let mut tile = blank(side, side, hatch.background)?;
            let stroke = Stroke {
                width: single(hatch.width),
                ..Stroke::default()
            };
            let lines = hatch.segments().map(|segment| segment.to_vec());
            let fit = single(side / hatch.period);
            if let Some(path) = polylines(&lines, false) {
                let transform = Transform::from_scale(fit, fit);
                tile.stroke_path(&path, &plain(hatch.lines), &stroke, transform, None);
            }
            Ok(tile)
        };
        Ok(Self {
            pixmap: blank(f64::from(pixels_wide), height, Colour::WHITE)?,
            typeface: Typeface::new(),
            no_value: tile(Hatch::NO_VALUE)?,
            open: tile(Hatch::OPEN)?,
        })
    }

    fn draw(&mut self, elements: &[DrawnElement], transform: Transform) {
        for element in elements {
            match element {
                DrawnElement::Shape {
                    outline,
                    fill,
                    stroke,
                } => {
                    if let Some(path) = path(outline) {
                        self.fill(&path, *fill, transform);
                        self.stroke(&path, *stroke, transform);
                    }
                }
                DrawnElement::Text(text) => self.text(text, transform),
                DrawnElement::Titled(_, inner) => self.draw(inner, transform),
                DrawnElement::Moved(corner, inner) => {
                    let [x, y] = corner.map(coordinate);
                    self.draw(inner, transform.pre_translate(x, y));
                }
            }
        }
    }

    fn fill(&mut self, path: &Path, fill: Fill, transform: Transform) {
        let paint = match fill {
            Fill::Empty => return,
            Fill::Plain(colour) => plain(colour),
            Fill::NoValue => tiled(&self.no_value, Hatch::NO_VALUE),
            Fill::Open => tiled(&self.open, Hatch::OPEN),
        };
        let rule = FillRule::EvenOdd;
        self.pixmap.fill_path(path, &paint, rule, transform, None);
    }

    fn stroke(&mut self, path: &Path, stroke: Option<canvas::Stroke>, transform: Transform) {
        let Some(stroke) = stroke else { return };
        let width = coordinate(stroke.width);
        // For tiny-skia a stroke without width is the thinnest of all.
        if width == 0.0 {
            return;
        }
        let (line_cap, dash) = match stroke.dash {
            Some(dash) => (
                LineCap::Butt,
                StrokeDash::new(vec![coordinate(dash); 2], 0.0),
            ),
            None => (LineCap::Round, None),
        };
        let style = Stroke {
            width,
            line_cap,
            line_join: LineJoin::Round,
            dash,
            ..Stroke::default()
        };
        let paint = plain(stroke.colour);
        self.pixmap
            .stroke_path(path, &paint, &style, transform, None);
    }

    fn text(&mut self, text: &Text, transform: Transform) {
        let (bold, turn) = match text.setting {
            Setting::Plain => (false, 0.0),
            Setting::Bold => (true, 0.0),
            Setting::Upwards => (false, -90.0),
        };
        let line = self.typeface.set(&text.label, text.size, bold);
        let Some(outline) = line.outline else { return };
        let back = match text.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => 0.5 * line.width,
            Anchor::End => line.width,
        };
        let [x, y] = text.position.map(coordinate);
        let transform = transform
            .pre_translate(x, y)
            .pre_rotate(turn)
            .pre_translate(-single(back), 0.0);
        let paint = plain(Colour::BLACK);
        let rule = FillRule::Winding;
        self.pixmap
            .fill_path(&outline, &paint, rule, transform, None);
    }
}

/// The path of an outline; none where it has no extent.
fn path(outline: &Outline) -> Option<Path> {
    match outline {
        Outline::Loops(loops) => polylines(loops, true),
        Outline::Lines(lines) => polylines(lines, false),
        Outline::Rectangle(corner, size) => rectangle(*corner, *size).map(PathBuilder::from_rect),
        Outline::Ellipse(centre, semi_axes) => ellipse(*centre, *semi_axes),
    }
}

/// Four cubic curves, none further from the ellipse than 3e-4 of its size.
fn ellipse(centre: Point, semi_axes: Point) -> Option<Path> {
    let ([x, y], [rx, ry]) = (centre.map(coordinate), semi_axes.map(coordinate));
    if rx <= 0.0 || ry <= 0.0 {
        return None;
    }
    // The middle of a quarter of the unit circle lies on the curve.
    let k = single(4.0 / 3.0 * (std::f64::consts::SQRT_2 - 1.0));
    let at = |[u, v]: [f32; 2]| [x + rx * u, y + ry * v];
    let mut path = PathBuilder::new();
    path.move_to(x + rx, y);
    let mut from = [1.0, 0.0];
    for to in [[0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, 0.0]] {
        let beside = |a: [f32; 2], b: [f32; 2]| at([a[0] + k * b[0], a[1] + k * b[1]]);
        let ([x1, y1], [x2, y2], [x3, y3]) = (beside(from, to), beside(to, from), at(to));
        path.cubic_to(x1, y1, x2, y2, x3, y3);
        from = to;
    }
    path.close();
    path.finish()
}

fn polylines(lines: &[Vec<Point>], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for line in lines {
        for (index, point) in line.iter().enumerate() {
            let [x, y] = point.map(coordinate);
            if index == 0 {
                path.move_to(x, y);
            } else {
                path.line_to(x, y);
            }
        }
        if closed {
            path.close();
        }
    }
    path.finish()
}

fn rectangle(corner: Point, size: Point) -> Option<Rect> {
    let ([x, y], [width, height]) = (corner.map(coordinate), size.map(coordinate));
    Rect::from_xywh(x, y, width, height).filter(|_| width > 0.0 && height > 0.0)
}

/// A coordinate as the SVG has it: two decimals, and 0 for what is not finite.
fn coordinate(value: f64) -> f32 {
    if value.is_finite() {
        single((100.0 * value).round() / 100.0)
    } else {
        0.0
    }
}

fn opaque(Colour(red, green, blue): Colour) -> Color {
    Color::from_rgba8(red, green, blue, u8::MAX)
}

fn plain(colour: Colour) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color(opaque(colour));
    paint
}

/// A tile in every direction, at its own size on the canvas.
fn tiled(tile: &Pixmap, hatch: Hatch) -> Paint<'_> {
    let size = single(hatch.period) / tile.width() as f32;
    Paint {
        shader: Pattern::new(
            tile.as_ref(),
            SpreadMode::Repeat,
            FilterQuality::Bicubic,
            1.0,
            Transform::from_scale(size, size),
        ),
        ..Paint::default()
    }
}
