//! Element types and physical groups of a Gmsh file.

use std::collections::{BTreeMap, HashSet};

use super::{
    FilePosition, GmshFlaw,
    body::{GmshBody, listed_nodes},
    boundary::GmshBoundary,
    contents::Contents,
};
use crate::mesh::sorted;

/// What is in no physical group is called so.
const UNNAMED: &str = "unnamed";

impl Contents {
    /// The name of a physical group: its number when it has none.
    pub(super) fn group_name(&self, dimension: i64, tag: i64) -> String {
        let name = self.names.get(&(dimension, tag));
        name.cloned().unwrap_or_else(|| tag.to_string())
    }

    /// The one physical group of an element; an error with the first two when it is in several.
    fn group_of<const K: usize>(&self, element: &MeshElement<K>) -> Result<Option<i64>, [i64; 2]> {
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
        let (dimension, kind, help) = if K == 4 {
            (3, "volume", "take the volume out of one of the two groups")
        } else {
            (
                2,
                "surface",
                "take the surface out of one of the two groups",
            )
        };
        let [first, second] = groups.map(|group| self.group_name(dimension, group));
        let expected = format!("one physical {kind}");
        element.flaw(expected, format!("{first:?} and {second:?}"), help)
    }
}

/// Members and names of the physical volumes; both empty when there are none.
pub(super) fn volumes(contents: &Contents) -> Result<(Vec<usize>, Vec<String>), GmshFlaw> {
    let groups: Vec<Option<i64>> = contents
        .tetrahedra
        .iter()
        .map(|element| {
            let groups = contents.group_of(element);
            groups.map_err(|groups| contents.in_two_groups(element, groups))
        })
        .collect::<Result<_, _>>()?;
    if groups.iter().all(Option::is_none) {
        return Ok((Vec::new(), Vec::new()));
    }
    named(contents, 3, &groups)
}

/// The physical surface of each boundary triangle, and the names of the surfaces.
///
/// Triangles inside the body or off it are passed over, unless their surface has no other.
pub(super) fn surfaces(
    contents: &Contents,
    body: &GmshBody,
    boundary: &GmshBoundary,
) -> Result<(Vec<usize>, Vec<String>), GmshFlaw> {
    let mut facet_group: Vec<Option<i64>> = vec![None; boundary.facets.len()];
    let mut surfaces: BTreeMap<i64, PhysicalSurface> = BTreeMap::new();
    for element in &contents.triangles {
        listed_nodes(contents, element, &element.nodes)?;
        let two = |groups| contents.in_two_groups(element, groups);
        let Some(group) = contents.group_of(element).map_err(two)? else {
            continue;
        };
        let surface = surfaces.entry(group).or_insert(PhysicalSurface {
            first: element,
            triangles: 0,
            on_boundary: false,
        });
        surface.triangles += 1;
        let nodes = body.numbers(element.nodes).map(sorted);
        if let Some(&facet) = nodes.and_then(|key| boundary.facet_of.get(&key)) {
            surface.on_boundary = true;
            match facet_group[facet].replace(group) {
                Some(other) if other != group => return Err(two([other, group])),
                _ => {}
            }
        }
    }
    if let Some((&group, surface)) = surfaces.iter().find(|(_, s)| !s.on_boundary) {
        let flaw = GmshFlaw::new(
            surface.first.place,
            "triangles on the boundary of the body",
            format!(
                "none among its {} (triangle {} is the first)",
                surface.triangles, surface.first.tag
            ),
            "the surface lies inside the body or off it; name an outer surface, and check that its volume is in a physical group",
        );
        let name = contents.group_name(2, group);
        return Err(flaw.of(format!("physical surface {name:?}")));
    }
    named(contents, 2, &facet_group)
}

/// The triangles of a physical surface in the file.
struct PhysicalSurface<'a> {
    first: &'a MeshElement<3>,
    triangles: usize,
    on_boundary: bool,
}

/// Numbers the groups by increasing tag, those without a group last.
fn named(
    contents: &Contents,
    dimension: i64,
    groups: &[Option<i64>],
) -> Result<(Vec<usize>, Vec<String>), GmshFlaw> {
    let mut tags: Vec<i64> = groups.iter().flatten().copied().collect();
    tags.sort_unstable();
    tags.dedup();
    let mut names: Vec<String> = tags
        .iter()
        .map(|&tag| contents.group_name(dimension, tag))
        .collect();
    if groups.iter().any(Option::is_none) {
        names.push(UNNAMED.to_owned());
    }
    let mut seen = HashSet::new();
    if let Some(name) = names.iter().find(|name| !seen.insert(*name)) {
        let kind = if dimension == 3 {
            "volumes"
        } else {
            "surfaces"
        };
        return Err(GmshFlaw::new(
            None,
            format!("different names of the physical {kind}"),
            format!("{name:?} twice"),
            "rename one; a group without a name is called by its number, and what is in no group is called \"unnamed\"",
        ));
    }
    let index = |group: &Option<i64>| {
        group.map_or(tags.len(), |tag| tags.partition_point(|&other| other < tag))
    };
    Ok((groups.iter().map(index).collect(), names))
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

/// The kinds of elements that a mesh of linear or quadratic tetrahedra has.
#[derive(Debug, Clone, Copy)]
pub(super) enum ElementKind {
    Point,
    Line(Order),
    Triangle(Order),
    Tetrahedron(Order),
}

/// Whether elements have nodes in the middle of their edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    First,
    Second,
}

/// Most nodes of an element that is read.
pub(super) const MOST_NODES: usize = 10;

/// The mid-edge nodes of a second-order tetrahedron in our order; the format swaps the last two.
pub(super) const MIDDLES: [usize; 6] = [4, 5, 6, 7, 9, 8];

impl ElementKind {
    /// The kind with a code of the format (Gmsh reference manual, MSH file format).
    pub(super) fn of_code(code: i64, place: FilePosition) -> Result<Self, GmshFlaw> {
        let name = match code {
            1 => return Ok(Self::Line(Order::First)),
            2 => return Ok(Self::Triangle(Order::First)),
            4 => return Ok(Self::Tetrahedron(Order::First)),
            8 => return Ok(Self::Line(Order::Second)),
            9 => return Ok(Self::Triangle(Order::Second)),
            11 => return Ok(Self::Tetrahedron(Order::Second)),
            15 => return Ok(Self::Point),
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
        Err(GmshFlaw::new(
            place,
            "linear tetrahedra and triangles",
            format!("{name} (element type {code})"),
            "only linear tetrahedra are used: mesh without Recombine and save with gmsh part.geo -3 -order 1",
        ))
    }

    pub(super) fn n_nodes(self) -> usize {
        match self {
            Self::Point => 1,
            Self::Line(Order::First) => 2,
            Self::Line(Order::Second) | Self::Triangle(Order::First) => 3,
            Self::Triangle(Order::Second) => 6,
            Self::Tetrahedron(Order::First) => 4,
            Self::Tetrahedron(Order::Second) => 10,
        }
    }
}
