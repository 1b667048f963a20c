//! What a mesh file holds.

use std::path::PathBuf;

use contact3d::mesh::MeshInspection;
use serde_json::{Value, json};
use units::Units;

use super::{
    Digits::{Fixed, Scientific},
    FigureTable, Figures,
};

/// Sizes and quality, then faces and parts; lengths in the unit of the file.
pub fn text(mesh: &MeshInspection) -> String {
    let parts = Some(parts(mesh)).filter(|parts| !parts.rows.is_empty());
    let parts = parts.map_or("no parts (physical volumes)\n".to_owned(), |it| it.text());
    whole(mesh).text(0, 24) + &faces(mesh).text() + &parts
}

/// The same for programs, with the pictures drawn.
pub fn json(mesh: &MeshInspection, pictures: &[PathBuf]) -> Value {
    let mut all = whole(mesh).json();
    all["faces"] = faces(mesh).json();
    all["parts"] = parts(mesh).json();
    all["figures"] = json!(pictures);
    json!(all)
}

#[rustfmt::skip]
fn whole(mesh: &MeshInspection) -> Figures {
    let mut figures = Figures::new(Units::default());
    let order = if mesh.is_quadratic { "second" } else { "first" };
    figures.plain("order", "order of tetrahedra", order);
    let n_bodies = mesh.mesh.bodies.len();
    if n_bodies > 1 {
        figures.plain("n_bodies", "bodies, no nodes shared", n_bodies);
    }
    figures.plain("n_tetrahedra", "tetrahedra", mesh.n_tetrahedra);
    figures.plain("n_nodes", "nodes", mesh.n_nodes);
    let [low, high] = mesh.bounds;
    let extent = low.iter().zip(&high).fold(0.0, |most: f64, (low, high)| most.max(high - low));
    // Six digits of the extent, however far from the origin the body is.
    let decimals = (5.0 - extent.log10().floor()).clamp(0.0, 15.0) as usize;
    let rounded = |x: f64| -> f64 { format!("{x:.decimals$}").parse().unwrap_or(x) + 0.0 };
    let shown = |corner: [f64; 3]| Some(corner.map(|x| rounded(x).to_string()).join(", "));
    figures.described("bounds_min", "smallest x, y, z", shown(low), low);
    figures.described("bounds_max", "largest x, y, z", shown(high), high);
    figures.number("volume", "volume", Scientific(6), mesh.quality.total_volume);
    figures.number("shortest_edge", "shortest edge", Scientific(3), mesh.quality.shortest_edge);
    figures.number("longest_edge", "longest edge", Scientific(3), mesh.quality.longest_edge);
    figures.number("smallest_shape", "worst shape, 1 best", Fixed(3), mesh.quality.smallest_shape);
    figures.number("mean_shape", "mean shape", Fixed(3), mesh.quality.mean_shape);
    figures
}

#[rustfmt::skip]
fn faces(mesh: &MeshInspection) -> FigureTable {
    let rows = mesh.faces.iter().map(|face| {
        let mut figures = Figures::new(Units::default());
        figures.plain("name", "face", face.name.clone());
        figures.plain("n_facets", "triangles", face.n_facets);
        figures.number("area", "area", Scientific(4), face.area);
        let normal = face.normal.map(|normal| normal.map(|c| format!("{:.3}", c + 0.0)).join(", "));
        figures.described("normal", "outward normal", Some(normal.unwrap_or_else(|| "curved".into())), face.normal);
        figures
    });
    FigureTable::new("faces (physical surfaces, or else parts between edges)", rows)
}

#[rustfmt::skip]
fn parts(mesh: &MeshInspection) -> FigureTable {
    let rows = mesh.parts.iter().map(|(name, n_tetrahedra, volume)| {
        let mut figures = Figures::new(Units::default());
        figures.plain("name", "part", name.clone());
        figures.plain("n_tetrahedra", "tetrahedra", *n_tetrahedra);
        figures.number("volume", "volume", Scientific(6), *volume);
        figures
    });
    FigureTable::new("parts (physical volumes)", rows)
}
