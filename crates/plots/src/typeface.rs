//! Text as outlines of DejaVu Sans, which the program carries with it: no fonts of the system are needed.

use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

use super::text::{Label, Run, shown};

/// The four faces of the font.
pub(super) struct Typeface {
    upright: Face<'static>,
    italic: Face<'static>,
    bold: Face<'static>,
    bold_italic: Face<'static>,
}

/// A label as one outline that starts at the origin, y downwards.
pub(super) struct Line {
    /// `None` when the label shows nothing.
    pub(super) outline: Option<Path>,
    /// Where the label ends, without blanks at its end.
    pub(super) width: f64,
}

impl Typeface {
    /// Reads the faces.
    ///
    /// # Panics
    /// Never: the fonts are part of the program.
    pub(super) fn new() -> Self {
        let face = |bytes| Face::parse(bytes, 0).expect("an embedded font is valid");
        Self {
            upright: face(dejavu::sans::regular()),
            italic: face(dejavu::sans::oblique()),
            bold: face(dejavu::sans::bold()),
            bold_italic: face(dejavu::sans::bold_oblique()),
        }
    }

    /// Sets a label: glyph by glyph from left to right, with kerning and ligatures, and with blanks as SVG treats them
    /// (those at the ends vanish, several become one).
    pub(super) fn set(&self, label: &Label, size: f64, bold: bool) -> Line {
        let mut line = Line {
            outline: None,
            width: 0.0,
        };
        let mut path = PathBuilder::new();
        let mut pen = 0.0;
        let mut after_blank = true;
        for run in label.runs(size) {
            let mut previous = None;
            for character in joined(run.text).chars() {
                let blank = character == ' ';
                if blank && after_blank {
                    continue;
                }
                after_blank = blank;
                let (face, glyph) = self.glyph(character, &run, bold);
                let scale = run.size / f64::from(face.units_per_em());
                pen += scale * f64::from(kerning(face, previous, glyph));
                face.outline_glyph(
                    glyph,
                    &mut Placed {
                        path: &mut path,
                        origin: [pen, run.drop],
                        scale,
                    },
                );
                pen += scale * f64::from(face.glyph_hor_advance(glyph).unwrap_or(0));
                if !blank {
                    line.width = pen;
                }
                previous = Some(glyph);
            }
        }
        line.outline = path.finish();
        line
    }

    /// The glyph of a character in the face of its run, or upright where that face lacks it; the box that stands for
    /// an unknown character where both do.
    fn glyph(&self, character: char, run: &Run<'_>, bold: bool) -> (&Face<'static>, GlyphId) {
        let face = match (run.italic, bold) {
            (false, false) => &self.upright,
            (true, false) => &self.italic,
            (false, true) => &self.bold,
            (true, true) => &self.bold_italic,
        };
        [face, &self.upright]
            .into_iter()
            .find_map(|face| Some((face, face.glyph_index(character)?)))
            .unwrap_or((face, GlyphId(0)))
    }
}

/// A text with its ligatures, as characters that the font has.
fn joined(text: &str) -> String {
    let text: String = text.chars().map(shown).collect();
    text.replace("ffi", "\u{fb03}")
        .replace("ffl", "\u{fb04}")
        .replace("ff", "\u{fb00}")
        .replace("fi", "\u{fb01}")
        .replace("fl", "\u{fb02}")
}

/// What the distance of two neighbours differs from the first one's advance, in units of the font.
fn kerning(face: &Face<'_>, left: Option<GlyphId>, right: GlyphId) -> i16 {
    let (Some(left), Some(table)) = (left, face.tables().kern) else {
        return 0;
    };
    table
        .subtables
        .into_iter()
        .filter(|pairs| pairs.horizontal && !pairs.variable)
        .find_map(|pairs| pairs.glyphs_kerning(left, right))
        .unwrap_or(0)
}

/// A glyph at its place on the line; the font's own y axis points upwards.
struct Placed<'a> {
    path: &'a mut PathBuilder,
    origin: [f64; 2],
    scale: f64,
}

impl Placed<'_> {
    fn at(&self, x: f32, y: f32) -> [f32; 2] {
        [
            self.origin[0] + self.scale * f64::from(x),
            self.origin[1] - self.scale * f64::from(y),
        ]
        .map(single)
    }
}

impl OutlineBuilder for Placed<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        let [x, y] = self.at(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let [x, y] = self.at(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ([x1, y1], [x, y]) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ([x1, y1], [x2, y2], [x, y]) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "single precision of tiny-skia"
)]
pub(super) fn single(value: f64) -> f32 {
    value as f32
}
