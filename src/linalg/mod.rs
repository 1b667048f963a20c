//! Sparse symmetric linear algebra: compressed columns, fill-reducing orderings, supernodal Cholesky factors.

mod block_solve;
mod elimination_tree;
mod factor;
mod factor_parts;
mod ordering;
mod reach;
mod solve;
mod sparse;

#[cfg(test)]
mod factor_tests;
#[cfg(test)]
mod test_brick;

pub use factor::{CholeskyFactor, FactorError};
pub use factor_parts::PartsError;
pub use ordering::{OrderingError, amd};
pub use reach::Reach;
pub use solve::Workspace;
pub use sparse::{CscMatrix, SparseError};
