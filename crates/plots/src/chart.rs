//! Axes and panes of a map of the contact part.

use super::canvas::{Anchor, Canvas, Colour, Fill, Stroke};
use super::layout::{LABEL_SIZE, Layout, PANEL_WIDTH, TICK_SIZE};
use super::panes::PaneShape;

const TICK_LENGTH: f64 = 5.0;

/// Draws frame, ticks, labels and the note on stretching.
pub(super) fn draw_axes(canvas: &mut Canvas, layout: &Layout) {
    let [left, top] = layout.corner;
    let [width, height] = layout.size;
    let bottom = top + height;
    let frame = Stroke::solid(Colour::BLACK, 0.8);
    canvas.rectangle(layout.corner, layout.size, Fill::Empty, Some(frame));
    let [horizontal, vertical] = &layout.axes;
    let first = horizontal.scale.scaled(layout.contact.low[0]);
    let last = horizontal.scale.scaled(layout.contact.high[0]);
    for &value in &horizontal.ticks.values {
        let x = left + (value - first) / (last - first) * width;
        canvas.line([x, bottom], [x, bottom + TICK_LENGTH], frame);
        let label = super::text::Label::plain(horizontal.ticks.text(value));
        canvas.text([x, bottom + 19.0], &label, TICK_SIZE, Anchor::Middle);
    }
    let first = vertical.scale.scaled(layout.contact.low[1]);
    let last = vertical.scale.scaled(layout.contact.high[1]);
    for &value in &vertical.ticks.values {
        let y = bottom - (value - first) / (last - first) * height;
        canvas.line([left, y], [left - TICK_LENGTH, y], frame);
        let label = super::text::Label::plain(vertical.ticks.text(value));
        let position = [left - TICK_LENGTH - 4.0, y + 0.36 * TICK_SIZE];
        canvas.text(position, &label, TICK_SIZE, Anchor::End);
    }
    let position = [left + width / 2.0, bottom + 37.0];
    canvas.text(position, &horizontal.label, LABEL_SIZE, Anchor::Middle);
    let offset = TICK_LENGTH + 14.0 + vertical.ticks.widest(TICK_SIZE);
    let position = [left - offset, top + height / 2.0];
    canvas.vertical_text(position, &vertical.label, LABEL_SIZE);
    if let Some(note) = &layout.note {
        let position = [PANEL_WIDTH - 16.0, 26.0];
        canvas.text(position, note, TICK_SIZE, Anchor::End);
    }
}

/// Draws every pane with its fill and the text it shows when pointed at, and thin outlines of the
/// given colour over all of them.
pub(super) fn draw_panes(
    canvas: &mut Canvas,
    layout: &Layout,
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

/// Pane outlines get thinner with the panes so that they never cover them.
fn outline_width(layout: &Layout, shapes: &[PaneShape]) -> f64 {
    (0.025 * typical_pane_size(layout, shapes)).min(0.5)
}

/// Lower quartile over the panes of the smaller side of their bounding boxes in pixels.
pub(super) fn typical_pane_size(layout: &Layout, shapes: &[PaneShape]) -> f64 {
    let scale = layout.pixels_per_length();
    let mut sizes: Vec<f64> = shapes
        .iter()
        .map(|shape| (shape.extent[0] * scale[0]).min(shape.extent[1] * scale[1]))
        .collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() / 4).copied().unwrap_or(0.0)
}
