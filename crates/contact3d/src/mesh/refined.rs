//! Meshes that are finer where it was asked for: the first mesh of a scene, cut level by level.

use std::{borrow::Cow, path::Path};

use super::{
    IsoparametricMap, Mesh, MeshError, MidEdgeNodes, RawMesh,
    bisection::{Bisection, Descendant},
    obstacle, side,
};
use crate::scene::Scene;

/// How a mesh comes from the one before; a list of such levels is how it comes from the first one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RefinedLevel {
    /// The brick is meshed anew with so many graded cells; see [`Scene::with_graded_cells`].
    Cells([usize; 3]),
    /// Each tetrahedron of the mesh before is cut in two so often, `[n_tetrahedra]`.
    Cuts(Vec<u8>),
}

/// A body whose tetrahedra can be cut.
///
/// Faces, regions and curved sides are those of the first mesh: a child lies in the region of its
/// parent and on its faces, and where sides are curved the nodes of a child are places of its
/// ancestor's map, so that the body keeps its shape.
#[derive(Debug)]
pub struct RefinableBody<'a> {
    scene: Cow<'a, Scene>,
    first: RawMesh,
    /// Region of each tetrahedron of the first mesh; empty without regions.
    regions: Vec<usize>,
    bisection: Bisection,
    is_cut: bool,
}

impl<'a> RefinableBody<'a> {
    /// The first mesh of a scene; mesh files are looked for in `folder`.
    ///
    /// # Errors
    /// As [`Mesh::of_scene`].
    pub fn new(scene: &'a Scene, folder: &Path) -> Result<Self, MeshError> {
        Self::of(Cow::Borrowed(scene), folder)
    }

    fn of(scene: Cow<'a, Scene>, folder: &Path) -> Result<Self, MeshError> {
        let first = RawMesh::of_scene(&scene, folder)?;
        Ok(Self {
            regions: side::assign(&scene, &first)?,
            scene,
            bisection: Bisection::new(&first.corner_mesh()),
            first,
            is_cut: false,
        })
    }

    /// The body after all levels beyond the first mesh.
    ///
    /// # Errors
    /// As [`Mesh::of_scene`].
    pub fn refined(
        scene: &'a Scene,
        folder: &Path,
        refinement: &[RefinedLevel],
    ) -> Result<Self, MeshError> {
        let mut meshed = Cow::Borrowed(scene);
        let mut cuts: Vec<&[u8]> = Vec::new();
        for level in refinement {
            match level {
                RefinedLevel::Cells(cells) => {
                    meshed = Cow::Owned(scene.clone().with_graded_cells(*cells));
                    cuts.clear();
                }
                RefinedLevel::Cuts(of_level) => cuts.push(of_level),
            }
        }
        let mut body = Self::of(meshed, folder)?;
        for cuts in cuts {
            body.refine(cuts);
        }
        Ok(body)
    }

    /// Cuts each tetrahedron at least as often as asked, `[n_tetrahedra]`, and others as far as the
    /// mesh needs it to stay conforming.
    pub fn refine(&mut self, cuts: &[u8]) {
        self.bisection.refine(cuts);
        self.is_cut = true;
    }

    /// Number of tetrahedra.
    #[must_use]
    pub fn n_tetrahedra(&self) -> usize {
        self.bisection.n_tetrahedra()
    }

    /// The tetrahedron, in the mesh before the last refinement, that each tetrahedron lies in.
    #[must_use]
    pub fn parents(&self) -> Vec<usize> {
        self.bisection.descendants().map(|d| d.parent).collect()
    }

    /// Where each tetrahedron lies in the first mesh, `[n_tetrahedra]`.
    #[must_use]
    pub fn descendants(&self) -> Vec<Descendant> {
        self.bisection.descendants().collect()
    }

    /// The mesh as it is now.
    ///
    /// # Errors
    /// As [`Mesh::of_scene`].
    pub fn mesh(&self) -> Result<Mesh, MeshError> {
        if !self.is_cut {
            return Mesh::new(&self.scene, self.first.clone(), self.regions.clone(), None);
        }
        let raw = self.curved(self.bisection.mesh(&self.first));
        let ancestors: Vec<usize> = self.bisection.descendants().map(|d| d.ancestor).collect();
        let raw = raw.by_bodies(&self.first.bodies, &ancestors);
        let region = |d: Descendant| self.regions.get(d.ancestor).copied();
        let regions = self.bisection.descendants().filter_map(region).collect();
        let faceting = self.faceting()?;
        Mesh::new(&self.scene, raw, regions, Some(faceting))
    }

    /// What the first mesh leaves of contact faces before obstacles or other bodies at most, in m.
    fn faceting(&self) -> Result<f64, MeshError> {
        let contacts = self.scene.contacts.iter().enumerate();
        let mut curved = contacts
            .filter(|(_, contact)| contact.obstacle.is_some() || contact.between.is_some())
            .peekable();
        if curved.peek().is_none() {
            return Ok(0.0);
        }
        let first = Mesh::without_contact(&self.scene, self.first.clone(), Vec::new())?;
        curved.try_fold(0.0, |most: f64, (entry, contact)| {
            let left = |facets: &[usize]| obstacle::faceting(&first, facets, |_| 1.0);
            if let Some(pair) = &contact.between {
                let of_faces = pair.each_ref().map(|name| {
                    let facets: Vec<usize> = first.facets_on(name).collect();
                    left(&facets)
                });
                return Ok(most.max(of_faces.iter().sum()));
            }
            let facets = first.contact_facets(&self.scene, entry)?;
            Ok(most.max(left(&facets)))
        })
    }

    /// Moves the nodes of a mesh to the curved sides of the first one, with nodes in the middle of
    /// its edges, where the first mesh has such nodes.
    fn curved(&self, straight: RawMesh) -> RawMesh {
        let Some(first) = &self.first.mid_edges else {
            return straight;
        };
        let n_corners = straight.coordinates.len();
        let (middles, edges) =
            MidEdgeNodes::number(n_corners, &straight.tetrahedra, &straight.facets);
        let mut place: Vec<Option<[f64; 3]>> = vec![None; n_corners + edges.len()];
        let tetrahedra = straight.tetrahedra.iter().zip(&middles.tetrahedra);
        for (descendant, (corners, middles)) in self.bisection.descendants().zip(tetrahedra) {
            let at = |node: usize| self.first.coordinates[node];
            let ancestor = self.first.tetrahedra[descendant.ancestor].map(at);
            let map = IsoparametricMap::new(&ancestor, &first[descendant.ancestor].map(at));
            for (node, inside) in corners.iter().chain(middles).zip(descendant.nodes()) {
                place[*node].get_or_insert_with(|| map.place(&inside));
            }
        }
        RawMesh {
            coordinates: place.into_iter().flatten().collect(),
            mid_edges: Some(middles.tetrahedra),
            ..straight
        }
    }
}

impl Mesh {
    /// The mesh of a scene after a refinement; mesh files are looked for in `folder`.
    ///
    /// # Errors
    /// As [`Mesh::of_scene`].
    pub fn refined(
        scene: &Scene,
        folder: &Path,
        refinement: &[RefinedLevel],
    ) -> Result<Self, MeshError> {
        if refinement.is_empty() {
            Self::of_scene(scene, folder)
        } else {
            RefinableBody::refined(scene, folder, refinement)?.mesh()
        }
    }
}

impl RawMesh {
    /// The corners of the tetrahedra alone, numbered in the same order, without nodes in the middle
    /// of edges.
    fn corner_mesh(&self) -> Self {
        let mut is_corner = vec![false; self.coordinates.len()];
        for node in self.tetrahedra.iter().flatten() {
            is_corner[*node] = true;
        }
        let mut number = vec![0; self.coordinates.len()];
        let mut coordinates = Vec::new();
        for node in (0..number.len()).filter(|node| is_corner[*node]) {
            number[node] = coordinates.len();
            coordinates.push(self.coordinates[node]);
        }
        Self {
            coordinates,
            tetrahedra: self
                .tetrahedra
                .iter()
                .map(|t| t.map(|n| number[n]))
                .collect(),
            facets: self.facets.iter().map(|f| f.map(|n| number[n])).collect(),
            mid_edges: None,
            ..self.clone()
        }
    }
}
