//! Which region each tetrahedron belongs to.

use super::RawMesh;
use crate::scene::{Invalid, Part, Scene, Written};

/// The region of each tetrahedron: 0, or k for the last region k of the scene that holds it; empty
/// in a scene without regions.
pub(super) fn assign(scene: &Scene, mesh: &RawMesh) -> Result<Vec<usize>, Invalid> {
    if scene.regions.is_empty() {
        return Ok(Vec::new());
    }
    let mut assigned = vec![0; mesh.tetrahedra.len()];
    for (i, region) in scene.regions.iter().enumerate() {
        let group = match &region.part {
            Part::Group(name) => mesh.group_names.iter().position(|n| n == name),
            Part::Box(_) => None,
        };
        let holds = |t: usize| match &region.part {
            Part::Group(_) => group.is_some_and(|g| mesh.tetrahedron_group[t] == g),
            Part::Box([low, high]) => {
                let centroid = centroid(mesh, t);
                (0..3).all(|c| low[c] <= centroid[c] && centroid[c] <= high[c])
            }
        };
        let mut found = false;
        for t in (0..assigned.len()).filter(|&t| holds(t)) {
            assigned[t] = i + 1;
            found = true;
        }
        if !found {
            return Err(empty(i, &region.part, mesh));
        }
    }
    Ok(assigned)
}

fn centroid(mesh: &RawMesh, tetrahedron: usize) -> [f64; 3] {
    let corners = mesh.tetrahedra[tetrahedron].map(|n| mesh.coordinates[n]);
    std::array::from_fn(|c| corners.iter().map(|p| p[c]).sum::<f64>() / 4.0)
}

fn empty(region: usize, part: &Part, mesh: &RawMesh) -> Invalid {
    Invalid {
        key: format!("region.{region}.part"),
        expected: match part {
            Part::Group(_) => format!(
                "one of the mesh's physical volumes: {}",
                mesh.group_names.join(", ")
            ),
            Part::Box(_) => "a box that holds the centroid of at least one tetrahedron".into(),
        },
        found: Written(part).to_string(),
        help: "a region without tetrahedra would have no effect; correct or remove it".into(),
    }
}
