//! Several bodies as the components of one mesh.

use std::{ops::Range, path::Path};

use super::{Mesh, MeshError, MidEdgeNodes, RawMesh, brick, gmsh};
use crate::scene::{BrickFace, Contact, ElementOrder, MultiplierSpace, Scene};

/// Where a body lies in the mesh of several.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BodyRange {
    /// Its name.
    pub name: String,
    /// Its nodes.
    pub nodes: Range<usize>,
    /// Its tetrahedra.
    pub tetrahedra: Range<usize>,
}

impl Mesh {
    /// Some of several bodies alone as one, without contact.
    #[must_use]
    pub fn of_bodies(&self, bodies: &[usize]) -> Self {
        let ranges = || bodies.iter().map(|body| &self.bodies[*body]);
        let mut number = vec![None; self.coordinates.len()];
        let nodes: Vec<usize> = ranges().flat_map(|range| range.nodes.clone()).collect();
        for (place, node) in nodes.iter().enumerate() {
            number[*node] = Some(place);
        }
        let tetrahedra: Vec<usize> = ranges().flat_map(|it| it.tetrahedra.clone()).collect();
        let is_own = |facet: &usize| number[self.facets[*facet][0]].is_some();
        let facets: Vec<usize> = (0..self.facets.len()).filter(is_own).collect();
        let region = |t: &usize| self.tetrahedron_region.get(*t).copied();
        Self {
            coordinates: nodes.iter().map(|node| self.coordinates[*node]).collect(),
            tetrahedra: chosen(&self.tetrahedra, &tetrahedra, &number),
            tetrahedron_region: tetrahedra.iter().filter_map(region).collect(),
            facets: chosen(&self.facets, &facets, &number),
            facet_face: facets.iter().map(|&f| self.facet_face[f]).collect(),
            face_names: self.face_names.clone(),
            mid_edges: self.mid_edges.as_ref().map(|middles| MidEdgeNodes {
                tetrahedra: chosen(&middles.tetrahedra, &tetrahedra, &number),
                facets: chosen(&middles.facets, &facets, &number),
            }),
            ..Self::default()
        }
    }
}

/// Some simplices with the new numbers of their nodes, which all have one.
fn chosen<const K: usize>(
    simplices: &[[usize; K]],
    chosen: &[usize],
    number: &[Option<usize>],
) -> Vec<[usize; K]> {
    let simplices = chosen.iter().map(|place| simplices[*place]);
    let simplices = simplices.map(|nodes| nodes.map(|node| number[node].unwrap_or_default()));
    simplices.collect()
}

impl RawMesh {
    /// The bodies of a scene, one after the other.
    ///
    /// # Errors
    /// An unusable mesh file.
    pub(super) fn of_bodies(scene: &Scene, folder: &Path) -> Result<Self, MeshError> {
        let several = scene.bodies.len() > 1;
        let mut joined = Self::default();
        for body in 0..scene.bodies.len() {
            let mut raw = Self::of_body(scene, body, folder)?;
            if !several {
                return Ok(raw);
            }
            if scene.element() == ElementOrder::P2 && raw.mid_edges.is_none() {
                let (corners, facets) = (&raw.tetrahedra, &raw.facets);
                let middles = MidEdgeNodes::add_straight(&mut raw.coordinates, corners, facets);
                raw.mid_edges = Some(middles.tetrahedra);
            }
            joined.append(raw, scene.body_name(body), scene.bodies[body].origin);
        }
        Ok(joined)
    }

    fn of_body(scene: &Scene, body: usize, folder: &Path) -> Result<Self, MeshError> {
        let given = &scene.bodies[body];
        let Some(spec) = &given.brick else {
            let file = given.gmsh.as_ref().expect("a body");
            return Ok(gmsh::read(file, folder)?);
        };
        // The diagonals of cells are those that panes ask for; faces with panes agree on them.
        let on_body = |contact: &Contact| {
            let faces = contact.faces().into_iter();
            let mut faces = faces.filter_map(|face| face.strip_prefix(&scene.face_prefix(body)));
            faces.find_map(BrickFace::named)
        };
        let with_panes = |c: &&Contact| c.multipliers == MultiplierSpace::Panes;
        let touching = || scene.contacts.iter().filter(|contact| !contact.glued);
        let panes = touching().filter(with_panes).find_map(on_body);
        let face = panes.or_else(|| touching().find_map(on_body));
        Ok(brick(spec, face))
    }

    /// A mesh that was cut with the nodes of each body one after the other, as in the first mesh with `first` bodies; `ancestors` are the
    /// tetrahedra of that one that each lies in, in their order.
    pub(super) fn by_bodies(self, first: &[BodyRange], ancestors: &[usize]) -> Self {
        if first.is_empty() {
            return self;
        }
        let body_of = |ancestor: usize| first.partition_point(|b| b.tetrahedra.end <= ancestor);
        let mut of_node = vec![0; self.coordinates.len()];
        for (t, ancestor) in ancestors.iter().enumerate() {
            let middles = self.mid_edges.iter().flat_map(|middles| middles[t]);
            for node in self.tetrahedra[t].into_iter().chain(middles) {
                of_node[node] = body_of(*ancestor);
            }
        }
        let mut order: Vec<usize> = (0..of_node.len()).collect();
        order.sort_by_key(|node| of_node[*node]);
        let mut number = vec![0; order.len()];
        for (place, node) in order.iter().enumerate() {
            number[*node] = place;
        }
        let renamed = |nodes: &[usize; 3]| nodes.map(|node| number[node]);
        let ranges = first.iter().enumerate().map(|(body, range)| BodyRange {
            name: range.name.clone(),
            nodes: order.partition_point(|node| of_node[*node] < body)
                ..order.partition_point(|node| of_node[*node] <= body),
            tetrahedra: ancestors.partition_point(|at| body_of(*at) < body)
                ..ancestors.partition_point(|at| body_of(*at) <= body),
        });
        let middles = self.mid_edges.iter();
        let middles = middles.map(|all| all.iter().map(|at| at.map(|node| number[node])).collect());
        Self {
            bodies: ranges.collect(),
            coordinates: order.iter().map(|node| self.coordinates[*node]).collect(),
            tetrahedra: (self.tetrahedra.iter().map(|at| at.map(|node| number[node]))).collect(),
            facets: self.facets.iter().map(renamed).collect(),
            mid_edges: middles.into_iter().next(),
            ..self
        }
    }

    /// Adds another body, whose faces get its name and whose coordinates count from `origin` in m.
    pub(super) fn append(&mut self, body: Self, name: String, origin: [f64; 3]) {
        let (nodes, tetrahedra) = (self.coordinates.len(), self.tetrahedra.len());
        let (groups, faces) = (self.group_names.len(), self.face_names.len());
        let places = body.coordinates.iter();
        self.coordinates
            .extend(places.map(|x| std::array::from_fn(|c| x[c] + origin[c])));
        let moved = |at: &[usize; 4]| at.map(|node| node + nodes);
        self.tetrahedra.extend(body.tetrahedra.iter().map(moved));
        // A brick has no groups.
        let own = body.tetrahedron_group.iter().map(|group| group + groups);
        self.tetrahedron_group.extend(own);
        self.tetrahedron_group
            .resize(self.tetrahedra.len(), usize::MAX);
        let named = |own: &String| format!("{name}.{own}");
        self.group_names.extend(body.group_names.iter().map(named));
        let facets = body.facets.iter();
        self.facets
            .extend(facets.map(|at| at.map(|node| node + nodes)));
        self.facet_face
            .extend(body.facet_face.iter().map(|face| face + faces));
        self.face_names.extend(body.face_names.iter().map(named));
        if let Some(own) = body.mid_edges {
            let middles = self.mid_edges.get_or_insert_default();
            middles.extend(own.iter().map(|at| at.map(|node| node + nodes)));
        }
        self.bodies.push(BodyRange {
            name,
            nodes: nodes..self.coordinates.len(),
            tetrahedra: tetrahedra..self.tetrahedra.len(),
        });
    }
}
