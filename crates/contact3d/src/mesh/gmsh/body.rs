//! The tetrahedra of a mesh file as one body: numbered nodes, positive orientation.

use super::{GmshError, contents::Contents, element::Element};

/// The tetrahedra of a file on nodes numbered by increasing tag; unused nodes are dropped.
#[derive(Debug)]
pub(super) struct Body {
    pub(super) coordinates: Vec<[f64; 3]>,
    /// Tag of each node, increasing.
    pub(super) tags: Vec<u64>,
    /// Positively oriented, in the order of the file.
    pub(super) tetrahedra: Vec<[usize; 4]>,
}

impl Body {
    /// Numbers the nodes and orients the tetrahedra; a mesh whose tetrahedra are all inverted, as
    /// in a mirrored copy, is turned as a whole.
    pub(super) fn new(contents: &Contents) -> Result<Self, GmshError> {
        if contents.tetrahedra.is_empty() {
            return Err(GmshError::NoTetrahedra);
        }
        let in_file: Vec<[usize; 4]> = contents
            .tetrahedra
            .iter()
            .map(|element| listed_nodes(contents, element))
            .collect::<Result<_, _>>()?;
        let mut is_used = vec![false; contents.node_tags.len()];
        in_file
            .iter()
            .flatten()
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
        };
        body.orient(&contents.tetrahedra)?;
        Ok(body)
    }

    /// The node numbers of a triangle of the file, if tetrahedra use all three.
    pub(super) fn numbers(&self, tags: [u64; 3]) -> Option<[usize; 3]> {
        let find = |tag: u64| self.tags.binary_search(&tag).ok();
        Some([find(tags[0])?, find(tags[1])?, find(tags[2])?])
    }

    fn orient(&mut self, elements: &[Element<4>]) -> Result<(), GmshError> {
        let mut inverted = Vec::new();
        for (t, (nodes, element)) in self.tetrahedra.iter().zip(elements).enumerate() {
            let (ratio, rounding) = relative_volume(&nodes.map(|n| self.coordinates[n]));
            // Not a number when coordinates are so far apart that products overflow.
            if ratio.is_nan() || ratio.abs() <= rounding {
                return Err(GmshError::Degenerate {
                    place: element.place,
                    element: element.tag,
                    ratio,
                });
            }
            if ratio < 0.0 {
                inverted.push(t);
            }
        }
        let total = elements.len();
        if inverted.len() == total {
            self.tetrahedra.iter_mut().for_each(|t| t.swap(2, 3));
        } else if let Some(&first) = inverted.first() {
            return Err(GmshError::Inverted {
                place: elements[first].place,
                element: elements[first].tag,
                inverted: inverted.len(),
                total,
            });
        }
        Ok(())
    }
}

/// Indices of an element's nodes in the file; they must be listed and differ.
pub(super) fn listed_nodes<const K: usize>(
    contents: &Contents,
    element: &Element<K>,
) -> Result<[usize; K], GmshError> {
    let mut nodes = [0; K];
    for (i, &tag) in element.nodes.iter().enumerate() {
        if element.nodes[..i].contains(&tag) {
            return Err(GmshError::RepeatedNode {
                place: element.place,
                element: element.tag,
                node: tag,
            });
        }
        nodes[i] = *contents
            .node_of_tag
            .get(&tag)
            .ok_or(GmshError::UnknownNode {
                place: element.place,
                element: element.tag,
                node: tag,
            })?;
    }
    Ok(nodes)
}

/// Signed volume over the cube of the longest edge L, and what roundings of the coordinates alone
/// can make of it.
///
/// Coordinates up to M are rounded by at most εM/2, edges over L by εM/L in each component, and
/// the determinant of three vectors not longer than 1 by 3√3 εM/L; 8 also covers its evaluation.
fn relative_volume(corners: &[[f64; 3]; 4]) -> (f64, f64) {
    let p = corners.map(nalgebra::Vector3::from);
    let longest = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
        .map(|(a, b)| (p[b] - p[a]).norm())
        .into_iter()
        .fold(0.0, f64::max);
    let [u, v, w] = [1, 2, 3].map(|i| (p[i] - p[0]) / longest);
    let largest = p.iter().map(|x| x.amax()).fold(0.0, f64::max);
    (
        u.cross(&v).dot(&w) / 6.0,
        8.0 * f64::EPSILON * largest / longest / 6.0,
    )
}
