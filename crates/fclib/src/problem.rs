//! Problems, solutions, and what is said about them.

use crate::Matrix;

/// What a file says about its problem.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Info {
    /// Title.
    pub title: Option<String>,
    /// Where the problem comes from.
    pub description: Option<String>,
    /// What is known of its solutions.
    pub math_info: Option<String>,
    /// Degrees of freedom of the bodies, an attribute of the group.
    pub degrees_of_freedom: Option<usize>,
}

/// A problem in the unknowns of its contacts alone: u = W r + q with Coulomb's law between u and r.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalProblem {
    /// Components of u and r at each contact: 2 or 3, the normal one first.
    pub space_dimension: usize,
    /// W, symmetric and positive semidefinite, `[d n, d n]` for n contacts.
    pub w: Matrix,
    /// q, `[d n]`.
    pub q: Vec<f64>,
    /// Coefficients of friction, `[n]`.
    pub mu: Vec<f64>,
    /// What the file says about it.
    pub info: Info,
}

/// A problem with the degrees of freedom of its bodies: M v = H r + f, u = Hᵀ v + w with Coulomb's law between u and r.
#[derive(Debug, Clone, PartialEq)]
pub struct GlobalProblem {
    /// Components of u and r at each contact: 2 or 3, the normal one first.
    pub space_dimension: usize,
    /// M, symmetric and positive definite, `[m, m]`.
    pub m: Matrix,
    /// H, `[m, d n]` for n contacts.
    pub h: Matrix,
    /// f, `[m]`.
    pub f: Vec<f64>,
    /// w, `[d n]`.
    pub w: Vec<f64>,
    /// Coefficients of friction, `[n]`.
    pub mu: Vec<f64>,
    /// What the file says about it.
    pub info: Info,
}

/// A solution or a guess.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FclibSolution {
    /// v, `[m]`; `None` for a local problem.
    pub v: Option<Vec<f64>>,
    /// u, `[d n]`.
    pub u: Vec<f64>,
    /// r, `[d n]`.
    pub r: Vec<f64>,
}
