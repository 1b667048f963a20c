//! Which contact triangles and triangles of other bodies face each other.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;

use crate::mesh::{ContactSurface, Mesh};

/// Triangles of two bodies that may lie opposite each other: those of panes, and those whose nodes have parts of these panes.
#[derive(Debug)]
pub(super) struct Facing<'a> {
    mesh: &'a Mesh,
    /// The places of the contact triangles that may lie opposite each boundary triangle, `[n_facets]`.
    places: Vec<Vec<usize>>,
    /// The boundary triangles that may lie opposite each contact triangle, `[n_contact_facets]`.
    facets: Vec<Vec<usize>>,
}

impl<'a> Facing<'a> {
    pub(super) fn new(mesh: &'a Mesh) -> Self {
        let n_places = mesh.contact.as_ref().map_or(0, |it| it.facets.len());
        let mut found = Self {
            mesh,
            places: vec![Vec::new(); mesh.facets.len()],
            facets: vec![Vec::new(); n_places],
        };
        let touching = mesh.contact.as_ref().filter(|it| it.opposite.is_some());
        if let Some(surface) = touching {
            found.find(surface);
        }
        found
    }

    fn find(&mut self, surface: &ContactSurface) {
        let mut triangles_of: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for place in 0..surface.facets.len() {
            if let Some(pane) = surface.pane_of_facet(place) {
                triangles_of.entry(pane).or_default().push(place);
            }
        }
        for face in &surface.faces {
            let mut panes_at: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
            for pane in face.panes.clone() {
                for (_, node, _) in surface.products(pane) {
                    panes_at.entry(*node).or_default().insert(pane);
                }
            }
            for facet in 0..self.mesh.facets.len() {
                let nodes = || self.mesh.facet_nodes(facet);
                // Other sides of the body have nodes off the face.
                if nodes().any(|node| !panes_at.contains_key(&node)) {
                    continue;
                }
                let panes: BTreeSet<usize> = nodes().flat_map(|k| &panes_at[&k]).copied().collect();
                for &place in panes.iter().flat_map(|pane| &triangles_of[pane]) {
                    self.places[facet].push(place);
                    self.facets[place].push(facet);
                }
            }
        }
    }

    /// The contact triangle of another body that a point of a boundary triangle lies opposite of along its normal, with the point's
    /// barycentric coordinates there.
    pub(super) fn across(&self, facet: usize, at: [f64; 3]) -> Option<(usize, [f64; 3])> {
        let surface = self.mesh.contact.as_ref()?;
        let places = self.places[facet].iter();
        let seen = places.map(|&place| (place, seen_in(self.mesh, surface.facets[place], at)));
        let inside = seen.filter(|(_, share)| is_inside(share));
        inside.max_by(|a, b| least(&a.1).total_cmp(&least(&b.1)))
    }

    /// Whether another body lies opposite a point of a contact triangle of a face that touches one.
    pub(super) fn is_covered(&self, place: usize, at: [f64; 3]) -> bool {
        let mut facets = self.facets[place].iter();
        facets.any(|&facet| is_inside(&seen_in(self.mesh, facet, at)))
    }
}

/// The barycentric coordinates where the line along the normal of a boundary triangle through a place meets it.
pub(super) fn seen_in(mesh: &Mesh, facet: usize, at: [f64; 3]) -> [f64; 3] {
    let corners = mesh.corners(&mesh.facets[facet]);
    let [a, b, c] = corners.map(Vector3::from);
    let x = Vector3::from(at);
    let normal = (b - a).cross(&(c - a));
    let part = |from: Vector3<f64>, to: Vector3<f64>| {
        (to - from).cross(&(x - from)).dot(&normal) / normal.norm_squared()
    };
    [part(b, c), part(c, a), part(a, b)]
}

/// Least barycentric coordinate of a point opposite a triangle: between normals of curved faces, which turn from one triangle to the next,
/// a hundredth of a triangle would lie opposite none.
const LEAST_INSIDE: f64 = -0.02;

/// Whether a point seen in a triangle lies inside.
pub(super) fn is_inside(share: &[f64; 3]) -> bool {
    least(share) >= LEAST_INSIDE
}

fn least(share: &[f64; 3]) -> f64 {
    share.iter().copied().fold(f64::INFINITY, f64::min)
}
