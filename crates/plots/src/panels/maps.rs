//! Panels (a), (b), (e) and (f): one value for each pane.

use units::{Dimension, Unit};

use super::PanelData;
use crate::canvas::Canvas;
use crate::colour::{ColourKey, ColourMap, ValueRange, map_panel};
use crate::layout::PictureLayout;
use crate::panes::{FrictionKind, PaneShape};
use crate::picture::DrawnFriction;
use crate::text::Label;

/// Panel (a): the normal contact stress.
pub(super) fn normal_stress(figure: &PanelData<'_>) -> Option<Canvas> {
    let (picture, shapes) = (figure.picture, figure.shapes.as_slice());
    if picture.contact_triangles.is_empty() {
        return None;
    }
    let symbol = Label::default().italic("σ").subscript("ν");
    let value = |pane: usize| picture.normal_stress[pane];
    let values = shapes.iter().map(|shape| value(shape.pane));
    let unit = picture.units.of(Dimension::STRESS);
    let key = ColourKey::new(values, ColourMap::ReversedViridis, &symbol, &unit);
    let title = Label::plain("(a) Normal contact stress ").then(&symbol);
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

/// Panels (e) and (f): the coefficients of friction, or the bounds of Tresca's law, along either axis, where they vary.
pub(super) fn semi_axis(
    figure: &PanelData<'_>,
    (kind, friction): (FrictionKind, &[DrawnFriction]),
    axis: usize,
) -> Option<Canvas> {
    if constant(friction, &figure.shapes, axis).is_some() {
        return None;
    }
    let symbol = kind.semi_axis_symbol(axis);
    let letter = ["(e)", "(f)"][axis];
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
    let ranges = ValueRange::shared([0, 1].map(|axis| ValueRange::of(values(axis))));
    let gaps = values(axis).any(|value| !value.is_finite());
    let key = ColourKey::with_range(ranges[axis], gaps, ColourMap::Cividis, symbol, unit);
    map_panel(layout, shapes, title, &key, unit, |pane| {
        friction[pane].semi_axes[axis]
    })
}
