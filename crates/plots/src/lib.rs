//! The pictures of HKL Fig. 5: contact stresses, deformed body, friction ellipses and coefficients of friction.
//!
//! [`panels`] draws every panel as a figure of its own, [`page`] all of them as one page of two columns; a [`Picture`]
//! is written as SVG or PNG. Colours come from perceptually uniform maps, units carry SI prefixes where they take any,
//! and no fonts or libraries of the system are used. [`law_page`] draws a law of friction alone.

#![deny(clippy::print_stdout, clippy::print_stderr)]

mod branch_diagram;
mod canvas;
mod colour;
pub mod html;
mod law;
mod layout;
mod line_chart;
mod mesh_picture;
mod panels;
mod panes;
mod picture;
mod raster;
mod scale;
mod svg;
mod text;
mod view;

pub use branch_diagram::{BranchDiagram, Curve, CurveKind, Mark, MarkKind};
pub use law::{LawPicture, OverSlip, SlipCoefficientMap, SlipCurve, SlipRange, law_page};
pub use line_chart::{AxisScale, ChartAxis, ChartPoint, LineChart, Series};
pub use mesh_picture::{MeshPicture, mesh_page};
pub use panels::PANELS;
pub use panes::FrictionKind;
pub use picture::{
    BodyMark, BodyMarkKind, ContactPicture, DrawnFriction, DrawnObstacle, DrawnZone, FigureError,
    Picture,
};

use canvas::{Anchor, Canvas};
use layout::PANEL_WIDTH;
use panels::{drawings, error_panels};
use text::{Label, fitted};

/// Height of the title of a page.
const PAGE_TITLE_HEIGHT: f64 = 46.0;
const PAGE_TITLE_SIZE: f64 = 19.0;

/// One panel of HKL Fig. 5.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Name for a file, one of [`PANELS`].
    pub name: &'static str,
    /// The drawing.
    pub figure: Picture,
}

/// Draws the panels of HKL Fig. 5.
///
/// (a) σ_ν, (b) ‖F⁻¹σ_t‖, (c) the deformed body, (d) an ellipse with the semi-axes F₁, F₂ and σ_t/λ_ν as a line for
/// every pane, (e) F₁, (f) F₂. With Tresca's law semi-axes are g F₁, g F₂, and σ_t is not divided. Without friction only (a) and (c), without contact only (c).
///
/// # Errors
/// [`FigureError`] when the arrays of the picture do not fit together, see [`ContactPicture::validate`].
pub fn panels(picture: &ContactPicture<'_>) -> Result<Vec<Panel>, FigureError> {
    let drawings = drawings(picture)?;
    Ok(drawings
        .into_iter()
        .map(|(name, canvas)| Panel {
            name,
            figure: Picture::new(canvas, picture.title),
        })
        .collect())
}

/// Draws where the error sits on the boundary of the body, from two opposite sides: the logarithm of `density`, for each node a share of
/// the mean, as many as `coordinates`. `sides` has words for that behind whose body the contact face is, and for the other.
///
/// # Errors
/// As [`panels`].
pub fn error_figure(
    picture: &ContactPicture<'_>,
    density: &[f64],
    sides: [&'static str; 2],
) -> Result<Picture, FigureError> {
    let canvas = error_panels(picture, density, sides)?;
    Ok(Picture::new(canvas, picture.title))
}

/// Draws all panels below a common title in two columns.
///
/// # Errors
/// As [`panels`].
pub fn page(picture: &ContactPicture<'_>) -> Result<Picture, FigureError> {
    let drawings = drawings(picture)?;
    let panel_height = drawings.first().map_or(0.0, |(_, canvas)| canvas.height);
    let rows = drawings.len().div_ceil(2) as f64;
    let mut page = Canvas::new(2.0 * PANEL_WIDTH, PAGE_TITLE_HEIGHT + rows * panel_height);
    let title = fitted(picture.title, PAGE_TITLE_SIZE, page.width - 60.0);
    let centre = [page.width / 2.0, 31.0];
    page.text(
        centre,
        &Label::plain(title),
        PAGE_TITLE_SIZE,
        Anchor::Middle,
    );
    for (index, (_, canvas)) in drawings.iter().enumerate() {
        let column = (index % 2) as f64;
        let row = (index / 2) as f64;
        let corner = [column * PANEL_WIDTH, PAGE_TITLE_HEIGHT + row * panel_height];
        page.place(canvas, corner);
    }
    Ok(Picture::new(page, picture.title))
}
