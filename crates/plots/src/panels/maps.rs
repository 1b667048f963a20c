//! Panels (a), (b), (e) and (f): one value for each pane.

use units::{Dimension, Unit};

use super::PanelData;
use crate::canvas::{Anchor, Canvas, Colour, Fill, Stroke};
use crate::colour::{ColourKey, ColourMap, ValueRange};
use crate::layout::{PANEL_WIDTH, PictureLayout, TICK_SIZE};
use crate::panes::{FrictionKind, PaneShape};
use crate::picture::DrawnFriction;
use crate::text::Label;

/// Panel (a): the contact pressure.
pub(super) fn pressure(figure: &PanelData<'_>) -> Option<Canvas> {
    let (picture, shapes) = (figure.picture, figure.shapes.as_slice());
    if picture.contact_triangles.is_empty() {
        return None;
    }
    let symbol = Label::default().italic("p");
    let value = |pane: usize| picture.pressure[pane];
    let values = shapes.iter().map(|shape| value(shape.pane));
    let unit = picture.units.of(Dimension::STRESS);
    let key = ColourKey::new(values, ColourMap::Viridis, &symbol, &unit);
    let title = Label::plain("(a) Contact pressure ").then(&symbol);
    let title = title.upright(" = −").italic("σ").subscript("ν");
    let layout = &figure.layout;
    Some(map_panel(layout, shapes, &title, &key, &unit, value))
}

/// Panel (b): the tangential contact stress, scaled by the law of friction.
pub(super) fn scaled_tangential(
    figure: &PanelData<'_>,
    (kind, friction): (FrictionKind, &[DrawnFriction]),
) -> Canvas {
    let shapes = figure.shapes.as_slice();
    let symbol = kind.scaled_symbol();
    let unit = kind.scaled_unit(figure.picture.units);
    let value = |pane: usize| friction[pane].scaled_tangential;
    let values = shapes.iter().map(|shape| value(shape.pane));
    let key = ColourKey::new(values, ColourMap::Viridis, &symbol, &unit);
    let title = Label::plain(kind.scaled_title()).then(&symbol);
    map_panel(&figure.layout, shapes, &title, &key, &unit, value)
}

/// Panels (e) and (f): the coefficients of friction, or the bounds of Tresca's law, along either axis, where they vary; in common colours
/// unless these would hide the variation of one of them.
pub(super) fn semi_axis(
    figure: &PanelData<'_>,
    (kind, friction): (FrictionKind, &[DrawnFriction]),
    axis: usize,
) -> Option<Canvas> {
    let shapes = figure.shapes.as_slice();
    if constant(friction, shapes, axis).is_some() {
        return None;
    }
    let symbol = kind.semi_axis_symbol(axis);
    let letter = ["(e)", "(f)"][axis];
    let title = Label::plain(format!("{letter} {}", kind.semi_axis_title())).then(&symbol);
    let unit = kind.unit(figure.picture.units);
    let values = |axis: usize| {
        let panes = shapes.iter().map(|shape| shape.pane);
        panes.map(move |pane| friction[pane].semi_axes[axis])
    };
    let ranges = ValueRange::shared([0, 1].map(|axis| ValueRange::of(values(axis))));
    let gaps = values(axis).any(|value| !value.is_finite());
    let key = ColourKey::with_range(ranges[axis], gaps, ColourMap::Cividis, &symbol, &unit);
    let value = |pane: usize| friction[pane].semi_axes[axis];
    let layout = &figure.layout;
    Some(map_panel(layout, shapes, &title, &key, &unit, value))
}

/// The one value of a semi-axis on all panes; `None` where it varies.
pub(super) fn constant(
    friction: &[DrawnFriction],
    shapes: &[PaneShape],
    axis: usize,
) -> Option<f64> {
    let panes = shapes.iter().map(|shape| shape.pane);
    match ValueRange::of(panes.map(|pane| friction[pane].semi_axes[axis])) {
        ValueRange::Constant(value) => Some(value),
        ValueRange::Nothing | ValueRange::Interval(..) => None,
    }
}

/// A map of one value per pane in `unit`, with axes and colour bar.
fn map_panel(
    layout: &PictureLayout,
    shapes: &[PaneShape],
    title: &Label,
    key: &ColourKey,
    unit: &Unit,
    value: impl Fn(usize) -> f64,
) -> Canvas {
    let mut canvas = layout.panel(title);
    let fill = |pane: usize| key.fill(value(pane));
    let hover = |pane: usize| format!("pane {pane}: {:.4e}{}", value(pane), unit.beside());
    draw_panes(&mut canvas, layout, shapes, Colour::WHITE, fill, hover);
    draw_axes(&mut canvas, layout);
    key.draw(&mut canvas, layout.key);
    canvas
}

/// Draws frame, ticks, labels and the note on stretching.
pub(super) fn draw_axes(canvas: &mut Canvas, layout: &PictureLayout) {
    let name_x = layout.frame.name_x(14.0);
    layout.frame.draw(canvas, [19.0, 37.0], name_x);
    if let Some(note) = &layout.note {
        let position = [PANEL_WIDTH - 16.0, 40.5];
        canvas.text(position, note, TICK_SIZE, Anchor::End);
    }
}

/// Draws every pane with its fill and the text it shows when pointed at, and thin outlines of the
/// given colour over all of them.
pub(super) fn draw_panes(
    canvas: &mut Canvas,
    layout: &PictureLayout,
    shapes: &[PaneShape],
    outline: Colour,
    fill: impl Fn(usize) -> Fill,
    hover: impl Fn(usize) -> String,
) {
    let mut outlines = Vec::new();
    for shape in shapes {
        let pixels = |line: &Vec<[f64; 2]>| line.iter().map(|&p| layout.point(p)).collect();
        let mut loops: Vec<Vec<_>> = shape.outline.iter().map(pixels).collect();
        let fill = fill(shape.pane);
        // A stroke in the colour of the pane closes the seam to its neighbours.
        let seam = match fill {
            Fill::Plain(colour) => Some(Stroke::solid(colour, 0.4)),
            Fill::Empty | Fill::NoValue | Fill::Open => None,
        };
        canvas.titled(&hover(shape.pane), |canvas| {
            canvas.region(&loops, fill, seam);
        });
        for points in &mut loops {
            points.extend(points.first().copied());
        }
        outlines.append(&mut loops);
    }
    let width = outline_width(layout, shapes);
    if width > 0.05 {
        canvas.polylines(&outlines, Stroke::solid(outline, width));
    }
}

/// Pane outlines get thinner with the panes so that they never cover them: by the lower quartile of the smaller sides of their boxes.
fn outline_width(layout: &PictureLayout, shapes: &[PaneShape]) -> f64 {
    let scale = layout.pixels_per_length();
    let sides = shapes
        .iter()
        .map(|shape| [0, 1].map(|k| shape.extent[k] * scale[k]));
    let mut sizes: Vec<f64> = sides.map(|[a, b]| a.min(b)).collect();
    sizes.sort_by(f64::total_cmp);
    let size = sizes.get(sizes.len() / 4).copied().unwrap_or(0.0);
    (0.025 * size).min(0.5)
}
