//! Stresses that are linear on the four parts of a tetrahedron around its centroid.
//!
//! The element of C. Johnson and B. Mercier (Numer. Math. 30 (1978) 103), in three dimensions after M. Křížek (Apl. Mat. 27 (1982)
//! 96): symmetric, with tractions that are continuous between the parts. Linear tractions on the four sides that balance a constant
//! body force determine it, and it then balances them at every point.
//!
//! With the columns of B along the edges from corner 0 and J = det B, σ = B σ̂ Bᵀ/J is the stress of the tetrahedron that belongs to σ̂
//! of the reference tetrahedron. Its forces ∫ λ_a σν and its divergence are B and B/J times those of σ̂.

use std::sync::LazyLock;

use contact3d::{
    elasticity::{MaterialField, Simplex},
    reference::{TETRAHEDRON_SIDES, quadrature},
};
use nalgebra::{DMatrix, Matrix3, Matrix6, SVector, Vector3, Vector6};
use rayon::prelude::*;

/// The two indices of each Voigt component xx, yy, zz, yz, xz, xy.
const VOIGT: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [1, 2], [0, 2], [0, 1]];

/// Data of a stress: the forces ∫ λ_a σν of the three corners of the four sides, then the divergence.
pub(super) const DATA: usize = 39;

/// Entries of [`DATA`] that belong to the forces of one side.
pub(super) const SIDE_DATA: usize = 9;

/// Pairs of components of a symmetric matrix.
const PAIRS: usize = 21;

/// Values of a stress: six components at the four corners of the four parts.
const VALUES: usize = 96;

/// Data of a stress on the reference tetrahedron, forces in N and divergence times J in N.
pub(super) type Data = SVector<f64, DATA>;

/// The map from data to values on the reference tetrahedron, and ∫ σ̂_c σ̂_d over its parts for unit data.
struct Reference {
    /// `[VALUES, DATA]`; part k has the corners of side k, then the centroid.
    values: DMatrix<f64>,
    /// Mean of the products of components c ≤ d, both orders added where they differ, `[DATA][pairs][DATA]`.
    products: Vec<[[f64; DATA]; PAIRS]>,
}

static REFERENCE: LazyLock<Reference> = LazyLock::new(Reference::new);

/// Mean of λ_a λ_b over a tetrahedron.
fn mean_product(a: usize, b: usize) -> f64 {
    if a == b { 0.1 } else { 0.05 }
}

fn value(part: usize, corner: usize, component: usize) -> usize {
    (part * 4 + corner) * 6 + component
}

/// Pairs of components c ≤ d.
fn pairs() -> impl Iterator<Item = [usize; 2]> {
    (0..6).flat_map(|c| (c..6).map(move |d| [c, d]))
}

impl Reference {
    fn new() -> Self {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let corners = corners.map(Vector3::from);
        let centroid: Vector3<f64> = corners.iter().sum::<Vector3<f64>>() / 4.0;
        let mut equations = Equations::default();
        for (part, side) in TETRAHEDRON_SIDES.into_iter().enumerate() {
            let [a, b, c] = side.map(|k| corners[k]);
            let area = outward((b - a).cross(&(c - a)) / 2.0, a - corners[part]);
            for (k, _) in side.iter().enumerate() {
                // The nodal values of a linear traction t from its moments: t_a = (12 m_a − 3 Σ m)/area.
                let of_moments = (0..3).flat_map(|j| {
                    let weight = if j == k { 9.0 } else { -3.0 } / area.norm();
                    (0..3).map(move |c| (c, part * SIDE_DATA + j * 3 + c, weight))
                });
                equations.add(&[(part, k, area.normalize())], of_moments);
            }
            let part_corners: [[f64; 3]; 4] = [a, b, c, centroid].map(Into::into);
            let gradients = Simplex::new(&part_corners).gradients;
            let terms: Vec<_> = (0..4).map(|k| (part, k, gradients[k])).collect();
            equations.add(&terms, (0..3).map(|c| (c, 36 + c, 1.0)));
            for other in part + 1..4 {
                let shared: Vec<usize> = (0..4).filter(|k| *k != part && *k != other).collect();
                let [a, b] = [corners[shared[0]], corners[shared[1]]];
                let normal = (a - centroid).cross(&(b - centroid)).normalize();
                let place = |side: usize, corner: Option<usize>| {
                    let at = corner.and_then(|corner| {
                        TETRAHEDRON_SIDES[side].iter().position(|k| *k == corner)
                    });
                    at.unwrap_or(3)
                };
                for corner in [Some(shared[0]), Some(shared[1]), None] {
                    let here = (part, place(part, corner), normal);
                    let there = (other, place(other, corner), -normal);
                    equations.add(&[here, there], std::iter::empty());
                }
            }
        }
        let values = equations.solution();
        let component =
            |c: usize| DMatrix::from_fn(16, DATA, |place, datum| values[(place * 6 + c, datum)]);
        let weights = DMatrix::from_fn(16, 16, |a, b| {
            if a / 4 == b / 4 {
                mean_product(a % 4, b % 4) / 4.0
            } else {
                0.0
            }
        });
        let mut products = vec![[[0.0; DATA]; PAIRS]; DATA];
        for (pair, [c, d]) in pairs().enumerate() {
            let product = component(c).transpose() * &weights * component(d);
            for (i, of_row) in products.iter_mut().enumerate() {
                of_row[pair] = std::array::from_fn(|j| match c == d {
                    true => product[(i, j)],
                    false => product[(i, j)] + product[(j, i)],
                });
            }
        }
        Self { products, values }
    }
}

/// An area vector or its opposite, whichever points away.
pub(super) fn outward(area: Vector3<f64>, away: Vector3<f64>) -> Vector3<f64> {
    if area.dot(&away) < 0.0 { -area } else { area }
}

/// Linear equations for the values of a stress.
#[derive(Default)]
struct Equations {
    left: Vec<[f64; VALUES]>,
    right: Vec<[f64; DATA]>,
}

impl Equations {
    /// Three equations Σ σ(part, corner) n = Σ weight · datum; the data come as (component, datum, weight).
    fn add(
        &mut self,
        terms: &[(usize, usize, Vector3<f64>)],
        data: impl Iterator<Item = (usize, usize, f64)>,
    ) {
        let first = self.left.len();
        self.left.resize(first + 3, [0.0; VALUES]);
        self.right.resize(first + 3, [0.0; DATA]);
        for (part, corner, normal) in terms {
            for (component, [i, j]) in VOIGT.into_iter().enumerate() {
                let place = value(*part, *corner, component);
                self.left[first + i][place] += normal[j];
                if i != j {
                    self.left[first + j][place] += normal[i];
                }
            }
        }
        for (component, datum, weight) in data {
            self.right[first + component][datum] += weight;
        }
    }

    /// The values for unit data, least squares for data that are not in balance.
    fn solution(&self) -> DMatrix<f64> {
        let rows = self.left.len();
        let left = DMatrix::from_fn(rows, VALUES, |i, j| self.left[i][j]);
        let right = DMatrix::from_fn(rows, DATA, |i, j| self.right[i][j]);
        let svd = left.svd(true, true);
        // Six of the 102 equations follow from the others; the smallest singular value of the rest is above 0.1.
        let found = svd.solve(&right, 1e-8);
        found.expect("both factors were asked for")
    }
}

/// A tetrahedron that carries such a stress.
#[derive(Debug, Clone)]
pub(super) struct MacroElement {
    /// B⁻¹ in 1/m.
    pub(super) inverse: Matrix3<f64>,
    /// J in m³.
    pub(super) jacobian: f64,
    /// From the components of σ̂ to those of σ.
    to_stress: Matrix6<f64>,
    /// V times the compliance seen by σ̂.
    metric: Matrix6<f64>,
}

impl MacroElement {
    /// A tetrahedron of a material with some compliance C⁻¹ in 1/Pa.
    pub(super) fn new(corners: &[[f64; 3]; 4], compliance: &Matrix6<f64>) -> Self {
        let [origin, a, b, c] = corners.map(Vector3::from);
        let map = Matrix3::from_columns(&[a - origin, b - origin, c - origin]);
        let jacobian = map.determinant();
        let mut to_stress = Matrix6::zeros();
        for (c, [i, j]) in VOIGT.into_iter().enumerate() {
            for (d, [k, l]) in VOIGT.into_iter().enumerate() {
                let mut entry = map[(i, k)] * map[(j, l)];
                if k != l {
                    entry += map[(i, l)] * map[(j, k)];
                }
                to_stress[(c, d)] = entry / jacobian;
            }
        }
        let volume = jacobian / 6.0;
        Self {
            inverse: map.try_inverse().unwrap_or_else(Matrix3::zeros),
            jacobian,
            metric: to_stress.transpose() * compliance * to_stress * volume,
            to_stress,
        }
    }

    /// Rows of the symmetric matrix of ∫ σ : C⁻¹σ in J over the data.
    pub(super) fn energy(&self, rows: &[usize]) -> DMatrix<f64> {
        let mut energy = DMatrix::zeros(rows.len(), DATA);
        for (i, row) in rows.iter().enumerate() {
            let mut sums = [0.0; DATA];
            for (products, [c, d]) in REFERENCE.products[*row].iter().zip(pairs()) {
                let weight = self.metric[(c, d)];
                (0..DATA).for_each(|j| sums[j] += products[j] * weight);
            }
            (0..DATA).for_each(|j| energy[(i, j)] = sums[j]);
        }
        energy
    }

    /// ∫ σ : ε in J of unit data with a strain that is linear, given in Voigt notation at the four corners.
    pub(super) fn work(&self, strain: &[Vector6<f64>; 4]) -> Data {
        let centroid = strain.iter().sum::<Vector6<f64>>() / 4.0;
        let volume = self.jacobian / 6.0;
        let mut sum = Data::zeros();
        for (part, side) in TETRAHEDRON_SIDES.into_iter().enumerate() {
            let at: [Vector6<f64>; 4] =
                std::array::from_fn(|k| side.get(k).map_or(centroid, |corner| strain[*corner]));
            for a in 0..4 {
                let mean = (0..4).map(|b| at[b] * mean_product(a, b));
                let mean = self.to_stress.transpose() * mean.sum::<Vector6<f64>>() * (volume / 4.0);
                for (component, weight) in mean.iter().enumerate() {
                    let row = REFERENCE.values.row(value(part, a, component));
                    sum += row.transpose() * *weight;
                }
            }
        }
        sum
    }
}

/// A strain that stresses are compared with.
pub(super) struct Target<'a> {
    elements: &'a [MacroElement],
    /// w: ∫ σ : ε in J of unit data, `[n_tetrahedra]`.
    pub(super) work: Vec<Data>,
    /// ∫ ε : C ε in J, `[n_tetrahedra]`.
    energy: Vec<f64>,
}

impl<'a> Target<'a> {
    /// One that is linear in each tetrahedron, given in Voigt notation at the corners.
    pub(super) fn new(
        elements: &'a [MacroElement],
        material: &MaterialField<'_>,
        strain: &[[Vector6<f64>; 4]],
    ) -> Self {
        let both = || elements.iter().zip(strain).enumerate();
        let energy = both().map(|(t, (element, strain))| {
            strain_energy(strain, material.tensor(t), element.jacobian / 6.0)
        });
        Self {
            elements,
            work: both().map(|(_, (element, at))| element.work(at)).collect(),
            energy: energy.collect(),
        }
    }

    /// √∫ ε : C ε over the body, in √J.
    pub(super) fn norm(&self) -> f64 {
        self.energy.iter().sum::<f64>().sqrt()
    }

    /// ∫ (σ − C ε) : C⁻¹ (σ − C ε) in J of the stresses that belong to some data.
    pub(super) fn distance(&self, data: &[Data]) -> f64 {
        let all: Vec<usize> = (0..DATA).collect();
        let elements = self.elements.par_iter().zip(data).enumerate();
        let of_element = |(t, (element, data)): (usize, (&MacroElement, &Data))| {
            let energy = (element.energy(&all) * data).dot(data);
            (energy - 2.0 * self.work[t].dot(data) + self.energy[t]).max(0.0)
        };
        let squares: Vec<f64> = elements.map(of_element).collect();
        squares.iter().sum()
    }
}

/// ∫ ε : C ε in J of a strain that is linear on a tetrahedron of some volume.
fn strain_energy(strain: &[Vector6<f64>; 4], elasticity: &Matrix6<f64>, volume: f64) -> f64 {
    let at = |weights: [f64; 4]| -> Vector6<f64> { (0..4).map(|k| strain[k] * weights[k]).sum() };
    let points = quadrature::TETRAHEDRON_2.into_iter();
    let terms = points.map(|(at_point, weight)| {
        let strain = at(at_point);
        weight * strain.dot(&(elasticity * strain))
    });
    volume * terms.sum::<f64>()
}
