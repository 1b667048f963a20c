//! Panel (c): the deformed body on its support, beside the obstacle; and, by itself, a field on the body at rest.

use units::{Dimension, Unit};

use super::marks::{ARROW, Sight, Symbol, draw_symbols};
use crate::{
    canvas::{Anchor, Canvas, Colour, Fill, Point, Stroke},
    colour::{ColourKey, ColourMap},
    layout::{
        KEY_HEIGHT, LABEL_SIZE, PANEL_WIDTH, PictureLayout, TICK_SIZE, TITLE_SIZE, axis_name,
    },
    outline::{FacetNormals, SurfaceEdge, edge_loops, joined_lines, mark_lines, surface_edges},
    panes::single_edges,
    picture::{BodyField, ContactPicture, DrawnObstacle},
    scale::{bounds, factor_label, round_down},
    surface::{Facets, Paint, brightness, draw_facets, shaded},
    text::Label,
    view::{Fit, TOWARD, Vector, View, cross, dot, minus, norm, scaled, unit},
};

/// Largest drawn relative shortening of an edge of the surface.
const MOST_SHRINKAGE: f64 = 0.6;
/// Pixels of an arrow of the axes triad.
const TRIAD_LENGTH: f64 = 30.0;

/// What colours the boundary.
struct Shown {
    title: Label,
    /// A value for each node.
    magnitude: Vec<f64>,
    symbol: Label,
    unit: Unit,
    /// The words below the title of a body at rest; `None` for one that is drawn deformed.
    at_rest: Option<&'static str>,
    /// From the body to the viewer, in the basis (t₁, −ν × t₁, −ν).
    toward: Vector,
}

/// Panel (c).
pub(super) fn body_panel(picture: &ContactPicture<'_>, layout: &PictureLayout) -> Canvas {
    let shown = Shown {
        title: Label::plain("(c) Deformed body"),
        magnitude: picture.displacement.iter().map(|&u| norm(u)).collect(),
        symbol: Label::plain("|").italic("u").upright("|"),
        unit: picture.units.of(Dimension::LENGTH),
        at_rest: None,
        toward: TOWARD,
    };
    drawn_body(picture, layout, &shown)
}

/// A field on the boundary of the body at rest, seen from two opposite sides, so that every face is shown, with words for both.
pub(crate) fn body_panels(
    picture: &ContactPicture<'_>,
    field: &BodyField<'_>,
    sides: [&'static str; 2],
) -> Canvas {
    let alone = ContactPicture {
        obstacle: None,
        marks: &[],
        ..*picture
    };
    let layout = PictureLayout::new(picture);
    let below = TOWARD.map(|component| -component);
    let mut page = Canvas::new(2.0 * PANEL_WIDTH, layout.height);
    for (column, (side, toward)) in sides.into_iter().zip([TOWARD, below]).enumerate() {
        let shown = Shown {
            title: Label::default(),
            magnitude: field.values.to_vec(),
            symbol: Label::plain(field.symbol),
            unit: picture.units.of(field.dimension),
            at_rest: Some(side),
            toward,
        };
        let panel = drawn_body(&alone, &layout, &shown);
        page.place(&panel, [column as f64 * PANEL_WIDTH, 0.0]);
    }
    page.bold_text(
        [16.0, 26.0],
        &Label::plain(field.title),
        TITLE_SIZE,
        Anchor::Start,
    );
    page
}

/// The boundary coloured by a value, the undeformed outline, the support and the axes.
fn drawn_body(picture: &ContactPicture<'_>, layout: &PictureLayout, shown: &Shown) -> Canvas {
    let mut canvas = layout.panel(&shown.title);
    let view = View::new(picture, shown.toward);
    let magnitude = &shown.magnitude;
    let undeformed: Vec<Vector> = picture
        .coordinates
        .iter()
        .map(|&x| view.stretched(x))
        .collect();
    let triangles = picture.boundary_triangles;
    let mut edges = surface_edges(triangles);
    let rest = FacetNormals::new(&undeformed, triangles, &edges);
    mark_lines(&mut edges, &rest, picture.boundary_face);
    let diagonal = norm(extents(picture, &undeformed));
    let obstacle = picture.obstacle;
    let obstacle = obstacle.map(|shape| ObstacleShape::new(shape, &view, diagonal));
    let factor = match shown.at_rest {
        Some(_) => 0.0,
        None if picture.is_to_scale => 1.0,
        None => displacement_factor(picture, &view, &undeformed, &edges),
    };
    let deformed: Vec<Vector> = undeformed
        .iter()
        .zip(picture.displacement)
        .map(|(&x, &u)| {
            let u = scaled(view.stretched(u), factor);
            let u = if norm(u).is_finite() { u } else { [0.0; 3] };
            [x[0] + u[0], x[1] + u[1], x[2] + u[2]]
        })
        .collect();
    let used = picture.boundary_triangles.as_flattened().iter();
    let values = used.clone().map(|&node| magnitude[node]);
    let key = ColourKey::new(values, ColourMap::Plasma, &shown.symbol, &shown.unit);

    let drawn = used.flat_map(|&node| [undeformed[node], deformed[node]]);
    let drawn = drawn
        .chain(obstacle.iter().flat_map(ObstacleShape::points))
        .map(|point| view.projected(point));
    let (corner, size) = view_rectangle(layout, !picture.marks.is_empty());
    let fit = Fit::new(drawn, corner, size);
    let symbols = symbols(picture, &view, &fit, (&deformed, &edges));
    let pixel = |point: Vector| fit.pixel(view.projected(point));
    if let Some(obstacle) = &obstacle {
        obstacle.draw(&mut canvas, &view, &fit);
    }

    let moved = |node: usize| {
        let [from, to] = [pixel(undeformed[node]), pixel(deformed[node])];
        // Lines of the body at rest are drawn where it moved by more pixels than this.
        (to[0] - from[0]).hypot(to[1] - from[1]) > 1.5
    };
    let outline = |hidden: bool| {
        let mut lines = outline_of(&rest, &edges, &view, hidden);
        lines.retain(|nodes| nodes.iter().any(|&node| moved(node)));
        joined_lines(&lines)
    };
    let to_pixels = |lines: Vec<Vec<usize>>| -> Vec<Vec<Point>> {
        let line = |nodes: Vec<usize>| nodes.into_iter().map(|n| pixel(undeformed[n])).collect();
        lines.into_iter().map(line).collect()
    };
    let dashed = Stroke::dashed(Colour(0x9a, 0x9a, 0x9a), 0.8, 4.0);
    canvas.polylines(&to_pixels(outline(true)), dashed);
    let facets = Facets {
        points: &deformed,
        paint: Paint::Values(magnitude, &key),
        triangles,
        bodies: picture.bodies,
        edges: &edges,
    };
    draw_facets(&mut canvas, &facets, &view, &fit);
    let dashed = Stroke::dashed(Colour(0x30, 0x30, 0x30), 0.8, 4.0);
    canvas.polylines(&to_pixels(outline(false)), dashed);

    draw_symbols(&mut canvas, &symbols, [16.0, 64.0]);
    let bottom = layout.height - KEY_HEIGHT - 14.0;
    draw_triad(&mut canvas, &view, [52.0, bottom - 24.0]);
    let note = match shown.at_rest {
        Some(words) => Label::plain(words),
        None if magnitude.iter().any(|&u| u > 0.0) => deformation_note(factor),
        None => Label::plain("no displacement"),
    };
    let grey = picture.obstacle.map_or("", |_| ", grey: obstacle");
    let note = note.upright(grey);
    canvas.text([16.0, 46.0], &note, TICK_SIZE, Anchor::Start);
    let height = if shown.at_rest.is_none() { 26.0 } else { 46.0 };
    note_stretch(&mut canvas, &view, height);
    key.draw(&mut canvas, [layout.key[0], layout.height - KEY_HEIGHT]);
    canvas
}

/// The sizes of the body along the basis of the view.
fn extents(picture: &ContactPicture<'_>, undeformed: &[Vector]) -> Vector {
    let nodes = || picture.boundary_triangles.as_flattened().iter();
    [0, 1, 2].map(|axis| {
        let (low, high) = bounds(nodes().map(|&node| undeformed[node][axis]));
        high - low
    })
}

/// A round factor ≥ 1 that makes the displacement visible, but neither larger than a part of the
/// body nor so large that an edge of the surface shrinks by more than [`MOST_SHRINKAGE`].
fn displacement_factor(
    picture: &ContactPicture<'_>,
    view: &View,
    undeformed: &[Vector],
    edges: &[SurfaceEdge],
) -> f64 {
    let nodes = || picture.boundary_triangles.as_flattened().iter();
    let extents = extents(picture, undeformed);
    let moved = |node: usize| view.stretched(picture.displacement[node]);
    let lengths = nodes().map(|&node| norm(moved(node)));
    let largest = lengths.filter(|l| l.is_finite()).fold(0.0, f64::max);
    let shrinkages = edges.iter().map(|edge| {
        let [p, q] = edge.nodes;
        let along = minus(undeformed[q], undeformed[p]);
        -dot(minus(moved(q), moved(p)), along) / dot(along, along)
    });
    let shrinkage = shrinkages.filter(|s| s.is_finite()).fold(0.0, f64::max);
    // Largest drawn displacement relative to the diagonal of the body.
    let factor = (0.15 * norm(extents) / largest).min(MOST_SHRINKAGE / shrinkage);
    if !factor.is_finite() || factor <= 1.0 {
        return 1.0;
    }
    round_down(factor)
}

/// The symbols of what holds and loads a body.
fn symbols(
    picture: &ContactPicture<'_>,
    view: &View,
    fit: &Fit,
    (deformed, edges): (&[Vector], &[SurfaceEdge]),
) -> Vec<Symbol> {
    let triangles = picture.boundary_triangles;
    let normals = FacetNormals::new(deformed, triangles, edges);
    let mut is_seen = vec![false; deformed.len()];
    for (triangle, nodes) in triangles.iter().enumerate() {
        if normals.faces(triangle, view.toward()) {
            nodes.iter().for_each(|&node| is_seen[node] = true);
        }
    }
    let points = deformed.iter();
    let pixels: Vec<Point> = points.map(|&x| fit.pixel(view.projected(x))).collect();
    let sight = Sight {
        view,
        is_seen: &is_seen,
        pixels: &pixels,
    };
    sight.symbols(picture.marks)
}

/// Outline of the undeformed body as edges: what is behind the body, or what is in front.
fn outline_of(
    facets: &FacetNormals,
    edges: &[SurfaceEdge],
    view: &View,
    hidden: bool,
) -> Vec<[usize; 2]> {
    let toward = view.toward();
    edges
        .iter()
        .filter(|edge| facets.is_outline(edge, toward))
        .filter(|edge| edge.triangles.iter().any(|&t| facets.faces(t, toward)) != hidden)
        .map(|edge| edge.nodes)
        .collect()
}

/// The part of the panel for the body, without the strip of the triad, the key, and room for symbols and their legend if it has some.
fn view_rectangle(layout: &PictureLayout, has_symbols: bool) -> (Point, Point) {
    let (left, top) = if has_symbols {
        (96.0, 80.0 + ARROW)
    } else {
        (76.0, 62.0)
    };
    let bottom = layout.height - KEY_HEIGHT - 14.0;
    ([left, top], [PANEL_WIDTH + 52.0 - 2.0 * left, bottom - top])
}

/// What is drawn larger, and what dashed lines are.
fn deformation_note(factor: f64) -> Label {
    Label::plain("displacement × ")
        .then(&factor_label(factor))
        .upright(", dashed: undeformed")
}

/// Which axes of a slender body are stretched, in a line at a height.
fn note_stretch(canvas: &mut Canvas, view: &View, height: f64) {
    let stretched = (0..3).filter(|&axis| view.stretch[axis] > 1.0);
    let factors = stretched.map(|axis| {
        let name = axis_name(view.basis[axis], &(axis + 1).to_string());
        name.upright(" × ").then(&factor_label(view.stretch[axis]))
    });
    let joined = factors.reduce(|all, next| all.upright(", ").then(&next));
    if let Some(factors) = joined {
        let note = Label::plain("stretched: ").then(&factors);
        let position = [PANEL_WIDTH - 16.0, height];
        canvas.text(position, &note, TICK_SIZE, Anchor::End);
    }
}

/// Arrows along x, y and z from a common origin.
pub(crate) fn draw_triad(canvas: &mut Canvas, view: &View, origin: Point) {
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let mut direction = [0.0; 3];
        direction[axis] = 1.0;
        let [right, up, _] = view.projected(view.turned(direction));
        let tip = [
            origin[0] + TRIAD_LENGTH * right,
            origin[1] - TRIAD_LENGTH * up,
        ];
        canvas.line(origin, tip, Stroke::solid(Colour::BLACK, 1.2));
        let length = right.hypot(up);
        if length < 0.05 {
            continue;
        }
        let [along, across] = [right / length, -up / length];
        let barb = |side: f64| {
            [
                tip[0] - 6.0 * along - side * 2.5 * across,
                tip[1] - 6.0 * across + side * 2.5 * along,
            ]
        };
        let head = [vec![tip, barb(1.0), barb(-1.0)]];
        canvas.region(&head, Fill::Plain(Colour::BLACK), None);
        let label_centre = [tip[0] + 9.0 * along, tip[1] + 9.0 * across + 4.0];
        let label = Label::default().italic(name);
        canvas.text(label_centre, &label, LABEL_SIZE, Anchor::Middle);
    }
}

const GREY: Colour = Colour(0xe6, 0xe6, 0xe6);
const EDGE: Colour = Colour(0xb4, 0xb4, 0xb4);

/// The obstacle in the stretched basis of the view, where it is.
pub(super) struct ObstacleShape {
    /// Polygons, one or more loops each, from back to front.
    pub(super) polygons: Vec<(Vec<Vec<Vector>>, Colour)>,
}

impl ObstacleShape {
    /// Of an obstacle beside a body with that diagonal.
    pub(super) fn new(obstacle: &DrawnObstacle, view: &View, diagonal: f64) -> Self {
        let gaps = obstacle.gaps.iter().map(|&gap| view.stretched(gap));
        let gaps: Vec<Vector> = gaps.collect();
        let nearest = gaps.iter().map(|&gap| norm(gap)).fold(f64::MAX, f64::min);
        // What is farther from the face than the nearest point, by more than this share of the diagonal of the body, is cut off.
        let limit = nearest + 0.2 * diagonal;
        let points = obstacle.points.iter().zip(&gaps);
        let corners: Vec<(Vector, f64)> = points
            .map(|(&point, gap)| {
                let x = view.stretched(point);
                ([0, 1, 2].map(|c| x[c] + gap[c]), norm(*gap))
            })
            .collect();
        let flat = is_plane(&corners, &obstacle.triangles);
        if flat && corners.iter().all(|(_, gap)| *gap <= limit) {
            let loops = edge_loops(&single_edges(&obstacle.triangles)).into_iter();
            let at = |nodes: Vec<usize>| nodes.into_iter().map(|n| corners[n].0).collect();
            return Self {
                polygons: vec![(loops.map(at).collect(), GREY)],
            };
        }
        let cut = obstacle.triangles.iter();
        let cut = cut.map(|nodes| cut_off(nodes.map(|node| corners[node]), limit));
        let mut polygons: Vec<Vec<Vector>> = cut.filter(|polygon| polygon.len() > 2).collect();
        let toward = view.toward();
        let depth = |polygon: &Vec<Vector>| {
            let sum: f64 = polygon.iter().map(|&x| dot(x, toward)).sum();
            sum / polygon.len() as f64
        };
        polygons.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
        let painted = |polygon: Vec<Vector>| {
            let colour = shaded(GREY, brightness(normal(&polygon), toward));
            (vec![polygon], colour)
        };
        Self {
            polygons: polygons.into_iter().map(painted).collect(),
        }
    }

    /// All corners.
    pub(super) fn points(&self) -> impl Iterator<Item = Vector> + Clone + '_ {
        let polygons = self.polygons.iter();
        polygons.flat_map(|(loops, _)| loops.iter().flatten().copied())
    }

    /// Draws it: a plane with an edge, what is curved with its shading.
    pub(super) fn draw(&self, canvas: &mut Canvas, view: &View, fit: &Fit) {
        let pixel = |&x: &Vector| fit.pixel(view.projected(x));
        for (loops, colour) in &self.polygons {
            let loops: Vec<Vec<_>> = loops
                .iter()
                .map(|line| line.iter().map(pixel).collect())
                .collect();
            let edge = if self.polygons.len() == 1 {
                EDGE
            } else {
                *colour
            };
            let stroke = Stroke::solid(edge, 0.6);
            canvas.region(&loops, Fill::Plain(*colour), Some(stroke));
        }
    }
}

fn normal(polygon: &[Vector]) -> Vector {
    let [a, b, c] = [polygon[0], polygon[1], polygon[2]];
    unit(cross(minus(b, a), minus(c, a)))
}

/// Whether all triangles look the same way.
fn is_plane(corners: &[(Vector, f64)], triangles: &[[usize; 3]]) -> bool {
    let mut normals = triangles
        .iter()
        .map(|nodes| normal(&nodes.map(|node| corners[node].0)));
    let first = normals.next();
    // Cosine of a millionth of a radian, and roundings.
    first.is_some_and(|first| normals.all(|next| dot(first, next) > 1.0 - 1e-12))
}

/// The part of a triangle whose gap is below a limit.
fn cut_off(triangle: [(Vector, f64); 3], limit: f64) -> Vec<Vector> {
    let mut kept = Vec::new();
    for (k, (b, gap_b)) in triangle.into_iter().enumerate() {
        let (a, gap_a) = triangle[(k + 2) % 3];
        if (gap_a <= limit) != (gap_b <= limit) {
            let share = (limit - gap_a) / (gap_b - gap_a);
            kept.push([0, 1, 2].map(|c| a[c] + share * (b[c] - a[c])));
        }
        if gap_b <= limit {
            kept.push(b);
        }
    }
    kept
}
