//! Panels (a), (b), (e), (f): one value per pane.

use units::Unit;

use super::canvas::{Canvas, Colour};
use super::chart::{draw_axes, draw_panes};
use super::colour_bar::ColourKey;
use super::layout::{KeySide, Layout};
use super::panes::PaneShape;
use super::text::Label;

/// A map of one value per pane in `unit`, with axes and colour bar.
pub(super) fn map_panel(
    layout: &Layout,
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
    let [left, top] = layout.corner;
    let [width, height] = layout.size;
    match layout.key {
        KeySide::Below => {
            let corner = [left, top + height + 50.0];
            key.draw(&mut canvas, layout.key, corner, width);
        }
        KeySide::Right => {
            let corner = [left + width + 28.0, top];
            key.draw(&mut canvas, layout.key, corner, height);
        }
    }
    canvas
}
