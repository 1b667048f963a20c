//! Springs on faces: their part of the stiffness, and their forces.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::free_motions::Hold;
use crate::{
    linalg::UNIT_ROUNDING,
    mesh::{Mesh, triangle_area},
    reference::quadrature,
    scene::{InvalidValue, Quantity, Scene, Spring, UNDEFINED, Written, place_words},
};

/// The springs of a scene on a mesh: ∫ φ_a φ_b K over their faces, by pairs of nodes.
///
/// Exact for constant stiffness on straight sides, linear and quadratic; by Gauss points of degree 6 for formulas and on
/// curved sides. Each block is the mirror image of its partner to the last bit.
#[derive(Debug, Clone, PartialEq)]
pub struct SpringMatrix {
    /// The blocks of each node with the others, in N/m, by increasing nodes, `[n_nodes]`.
    rows: Vec<Vec<(usize, Matrix3<f64>)>>,
}

/// A point of a spring's face to integrate at.
pub struct SpringPoint<'a> {
    /// Its place in m.
    pub at: [f64; 3],
    nodes: &'a [usize],
    shape: &'a [f64],
    /// Outward unit normal.
    normal: Vector3<f64>,
    /// Area in m² that the point stands for.
    pub area: f64,
}

impl SpringPoint<'_> {
    /// A field of all nodes, `[n_nodes]`, at the point.
    #[must_use]
    pub fn value(&self, field: &[[f64; 3]]) -> Vector3<f64> {
        let nodes = self.nodes.iter().zip(self.shape);
        nodes.map(|(n, w)| Vector3::from(field[*n]) * *w).sum()
    }
}

impl SpringMatrix {
    /// All springs of a scene; `None` where there are none.
    ///
    /// # Errors
    /// A stiffness that is not finite and positive semidefinite somewhere.
    pub fn of(scene: &Scene, mesh: &Mesh) -> Result<Option<Self>, InvalidValue> {
        if scene.springs.is_empty() {
            Ok(None)
        } else {
            Self::sum(scene.springs.iter().enumerate(), mesh).map(Some)
        }
    }

    /// Some of the springs of a scene, with their places in it.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub(crate) fn sum<'a>(
        springs: impl Iterator<Item = (usize, &'a Spring)>,
        mesh: &Mesh,
    ) -> Result<Self, InvalidValue> {
        let mut blocks: BTreeMap<[usize; 2], Matrix3<f64>> = BTreeMap::new();
        for (index, spring) in springs {
            visit(spring, index, mesh, &mut |point, stiffness| {
                for (i, a) in point.nodes.iter().enumerate() {
                    for (j, b) in point.nodes.iter().enumerate().filter(|(_, b)| a <= b) {
                        let weight = point.area * (point.shape[i] * point.shape[j]);
                        *blocks.entry([*a, *b]).or_default() += stiffness * weight;
                    }
                }
            })?;
        }
        let mut rows = vec![Vec::new(); mesh.coordinates.len()];
        for ([a, b], block) in blocks {
            rows[a].push((b, block));
            if a != b {
                rows[b].push((a, block));
            }
        }
        rows.iter_mut()
            .for_each(|row| row.sort_by_key(|(node, _)| *node));
        Ok(Self { rows })
    }

    /// The blocks of a node with others, increasing.
    pub(super) fn row(&self, node: usize) -> &[(usize, Matrix3<f64>)] {
        &self.rows[node]
    }

    /// K u, what the displacement in m of all nodes takes, in N, `[n_nodes]`; the springs act on the body with its opposite.
    #[must_use]
    pub fn forces(&self, displacement: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let force = |row: &Vec<(usize, Matrix3<f64>)>| {
            let terms = row.iter();
            let sum: Vector3<f64> = terms
                .map(|(node, block)| block * Vector3::from(displacement[*node]))
                .sum();
            sum.into()
        };
        self.rows.iter().map(force).collect()
    }
}

/// The points at which the springs of a scene are integrated, with the stiffness in Pa/m there.
///
/// # Errors
/// As [`SpringMatrix::of`].
pub fn visit_springs(
    scene: &Scene,
    mesh: &Mesh,
    take: &mut dyn FnMut(&SpringPoint<'_>, Matrix3<f64>),
) -> Result<(), InvalidValue> {
    let mut springs = scene.springs.iter().enumerate();
    springs.try_for_each(|(index, spring)| visit(spring, index, mesh, take))
}

/// The points of a spring's face with the stiffness there.
fn visit(
    spring: &Spring,
    index: usize,
    mesh: &Mesh,
    take: &mut dyn FnMut(&SpringPoint<'_>, Matrix3<f64>),
) -> Result<(), InvalidValue> {
    for side in mesh.sides_of(&format!("spring.{index}"), &spring.part())? {
        let mut add = |point: SpringPoint<'_>| -> Result<(), InvalidValue> {
            let stiffness = stiffness_at(spring, index, point.at, &point.normal)?;
            take(&point, stiffness);
            Ok(())
        };
        if let Some((nodes, points)) = mesh.points_unless_plain(&side) {
            for point in &points {
                add(SpringPoint {
                    at: point.at,
                    nodes: &nodes,
                    shape: &point.shape,
                    normal: point.area.normalize(),
                    area: point.area.norm(),
                })?;
            }
            continue;
        }
        let nodes = mesh.facets[side.facet];
        let corners = mesh.corners(&nodes);
        let [a, b, c] = corners.map(Vector3::from);
        let normal = (b - a).cross(&(c - a)).normalize();
        let area = triangle_area(&corners);
        for (shape, weight) in quadrature::triangle() {
            add(SpringPoint {
                at: quadrature::point(&corners, &shape),
                nodes: &nodes,
                shape: &shape,
                normal,
                area: area * weight,
            })?;
        }
    }
    Ok(())
}

/// K in Pa/m at a place of a face with some outward unit normal.
///
/// # Errors
/// A stiffness that is not finite and positive semidefinite.
pub(crate) fn stiffness_at(
    spring: &Spring,
    index: usize,
    at: [f64; 3],
    normal: &Vector3<f64>,
) -> Result<Matrix3<f64>, InvalidValue> {
    let refused = |name: &str, expected: &str, found: String| {
        InvalidValue {
        key: format!("spring.{index}.{name}"),
        expected: format!("a stiffness that is {expected} on the whole face"),
        found: format!("{found} at {}", place_words(at)),
        help: match expected {
            "finite" => UNDEFINED.into(),
            _ => "a spring that pushes a body further away has no equilibrium; write max(FORMULA, 0), or another tensor".into(),
        },
    }
    };
    let value = |name: &str, quantity: &Quantity| -> Result<f64, InvalidValue> {
        let found = quantity.at(at);
        if found.is_finite() {
            return Ok(found);
        }
        Err(refused(name, "finite", Written(&found).to_string()))
    };
    match &spring.tensor {
        None => {
            let along = |name: &str, quantity: &Option<Quantity>| {
                let found = quantity
                    .as_ref()
                    .map_or(Ok(0.0), |quantity| value(name, quantity))?;
                if found < 0.0 {
                    return Err(refused(name, "not negative", Written(&found).to_string()));
                }
                Ok(found)
            };
            let k_n = along("normal", &spring.normal)?;
            let k_t = along("tangential", &spring.tangential)?;
            let normals = normal * normal.transpose();
            Ok(Matrix3::from_diagonal_element(k_t) + normals * (k_n - k_t))
        }
        Some(rows) => {
            let mut tensor = Matrix3::zeros();
            for (i, row) in rows.iter().enumerate() {
                for (j, quantity) in row.iter().enumerate() {
                    tensor[(i, j)] = value("tensor", quantity)?;
                }
            }
            let largest = tensor.amax();
            let asymmetry = (tensor - tensor.transpose()).amax();
            let tensor = (tensor + tensor.transpose()) / 2.0;
            let least = tensor.symmetric_eigenvalues().min();
            if asymmetry > UNIT_ROUNDING * largest || least < -UNIT_ROUNDING * largest {
                let found = Written(&<[[f64; 3]; 3]>::from(tensor)).to_string();
                let expected = "symmetric and positive semidefinite";
                return Err(refused("tensor", expected, found));
            }
            Ok(tensor)
        }
    }
}

/// The places at which springs are integrated, each with an orthonormal basis of the directions that they hold there, however
/// stiffly.
pub(super) fn held_directions(scene: &Scene, mesh: &Mesh) -> Result<Vec<Hold>, InvalidValue> {
    let mut found = Vec::new();
    visit_springs(scene, mesh, &mut |point, stiffness| {
        let eigen = SymmetricEigen::new(stiffness);
        let largest = eigen.eigenvalues.max();
        let held = (0..3).filter(|&i| eigen.eigenvalues[i] > UNIT_ROUNDING * largest);
        let at = Vector3::from(point.at);
        found.extend(held.map(|i| (at, eigen.eigenvectors.column(i).into_owned())));
    })?;
    Ok(found)
}
