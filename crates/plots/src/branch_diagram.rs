//! Bifurcation diagrams: paths of solutions with their stability and their special points.

use super::{
    canvas::{Canvas, Colour, Fill, Point, Stroke},
    line_chart::{
        BOTTOM, ChartAxis, HEIGHT, LEFT, LEGEND_LINE, LEGEND_WIDTH, PlacedAxis, TOP, WIDTH,
        draw_frame, draw_name, titled_canvas,
    },
    picture::Picture,
};

const MARKER: f64 = 4.4;
const DASH: f64 = 5.0;
const DOT: f64 = 1.8;

/// How the solutions of a curve behave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveKind {
    /// Successive approximations converge to them.
    Attracting,
    /// They do not, and det R' > 0.
    Repelling,
    /// det R' < 0.
    NegativeDeterminant,
}

/// What is special about a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkKind {
    /// The parameter turns back.
    Fold,
    /// Panes or nodes change.
    Kink,
    /// Paths meet.
    BranchPoint,
    /// The path ends inside the range.
    End,
}

/// A part of a path along which the solutions behave alike.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// How they behave.
    pub kind: CurveKind,
    /// Places in the diagram.
    pub points: Vec<[f64; 2]>,
}

/// A special point.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// What it is.
    pub kind: MarkKind,
    /// Its place in the diagram.
    pub at: [f64; 2],
    /// What it says when pointed at.
    pub text: String,
}

/// Paths of solutions over a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct BranchDiagram {
    /// Title above the diagram.
    pub title: String,
    /// The parameter.
    pub x: ChartAxis,
    /// A quantity of the solutions.
    pub y: ChartAxis,
    /// The paths in parts.
    pub curves: Vec<Curve>,
    /// Special points.
    pub marks: Vec<Mark>,
}

impl CurveKind {
    const ALL: [Self; 3] = [Self::Attracting, Self::Repelling, Self::NegativeDeterminant];

    fn stroke(self) -> Stroke {
        match self {
            Self::Attracting => Stroke::solid(Colour(0x00, 0x72, 0xb2), 2.0),
            Self::Repelling => Stroke::dashed(Colour(0x00, 0x9e, 0x73), 1.8, DASH),
            Self::NegativeDeterminant => Stroke::dashed(Colour(0xd5, 0x5e, 0x00), 1.8, DOT),
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Attracting => "attracting, ρ(Ψ') < 1",
            Self::Repelling => "not attracting, det R' > 0",
            Self::NegativeDeterminant => "det R' < 0",
        }
    }
}

impl MarkKind {
    const ALL: [Self; 4] = [Self::Fold, Self::Kink, Self::BranchPoint, Self::End];

    fn words(self) -> &'static str {
        match self {
            Self::Fold => "fold",
            Self::Kink => "kink",
            Self::BranchPoint => "branch point",
            Self::End => "end inside the range",
        }
    }

    fn draw(self, canvas: &mut Canvas, [x, y]: Point) {
        let edge = Some(Stroke::solid(Colour::BLACK, 1.0));
        let r = MARKER;
        match self {
            Self::Fold => canvas.ellipse([x, y], [r; 2], Fill::Plain(Colour::WHITE), edge),
            Self::Kink => canvas.ellipse([x, y], [0.6 * r; 2], Fill::Plain(Colour::GREY), None),
            Self::BranchPoint => {
                let corners = [[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]];
                let corners = corners.map(|[a, b]| [x + a * r, y + b * r]);
                canvas.region(&[corners.to_vec()], Fill::Plain(Colour::BLACK), None);
            }
            Self::End => {
                let black = Stroke::solid(Colour::BLACK, 1.6);
                canvas.line([x - r, y - r], [x + r, y + r], black);
                canvas.line([x - r, y + r], [x + r, y - r], black);
            }
        }
    }
}

impl BranchDiagram {
    /// Draws the diagram. Points that an axis cannot show are left out.
    #[must_use]
    pub fn figure(&self) -> Picture {
        let mut canvas = titled_canvas(&self.title);
        let right = WIDTH - LEGEND_WIDTH;
        let drawn = || {
            let points = self.curves.iter().flat_map(|curve| &curve.points);
            points.filter(|point| self.is_drawn(**point))
        };
        let x = PlacedAxis::new(&self.x, drawn().map(|p| p[0]), [LEFT, right]);
        let y = PlacedAxis::new(&self.y, drawn().map(|p| p[1]), [HEIGHT - BOTTOM, TOP]);
        draw_frame(&mut canvas, &x, &y);
        let place = |[a, b]: [f64; 2]| [x.pixel(a), y.pixel(b)];
        for curve in &self.curves {
            let points = curve.points.iter().filter(|p| self.is_drawn(**p));
            let line: Vec<Point> = points.map(|p| place(*p)).collect();
            if line.len() > 1 {
                canvas.polylines(&[line], curve.kind.stroke());
            }
        }
        for mark in self.marks.iter().filter(|mark| self.is_drawn(mark.at)) {
            let at = place(mark.at);
            canvas.titled(&mark.text, |canvas| mark.kind.draw(canvas, at));
        }
        self.draw_legend(&mut canvas, right + 16.0);
        Picture::new(canvas, &self.title)
    }

    fn is_drawn(&self, point: [f64; 2]) -> bool {
        self.x.shows(point[0]) && self.y.shows(point[1])
    }

    fn draw_legend(&self, canvas: &mut Canvas, x: f64) {
        let mut y = TOP + 14.0;
        let mut entry = |words: &str, draw: &dyn Fn(&mut Canvas, f64)| {
            draw(canvas, y);
            draw_name(canvas, words, [x, y]);
            y += LEGEND_LINE;
        };
        for kind in CurveKind::ALL {
            if self.curves.iter().any(|curve| curve.kind == kind) {
                entry(kind.words(), &|canvas, y| {
                    canvas.line([x, y], [x + 26.0, y], kind.stroke());
                });
            }
        }
        for kind in MarkKind::ALL {
            if self.marks.iter().any(|mark| mark.kind == kind) {
                entry(kind.words(), &|canvas, y| kind.draw(canvas, [x + 13.0, y]));
            }
        }
    }
}
