//! Sparse matrices, orderings and factors.

mod brick;
mod dissection;
mod factor;
mod parts;
mod sparse;
mod vector;

use contact3d::linalg::CscMatrix;
