//! The pictures of HKL Fig. 5: contact stresses, deformed body, friction ellipses and coefficients of friction.
//!
//! [`panels`] draws every panel as a figure of its own, [`page`] all of them as one page of two columns; a [`Figure`]
//! is written as SVG or PNG. Colours come from perceptually uniform maps, units carry SI prefixes where they take any,
//! and no fonts or libraries of the system are used. [`law_page`] draws a law of friction alone.

#![deny(clippy::print_stdout, clippy::print_stderr)]

mod body;
mod canvas;
mod chart;
mod colour;
mod colour_bar;
mod ellipses;
mod facets;
mod figure;
mod friction_labels;
mod hatch;
pub mod html;
mod law;
mod law_axes;
mod layout;
mod line_chart;
mod log_ticks;
mod maps;
mod panes;
mod picture;
mod raster;
#[cfg(test)]
mod sample;
mod scale;
mod surface;
mod svg;
#[cfg(test)]
mod tests;
mod text;
mod typeface;
mod vector;
mod view;

pub use figure::Figure;
pub use friction_labels::FrictionKind;
pub use law::{LawPicture, OverSlip, SlipCurve, SlipMap, SlipRange, law_page};
pub use line_chart::{Axis as ChartAxis, AxisScale, ChartPoint, LineChart, Series};
pub use picture::{ContactPicture, FigureError, PaneFriction, Zone};

use canvas::{Anchor, Canvas};
use colour::{ColourMap, ValueRange};
use colour_bar::ColourKey;
use layout::{Layout, PANEL_WIDTH};
use panes::{PaneShape, pane_shapes};
use text::{Label, fitted};
use units::{Dimension, Unit};

/// Height of the title of a page.
const PAGE_TITLE_HEIGHT: f64 = 46.0;
const PAGE_TITLE_SIZE: f64 = 19.0;

/// Names of all panels of HKL Fig. 5, for files.
pub const PANELS: [&str; 6] = [
    "a_normal_stress",
    "b_scaled_tangential_stress",
    "c_deformed_body",
    "d_friction_ellipses",
    "e_friction_1",
    "f_friction_2",
];

/// One panel of HKL Fig. 5.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Name for a file, one of [`PANELS`].
    pub name: &'static str,
    /// The drawing.
    pub figure: Figure,
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
            figure: Figure::new(canvas, picture.title),
        })
        .collect())
}

/// Draws all panels below a common title in two columns.
///
/// # Errors
/// As [`panels`].
pub fn page(picture: &ContactPicture<'_>) -> Result<Figure, FigureError> {
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
    Ok(Figure::new(page, picture.title))
}

/// All panels that the picture allows, of equal size.
fn drawings(picture: &ContactPicture<'_>) -> Result<Vec<(&'static str, Canvas)>, FigureError> {
    picture.validate()?;
    let layout = Layout::new(picture);
    let shapes = pane_shapes(picture);
    let mut drawings = Vec::new();
    if !picture.contact_triangles.is_empty() {
        drawings.push(normal_stress(picture, &layout, &shapes));
    }
    if let Some((kind, friction)) = picture.friction {
        drawings.push(scaled_tangential(
            picture,
            (kind, friction),
            &layout,
            &shapes,
        ));
    }
    let title = Label::plain("(c) Deformed body");
    let body = body::body_panel(picture, &layout, &title);
    drawings.push((PANELS[2], body));
    if let Some((kind, friction)) = picture.friction {
        let title = Label::plain("(d) Friction ellipses and tangential contact stress");
        let unit = kind.unit(picture.units);
        let law = (kind, &unit);
        let ellipses = ellipses::ellipse_panel(&layout, &shapes, &title, law, friction);
        drawings.push((PANELS[3], ellipses));
        let symbols = [0, 1].map(|axis| kind.semi_axis_symbol(axis));
        let title = |letter: &str, axis: usize| {
            let words = format!("({letter}) {}", kind.semi_axis_title());
            Label::plain(words).then(&symbols[axis])
        };
        let titles = [title("e", 0), title("f", 1)];
        let face = (&layout, shapes.as_slice());
        let [first, second] = semi_axes((friction, &unit), face, &titles, &symbols);
        drawings.push((PANELS[4], first));
        drawings.push((PANELS[5], second));
    }
    Ok(drawings)
}

fn normal_stress(
    picture: &ContactPicture<'_>,
    layout: &Layout,
    shapes: &[PaneShape],
) -> (&'static str, Canvas) {
    let symbol = Label::default().italic("σ").subscript("ν");
    let values = shapes.iter().map(|shape| picture.normal_stress[shape.pane]);
    let unit = picture.units.of(Dimension::STRESS);
    let key = ColourKey::new(values, ColourMap::Viridis, &symbol, &unit);
    let title = Label::plain("(a) Normal contact stress ").then(&symbol);
    let value = |pane: usize| picture.normal_stress[pane];
    let map = maps::map_panel(layout, shapes, &title, &key, &unit, value);
    (PANELS[0], map)
}

fn scaled_tangential(
    picture: &ContactPicture<'_>,
    (kind, friction): (FrictionKind, &[PaneFriction]),
    layout: &Layout,
    shapes: &[PaneShape],
) -> (&'static str, Canvas) {
    let symbol = kind.scaled_symbol();
    let unit = kind.scaled_unit(picture.units);
    let value = |pane: usize| friction[pane].scaled_tangential;
    let values = shapes.iter().map(|shape| value(shape.pane));
    let key = ColourKey::new(values, ColourMap::Viridis, &symbol, &unit);
    let title = Label::plain(kind.scaled_title()).then(&symbol);
    let map = maps::map_panel(layout, shapes, &title, &key, &unit, value);
    (PANELS[1], map)
}

/// The maps of F₁ and F₂, or of g F₁ and g F₂, with common colours unless these would hide the
/// variation of one of them.
fn semi_axes(
    (friction, unit): (&[PaneFriction], &Unit),
    (layout, shapes): (&Layout, &[PaneShape]),
    titles: &[Label; 2],
    symbols: &[Label; 2],
) -> [Canvas; 2] {
    let value = |pane: usize, axis: usize| friction[pane].semi_axes[axis];
    let values = |axis: usize| shapes.iter().map(move |shape| value(shape.pane, axis));
    let own = [0, 1].map(|axis| ValueRange::of(values(axis)));
    let ranges = own[0].shared(own[1]).map_or(own, |common| [common; 2]);
    [0, 1].map(|axis| {
        let gaps = values(axis).any(|value| !value.is_finite());
        let map = ColourMap::Cividis;
        let key = ColourKey::with_range(ranges[axis], gaps, map, &symbols[axis], unit);
        maps::map_panel(layout, shapes, &titles[axis], &key, unit, |pane| {
            value(pane, axis)
        })
    })
}
