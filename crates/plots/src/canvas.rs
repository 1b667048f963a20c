//! A small scene builder: what is drawn, before it becomes SVG or PNG.

use super::text::Label;

/// A point on a canvas in its pixels, x to the right, y downwards.
pub(super) type Point = [f64; 2];

/// An sRGB colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Colour(pub(super) u8, pub(super) u8, pub(super) u8);

impl Colour {
    pub(super) const BLACK: Self = Self(0x1a, 0x1a, 0x1a);
    pub(super) const WHITE: Self = Self(0xff, 0xff, 0xff);
    pub(super) const GREY: Self = Self(0x77, 0x77, 0x77);
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

/// The outline of a shape.
#[derive(Clone, Debug)]
pub(super) enum Outline {
    /// Closed loops that together bound one even–odd region.
    Loops(Vec<Vec<Point>>),
    /// Open polylines.
    Lines(Vec<Vec<Point>>),
    /// A rectangle: upper left corner and size.
    Rectangle(Point, Point),
    /// An ellipse with axes along those of the canvas: centre and semi-axes.
    Ellipse(Point, Point),
}

/// How a line of text is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Setting {
    Plain,
    Bold,
    /// Reads upwards.
    Upwards,
}

/// A line of text on a canvas.
#[derive(Clone, Debug)]
pub(super) struct Text {
    /// The point of the baseline that `anchor` names.
    pub(super) position: Point,
    pub(super) label: Label,
    /// Font size in pixels.
    pub(super) size: f64,
    pub(super) anchor: Anchor,
    pub(super) setting: Setting,
}

/// One thing on a canvas.
#[derive(Clone, Debug)]
pub(super) enum DrawnElement {
    Shape {
        outline: Outline,
        fill: Fill,
        stroke: Option<Stroke>,
    },
    Text(Text),
    /// Elements with a text that shows when the reader points at them.
    Titled(String, Vec<Self>),
    /// Elements moved by a vector.
    Moved(Point, Vec<Self>),
}

/// A drawing of fixed size; later elements cover earlier ones.
#[derive(Clone, Debug)]
pub(super) struct Canvas {
    /// Width in pixels.
    pub(super) width: f64,
    /// Height in pixels.
    pub(super) height: f64,
    pub(super) elements: Vec<DrawnElement>,
}

impl Canvas {
    /// An empty canvas.
    pub(super) fn new(width: f64, height: f64) -> Self {
        Self {
            width,
            height,
            elements: Vec::new(),
        }
    }

    /// Closed loops that together bound one even–odd region.
    pub(super) fn region(&mut self, loops: &[Vec<Point>], fill: Fill, stroke: Option<Stroke>) {
        self.shape(Outline::Loops(loops.to_vec()), fill, stroke);
    }

    /// Open polylines with one stroke.
    pub(super) fn polylines(&mut self, lines: &[Vec<Point>], stroke: Stroke) {
        self.shape(Outline::Lines(lines.to_vec()), Fill::Empty, Some(stroke));
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
        self.shape(Outline::Rectangle(corner, size), fill, stroke);
    }

    /// An ellipse with axes along those of the canvas.
    pub(super) fn ellipse(
        &mut self,
        centre: Point,
        semi_axes: Point,
        fill: Fill,
        stroke: Option<Stroke>,
    ) {
        self.shape(Outline::Ellipse(centre, semi_axes), fill, stroke);
    }

    /// A label with its baseline at `position`.
    pub(super) fn text(&mut self, position: Point, label: &Label, size: f64, anchor: Anchor) {
        self.set(position, label, size, anchor, Setting::Plain);
    }

    /// A bold label with its baseline at `position`.
    pub(super) fn bold_text(&mut self, position: Point, label: &Label, size: f64, anchor: Anchor) {
        self.set(position, label, size, anchor, Setting::Bold);
    }

    /// A label centred at `position` that reads upwards.
    pub(super) fn vertical_text(&mut self, position: Point, label: &Label, size: f64) {
        self.set(position, label, size, Anchor::Middle, Setting::Upwards);
    }

    /// What `draw` draws, with a text that shows when the reader points at it.
    pub(super) fn titled(&mut self, title: &str, draw: impl FnOnce(&mut Self)) {
        let outer = std::mem::take(&mut self.elements);
        draw(self);
        let inner = std::mem::replace(&mut self.elements, outer);
        self.elements
            .push(DrawnElement::Titled(title.to_owned(), inner));
    }

    /// Copies another canvas with its upper left corner to `corner`.
    pub(super) fn place(&mut self, other: &Self, corner: Point) {
        let elements = other.elements.clone();
        self.elements.push(DrawnElement::Moved(corner, elements));
    }

    fn shape(&mut self, outline: Outline, fill: Fill, stroke: Option<Stroke>) {
        self.elements.push(DrawnElement::Shape {
            outline,
            fill,
            stroke,
        });
    }

    fn set(&mut self, position: Point, label: &Label, size: f64, anchor: Anchor, setting: Setting) {
        self.elements.push(DrawnElement::Text(Text {
            position,
            label: label.clone(),
            size,
            anchor,
            setting,
        }));
    }
}
