//! A drawing, kept as deterministic SVG 1.1, and its PNG.

use std::{
    borrow::Cow,
    sync::{Arc, LazyLock},
};

use resvg::{
    tiny_skia::{Pixmap, Transform},
    usvg::{Options, Tree, fontdb},
};
use ttf_parser::Face;

use super::{
    picture::PngError,
    text::{Label, escape},
};

/// A point on a canvas in its pixels, x to the right, y downwards.
pub(super) type Point = [f64; 2];

/// An sRGB colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Colour(pub(super) u8, pub(super) u8, pub(super) u8);

impl Colour {
    pub(super) const BLACK: Self = Self(0x1a, 0x1a, 0x1a);
    pub(super) const WHITE: Self = Self(0xff, 0xff, 0xff);
    pub(super) const GREY: Self = Self(0x77, 0x77, 0x77);

    /// As `#rrggbb`.
    pub(super) fn hex(self) -> String {
        let Self(red, green, blue) = self;
        format!("#{red:02x}{green:02x}{blue:02x}")
    }
}

/// The inside of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fill {
    Empty,
    Plain(Colour),
    /// Diagonal lines on light grey: a value that is not a number.
    NoValue,
    /// Diagonal lines on white: a pane that is out of contact.
    Open,
}

/// The line around a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stroke {
    colour: Colour,
    /// Width in pixels.
    width: f64,
    /// Length of dashes and of the spaces between them in pixels.
    dash: Option<f64>,
}

impl Stroke {
    pub(super) const fn solid(colour: Colour, width: f64) -> Self {
        Self {
            colour,
            width,
            dash: None,
        }
    }

    pub(super) const fn dashed(colour: Colour, width: f64, dash: f64) -> Self {
        Self {
            colour,
            width,
            dash: Some(dash),
        }
    }
}

/// Which point of a label sits at the given position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// A drawing of fixed size; later elements cover earlier ones.
#[derive(Clone, Debug)]
pub(super) struct Canvas {
    /// Width in pixels.
    pub(super) width: f64,
    /// Height in pixels.
    pub(super) height: f64,
    /// The elements as SVG.
    elements: String,
}

impl Canvas {
    /// An empty canvas.
    pub(super) fn new(width: f64, height: f64) -> Self {
        Self {
            width,
            height,
            elements: String::new(),
        }
    }

    /// Closed loops that together bound one even–odd region.
    pub(super) fn region(&mut self, loops: &[Vec<Point>], fill: Fill, stroke: Option<Stroke>) {
        self.path(loops, "Z", fill, stroke);
    }

    /// Open polylines with one stroke.
    pub(super) fn polylines(&mut self, lines: &[Vec<Point>], stroke: Stroke) {
        self.path(lines, "", Fill::Empty, Some(stroke));
    }

    /// A straight line.
    pub(super) fn line(&mut self, from: Point, to: Point, stroke: Stroke) {
        self.polylines(&[vec![from, to]], stroke);
    }

    /// A rectangle with its upper left corner at `corner`.
    pub(super) fn rectangle(
        &mut self,
        corner: Point,
        size: Point,
        fill: Fill,
        stroke: Option<Stroke>,
    ) {
        let ([x, y], [width, height]) = (corner.map(number), size.map(number));
        let shape = format!("rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"");
        self.shape(&shape, fill, stroke);
    }

    /// An ellipse with axes along those of the canvas.
    pub(super) fn ellipse(
        &mut self,
        centre: Point,
        semi_axes: Point,
        fill: Fill,
        stroke: Option<Stroke>,
    ) {
        let ([x, y], [rx, ry]) = (centre.map(number), semi_axes.map(number));
        let shape = format!("ellipse cx=\"{x}\" cy=\"{y}\" rx=\"{rx}\" ry=\"{ry}\"");
        self.shape(&shape, fill, stroke);
    }

    /// A label with its baseline at `position`.
    pub(super) fn text(&mut self, position: Point, label: &Label, size: f64, anchor: Anchor) {
        self.set(position, label, size, anchor, "");
    }

    /// A bold label with its baseline at `position`.
    pub(super) fn bold_text(&mut self, position: Point, label: &Label, size: f64, anchor: Anchor) {
        self.set(position, label, size, anchor, " font-weight=\"bold\"");
    }

    /// A label centred at `position` that reads upwards.
    pub(super) fn vertical_text(&mut self, position: Point, label: &Label, size: f64) {
        let [x, y] = position.map(number);
        let turn = format!(" transform=\"rotate(-90 {x} {y})\"");
        self.set(position, label, size, Anchor::Middle, &turn);
    }

    /// What `draw` draws, with a text that shows when the reader points at it.
    pub(super) fn titled(&mut self, title: &str, draw: impl FnOnce(&mut Self)) {
        self.elements += &format!("<g><title>{}</title>\n", escape(title));
        draw(self);
        self.elements += "</g>\n";
    }

    /// Copies another canvas with its upper left corner to `corner`.
    pub(super) fn place(&mut self, other: &Self, corner: Point) {
        let [x, y] = corner.map(number);
        self.elements += &format!("<g transform=\"translate({x} {y})\">\n");
        self.elements += &other.elements;
        self.elements += "</g>\n";
    }

    fn path(&mut self, lines: &[Vec<Point>], end: &str, fill: Fill, stroke: Option<Stroke>) {
        let data: String = lines.iter().map(|line| data(line) + end).collect();
        let shape = format!("path d=\"{data}\" fill-rule=\"evenodd\"");
        self.shape(&shape, fill, stroke);
    }

    fn shape(&mut self, shape: &str, fill: Fill, stroke: Option<Stroke>) {
        let stroke = stroke.map_or_else(String::new, stroke_attributes);
        self.elements += &match fill {
            Fill::Empty => format!("<{shape} fill=\"none\"{stroke}/>\n"),
            Fill::Plain(colour) => format!("<{shape} fill=\"{}\"{stroke}/>\n", colour.hex()),
            Fill::NoValue => format!("<{shape} fill=\"url(#no-value)\"{stroke}/>\n"),
            Fill::Open => format!("<{shape} fill=\"url(#open)\"{stroke}/>\n"),
        };
    }

    fn set(&mut self, position: Point, label: &Label, size: f64, anchor: Anchor, attributes: &str) {
        let [x, y] = position.map(number);
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        self.elements += &format!(
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" text-anchor=\"{anchor}\"{attributes}>{}</text>\n",
            number(size),
            label.markup(size)
        );
    }

    /// The whole SVG document, with `title` as its accessible name.
    pub(super) fn svg(&self, title: &str) -> String {
        let (width, height) = (number(self.width), number(self.height));
        let elements = &self.elements;
        let patterns = if elements.contains("url(#") {
            PATTERNS
        } else {
            ""
        };
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" \
             font-family=\"'DejaVu Sans', Verdana, sans-serif\" fill=\"{}\">\n\
             <title>{}</title>\n{patterns}\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n{elements}</svg>\n",
            Colour::BLACK.hex(),
            escape(title),
        )
    }
}

/// The two hatches: square tiles with their diagonal and the corners of those of their neighbours. Every document that
/// needs one defines both, so that panels can be joined to a page.
const PATTERNS: &str = "<defs>\n\
    <pattern id=\"no-value\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\">\
    <rect width=\"6\" height=\"6\" fill=\"#d8d8d8\"/>\
    <path d=\"M-1 1L1 -1M0 6L6 0M5 7L7 5\" stroke=\"#8a8a8a\" stroke-width=\"1\"/></pattern>\n\
    <pattern id=\"open\" width=\"5\" height=\"5\" patternUnits=\"userSpaceOnUse\">\
    <rect width=\"5\" height=\"5\" fill=\"#ffffff\"/>\
    <path d=\"M-1 1L1 -1M0 5L5 0M4 6L6 4\" stroke=\"#c4c4c4\" stroke-width=\"0.7\"/></pattern>\n\
    </defs>\n";

/// A polyline as path data.
fn data(line: &[Point]) -> String {
    let mut data = String::new();
    for (index, point) in line.iter().enumerate() {
        data.push(if index == 0 { 'M' } else { 'L' });
        data.push_str(&number(point[0]));
        data.push(' ');
        data.push_str(&number(point[1]));
    }
    data
}

fn stroke_attributes(stroke: Stroke) -> String {
    let (colour, width) = (stroke.colour.hex(), number(stroke.width));
    let ends = stroke.dash.map_or_else(
        || " stroke-linecap=\"round\"".to_owned(),
        |dash| format!(" stroke-dasharray=\"{}\"", number(dash)),
    );
    format!(" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"{ends}")
}

/// A coordinate with two decimals at most; what is not finite becomes 0.
fn number(value: f64) -> String {
    if !value.is_finite() {
        return "0".to_owned();
    }
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0" } else { text }.to_owned()
}

/// DejaVu Sans, so that pictures need no fonts of the system.
static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    for font in [
        dejavu::sans::regular(),
        dejavu::sans::oblique(),
        dejavu::sans::bold(),
        dejavu::sans::bold_oblique(),
    ] {
        fonts.load_font_source(fontdb::Source::Binary(Arc::new(font)));
    }
    Arc::new(fonts)
});

/// The text with a box for each character that DejaVu Sans lacks, which the renderer would leave out.
fn boxed(svg: &str) -> Cow<'_, str> {
    let has = |face: &Face<'_>, c: char| c.is_ascii() || face.glyph_index(c).is_some();
    match Face::parse(dejavu::sans::regular(), 0) {
        Ok(face) if !svg.is_ascii() => svg
            .chars()
            .map(|c| if has(&face, c) { c } else { '□' })
            .collect(),
        _ => svg.into(),
    }
}

/// Bytes of a PNG up to the end of its header.
const PNG_HEADER_BYTES: usize = 33;
/// The chunk of a PNG that names this program: length, type, keyword, text, check sum.
const SOFTWARE: &[u8] = b"\0\0\0\x17tEXtSoftware\0contact3d-pipe\x2a\xc3\xa9\x06";

/// An SVG document of ours as a PNG of the given width; the height follows from its shape.
///
/// # Errors
/// [`PngError::Width`] when the picture would be empty or too large, [`PngError::Failed`] when the renderer or the encoder fails.
pub(super) fn png(svg: &str, pixels_wide: u32) -> Result<Vec<u8>, PngError> {
    let options = Options {
        fontdb: FONTS.clone(),
        ..Options::default()
    };
    let tree =
        Tree::from_str(&boxed(svg), &options).map_err(|e| PngError::Failed(e.to_string()))?;
    let scale = pixels_wide as f32 / tree.size().width();
    let height = (scale * tree.size().height()).round() as u32;
    let fits = pixels_wide.max(height) < 100_000;
    let pixmap = fits.then(|| Pixmap::new(pixels_wide, height)).flatten();
    let mut pixmap = pixmap.ok_or(PngError::Width(pixels_wide))?;
    resvg::render(
        &tree,
        Transform::from_scale(scale, scale),
        &mut pixmap.as_mut(),
    );
    let png = pixmap.encode_png();
    let mut png = png.map_err(|error| PngError::Failed(error.to_string()))?;
    png.splice(PNG_HEADER_BYTES..PNG_HEADER_BYTES, SOFTWARE.iter().copied());
    Ok(png)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_never_negative_zero() {
        assert_eq!(number(1.5), "1.5");
        assert_eq!(number(100.0), "100");
        assert_eq!(number(-0.001), "0");
        assert_eq!(number(f64::NAN), "0");
    }
}
