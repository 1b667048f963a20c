//! Sparse symmetric linear algebra: compressed columns, fill-reducing orderings, supernodal
//! Cholesky factors.

mod analysis;
mod block_solve;
mod compliance;
mod dissection;
mod elimination_tree;
mod factor;
mod factor_parts;
mod forward_rows;
mod front_plan;
mod gmres;
mod half_solve;
mod lanczos;
mod ordering;
mod reach;
mod refinement;
mod separator;
mod solve;
mod sparse;
mod vector;

#[cfg(test)]
mod factor_tests;
#[cfg(test)]
mod forward_rows_tests;
#[cfg(test)]
mod test_brick;

pub(crate) use analysis::Analysis;
pub(crate) use dissection::{expand_to_unknowns, nested_dissection};
pub use factor::{CholeskyFactor, FactorError};
pub use factor_parts::PartsError;
pub(crate) use gmres::gmres;
pub(crate) use lanczos::largest_eigenvalue;
pub use ordering::{OrderingError, amd};
pub(crate) use reach::Reach;
pub use refinement::Doubled;
pub use solve::Workspace;
pub use sparse::{CscMatrix, SparseError};
pub(crate) use vector::add_scaled;
pub use vector::{difference, dot, norm};
