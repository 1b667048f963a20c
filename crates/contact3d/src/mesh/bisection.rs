//! Local refinement of a tetrahedral mesh by bisection, conforming.
//!
//! Every tetrahedron is cut at its longest edge, as M.-C. Rivara, Algorithms for refining triangular grids suitable for
//! adaptive and multigrid techniques, Int. J. Numer. Meth. Engng 20 (1984) 745: slender ones become rounder, as those between
//! the lines of a graded brick, where rules that repeat the shapes of the first mesh keep their slenderness. An order of all
//! edges, equal in all tetrahedra, cuts a triangle at its longest edge on both sides, so that meshes conform; cutting
//! those with hanging nodes comes to an end, since what it cuts is no shorter than the edge that asked for it.

use std::{cmp::Reverse, collections::HashMap};

use super::{COORDINATE_ROUNDING, RawMesh, quadratic::edge, sorted};
use crate::reference::TETRAHEDRON_EDGES;

/// A tetrahedron with the edge at which it will be cut.
#[derive(Debug, Clone, PartialEq)]
struct MarkedTetrahedron {
    nodes: [usize; 4],
    longest: [usize; 2],
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
pub struct Descendant {
    /// The tetrahedron of the first mesh that it lies in.
    pub ancestor: usize,
    /// Barycentric coordinates of its corners there.
    pub places: [[f64; 4]; 4],
    /// The tetrahedron of the mesh before the last refinement that it lies in.
    pub parent: usize,
}

impl Descendant {
    /// Where its corners and the middles of its edges lie in its ancestor.
    #[must_use]
    pub fn nodes(&self) -> [[f64; 4]; 10] {
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
        let tetrahedra = mesh.tetrahedra.iter().enumerate();
        let tetrahedra = tetrahedra.map(|(ancestor, nodes)| MarkedTetrahedron {
            nodes: *nodes,
            longest: longest(&mesh.coordinates, nodes),
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
        for (number, tetrahedron) in self.tetrahedra.iter_mut().enumerate() {
            tetrahedron.parent = number;
            tetrahedron.cuts = cuts.get(number).copied().unwrap_or(0);
        }
        let mut must_cut: Vec<bool> = self.tetrahedra.iter().map(|t| t.cuts > 0).collect();
        while must_cut.contains(&true) {
            let parents = std::mem::take(&mut self.tetrahedra);
            for (parent, must_cut) in parents.into_iter().zip(must_cut) {
                if must_cut {
                    let middle = self.middle(parent.longest);
                    self.tetrahedra
                        .extend(parent.bisected(middle, &self.coordinates));
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
    /// The two halves, first that with the smaller end of the edge that is cut.
    fn bisected(&self, middle: usize, coordinates: &[[f64; 3]]) -> [Self; 2] {
        let at = self
            .longest
            .map(|end| self.nodes.iter().position(|n| *n == end).unwrap_or(0));
        [(at[0], at[1]), (at[1], at[0])].map(|(kept, dropped)| {
            let mut child = self.clone();
            child.nodes[dropped] = middle;
            child.longest = longest(coordinates, &child.nodes);
            let (p, q) = (self.places[kept], self.places[dropped]);
            child.places[dropped] = std::array::from_fn(|j| 0.5 * (p[j] + q[j]));
            child.faces[kept] = None;
            child.cuts = self.cuts.saturating_sub(1);
            child
        })
    }
}

/// The last edge of a tetrahedron in the order of lengths, and of node numbers where lengths are equal but for rounding.
fn longest(coordinates: &[[f64; 3]], nodes: &[usize; 4]) -> [usize; 2] {
    let order = |&[a, b]: &[usize; 2]| {
        let square = (0..3).map(|c| (coordinates[a][c] - coordinates[b][c]).powi(2));
        let classes = square.sum::<f64>().ln() / COORDINATE_ROUNDING;
        (classes.round() as i64, Reverse([a, b]))
    };
    let edges = edges(nodes).into_iter().max_by_key(order);
    edges.unwrap_or_default()
}
