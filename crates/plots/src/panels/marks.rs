//! Symbols of clamps, springs, prescribed displacements and loads on the deformed body, and their legend.

use crate::canvas::{Anchor, Canvas, Colour, Fill, Point, Stroke};
use crate::layout::TICK_SIZE;
use crate::picture::{BodyMark, BodyMarkKind};
use crate::text::Label;
use crate::view::{Vector, View, dot, norm, scaled};

/// Most symbols of one mark.
const MOST_SYMBOLS: usize = 5;
/// Pixels of the longest arrow, of a shorter one that is left out, and of other symbols.
pub(super) const ARROW: f64 = 34.0;
const SHORTEST_ARROW: f64 = 8.0;
const SYMBOL: f64 = 9.0;
const LOAD: Colour = Colour(0x00, 0x6d, 0x2c);

/// How a symbol looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shape {
    /// Held along all axes.
    Square,
    /// Held along one axis.
    Cone,
    Spring,
    Moved,
    Load,
}

/// One symbol on the canvas.
#[derive(Clone, Copy, Debug)]
pub(super) struct Symbol {
    shape: Shape,
    /// Where it touches the body.
    at: Point,
    /// From there to its other end.
    way: Point,
    /// Whether the head of an arrow is where it touches.
    pushes: bool,
}

impl Symbol {
    fn draw(&self, canvas: &mut Canvas) {
        let ([x, y], [right, down]) = (self.at, self.way);
        let end = [x + right, y + down];
        match self.shape {
            Shape::Square => {
                let corner = [x - SYMBOL / 2.0, y - SYMBOL / 2.0];
                let edge = Stroke::solid(Colour::WHITE, 1.2);
                let black = Fill::Plain(Colour::BLACK);
                canvas.rectangle(corner, [SYMBOL; 2], black, Some(edge));
            }
            Shape::Cone => {
                let [a, b] = [0.5, -0.5].map(|side| [end[0] - side * down, end[1] + side * right]);
                let edge = Stroke::solid(Colour::WHITE, 1.0);
                let black = Fill::Plain(Colour::BLACK);
                canvas.region(&[vec![self.at, a, b]], black, Some(edge));
            }
            Shape::Spring => {
                let turn = |k: i32| {
                    let (share, side) = (f64::from(k) / 6.0, [0.0, 0.3, 0.0, -0.3][k as usize % 4]);
                    [
                        x + share * right - side * down,
                        y + share * down + side * right,
                    ]
                };
                let line: Vec<Point> = (0..=6).map(turn).collect();
                let line = [line];
                canvas.polylines(&line, Stroke::solid(Colour::WHITE, 3.4));
                canvas.polylines(&line, Stroke::solid(Colour::BLACK, 1.4));
            }
            Shape::Moved | Shape::Load => {
                let [from, to] = if self.pushes {
                    [end, self.at]
                } else {
                    [self.at, end]
                };
                let is_load = self.shape == Shape::Load;
                arrow(canvas, from, to, if is_load { LOAD } else { Colour::BLACK });
            }
        }
    }
}

/// An arrow with a white edge, readable on any colour.
fn arrow(canvas: &mut Canvas, from: Point, to: Point, colour: Colour) {
    let [right, down] = [to[0] - from[0], to[1] - from[1]];
    let length = right.hypot(down);
    let [along, across] = [right / length, down / length];
    let back = |by: f64, side: f64| {
        [
            to[0] - by * along - side * across,
            to[1] - by * across + side * along,
        ]
    };
    let head = [vec![to, back(9.0, 3.8), back(9.0, -3.8)]];
    canvas.line(from, back(7.0, 0.0), Stroke::solid(Colour::WHITE, 4.2));
    let edge = Stroke::solid(Colour::WHITE, 1.4);
    canvas.region(&head, Fill::Plain(colour), Some(edge));
    canvas.line(from, back(7.0, 0.0), Stroke::solid(colour, 1.9));
}

/// What symbols are placed by.
pub(super) struct Sight<'a> {
    pub(super) view: &'a View,
    /// Whether a node belongs to a facet that the viewer sees.
    pub(super) is_seen: &'a [bool],
    /// Pixels of the nodes.
    pub(super) pixels: &'a [Point],
}

impl Sight<'_> {
    /// The symbols of all marks: few of each, spread over what is seen of it, none on another. Each mark has its first before any has
    /// its second.
    pub(super) fn symbols(&self, marks: &[BodyMark]) -> Vec<Symbol> {
        let mut symbols: Vec<Symbol> = Vec::new();
        let mut chosen = vec![Vec::new(); marks.len()];
        for round in 0..MOST_SYMBOLS {
            for (mark, chosen) in marks.iter().zip(&mut chosen) {
                let next = if round < most(mark) {
                    self.next_place(mark, chosen, &symbols)
                } else {
                    None
                };
                if let Some(place) = next {
                    chosen.push(place);
                    symbols.extend(self.symbols_at(mark, place, largest(mark)));
                }
            }
        }
        symbols
    }

    /// A vector of length 1 at most as pixels of a symbol.
    fn on_screen(&self, vector: Vector, size: f64) -> Point {
        let [right, up, _] = self.view.projected(self.view.turned(vector));
        [size * right, -size * up]
    }

    /// A cone of one size from wherever it is seen, upright where it points at the viewer.
    fn cone(&self, away: Vector) -> Point {
        let [right, down] = self.on_screen(away, 1.0);
        let length = right.hypot(down);
        if length < 0.05 {
            return [0.0, 1.2 * SYMBOL];
        }
        [right, down].map(|c| 1.2 * SYMBOL * c / length)
    }

    fn symbols_at(&self, mark: &BodyMark, place: usize, largest: f64) -> Vec<Symbol> {
        let (at, normal) = (self.pixels[mark.nodes[place]], mark.normals[place]);
        let symbol = |shape, way: Point, pushes| Symbol {
            shape,
            at,
            way,
            pushes,
        };
        let vector = mark.vectors[place];
        match mark.kind {
            BodyMarkKind::Held if vector.iter().all(|&held| held != 0.0) => {
                vec![symbol(Shape::Square, [0.0; 2], false)]
            }
            BodyMarkKind::Held => {
                let axes = (0..3).filter(|&c| vector[c] != 0.0);
                let cones = axes.map(|c| {
                    let mut away = [0.0; 3];
                    away[c] = if normal[c] > 0.1 { 1.0 } else { -1.0 };
                    symbol(Shape::Cone, self.cone(away), false)
                });
                cones.collect()
            }
            BodyMarkKind::Spring => {
                let way = self.on_screen(normal, 2.0 * SYMBOL);
                vec![symbol(Shape::Spring, way, false)]
            }
            BodyMarkKind::Moved | BodyMarkKind::Load | BodyMarkKind::Volume => {
                let pushes = dot(vector, normal) < -0.1 * norm(vector);
                let sign = if pushes { -1.0 } else { 1.0 };
                let way = self.on_screen(scaled(vector, sign / largest), ARROW);
                let is_drawn = way[0].hypot(way[1]) >= SHORTEST_ARROW;
                let shape = match mark.kind {
                    BodyMarkKind::Moved => Shape::Moved,
                    _ => Shape::Load,
                };
                let drawn = is_drawn.then(|| symbol(shape, way, pushes));
                drawn.into_iter().collect()
            }
        }
    }

    /// The next place of a mark, apart from all symbols: its middle, then always the place farthest from those before.
    fn next_place(&self, mark: &BodyMark, chosen: &[usize], symbols: &[Symbol]) -> Option<usize> {
        let pixel = |place: usize| self.pixels[mark.nodes[place]];
        let away = |place: usize, others: &mut dyn Iterator<Item = Point>| {
            let [x, y] = pixel(place);
            others.fold(f64::MAX, |least, o| least.min((x - o[0]).hypot(y - o[1])))
        };
        let seen = (0..mark.nodes.len()).filter(|&place| self.is_seen[mark.nodes[place]]);
        // Least distance of two symbols in pixels.
        let free: Vec<usize> = seen
            .filter(|&place| away(place, &mut symbols.iter().map(|symbol| symbol.at)) >= 28.0)
            .collect();
        let count = free.len().max(1) as f64;
        let middle = [0, 1].map(|c| free.iter().map(|&place| pixel(place)[c]).sum::<f64>() / count);
        let rank = |place: &usize| match chosen {
            [] => -away(*place, &mut [middle].into_iter()),
            _ => away(*place, &mut chosen.iter().map(|&place| pixel(place))),
        };
        let places = free.iter().copied();
        places.max_by(|a, b| rank(a).total_cmp(&rank(b)).then(b.cmp(a)))
    }
}

/// The longest vector of a mark.
fn largest(mark: &BodyMark) -> f64 {
    mark.vectors.iter().map(|&v| norm(v)).fold(0.0, f64::max)
}

/// Most symbols of a mark.
fn most(mark: &BodyMark) -> usize {
    let is_all = || mark.vectors.iter().flatten().all(|&held| held != 0.0);
    match mark.kind {
        BodyMarkKind::Volume => 1,
        // Most of what is held along an axis, where planes of symmetry meet in corners.
        BodyMarkKind::Held if !is_all() => 3,
        _ => MOST_SYMBOLS,
    }
}

/// Draws the symbols, and a legend of those there are from a point to the right.
pub(super) fn draw_symbols(canvas: &mut Canvas, symbols: &[Symbol], from: Point) {
    symbols.iter().for_each(|symbol| symbol.draw(canvas));
    let [mut x, y] = from;
    let legend: [(Shape, &str, Point, Point); 5] = [
        (Shape::Square, "held", [SYMBOL / 2.0, 0.0], [0.0; 2]),
        (Shape::Cone, "held along an axis", [5.0, -6.0], [0.0, 12.0]),
        (Shape::Spring, "springs", [0.0; 2], [18.0, 0.0]),
        (Shape::Moved, "moved", [0.0; 2], [22.0, 0.0]),
        (Shape::Load, "load", [0.0; 2], [22.0, 0.0]),
    ];
    for (shape, word, [right, down], way) in legend {
        if !symbols.iter().any(|symbol| symbol.shape == shape) {
            continue;
        }
        let shown = Symbol {
            shape,
            at: [x + right, y - 4.0 + down],
            way,
            pushes: false,
        };
        shown.draw(canvas);
        x += way[0].max(2.0 * right) + 6.0;
        let label = Label::plain(word);
        canvas.text([x, y], &label, TICK_SIZE, Anchor::Start);
        x += label.width(TICK_SIZE) + 18.0;
    }
}
