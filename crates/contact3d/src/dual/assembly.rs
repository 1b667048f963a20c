//! The elastic problem, its factor, and solves with it: refinement or conjugate gradients about the factor.

use std::{collections::BTreeMap, sync::Arc, time::Instant};

use thiserror::Error;

use super::{InsufficientResource, Requirement};
use crate::{
    elasticity::{
        DofMap, Loads, MaterialField, NodeGraph, RigidModes, SpringMatrix, forces_of_prescribed,
        loose_motions_of_bodies, prescribed_displacements, rigid_modes, stiffness_on, tool_loads,
    },
    linalg::{
        CgSolution, CscMatrix, Doubled, EngineError, Factor, FactorError, FactorStructure,
        Precision, RemoteFactor, Work, add_scaled, conjugate_gradients, expand_to_unknowns,
        nested_dissection, norm,
    },
    mesh::Mesh,
    scene::{InvalidValue, Scene},
};

/// The discrete elastic problem A u = l.
#[derive(Debug, Clone, PartialEq)]
pub struct PrimalSystem {
    /// Numbering of the free degrees of freedom.
    pub dofs: DofMap,
    /// Stiffness A, `[n_free, n_free]`, in N/m; shared by problems that differ in their loads.
    pub stiffness: Arc<CscMatrix>,
    /// Right-hand side over the free degrees of freedom, `[n_free]`, in N: the load l, less A_fc u_c where clamps hold at
    /// a displacement u_c.
    pub load: Vec<f64>,
    /// The rigid modes of a body that only contact holds, or weak springs, and of free tools; `None` where all are held.
    pub rigid_modes: Option<Arc<RigidModes>>,
}

impl PrimalSystem {
    /// A, or A_κ where the body floats: what the factor is of.
    #[must_use]
    pub fn invertible(&self) -> &CscMatrix {
        match &self.rigid_modes {
            None => &self.stiffness,
            Some(rigid) => &rigid.grounded,
        }
    }

    /// Replaces the load, and the displacements at which the clamps hold, by those of a scene that differs in no more.
    ///
    /// # Errors
    /// A load that is not finite.
    pub fn apply_loads(&mut self, scene: &Scene, mesh: &Mesh) -> Result<(), InvalidValue> {
        let prescribed = prescribed_displacements(scene, mesh)?;
        self.load = load_vector(scene, mesh, &self.dofs, prescribed.as_deref())?;
        self.dofs.prescribed = prescribed.map(Arc::new);
        Ok(())
    }
}

/// The elastic problem and the Cholesky factor of its stiffness.
#[derive(Debug, Clone, PartialEq)]
pub struct Assembly {
    /// A and l.
    pub primal: PrimalSystem,
    /// Sparse Cholesky factor of A, or of A_κ where the body floats, shared as A is.
    pub factor: Arc<Factor>,
    /// What took how long.
    pub seconds: AssemblySeconds,
}

/// Wall-clock seconds of the parts of an assembly.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AssemblySeconds {
    /// Stiffness and load.
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
    /// A body that is not held, or a load that cannot be integrated.
    #[error("{}: expected {}, found {}; {}", .0.key, .0.expected, .0.found, .0.help)]
    Scene(InvalidValue),
    /// A is not positive definite.
    #[error(
        "the stiffness matrix is not positive definite at node {node}, component {component}: {source}. \
         Likely causes: a Poisson ratio too close to 0.5, elements so thin that rounding decides, or numbers too \
         large or too small for double precision"
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
    /// Too little memory or disk space.
    #[error(transparent)]
    InsufficientResource(#[from] InsufficientResource),
    /// The program that was to hold the factor.
    #[error(transparent)]
    Engine(#[from] EngineError),
}

/// A and l with the structure of A's factor, before the numeric factorisation.
#[derive(Debug)]
pub(super) struct Analysed {
    pub(super) primal: PrimalSystem,
    pub(super) structure: FactorStructure,
    /// C = K_s Z in N/m, `[n_modes][n_free]`, where weak springs resist the rigid modes.
    support_forces: Option<Vec<Vec<f64>>>,
    seconds: AssemblySeconds,
}

impl Analysed {
    /// Assembles A and l and analyses A, if `admit` lets the stiffness pass.
    pub(super) fn new(
        scene: &Scene,
        mesh: &Mesh,
        admit: &dyn Fn(Requirement) -> Result<(), InsufficientResource>,
    ) -> Result<Self, AssemblyError> {
        let (loose, are_resisted) =
            loose_motions_of_bodies(scene, mesh).map_err(AssemblyError::Scene)?;
        let mut dofs = DofMap::of_scene(scene, mesh);
        if dofs.n_free == 0 {
            return Err(AssemblyError::NothingFree);
        }
        admit(Requirement::of_stiffness(mesh, &dofs, !loose.is_empty()))?;
        let (graph, graph_seconds) = timed(|| NodeGraph::new(mesh));
        let (matrices, order) = rayon::join(
            || {
                timed(|| {
                    let material = MaterialField::new(scene, mesh);
                    let springs = SpringMatrix::of(scene, mesh)?;
                    let stiffness = stiffness_on(&graph, mesh, &material, springs.as_ref(), &dofs);
                    let prescribed = prescribed_displacements(scene, mesh)?;
                    let load = load_vector(scene, mesh, &dofs, prescribed.as_deref())?;
                    Ok((stiffness, springs, load, prescribed))
                })
            },
            || timed(|| fill_reducing_order(mesh, &graph, &dofs)),
        );
        let (matrices, stiffness_seconds) = matrices;
        let (order, ordering_seconds) = order;
        let (stiffness, springs, load, prescribed) = matrices.map_err(AssemblyError::Scene)?;
        let order = order.map_err(AssemblyError::Factor)?;
        let (structure, analysis_seconds) = timed(|| FactorStructure::analyse(&stiffness, order));
        let seconds = AssemblySeconds {
            stiffness: graph_seconds + stiffness_seconds,
            ordering: ordering_seconds,
            factorisation: analysis_seconds,
            dual_operator: 0.0,
        };
        let structure = structure.map_err(|e| explain(e, &dofs))?;
        let rigid_modes =
            rigid_modes(scene, mesh, &dofs, &loose, &stiffness).map_err(AssemblyError::Scene)?;
        let resisting = rigid_modes.as_ref().zip(springs.filter(|_| are_resisted));
        let support_forces = resisting.map(|(rigid, springs)| {
            let force = |mode: &Vec<f64>| dofs.forces(&springs.forces(&dofs.to_nodes(mode)), &[]);
            rigid.modes.iter().map(force).collect()
        });
        dofs.prescribed = prescribed.map(Arc::new);
        Ok(Self {
            primal: PrimalSystem {
                dofs,
                stiffness: Arc::new(stiffness),
                load,
                rigid_modes: rigid_modes.map(Arc::new),
            },
            support_forces,
            structure,
            seconds,
        })
    }

    /// Factorises A, and tells `work` how far it is.
    pub(super) fn factorise(
        &self,
        precision: Precision,
        work: &Work,
    ) -> Result<Assembly, AssemblyError> {
        let started = Instant::now();
        let stiffness = self.primal.invertible();
        let factor = Factor::of_structure(self.structure.clone(), stiffness, precision, work)
            .map_err(|e| explain(e, &self.primal.dofs))?;
        Ok(self.assembly(factor, started))
    }

    /// Has an engine factorise A, and form S for a Bᵀ.
    pub(super) fn factorise_by(
        &self,
        engine: &str,
        transposed: CscMatrix,
    ) -> Result<Assembly, AssemblyError> {
        let started = Instant::now();
        let (structure, stiffness) = (self.structure.clone(), self.primal.invertible());
        let factor = RemoteFactor::new(engine, structure, stiffness, transposed)?;
        Ok(self.assembly(Factor::Remote(factor), started))
    }

    fn assembly(&self, factor: Factor, started: Instant) -> Assembly {
        let mut seconds = self.seconds;
        seconds.factorisation += started.elapsed().as_secs_f64();
        let mut assembly = Assembly {
            primal: self.primal.clone(),
            factor: Arc::new(factor),
            seconds,
        };
        if let Some((forces, rigid)) = self
            .support_forces
            .as_ref()
            .zip(self.primal.rigid_modes.as_ref())
        {
            let mut spring_response = |force: &Vec<f64>| {
                let solved = assembly.solve_refined(force, None, f64::EPSILON);
                solved.value.iter().map(|u| -u).collect()
            };
            let spring_response: Vec<Vec<f64>> = forces.iter().map(&mut spring_response).collect();
            let rigid = RigidModes::clone(rigid).resisted(forces, spring_response);
            assembly.primal.rigid_modes = Some(Arc::new(rigid));
        }
        assembly
    }
}

/// l − A_fc u_c over the free degrees of freedom in N, for u_c in m, `[n_nodes]`; `None` where all clamps hold at zero.
fn load_vector(
    scene: &Scene,
    mesh: &Mesh,
    dofs: &DofMap,
    prescribed: Option<&[[f64; 3]]>,
) -> Result<Vec<f64>, InvalidValue> {
    let nodal = Loads::of(scene).nodal_forces(mesh)?;
    let mut rhs = dofs.forces(&nodal, &tool_loads(scene, mesh)?);
    if let Some(prescribed) = prescribed {
        let material = MaterialField::new(scene, mesh);
        let elastic = forces_of_prescribed(mesh, &material, prescribed);
        let springs = SpringMatrix::of(scene, mesh)?;
        let springs = springs.map(|springs| springs.forces(prescribed));
        for taken in [Some(elastic), springs].into_iter().flatten() {
            add_scaled(&mut rhs, -1.0, &dofs.forces(&taken, &[]));
        }
    }
    Ok(rhs)
}

/// Nested dissection of the mesh without its held nodes, the free degrees of freedom node by node.
fn fill_reducing_order(
    mesh: &Mesh,
    graph: &NodeGraph,
    dofs: &DofMap,
) -> Result<Vec<usize>, FactorError> {
    let is_free = |node: usize| dofs.dof[node].iter().any(Option::is_some);
    let free: Vec<usize> = (0..dofs.n_nodes).filter(|&node| is_free(node)).collect();
    let mut place = vec![None; dofs.n_nodes];
    for (new, &node) in free.iter().enumerate() {
        place[node] = Some(new);
    }
    let mut followers: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (&node, follows) in &dofs.glued {
        for (other, _) in follows {
            followers.entry(*other).or_default().push(node);
        }
    }
    let followed = |node: usize| {
        let follows = dofs.glued.get(&node).into_iter().flatten();
        follows.map(|(other, _)| *other).chain([node])
    };
    let mut free_offsets = vec![0];
    let mut free_neighbours = Vec::new();
    for &node in &free {
        let around = followers.get(&node).into_iter().flatten().copied();
        let around = [node].into_iter().chain(around);
        let around = around.flat_map(|at| graph.neighbours(at)).copied();
        let mut others: Vec<usize> = around.flat_map(followed).collect();
        if !dofs.glued.is_empty() {
            others.sort_unstable();
            others.dedup();
        }
        let others = others.into_iter().filter(|other| *other != node);
        free_neighbours.extend(others.filter_map(|other| place[other]));
        free_offsets.push(free_neighbours.len());
    }
    let points: Vec<[f64; 3]> = free.iter().map(|&node| mesh.coordinates[node]).collect();
    let order = nested_dissection(&free_offsets, &free_neighbours, &points)?;
    let of_node = |new: usize| dofs.dof[free[new]].into_iter().flatten();
    let mut unknowns = expand_to_unknowns(&order, of_node);
    let of_tools = dofs.dof[dofs.n_nodes..].as_flattened().iter();
    unknowns.extend(of_tools.flatten());
    Ok(unknowns)
}

/// A value and the seconds that it took.
fn timed<T>(compute: impl FnOnce() -> T) -> (T, f64) {
    let started = Instant::now();
    let value = compute();
    (value, started.elapsed().as_secs_f64())
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

/// What conjugate gradients leave of a correction at most, where the factor is in single precision: after two steps or so.
pub(super) const CG_LEFT: f64 = 1e-8;

impl Assembly {
    /// The displacement A⁻¹l over the free degrees of freedom in m: the body without contact.
    #[must_use]
    pub fn unconstrained(&self) -> Vec<f64> {
        self.solve(&self.primal.load)
    }

    /// The displacement A⁻¹f of nodal forces f in N over the free degrees of freedom, in m.
    #[must_use]
    pub fn solve(&self, forces: &[f64]) -> Vec<f64> {
        match self.factor.precision() {
            Precision::Double => self.solve_once(forces),
            Precision::Single => self.solve_refined(forces, None, f64::EPSILON).value,
        }
    }

    fn solve_once(&self, forces: &[f64]) -> Vec<f64> {
        let mut displacement = forces.to_vec();
        self.factor.solve_in_place(&mut displacement);
        displacement
    }

    /// A⁻¹f for several f but for a `share` of each, in one reading of a factor in double precision, else by conjugate gradients that
    /// share its readings.
    pub(crate) fn solve_several(&self, mut forces: Vec<Vec<f64>>, share: f64) -> Vec<Vec<f64>> {
        match self.factor.precision() {
            Precision::Double => {
                let columns = forces.iter_mut().map(Vec::as_mut_slice);
                self.factor.solve_several(&mut columns.collect::<Vec<_>>());
                forces
            }
            Precision::Single => {
                let forces: Vec<&[f64]> = forces.iter().map(Vec::as_slice).collect();
                let a = self.primal.invertible();
                let solved = conjugate_gradients(a, &self.factor, &forces, share, 0.0);
                solved.into_iter().map(|solved| solved.solution).collect()
            }
        }
    }

    /// A⁻¹f by conjugate gradients, but for a share of it or a length.
    pub(super) fn by_gradients(&self, forces: &[f64], share: f64, length: f64) -> CgSolution {
        let a = self.primal.invertible();
        conjugate_gradients(a, &self.factor, &[forces], share, length).remove(0)
    }

    /// A⁻¹f from a start, or from zero, refined with residuals in twice the working precision until the
    /// corrections no longer fall, or are below `target` ‖u‖: accurate while ε_M cond(A) < 1
    /// (N. J. Higham, *Accuracy and Stability of Numerical Algorithms*, SIAM 2002, theorem 12.1).
    pub(crate) fn solve_refined(
        &self,
        forces: &[f64],
        start: Option<&Doubled>,
        target: f64,
    ) -> Doubled {
        let mut displacement = match start {
            Some(start) => start.clone(),
            None => Doubled::from(vec![0.0; forces.len()]),
        };
        let mut last = f64::INFINITY;
        // Each of six refinements wins at least the digits that cond(A) leaves.
        for _ in 0..=6 {
            let whole = norm(&displacement.value);
            let residual = match whole {
                0.0 => forces.to_vec(),
                _ => self
                    .primal
                    .invertible()
                    .symmetric_residual(&displacement, forces),
            };
            let (correction, left) = self.correction(&residual, whole, target);
            let size = norm(&correction);
            // A first correction of no more than rounding changes nothing; NaN ends here too.
            if !(size > 0.0 && size < 0.5 * last) {
                break;
            }
            // What the next correction would be: those of a factor in double precision fall by one factor, ε_M cond(A).
            let next = match left {
                Some(left) => left * size,
                None if whole == 0.0 => f64::INFINITY,
                None => size * size / if last.is_finite() { last } else { whole },
            };
            displacement.add(&correction);
            if whole > 0.0 {
                last = size;
            }
            if next <= target * whole.max(size) {
                break;
            }
        }
        displacement
    }

    /// A⁻¹r for the residual r of a displacement of length `whole`, and the share of it that is left, where that is known.
    fn correction(&self, residual: &[f64], whole: f64, target: f64) -> (Vec<f64>, Option<f64>) {
        match self.factor.precision() {
            Precision::Double => (self.solve_once(residual), None),
            Precision::Single => {
                let least = if whole > 0.0 { 0.0 } else { target };
                let (share, length) = (CG_LEFT.max(least), target * whole);
                let solved = self.by_gradients(residual, share, length);
                let left = solved.left();
                (solved.solution, Some(left))
            }
        }
    }
}
