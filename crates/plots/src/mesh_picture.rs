//! The boundary of a mesh from two sides, its faces coloured by name.

use std::ops::Range;

use super::{
    canvas::{Anchor, Canvas, Colour, Fill, Stroke},
    chart::COLOURS,
    layout::{LABEL_SIZE, PANEL_WIDTH, TICK_SIZE, axis_name, titled_panel},
    outline::{FacetNormals, mark_lines, surface_edges},
    panels::draw_triad,
    picture::Picture,
    scale::factor_label,
    surface::{Facets, Paint, draw_facets, shaded},
    text::{Label, fitted},
    view::{Fit, TOWARD, Vector, View},
};

/// Height of the title, and of the views below it.
const TITLE: f64 = 40.0;
const VIEW_HEIGHT: f64 = 430.0;
/// Names of faces in a line of the legend, and the height of a line.
const COLUMNS: usize = 4;
const LINE: f64 = 22.0;

/// The boundary of a mesh as its picture needs it.
#[derive(Clone, Copy, Debug)]
pub struct MeshPicture<'a> {
    /// Title of the page.
    pub title: &'a str,
    /// Coordinates of the nodes.
    pub coordinates: &'a [[f64; 3]],
    /// Nodes of the boundary triangles.
    pub triangles: &'a [[usize; 3]],
    /// The nodes of each of several bodies; none for one.
    pub bodies: &'a [Range<usize>],
    /// Number of the face of every triangle.
    pub face: &'a [usize],
    /// Names of the faces.
    pub names: &'a [String],
}

/// Draws a mesh as seen from above and from below, with a legend of its faces.
///
/// # Panics
/// Where arrays do not fit together.
#[must_use]
pub fn mesh_page(picture: &MeshPicture<'_>) -> Picture {
    // Most lines of the legend; the faces beyond are counted.
    let shown = picture.names.len().min(COLUMNS * 10);
    let lines = shown.div_ceil(COLUMNS) as f64;
    let size = [2.0 * PANEL_WIDTH, TITLE + VIEW_HEIGHT + lines * LINE + 24.0];
    let title = fitted(picture.title, 15.0, size[0] - 40.0);
    let mut page = titled_panel(size, &Label::plain(title));
    let below = TOWARD.map(|c| -c);
    for (column, (words, toward)) in [("from above", TOWARD), ("from below", below)]
        .into_iter()
        .enumerate()
    {
        let view = drawn(picture, words, toward);
        page.place(&view, [column as f64 * PANEL_WIDTH, TITLE]);
    }
    draw_legend(&mut page, &picture.names[..shown], picture.names.len());
    Picture::new(page, picture.title)
}

/// The colour of a face: those of charts, then lighter ones.
fn colour(face: usize) -> Colour {
    let Colour(red, green, blue) = COLOURS[face % COLOURS.len()];
    let lighter = 0.25 + 0.3 * ((face / COLOURS.len()) % 3) as f64;
    let mix = |channel: u8| channel + shade_of(255 - channel, lighter);
    Colour(mix(red), mix(green), mix(blue))
}

fn shade_of(channel: u8, share: f64) -> u8 {
    shaded(Colour(channel, 0, 0), share).0
}

fn drawn(picture: &MeshPicture<'_>, words: &str, toward: Vector) -> Canvas {
    let mut canvas = Canvas::new(PANEL_WIDTH, VIEW_HEIGHT);
    let basis = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let corners = picture.triangles.as_flattened().iter();
    let corners = corners.map(|&node| picture.coordinates[node]);
    let view = View::of(basis, corners.clone(), toward);
    let points: Vec<Vector> = picture
        .coordinates
        .iter()
        .map(|&x| view.stretched(x))
        .collect();
    let mut edges = surface_edges(picture.triangles);
    let normals = FacetNormals::new(&points, picture.triangles, &edges);
    mark_lines(&mut edges, &normals, picture.face);
    let projected = corners.map(|x| view.projected(view.stretched(x)));
    let fit = Fit::new(
        projected,
        [76.0, 30.0],
        [PANEL_WIDTH - 100.0, VIEW_HEIGHT - 60.0],
    );
    let colours: Vec<Colour> = picture.face.iter().map(|&face| colour(face)).collect();
    let facets = Facets {
        points: &points,
        paint: Paint::Faces(&colours),
        triangles: picture.triangles,
        bodies: picture.bodies,
        edges: &edges,
    };
    draw_facets(&mut canvas, &facets, &view, &fit);
    draw_triad(&mut canvas, &view, [48.0, VIEW_HEIGHT - 48.0]);
    let stretched = (0..3).filter(|&axis| view.stretch[axis] > 1.0);
    let words = stretched.fold(Label::plain(words), |words, axis| {
        let name = axis_name(basis[axis], "");
        let words = words.upright(", ").then(&name).upright(" stretched × ");
        words.then(&factor_label(view.stretch[axis]))
    });
    canvas.text([16.0, 16.0], &words, TICK_SIZE, Anchor::Start);
    canvas
}

fn draw_legend(page: &mut Canvas, names: &[String], all: usize) {
    let width = (2.0 * PANEL_WIDTH - 32.0) / COLUMNS as f64;
    let more = all - names.len();
    for (face, name) in names.iter().enumerate() {
        let [column, line] = [face % COLUMNS, face / COLUMNS].map(|k| k as f64);
        let [x, y] = [
            16.0 + column * width,
            TITLE + VIEW_HEIGHT + 16.0 + line * LINE,
        ];
        let edge = Stroke::solid(Colour::BLACK, 0.6);
        let fill = Fill::Plain(colour(face));
        page.rectangle([x, y - 11.0], [14.0, 14.0], fill, Some(edge));
        let name = if face + 1 == names.len() && more > 0 {
            format!("{name}, and {more} more")
        } else {
            name.clone()
        };
        let name = fitted(&name, LABEL_SIZE, width - 34.0);
        page.text(
            [x + 20.0, y],
            &Label::plain(name),
            LABEL_SIZE,
            Anchor::Start,
        );
    }
}
