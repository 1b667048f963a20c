//! The problem in the order and units of the solvers.

use std::sync::Arc;

use super::DelassusProblem;
use crate::{
    contact::{CoulombLaw, FaceLaw, InterfaceFriction, MultiplierLayout, SlipMap, SlipOperator},
    dual::{DualMatrix, DualOperator, ExplicitDual},
    linalg::{CscMatrix, power_of_two_near_largest},
    scene::{Coefficient, FrictionLaw},
    solver::PaneLaws,
};

/// How Newton's method holds its matrices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MatrixForm {
    Dense,
    Sparse,
}

/// A problem with W' = D W D of about unit diagonal, q' = D q / t of about unit size, and μ' = 1 at all contacts with friction.
///
/// D = s diag(1, μ, μ) with one s for each contact: the law between r' = D⁻¹ r / t and u' = D u / t is Coulomb's with μ' = 1,
/// exactly, and powers of two for s and t round nothing. Contacts with friction come first, and those without have no tangential
/// components, as [`MultiplierLayout`] has it.
pub(super) struct Scaled<'a> {
    problem: &'a DelassusProblem,
    /// W' by columns.
    pub(super) operator: CscMatrix,
    /// h' = −q'.
    pub(super) rhs: Vec<f64>,
    pub(super) layout: MultiplierLayout,
    /// Component of the given problem at each of ours.
    source: Vec<usize>,
    /// D of each of our components.
    scale: Vec<f64>,
    /// t.
    unit: f64,
    /// The problem with each contact scaled by its s, and q by 1/t, in the order of the given one with all its tangential components, to
    /// judge by.
    pub(super) judge: DelassusProblem,
}

impl<'a> Scaled<'a> {
    pub(super) fn new(problem: &'a DelassusProblem) -> Self {
        let n = problem.n_contacts();
        let mu = problem.mu();
        let (with, without): (Vec<usize>, Vec<usize>) = (0..n).partition(|&c| mu[c] > 0.0);
        let layout = MultiplierLayout::new(n, with.len());
        let contacts = with.iter().chain(&without);
        let normal = contacts.map(|c| 3 * c);
        let tangential = with.iter().flat_map(|c| [3 * c + 1, 3 * c + 2]);
        let source: Vec<usize> = normal.chain(tangential).collect();
        let diagonal = problem.diagonal();
        let contact_scale: Vec<f64> = (0..n)
            .map(|c| contact_scale(&diagonal[3 * c..3 * c + 3], mu[c]))
            .collect();
        let own = |component: usize| {
            let contact = component / 3;
            let friction = match component % 3 {
                0 => 1.0,
                _ => mu[contact],
            };
            contact_scale[contact] * friction
        };
        let scale: Vec<f64> = source.iter().map(|&component| own(component)).collect();
        let offset: Vec<f64> = source
            .iter()
            .zip(&scale)
            .map(|(&k, d)| d * problem.offset()[k])
            .collect();
        let unit = power_of_two_near_largest(&offset).unwrap_or(1.0);
        let mut place = vec![None; 3 * n];
        for (ours, &given) in source.iter().enumerate() {
            place[given] = Some(ours);
        }
        Self {
            problem,
            operator: permuted(problem.matrix(), &source, &place, &scale),
            rhs: offset.iter().map(|q| -q / unit).collect(),
            judge: judged_scaling(problem, &contact_scale, unit),
            layout,
            source,
            scale,
            unit,
        }
    }

    /// r of the given problem.
    pub(super) fn forces(&self, multiplier: &[f64]) -> Vec<f64> {
        let mut force = vec![0.0; self.problem.offset().len()];
        for ((&component, scale), value) in self.source.iter().zip(&self.scale).zip(multiplier) {
            force[component] = self.unit * scale * value;
        }
        force
    }

    /// The larger of the errors of the given problem and of the scaled one.
    pub(super) fn worst_error(&self, multiplier: &[f64]) -> f64 {
        let given = self.problem.error(&self.forces(multiplier));
        let scaled = self.scaled_error(multiplier);
        if given.is_nan() {
            given
        } else {
            given.max(scaled)
        }
    }

    /// ‖r − P(r − û)‖ / ‖q‖ of the given problem with each contact scaled to a unit diagonal.
    pub(super) fn scaled_error(&self, multiplier: &[f64]) -> f64 {
        let mu = self.judge.mu();
        let mut force = vec![0.0; 3 * mu.len()];
        for (&component, value) in self.source.iter().zip(multiplier) {
            let friction = if component % 3 == 0 {
                1.0
            } else {
                mu[component / 3]
            };
            force[component] = friction * value;
        }
        self.judge.error_by_offset(&force)
    }

    /// A direction of forces of `judge` in those of the given problem, with a largest component of one.
    pub(super) fn unscaled(&self, direction: &[f64]) -> Vec<f64> {
        let mut scaled = vec![0.0; direction.len()];
        for (&component, scale) in self.source.iter().zip(&self.scale) {
            let normal = component - component % 3;
            if component == normal {
                (normal..normal + 3).for_each(|k| scaled[k] = scale * direction[k]);
            }
        }
        let largest = scaled.iter().fold(0.0_f64, |most, p| most.max(p.abs()));
        scaled.iter().map(|p| p / largest).collect()
    }

    /// The problem with a share of the diagonal added about some forces: S + α diag S, h + α diag S λ.
    pub(super) fn shifted(&self, form: MatrixForm, share: f64, about: &[f64]) -> ExplicitDual {
        let mut operator = self.operator.clone();
        let mut rhs = self.rhs.clone();
        for j in 0..rhs.len() {
            if let Some(at) = operator.place_of_diagonal(j) {
                let diagonal = &mut operator.data[at];
                let added = share * *diagonal;
                *diagonal += added;
                rhs[j] += added * about[j];
            }
        }
        ExplicitDual {
            operator: match form {
                MatrixForm::Sparse => DualMatrix::Sparse(Arc::new(operator)),
                MatrixForm::Dense => DualMatrix::Dense(Arc::new(dense(&operator))),
            },
            rhs,
            anchor: None,
            layout: self.layout,
            compliance: None,
            balance: None,
        }
    }

    /// Contacts of unit area, with F = 1 where there is friction.
    pub(super) fn laws(&self) -> PaneLaws {
        let (n, pairs) = (self.layout.n_panes(), self.layout.n_pairs());
        let law = FrictionLaw::Isotropic(Coefficient::Constant(1.0));
        let law = FaceLaw::new("mu", law, vec![[0.0; 3]; pairs]).placed(0, 0..pairs);
        PaneLaws::new(
            self.layout,
            vec![1.0; n],
            CscMatrix {
                rows: n,
                cols: n,
                indptr: (0..=n).collect(),
                indices: (0..n).collect(),
                data: vec![1.0; n],
            },
            match pairs {
                0 => InterfaceFriction::Frictionless,
                _ => InterfaceFriction::Coulomb(Box::new(CoulombLaw::new(vec![law]))),
            },
            SlipMap {
                operator: SlipOperator::Lagrange,
                past: None,
            },
        )
    }
}

/// All entries of a square matrix, column-major.
fn dense(matrix: &CscMatrix) -> Vec<f64> {
    let n = matrix.cols;
    let mut entries = vec![0.0; n * n];
    for (j, column) in entries.chunks_exact_mut(n.max(1)).enumerate() {
        let (rows, values) = matrix.column(j);
        for (&row, value) in rows.iter().zip(values) {
            column[row] = *value;
        }
    }
    entries
}

/// What is left of a diagonal entry that is zero but for the rounding of the others of its contact, as a share of those.
const ROUNDED: f64 = 1e-12;

/// 1/√ of the mean diagonal entry of a contact whose tangential components are scaled by μ, as a power of two; 1 for zeros.
///
/// Where these vanish beside those of the contact as they are, the mean of the latter.
fn contact_scale(diagonal: &[f64], mu: f64) -> f64 {
    let friction = if mu > 0.0 { mu * mu } else { 0.0 };
    let sum = diagonal[0] + friction * (diagonal[1] + diagonal[2]);
    let felt = sum / if mu > 0.0 { 3.0 } else { 1.0 };
    let whole = diagonal.iter().sum::<f64>() / 3.0;
    let mean = if felt > ROUNDED * whole { felt } else { whole };
    if mean > 0.0 {
        (-0.5 * mean.log2()).round().exp2()
    } else {
        1.0
    }
}

/// The given problem with each contact scaled by its s, and q by 1/t: the law keeps its μ.
fn judged_scaling(problem: &DelassusProblem, contact_scale: &[f64], unit: f64) -> DelassusProblem {
    let mut matrix = problem.matrix().clone();
    for column in 0..matrix.cols {
        for k in matrix.indptr[column]..matrix.indptr[column + 1] {
            let row = matrix.indices[k];
            matrix.data[k] *= contact_scale[row / 3] * contact_scale[column / 3];
        }
    }
    let components = problem.offset().iter().enumerate();
    let offset = components.map(|(k, q)| q * contact_scale[k / 3] / unit);
    let offset = offset.collect();
    problem.with_arrays(matrix, offset)
}

/// The rows and columns of a matrix that are kept, in a new order, scaled from both sides.
fn permuted(
    matrix: &CscMatrix,
    source: &[usize],
    place: &[Option<usize>],
    scale: &[f64],
) -> CscMatrix {
    let n = source.len();
    let mut kept = CscMatrix {
        rows: n,
        cols: n,
        indptr: vec![0],
        indices: Vec::with_capacity(matrix.indices.len()),
        data: Vec::with_capacity(matrix.data.len()),
    };
    let mut column_entries: Vec<(usize, f64)> = Vec::new();
    for (j, &given) in source.iter().enumerate() {
        let (rows, values) = matrix.column(given);
        let entries = rows.iter().zip(values);
        column_entries.extend(entries.filter_map(|(&row, value)| {
            let i = place[row]?;
            Some((i, scale[i] * value * scale[j]))
        }));
        column_entries.sort_unstable_by_key(|(row, _)| *row);
        for (row, value) in column_entries.drain(..) {
            kept.indices.push(row);
            kept.data.push(value);
        }
        kept.indptr.push(kept.indices.len());
    }
    kept
}

/// S' λ by the sparse matrix.
pub(super) struct SparseOperator<'a> {
    pub(super) scaled: &'a Scaled<'a>,
    pub(super) applications: usize,
}

impl DualOperator for SparseOperator<'_> {
    fn dimension(&self) -> usize {
        self.scaled.rhs.len()
    }

    fn rhs(&self) -> &[f64] {
        &self.scaled.rhs
    }

    fn apply(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.applications += 1;
        let mut product = vec![0.0; multiplier.len()];
        self.scaled
            .operator
            .mul_transposed(multiplier, &mut product);
        product
    }

    fn applications(&self) -> usize {
        self.applications
    }
}
