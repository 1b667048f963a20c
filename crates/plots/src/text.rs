//! Labels made of upright, italic, lowered and raised runs, and the outlines of their letters.

use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// Size of a lowered or raised run relative to its label.
const SCRIPT_SIZE: f64 = 0.74;

/// Vertical shift of a lowered or raised run relative to the size of its label.
const SCRIPT_SHIFT: f64 = 0.28;

/// Form of one run of a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RunStyle {
    Upright,
    Italic,
    Subscript,
    Superscript,
}

/// A one-line label with mathematical symbols, such as σ with the subscript ν.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Label {
    runs: Vec<(RunStyle, String)>,
}

/// A part of a label that is set in one style.
#[derive(Clone, Copy, Debug)]
pub(super) struct TextRun<'a> {
    pub(super) text: &'a str,
    pub(super) italic: bool,
    /// Font size, in the unit of the label's size.
    pub(super) size: f64,
    /// Distance of its baseline below that of the label, in the same unit.
    pub(super) drop: f64,
}

impl Label {
    /// A label of one upright run.
    pub(super) fn plain(text: impl Into<String>) -> Self {
        Self::default().upright(text)
    }

    /// Appends an upright run.
    pub(super) fn upright(self, text: impl Into<String>) -> Self {
        self.with(RunStyle::Upright, text.into())
    }

    /// Appends an italic run, for mathematical symbols.
    pub(super) fn italic(self, text: impl Into<String>) -> Self {
        self.with(RunStyle::Italic, text.into())
    }

    /// Appends a small lowered run.
    pub(super) fn subscript(self, text: impl Into<String>) -> Self {
        self.with(RunStyle::Subscript, text.into())
    }

    /// Appends a small raised run.
    pub(super) fn superscript(self, text: impl Into<String>) -> Self {
        self.with(RunStyle::Superscript, text.into())
    }

    /// Appends all runs of another label.
    pub(super) fn then(mut self, other: &Self) -> Self {
        self.runs.extend(other.runs.iter().cloned());
        self
    }

    /// The label without the brackets around it.
    pub(super) fn without_brackets(mut self) -> Self {
        if let Some((_, first)) = self.runs.first_mut() {
            *first = first.trim_start_matches('[').to_owned();
        }
        if let Some((_, last)) = self.runs.last_mut() {
            *last = last.trim_end_matches(']').to_owned();
        }
        self
    }

    fn with(mut self, form: RunStyle, text: String) -> Self {
        if !text.is_empty() {
            self.runs.push((form, text));
        }
        self
    }

    /// Estimated width at font size `size`, in the unit of `size`.
    pub(super) fn width(&self, size: f64) -> f64 {
        let estimate = |run: TextRun<'_>| run.size * run.text.chars().map(advance).sum::<f64>();
        size * self.runs(1.0).map(estimate).sum::<f64>()
    }

    /// The runs of the label at font size `size`.
    pub(super) fn runs(&self, size: f64) -> impl Iterator<Item = TextRun<'_>> {
        self.runs.iter().map(move |(form, text)| {
            let (italic, scale, drop) = match form {
                RunStyle::Upright => (false, 1.0, 0.0),
                RunStyle::Italic => (true, 1.0, 0.0),
                RunStyle::Subscript => (false, SCRIPT_SIZE, SCRIPT_SHIFT * size),
                RunStyle::Superscript => (false, SCRIPT_SIZE, -1.3 * SCRIPT_SHIFT * size),
            };
            TextRun {
                text,
                italic,
                size: scale * size,
                drop,
            }
        })
    }

    /// The content of an SVG `text` element of font size `size`.
    pub(super) fn markup(&self, size: f64) -> String {
        let mut markup = String::new();
        let mut level = 0.0;
        for run in self.runs(size) {
            let mut attributes = String::new();
            if run.drop != level {
                attributes.push_str(&format!(" dy=\"{:.2}\"", run.drop - level));
            }
            if run.italic {
                attributes.push_str(" font-style=\"italic\"");
            }
            if run.size != size {
                attributes.push_str(&format!(" font-size=\"{:.2}\"", run.size));
            }
            level = run.drop;
            let text = escape(run.text);
            if attributes.is_empty() {
                markup.push_str(&text);
            } else {
                markup.push_str(&format!("<tspan{attributes}>{text}</tspan>"));
            }
        }
        markup
    }
}

/// Escapes a string for use as XML character data or attribute value.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars().map(shown) {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&apos;"),
            c => escaped.push(c),
        }
    }
    escaped
}

/// What stands for a character: control characters that XML 1.0 forbids become the replacement character, and line
/// ends and tabs become spaces.
pub(super) fn shown(character: char) -> char {
    match character {
        '\t' | '\n' | '\r' => ' ',
        '\u{fffe}' | '\u{ffff}' => '\u{fffd}',
        c if c < ' ' => '\u{fffd}',
        c => c,
    }
}

/// The longest beginning of `text` that fits in `width`, with an ellipsis where something was cut off.
pub(super) fn fitted(text: &str, size: f64, width: f64) -> String {
    if Label::plain(text).width(size) <= width {
        return text.to_owned();
    }
    let room = width - size * advance('…');
    let mut used = 0.0;
    let kept: String = text
        .chars()
        .take_while(|&c| {
            used += size * advance(c);
            used <= room
        })
        .collect();
    format!("{}…", kept.trim_end())
}

/// Estimated advance width of a character of DejaVu Sans in em; wide enough for narrower sans-serif fonts.
fn advance(character: char) -> f64 {
    match character {
        ' ' | '.' | ',' | 'i' | 'j' | 'l' => 0.32,
        '(' | ')' | '[' | ']' | 'f' | 't' | 'r' | '-' | ':' | ';' | '|' | '/' | 'I' => 0.40,
        '0'..='9' => 0.637,
        'm' | 'w' | 'M' | 'W' | '%' | '@' | '…' => 1.0,
        '+' | '−' | '=' | '×' | '<' | '>' | '~' => 0.838,
        'A'..='Z' => 0.74,
        'a'..='z' => 0.61,
        '‖' => 0.5,
        c if (c as u32) < 0x1100 => 0.68,
        _ => 1.05,
    }
}

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
                    &mut PlacedGlyph {
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
    fn glyph(&self, character: char, run: &TextRun<'_>, bold: bool) -> (&Face<'static>, GlyphId) {
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
struct PlacedGlyph<'a> {
    path: &'a mut PathBuilder,
    origin: [f64; 2],
    scale: f64,
}

impl PlacedGlyph<'_> {
    fn at(&self, x: f32, y: f32) -> [f32; 2] {
        [
            self.origin[0] + self.scale * f64::from(x),
            self.origin[1] - self.scale * f64::from(y),
        ]
        .map(single)
    }
}

impl OutlineBuilder for PlacedGlyph<'_> {
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
