//! Physical volumes and surfaces of a body, by their names.

use std::{
    cmp::Reverse,
    collections::{BTreeMap, HashMap, HashSet, hash_map::Entry},
};

use nalgebra::Vector3;

use super::{
    body::GmshBody,
    boundary::{GmshBoundary, Pieces},
    contents::{Contents, MeshElement, listed_nodes},
    scanner::GmshFlaw,
};
use crate::mesh::sorted;

/// What is in no physical group is called so.
const UNNAMED: &str = "unnamed";

/// A boundary without names is split where triangles meet at more than so many degrees, as the converter does: a round hole is drawn with
/// more than twelve sides.
const EDGE_ANGLE: f64 = 30.0;

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
/// Triangles inside the body or off it are passed over, unless their surface has no other. Without physical surfaces the boundary is split at
/// its edges: `face_1`, `face_2` and so on, the largest first.
pub(super) fn surfaces(
    contents: &Contents,
    body: &GmshBody,
    boundary: &GmshBoundary,
) -> Result<(Vec<usize>, Vec<String>), GmshFlaw> {
    let mut facet_group: Vec<Option<i64>> = vec![None; boundary.facets.len()];
    let mut surfaces: BTreeMap<i64, Vec<&MeshElement<3>>> = BTreeMap::new();
    for element in &contents.triangles {
        listed_nodes(contents, element, &element.nodes)?;
        let two = |groups| contents.in_two_groups(element, groups);
        let Some(group) = contents.group_of(element).map_err(two)? else {
            continue;
        };
        surfaces.entry(group).or_default().push(element);
        let nodes = body.numbers(element.nodes).map(sorted);
        if let Some(&facet) = nodes.and_then(|key| boundary.facet_of.get(&key)) {
            match facet_group[facet].replace(group) {
                Some(other) if other != group => return Err(two([other, group])),
                _ => {}
            }
        }
    }
    let on_boundary: HashSet<i64> = facet_group.iter().flatten().copied().collect();
    if let Some((&group, triangles)) = surfaces.iter().find(|(g, _)| !on_boundary.contains(g)) {
        let flaw = GmshFlaw::new(
            triangles[0].place,
            "triangles on the boundary of the body",
            format!(
                "none among its {} (triangle {} is the first)",
                triangles.len(),
                triangles[0].tag
            ),
            "the surface lies inside the body or off it; name an outer surface, and check that its volume is in a physical group, or choose groups: python -m contact3d.convert mesh.msh part.msh --sets NAME ...",
        );
        let name = contents.group_name(2, group);
        return Err(flaw.of(format!("physical surface {name:?}")));
    }
    let is_grouped = |group: Result<Option<i64>, _>| group != Ok(None);
    let mut tetrahedra = contents.tetrahedra.iter();
    let named_group = contents.names.iter().find(|((d, _), _)| *d >= 2);
    if let Some((_, name)) = named_group
        && surfaces.is_empty()
        && !tetrahedra.any(|element| is_grouped(contents.group_of(element)))
    {
        return Err(GmshFlaw::new(
            None,
            format!("elements in the physical group {name:?}"),
            "none in any group",
            "MSH 2.2 with Mesh.SaveAll = 1 and some converters lose the groups; save again: gmsh part.geo -3 -format msh41 -o part.msh",
        ));
    }
    if surfaces.is_empty() {
        return Ok(split_at_edges(body, boundary));
    }
    named(contents, 2, &facet_group)
}

/// The part of each boundary triangle, and the names of the parts.
fn split_at_edges(body: &GmshBody, boundary: &GmshBoundary) -> (Vec<usize>, Vec<String>) {
    let area = |facet: &[usize; 3]| {
        let [a, b, c] = facet.map(|node| Vector3::from(body.coordinates[node]));
        (b - a).cross(&(c - a)) / 2.0
    };
    let areas: Vec<Vector3<f64>> = boundary.facets.iter().map(area).collect();
    let mut parts = Pieces::new(areas.len());
    let mut first_at: HashMap<[usize; 2], usize> = HashMap::new();
    for (facet, [a, b, c]) in boundary.facets.iter().enumerate() {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            match first_at.entry([*p.min(q), *p.max(q)]) {
                Entry::Vacant(edge) => {
                    edge.insert(facet);
                }
                Entry::Occupied(other) => {
                    let other = *other.get();
                    if areas[facet].angle(&areas[other]) < EDGE_ANGLE.to_radians() {
                        parts.join(facet, other);
                    }
                }
            }
        }
    }
    let part = parts.firsts();
    let mut sizes = vec![0.0; areas.len()];
    for (area, &part) in areas.iter().zip(&part) {
        sizes[part] += area.norm();
    }
    let mut ranked: Vec<usize> = (0..part.len()).filter(|&f| part[f] == f).collect();
    // Parts that are equal to nine digits keep their order.
    let whole: f64 = sizes.iter().sum();
    ranked.sort_by_key(|&part| Reverse((1e9 * sizes[part] / whole).round() as u64));
    let mut number = vec![0; areas.len()];
    for (place, &part) in ranked.iter().enumerate() {
        number[part] = place;
    }
    let names = (1..=ranked.len()).map(|n| format!("face_{n}"));
    (
        part.iter().map(|&part| number[part]).collect(),
        names.collect(),
    )
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
