//! What assembling takes: memory, disk space and operations, counted before they are spent.

use thiserror::Error;

use crate::{
    contact::Coupling,
    elasticity::DofMap,
    linalg::{CscMatrix, FactorStructure, Precision},
    mesh::Mesh,
};

/// What a step takes beyond what is held already.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Requirement {
    /// The step.
    pub step: &'static str,
    /// Bytes of memory.
    pub memory: u64,
    /// Bytes that will be stored.
    pub stored: u64,
    /// Bytes of what could be made again, a factor, where that is stored too.
    pub remakable: u64,
}

units::worded! {
    /// What there is too little of.
    pub enum Resource {
        /// Memory of the machine, of the process's group, or of its address space.
        Memory = "memory",
        /// Room on the disk, or the largest file a process may write.
        Disk = "disk space",
    }
}

/// A step that does not fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error(
    "{step}: expected at most {} of {}, which is what is available, found a need of {}; {}",
    in_units(*available), resource.word(), in_units(*needed), resource.remedy()
)]
pub struct InsufficientResource {
    /// The step.
    pub step: &'static str,
    /// What there is too little of.
    pub resource: Resource,
    /// Bytes the step takes.
    pub needed: u64,
    /// Bytes there are.
    pub available: u64,
}

impl Resource {
    fn remedy(self) -> &'static str {
        match self {
            Self::Memory => "use a coarser mesh or a machine with more memory",
            Self::Disk => "use a coarser mesh or a run file on another disk",
        }
    }
}

/// The step that computes the factor.
pub(super) const FACTORISING: &str = "factorising the stiffness";

/// Bytes in units that suit them.
fn in_units(bytes: u64) -> String {
    match bytes {
        0..10_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        10_000_000..1_000_000_000 => format!("{:.1} MB", bytes as f64 / 1e6),
        _ => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}

impl Requirement {
    /// A and what it is made from: every pair of nodes of a tetrahedron is coupled by 3 × 3
    /// coefficients.
    ///
    /// Pairs follow from Euler's formula V − E + F − T = 1 of a ball with 2F = 4T + boundary
    /// triangles. P1 has one pair for each edge; P2, where N = V + E, has three within each edge, six
    /// more on each triangle and three more in each tetrahedron. A body that floats has A_κ beside A.
    pub(super) fn of_stiffness(mesh: &Mesh, dofs: &DofMap, floats: bool) -> Self {
        let nodes = mesh.coordinates.len() as f64;
        let [tetrahedra, facets] =
            [mesh.tetrahedra.len(), mesh.facets.len()].map(|count| count as f64);
        let pairs = match mesh.mid_edges {
            None => nodes + tetrahedra + facets / 2.0,
            Some(_) => {
                let edges = (nodes + tetrahedra + facets / 2.0) / 2.0;
                let triangles = 2.0 * tetrahedra + facets / 2.0;
                3.0 * edges + 6.0 * triangles + 3.0 * tetrahedra
            }
        };
        // Held nodes have no rows: the share of free unknowns counts twice.
        let free = dofs.n_free as f64 / (3.0 * nodes);
        let coefficients = 9.0 * (nodes + 2.0 * pairs) * free * free;
        let copies = if floats { 2.0 } else { 1.0 };
        Self {
            step: "assembling the stiffness",
            memory: (16.0 * copies * coefficients) as u64,
            stored: (8.0 * coefficients) as u64,
            remakable: 0,
        }
    }

    /// The factor, counted exactly, and the dense dual operator where it will be formed.
    pub(super) fn of_factor(
        stiffness: &CscMatrix,
        structure: &FactorStructure,
        precision: Precision,
        dense: Option<&OperatorEstimate>,
    ) -> Self {
        let bytes = precision.bytes() as f64;
        let values = bytes * structure.value_count() as f64;
        let scratch = bytes * structure.update_count(rayon::current_num_threads()) as f64;
        let forming = dense.map_or(0.0, |estimate| estimate.forming_bytes(precision));
        let kept = dense.map_or(0.0, |estimate| estimate.dense_bytes);
        // Displacement, stresses and errors on nodes and tetrahedra, for h5py and once more for ParaView: some bytes for each unknown.
        let results = 200.0 * stiffness.cols as f64;
        let stiffness = 8.0 * stiffness.data.len() as f64;
        // Each thread packs the matrices that it multiplies into 64 MiB, once they are large.
        let packing = (67_108_864.0 * rayon::current_num_threads() as f64).min(values);
        Self {
            step: FACTORISING,
            memory: (values + scratch.max(forming) + packing) as u64,
            stored: (stiffness + kept + results) as u64,
            remakable: values as u64,
        }
    }
}

/// What each form of the dual operator would cost, from the structure of the factor alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatorEstimate {
    /// Bytes of S and of the contact compliance.
    pub dense_bytes: f64,
    /// Entries of W on the supernodes that its columns reach.
    pub half_solved: f64,
    /// Floating-point operations that form S and the compliance.
    pub explicit_operations: f64,
    /// Bytes of the Cholesky factor.
    pub factor_bytes: f64,
    /// Floating-point operations of one application of the implicit operator.
    pub action_operations: f64,
}

/// Memory that never matters, in bytes.
pub(crate) const SMALL_MEMORY: f64 = 256e6;

impl OperatorEstimate {
    /// Counts the supernodes between the contact nodes and the root of the elimination tree; the
    /// factor's coefficients are not read.
    #[must_use]
    pub fn new(factor: &FactorStructure, coupling: &Coupling, n_contact_nodes: usize) -> Self {
        let [half_solved, of_solves, of_products] =
            factor.count_forward_rows(&coupling.transposed.transpose());
        let reach = factor.reach(coupling.transposed.indices.iter().copied());
        let offsets = &factor.value_offsets;
        let values: usize = reach.iter().map(|&s| offsets[s + 1] - offsets[s]).sum();
        let multipliers = coupling.transposed.cols as f64;
        let dense = multipliers * multipliers + 2.0 * n_contact_nodes as f64 * multipliers;
        Self {
            dense_bytes: 8.0 * dense,
            half_solved,
            // The compliance takes about as much as the solves: it goes back where they came from.
            explicit_operations: 2.0 * of_solves + of_products,
            factor_bytes: 8.0 * factor.value_count() as f64,
            action_operations: 4.0 * values as f64,
        }
    }

    /// Bytes of S, of the contact compliance, and of W = L⁻¹PBᵀ in some precision, while they are formed.
    #[must_use]
    pub fn forming_bytes(&self, precision: Precision) -> f64 {
        self.dense_bytes + precision.bytes() as f64 * self.half_solved
    }

    /// Whether the dense form pays: it takes no more than eight times the memory of the factor or than [`SMALL_MEMORY`], and forming it costs less
    /// than 1e5 applications of S. Without it, refined meshes with thousands of panes of different sizes take hours.
    ///
    /// The paper's algorithm takes about a thousand applications for four digits and some ten thousand for eight, more where panes differ
    /// in size, and their operations wait for memory, which those that form S do not.
    pub(crate) fn prefers_explicit(&self) -> bool {
        self.forming_bytes(Precision::Double) <= (8.0 * self.factor_bytes).max(SMALL_MEMORY)
            && self.explicit_operations <= 1e5 * self.action_operations
    }
}
