//! The clamped elastic brick of HKL (2011), section 4, assembled independently of the rest of the crate,
//! for tests and measurements.

use std::collections::HashMap;

use super::CscMatrix;

/// Lamé constants of E = 21.19e10 Pa and Poisson ratio 0.277.
fn lame() -> (f64, f64) {
    let (young, poisson) = (21.19e10, 0.277);
    (
        young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)),
        young / (2.0 * (1.0 + poisson)),
    )
}

/// A tetrahedron's free node numbers (`None` = clamped) and its vertices.
type Tetrahedron = ([Option<usize>; 4], [[f64; 3]; 4]);

/// Free nodes and tetrahedra of (0,3)×(0,1)×(0,1) cut in 3n × n × n cubes of 5 tetrahedra, clamped
/// on x = 0.
pub(crate) struct Brick {
    /// Coordinates of the free nodes [m].
    pub(crate) points: Vec<[f64; 3]>,
    tetrahedra: Vec<Tetrahedron>,
    /// Numbers of the nodes with z = 0.
    pub(crate) contact_nodes: Vec<usize>,
}

impl Brick {
    pub(crate) fn new(n: usize) -> Self {
        Self::stretched(n, [1.0; 3])
    }

    /// The brick with its coordinates multiplied by `scale`.
    pub(crate) fn stretched(n: usize, scale: [f64; 3]) -> Self {
        let h = 1.0 / n as f64;
        let point = |[i, j, k]: [usize; 3]| {
            [
                i as f64 * h * scale[0],
                j as f64 * h * scale[1],
                k as f64 * h * scale[2],
            ]
        };
        let number = |[i, j, k]: [usize; 3]| (i > 0).then(|| ((i - 1) * (n + 1) + j) * (n + 1) + k);
        let mut brick = Self {
            points: vec![],
            tetrahedra: vec![],
            contact_nodes: vec![],
        };
        for i in 1..=3 * n {
            for j in 0..=n {
                for k in 0..=n {
                    if k == 0 {
                        brick.contact_nodes.push(brick.points.len());
                    }
                    brick.points.push(point([i, j, k]));
                }
            }
        }
        for cell in 0..3 * n * n * n {
            for nodes in cube_tetrahedra([cell / (n * n), cell / n % n, cell % n]) {
                brick.tetrahedra.push((nodes.map(number), nodes.map(point)));
            }
        }
        brick
    }

    /// Adjacency of the free nodes without the diagonal: pointers and sorted neighbours.
    pub(crate) fn graph(&self) -> (Vec<usize>, Vec<usize>) {
        let mut pairs = vec![];
        for (nodes, _) in &self.tetrahedra {
            for a in nodes.iter().flatten() {
                pairs.extend(nodes.iter().flatten().filter(|b| *b != a).map(|b| (*a, *b)));
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        let mut indptr = vec![0; self.points.len() + 1];
        for &(a, _) in &pairs {
            indptr[a + 1] += 1;
        }
        for a in 0..self.points.len() {
            indptr[a + 1] += indptr[a];
        }
        (indptr, pairs.into_iter().map(|(_, b)| b).collect())
    }

    /// Stiffness of isotropic linear elasticity on the free nodes, unknown 3·node + component.
    pub(crate) fn stiffness(&self) -> CscMatrix {
        let (indptr, neighbours) = self.graph();
        let row_count = |node: usize| indptr[node + 1] - indptr[node] + 1;
        let mut column_start = vec![0];
        let mut indices = vec![];
        let mut block_place = HashMap::new();
        for node in 0..self.points.len() {
            let mut column: Vec<usize> = neighbours[indptr[node]..indptr[node + 1]].to_vec();
            column.push(node);
            column.sort_unstable();
            for (place, &row) in column.iter().enumerate() {
                block_place.insert((row, node), indices.len() + 3 * place);
            }
            for _ in 0..3 {
                indices.extend(column.iter().flat_map(|&row| 3 * row..3 * row + 3));
                column_start.push(indices.len());
            }
        }
        let mut data = vec![0.0; indices.len()];
        for (nodes, points) in &self.tetrahedra {
            let element = element_stiffness(points);
            for (a, row) in nodes
                .iter()
                .enumerate()
                .filter_map(|(a, row)| row.map(|row| (a, row)))
            {
                for (b, column) in nodes
                    .iter()
                    .enumerate()
                    .filter_map(|(b, column)| column.map(|c| (b, c)))
                {
                    let start = block_place[&(row, column)];
                    for d in 0..3 {
                        for c in 0..3 {
                            data[start + d * 3 * row_count(column) + c] +=
                                element[3 * a + c][3 * b + d];
                        }
                    }
                }
            }
        }
        let size = 3 * self.points.len();
        CscMatrix {
            rows: size,
            cols: size,
            indptr: column_start,
            indices,
            data,
        }
    }
}

/// The five tetrahedra of the cube with the lowest corner `corner`.
fn cube_tetrahedra(corner: [usize; 3]) -> [[[usize; 3]; 4]; 5] {
    let vertex = |bits: usize| {
        [
            corner[0] + (bits & 1),
            corner[1] + (bits >> 1 & 1),
            corner[2] + (bits >> 2 & 1),
        ]
    };
    let parity = |bits: usize| vertex(bits).iter().sum::<usize>() % 2;
    let mut result = [[[0; 3]; 4]; 5];
    let (mut even, mut odd) = (0, 0);
    for bits in 0..8 {
        if parity(bits) == 0 {
            result[0][even] = vertex(bits);
            even += 1;
        } else {
            odd += 1;
            result[odd] = [
                vertex(bits),
                vertex(bits ^ 1),
                vertex(bits ^ 2),
                vertex(bits ^ 4),
            ];
        }
    }
    result
}

/// K = V (λ ∂ᵢNₐ ∂ⱼN_b + μ ∂ⱼNₐ ∂ᵢN_b + μ δᵢⱼ ∇Nₐ·∇N_b) of a linear tetrahedron.
fn element_stiffness(points: &[[f64; 3]; 4]) -> [[f64; 12]; 12] {
    let (lambda, mu) = lame();
    let edge = |a: usize| nalgebra::Vector3::from(points[a]) - nalgebra::Vector3::from(points[0]);
    let jacobian = nalgebra::Matrix3::from_columns(&[edge(1), edge(2), edge(3)]);
    let volume = jacobian.determinant().abs() / 6.0;
    let inverse = jacobian
        .try_inverse()
        .expect("tetrahedra of the brick are not flat");
    let mut gradient = [nalgebra::Vector3::zeros(); 4];
    for a in 0..3 {
        gradient[a + 1] = inverse.row(a).transpose();
        gradient[0] -= gradient[a + 1];
    }
    let mut k = [[0.0; 12]; 12];
    for (row, col) in (0..144).map(|entry| (entry / 12, entry % 12)) {
        let (a, i, b, j) = (row / 3, row % 3, col / 3, col % 3);
        let shear = if i == j {
            gradient[a].dot(&gradient[b])
        } else {
            0.0
        };
        let direct =
            lambda * gradient[a][i] * gradient[b][j] + mu * gradient[a][j] * gradient[b][i];
        k[row][col] = volume * (direct + mu * shear);
    }
    k
}
