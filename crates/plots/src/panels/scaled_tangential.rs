//! Panel (b): the tangential contact stress, scaled by the law of friction.

use super::{PanelData, PanelSpec};
use crate::canvas::Canvas;
use crate::colour::ColourMap;
use crate::colour::map_panel;
use crate::colour_bar::ColourKey;
use crate::panes::FrictionKind;
use crate::picture::DrawnFriction;
use crate::text::Label;

/// Panel (b).
pub(super) const PANEL: PanelSpec = PanelSpec {
    name: "b_scaled_tangential_stress",
    draw: |figure| Some(scaled_tangential(figure, figure.picture.friction?)),
};

fn scaled_tangential(
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
