//! Element types and physical groups of a Gmsh file.

use std::collections::{BTreeMap, HashSet};

use super::{
    FilePosition, GmshError,
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
}

/// Members and names of the physical volumes; both empty when there are none.
pub(super) fn volumes(contents: &Contents) -> Result<(Vec<usize>, Vec<String>), GmshError> {
    let groups: Vec<Option<i64>> = contents
        .tetrahedra
        .iter()
        .map(|element| {
            contents
                .group_of(element)
                .map_err(|[first, second]| GmshError::TwoVolumes {
                    place: element.place,
                    element: element.tag,
                    first: contents.group_name(3, first),
                    second: contents.group_name(3, second),
                })
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
) -> Result<(Vec<usize>, Vec<String>), GmshError> {
    let mut facet_group: Vec<Option<i64>> = vec![None; boundary.facets.len()];
    let mut surfaces: BTreeMap<i64, PhysicalSurface> = BTreeMap::new();
    for element in &contents.triangles {
        listed_nodes(contents, element)?;
        let two = |[first, second]: [i64; 2]| GmshError::TwoSurfaces {
            place: element.place,
            element: element.tag,
            first: contents.group_name(2, first),
            second: contents.group_name(2, second),
        };
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
        return Err(GmshError::NotOnBoundary {
            place: surface.first.place,
            name: contents.group_name(2, group),
            triangles: surface.triangles,
            element: surface.first.tag,
        });
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
) -> Result<(Vec<usize>, Vec<String>), GmshError> {
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
        return Err(GmshError::RepeatedName {
            kind: if dimension == 3 {
                "volumes"
            } else {
                "surfaces"
            },
            name: name.clone(),
        });
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
    pub(super) fn of_code(code: i64, place: FilePosition) -> Result<Self, GmshError> {
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
        Err(GmshError::ElementType { place, code, name })
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
