#![doc = include_str!("../README.md")]
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod axis;
mod canvas;
mod chart;
mod colour;
pub mod html;
mod layout;
mod mesh_picture;
mod outline;
mod panels;
mod panes;
mod picture;
mod scale;
mod surface;
mod text;
mod view;

pub use axis::AxisScale;
pub use chart::{Chart, ChartAxis, ChartPoint, Series, SeriesStyle};
pub use mesh_picture::{MeshPicture, mesh_page};
pub use panels::PANELS;
pub use panes::FrictionKind;
pub use picture::{
    BodyField, BodyMark, BodyMarkKind, ContactPicture, DrawnFriction, DrawnObstacle, DrawnZone,
    Picture, PngError,
};

use canvas::{Anchor, Canvas};
use layout::PANEL_WIDTH;
use panels::{body_panels, drawings};
use text::{Label, fitted};

/// Draws the panels of HKL Fig. 5, each with its name for a file, one of [`PANELS`].
///
/// (a) σ_ν, (b) ‖F⁻¹σ_t‖, (c) the deformed body, (d) an ellipse with the semi-axes F₁, F₂ and σ_t/λ_ν as a line for
/// every pane, (e) F₁, (f) F₂. With Tresca's law semi-axes are g F₁, g F₂, and σ_t is not divided. Without friction only (a) and (c), without contact only (c).
#[must_use]
pub fn panels(picture: &ContactPicture<'_>) -> Vec<(&'static str, Picture)> {
    let drawings = drawings(picture).into_iter();
    let figure = |canvas: Canvas| Picture::new(canvas, picture.title);
    drawings
        .map(|(name, canvas)| (name, figure(canvas)))
        .collect()
}

/// Draws a field on the boundary of the body at rest, from two opposite sides. `sides` has words for that behind whose body the contact face
/// is, and for the other.
#[must_use]
pub fn body_figure(
    picture: &ContactPicture<'_>,
    field: &BodyField<'_>,
    sides: [&'static str; 2],
) -> Picture {
    Picture::new(body_panels(picture, field, sides), picture.title)
}

/// Draws all panels below a common title in two columns.
#[must_use]
pub fn page(picture: &ContactPicture<'_>) -> Picture {
    let panels = drawings(picture);
    // Panels of one picture have one height.
    let height = panels.first().map_or(0.0, |(_, canvas)| canvas.height);
    let (top, rows) = (46.0, panels.len().div_ceil(2) as f64);
    let mut page = Canvas::new(2.0 * PANEL_WIDTH, top + rows * height);
    let title = Label::plain(fitted(picture.title, 19.0, page.width - 60.0));
    page.text([page.width / 2.0, 31.0], &title, 19.0, Anchor::Middle);
    for (k, (_, canvas)) in panels.iter().enumerate() {
        let [column, row] = [k % 2, k / 2].map(|k| k as f64);
        page.place(canvas, [column * PANEL_WIDTH, top + row * height]);
    }
    Picture::new(page, picture.title)
}
