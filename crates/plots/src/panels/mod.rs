//! The panels of HKL Fig. 5, all listed once.

mod body;
mod ellipses;
mod maps;
mod marks;

pub(super) use body::{body_panels, draw_triad};
pub(super) use ellipses::zone_colour;

use super::canvas::Canvas;
use super::layout::PictureLayout;
use super::panes::{PaneShape, pane_shapes};
use super::picture::ContactPicture;

/// Names of all panels of HKL Fig. 5 in the order of the page, for files.
pub const PANELS: [&str; 6] = [
    "a_contact_pressure",
    "b_scaled_tangential_stress",
    "c_deformed_body",
    "d_friction_ellipses",
    "e_friction_1",
    "f_friction_2",
];

/// What the panels of one page are drawn from.
struct PanelData<'a> {
    picture: &'a ContactPicture<'a>,
    layout: PictureLayout,
    shapes: Vec<PaneShape>,
}

/// All panels that the picture allows, of equal size, by their names.
pub(super) fn drawings(picture: &ContactPicture<'_>) -> Vec<(&'static str, Canvas)> {
    let layout = PictureLayout::new(picture);
    let shapes = pane_shapes(picture).into_iter();
    let figure = PanelData {
        picture,
        shapes: shapes
            .filter_map(|shape| shape.within(&layout.contact))
            .collect(),
        layout,
    };
    let law = picture.friction;
    let drawn = [
        maps::pressure(&figure),
        law.map(|law| maps::scaled_tangential(&figure, law)),
        Some(body::body_panel(picture, &figure.layout)),
        law.map(|law| ellipses::ellipse_panel(&figure, law)),
        law.and_then(|law| maps::semi_axis(&figure, law, 0)),
        law.and_then(|law| maps::semi_axis(&figure, law, 1)),
    ];
    let named = PANELS.into_iter().zip(drawn);
    named
        .filter_map(|(name, canvas)| Some((name, canvas?)))
        .collect()
}
