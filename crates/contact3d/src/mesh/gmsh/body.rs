//! The tetrahedra of a mesh file as one body: numbered nodes, positive orientation.

use std::collections::HashMap;

use super::{
    contents::{Contents, MeshElement, listed_nodes},
    scanner::GmshFlaw,
};
use crate::{
    mesh::{IsoparametricMap, quadratic::edge, side::edge_lengths},
    reference::TETRAHEDRON_EDGES,
};

/// The tetrahedra of a file on nodes numbered by increasing tag; unused nodes are dropped.
#[derive(Debug)]
pub(super) struct GmshBody {
    pub(super) coordinates: Vec<[f64; 3]>,
    /// Tag of each node, increasing.
    pub(super) tags: Vec<u64>,
    /// Positively oriented, in the order of the file.
    pub(super) tetrahedra: Vec<[usize; 4]>,
    /// Their mid-edge nodes, where they have any.
    pub(super) mid_edges: Option<Vec<[usize; 6]>>,
}

impl GmshBody {
    /// Numbers the nodes and orients the tetrahedra; a mesh whose tetrahedra are all inverted, as
    /// in a mirrored copy, is turned as a whole.
    pub(super) fn new(contents: &Contents) -> Result<Self, GmshFlaw> {
        if contents.tetrahedra.is_empty() {
            return Err(GmshFlaw::new(
                None,
                "tetrahedra",
                "none",
                "mesh the volume (gmsh -3); when there are physical groups, Gmsh saves only elements in them: add a Physical Volume",
            ));
        }
        let in_file: Vec<[usize; 4]> = contents
            .tetrahedra
            .iter()
            .map(|element| listed_nodes(contents, element, &element.nodes))
            .collect::<Result<_, _>>()?;
        let middles: Vec<[usize; 6]> = contents
            .middles
            .iter()
            .zip(&contents.tetrahedra)
            .map(|(tags, element)| listed_nodes(contents, element, tags))
            .collect::<Result<_, _>>()?;
        let mut is_used = vec![false; contents.node_tags.len()];
        let nodes = in_file.as_flattened().iter();
        nodes
            .chain(middles.as_flattened())
            .for_each(|&node| is_used[node] = true);
        let mut used: Vec<usize> = (0..is_used.len()).filter(|&n| is_used[n]).collect();
        used.sort_unstable_by_key(|&node| contents.node_tags[node]);
        let mut number = vec![0; contents.node_tags.len()];
        for (new, &old) in used.iter().enumerate() {
            number[old] = new;
        }
        let mut body = Self {
            coordinates: used.iter().map(|&n| contents.coordinates[n]).collect(),
            tags: used.iter().map(|&n| contents.node_tags[n]).collect(),
            tetrahedra: in_file.iter().map(|t| t.map(|n| number[n])).collect(),
            mid_edges: (!middles.is_empty())
                .then(|| middles.iter().map(|m| m.map(|n| number[n])).collect()),
        };
        body.orient(&contents.tetrahedra)?;
        body.check_middles(&contents.tetrahedra)?;
        Ok(body)
    }

    /// Refuses edges with two nodes in the middle and curved tetrahedra that fold.
    fn check_middles(&self, elements: &[MeshElement<4>]) -> Result<(), GmshFlaw> {
        let mut known = HashMap::new();
        let middles = self.mid_edges.iter().flatten();
        for ((corners, middles), element) in self.tetrahedra.iter().zip(middles).zip(elements) {
            for ([a, b], &node) in TETRAHEDRON_EDGES.into_iter().zip(middles) {
                let (a, b) = (corners[a], corners[b]);
                let first = *known.entry(edge(a, b)).or_insert(node);
                if first != node {
                    let [first, a, b, found] = [first, a, b, node].map(|n| self.tags[n]);
                    return Err(element.flaw(
                        format!("the node {first} in the middle of the edge from {a} to {b}, as in another tetrahedron"),
                        found.to_string(),
                        "parts that touch are not joined: use BooleanFragments or Coherence before meshing",
                    ));
                }
            }
            let corners = corners.map(|n| self.coordinates[n]);
            let ratio = IsoparametricMap::new(&corners, &middles.map(|n| self.coordinates[n]))
                .least_jacobian();
            if ratio.is_nan() || ratio <= 0.0 {
                return Err(element.flaw(
                    "a positive Jacobian everywhere",
                    format!("{ratio:.1e} times that of its corners"),
                    "curve the mesh with care: gmsh part.geo -3 -order 2 -optimize_ho -format msh41 -o part.msh, or refine it where sides bend",
                ));
            }
        }
        Ok(())
    }

    /// The node numbers of a triangle of the file, if tetrahedra use all three.
    pub(super) fn numbers(&self, tags: [u64; 3]) -> Option<[usize; 3]> {
        let find = |tag: u64| self.tags.binary_search(&tag).ok();
        Some([find(tags[0])?, find(tags[1])?, find(tags[2])?])
    }

    fn orient(&mut self, elements: &[MeshElement<4>]) -> Result<(), GmshFlaw> {
        let mut inverted = Vec::new();
        for (t, (nodes, element)) in self.tetrahedra.iter().zip(elements).enumerate() {
            let (ratio, rounding) = relative_volume(&nodes.map(|n| self.coordinates[n]));
            // Not a number when coordinates are so far apart that products overflow.
            if ratio.is_nan() || ratio.abs() <= rounding {
                return Err(element.flaw(
                    "a volume",
                    format!("{ratio:.1e} of its longest edge cubed, which is rounding"),
                    "the tetrahedron is flat; optimise the mesh (gmsh -optimize) or mesh again",
                ));
            }
            if ratio < 0.0 {
                inverted.push(t);
            }
        }
        let total = elements.len();
        if inverted.len() == total {
            self.tetrahedra.iter_mut().for_each(|t| t.swap(2, 3));
            // Corners 2 and 3 change places, so edges 1-2 and 1-3 do, and 0-2 and 0-3.
            let middles = self.mid_edges.iter_mut().flatten();
            middles.for_each(|m| *m = [m[0], m[4], m[3], m[2], m[1], m[5]]);
        } else if let Some(&first) = inverted.first() {
            return Err(elements[first].flaw(
                "the orientation of the others",
                format!("it inverted ({} of {total} are)", inverted.len()),
                "the mesh folds over itself there; optimise it (gmsh -optimize) or mesh again",
            ));
        }
        Ok(())
    }
}

/// Signed volume over the cube of the longest edge L, and what roundings of the coordinates alone
/// can make of it.
///
/// Coordinates up to M are rounded by at most εM/2, edges over L by εM/L in each component, and
/// the determinant of three vectors not longer than 1 by 3√3 εM/L; 8 also covers its evaluation.
fn relative_volume(corners: &[[f64; 3]; 4]) -> (f64, f64) {
    let p = corners.map(nalgebra::Vector3::from);
    let longest = edge_lengths(corners).into_iter().fold(0.0, f64::max);
    let [u, v, w] = [1, 2, 3].map(|i| (p[i] - p[0]) / longest);
    let largest = p.iter().map(|x| x.amax()).fold(0.0, f64::max);
    (
        u.cross(&v).dot(&w) / 6.0,
        8.0 * f64::EPSILON * largest / longest / 6.0,
    )
}
