//! What a dense and an implicit dual operator would cost, and which is the better choice.

use crate::{contact::Coupling, linalg::CholeskyFactor};

/// What each form of the dual operator would cost, from the structure of the factor alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatorEstimate {
    /// Bytes of S and of the contact compliance.
    pub dense_bytes: f64,
    /// Bytes of S, of the contact compliance, and of W = L⁻¹PBᵀ while they are formed.
    pub explicit_bytes: f64,
    /// Floating-point operations that form S and the compliance.
    pub explicit_operations: f64,
    /// Bytes of the Cholesky factor.
    pub factor_bytes: f64,
    /// Floating-point operations of one application of the implicit operator.
    pub action_operations: f64,
}

/// The paper's algorithm takes about a thousand applications for four digits and some ten thousand for
/// eight; forming S pays when it costs less than this many.
const APPLICATIONS_OF_A_SOLVE: f64 = 1e4;

/// Memory that never matters, in bytes.
const SMALL_MEMORY: f64 = 256e6;

impl OperatorEstimate {
    /// Counts the supernodes between the contact nodes and the root of the elimination tree; the
    /// factor's coefficients are not read.
    #[must_use]
    pub fn new(factor: &CholeskyFactor, coupling: &Coupling, n_contact_nodes: usize) -> Self {
        let reach = factor.reach(coupling.transposed.indices.iter().copied());
        let extent = |offsets: &[usize], s: usize| (offsets[s + 1] - offsets[s]) as f64;
        let sum = |offsets: &[usize]| -> f64 {
            reach.supernodes().iter().map(|&s| extent(offsets, s)).sum()
        };
        let columns = sum(factor.supernode_columns());
        let values = sum(factor.value_offsets());
        let multipliers = coupling.transposed.cols as f64;
        let dense = multipliers * multipliers + 2.0 * n_contact_nodes as f64 * multipliers;
        Self {
            dense_bytes: 8.0 * dense,
            explicit_bytes: 8.0 * (dense + columns * multipliers),
            explicit_operations: 4.0 * values * multipliers + columns * multipliers * multipliers,
            factor_bytes: 8.0 * factor.value_count() as f64,
            action_operations: 4.0 * values,
        }
    }

    /// Whether the dense form pays: it fits in a few times the factor's memory, and forming it
    /// costs less than the applications of a solve.
    #[must_use]
    pub fn prefers_explicit(&self) -> bool {
        self.explicit_bytes <= (4.0 * self.factor_bytes).max(SMALL_MEMORY)
            && self.explicit_operations <= APPLICATIONS_OF_A_SOLVE * self.action_operations
    }
}
