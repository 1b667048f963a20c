use std::time::Instant;

use thiserror::Error;

use crate::{
    contact::Coupling,
    elasticity::{DofMap, load_vector, node_adjacency, stiffness},
    linalg::{
        CholeskyFactor, CscMatrix, FactorError, OrderingError, Workspace, expand_to_unknowns,
        nested_dissection,
    },
    mesh::Mesh,
    scene::Scene,
};

/// The discrete elastic problem A u = l − Bᵀλ.
#[derive(Debug, Clone, PartialEq)]
pub struct PrimalSystem {
    /// Numbering of the free degrees of freedom.
    pub dofs: DofMap,
    /// Stiffness A, `[n_free, n_free]`, in N/m.
    pub stiffness: CscMatrix,
    /// Load l, `[n_free]`, in N.
    pub load: Vec<f64>,
    /// Coupling B = [N; T], in m².
    pub coupling: Coupling,
}

/// Everything the assemble stage makes: the primal system, its factor, and the dual data.
#[derive(Debug, Clone, PartialEq)]
pub struct Assembly {
    /// A, l and B.
    pub primal: PrimalSystem,
    /// Sparse Cholesky factor of A.
    pub factor: CholeskyFactor,
    /// h = B A⁻¹ l with the gap's integral subtracted from the normal part, `[3 n_panes]`, in m³.
    pub dual_rhs: Vec<f64>,
    /// What took how long.
    pub seconds: AssemblySeconds,
}

/// Wall-clock seconds of the parts of an assembly.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AssemblySeconds {
    /// Stiffness, load and coupling.
    pub stiffness: f64,
    /// Fill-reducing order.
    pub ordering: f64,
    /// Symbolic and numeric Cholesky factorisation.
    pub factorisation: f64,
    /// The dense dual operator and the contact compliance; 0 when the operator is implicit.
    pub dual_operator: f64,
}

impl AssemblySeconds {
    /// The parts with their names.
    #[must_use]
    pub fn parts(&self) -> [(&'static str, f64); 4] {
        [
            ("stiffness", self.stiffness),
            ("ordering", self.ordering),
            ("factorisation", self.factorisation),
            ("dual_operator", self.dual_operator),
        ]
    }
}

/// Why a scene has no factorised stiffness.
#[derive(Debug, Error)]
pub enum AssemblyError {
    /// Every node is held.
    #[error(
        "no degree of freedom is free: the clamps hold every node; clamp fewer faces or refine the mesh"
    )]
    NothingFree,
    /// A is not positive definite.
    #[error(
        "the stiffness matrix is not positive definite at node {node}, component {component}: {source}. \
         Likely causes: clamps that leave a rigid motion free, or a Poisson ratio too close to 0.5"
    )]
    NotPositiveDefinite {
        /// Node of the failed pivot.
        node: usize,
        /// Component of the failed pivot (x, y or z).
        component: char,
        /// What the factorisation found.
        source: FactorError,
    },
    /// The factorisation failed for another reason.
    #[error(transparent)]
    Factor(FactorError),
    /// No ordering.
    #[error(transparent)]
    Ordering(#[from] OrderingError),
}

impl Assembly {
    /// Assembles A, l, N, T, factorises A and solves for h.
    ///
    /// # Errors
    /// [`AssemblyError`] when A has no Cholesky factor.
    pub fn new(scene: &Scene, mesh: &Mesh, threads: usize) -> Result<Self, AssemblyError> {
        let dofs = DofMap::new(mesh, &scene.clamps);
        if dofs.n_free == 0 {
            return Err(AssemblyError::NothingFree);
        }
        let started = Instant::now();
        let stiffness = stiffness(mesh, &scene.material.elasticity(), &dofs);
        let load = dofs.to_free(&load_vector(mesh, &scene.tractions));
        let coupling = Coupling::new(&mesh.contact, &scene.contact.frame(), &dofs);
        let assembled = Instant::now();
        let order = fill_reducing_order(mesh, &dofs)?;
        let ordered = Instant::now();
        let factor =
            CholeskyFactor::factorise(&stiffness, order, threads).map_err(|e| explain(e, &dofs))?;
        let seconds = AssemblySeconds {
            stiffness: (assembled - started).as_secs_f64(),
            ordering: (ordered - assembled).as_secs_f64(),
            factorisation: ordered.elapsed().as_secs_f64(),
            dual_operator: 0.0,
        };
        let mut unconstrained = load.clone();
        factor.solve_in_place(&mut unconstrained, &mut Workspace::default());
        let mut dual_rhs = coupling.integrate(&unconstrained);
        for (h, area) in dual_rhs.iter_mut().zip(&mesh.contact.pane_area) {
            *h -= scene.contact.gap * area;
        }
        let primal = PrimalSystem {
            dofs,
            stiffness,
            load,
            coupling,
        };
        Ok(Self {
            primal,
            factor,
            dual_rhs,
            seconds,
        })
    }

    /// The displacement u = A⁻¹(l − Bᵀλ) over the free degrees of freedom in m.
    pub(super) fn displacement(&self, multiplier: &[f64], work: &mut Workspace) -> Vec<f64> {
        let contact_forces = self.primal.coupling.nodal_forces(multiplier);
        let mut displacement: Vec<f64> = self
            .primal
            .load
            .iter()
            .zip(contact_forces)
            .map(|(l, f)| l - f)
            .collect();
        self.factor.solve_in_place(&mut displacement, work);
        displacement
    }
}

/// Nested dissection of the mesh without its held nodes, the free degrees of freedom node by node.
fn fill_reducing_order(mesh: &Mesh, dofs: &DofMap) -> Result<Vec<usize>, OrderingError> {
    let (offsets, neighbours) = node_adjacency(mesh);
    let is_free = |node: usize| dofs.dof[node].iter().any(Option::is_some);
    let free: Vec<usize> = (0..dofs.dof.len()).filter(|&node| is_free(node)).collect();
    let mut place = vec![None; dofs.dof.len()];
    for (new, &node) in free.iter().enumerate() {
        place[node] = Some(new);
    }
    let mut free_offsets = vec![0];
    let mut free_neighbours = Vec::with_capacity(neighbours.len());
    for &node in &free {
        let around = &neighbours[offsets[node]..offsets[node + 1]];
        free_neighbours.extend(around.iter().filter_map(|&other| place[other]));
        free_offsets.push(free_neighbours.len());
    }
    let points: Vec<[f64; 3]> = free.iter().map(|&node| mesh.coordinates[node]).collect();
    let order = nested_dissection(&free_offsets, &free_neighbours, &points)?;
    Ok(expand_to_unknowns(&order, |new| {
        dofs.dof[free[new]].into_iter().flatten()
    }))
}

/// Names the node and component of a failed pivot.
fn explain(error: FactorError, dofs: &DofMap) -> AssemblyError {
    let FactorError::NotPositiveDefinite { column, .. } = error else {
        return AssemblyError::Factor(error);
    };
    let place = dofs.dof.iter().enumerate().find_map(|(node, components)| {
        let component = components.iter().position(|dof| *dof == Some(column))?;
        Some((node, ['x', 'y', 'z'][component]))
    });
    match place {
        Some((node, component)) => AssemblyError::NotPositiveDefinite {
            node,
            component,
            source: error,
        },
        None => AssemblyError::Factor(error),
    }
}
