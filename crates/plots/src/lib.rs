#![doc = include_str!("../README.md")]
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod axis;
mod canvas;
mod chart;
mod colour;
pub mod html;
mod law;
mod layout;
mod mesh_picture;
mod panels;
mod panes;
mod picture;
mod scale;
mod text;
mod view;

pub use axis::AxisScale;
pub use chart::{Chart, ChartAxis, ChartPoint, MarkKind, PathKind, Series, SeriesStyle};
pub use law::{LawPicture, OverSlip, SlipCoefficientMap, SlipCurve, SlipRange, law_page};
pub use mesh_picture::{MeshPicture, mesh_page};
pub use panels::PANELS;
pub use panes::FrictionKind;
pub use picture::{
    BodyMark, BodyMarkKind, ContactPicture, DrawnFriction, DrawnObstacle, DrawnZone, Picture,
    PngError,
};

use canvas::{Anchor, Canvas};
use layout::{PANEL_WIDTH, TITLE_SIZE};
use panels::{drawings, error_panels};
use text::{Label, fitted};

/// Draws the panels of HKL Fig. 5, each with its name for a file, one of [`PANELS`].
///
/// (a) σ_ν, (b) ‖F⁻¹σ_t‖, (c) the deformed body, (d) an ellipse with the semi-axes F₁, F₂ and σ_t/λ_ν as a line for
/// every pane, (e) F₁, (f) F₂. With Tresca's law semi-axes are g F₁, g F₂, and σ_t is not divided. Without friction only (a) and (c), without contact only (c).
#[must_use]
pub fn panels(picture: &ContactPicture<'_>) -> Vec<(&'static str, Picture)> {
    let drawings = drawings(picture).into_iter();
    let figure = |canvas: Canvas| Picture::new(&canvas, picture.title);
    drawings
        .map(|(name, canvas)| (name, figure(canvas)))
        .collect()
}

/// Draws where the error sits on the boundary of the body, from two opposite sides: the logarithm of `density`, for each node a share of
/// the mean, as many as `coordinates`. `sides` has words for that behind whose body the contact face is, and for the other.
#[must_use]
pub fn error_figure(
    picture: &ContactPicture<'_>,
    density: &[f64],
    sides: [&'static str; 2],
) -> Picture {
    Picture::new(&error_panels(picture, density, sides), picture.title)
}

/// Draws all panels below a common title in two columns.
#[must_use]
pub fn page(picture: &ContactPicture<'_>) -> Picture {
    let mut panels = drawings(picture).into_iter().map(|(_, canvas)| canvas);
    let mut rows = Vec::new();
    while let Some(first) = panels.next() {
        rows.push([first].into_iter().chain(panels.next()).collect());
    }
    let page = titled_page([picture.title, ""], &rows, 2, 0.0);
    Picture::new(&page, picture.title)
}

/// Rows of panels below a title and a note, which may be empty; where a row is shorter than the page, a share of what is left is before it.
fn titled_page(
    [title, note]: [&str; 2],
    rows: &[Vec<Canvas>],
    columns: usize,
    indent: f64,
) -> Canvas {
    let height = |row: &Vec<Canvas>| row.iter().map(|canvas| canvas.height).fold(0.0, f64::max);
    let mut top = if note.is_empty() { 46.0 } else { 70.0 };
    let mut page = Canvas::new(
        columns as f64 * PANEL_WIDTH,
        top + rows.iter().map(height).sum::<f64>(),
    );
    for (text, baseline, size) in [(title, 31.0, 19.0), (note, 55.0, TITLE_SIZE)] {
        let label = Label::plain(fitted(text, size, page.width - 60.0));
        page.text([page.width / 2.0, baseline], &label, size, Anchor::Middle);
    }
    for row in rows {
        let before = indent * (columns - row.len()) as f64;
        for (column, canvas) in row.iter().enumerate() {
            page.place(canvas, [(before + column as f64) * PANEL_WIDTH, top]);
        }
        top += height(row);
    }
    page
}
