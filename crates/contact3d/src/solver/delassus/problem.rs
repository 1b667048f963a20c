//! The problem as it is given, and the error of forces.

use std::sync::OnceLock;

use thiserror::Error;

use crate::linalg::{CscMatrix, FactorStructure, amd, norm};

/// How far entries W_ij and W_ji may be apart, as a share of the largest entry: files of other programs are written with
/// rounding.
const ASYMMETRY: f64 = 1e-8;

/// The share of the operations of a dense factor below which a sparse one is quicker, though its kernels are small.
const SPARSE: f64 = 0.1;

/// Find u and r with u = W r + q and, at every contact, r_N ≥ 0, u_N ≥ 0, r_N u_N = 0 and Coulomb's law between u_T and r_T
/// with the coefficient μ.
///
/// Components are N, T1, T2 contact after contact. With û = u + (μ‖u_T‖, 0, 0) the conditions say that r lies in the cone
/// ‖r_T‖ ≤ μ r_N, û in its dual, and r·û = 0 (G. De Saxcé, Z.-Q. Feng, *Math. Comput. Model.* 28 (1998) 225).
#[derive(Debug, Clone)]
pub struct DelassusProblem {
    matrix: CscMatrix,
    offset: Vec<f64>,
    mu: Vec<f64>,
    /// [`Self::is_sparse`], once it was asked for.
    sparse: OnceLock<bool>,
}

/// Why arrays make no problem.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DelassusError {
    /// Sizes that do not fit.
    #[error(
        "expected W of 3n rows and columns, q of 3n and mu of n numbers for n contacts, found {rows} rows, {columns} columns, {offset} and {mu} numbers; give the arrays of one problem in 3D"
    )]
    Sizes {
        /// Rows of W.
        rows: usize,
        /// Columns of W.
        columns: usize,
        /// Length of q.
        offset: usize,
        /// Length of μ.
        mu: usize,
    },
    /// A number that is not finite.
    #[error("{array}: expected finite numbers, found {value} at entry {at}; correct the file")]
    NotFinite {
        /// W, q or mu.
        array: &'static str,
        /// Its place.
        at: usize,
        /// What it is.
        value: f64,
    },
    /// A negative coefficient of friction.
    #[error("mu: expected coefficients >= 0, found {value} at contact {contact}; correct the file")]
    NegativeFriction {
        /// The contact, counted from 0.
        contact: usize,
        /// Its coefficient.
        value: f64,
    },
    /// A diagonal entry below zero.
    #[error(
        "W: expected a positive semidefinite matrix, found {value} on the diagonal in row {row}; correct the file"
    )]
    NegativeDiagonal {
        /// The row.
        row: usize,
        /// The entry.
        value: f64,
    },
    /// Entries that differ from those across the diagonal.
    #[error(
        "W: expected a symmetric matrix, found entries in row {row} and column {column} that differ by {difference} from those across the diagonal; correct the file"
    )]
    NotSymmetric {
        /// The row.
        row: usize,
        /// The column.
        column: usize,
        /// W_ij − W_ji.
        difference: f64,
    },
}

impl DelassusProblem {
    /// A problem with W of shape `[3 n, 3 n]`, q of `[3 n]` and μ of `[n]`.
    ///
    /// # Errors
    /// [`DelassusError`]. That W has no negative eigenvalue is not checked; without it a solve may fail.
    pub fn new(matrix: CscMatrix, offset: Vec<f64>, mu: Vec<f64>) -> Result<Self, DelassusError> {
        let size = 3 * mu.len();
        if [matrix.rows, matrix.cols, offset.len()] != [size; 3] {
            return Err(DelassusError::Sizes {
                rows: matrix.rows,
                columns: matrix.cols,
                offset: offset.len(),
                mu: mu.len(),
            });
        }
        for (array, values) in [("W", &matrix.data), ("q", &offset), ("mu", &mu)] {
            if let Some(at) = values.iter().position(|value| !value.is_finite()) {
                let value = values[at];
                return Err(DelassusError::NotFinite { array, at, value });
            }
        }
        if let Some(contact) = mu.iter().position(|mu| *mu < 0.0) {
            let value = mu[contact];
            return Err(DelassusError::NegativeFriction { contact, value });
        }
        let problem = Self {
            matrix,
            offset,
            mu,
            sparse: OnceLock::new(),
        };
        problem.refuse_asymmetry()?;
        let diagonal = problem.diagonal();
        match diagonal.iter().position(|value| *value < 0.0) {
            None => Ok(problem),
            Some(row) => {
                let value = diagonal[row];
                Err(DelassusError::NegativeDiagonal { row, value })
            }
        }
    }

    /// The same μ with arrays of the same sizes, known to be valid.
    pub(super) fn with_arrays(&self, matrix: CscMatrix, offset: Vec<f64>) -> Self {
        let mu = self.mu.clone();
        Self {
            matrix,
            offset,
            mu,
            sparse: OnceLock::new(),
        }
    }

    fn refuse_asymmetry(&self) -> Result<(), DelassusError> {
        let transposed = self.matrix.transpose();
        let size = |values: &[f64]| values.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let allowed = ASYMMETRY * size(&self.matrix.data);
        let mut row_values = vec![0.0; self.offset.len()];
        for column in 0..self.offset.len() {
            let (rows, values) = self.matrix.column(column);
            let (others, across) = transposed.column(column);
            for (&row, value) in rows.iter().zip(values) {
                row_values[row] += value;
            }
            for (&row, value) in others.iter().zip(across) {
                row_values[row] -= value;
            }
            for &row in rows.iter().chain(others) {
                let difference = std::mem::take(&mut row_values[row]);
                if difference.abs() > allowed {
                    return Err(DelassusError::NotSymmetric {
                        row,
                        column,
                        difference,
                    });
                }
            }
        }
        Ok(())
    }

    /// Number of contacts n.
    #[must_use]
    pub fn n_contacts(&self) -> usize {
        self.mu.len()
    }

    /// W, `[3 n, 3 n]`.
    #[must_use]
    pub fn matrix(&self) -> &CscMatrix {
        &self.matrix
    }

    /// Whether a Cholesky factor of W takes so few operations beside that of a dense matrix, n³/3 for n rows, that Newton's method
    /// holds its matrices sparse.
    #[must_use]
    pub fn is_sparse(&self) -> bool {
        *self.sparse.get_or_init(|| {
            let order = amd(&self.matrix).ok();
            let structure =
                order.and_then(|order| FactorStructure::analyse(&self.matrix, order).ok());
            let dense = (self.matrix.cols as f64).powi(3) / 3.0;
            structure.is_some_and(|structure| structure.operations() < SPARSE * dense)
        })
    }

    /// W alone.
    #[must_use]
    pub fn into_matrix(self) -> CscMatrix {
        self.matrix
    }

    /// q, `[3 n]`.
    #[must_use]
    pub fn offset(&self) -> &[f64] {
        &self.offset
    }

    /// μ, `[n]`.
    #[must_use]
    pub fn mu(&self) -> &[f64] {
        &self.mu
    }

    /// The diagonal of W.
    #[must_use]
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.offset.len())
            .map(|j| self.matrix.diagonal(j))
            .collect()
    }

    /// u = W r + q.
    #[must_use]
    pub fn velocity(&self, force: &[f64]) -> Vec<f64> {
        let mut velocity = vec![0.0; force.len()];
        self.matrix.mul(force, &mut velocity);
        for (u, q) in velocity.iter_mut().zip(&self.offset) {
            *u += q;
        }
        velocity
    }

    /// ‖r − P(r − û)‖ / max(‖q‖, ‖r‖, ‖u‖) with the projection P on the cones of friction, 0 for 0/0: the error by which
    /// `fc3d_compute_error` of Siconos 4.4 judges forces where its argument `norm` is ‖q‖, as its solvers have it. It adds forces to
    /// velocities, so it depends on units.
    ///
    /// The residual is the largest of three that exact arithmetic bounds by each other, since rounding lets the first one vanish where
    /// forces are huge, and the second where velocities are: ‖r − P(r − û)‖, ‖û − P*(û − r)‖ with the projection P* on the dual cones
    /// (equal to it by J.-J. Moreau, *C. R. Acad. Sci.* 255 (1962) 238), and the penetration ‖min(u_N, 0)‖.
    #[must_use]
    pub fn error(&self, force: &[f64]) -> f64 {
        self.error_with(force, &self.velocity(force))
    }

    /// [`Self::error`] where u is known.
    pub(super) fn error_with(&self, force: &[f64], velocity: &[f64]) -> f64 {
        let sizes = [force, velocity, &self.offset].map(norm);
        relative(
            self.residual(force, velocity),
            sizes.into_iter().fold(0.0, f64::max),
        )
    }

    /// The residual of [`Self::error`], or what forces cannot resolve if that is more, over ‖q‖; 0 for 0/0. Forces without bound, by
    /// which a problem without a solution is solved ever better relative to them, make this no smaller.
    #[must_use]
    pub fn error_by_offset(&self, force: &[f64]) -> f64 {
        let residual = self.residual(force, &self.velocity(force));
        let resolution = self.resolution(force);
        relative(largest([residual, resolution]), norm(&self.offset))
    }

    fn residual(&self, force: &[f64], velocity: &[f64]) -> f64 {
        let form = |which: usize| {
            let contacts = force.as_chunks().0.iter().zip(velocity.as_chunks().0);
            let residuals = contacts
                .zip(&self.mu)
                .flat_map(|((r, u), mu)| residuals(*r, *u, *mu)[which]);
            norm(&residuals.collect::<Vec<f64>>())
        };
        largest([0, 1, 2].map(form))
    }

    /// How far the last digit of a force moves its own contact: u is known no better, and W, if it is a product of other matrices,
    /// not either.
    fn resolution(&self, force: &[f64]) -> f64 {
        let contacts = force.as_chunks::<3>().0.iter().enumerate();
        let moved = contacts.map(|(contact, r)| {
            let diagonal = (3 * contact..3 * contact + 3).map(|j| self.matrix.diagonal(j));
            diagonal.fold(0.0, f64::max) * norm(r)
        });
        f64::EPSILON * moved.fold(0.0, f64::max)
    }
}

/// The largest number; NaN where there is one.
fn largest<const N: usize>(values: [f64; N]) -> f64 {
    let larger = |most: f64, value: f64| {
        if most.is_nan() || value <= most {
            most
        } else {
            value
        }
    };
    values.into_iter().fold(0.0, larger)
}

fn relative(residual: f64, size: f64) -> f64 {
    match residual {
        0.0 => 0.0,
        residual => residual / size,
    }
}

/// r − P(r − û), û − P*(û − r) and min(u_N, 0) at one contact.
fn residuals(r: [f64; 3], u: [f64; 3], mu: f64) -> [[f64; 3]; 3] {
    let corrected = [u[0] + mu * u[1].hypot(u[2]), u[1], u[2]];
    let projected = project([0, 1, 2].map(|k| r[k] - corrected[k]), mu);
    // P*(x) = x + P(−x), summed first: forces that swallow velocities cancel, and leave them.
    let dual = [0, 1, 2].map(|k| (corrected[k] - r[k]) + projected[k]);
    [
        [0, 1, 2].map(|k| r[k] - projected[k]),
        [0, 1, 2].map(|k| corrected[k] - dual[k]),
        [u[0].min(0.0), 0.0, 0.0],
    ]
}

/// The point of the cone ‖x_T‖ ≤ μ x_N that is nearest.
pub(super) fn project(x: [f64; 3], mu: f64) -> [f64; 3] {
    let tangential = x[1].hypot(x[2]);
    if mu * tangential <= -x[0] {
        return [0.0; 3];
    }
    if tangential <= mu * x[0] {
        return x;
    }
    let normal = (x[0] + mu * tangential) / (1.0 + mu * mu);
    let share = mu * normal / tangential;
    [normal, share * x[1], share * x[2]]
}
