//! The oblique view of the body: stretched axes t₁, t₂, −ν, parallel projection, the edges of its surface, and its facets from back to
//! front.

use std::collections::BTreeMap;

use super::{
    canvas::{Canvas, Colour, Fill, Point, Stroke},
    colour::ColourKey,
    layout::stretch_factor,
    picture::ContactPicture,
    scale::bounds,
};

/// From the body to the viewer, in the basis (t₁, −ν × t₁, −ν): in front, a little to the right and
/// above.
pub(super) const TOWARD: Vector = [0.34, -0.84, 0.42];

/// The cosine, of 37 degrees, below which an axis and a normal are two directions.
const NEARLY_ALONG: f64 = 0.8;

/// Maps points of the body to the view, x to the right, y upwards, z towards the viewer.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// t₁, −ν × t₁ and −ν; with ν for −ν where z would point down.
    pub(super) basis: [Vector; 3],
    /// Stretch along the basis vectors; all 1 unless the body is very slender.
    pub(super) stretch: [f64; 3],
    screen: [Vector; 3],
}

impl View {
    /// The view of the undeformed body from a direction in the basis (t₁, −ν × t₁, −ν).
    pub(super) fn new(picture: &ContactPicture<'_>, toward: Vector) -> Self {
        let first = unit(picture.axis_1);
        let away = unit(picture.normal.map(|component| -component));
        // A body below what it touches hangs from the contact face: z stays up.
        let up = if picture.is_contact_above() {
            away.map(|component| -component)
        } else {
            away
        };
        // A face that is nearly level or plumb hangs or stands as the coordinate axis does.
        let upright = [0, 1, 2]
            .into_iter()
            .find(|&axis| up[axis].abs() > NEARLY_ALONG);
        let (first, up) = match upright {
            None => (first, up),
            Some(axis) => {
                let mut along = [0.0; 3];
                along[axis] = up[axis].signum();
                let flat = [0, 1, 2].map(|c| first[c] - dot(first, along) * along[c]);
                (unit(flat), along)
            }
        };
        let basis = [first, cross(up, first), up];
        let nodes = picture.boundary_triangles.as_flattened().iter();
        Self::of(basis, nodes.map(|&node| picture.coordinates[node]), toward)
    }

    /// The view of points from a direction in a basis.
    pub(super) fn of(
        basis: [Vector; 3],
        points: impl Iterator<Item = Vector> + Clone,
        toward: Vector,
    ) -> Self {
        let extents = basis.map(|axis| {
            let (low, high) = bounds(points.clone().map(|point| dot(axis, point)));
            high - low
        });
        let longest = extents.into_iter().fold(0.0, f64::max);
        let stretch = extents.map(|extent| {
            if extent > 0.0 {
                // Bodies that are longer than this many times their width or height are stretched across.
                stretch_factor(longest / extent, 25.0)
            } else {
                1.0
            }
        });
        let toward = unit(toward);
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

/// A surface to be drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facets<'a> {
    /// Deformed nodes in the stretched basis of the view.
    pub(super) points: &'a [Vector],
    pub(super) paint: Paint<'a>,
    pub(super) triangles: &'a [[usize; 3]],
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
    let bodies = bodies_in_front(facets, toward);
    let mut order: Vec<(usize, f64)> = (0..facets.triangles.len())
        .filter(|&triangle| normals.faces(triangle, toward))
        .map(|triangle| {
            let depth = facets.triangles[triangle].map(|n| dot(facets.points[n], toward));
            (triangle, depth.iter().sum::<f64>())
        })
        .collect();
    let body = |triangle: usize| bodies[facets.triangles[triangle][0]];
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

/// How many bodies lie behind that of each node, one behind the other; those that no plane across an axis parts count as one.
fn bodies_in_front(facets: &Facets<'_>, toward: Vector) -> Vec<usize> {
    let mut body: Vec<usize> = (0..facets.points.len()).collect();
    fn first(body: &mut [usize], mut node: usize) -> usize {
        while body[node] != node {
            body[node] = body[body[node]];
            node = body[node];
        }
        node
    }
    for [a, b, c] in facets.triangles {
        for other in [b, c] {
            let (one, two) = (first(&mut body, *a), first(&mut body, *other));
            body[one.max(two)] = one.min(two);
        }
    }
    let of_node: Vec<usize> = (0..body.len()).map(|node| first(&mut body, node)).collect();
    let mut boxes: BTreeMap<usize, [[f64; 2]; 3]> = BTreeMap::new();
    for &node in facets.triangles.as_flattened() {
        let sides = boxes
            .entry(of_node[node])
            .or_insert([[f64::INFINITY, f64::NEG_INFINITY]; 3]);
        for (side, x) in sides.iter_mut().zip(facets.points[node]) {
            *side = [side[0].min(x), side[1].max(x)];
        }
    }
    // Magnified displacements let bodies that touch overlap by a part of their height.
    let is_before = |a: &[[f64; 2]; 3], b: &[[f64; 2]; 3]| {
        (0..3).any(|axis| {
            let (a, b) = (a[axis], b[axis]);
            let overlap = 0.2 * (a[1] - a[0]).min(b[1] - b[0]);
            let (front, behind) = if toward[axis] > 0.0 { (a, b) } else { (b, a) };
            (front[0] + front[1] > behind[0] + behind[1]) && front[0] >= behind[1] - overlap
        })
    };
    let mut ranks: BTreeMap<usize, usize> = boxes.keys().map(|&key| (key, 0)).collect();
    for _ in 0..boxes.len() {
        for (key, mine) in &boxes {
            let behind = boxes.iter().filter(|(other, its)| {
                *other != key && is_before(mine, its) && !is_before(its, mine)
            });
            let rank = behind.map(|(other, _)| ranks[other] + 1).max().unwrap_or(0);
            ranks.insert(*key, rank.min(boxes.len()));
        }
    }
    of_node
        .iter()
        .map(|key| ranks.get(key).copied().unwrap_or(0))
        .collect()
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
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 1 to 60"
    )]
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
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a product of 0..=255 and 0..=1"
    )]
    let shade = |channel: u8| (f64::from(channel) * brightness).round() as u8;
    Colour(shade(red), shade(green), shade(blue))
}

/// An edge with the one or two (or more) triangles that meet in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct SurfaceEdge {
    pub(super) nodes: [usize; 2],
    pub(super) triangles: Vec<usize>,
    /// Whether it is drawn from wherever it is seen: at a rim, between named faces, or a crease of the body at rest.
    pub(super) is_line: bool,
}

/// All edges of a surface, ordered by their nodes.
pub(super) fn surface_edges(triangles: &[[usize; 3]]) -> Vec<SurfaceEdge> {
    let mut edges: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
    for (index, &[a, b, c]) in triangles.iter().enumerate() {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            edges.entry([p.min(q), p.max(q)]).or_default().push(index);
        }
    }
    let edges = edges.into_iter();
    edges
        .map(|(nodes, triangles)| SurfaceEdge {
            nodes,
            is_line: triangles.len() != 2,
            triangles,
        })
        .collect()
}

/// Marks the edges between named faces, and the creases of the body at rest.
pub(super) fn mark_lines(edges: &mut [SurfaceEdge], rest: &FacetNormals, faces: &[usize]) {
    for edge in edges {
        if let [first, second] = edge.triangles[..] {
            let cosine = dot(rest.normals[first], rest.normals[second]);
            let cosine = if rest.outward { cosine } else { cosine.abs() };
            // Facets that meet at more than 50° have a crease between them; those of coarse round faces meet at less.
            edge.is_line = cosine < 0.643 || faces.get(first) != faces.get(second);
        }
    }
}

/// Joins edges that meet in a node of two edges to lines of nodes; every edge is used once.
pub(super) fn joined_lines(edges: &[[usize; 2]]) -> Vec<Vec<usize>> {
    let mut edges_at: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (index, edge) in edges.iter().enumerate() {
        for &node in edge {
            edges_at.entry(node).or_default().push(index);
        }
    }
    let mut used = vec![false; edges.len()];
    let mut lines = Vec::new();
    // Lines start where they end or branch; what remains are rings, which start anywhere.
    let ends = edges_at.iter().filter(|(_, at)| at.len() != 2);
    let starts = ends.chain(edges_at.iter());
    for (&start, at_start) in starts {
        for &first in at_start {
            if used[first] {
                continue;
            }
            let mut line = vec![start];
            let mut edge = first;
            loop {
                used[edge] = true;
                let [p, q] = edges[edge];
                let node = if line.last() == Some(&p) { q } else { p };
                line.push(node);
                let at = &edges_at[&node];
                match at.iter().find(|&&next| !used[next]) {
                    Some(&next) if at.len() == 2 => edge = next,
                    _ => break,
                }
            }
            lines.push(line);
        }
    }
    lines
}

/// Normals of the triangles, outward when the surface is closed and consistently oriented.
pub(super) struct FacetNormals {
    /// Unit normals.
    pub(super) normals: Vec<Vector>,
    /// Whether they all point outward, so that facets turned away from the viewer are hidden.
    pub(super) outward: bool,
}

impl FacetNormals {
    /// Normals of `triangles` with the nodes at `points`.
    pub(super) fn new(points: &[Vector], triangles: &[[usize; 3]], edges: &[SurfaceEdge]) -> Self {
        let mut normals: Vec<Vector> = triangles
            .iter()
            .map(|&[a, b, c]| {
                unit(cross(
                    minus(points[b], points[a]),
                    minus(points[c], points[a]),
                ))
            })
            .collect();
        let outward = is_oriented(triangles, edges);
        if outward && enclosed_volume(points, triangles) < 0.0 {
            for normal in &mut normals {
                *normal = normal.map(|component| -component);
            }
        }
        Self { normals, outward }
    }

    /// Whether the edge belongs to the outline seen from direction `toward`: a line, or between a visible and a hidden facet.
    pub(super) fn is_outline(&self, edge: &SurfaceEdge, toward: Vector) -> bool {
        let is_seen = |triangle: &usize| dot(self.normals[*triangle], toward) > 0.0;
        let count = edge
            .triangles
            .iter()
            .filter(|triangle| is_seen(triangle))
            .count();
        edge.is_line || (self.outward && count == 1)
    }

    /// Whether the viewer in direction `toward` may see the facet.
    pub(super) fn faces(&self, triangle: usize, toward: Vector) -> bool {
        !self.outward || dot(self.normals[triangle], toward) > 0.0
    }
}

/// Whether every edge is passed once in each direction.
fn is_oriented(triangles: &[[usize; 3]], edges: &[SurfaceEdge]) -> bool {
    let forward = |triangle: usize, [p, q]: [usize; 2]| {
        let [a, b, c] = triangles[triangle];
        [[a, b], [b, c], [c, a]].contains(&[p, q])
    };
    edges.iter().all(|edge| match edge.triangles[..] {
        [first, second] => forward(first, edge.nodes) != forward(second, edge.nodes),
        _ => false,
    })
}

/// Signed volume Σ a·(b × c)/6, taken about the first point against cancellation.
fn enclosed_volume(points: &[Vector], triangles: &[[usize; 3]]) -> f64 {
    let Some(&[origin, ..]) = triangles.first() else {
        return 0.0;
    };
    let origin = points[origin];
    let six_fold = triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|node| minus(points[node], origin));
        dot(a, cross(b, c))
    });
    six_fold.sum::<f64>() / 6.0
}

/// A vector of ℝ³.
pub(super) type Vector = [f64; 3];

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(super) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn scaled(a: Vector, factor: f64) -> Vector {
    a.map(|component| factor * component)
}

pub(super) fn norm(a: Vector) -> f64 {
    a[0].hypot(a[1]).hypot(a[2])
}

/// `a` divided by its length; the zero vector stays.
pub(super) fn unit(a: Vector) -> Vector {
    let length = norm(a);
    if length > 0.0 {
        scaled(a, 1.0 / length)
    } else {
        a
    }
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

    const CORNERS: [Vector; 4] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
    ];

    #[test]
    fn inward_oriented_tetrahedron_gets_outward_normals() {
        let inward = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
        let facets = FacetNormals::new(&CORNERS, &inward, &surface_edges(&inward));
        assert!(facets.outward);
        assert_eq!(facets.normals[0], [0.0, 0.0, -1.0]);
        assert!(facets.faces(0, [0.0, 0.0, -1.0]) && !facets.faces(0, [0.0, 0.0, 1.0]));
    }

    /// The edge between two facets at a right angle, at half of one, and between two faces in a plane.
    #[test]
    fn lines_are_creases_and_bounds_of_faces() {
        let triangles = [[0, 1, 2], [1, 0, 3]];
        let is_line = |apex: Vector, faces: &[usize]| {
            let points = [CORNERS[0], CORNERS[1], [0.0, -1.0, 0.0], apex];
            let mut edges = surface_edges(&triangles);
            let rest = FacetNormals::new(&points, &triangles, &edges);
            mark_lines(&mut edges, &rest, faces);
            edges
                .iter()
                .find(|edge| edge.nodes == [0, 1])
                .is_some_and(|edge| edge.is_line)
        };
        assert!(is_line([0.0, 0.0, 1.0], &[]));
        assert!(!is_line([0.0, 1.0, 1.0], &[]) && !is_line([0.0, 1.0, 1.0], &[4, 4]));
        assert!(is_line([0.0, 1.0, 0.0], &[4, 5]));
    }

    #[test]
    fn edges_are_joined_up_to_branches_and_around_rings() {
        let lines = joined_lines(&[[0, 1], [1, 2], [2, 3], [2, 4]]);
        assert_eq!(lines, [vec![0, 1, 2], vec![2, 3], vec![2, 4]]);
        assert_eq!(joined_lines(&[[0, 1], [1, 2], [0, 2]]), [vec![0, 1, 2, 0]]);
    }

    #[test]
    fn an_open_surface_hides_nothing() {
        let open = [[0, 1, 2], [0, 3, 1]];
        let facets = FacetNormals::new(&CORNERS, &open, &surface_edges(&open));
        assert!(!facets.outward && facets.faces(0, [0.0, 0.0, 1.0]));
    }
}
