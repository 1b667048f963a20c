//! A small scene builder that writes deterministic SVG 1.1.

use std::fmt::Write;

use super::text::{Label, escape};

/// A point on a canvas in its pixels, x to the right, y downwards.
pub(super) type Point = [f64; 2];

/// An sRGB colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Colour(pub(super) u8, pub(super) u8, pub(super) u8);

impl Colour {
    pub(super) const BLACK: Self = Self(0x1a, 0x1a, 0x1a);
    pub(super) const WHITE: Self = Self(0xff, 0xff, 0xff);
    pub(super) const GREY: Self = Self(0x77, 0x77, 0x77);

    fn hex(self) -> String {
        format!("#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
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
    pub(super) colour: Colour,
    /// Width in pixels.
    pub(super) width: f64,
    /// Length of dashes and of the spaces between them in pixels.
    pub(super) dash: Option<f64>,
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

/// A drawing of fixed size.
#[derive(Clone, Debug)]
pub(super) struct Canvas {
    /// Width in pixels.
    pub(super) width: f64,
    /// Height in pixels.
    pub(super) height: f64,
    elements: String,
}

/// The two fill patterns; every drawing of this module defines the same ones, so panels can be joined to a page.
const PATTERNS: &str = concat!(
    "<defs>\n",
    "<pattern id=\"no-value\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\">",
    "<rect width=\"6\" height=\"6\" fill=\"#d8d8d8\"/>",
    "<path d=\"M-1 1L1 -1M0 6L6 0M5 7L7 5\" stroke=\"#8a8a8a\" stroke-width=\"1\"/></pattern>\n",
    "<pattern id=\"open\" width=\"5\" height=\"5\" patternUnits=\"userSpaceOnUse\">",
    "<rect width=\"5\" height=\"5\" fill=\"#ffffff\"/>",
    "<path d=\"M-1 1L1 -1M0 5L5 0M4 6L6 4\" stroke=\"#c4c4c4\" stroke-width=\"0.7\"/></pattern>\n",
    "</defs>\n",
);

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
        self.path(loops, true, fill, stroke);
    }

    /// Open polylines with one stroke.
    pub(super) fn polylines(&mut self, lines: &[Vec<Point>], stroke: Stroke) {
        self.path(lines, false, Fill::Empty, Some(stroke));
    }

    /// A straight line.
    pub(super) fn line(&mut self, from: Point, to: Point, stroke: Stroke) {
        self.path(&[vec![from, to]], false, Fill::Empty, Some(stroke));
    }

    /// A rectangle with its upper left corner at `corner`.
    pub(super) fn rectangle(
        &mut self,
        corner: Point,
        size: Point,
        fill: Fill,
        stroke: Option<Stroke>,
    ) {
        let element = format!(
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"{}/>\n",
            number(corner[0]),
            number(corner[1]),
            number(size[0]),
            number(size[1]),
            paint(fill, stroke)
        );
        self.elements.push_str(&element);
    }

    /// An ellipse with axes along those of the canvas.
    pub(super) fn ellipse(
        &mut self,
        centre: Point,
        semi_axes: Point,
        fill: Fill,
        stroke: Option<Stroke>,
    ) {
        let element = format!(
            "<ellipse cx=\"{}\" cy=\"{}\" rx=\"{}\" ry=\"{}\"{}/>\n",
            number(centre[0]),
            number(centre[1]),
            number(semi_axes[0]),
            number(semi_axes[1]),
            paint(fill, stroke)
        );
        self.elements.push_str(&element);
    }

    /// A label with its baseline at `position`.
    pub(super) fn text(&mut self, position: Point, label: &Label, size: f64, anchor: Anchor) {
        self.write_text(position, label, size, anchor, "");
    }

    /// A bold label with its baseline at `position`.
    pub(super) fn bold_text(&mut self, position: Point, label: &Label, size: f64, anchor: Anchor) {
        self.write_text(position, label, size, anchor, " font-weight=\"bold\"");
    }

    /// A label centred at `position` that reads upwards.
    pub(super) fn vertical_text(&mut self, position: Point, label: &Label, size: f64) {
        let turn = format!(
            " transform=\"rotate(-90 {} {})\"",
            number(position[0]),
            number(position[1])
        );
        self.write_text(position, label, size, Anchor::Middle, &turn);
    }

    /// What `draw` draws, with a text that shows when the reader points at it.
    pub(super) fn titled(&mut self, title: &str, draw: impl FnOnce(&mut Self)) {
        self.elements
            .push_str(&format!("<g><title>{}</title>\n", escape(title)));
        draw(self);
        self.elements.push_str("</g>\n");
    }

    /// Copies another canvas with its upper left corner to `corner`.
    pub(super) fn place(&mut self, other: &Self, corner: Point) {
        let open = format!(
            "<g transform=\"translate({} {})\">\n",
            number(corner[0]),
            number(corner[1])
        );
        self.elements.push_str(&open);
        self.elements.push_str(&other.elements);
        self.elements.push_str("</g>\n");
    }

    /// The whole SVG document, with `title` as its accessible name.
    pub(super) fn document(&self, title: &str) -> String {
        let (width, height) = (number(self.width), number(self.height));
        let patterns = if self.elements.contains("url(#") {
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
             <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n{}</svg>\n",
            Colour::BLACK.hex(),
            escape(title),
            self.elements
        )
    }

    fn path(&mut self, lines: &[Vec<Point>], closed: bool, fill: Fill, stroke: Option<Stroke>) {
        let mut data = String::new();
        for line in lines {
            for (index, point) in line.iter().enumerate() {
                data.push(if index == 0 { 'M' } else { 'L' });
                data.push_str(&number(point[0]));
                data.push(' ');
                data.push_str(&number(point[1]));
            }
            if closed {
                data.push('Z');
            }
        }
        let element = format!(
            "<path d=\"{data}\" fill-rule=\"evenodd\"{}/>\n",
            paint(fill, stroke)
        );
        self.elements.push_str(&element);
    }

    fn write_text(
        &mut self,
        position: Point,
        label: &Label,
        size: f64,
        anchor: Anchor,
        attributes: &str,
    ) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let element = format!(
            "<text x=\"{}\" y=\"{}\" font-size=\"{}\" text-anchor=\"{anchor}\"{attributes}>{}</text>\n",
            number(position[0]),
            number(position[1]),
            number(size),
            label.markup(size)
        );
        self.elements.push_str(&element);
    }
}

/// Fill and stroke as SVG attributes.
fn paint(fill: Fill, stroke: Option<Stroke>) -> String {
    let mut attributes = match fill {
        Fill::Empty => " fill=\"none\"".to_owned(),
        Fill::Plain(colour) => format!(" fill=\"{}\"", colour.hex()),
        Fill::NoValue => " fill=\"url(#no-value)\"".to_owned(),
        Fill::Open => " fill=\"url(#open)\"".to_owned(),
    };
    if let Some(stroke) = stroke {
        let colour = stroke.colour.hex();
        let width = number(stroke.width);
        // Writing to a String cannot fail.
        let _ = write!(
            attributes,
            " stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linejoin=\"round\""
        );
        match stroke.dash {
            Some(dash) => {
                let _ = write!(attributes, " stroke-dasharray=\"{}\"", number(dash));
            }
            None => attributes.push_str(" stroke-linecap=\"round\""),
        }
    }
    attributes
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
