//! Panel (d): friction ellipses and tangential contact stress.

use units::Unit;

use super::{
    PanelData,
    maps::{constant, draw_axes, draw_panes},
};
use crate::canvas::{Anchor, Canvas, Colour, Fill, Point, Stroke};
use crate::layout::{LABEL_SIZE, PANEL_WIDTH, PictureLayout, RIGHT_MARGIN, TICK_SIZE};
use crate::panes::{FrictionKind, PaneShape};
use crate::picture::{DrawnFriction, DrawnZone};
use crate::scale::round_down;
use crate::text::Label;

/// Distance of two ellipses at least, over their largest semi-axis.
const LEAST_DISTANCE: f64 = 2.2;
/// Longest bar of the friction scale in the legend in pixels.
const LONGEST_SCALE_BAR: f64 = 64.0;

/// Light fill and dark line of a contact state.
fn zone_paint(zone: DrawnZone) -> (Fill, Colour) {
    match zone {
        DrawnZone::Open => (Fill::Open, Colour(0xa8, 0xa8, 0xa8)),
        DrawnZone::Stick => (
            Fill::Plain(Colour(0xcf, 0xe1, 0xf4)),
            Colour(0x00, 0x55, 0x9c),
        ),
        DrawnZone::Slip => (
            Fill::Plain(Colour(0xfd, 0xe0, 0xc8)),
            Colour(0xc4, 0x4e, 0x00),
        ),
    }
}

/// The dark colour of a contact state.
pub(crate) fn zone_colour(zone: DrawnZone) -> Colour {
    zone_paint(zone).1
}

/// Panel (d): one ellipse per pane, the tangential contact stress over λ_ν inside it, and the zones.
pub(super) fn ellipse_panel(
    figure: &PanelData<'_>,
    (kind, friction): (FrictionKind, &[DrawnFriction]),
) -> Canvas {
    let unit = &kind.unit(figure.picture.units);
    let (layout, shapes) = (&figure.layout, figure.shapes.as_slice());
    let title = Label::plain("(d) Friction ellipses and tangential contact stress");
    let mut canvas = layout.panel(&title);
    let fill = |pane: usize| match &friction[pane] {
        state if state.scaled_tangential.is_nan() => Fill::NoValue,
        state => zone_paint(state.zone).0,
    };
    let hover = |pane: usize| describe((kind, unit), pane, &friction[pane]);
    draw_panes(&mut canvas, layout, shapes, Colour::GREY, fill, hover);
    // Where stresses are drawn over a bound that the pressure makes, open panes have none.
    let has_ellipse = |shape: &&PaneShape| {
        layout.contact.contains(shape.centre)
            && (kind == FrictionKind::Plain || friction[shape.pane].zone != DrawnZone::Open)
    };
    let with_ellipse: Vec<&PaneShape> = shapes.iter().filter(has_ellipse).collect();
    let free = with_ellipse.iter().map(|shape| free_radius(layout, shape));
    let free: Vec<f64> = free.collect();
    let largest = largest_semi_axis(friction);
    let radius = common_radius(free.clone());
    let mut drawn: Vec<Point> = Vec::new();
    let fit = free.iter().all(|free| radius <= *free);
    for shape in with_ellipse.iter().filter(|_| largest > 0.0) {
        let centre = layout.point(shape.centre);
        // Where panes are smaller than ellipses only some have one, and these do not touch.
        let is_apart =
            |[x, y]: &Point| (centre[0] - x).hypot(centre[1] - y) >= LEAST_DISTANCE * radius;
        if drawn.iter().all(is_apart) {
            drawn.push(centre);
            let state = &friction[shape.pane];
            canvas.titled(&describe((kind, unit), shape.pane, state), |canvas| {
                draw_pane(canvas, state, fit, centre, radius, largest);
            });
        }
    }
    draw_axes(&mut canvas, layout);
    let constants = [0, 1].map(|axis| constant(friction, shapes, axis));
    let mut remark = kind.constants_label(constants, unit);
    if drawn.len() < with_ellipse.len() && !drawn.is_empty() {
        let some = format!(
            "ellipses of {} of {} panes",
            drawn.len(),
            with_ellipse.len()
        );
        let comma = if remark.width(TICK_SIZE) > 0.0 {
            ", "
        } else {
            ""
        };
        remark = remark.upright(format!("{comma}{some}"));
    }
    let position = [layout.frame.corner[0], 40.5];
    canvas.text(position, &remark, TICK_SIZE, Anchor::Start);
    draw_legend(
        &mut canvas,
        layout,
        (kind, unit),
        (!drawn.is_empty()).then_some((radius, largest)),
    );
    canvas
}

/// What a pane says when pointed at.
fn describe((kind, unit): (FrictionKind, &Unit), pane: usize, friction: &DrawnFriction) -> String {
    let zone = friction.zone.word();
    let words = kind.describe(friction.semi_axes, friction.stress, unit);
    format!("pane {pane}, {zone}: {words}")
}

/// The radius in pixels of all ellipses: that of the smallest pane, unless it is so small that it would hide the others.
fn common_radius(mut radii: Vec<f64>) -> f64 {
    radii.sort_by(f64::total_cmp);
    let quartile = radii.get(radii.len() / 4).copied().unwrap_or(0.0);
    let smallest = radii.first().copied().unwrap_or(0.0);
    // The largest semi-axis of the ellipses has at least so many pixels.
    (0.88 * smallest.max(quartile / 2.0)).max(7.0)
}

/// The distance in pixels from the centre of a pane to its outline.
fn free_radius(layout: &PictureLayout, shape: &PaneShape) -> f64 {
    let [x, y] = layout.point(shape.centre);
    let sides = shape.outline.iter().flat_map(|corners| {
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next)
    });
    let distance = sides.map(|(&a, &b)| {
        let ([ax, ay], [bx, by]) = (layout.point(a), layout.point(b));
        let (dx, dy) = (bx - ax, by - ay);
        let share = ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy);
        let share = if share.is_finite() {
            share.clamp(0.0, 1.0)
        } else {
            0.0
        };
        (x - ax - share * dx).hypot(y - ay - share * dy)
    });
    distance.fold(f64::INFINITY, f64::min)
}

fn largest_semi_axis(friction: &[DrawnFriction]) -> f64 {
    let finite = friction
        .iter()
        .flat_map(|pane| pane.semi_axes)
        .filter(|semi_axis| semi_axis.is_finite());
    finite.fold(0.0, f64::max)
}

/// Draws the ellipse of a pane, `largest` being a semi-axis of `radius` pixels, and the line inside it; where some do not
/// fit into their panes, none is filled.
fn draw_pane(
    canvas: &mut Canvas,
    pane: &DrawnFriction,
    fit: bool,
    centre: Point,
    radius: f64,
    largest: f64,
) {
    let (_, colour) = zone_paint(pane.zone);
    let thin = (0.06 * radius).clamp(0.15, 0.9);
    if pane.semi_axes.iter().all(|f| f.is_finite() && *f >= 0.0) {
        // Smallest drawn semi-axis in pixels, for friction that is strong in one direction only.
        let semi_axes = pane.semi_axes.map(|f| (f / largest * radius).max(0.3));
        let fill = match pane.zone {
            DrawnZone::Stick | DrawnZone::Slip if fit => Fill::Plain(Colour::WHITE),
            _ => Fill::Empty,
        };
        let stroke = Some(Stroke::solid(colour, thin));
        if pane.turn == 0.0 {
            canvas.ellipse(centre, semi_axes, fill, stroke);
        } else {
            let outline = turned_ellipse(centre, semi_axes, pane.turn);
            canvas.region(&[outline], fill, stroke);
        }
    }
    let ratio = turned(pane.stress.map(|t| t / largest), pane.turn);
    let length = ratio[0].hypot(ratio[1]);
    if length.is_finite() && length > 0.0 {
        // Longer lines, in multiples of the largest semi-axis, are cut.
        let shortening = radius * (2.0 / length).min(1.0);
        let tip = [
            centre[0] + shortening * ratio[0],
            centre[1] - shortening * ratio[1],
        ];
        canvas.line(centre, tip, Stroke::solid(colour, 2.0 * thin));
        canvas.ellipse(centre, [1.6 * thin; 2], Fill::Plain(colour), None);
    }
}

/// A vector with components along t₁ and t₂ in the axes of the picture.
fn turned(vector: Point, turn: f64) -> Point {
    let (sine, cosine) = turn.sin_cos();
    [
        cosine * vector[0] - sine * vector[1],
        sine * vector[0] + cosine * vector[1],
    ]
}

/// The outline of an ellipse whose first axis is turned.
fn turned_ellipse(centre: Point, semi_axes: Point, turn: f64) -> Vec<Point> {
    const CORNERS: u32 = 48;
    (0..CORNERS)
        .map(|k| {
            let angle = std::f64::consts::TAU * f64::from(k) / f64::from(CORNERS);
            let on_axes = [semi_axes[0] * angle.cos(), semi_axes[1] * angle.sin()];
            let [right, up] = turned(on_axes, turn);
            [centre[0] + right, centre[1] - up]
        })
        .collect()
}

/// Draws the legend in two rows; `ellipses` is the radius in pixels of the largest coefficient and this coefficient.
fn draw_legend(
    canvas: &mut Canvas,
    layout: &PictureLayout,
    (kind, unit): (FrictionKind, &Unit),
    ellipses: Option<(f64, f64)>,
) {
    let [left, top] = layout.key;
    let width = PANEL_WIDTH - RIGHT_MARGIN - left;
    // Left ends of the columns, as shares of the width.
    let corner = |row: usize, column: usize| {
        let x = left + [0.0, 0.38, 0.66][column] * width;
        [x, top + 6.0 + 26.0 * row as f64]
    };
    let name = |canvas: &mut Canvas, [x, y]: Point, indent: f64, label: &Label| {
        canvas.text([x + indent, y + 12.0], label, LABEL_SIZE, Anchor::Start);
    };
    let zones = [DrawnZone::Open, DrawnZone::Stick, DrawnZone::Slip];
    for (column, zone) in zones.into_iter().enumerate() {
        let (fill, colour) = zone_paint(zone);
        let frame = Some(Stroke::solid(colour, 1.0));
        canvas.rectangle(corner(0, column), [22.0, 14.0], fill, frame);
        let word = Label::plain(zone.word());
        name(canvas, corner(0, column), 30.0, &word);
    }
    let Some((radius, largest)) = ellipses else {
        return;
    };
    let dark = Stroke::solid(Colour::BLACK, 1.0);
    let [x, y] = corner(1, 0);
    let white = Fill::Plain(Colour::WHITE);
    canvas.ellipse([x + 11.0, y + 7.0], [11.0, 7.0], white, Some(dark));
    name(canvas, [x, y], 30.0, &kind.semi_axes_label());
    let [x, y] = corner(1, 1);
    let [from, to] = [[x + 2.0, y + 11.0], [x + 20.0, y + 3.0]];
    canvas.line(from, to, Stroke::solid(Colour::BLACK, 1.8));
    canvas.ellipse(from, [1.8; 2], Fill::Plain(Colour::BLACK), None);
    name(canvas, [x, y], 30.0, &kind.stress_label());
    let has_few_digits = |digits: f64| (digits - digits.round()).abs() < 1e-6;
    let value = if radius <= LONGEST_SCALE_BAR
        && has_few_digits(largest / 10f64.powf(largest.log10().floor() - 1.0))
    {
        largest
    } else {
        round_down(largest * (LONGEST_SCALE_BAR / radius).min(1.0))
    };
    let bar = value / largest * radius;
    let [x, y] = corner(1, 2);
    canvas.line([x, y + 7.0], [x + bar, y + 7.0], dark);
    for end in [x, x + bar] {
        canvas.line([end, y + 3.0], [end, y + 11.0], dark);
    }
    name(
        canvas,
        [x, y],
        bar.max(22.0) + 8.0,
        &kind.scale_bar_label(value, unit),
    );
}
