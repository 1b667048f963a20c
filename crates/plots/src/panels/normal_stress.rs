//! Panel (a): the normal contact stress.

use units::Dimension;

use super::{PanelData, PanelSpec};
use crate::canvas::Canvas;
use crate::colour::ColourMap;
use crate::colour::map_panel;
use crate::colour_bar::ColourKey;
use crate::text::Label;

/// Panel (a).
pub(super) const PANEL: PanelSpec = PanelSpec {
    name: "a_normal_stress",
    draw: |figure| (!figure.picture.contact_triangles.is_empty()).then(|| normal_stress(figure)),
};

fn normal_stress(figure: &PanelData<'_>) -> Canvas {
    let (picture, shapes) = (figure.picture, figure.shapes.as_slice());
    let symbol = Label::default().italic("σ").subscript("ν");
    let value = |pane: usize| picture.normal_stress[pane];
    let values = shapes.iter().map(|shape| value(shape.pane));
    let unit = picture.units.of(Dimension::STRESS);
    let key = ColourKey::new(values, ColourMap::ReversedViridis, &symbol, &unit);
    let title = Label::plain("(a) Normal contact stress ").then(&symbol);
    map_panel(&figure.layout, shapes, &title, &key, &unit, value)
}
