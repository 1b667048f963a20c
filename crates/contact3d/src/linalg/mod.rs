//! Sparse symmetric linear algebra, made for one use: factorise A once, then solve with B's few rows many times.
//!
//! | what | how | source |
//! |---|---|---|
//! | order | nested dissection along planes and breadth-first levels; approximate minimum degree where only the matrix is known | A. George, *SIAM J. Numer. Anal.* 10 (1973) 345; P. Amestoy, T. Davis, I. Duff, *SIAM J. Matrix Anal. Appl.* 17 (1996) 886 |
//! | factor | LLᵀ = PAPᵀ by the multifrontal method, in single or double precision, kept as plain arrays that a file can hold | I. Duff, J. Reid, *ACM Trans. Math. Softw.* 9 (1983) 302; J. W. H. Liu, *SIAM Review* 34 (1992) 82 |
//! | half-solves | W = L⁻¹PBᵀ on the paths of the elimination tree that B's columns reach; S = WᵀW | J. Gilbert, T. Peierls, *SIAM J. Sci. Stat. Comput.* 9 (1988) 862 |
//! | conjugate gradients | on A, preconditioned by a factor in single precision | M. R. Hestenes, E. Stiefel, *J. Res. Nat. Bur. Standards* 49 (1952) 409 |
//! | refinement | residuals in twice the working precision | N. J. Higham, *Accuracy and Stability of Numerical Algorithms*, 2002 |
//! | nonnegative least squares | active sets in a few dimensions | C. L. Lawson, R. J. Hanson, *Solving Least Squares Problems*, 1995 |
//! | operators | GMRES, Lanczos and Arnoldi, for matrices known by their products | Y. Saad, *Iterative Methods for Sparse Linear Systems*, 2003 |
//!
//! Sums have one fixed order: the same matrix gives the same bits at any number of threads.

mod analysis;
mod cholesky;
mod compliance;
mod dense;
mod dissection;
mod eigenvalues;
mod engine;
mod fronts;
mod half_solve;
mod iterative;
mod nonnegative;
mod precision;
mod solve;
mod sparse;
mod structure;
mod tasks;
mod vector;

#[cfg(test)]
#[path = "../../tests/rooms/linalg/brick.rs"]
mod test_brick;
#[cfg(test)]
mod tests;

pub use cholesky::{CholeskyFactor, Factor};
pub use dense::DenseLu;
pub(crate) use dense::{DenseCholesky, product, transpositions};
pub use dissection::{amd, expand_to_unknowns, nested_dissection};
pub use eigenvalues::largest_eigenvalue;
pub(crate) use eigenvalues::{
    distance_to_one, figures_by_products, least_modulus, spectral_radius,
};
pub use engine::{EngineError, EngineReport, RemoteFactor};
pub(crate) use iterative::{CgSolution, conjugate_gradients, gmres, gmres_several};
pub(crate) use nonnegative::nonnegative_least_squares;
pub(crate) use precision::{FEW_ROUNDINGS, UNIT_ROUNDING};
pub use precision::{Precision, Scalar};
pub use sparse::CscMatrix;
pub use structure::{FactorError, FactorStructure, PartsError};
pub use tasks::Work;
pub use vector::{Doubled, add_scaled, difference, dot, norm, power_of_two_near_largest, ratio};
pub(crate) use vector::{add_combination, larger, orthogonalise, vectorised};
