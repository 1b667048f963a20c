//! Surfaces of triangles that are none: cut by themselves, or cracked.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;
use rstar::{RTree, primitives::GeomWithData};

use super::triangulated::TriangulatedSurface;
use crate::scene::place_words;

/// The share of an edge below which corners at a border are those of one crack.
const CRACK: f64 = 1e-2;

/// The share of the longest edge of the smaller of two triangles by which they must reach through each other to cut.
const CUT: f64 = 1e-3;

impl TriangulatedSurface {
    /// Refuses corners at the border, by the triangle at each edge, that lie beside each other.
    ///
    /// # Errors
    /// How many there are and how far apart, and what to do.
    pub(super) fn refuse_cracks(
        &self,
        at_edge: &BTreeMap<[usize; 2], usize>,
    ) -> Result<(), (String, &'static str)> {
        let ends = at_edge.keys();
        let ends = ends.filter(|[from, to]| !at_edge.contains_key(&[*to, *from]));
        let border: BTreeSet<usize> = ends.flatten().copied().collect();
        let place = |point: usize| GeomWithData::new(self.points[point], point);
        let tree = RTree::bulk_load(border.iter().map(|point| place(*point)).collect());
        let (mut n, mut widest, mut first) = (0, 0.0_f64, None);
        for &point in &border {
            let corners = self.around[point].iter().flat_map(|t| self.triangles[*t]);
            let squares = corners.filter(|other| *other != point).map(|other| {
                (Vector3::from(self.points[other]) - Vector3::from(self.points[point]))
                    .norm_squared()
            });
            let within = CRACK * CRACK * squares.fold(f64::INFINITY, f64::min);
            let near = tree.nearest_neighbor_iter_with_distance_2(self.points[point]);
            let mut near = near.filter(|(other, _)| other.data != point);
            if let Some((_, square)) = near.next().filter(|(_, square)| *square <= within) {
                n += 1;
                widest = widest.max(square.sqrt());
                first.get_or_insert(point);
            }
        }
        let Some(first) = first else { return Ok(()) };
        Err((
            format!(
                "cracks: {n} corners at the border lie up to {widest:.1e} beside others, the first at {}",
                place_words(self.points[first])
            ),
            "let a CAD or mesh program weld corners that lie so near to each other",
        ))
    }

    /// Refuses triangles that cut others by more than some digits in m: those that meet in a segment, on both sides of which both go on
    /// (T. Möller, *J. Graphics Tools* 2 (1997) 25).
    ///
    /// # Errors
    /// Where, and what to do.
    pub(super) fn refuse_cuts(&self, digits: f64) -> Result<(), (String, &'static str)> {
        let pairs = self
            .tree
            .intersection_candidates_with_other_tree(&self.tree);
        let pairs = pairs.map(|(one, other)| [one.data, other.data]);
        let mut pairs = pairs.filter(|[one, other]| one < other);
        match pairs.find_map(|[one, other]| self.cut(one, other, digits)) {
            None => Ok(()),
            Some(at) => Err((
                format!(
                    "triangles that cut each other around {}",
                    place_words(at.into())
                ),
                "let a CAD or mesh program unite the parts (Boolean union), and leave inner walls out",
            )),
        }
    }

    /// A place where two triangles cut each other; `None` where they touch, or share an edge.
    fn cut(&self, one: usize, other: usize, digits: f64) -> Option<Vector3<f64>> {
        let shared = self.triangles[one].iter();
        let shared = shared.filter(|point| self.triangles[other].contains(point));
        if shared.count() > 1 {
            return None;
        }
        let triangles = [one, other].map(|triangle| self.corners(triangle));
        let longest =
            triangles.map(|[a, b, c]| (b - a).norm().max((c - b).norm()).max((a - c).norm()));
        let least = digits.max(CUT * longest[0].min(longest[1]));
        let normals = [one, other].map(|triangle| self.normal(triangle));
        let along = normals[0].cross(&normals[1]).try_normalize(0.0)?;
        let through_other = |k: usize| {
            let plane = (&triangles[1 - k][0], &normals[1 - k]);
            in_plane(&triangles[k], plane, &along, least)
        };
        let (first, second) = (through_other(0)?, through_other(1)?);
        let place = |x: &Vector3<f64>| x.dot(&along);
        let from = if place(&first[0]) > place(&second[0]) {
            first[0]
        } else {
            second[0]
        };
        let to = place(&first[1]).min(place(&second[1]));
        (to - place(&from) > least).then_some(from)
    }
}

/// The ends of the segment in which a triangle meets a plane through a point with a unit normal, in their order along a direction; `None`
/// where it does not reach beyond the plane by more than `least` in m on both sides.
fn in_plane(
    triangle: &[Vector3<f64>; 3],
    (point, normal): (&Vector3<f64>, &Vector3<f64>),
    along: &Vector3<f64>,
    least: f64,
) -> Option<[Vector3<f64>; 2]> {
    let height = triangle.map(|x| (x - point).dot(normal));
    let is_beyond = |sign: f64| height.iter().any(|h| sign * h > least);
    if !is_beyond(1.0) || !is_beyond(-1.0) {
        return None;
    }
    let crossed = (0..3).map(|k| [k, (k + 1) % 3]);
    let crossed = crossed.filter(|[from, to]| (height[*from] > 0.0) != (height[*to] > 0.0));
    let mut ends = crossed.map(|[from, to]| {
        let share = height[from] / (height[from] - height[to]);
        triangle[from] + (triangle[to] - triangle[from]) * share
    });
    let (first, second) = (ends.next()?, ends.next()?);
    let in_order = first.dot(along) <= second.dot(along);
    Some(if in_order {
        [first, second]
    } else {
        [second, first]
    })
}
