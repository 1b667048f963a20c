//! Panes and nodal multipliers as cells that pictures can fill.

use std::collections::BTreeMap;

use contact3d::mesh::{ContactSurface, Mesh, SurfaceFace};

/// The contact face cut in drawable cells: panes, or with nodal multipliers the median cells of
/// the nodes, whose triangles meet at edge midpoints and centroids; with quadratic triangles those around the middles of edges.
pub(super) struct ContactCells {
    /// Mesh nodes, then the added points.
    pub(super) coordinates: Vec<[f64; 3]>,
    /// Mesh nodes whose mean each added point is; three or two.
    parents: Vec<Vec<usize>>,
    pub(super) triangles: Vec<[usize; 3]>,
    /// Cell of each triangle.
    pub(super) pane: Vec<usize>,
    /// Number of cells that carry multipliers; cells of held nodes come after them.
    pub(super) carrying: usize,
    cells: usize,
}

impl ContactCells {
    /// Cuts a contact face; no cells without contact.
    pub(super) fn new(mesh: &Mesh, face: Option<(&ContactSurface, &SurfaceFace)>) -> Self {
        let mut cells = Self {
            coordinates: mesh.coordinates.clone(),
            parents: Vec::new(),
            triangles: Vec::new(),
            pane: Vec::new(),
            carrying: 0,
            cells: 0,
        };
        let Some((surface, face)) = face else {
            return cells;
        };
        let panes = face.facets.clone();
        cells.pane = panes
            .filter_map(|place| Some(surface.pane_of_facet(place)? - face.panes.start))
            .collect();
        cells.carrying = face.panes.len();
        cells.cells = face.panes.len();
        let facets = surface.facets[face.facets.clone()].iter();
        let triangles = facets.clone().map(|&f| mesh.facets[f]);
        if !face.is_nodal {
            cells.triangles = triangles.collect();
            return cells;
        }
        let cell_of_node = cells.of_nodes(surface, face);
        match &mesh.mid_edges {
            None => cells.cut_at_medians(&cell_of_node, triangles),
            Some(middles) => {
                let middles = facets.map(|&f| middles.facets[f]);
                cells.cut_at_centroids(&cell_of_node, triangles.zip(middles));
            }
        }
        cells
    }

    /// The cell of each node of a face; nodes without a multiplier have cells after the others.
    fn of_nodes(&mut self, surface: &ContactSurface, face: &SurfaceFace) -> BTreeMap<usize, usize> {
        let mut cell_of_node: BTreeMap<usize, usize> = face
            .panes
            .clone()
            .flat_map(|pane| {
                let cell = pane - face.panes.start;
                surface
                    .pane_weights(pane)
                    .map(move |(local, _)| (local, cell))
            })
            .map(|(local, cell)| (surface.nodes[local], cell))
            .collect();
        for &node in &surface.nodes[face.nodes.clone()] {
            let next = self.cells;
            let cell = *cell_of_node.entry(node).or_insert(next);
            self.cells = self.cells.max(cell + 1);
        }
        cell_of_node
    }

    /// Quadratic triangles, whose multipliers are in the middle of edges: what lies between an edge and the centroid.
    fn cut_at_centroids(
        &mut self,
        cell_of_node: &BTreeMap<usize, usize>,
        triangles: impl Iterator<Item = ([usize; 3], [usize; 3])>,
    ) {
        for (corners, middles) in triangles {
            let centre = self.add_mean(corners.to_vec());
            for (k, middle) in middles.into_iter().enumerate() {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                self.triangles.push([a, b, centre]);
                self.pane.push(cell_of_node[&middle]);
            }
        }
    }

    fn cut_at_medians(
        &mut self,
        cell_of_node: &BTreeMap<usize, usize>,
        triangles: impl Iterator<Item = [usize; 3]>,
    ) {
        let mut midpoints: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        for nodes in triangles {
            let centre = self.add_mean(nodes.to_vec());
            for k in 0..3 {
                let (a, b) = (nodes[k], nodes[(k + 1) % 3]);
                let edge = [a.min(b), a.max(b)];
                let middle = match midpoints.get(&edge) {
                    Some(&middle) => middle,
                    None => self.add_mean(edge.to_vec()),
                };
                midpoints.insert(edge, middle);
                self.triangles
                    .extend([[a, middle, centre], [middle, b, centre]]);
                self.pane.extend([cell_of_node[&a], cell_of_node[&b]]);
            }
        }
    }

    fn add_mean(&mut self, nodes: Vec<usize>) -> usize {
        let point = mean(&nodes, &self.coordinates);
        self.coordinates.push(point);
        self.parents.push(nodes);
        self.coordinates.len() - 1
    }

    /// A nodal field on mesh nodes and added points.
    pub(super) fn interpolate<const K: usize>(&self, nodal: &[[f64; K]]) -> Vec<[f64; K]> {
        let mut field = nodal.to_vec();
        field.extend(self.parents.iter().map(|nodes| mean(nodes, nodal)));
        field
    }

    /// A value for every cell: of the multiplier it carries, or `otherwise`.
    pub(super) fn of_cells<T, V: Clone>(
        &self,
        panes: &[T],
        otherwise: &V,
        value: impl Fn(&T) -> V,
    ) -> Vec<V> {
        let mut values: Vec<V> = panes.iter().map(value).collect();
        values.resize(values.len() + self.cells - self.carrying, otherwise.clone());
        values
    }
}

fn mean<const K: usize>(nodes: &[usize], field: &[[f64; K]]) -> [f64; K] {
    std::array::from_fn(|c| nodes.iter().map(|&n| field[n][c]).sum::<f64>() / nodes.len() as f64)
}
