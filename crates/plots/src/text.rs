//! Labels made of upright, italic, lowered and raised runs.

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

impl RunStyle {
    /// Its font size and the distance of its baseline below that of the label, relative to the font size of the label.
    fn size_and_drop(self) -> (f64, f64) {
        match self {
            Self::Upright | Self::Italic => (1.0, 0.0),
            Self::Subscript => (0.74, SCRIPT_SHIFT),
            Self::Superscript => (0.74, -1.3 * SCRIPT_SHIFT),
        }
    }
}

/// A one-line label with mathematical symbols, such as σ with the subscript ν.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Label {
    runs: Vec<(RunStyle, String)>,
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
        let runs = self.runs.iter();
        let widths = runs.map(|(style, text)| {
            let (scale, _) = style.size_and_drop();
            scale * text.chars().map(advance).sum::<f64>()
        });
        size * widths.sum::<f64>()
    }

    /// The content of an SVG `text` element of font size `size`.
    pub(super) fn markup(&self, size: f64) -> String {
        let mut markup = String::new();
        let mut level = 0.0;
        for (style, text) in &self.runs {
            let mut attributes = String::new();
            let (scale, drop) = style.size_and_drop();
            if drop != level {
                attributes.push_str(&format!(" dy=\"{:.2}\"", (drop - level) * size));
            }
            if *style == RunStyle::Italic {
                attributes.push_str(" font-style=\"italic\"");
            }
            if scale != 1.0 {
                attributes.push_str(&format!(" font-size=\"{:.2}\"", scale * size));
            }
            level = drop;
            let text = escape(text);
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
