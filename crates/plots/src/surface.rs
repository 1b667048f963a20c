//! The surface of bodies from back to front, in the colours of a field or of faces.

use std::ops::Range;

use super::{
    canvas::{Canvas, Colour, Fill, Point, Stroke},
    colour::ColourKey,
    outline::{FacetNormals, SurfaceEdge},
    scale::bounds,
    view::{Fit, Vector, View, dot, unit},
};

/// A surface to be drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facets<'a> {
    /// Deformed nodes in the stretched basis of the view.
    pub(super) points: &'a [Vector],
    pub(super) paint: Paint<'a>,
    pub(super) triangles: &'a [[usize; 3]],
    /// The nodes of each of several bodies; none for one.
    pub(super) bodies: &'a [Range<usize>],
    pub(super) edges: &'a [SurfaceEdge],
}

/// What colours a surface.
#[derive(Clone, Copy, Debug)]
pub(super) enum Paint<'a> {
    /// A value at every node, by its key.
    Values(&'a [f64], &'a ColourKey),
    /// A colour for every triangle, with the lines between them.
    Faces(&'a [Colour]),
}

/// Draws what is visible of a surface from back to front, sharp edges and contours as lines.
pub(super) fn draw_facets(canvas: &mut Canvas, facets: &Facets<'_>, view: &View, fit: &Fit) {
    let toward = view.toward();
    let normals = FacetNormals::new(facets.points, facets.triangles, facets.edges);
    let bodies = from_back_to_front(facets.points, facets.bodies, toward);
    let mut order: Vec<(usize, f64)> = (0..facets.triangles.len())
        .filter(|&triangle| normals.faces(triangle, toward))
        .map(|triangle| {
            let depth = facets.triangles[triangle].map(|n| dot(facets.points[n], toward));
            (triangle, depth.iter().sum::<f64>())
        })
        .collect();
    let body = |triangle: usize| {
        let node = facets.triangles[triangle][0];
        bodies
            .iter()
            .position(|&body| facets.bodies[body].contains(&node))
    };
    order.sort_by(|a, b| {
        let by_body = body(a.0).cmp(&body(b.0));
        by_body.then(a.1.total_cmp(&b.1)).then(a.0.cmp(&b.0))
    });
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
    let pixel = |node: usize| fit.pixel(view.projected(facets.points[node]));
    let pieces = match facets.paint {
        Paint::Values(magnitude, key) => {
            let drawn = order
                .iter()
                .map(|&(triangle, _)| facets.triangles[triangle]);
            let drawn = drawn.map(|nodes| (nodes.map(pixel), nodes.map(|node| magnitude[node])));
            pieces_per_edge(&drawn.collect::<Vec<_>>(), key)
        }
        Paint::Faces(_) => vec![1; order.len()],
    };
    for ((&(triangle, _), edges), pieces) in order.iter().zip(&edges_after).zip(pieces) {
        let brightness = brightness(normals.normals[triangle], toward);
        let nodes = facets.triangles[triangle];
        let corners = nodes.map(pixel);
        match facets.paint {
            Paint::Values(magnitude, key) => {
                let values = nodes.map(|node| magnitude[node]);
                draw_facet(canvas, corners, values, pieces, brightness, key);
            }
            Paint::Faces(colours) => {
                let fill = shaded(colours[triangle], brightness);
                let edge = Stroke::solid(shaded(fill, 0.8), 0.4);
                canvas.region(&[corners.to_vec()], Fill::Plain(fill), Some(edge));
            }
        }
        let lines: Vec<Vec<Point>> = edges.iter().map(|e| e.map(pixel).to_vec()).collect();
        if !lines.is_empty() {
            canvas.polylines(&lines, Stroke::solid(Colour::BLACK, 0.9));
        }
    }
}

/// Bodies from back to front: one that a plane across an axis parts from another, on the side of the viewer, comes after it; of bodies that go
/// round in a ring the one whose middle is furthest.
fn from_back_to_front(points: &[Vector], bodies: &[Range<usize>], toward: Vector) -> Vec<usize> {
    let extent = |body: &Range<usize>| {
        [0, 1, 2].map(|axis| bounds(points[body.clone()].iter().map(|point| point[axis])))
    };
    let boxes: Vec<[(f64, f64); 3]> = bodies.iter().map(extent).collect();
    let middle = |body: usize| dot(boxes[body].map(|(low, high)| low.midpoint(high)), toward);
    // Magnified displacements let bodies that touch overlap by a part of their height.
    let is_before = |one: usize, other: usize| {
        (0..3).any(|axis| {
            let (a, b) = (boxes[one][axis], boxes[other][axis]);
            let overlap = 0.2 * (a.1 - a.0).min(b.1 - b.0);
            let (front, behind) = if toward[axis] > 0.0 { (a, b) } else { (b, a) };
            front.0 + front.1 > behind.0 + behind.1 && front.0 >= behind.1 - overlap
        })
    };
    let hides = |one: usize, other: usize| is_before(one, other) && !is_before(other, one);
    let mut left: Vec<usize> = (0..bodies.len()).collect();
    left.sort_by(|&one, &other| middle(one).total_cmp(&middle(other)));
    let mut order = Vec::with_capacity(left.len());
    while !left.is_empty() {
        let is_free = |body: &usize| !left.iter().any(|other| hides(*body, *other));
        let next = left.iter().position(is_free).unwrap_or(0);
        order.push(left.remove(next));
    }
    order
}

/// Draws one facet in `pieces`² congruent pieces, each in the colour of its mean value.
fn draw_facet(
    canvas: &mut Canvas,
    corners: [Point; 3],
    values: [f64; 3],
    pieces: usize,
    brightness: f64,
    key: &ColourKey,
) {
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
                (Fill::Plain(colour), Some(Stroke::solid(colour, 0.9)))
            }
            other => (other, None),
        };
        canvas.region(&[points.to_vec()], fill, seam);
    }
}

/// Pieces along the edges of each facet, given its corners and values: steps of 1/60 of the colours and of two pixels at least, larger ones
/// where that makes more pieces than a file of ordinary size has.
fn pieces_per_edge(facets: &[([Point; 3], [f64; 3])], key: &ColourKey) -> Vec<usize> {
    let wanted = |(corners, values): &([Point; 3], [f64; 3])| {
        let (low, high) = bounds(values.iter().filter_map(|&value| key.range.fraction(value)));
        let sides = [[0, 1], [1, 2], [2, 0]].map(|[p, q]| {
            let [from, to] = [corners[p], corners[q]];
            (to[0] - from[0]).hypot(to[1] - from[1])
        });
        let longest = sides.into_iter().fold(0.0, f64::max);
        (60.0 * (high - low)).min(longest / 2.0).max(1.0)
    };
    let wanted: Vec<f64> = facets.iter().map(wanted).collect();
    let all: f64 = wanted.iter().map(|n| n * n).sum();
    // Most pieces of a surface.
    let share = (6000.0 / all).sqrt().min(1.0);
    let pieces = wanted.iter().map(|n| (n * share).round().max(1.0));
    pieces.map(|n| n as usize).collect()
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

/// Brightness of a facet lit from the viewer's left shoulder, above or, seen from below, below it, from 0.72 to 1.
pub(super) fn brightness(normal: Vector, toward: Vector) -> f64 {
    let light = unit([
        toward[0] - 0.5,
        toward[1],
        toward[2] + 0.7_f64.copysign(toward[2]),
    ]);
    let facing = if dot(normal, toward) < 0.0 { -1.0 } else { 1.0 };
    0.72 + 0.28 * (facing * dot(normal, light)).max(0.0)
}

pub(super) fn shaded(Colour(red, green, blue): Colour, brightness: f64) -> Colour {
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

    /// A stack from below to above, and three bars of which each leans over the next: none is last of all, none is lost.
    #[test]
    fn bodies_behind_others_come_first() {
        let boxed = |low: Vector, high: Vector| [low, high];
        let toward = [0.34, -0.84, 0.42];
        let order = |boxes: &[[Vector; 2]]| {
            let bodies: Vec<Range<usize>> = (0..boxes.len()).map(|k| 2 * k..2 * k + 2).collect();
            from_back_to_front(boxes.as_flattened(), &bodies, toward)
        };
        let at = |z: f64| boxed([0.0, 0.0, z], [1.0, 1.0, z + 1.0]);
        assert_eq!(order(&[at(1.0), at(2.0), at(0.0)]), [2, 0, 1]);
        // Overlaps along one axis alone are told by the others.
        let beside = |y: f64| boxed([0.0, y, 0.0], [1.0, y + 1.0, 1.0]);
        assert_eq!(order(&[beside(0.0), beside(1.5)]), [1, 0]);
        let ring = [
            boxed([0.0, 0.0, 0.0], [3.0, 1.0, 1.0]),
            boxed([2.0, -1.0, 1.0], [3.0, 3.0, 2.0]),
            boxed([-1.0, 2.0, -1.0], [2.5, 3.0, 3.0]),
        ];
        let mut all = order(&ring);
        all.sort_unstable();
        assert_eq!(all, [0, 1, 2]);
    }
}
