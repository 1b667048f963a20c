//! A canvas of vectors as deterministic SVG 1.1.

use std::fmt::Write;

use super::{
    canvas::{Anchor, Canvas, Colour, DrawnElement, Fill, Outline, Point, Setting, Stroke, Text},
    colour::Hatch,
    text::escape,
};

/// The whole document, with `title` as its accessible name.
pub(super) fn document(canvas: &Canvas, title: &str) -> String {
    let (width, height) = (number(canvas.width), number(canvas.height));
    let mut elements = String::new();
    write_elements(&mut elements, &canvas.elements);
    let patterns = if elements.contains("url(#") {
        patterns()
    } else {
        String::new()
    };
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" \
         font-family=\"'DejaVu Sans', Verdana, sans-serif\" fill=\"{}\">\n\
         <title>{}</title>\n{patterns}\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n{elements}</svg>\n",
        hex(Colour::BLACK),
        escape(title),
    )
}

/// The two fill patterns; every document that needs one defines both, so panels can be joined to a page.
fn patterns() -> String {
    let mut patterns = "<defs>\n".to_owned();
    for hatch in [Hatch::NO_VALUE, Hatch::OPEN] {
        let side = number(hatch.period);
        let lines: String = hatch.segments().iter().map(|line| data(line)).collect();
        patterns.push_str(&format!(
            "<pattern id=\"{}\" width=\"{side}\" height=\"{side}\" patternUnits=\"userSpaceOnUse\">\
             <rect width=\"{side}\" height=\"{side}\" fill=\"{}\"/>\
             <path d=\"{lines}\" stroke=\"{}\" stroke-width=\"{}\"/></pattern>\n",
            hatch.name,
            hex(hatch.background),
            hex(hatch.lines),
            number(hatch.width)
        ));
    }
    patterns + "</defs>\n"
}

fn write_elements(document: &mut String, elements: &[DrawnElement]) {
    for element in elements {
        match element {
            DrawnElement::Shape {
                outline,
                fill,
                stroke,
            } => document.push_str(&shape(outline, &paint(*fill, *stroke))),
            DrawnElement::Text(text) => document.push_str(&text_element(text)),
            DrawnElement::Titled(title, inner) => {
                document.push_str(&format!("<g><title>{}</title>\n", escape(title)));
                write_elements(document, inner);
                document.push_str("</g>\n");
            }
            DrawnElement::Moved([x, y], inner) => {
                let (x, y) = (number(*x), number(*y));
                document.push_str(&format!("<g transform=\"translate({x} {y})\">\n"));
                write_elements(document, inner);
                document.push_str("</g>\n");
            }
        }
    }
}

fn shape(outline: &Outline, paint: &str) -> String {
    let path = |lines: &[Vec<Point>], end: &str| {
        let data: String = lines.iter().map(|line| data(line) + end).collect();
        format!("<path d=\"{data}\" fill-rule=\"evenodd\"{paint}/>\n")
    };
    match outline {
        Outline::Loops(loops) => path(loops, "Z"),
        Outline::Lines(lines) => path(lines, ""),
        Outline::Rectangle(corner, size) => {
            let ([x, y], [width, height]) = (corner.map(number), size.map(number));
            format!("<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"{paint}/>\n")
        }
        Outline::Ellipse(centre, semi_axes) => {
            let ([x, y], [rx, ry]) = (centre.map(number), semi_axes.map(number));
            format!("<ellipse cx=\"{x}\" cy=\"{y}\" rx=\"{rx}\" ry=\"{ry}\"{paint}/>\n")
        }
    }
}

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

fn text_element(text: &Text) -> String {
    let [x, y] = text.position.map(number);
    let anchor = match text.anchor {
        Anchor::Start => "start",
        Anchor::Middle => "middle",
        Anchor::End => "end",
    };
    let setting = match text.setting {
        Setting::Plain => String::new(),
        Setting::Bold => " font-weight=\"bold\"".to_owned(),
        Setting::Upwards => format!(" transform=\"rotate(-90 {x} {y})\""),
    };
    format!(
        "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" text-anchor=\"{anchor}\"{setting}>{}</text>\n",
        number(text.size),
        text.label.markup(text.size)
    )
}

/// Fill and stroke as attributes.
fn paint(fill: Fill, stroke: Option<Stroke>) -> String {
    let mut attributes = match fill {
        Fill::Empty => " fill=\"none\"".to_owned(),
        Fill::Plain(colour) => format!(" fill=\"{}\"", hex(colour)),
        Fill::NoValue => format!(" fill=\"url(#{})\"", Hatch::NO_VALUE.name),
        Fill::Open => format!(" fill=\"url(#{})\"", Hatch::OPEN.name),
    };
    if let Some(stroke) = stroke {
        let colour = hex(stroke.colour);
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

/// A colour as `#rrggbb`.
pub(super) fn hex(Colour(red, green, blue): Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
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

/// A vector of ℝ³.
pub(super) type Vector = [f64; 3];

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(super) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn scaled(a: Vector, factor: f64) -> Vector {
    a.map(|component| factor * component)
}

pub(super) fn norm(a: Vector) -> f64 {
    a[0].hypot(a[1]).hypot(a[2])
}

/// `a` divided by its length; the zero vector stays.
pub(super) fn unit(a: Vector) -> Vector {
    let length = norm(a);
    if length > 0.0 {
        scaled(a, 1.0 / length)
    } else {
        a
    }
}

/// Smallest and largest value; (0, 0) when there is none.
pub(super) fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    if low <= high { (low, high) } else { (0.0, 0.0) }
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
