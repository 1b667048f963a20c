//! Panels (e) and (f): the coefficients of friction, or the bounds of Tresca's law, along either
//! axis, where they vary.

use units::Unit;

use super::{PanelData, PanelSpec};
use crate::canvas::Canvas;
use crate::colour::map_panel;
use crate::colour::{ColourMap, ValueRange};
use crate::colour_bar::ColourKey;
use crate::layout::PictureLayout;
use crate::panes::PaneShape;
use crate::picture::DrawnFriction;
use crate::text::Label;

/// Panel (e).
pub(super) const FIRST: PanelSpec = PanelSpec {
    name: "e_friction_1",
    draw: |figure| along(figure, 0, "(e)"),
};

/// Panel (f).
pub(super) const SECOND: PanelSpec = PanelSpec {
    name: "f_friction_2",
    draw: |figure| along(figure, 1, "(f)"),
};

fn along(figure: &PanelData<'_>, axis: usize, letter: &str) -> Option<Canvas> {
    let (kind, friction) = figure.picture.friction?;
    if constant(friction, &figure.shapes, axis).is_some() {
        return None;
    }
    let symbol = kind.semi_axis_symbol(axis);
    let title = Label::plain(format!("{letter} {}", kind.semi_axis_title())).then(&symbol);
    let unit = kind.unit(figure.picture.units);
    let face = (&figure.layout, figure.shapes.as_slice());
    Some(semi_axis_map(
        (friction, &unit),
        face,
        axis,
        &title,
        &symbol,
    ))
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

/// The map of F₁ or F₂, or of g F₁ or g F₂, with common colours for both unless these would hide
/// the variation of one of them.
pub(crate) fn semi_axis_map(
    (friction, unit): (&[DrawnFriction], &Unit),
    (layout, shapes): (&PictureLayout, &[PaneShape]),
    axis: usize,
    title: &Label,
    symbol: &Label,
) -> Canvas {
    let values = |axis: usize| {
        let panes = shapes.iter().map(|shape| shape.pane);
        panes.map(move |pane| friction[pane].semi_axes[axis])
    };
    let own = [0, 1].map(|axis| ValueRange::of(values(axis)));
    let ranges = own[0].shared(own[1]).map_or(own, |common| [common; 2]);
    let gaps = values(axis).any(|value| !value.is_finite());
    let key = ColourKey::with_range(ranges[axis], gaps, ColourMap::Cividis, symbol, unit);
    map_panel(layout, shapes, title, &key, unit, |pane| {
        friction[pane].semi_axes[axis]
    })
}
