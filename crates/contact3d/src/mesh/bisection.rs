//! Local refinement of a tetrahedral mesh by bisection, conforming and shape-regular.
//!
//! Every tetrahedron has an edge at which it is cut next, and every triangle a marked edge: that of
//! the two triangles at the refinement edge is the refinement edge. Children inherit marks by the
//! rules of D. Arnold, A. Mukherjee, L. Pouly, Locally adapted tetrahedral meshes using bisection,
//! SIAM J. Sci. Comput. 22 (2000) 431: whatever the marks of the first mesh, provided neighbours agree
//! about the triangle they share, tetrahedra of all generations belong to finitely many classes of
//! shapes, and cutting those with hanging nodes comes to an end.

use std::collections::HashMap;

use super::{COORDINATE_ROUNDING, RawMesh, quadratic::edge, sorted};
use crate::reference::TETRAHEDRON_EDGES;

/// A tetrahedron with the edges at which it and its children will be cut.
#[derive(Debug, Clone, PartialEq)]
struct MarkedTetrahedron {
    nodes: [usize; 4],
    /// The marked edge of the triangle opposite to each node: two nodes, the smaller one first.
    marks: [[usize; 2]; 4],
    refinement: [usize; 2],
    /// Tells two planar types apart, of which one is the parent of the other.
    is_flagged: bool,
    /// Face of the body that the triangle opposite to each node lies on, if any.
    faces: [Option<usize>; 4],
    /// The tetrahedron of the mesh before all refinement that this one lies in, and the barycentric
    /// coordinates of its nodes there.
    ancestor: usize,
    places: [[f64; 4]; 4],
    /// The tetrahedron of the mesh before the last refinement that this one lies in.
    parent: usize,
    /// How often it has to be cut still.
    cuts: u8,
}

/// A mesh under refinement.
#[derive(Debug, Clone)]
pub(super) struct Bisection {
    coordinates: Vec<[f64; 3]>,
    tetrahedra: Vec<MarkedTetrahedron>,
    /// The node in the middle of every edge that was cut.
    middles: HashMap<[usize; 2], usize>,
}

/// One tetrahedron of a refined mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Descendant {
    /// The tetrahedron of the first mesh that it lies in.
    pub(super) ancestor: usize,
    /// Barycentric coordinates of its corners there.
    pub(super) places: [[f64; 4]; 4],
    /// The tetrahedron of the mesh before the last refinement that it lies in.
    pub(super) parent: usize,
}

impl Descendant {
    /// Where its corners and the middles of its edges lie in its ancestor.
    pub(super) fn nodes(&self) -> [[f64; 4]; 10] {
        std::array::from_fn(|k| match k.checked_sub(4) {
            None => self.places[k],
            Some(side) => {
                let [a, b] = TETRAHEDRON_EDGES[side].map(|corner| self.places[corner]);
                std::array::from_fn(|j| 0.5 * (a[j] + b[j]))
            }
        })
    }
}

fn edges(nodes: &[usize]) -> Vec<[usize; 2]> {
    let later = |i: usize| nodes[i + 1..].iter().map(move |b| edge(nodes[i], *b));
    (0..nodes.len()).flat_map(later).collect()
}

fn without(nodes: &[usize; 4], k: usize) -> [usize; 3] {
    std::array::from_fn(|i| nodes[if i < k { i } else { i + 1 }])
}

impl Bisection {
    /// The tetrahedra of a mesh, each to be cut at its longest edge first.
    pub(super) fn new(mesh: &RawMesh) -> Self {
        let face_of: HashMap<[usize; 3], usize> = mesh
            .facets
            .iter()
            .zip(&mesh.facet_face)
            .map(|(nodes, face)| (sorted(*nodes), *face))
            .collect();
        let longest = |nodes: &[usize]| {
            let candidates = edges(nodes).into_iter();
            let length = |[a, b]: [usize; 2]| {
                let difference = |c: usize| mesh.coordinates[a][c] - mesh.coordinates[b][c];
                (0..3).map(|c| difference(c).powi(2)).sum::<f64>()
            };
            candidates
                .reduce(|best, next| {
                    // Roundings do not decide which edge is marked; ties go by node numbers.
                    let (known, found) = (length(best), length(next));
                    let is_longer = found > known * (1.0 + COORDINATE_ROUNDING);
                    let is_equal = found >= known * (1.0 - COORDINATE_ROUNDING) && !is_longer;
                    if is_longer || is_equal && next < best {
                        next
                    } else {
                        best
                    }
                })
                .expect("a simplex has edges")
        };
        let tetrahedra = mesh.tetrahedra.iter().enumerate();
        let tetrahedra = tetrahedra.map(|(ancestor, nodes)| MarkedTetrahedron {
            nodes: *nodes,
            marks: std::array::from_fn(|k| longest(&without(nodes, k))),
            refinement: longest(nodes),
            is_flagged: false,
            faces: std::array::from_fn(|k| face_of.get(&sorted(without(nodes, k))).copied()),
            ancestor,
            places: std::array::from_fn(|k| std::array::from_fn(|j| f64::from(u8::from(j == k)))),
            parent: ancestor,
            cuts: 0,
        });
        Self {
            tetrahedra: tetrahedra.collect(),
            coordinates: mesh.coordinates.clone(),
            middles: HashMap::new(),
        }
    }

    /// Cuts every tetrahedron at least as often as asked, `[n_tetrahedra]`, and those with hanging
    /// nodes, until there are none. Children take the place of their parent in the order, so the
    /// result depends on the cuts alone.
    pub(super) fn refine(&mut self, cuts: &[u8]) {
        for (number, (tetrahedron, &cuts)) in self.tetrahedra.iter_mut().zip(cuts).enumerate() {
            tetrahedron.parent = number;
            tetrahedron.cuts = cuts;
        }
        let mut must_cut: Vec<bool> = cuts.iter().map(|cuts| *cuts > 0).collect();
        while must_cut.contains(&true) {
            let parents = std::mem::take(&mut self.tetrahedra);
            for (parent, must_cut) in parents.into_iter().zip(must_cut) {
                if must_cut {
                    let middle = self.middle(parent.refinement);
                    self.tetrahedra.extend(parent.bisected(middle));
                } else {
                    self.tetrahedra.push(parent);
                }
            }
            let must = |t: &MarkedTetrahedron| {
                let mut edges = edges(&t.nodes).into_iter();
                t.cuts > 0 || edges.any(|edge| self.middles.contains_key(&edge))
            };
            must_cut = self.tetrahedra.iter().map(must).collect();
        }
    }

    /// The mesh as it is now, on straight edges, with the boundary of the first one.
    pub(super) fn mesh(&self, first: &RawMesh) -> RawMesh {
        let sides = self.tetrahedra.iter().flat_map(|t| {
            let outward = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
            let sides = outward.into_iter().zip(t.faces);
            sides.filter_map(|(side, face)| Some((side.map(|k| t.nodes[k]), face?)))
        });
        let (facets, facet_face) = sides.unzip();
        let group = |t: &MarkedTetrahedron| first.tetrahedron_group.get(t.ancestor).copied();
        RawMesh {
            coordinates: self.coordinates.clone(),
            tetrahedra: self.tetrahedra.iter().map(|t| t.nodes).collect(),
            tetrahedron_group: self.tetrahedra.iter().filter_map(group).collect(),
            group_names: first.group_names.clone(),
            facets,
            facet_face,
            face_names: first.face_names.clone(),
            mid_edges: None,
            bodies: Vec::new(),
            obstacles: first.obstacles.clone(),
        }
    }

    /// Number of tetrahedra.
    pub(super) fn n_tetrahedra(&self) -> usize {
        self.tetrahedra.len()
    }

    /// Where each tetrahedron lies in the first mesh.
    pub(super) fn descendants(&self) -> impl Iterator<Item = Descendant> {
        self.tetrahedra.iter().map(|t| Descendant {
            ancestor: t.ancestor,
            places: t.places,
            parent: t.parent,
        })
    }

    /// The node in the middle of an edge, made if it is not there yet.
    fn middle(&mut self, edge: [usize; 2]) -> usize {
        let coordinates = &mut self.coordinates;
        *self.middles.entry(edge).or_insert_with(|| {
            let [a, b] = edge.map(|node| coordinates[node]);
            coordinates.push(std::array::from_fn(|c| 0.5 * (a[c] + b[c])));
            coordinates.len() - 1
        })
    }
}

impl MarkedTetrahedron {
    /// Whether the refinement edge and the marks of the two triangles that do not hold it lie in one
    /// plane.
    fn is_planar(&self) -> bool {
        let others = (0..4).filter(|&k| self.refinement.contains(&self.nodes[k]));
        let mut touched: Vec<usize> = others.flat_map(|k| self.marks[k]).collect();
        touched.extend(self.refinement);
        touched.sort_unstable();
        touched.dedup();
        touched.len() == 3
    }

    /// The two halves, first that with the smaller end of the refinement edge.
    fn bisected(&self, middle: usize) -> [Self; 2] {
        let was_planar = self.is_planar();
        let ends = self.refinement;
        ends.map(|kept| {
            let dropped = ends[usize::from(kept == ends[0])];
            let at = |node: usize| self.nodes.iter().position(|n| *n == node).unwrap_or(0);
            let (kept_at, dropped_at) = (at(kept), at(dropped));
            let mut nodes = self.nodes;
            nodes[dropped_at] = middle;
            let mut places = self.places;
            let (p, q) = (self.places[kept_at], self.places[dropped_at]);
            places[dropped_at] = std::array::from_fn(|j| 0.5 * (p[j] + q[j]));
            // The triangle opposite to the dropped end is inherited whole with its mark, at which
            // the child is cut next.
            let refinement = self.marks[dropped_at];
            let others: Vec<usize> = self
                .nodes
                .into_iter()
                .filter(|n| !ends.contains(n))
                .collect();
            let opposite = edge(others[0], others[1]);
            let marks = std::array::from_fn(|k| {
                if k == dropped_at {
                    refinement
                } else if k == kept_at {
                    // The triangle between the two children.
                    match (was_planar && self.is_flagged, common(refinement, opposite)) {
                        (true, Some(node)) => edge(middle, node),
                        _ => opposite,
                    }
                } else {
                    // A triangle that was cut: the edge opposite to the new node.
                    let third = others.iter().find(|n| **n != self.nodes[k]);
                    edge(kept, third.copied().unwrap_or(kept))
                }
            });
            let mut faces = self.faces;
            faces[kept_at] = None;
            Self {
                nodes,
                marks,
                refinement,
                is_flagged: was_planar && !self.is_flagged,
                faces,
                ancestor: self.ancestor,
                places,
                parent: self.parent,
                cuts: self.cuts.saturating_sub(1),
            }
        })
    }
}

/// The node that two edges share.
fn common(first: [usize; 2], second: [usize; 2]) -> Option<usize> {
    first.into_iter().find(|node| second.contains(node))
}
