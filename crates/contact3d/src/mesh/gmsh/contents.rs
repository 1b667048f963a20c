//! Nodes, elements and physical groups of a mesh file, before they are checked as a body.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::scanner::{FilePosition, GmshFlaw, Scanner};

/// What a mesh file says, before it is checked as a body.
#[derive(Debug, Default)]
pub(super) struct Contents {
    pub(super) node_tags: Vec<u64>,
    /// Index of each node by its tag.
    pub(super) node_of_tag: HashMap<u64, usize>,
    pub(super) coordinates: Vec<[f64; 3]>,
    pub(super) tetrahedra: Vec<MeshElement<4>>,
    /// Node tags of the mid-edge nodes of each tetrahedron in our order; empty in a mesh of linear ones.
    pub(super) middles: Vec<[u64; 6]>,
    pub(super) triangles: Vec<MeshElement<3>>,
    /// Node tags of the middles of the edges that begin at each corner, by the tags of triangles of the second order.
    pub(super) middles_of_triangles: HashMap<u64, [u64; 3]>,
    /// The sets of physical groups that elements are in, increasing; the first one is empty.
    pub(super) memberships: Vec<Vec<i64>>,
    /// Names of physical groups by dimension and tag.
    pub(super) names: BTreeMap<(i64, i64), String>,
}

impl Contents {
    /// Adds a set of physical groups, of which 0 is none, and gives its index.
    pub(super) fn membership(&mut self, mut groups: Vec<i64>) -> usize {
        groups.retain(|group| *group != 0);
        if groups.is_empty() {
            return 0;
        }
        groups.sort_unstable();
        groups.dedup();
        self.memberships.push(groups);
        self.memberships.len() - 1
    }

    /// Makes room for nodes whose count was checked against the file.
    pub(super) fn reserve_nodes(&mut self, count: usize) {
        self.node_tags.reserve(count);
        self.node_of_tag.reserve(count);
        self.coordinates.reserve(count);
    }

    /// Adds a node; its tag must be new and its coordinates finite.
    pub(super) fn push_node(
        &mut self,
        place: FilePosition,
        tag: u64,
        at: [f64; 3],
    ) -> Result<(), GmshFlaw> {
        if let Some(&found) = at.iter().find(|x| !x.is_finite()) {
            let flaw = GmshFlaw::new(
                place,
                "finite coordinates",
                found.to_string(),
                "mesh the geometry again",
            );
            return Err(flaw.of(format!("node {tag}")));
        }
        if self.node_of_tag.insert(tag, self.node_tags.len()).is_some() {
            return Err(GmshFlaw::new(
                place,
                "every node once",
                format!("node {tag} again"),
                "renumber the mesh in Gmsh: Mesh > Renumber, or RenumberMeshNodes",
            ));
        }
        self.node_tags.push(tag);
        self.coordinates.push(at);
        Ok(())
    }

    /// Reads the nodes of one element and adds it if it is a triangle or a tetrahedron.
    pub(super) fn read_element(
        &mut self,
        scanner: &mut Scanner,
        (place, tag): (FilePosition, u64),
        kind: ElementKind,
        membership: usize,
    ) -> Result<(), GmshFlaw> {
        let mut nodes = [0; 10];
        for node in &mut nodes[..kind.n_nodes] {
            *node = scanner.size("the tag of a node of the element")?;
        }
        let [a, b, c, d, e, f, ..] = nodes;
        match kind.corners {
            3 => {
                if kind.n_nodes == 6 {
                    self.middles_of_triangles.insert(tag, [d, e, f]);
                }
                self.triangles.push(MeshElement {
                    tag,
                    place,
                    nodes: [a, b, c],
                    membership,
                });
            }
            4 => {
                if kind.n_nodes == 10 {
                    self.middles.push(MIDDLES.map(|k| nodes[k]));
                }
                self.tetrahedra.push(MeshElement {
                    tag,
                    place,
                    nodes: [a, b, c, d],
                    membership,
                });
                if ![0, self.tetrahedra.len()].contains(&self.middles.len()) {
                    return Err(GmshFlaw::new(
                        place,
                        "tetrahedra of one order",
                        format!("tetrahedron {tag} of another one"),
                        "mesh the whole body with one order: gmsh part.geo -3 -order 2 -format msh41 -o part.msh",
                    ));
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Leaves the tetrahedra of a physical volume, and the triangles between their nodes.
    pub(super) fn keep_volume(&mut self, name: &str) -> Result<(), GmshFlaw> {
        let groups = |element: &MeshElement<4>| self.memberships[element.membership].iter();
        let is_in = |element: &MeshElement<4>| {
            let mut groups = groups(element);
            groups.any(|tag| self.group_name(3, *tag) == name)
        };
        let is_kept: Vec<bool> = self.tetrahedra.iter().map(is_in).collect();
        if !is_kept.contains(&true) {
            let names = self.volume_names();
            return Err(GmshFlaw::new(
                None,
                format!("one of the physical volumes: {}", names.join(", ")),
                format!("volume = {name:?}"),
                "each body of a file is a physical volume of its own",
            ));
        }
        let mut kept = is_kept.iter();
        self.middles.retain(|_| kept.next() == Some(&true));
        let mut kept = is_kept.iter();
        self.tetrahedra.retain(|_| kept.next() == Some(&true));
        let nodes = self.tetrahedra.iter().flat_map(|element| element.nodes);
        let nodes: HashSet<u64> = nodes.collect();
        self.triangles
            .retain(|element| element.nodes.iter().all(|node| nodes.contains(node)));
        Ok(())
    }

    /// The names of the physical volumes, by increasing tag.
    pub(super) fn volume_names(&self) -> Vec<String> {
        let elements = self.tetrahedra.iter();
        let tags: BTreeSet<i64> = elements
            .flat_map(|element| self.memberships[element.membership].iter().copied())
            .collect();
        tags.iter().map(|tag| self.group_name(3, *tag)).collect()
    }

    /// The name of a physical group: its number when it has none.
    pub(super) fn group_name(&self, dimension: i64, tag: i64) -> String {
        let name = self.names.get(&(dimension, tag));
        name.cloned().unwrap_or_else(|| tag.to_string())
    }

    /// The one physical group of an element; an error with the first two when it is in several.
    pub(super) fn group_of<const K: usize>(
        &self,
        element: &MeshElement<K>,
    ) -> Result<Option<i64>, [i64; 2]> {
        match self.memberships[element.membership].as_slice() {
            [] => Ok(None),
            [group] => Ok(Some(*group)),
            [first, second, ..] => Err([*first, *second]),
        }
    }

    /// The flaw of an element that two physical groups claim.
    pub(super) fn in_two_groups<const K: usize>(
        &self,
        element: &MeshElement<K>,
        groups: [i64; 2],
    ) -> GmshFlaw {
        let (dimension, kind) = if K == 4 {
            (3, "volume")
        } else {
            (2, "surface")
        };
        let [first, second] = groups.map(|group| self.group_name(dimension, group));
        let expected = format!("one physical {kind}");
        let help = "take it out of one of the two groups, or choose groups: python -m contact3d.convert mesh.msh part.msh --sets NAME ...";
        element.flaw(expected, format!("{first:?} and {second:?}"), help)
    }
}

/// A tetrahedron (K = 4) or triangle (K = 3) as it stands in the file, by its corners.
#[derive(Debug)]
pub(super) struct MeshElement<const K: usize> {
    pub(super) tag: u64,
    pub(super) place: FilePosition,
    /// Node tags of the corners.
    pub(super) nodes: [u64; K],
    /// Index into the memberships.
    pub(super) membership: usize,
}

impl<const K: usize> MeshElement<K> {
    /// A flaw of this element.
    pub(super) fn flaw(
        &self,
        expected: impl Into<String>,
        found: impl Into<String>,
        help: &'static str,
    ) -> GmshFlaw {
        let kind = if K == 4 { "tetrahedron" } else { "triangle" };
        GmshFlaw::new(self.place, expected, found, help).of(format!("{kind} {}", self.tag))
    }
}

/// Corners and nodes of a kind of elements that a mesh of linear or quadratic tetrahedra has.
#[derive(Debug, Clone, Copy)]
pub(super) struct ElementKind {
    /// 1 of a point, 2 of a line, 3 of a triangle, 4 of a tetrahedron.
    corners: usize,
    /// Corners, and middles of edges in elements of the second order.
    pub(super) n_nodes: usize,
}

/// The mid-edge nodes of a second-order tetrahedron in our order; the format swaps the last two.
const MIDDLES: [usize; 6] = [4, 5, 6, 7, 9, 8];

impl ElementKind {
    /// The kind with a code of the format (Gmsh reference manual, MSH file format).
    pub(super) fn of_code(code: i64, place: FilePosition) -> Result<Self, GmshFlaw> {
        let (corners, n_nodes) = match code {
            15 => (1, 1),
            1 => (2, 2),
            8 => (2, 3),
            2 => (3, 3),
            9 => (3, 6),
            4 => (4, 4),
            11 => (4, 10),
            _ => return Err(unused_elements(code, place)),
        };
        Ok(Self { corners, n_nodes })
    }
}

fn unused_elements(code: i64, place: FilePosition) -> GmshFlaw {
    let name = match code {
        3 => "quadrangles",
        5 => "hexahedra",
        6 => "prisms",
        7 => "pyramids",
        10 | 16 => "second-order quadrangles",
        12 | 17 => "second-order hexahedra",
        13 | 18 => "second-order prisms",
        14 | 19 => "second-order pyramids",
        20..=28 => "higher-order lines or triangles",
        29..=31 => "higher-order tetrahedra",
        _ => "another kind",
    };
    GmshFlaw::new(
        place,
        "linear or quadratic tetrahedra and triangles",
        format!("{name} (element type {code})"),
        "linear and quadratic tetrahedra are used: mesh without Recombine and save with gmsh part.geo -3 -order 1 or -order 2; python -m contact3d.convert mesh.msh part.msh --cut makes tetrahedra of other linear cells",
    )
}

/// Indices of nodes of an element in the file; they must be listed and differ.
pub(super) fn listed_nodes<const K: usize, const N: usize>(
    contents: &Contents,
    element: &MeshElement<K>,
    tags: &[u64; N],
) -> Result<[usize; N], GmshFlaw> {
    let mut nodes = [0; N];
    for (i, &tag) in tags.iter().enumerate() {
        let flaw = |expected: &str, found, help| {
            let flaw = GmshFlaw::new(element.place, expected, found, help);
            flaw.of(format!("element {}", element.tag))
        };
        if tags[..i].contains(&tag) {
            return Err(flaw(
                "different nodes",
                format!("node {tag} twice"),
                "the element is degenerate; mesh the geometry again, or a little coarser",
            ));
        }
        nodes[i] = *contents.node_of_tag.get(&tag).ok_or_else(|| {
            let found = format!("node {tag}");
            flaw(
                "nodes of $Nodes",
                found,
                "the file is damaged; save it again",
            )
        })?;
    }
    Ok(nodes)
}
