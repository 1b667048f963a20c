//! The boundary of a body of tetrahedra; whether the body is connected and conforming.

use std::collections::HashMap;

use nalgebra::Vector3;
use rayon::slice::ParallelSliceMut;

use super::{body::GmshBody, contents::Contents, scanner::GmshFlaw};
use crate::mesh::{GEOMETRY_TOLERANCE, sorted};

/// The outer triangles of the body and how its tetrahedra hang together.
#[derive(Debug)]
pub(super) struct GmshBoundary {
    /// Counter-clockwise seen from outside, in the order of their tetrahedra.
    pub(super) facets: Vec<[usize; 3]>,
    /// The tetrahedron behind each.
    pub(super) owner: Vec<usize>,
    /// Index of each by its nodes in increasing order.
    pub(super) facet_of: HashMap<[usize; 3], usize>,
    /// For each tetrahedron the first one of the piece it is in.
    piece: Vec<usize>,
}

impl GmshBoundary {
    /// Matches the triangles of all tetrahedra: two tetrahedra share a triangle from opposite
    /// sides, or it is on the boundary. So a third one at a triangle overlaps one of the two.
    pub(super) fn new(body: &GmshBody, contents: &Contents) -> Result<Self, GmshFlaw> {
        let mut sides: Vec<TetrahedronSide> = (0..body.tetrahedra.len())
            .flat_map(|t| (0..4).map(move |local| (t, local)))
            .map(|(t, local)| TetrahedronSide {
                key: sorted(triangles(&body.tetrahedra[t])[local]),
                tetrahedron: t,
                local,
            })
            .collect();
        sides.par_sort_unstable();
        let mut pieces = Pieces::new(body.tetrahedra.len());
        let mut outer = Vec::new();
        for shared in sides.chunk_by(|a, b| a.key == b.key) {
            match shared {
                [only] => outer.push((only.tetrahedron, only.local)),
                [first, second] if is_even(body, first) != is_even(body, second) => {
                    pieces.join(first.tetrahedron, second.tetrahedron);
                }
                _ => return Err(overlap(body, contents, shared)),
            }
        }
        outer.sort_unstable();
        let facets: Vec<[usize; 3]> = outer
            .iter()
            .map(|&(t, local)| triangles(&body.tetrahedra[t])[local])
            .collect();
        Ok(Self {
            facet_of: facets.iter().map(|f| sorted(*f)).zip(0..).collect(),
            facets,
            owner: outer.into_iter().map(|(t, _)| t).collect(),
            piece: pieces.firsts(),
        })
    }

    /// Refuses a body of several pieces.
    pub(super) fn require_one_piece(&self, contents: &Contents) -> Result<(), GmshFlaw> {
        let mut size = vec![0_usize; self.piece.len()];
        for &first in &self.piece {
            size[first] += 1;
        }
        let firsts: Vec<usize> = (0..size.len()).filter(|&t| size[t] > 0).collect();
        let largest = firsts.iter().rev().max_by_key(|t| size[**t]);
        let smallest = firsts.iter().rev().min_by_key(|t| size[**t]);
        match (largest, smallest) {
            (Some(&largest), Some(&smallest)) if firsts.len() > 1 => Err(GmshFlaw::new(
                None,
                "one body",
                format!(
                    "{} pieces not joined by whole triangles: tetrahedron {} is in the largest, tetrahedron {} in the smallest ({} of {} tetrahedra)",
                    firsts.len(),
                    contents.tetrahedra[largest].tag,
                    contents.tetrahedra[smallest].tag,
                    size[smallest],
                    self.piece.len()
                ),
                "a piece could move alone: join the pieces (BooleanUnion, BooleanFragments), keep one of them, or make each a [[body]] with gmsh.volume",
            )),
            _ => Ok(()),
        }
    }
}

/// One of the four triangles of a tetrahedron.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct TetrahedronSide {
    /// Its nodes in increasing order.
    key: [usize; 3],
    tetrahedron: usize,
    local: usize,
}

/// The four triangles of a positively oriented tetrahedron, counter-clockwise seen from outside.
fn triangles(&[a, b, c, d]: &[usize; 4]) -> [[usize; 3]; 4] {
    [[a, c, b], [a, b, d], [a, d, c], [b, c, d]]
}

/// Whether the outward order of a side is an even permutation of the increasing one.
fn is_even(body: &GmshBody, side: &TetrahedronSide) -> bool {
    let [a, b, c] = triangles(&body.tetrahedra[side.tetrahedron])[side.local];
    !((a > b) ^ (b > c) ^ (a > c))
}

/// The error for sides that share a triangle although two of them are on the same side of it.
fn overlap(body: &GmshBody, contents: &Contents, shared: &[TetrahedronSide]) -> GmshFlaw {
    let corners = |side: &TetrahedronSide| {
        let mut nodes = body.tetrahedra[side.tetrahedron];
        nodes.sort_unstable();
        nodes
    };
    let pairs = || {
        let seconds = shared.iter().enumerate();
        seconds.flat_map(|(i, second)| shared[..i].iter().map(move |first| (first, second)))
    };
    let copy = pairs().find(|(a, b)| corners(a) == corners(b));
    let same_side = pairs().find(|(a, b)| is_even(body, a) == is_even(body, b));
    let (first, second) = copy
        .or(same_side)
        .expect("two of three sides, or the two of a wrong pair, are on the same side");
    let [first, second] = [first, second].map(|s| &contents.tetrahedra[s.tetrahedron]);
    if copy.is_none() {
        let triangle = shared[0].key.map(|n| body.tags[n]);
        return second.flaw(
            "no overlap",
            format!(
                "tetrahedron {} on the same side of triangle {triangle:?}",
                first.tag
            ),
            "volumes overlap; make them parts of each other with BooleanFragments and mesh again",
        );
    }
    let groups = [first, second].map(|e| contents.memberships[e.membership].first());
    match groups {
        // MSH 2.2 writes an element once for each physical group it is in.
        [Some(a), Some(b)] if a != b => contents.in_two_groups(second, [*a, *b]),
        _ => second.flaw(
            "its own nodes",
            format!("those of tetrahedron {}", first.tag),
            "a volume was meshed or saved twice; remove the copy (Coherence Mesh)",
        ),
    }
}

/// Disjoint sets of tetrahedra; each set is named by its first one.
pub(super) struct Pieces(Vec<usize>);

impl Pieces {
    pub(super) fn new(n: usize) -> Self {
        Self((0..n).collect())
    }

    fn first(&mut self, mut t: usize) -> usize {
        while self.0[t] != t {
            self.0[t] = self.0[self.0[t]];
            t = self.0[t];
        }
        t
    }

    pub(super) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.first(a), self.first(b));
        self.0[a.max(b)] = a.min(b);
    }

    pub(super) fn firsts(mut self) -> Vec<usize> {
        (0..self.0.len()).map(|t| self.first(t)).collect()
    }
}

/// Refuses boundaries on which parts touch without being joined: nodes in the same place, or on
/// triangles of which they are no corner.
///
/// Only boundary triangles are looked at, since a face between unjoined parts is boundary of both.
pub(super) fn check(
    body: &GmshBody,
    boundary: &GmshBoundary,
    contents: &Contents,
) -> Result<(), GmshFlaw> {
    let mut nodes: Vec<usize> = boundary.facets.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let nearby = Nearby::new(&body.coordinates, &nodes);
    no_coincident_nodes(body, boundary, &nodes, &nearby)?;
    no_hanging_nodes(body, boundary, contents, &nearby)
}

fn point(body: &GmshBody, node: usize) -> Vector3<f64> {
    body.coordinates[node].into()
}

fn no_coincident_nodes(
    body: &GmshBody,
    boundary: &GmshBoundary,
    nodes: &[usize],
    nearby: &Nearby,
) -> Result<(), GmshFlaw> {
    let mut shortest = vec![f64::INFINITY; body.coordinates.len()];
    for &[a, b, c] in &boundary.facets {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let length = (point(body, p) - point(body, q)).norm();
            shortest[p] = shortest[p].min(length);
            shortest[q] = shortest[q].min(length);
        }
    }
    for &node in nodes {
        let at = body.coordinates[node];
        let reach = GEOMETRY_TOLERANCE * shortest[node];
        let others = nearby.in_box(at.map(|x| x - reach), at.map(|x| x + reach));
        if let Some(&other) = others.iter().find(|&&other| other != node) {
            let flaw = GmshFlaw::new(
                None,
                "different places",
                format!("them in the same place {at:?}"),
                "parts that touch are not joined: if they are one body, use BooleanFragments or Coherence before meshing, or Coherence Mesh after it; else make each a [[body]] with gmsh.volume",
            );
            let [first, second] = [node.min(other), node.max(other)].map(|n| body.tags[n]);
            return Err(flaw.of(format!("nodes {first} and {second}")));
        }
    }
    Ok(())
}

fn no_hanging_nodes(
    body: &GmshBody,
    boundary: &GmshBoundary,
    contents: &Contents,
    nearby: &Nearby,
) -> Result<(), GmshFlaw> {
    for (facet, &owner) in boundary.facets.iter().zip(&boundary.owner) {
        let corners = facet.map(|n| point(body, n));
        let longest = (0..3)
            .map(|i| (corners[i] - corners[(i + 1) % 3]).norm())
            .fold(0.0, f64::max);
        let reach = GEOMETRY_TOLERANCE * longest;
        let low = corners[0]
            .inf(&corners[1])
            .inf(&corners[2])
            .add_scalar(-reach);
        let high = corners[0]
            .sup(&corners[1])
            .sup(&corners[2])
            .add_scalar(reach);
        let inside = nearby.in_box(low.into(), high.into());
        let hanging = inside
            .into_iter()
            .filter(|node| !facet.contains(node))
            .find(|&node| lies_on(&corners, reach, &point(body, node)));
        if let Some(node) = hanging {
            let triangle = facet.map(|n| body.tags[n]);
            let element = contents.tetrahedra[owner].tag;
            let flaw = GmshFlaw::new(
                None,
                "a conforming mesh",
                format!("it on boundary triangle {triangle:?} of tetrahedron {element}"),
                "parts that touch are meshed apart: if they are one body, join them with BooleanFragments or Coherence before meshing; else make each a [[body]] with gmsh.volume",
            );
            return Err(flaw.of(format!("node {}", body.tags[node])));
        }
    }
    Ok(())
}

/// Whether a point is within `reach` of the plane of a triangle and its foot is in the triangle.
fn lies_on(corners: &[Vector3<f64>; 3], reach: f64, at: &Vector3<f64>) -> bool {
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a));
    let twice_area = normal.norm();
    if (at - a).dot(&normal).abs() > reach * twice_area {
        return false;
    }
    [(a, b), (b, c), (c, a)].into_iter().all(|(p, q)| {
        let share = (q - p).cross(&(at - p)).dot(&normal) / (twice_area * twice_area);
        share >= -GEOMETRY_TOLERANCE
    })
}

/// Points in the order of their places along a direction that hardly any face is perpendicular to, for queries with boxes: of n points
/// on a surface a box has some √n others beside it.
struct Nearby<'a> {
    points: &'a [[f64; 3]],
    order: Vec<(f64, usize)>,
}

impl<'a> Nearby<'a> {
    fn new(points: &'a [[f64; 3]], chosen: &[usize]) -> Self {
        let place = |&point: &usize| (along(points[point]), point);
        let mut order: Vec<(f64, usize)> = chosen.iter().map(place).collect();
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        Self { points, order }
    }

    /// The chosen points in a closed box, in increasing order.
    fn in_box(&self, low: [f64; 3], high: [f64; 3]) -> Vec<usize> {
        let first = self.order.partition_point(|(place, _)| *place < along(low));
        let places = self.order[first..].iter();
        let between = places.take_while(|(place, _)| *place <= along(high));
        let is_inside = |at: [f64; 3]| (0..3).all(|a| low[a] <= at[a] && at[a] <= high[a]);
        let inside = between.filter(|(_, point)| is_inside(self.points[*point]));
        let mut found: Vec<usize> = inside.map(|(_, point)| *point).collect();
        found.sort_unstable();
        found
    }
}

/// The place of a point along the direction; sums of products with positive numbers keep the order of coordinates in spite of rounding.
fn along([x, y, z]: [f64; 3]) -> f64 {
    x + 0.618_034 * y + 0.414_214 * z
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::Nearby;

    /// Few different coordinates, so that many are equal and some extents are zero.
    fn any_point() -> impl Strategy<Value = [f64; 3]> {
        prop::array::uniform3((0..5_i32).prop_map(f64::from))
    }

    proptest! {
        #[test]
        fn boxes_hold_what_brute_force_finds(
            points in prop::collection::vec(any_point(), 0..60),
            (low, size) in (any_point(), any_point()),
        ) {
            let high: [f64; 3] = std::array::from_fn(|a| low[a] + size[a] - 1.0);
            let chosen: Vec<usize> = (0..points.len()).filter(|i| i % 3 != 0).collect();
            let is_inside = |i: &usize| (0..3).all(|a| (low[a]..=high[a]).contains(&points[*i][a]));
            let expected: Vec<usize> = chosen.iter().copied().filter(is_inside).collect();
            prop_assert_eq!(Nearby::new(&points, &chosen).in_box(low, high), expected);
        }
    }
}
