//! Sparse symmetric linear algebra, made for one use: factorise A once, then solve with B's few rows many times.
//!
//! | what | how | source |
//! |---|---|---|
//! | order | nested dissection along planes and breadth-first levels; approximate minimum degree where only the matrix is known | A. George, *SIAM J. Numer. Anal.* 10 (1973) 345; P. Amestoy, T. Davis, I. Duff, *SIAM J. Matrix Anal. Appl.* 17 (1996) 886 |
//! | factor | LLᵀ = PAPᵀ by the multifrontal method, in single or double precision, kept as plain arrays that a file can hold | I. Duff, J. Reid, *ACM Trans. Math. Softw.* 9 (1983) 302; J. W. H. Liu, *SIAM Review* 34 (1992) 82 |
//! | half-solves | W = L⁻¹PBᵀ on the paths of the elimination tree that B's columns reach; S = WᵀW | J. Gilbert, T. Peierls, *SIAM J. Sci. Stat. Comput.* 9 (1988) 862 |
//! | conjugate gradients | on A, preconditioned by a factor in single precision | M. R. Hestenes, E. Stiefel, *J. Res. Nat. Bur. Standards* 49 (1952) 409 |
//! | refinement | residuals in twice the working precision | N. J. Higham, *Accuracy and Stability of Numerical Algorithms*, 2002 |
//! | operators | GMRES, Lanczos and Arnoldi, for matrices known by their products | Y. Saad, *Iterative Methods for Sparse Linear Systems*, 2003 |
//!
//! Sums have one fixed order: the same matrix gives the same bits at any number of threads.

mod amalgamation;
mod analysis;
mod arnoldi;
mod block_solve;
mod compliance;
mod conjugate_gradients;
mod dense_cholesky;
mod dense_lu;
mod dissection;
mod distance_to_one;
mod elimination_tree;
mod factor;
mod factor_parts;
mod forward_rows;
mod front_plan;
mod fronts;
mod gmres;
mod half_solve;
mod inverse_diagonal;
mod lanczos;
mod ordering;
mod parity;
mod precision;
mod reach;
mod refinement;
mod scalar;
mod separator;
mod solve;
mod sparse;
mod sparse_lu;
mod spectral_radius;
mod structure;
mod substitution;
mod unknown;
mod vector;
mod work;

#[cfg(test)]
mod factor_tests;
#[cfg(test)]
mod forward_rows_tests;
#[cfg(test)]
mod test_brick;

pub(crate) use arnoldi::{figures_by_products, radius_by_products};
pub(crate) use conjugate_gradients::{Accuracy, conjugate_gradients};
pub(crate) use dense_cholesky::{DenseCholesky, shifts};
pub(crate) use dense_lu::DenseLu;
pub(crate) use dissection::{expand_to_unknowns, nested_dissection};
pub(crate) use distance_to_one::{distance_to_one, least_modulus};
pub use factor::{CholeskyFactor, FactorError};
pub use factor_parts::PartsError;
pub(crate) use gmres::gmres;
pub(crate) use lanczos::{largest_eigenvalue, largest_ritz_pair};
pub use ordering::{OrderingError, amd};
pub(crate) use parity::transpositions;
pub use precision::{Factor, Precision};
pub(crate) use reach::Reach;
pub use refinement::Doubled;
pub use scalar::Scalar;
pub use solve::Workspace;
pub use sparse::{CscMatrix, SparseError};
pub(crate) use sparse_lu::{SparseLuMemory, solve_sparse};
pub(crate) use spectral_radius::{product, spectral_radius};
pub use structure::FactorStructure;
pub(crate) use vector::{add_scaled, power_of_two_near_largest};
pub use vector::{difference, dot, norm};
pub use work::Work;
