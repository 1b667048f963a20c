//! The obstacle beside the deformed body.

use crate::canvas::{Canvas, Colour, Fill, Stroke};
use crate::panes::{edge_loops, single_edges};
use crate::picture::DrawnObstacle;
use crate::view::{Fit, Vector, View, brightness, cross, dot, minus, norm, shaded, unit};

const GREY: Colour = Colour(0xe6, 0xe6, 0xe6);
const EDGE: Colour = Colour(0xb4, 0xb4, 0xb4);

/// The obstacle in the stretched basis of the view, its gaps drawn larger as displacements are.
pub(super) struct ObstacleShape {
    /// Polygons, one or more loops each, from back to front.
    pub(super) polygons: Vec<(Vec<Vec<Vector>>, Colour)>,
}

impl ObstacleShape {
    /// Of an obstacle whose gaps are drawn `factor` times as wide, beside a body with that diagonal.
    pub(super) fn new(obstacle: &DrawnObstacle, view: &View, factor: f64, diagonal: f64) -> Self {
        let gaps = obstacle.gaps.iter().map(|&gap| view.stretched(gap));
        let gaps: Vec<Vector> = gaps.map(|gap| gap.map(|c| factor * c)).collect();
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
