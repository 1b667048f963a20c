//! The contact face as a surface of linear triangles: forms and norms of Y^h.

use std::collections::BTreeMap;

use faer::Mat;
use nalgebra::Vector3;

use super::dense::{DenseFactor, alone, symmetric};
use crate::shared::matrix_of_columns;
use contact3d::{
    contact::ContactFrame,
    elasticity::DofMap,
    linalg::{CholeskyFactor, CscMatrix, Work, amd, dot},
    mesh::{ContactSurface, Mesh, triangle_area},
    scene::{ElementOrder, FrictionModel, InvalidValue, ModelFeatures, Quantity, Scene, Written},
};

/// A flat surface of linear triangles, some of whose nodes are held.
#[derive(Debug, Clone)]
pub(super) struct TriangulatedFace {
    /// Its nodes in m, `[n]`.
    pub(super) points: Vec<[f64; 3]>,
    /// Nodes of each triangle.
    pub(super) triangles: Vec<[usize; 3]>,
    /// The place among the free nodes; `None` where functions of Y^h vanish.
    pub(super) place: Vec<Option<usize>>,
}

/// The mass and the stiffness of scalar functions of Y^h over the free nodes.
pub(super) struct FaceForms {
    /// ∫ φ_i φ_j in m².
    pub(super) mass: CscMatrix,
    /// ∫ ∇φ_i·∇φ_j.
    pub(super) stiffness: CscMatrix,
}

impl TriangulatedFace {
    /// The contact face of a mesh of linear tetrahedra; a node of which one component is free is free.
    pub(super) fn new(mesh: &Mesh, surface: &ContactSurface, dofs: &DofMap) -> Self {
        let local = |node: usize| surface.nodes.partition_point(|&n| n < node);
        let facets = surface.facets.iter();
        Self::with_held(
            surface.nodes.iter().map(|&n| mesh.coordinates[n]).collect(),
            facets.map(|&f| mesh.facets[f].map(local)).collect(),
            |node| dofs.dof[surface.nodes[node]].iter().all(Option::is_none),
        )
    }

    pub(super) fn with_held(
        points: Vec<[f64; 3]>,
        triangles: Vec<[usize; 3]>,
        is_held: impl Fn(usize) -> bool,
    ) -> Self {
        let mut free = 0;
        let place = (0..points.len()).map(|node| {
            (!is_held(node)).then(|| {
                free += 1;
                free - 1
            })
        });
        Self {
            place: place.collect(),
            points,
            triangles,
        }
    }

    /// Number of free nodes, the dimension of Y^h.
    pub(super) fn n_free(&self) -> usize {
        self.place.iter().flatten().count()
    }

    pub(super) fn corners(&self, triangle: usize) -> [[f64; 3]; 3] {
        self.triangles[triangle].map(|node| self.points[node])
    }

    pub(super) fn area(&self, triangle: usize) -> f64 {
        triangle_area(&self.corners(triangle))
    }

    /// h_Γ: the largest diameter of a triangle.
    pub(super) fn size(&self) -> f64 {
        let triangles = self.triangles.iter();
        let edges = triangles.flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let length = |[a, b]: [usize; 2]| distance(self.points[a], self.points[b]);
        edges.map(length).fold(0.0, f64::max)
    }

    /// The triangles around each node.
    pub(super) fn stars(&self) -> Vec<Vec<usize>> {
        let mut stars = vec![Vec::new(); self.points.len()];
        for (t, nodes) in self.triangles.iter().enumerate() {
            nodes.iter().for_each(|&node| stars[node].push(t));
        }
        stars
    }

    /// The nodes at which functions of Y^h need not vanish.
    pub(super) fn free_nodes(&self) -> Vec<usize> {
        let nodes = 0..self.points.len();
        nodes.filter(|&n| self.place[n].is_some()).collect()
    }

    /// ∫ φ_j of the hat functions, `[n]`.
    pub(super) fn lumped(&self) -> Vec<f64> {
        let mut lumped = vec![0.0; self.points.len()];
        for (t, nodes) in self.triangles.iter().enumerate() {
            nodes.iter().for_each(|&n| lumped[n] += self.area(t) / 3.0);
        }
        lumped
    }

    pub(super) fn forms(&self) -> FaceForms {
        let n = self.n_free();
        let (mut mass, mut stiffness) = (ElementSums::new(n), ElementSums::new(n));
        for (t, nodes) in self.triangles.iter().enumerate() {
            let area = self.area(t);
            let gradients = gradients(&self.corners(t));
            for (a, row) in nodes.iter().enumerate() {
                for (b, column) in nodes.iter().enumerate() {
                    let (Some(row), Some(column)) = (self.place[*row], self.place[*column]) else {
                        continue;
                    };
                    mass.add(row, column, area / if a == b { 6.0 } else { 12.0 });
                    stiffness.add(row, column, area * gradients[a].dot(&gradients[b]));
                }
            }
        }
        FaceForms {
            mass: mass.matrix(),
            stiffness: stiffness.matrix(),
        }
    }

    /// The values of a nodal field at the free nodes.
    pub(super) fn to_free(&self, nodal: impl Fn(usize) -> f64) -> Vec<f64> {
        self.free_nodes().into_iter().map(nodal).collect()
    }

    /// M_Γ times each of so many components of a field, `[n][components]`; 0 at held nodes.
    pub(super) fn mass_product(
        &self,
        mass: &CscMatrix,
        values: &[f64],
        components: usize,
    ) -> Vec<f64> {
        let mut image = vec![0.0; values.len()];
        for c in 0..components {
            let free = product(mass, &self.to_free(|node| values[components * node + c]));
            for (node, value) in self.free_nodes().into_iter().zip(free) {
                image[components * node + c] = value;
            }
        }
        image
    }

    /// A pair of functions of Y^h at a point of a triangle, from values at the nodes.
    pub(super) fn mean(&self, nodal: &[[f64; 2]], triangle: usize, shape: &[f64; 3]) -> [f64; 2] {
        let nodes = self.triangles[triangle];
        [0, 1].map(|k| nodes.iter().zip(shape).map(|(n, s)| s * nodal[*n][k]).sum())
    }

    /// The norm of a pair of functions of Y^h in L²(Γ_c), from values at the nodes.
    pub(super) fn norm_of_pair(&self, mass: &CscMatrix, values: &[[f64; 2]]) -> f64 {
        let square = |k: usize| {
            let values = self.to_free(|node| values[node][k]);
            dot(&values, &product(mass, &values))
        };
        (square(0) + square(1)).sqrt()
    }
}

/// Gradients of the barycentric coordinates of a triangle in space.
pub(super) fn gradients(corners: &[[f64; 3]; 3]) -> [Vector3<f64>; 3] {
    let points = corners.map(Vector3::from);
    let normal = (points[1] - points[0]).cross(&(points[2] - points[0]));
    let square = normal.norm_squared();
    [0, 1, 2].map(|k| normal.cross(&(points[(k + 2) % 3] - points[(k + 1) % 3])) / square)
}

pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (Vector3::from(a) - Vector3::from(b)).norm()
}

/// Sums of element contributions, column by column.
pub(super) struct ElementSums(Vec<BTreeMap<usize, f64>>);

impl ElementSums {
    pub(super) fn new(size: usize) -> Self {
        Self(vec![BTreeMap::new(); size])
    }

    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        *self.0[column].entry(row).or_insert(0.0) += value;
    }

    pub(super) fn matrix(self) -> CscMatrix {
        matrix_of_columns(self.0.len(), self.0)
    }
}

/// A + B of two matrices with the same pattern.
pub(super) fn sum(first: &CscMatrix, second: &CscMatrix) -> CscMatrix {
    let pairs = first.data.iter().zip(&second.data);
    CscMatrix {
        data: pairs.map(|(a, b)| a + b).collect(),
        ..first.clone()
    }
}

/// M x of a symmetric matrix.
pub(super) fn product(matrix: &CscMatrix, x: &[f64]) -> Vec<f64> {
    let mut image = vec![0.0; matrix.cols];
    matrix.mul_transposed(x, &mut image);
    image
}

/// The Cholesky factor of a symmetric positive definite matrix in a fill-reducing order; `None` where it has none.
pub(super) fn factorised(matrix: &CscMatrix) -> Option<CholeskyFactor> {
    CholeskyFactor::factorise(matrix, amd(matrix).ok()?).ok()
}

/// Refuses what HKL §2 and §3 do not cover.
pub(super) fn require_covered(scene: &Scene) -> Result<(), InvalidValue> {
    scene.require_no_history("the theory")?;
    let faces = ModelFeatures::of(scene).contact;
    if faces.len() > 1 {
        return Err(InvalidValue {
            key: "contact".into(),
            expected: "one contact face, as in HKL section 2".into(),
            found: format!("{} faces", faces.len()),
            help: "the norms and constants of HKL section 3 belong to one flat face with one law; leave the others out"
                .into(),
        });
    }
    let law = faces.first().map(|face| face.friction.as_ref());
    let follows_pressure = |law: &FrictionModel| law.bound.follows_pressure();
    if !law.flatten().is_some_and(follows_pressure) {
        return Err(InvalidValue {
            key: "friction".into(),
            expected: "Coulomb friction on a contact face".into(),
            found: law.map_or("no contact", FrictionModel::word).into(),
            help: "other scenes are one minimisation: their solution is unique, and there is no mapping to study".into(),
        });
    }
    let obstacle = faces.first().and_then(|face| face.obstacle.as_ref());
    if let Some(obstacle) = obstacle {
        return Err(InvalidValue {
            key: "contact.obstacle".into(),
            expected: "no obstacle, as in HKL section 2".into(),
            found: obstacle.word().into(),
            help: "there the contact face is flat and touches its foundation everywhere at first; leave the obstacle out".into(),
        });
    }
    let gap = faces.first().and_then(|face| face.gap.clone());
    if let Some(gap) = gap {
        return Err(InvalidValue {
            key: "contact.gap".into(),
            expected: "no gap, as in HKL section 2".into(),
            found: match gap {
                Quantity::Constant(value) => Written(&value).to_string(),
                _ => "a gap that varies".into(),
            },
            help:
                "the radii of Lemma 3.3 compare u with 0 and 2u, which a gap excludes; set it to 0"
                    .into(),
        });
    }
    if scene.body.element == ElementOrder::P2 {
        return Err(InvalidValue {
            key: "body.element".into(),
            expected: "\"P1\"".into(),
            found: "\"P2\"".into(),
            help: "quadratic interpolation does not preserve signs, which HKL (3.2) asks for"
                .into(),
        });
    }
    Ok(())
}

/// The Gram matrix E X⁻¹ Eᵀ of the displacements (u_ν, u_t1, u_t2) at the contact nodes for a norm ‖v‖² = vᵀXv of V^h:
/// for nodal forces f on the face fᵀ E X⁻¹ Eᵀ f = sup (f·v)²/‖v‖². For the energy norm, X = A, it is the compliance of the face.
pub(super) struct FaceGram {
    /// `[3 n_contact_nodes, 3 n_contact_nodes]`; rows of held components vanish.
    matrix: Vec<f64>,
    n_nodes: usize,
}

/// Multipliers in terms of nodal values: row i holds ∫_{Rⁱ} φ_j over contact nodes j.
#[derive(Debug, Clone)]
pub(super) struct PaneIntegrals(pub(super) Vec<Vec<(usize, f64)>>);

impl PaneIntegrals {
    /// The panes of the scene.
    pub(super) fn of_surface(surface: &ContactSurface) -> Self {
        let panes = surface.pane_area.iter().enumerate();
        let row = |(pane, area): (usize, &f64)| {
            let weights = surface.pane_weights(pane);
            weights
                .map(|(node, weight)| (node, weight * area))
                .collect()
        };
        Self(panes.map(row).collect())
    }

    /// Sums of contributions of triangles.
    pub(super) fn of_sums(sums: Vec<BTreeMap<usize, f64>>) -> Self {
        Self(sums.into_iter().map(Vec::from_iter).collect())
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// ∫ 1 over each pane.
    pub(super) fn areas(&self) -> Vec<f64> {
        let rows = self.0.iter();
        rows.map(|row| row.iter().map(|(_, integral)| integral).sum())
            .collect()
    }
}

impl FaceGram {
    /// By half solves with the factor of X on the supernodes that the face reaches.
    pub(super) fn new(
        factor: &CholeskyFactor,
        surface: &ContactSurface,
        frame: &ContactFrame,
        dofs: &DofMap,
    ) -> Self {
        let selection = selection(surface, frame, dofs);
        Self {
            matrix: factor.gram(&selection, &Work::default()),
            n_nodes: surface.nodes.len(),
        }
    }

    pub(super) fn n_nodes(&self) -> usize {
        self.n_nodes
    }

    /// The entry of components c, d (0 for ν, 1 and 2 for the tangents) at two nodes.
    pub(super) fn entry(&self, [a, c]: [usize; 2], [b, d]: [usize; 2]) -> f64 {
        self.matrix[(3 * b + d) * 3 * self.n_nodes + 3 * a + c]
    }

    /// G f for nodal forces in the order of the rows, `[3 n_contact_nodes]`.
    pub(super) fn apply(&self, forces: &[f64]) -> Vec<f64> {
        // Symmetric: each entry is the product of one column.
        let columns = self.matrix.chunks_exact(forces.len().max(1));
        columns.map(|column| dot(column, forces)).collect()
    }

    /// W G_ab Wᵀ for components a and b of displacements.
    fn between(&self, rows: &PaneIntegrals, a: usize, b: usize) -> Mat<f64> {
        let cross = self.cross(rows, a, b);
        Mat::from_fn(rows.len(), rows.len(), |i, j| {
            let row = rows.0[j].iter();
            row.map(|&(node, integral)| integral * cross[(i, node)])
                .sum()
        })
    }

    /// W G_ab, `[m, n_contact_nodes]`.
    fn cross(&self, rows: &PaneIntegrals, a: usize, b: usize) -> Mat<f64> {
        Mat::from_fn(rows.len(), self.n_nodes, |i, node| {
            let row = rows.0[i].iter();
            row.map(|&(other, integral)| integral * self.entry([other, a], [node, b]))
                .sum()
        })
    }

    /// Q = N X⁻¹ Nᵀ: μᵀQμ = sup (μ, v_ν)²/‖v‖² over V^h.
    pub(super) fn normal(&self, rows: &PaneIntegrals) -> Mat<f64> {
        symmetric(self.between(rows, 0, 0))
    }

    /// The same over V₀^h, the displacements without tangential part on Γ_c, which is what the proofs of HKL Lemma 3.3 and
    /// Proposition 3.1 need. It is Q where X does not couple components and all are held on the same nodes, as in
    /// H¹(Ω)³; in the energy norm it is smaller. `None` where the tangential block is singular.
    pub(super) fn normal_glued(&self, rows: &PaneIntegrals) -> Option<Mat<f64>> {
        let moving: Vec<[usize; 2]> = (0..self.n_nodes)
            .flat_map(|node| [[node, 1], [node, 2]])
            .filter(|&at| self.entry(at, at) > 0.0)
            .collect();
        let n = moving.len();
        let block = Mat::from_fn(n, n, |i, j| self.entry(moving[i], moving[j]));
        let parts = [1, 2].map(|b| self.cross(rows, 0, b));
        let cross = Mat::from_fn(n, rows.len(), |i, pane| {
            let [node, component] = moving[i];
            parts[component - 1][(pane, node)]
        });
        let solved = DenseFactor::new(&block)?.solve(&cross);
        Some(symmetric(alone(|| {
            self.normal(rows) - cross.transpose() * &solved
        })))
    }

    /// The compliance of the tangential displacements by the multipliers of a scene with friction, column-major,
    /// `[2 n_contact_nodes, 3 m]`: u_t1 and u_t2 node by node, against m normal multipliers, then m pairs.
    pub(super) fn tangential_by_multipliers(&self, rows: &PaneIntegrals) -> Mat<f64> {
        let m = rows.len();
        let parts: Vec<[Mat<f64>; 2]> = (0..3)
            .map(|a| [1, 2].map(|b| self.cross(rows, a, b)))
            .collect();
        Mat::from_fn(2 * self.n_nodes, 3 * m, |row, column| {
            let (pane, component) = match column.checked_sub(m) {
                None => (column, 0),
                Some(pair) => (pair / 2, 1 + pair % 2),
            };
            parts[component][row % 2][(pane, row / 2)]
        })
    }
}

/// E: rows u_ν, u_t1, u_t2 of contact node after contact node, `[3 n_contact_nodes, n_free]`.
fn selection(surface: &ContactSurface, frame: &ContactFrame, dofs: &DofMap) -> CscMatrix {
    let nodes = surface.nodes.iter().enumerate();
    let columns = nodes.flat_map(|(local, &node)| {
        let [first, second] = *frame.axes_at(local);
        [frame.normal_at(local), first, second].map(|axis| {
            let entries = dofs.dof[node].iter().zip(axis);
            let entries = entries.filter(|(_, direction)| *direction != 0.0);
            entries.filter_map(|(dof, direction)| Some(((*dof)?, direction)))
        })
    });
    matrix_of_columns(dofs.n_free, columns).transpose()
}
