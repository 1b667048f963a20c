//! The oblique view of the body: stretched axes t₁, t₂, −ν, parallel projection, and its facets from back to
//! front.

use super::{
    canvas::{Canvas, Colour, Fill, Point, Stroke},
    colour_bar::ColourKey,
    layout::stretch_factor,
    picture::ContactPicture,
    surface::{FacetNormals, SurfaceEdge},
    svg::{Vector, bounds, cross, dot, unit},
};

/// From the body to the viewer, in the basis (t₁, −ν × t₁, −ν): in front, a little to the right and
/// above.
const TOWARD: Vector = [0.34, -0.84, 0.42];

/// Bodies that are longer than this many times their width or height are stretched across.
const MOST_SLENDER: f64 = 25.0;

/// Maps points of the body to the view, x to the right, y upwards, z towards the viewer.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// t₁, −ν × t₁ and −ν.
    pub(super) basis: [Vector; 3],
    /// Stretch along the basis vectors; all 1 unless the body is very slender.
    pub(super) stretch: [f64; 3],
    screen: [Vector; 3],
}

impl View {
    /// The view of the undeformed body.
    pub(super) fn new(picture: &ContactPicture<'_>) -> Self {
        let first = unit(picture.axis_1);
        let up = unit(picture.normal.map(|component| -component));
        let basis = [first, cross(up, first), up];
        let nodes = || picture.boundary_triangles.as_flattened().iter();
        let extents = basis.map(|axis| {
            let (low, high) = bounds(nodes().map(|&node| dot(axis, picture.coordinates[node])));
            high - low
        });
        let longest = extents.into_iter().fold(0.0, f64::max);
        let stretch = extents.map(|extent| {
            if extent > 0.0 {
                stretch_factor(longest / extent, MOST_SLENDER)
            } else {
                1.0
            }
        });
        let toward = unit(TOWARD);
        let right = unit(cross([0.0, 0.0, 1.0], toward));
        Self {
            basis,
            stretch,
            screen: [right, cross(toward, right), toward],
        }
    }

    /// A position or displacement in the stretched basis.
    pub(super) fn stretched(&self, vector: Vector) -> Vector {
        [0, 1, 2].map(|axis| self.stretch[axis] * dot(self.basis[axis], vector))
    }

    /// A direction in the basis, not stretched.
    pub(super) fn turned(&self, vector: Vector) -> Vector {
        self.basis.map(|axis| dot(axis, vector))
    }

    /// View coordinates of a vector in the stretched basis.
    pub(super) fn projected(&self, vector: Vector) -> Vector {
        self.screen.map(|axis| dot(axis, vector))
    }

    /// Unit vector to the viewer in the stretched basis.
    pub(super) fn toward(&self) -> Vector {
        self.screen[2]
    }
}

/// Scales view coordinates into a rectangle of the canvas.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    scale: f64,
    centre: Point,
    target: Point,
}

impl Fit {
    /// The largest scale at which all `points` lie in the rectangle.
    pub(super) fn new(
        points: impl Iterator<Item = Vector> + Clone,
        corner: Point,
        size: Point,
    ) -> Self {
        let (left, right) = bounds(points.clone().map(|p| p[0]));
        let (bottom, top) = bounds(points.map(|p| p[1]));
        let scale = (size[0] / (right - left)).min(size[1] / (top - bottom));
        Self {
            scale: if scale.is_finite() { scale } else { 1.0 },
            centre: [left.midpoint(right), bottom.midpoint(top)],
            target: [corner[0] + size[0] / 2.0, corner[1] + size[1] / 2.0],
        }
    }

    /// Pixel of a point in view coordinates.
    pub(super) fn pixel(&self, point: Vector) -> Point {
        [
            self.target[0] + self.scale * (point[0] - self.centre[0]),
            self.target[1] - self.scale * (point[1] - self.centre[1]),
        ]
    }
}

/// Coarse surfaces are refined up to about this many coloured pieces.
const PIECES: usize = 5000;
/// Most pieces along an edge of a facet.
const MOST_PIECES_PER_EDGE: usize = 16;

/// A surface with a value at every node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facets<'a> {
    /// Deformed nodes in the stretched basis of the view.
    pub(super) points: &'a [Vector],
    /// |u| of every node.
    pub(super) magnitude: &'a [f64],
    pub(super) triangles: &'a [[usize; 3]],
    pub(super) edges: &'a [SurfaceEdge],
}

/// Draws what is visible of a surface from back to front, sharp edges and contours as lines.
pub(super) fn draw_facets(
    canvas: &mut Canvas,
    facets: &Facets<'_>,
    view: &View,
    fit: &Fit,
    key: &ColourKey,
) {
    let toward = view.toward();
    let normals = FacetNormals::new(facets.points, facets.triangles, facets.edges);
    let mut order: Vec<(usize, f64)> = (0..facets.triangles.len())
        .filter(|&triangle| normals.faces(triangle, toward))
        .map(|triangle| {
            let depth = facets.triangles[triangle].map(|n| dot(facets.points[n], toward));
            (triangle, depth.iter().sum::<f64>())
        })
        .collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    let mut visible = vec![false; facets.triangles.len()];
    let mut last_at_node = vec![0; facets.points.len()];
    for (position, &(triangle, _)) in order.iter().enumerate() {
        visible[triangle] = true;
        for node in facets.triangles[triangle] {
            last_at_node[node] = position;
        }
    }
    // An edge is drawn after all facets that touch it, so that none covers a part of its line.
    let mut edges_after = vec![Vec::new(); order.len()];
    for edge in facets.edges {
        let seen = edge.triangles.iter().any(|&triangle| visible[triangle]);
        if seen && normals.is_outline(edge, toward) {
            let [p, q] = edge.nodes;
            edges_after[last_at_node[p].max(last_at_node[q])].push(edge.nodes);
        }
    }
    let pieces = pieces_per_edge(order.len());
    let pixel = |node: usize| fit.pixel(view.projected(facets.points[node]));
    for (&(triangle, _), edges) in order.iter().zip(&edges_after) {
        let brightness = brightness(normals.normals[triangle], toward);
        draw_facet(canvas, facets, triangle, pieces, brightness, key, &pixel);
        let lines: Vec<Vec<Point>> = edges.iter().map(|e| e.map(pixel).to_vec()).collect();
        if !lines.is_empty() {
            canvas.polylines(&lines, Stroke::solid(Colour::BLACK, 0.9));
        }
    }
}

/// Draws one facet in `pieces`² congruent pieces, each in the colour of its mean value.
fn draw_facet(
    canvas: &mut Canvas,
    facets: &Facets<'_>,
    triangle: usize,
    pieces: usize,
    brightness: f64,
    key: &ColourKey,
    pixel: &impl Fn(usize) -> Point,
) {
    let nodes = facets.triangles[triangle];
    let corners = nodes.map(pixel);
    let values = nodes.map(|node| facets.magnitude[node]);
    for piece in piece_coordinates(pieces) {
        let points = piece.map(|[s, t]| {
            [0, 1].map(|axis| {
                let [a, b, c] = corners.map(|corner| corner[axis]);
                a + s * (b - a) + t * (c - a)
            })
        });
        let [s, t] = [0, 1].map(|k| (piece[0][k] + piece[1][k] + piece[2][k]) / 3.0);
        let value = (1.0 - s - t) * values[0] + s * values[1] + t * values[2];
        let (fill, seam) = match key.fill(value) {
            Fill::Plain(colour) => {
                let colour = shaded(colour, brightness);
                (Fill::Plain(colour), Some(Stroke::solid(colour, 0.5)))
            }
            other => (other, None),
        };
        canvas.region(&[points.to_vec()], fill, seam);
    }
}

fn pieces_per_edge(facets: usize) -> usize {
    let mut pieces = 1;
    while pieces < MOST_PIECES_PER_EDGE && facets * (pieces + 1) * (pieces + 1) <= PIECES {
        pieces += 1;
    }
    pieces
}

/// The pieces of the reference triangle cut `n` times along each edge: corners (s, t) with s, t ≥
/// 0, s + t ≤ 1.
fn piece_coordinates(n: usize) -> Vec<[[f64; 2]; 3]> {
    let at = |i: usize, j: usize| [i as f64 / n as f64, j as f64 / n as f64];
    let mut pieces = Vec::with_capacity(n * n);
    for i in 0..n {
        for j in 0..n - i {
            pieces.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
            if i + j + 2 <= n {
                pieces.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    pieces
}

/// Brightness of a facet lit from above the viewer's left shoulder, from 0.72 to 1.
fn brightness(normal: Vector, toward: Vector) -> f64 {
    let light = unit([toward[0] - 0.5, toward[1], toward[2] + 0.7]);
    let facing = if dot(normal, toward) < 0.0 { -1.0 } else { 1.0 };
    0.72 + 0.28 * (facing * dot(normal, light)).max(0.0)
}

fn shaded(Colour(red, green, blue): Colour, brightness: f64) -> Colour {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a product of 0..=255 and 0..=1"
    )]
    let shade = |channel: u8| (f64::from(channel) * brightness).round() as u8;
    Colour(shade(red), shade(green), shade(blue))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_fill_the_reference_triangle() {
        for n in 1..=5 {
            let pieces = piece_coordinates(n);
            assert_eq!(pieces.len(), n * n);
            let area: f64 = pieces
                .iter()
                .map(|[a, b, c]| {
                    ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0
                })
                .sum();
            // A sum of 25 terms below 1/2.
            assert!((area - 0.5).abs() < 1e-14, "n = {n}: {area}");
        }
    }
}
