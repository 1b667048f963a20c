//! The boundary of a body of tetrahedra, and whether the body is connected.

use std::collections::HashMap;

use rayon::slice::ParallelSliceMut;

use super::{GmshError, body::Body, contents::Contents};
use crate::mesh::sorted;

/// The outer triangles of the body and how its tetrahedra hang together.
#[derive(Debug)]
pub(super) struct Boundary {
    /// Counter-clockwise seen from outside, in the order of their tetrahedra.
    pub(super) facets: Vec<[usize; 3]>,
    /// The tetrahedron behind each.
    pub(super) owner: Vec<usize>,
    /// Index of each by its nodes in increasing order.
    pub(super) facet_of: HashMap<[usize; 3], usize>,
    /// For each tetrahedron the first one of the piece it is in.
    piece: Vec<usize>,
}

impl Boundary {
    /// Matches the triangles of all tetrahedra: two tetrahedra share a triangle from opposite
    /// sides, or it is on the boundary. So a third one at a triangle overlaps one of the two.
    pub(super) fn new(body: &Body, contents: &Contents) -> Result<Self, GmshError> {
        let mut sides: Vec<Side> = (0..body.tetrahedra.len())
            .flat_map(|t| (0..4).map(move |local| (t, local)))
            .map(|(t, local)| Side {
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
    pub(super) fn require_one_piece(&self, contents: &Contents) -> Result<(), GmshError> {
        let mut size = vec![0_usize; self.piece.len()];
        for &first in &self.piece {
            size[first] += 1;
        }
        let firsts: Vec<usize> = (0..size.len()).filter(|&t| size[t] > 0).collect();
        let largest = firsts.iter().rev().max_by_key(|t| size[**t]);
        let smallest = firsts.iter().rev().min_by_key(|t| size[**t]);
        match (largest, smallest) {
            (Some(&largest), Some(&smallest)) if firsts.len() > 1 => Err(GmshError::Pieces {
                pieces: firsts.len(),
                first: contents.tetrahedra[largest].tag,
                other: contents.tetrahedra[smallest].tag,
                smallest: size[smallest],
                total: self.piece.len(),
            }),
            _ => Ok(()),
        }
    }
}

/// One of the four triangles of a tetrahedron.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
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
fn is_even(body: &Body, side: &Side) -> bool {
    let [a, b, c] = triangles(&body.tetrahedra[side.tetrahedron])[side.local];
    !((a > b) ^ (b > c) ^ (a > c))
}

/// The error for sides that share a triangle although two of them are on the same side of it.
fn overlap(body: &Body, contents: &Contents, shared: &[Side]) -> GmshError {
    let corners = |side: &Side| {
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
        return GmshError::Overlap {
            place: second.place,
            first: first.tag,
            second: second.tag,
            triangle: shared[0].key.map(|n| body.tags[n]),
        };
    }
    let groups = [first, second].map(|e| contents.memberships[e.membership].first());
    match groups {
        // MSH 2.2 writes an element once for each physical group it is in.
        [Some(a), Some(b)] if a != b => GmshError::TwoVolumes {
            place: second.place,
            element: second.tag,
            first: contents.group_name(3, *a),
            second: contents.group_name(3, *b),
        },
        _ => GmshError::DuplicateTetrahedron {
            place: second.place,
            first: first.tag,
            second: second.tag,
        },
    }
}

/// Disjoint sets of tetrahedra; each set is named by its first one.
struct Pieces(Vec<usize>);

impl Pieces {
    fn new(n: usize) -> Self {
        Self((0..n).collect())
    }

    fn first(&mut self, mut t: usize) -> usize {
        while self.0[t] != t {
            self.0[t] = self.0[self.0[t]];
            t = self.0[t];
        }
        t
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.first(a), self.first(b));
        self.0[a.max(b)] = a.min(b);
    }

    fn firsts(mut self) -> Vec<usize> {
        (0..self.0.len()).map(|t| self.first(t)).collect()
    }
}
