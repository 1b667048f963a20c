//! Triangles of a mesh file as a rigid surface.

use std::collections::{HashMap, hash_map::Entry};

use nalgebra::Vector3;

use super::{
    contents::{Contents, MeshElement, listed_nodes},
    scanner::GmshFlaw,
    sections,
};
use crate::mesh::sorted;

/// The triangles of a physical surface, or of the whole file, in its unit: no normal, then the corners. Each of the second order is four.
/// They go counter-clockwise as seen from outside the tetrahedra that have them as a side, else as they stand in the file.
///
/// # Errors
/// The first flaw found; a surface that the file does not have.
pub(in crate::mesh) fn triangles(
    bytes: &[u8],
    face: Option<&str>,
) -> Result<Vec<[Vector3<f64>; 4]>, GmshFlaw> {
    let contents = sections::read(bytes)?;
    let names = |element: &MeshElement<3>| {
        let groups = contents.memberships[element.membership].iter();
        groups.map(|tag| contents.group_name(2, *tag))
    };
    let is_in =
        |element: &&MeshElement<3>| face.is_none_or(|face| names(element).any(|name| name == face));
    let chosen: Vec<&MeshElement<3>> = contents.triangles.iter().filter(is_in).collect();
    if chosen.is_empty() {
        let mut known: Vec<String> = contents.triangles.iter().flat_map(names).collect();
        known.sort_unstable();
        known.dedup();
        return Err(GmshFlaw::new(
            None,
            format!("one of the physical surfaces: {}", known.join(", ")),
            face.map_or("no triangles".into(), |face| format!("face = {face:?}")),
            "mesh the surface (gmsh -2); where there are physical groups, Gmsh saves only what is in them",
        ));
    }
    let place = |node: usize| Vector3::from(contents.coordinates[node]);
    let placed = outward(&contents, &chosen)?.into_iter().map(|corners| {
        let [a, b, c] = corners.map(place);
        [Vector3::zeros(), a, b, c]
    });
    Ok(placed.collect())
}

/// The nodes of the triangles, or of their quarters where they have middles, turned outward.
fn outward(contents: &Contents, chosen: &[&MeshElement<3>]) -> Result<Vec<[usize; 3]>, GmshFlaw> {
    let mut number = HashMap::new();
    let mut parts = Vec::new();
    for element in chosen {
        let [a, b, c] = listed_nodes(contents, element, &element.nodes)?;
        // A triangle in several groups stands in several lines of MSH 2.2.
        let Entry::Vacant(new) = number.entry(sorted([a, b, c])) else {
            continue;
        };
        new.insert(parts.len());
        parts.push(match contents.middles_of_triangles.get(&element.tag) {
            None => vec![[a, b, c]],
            Some(tags) => {
                let [ab, bc, ca] = listed_nodes(contents, element, tags)?;
                vec![[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            }
        });
    }
    // How many tetrahedra lie behind each triangle, less those before it.
    let mut behind = vec![0; parts.len()];
    let place = |node: usize| Vector3::from(contents.coordinates[node]);
    for element in &contents.tetrahedra {
        let nodes = listed_nodes(contents, element, &element.nodes)?;
        for (k, opposite) in nodes.into_iter().enumerate() {
            let side = [1, 2, 3].map(|other| nodes[(k + other) % 4]);
            if let Some(&triangle) = number.get(&sorted(side)) {
                let [a, b, c] = parts[triangle][0].map(place);
                let height = (b - a).cross(&(c - a)).dot(&(place(opposite) - a));
                behind[triangle] += if height > 0.0 { -1 } else { 1 };
            }
        }
    }
    for (parts, _) in parts
        .iter_mut()
        .zip(behind)
        .filter(|(_, behind)| *behind < 0)
    {
        parts.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    Ok(parts.into_iter().flatten().collect())
}
