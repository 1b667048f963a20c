//! The panels of HKL Fig. 5: each in a file of its own, all listed once.

mod body;
mod ellipses;
mod normal_stress;
mod scaled_tangential;
mod semi_axes;

pub(super) use ellipses::zone_colour;
pub(super) use semi_axes::semi_axis_map;

use super::canvas::Canvas;
use super::layout::PictureLayout;
use super::panes::{PaneShape, pane_shapes};
use super::picture::{ContactPicture, FigureError};

/// What the panels of one page are drawn from.
struct PanelData<'a> {
    picture: &'a ContactPicture<'a>,
    layout: PictureLayout,
    shapes: Vec<PaneShape>,
}

/// A panel that a page may have.
struct PanelSpec {
    /// Its name for files.
    name: &'static str,
    /// Draws it; `None` where the problem does not have what it shows.
    draw: fn(&PanelData<'_>) -> Option<Canvas>,
}

/// All panels in the order of the page.
const TABLE: [PanelSpec; 6] = [
    normal_stress::PANEL,
    scaled_tangential::PANEL,
    body::PANEL,
    ellipses::PANEL,
    semi_axes::FIRST,
    semi_axes::SECOND,
];

/// Names of all panels of HKL Fig. 5, for files.
pub const PANELS: [&str; TABLE.len()] = {
    let mut names = [""; TABLE.len()];
    let mut index = 0;
    while index < TABLE.len() {
        names[index] = TABLE[index].name;
        index += 1;
    }
    names
};

/// The estimated error on the body, by itself.
pub(super) fn error_drawing(
    picture: &ContactPicture<'_>,
    density: &[f64],
) -> Result<Canvas, FigureError> {
    picture.validate()?;
    Ok(body::error_panel(
        picture,
        &PictureLayout::new(picture),
        density,
    ))
}

/// All panels that the picture allows, of equal size.
pub(super) fn drawings(
    picture: &ContactPicture<'_>,
) -> Result<Vec<(&'static str, Canvas)>, FigureError> {
    picture.validate()?;
    let layout = PictureLayout::new(picture);
    let shapes = pane_shapes(picture).into_iter();
    let figure = PanelData {
        picture,
        shapes: shapes
            .filter_map(|shape| shape.within(&layout.contact))
            .collect(),
        layout,
    };
    let drawn = TABLE
        .iter()
        .filter_map(|panel| Some((panel.name, (panel.draw)(&figure)?)));
    Ok(drawn.collect())
}
