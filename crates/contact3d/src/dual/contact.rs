//! What contact adds to the assembled problem: B, S, h and the compliance at contact nodes.

use std::sync::Arc;

use super::{Assembly, ExplicitDual, PrimalSystem, RigidEquilibrium, dense::subtract_product};
use crate::{
    contact::{ContactFrame, Coupling, Interface, MultiplierLayout},
    elasticity::DofMap,
    linalg::{CscMatrix, Doubled, Work, add_scaled},
    mesh::ContactSurface,
};

/// The dual problem's data: minimise ½ λᵀSλ − λᵀh over the admissible multipliers.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactSystem {
    /// Coupling B, in m².
    pub coupling: Coupling,
    /// B A⁻¹ l, `[n_multipliers]`, in m³; empty where h was given without it.
    pub unconstrained: Vec<f64>,
    /// h, S where it is dense, and the equilibrium of rigid-body motions.
    pub form: OperatorForm,
}

/// How S is held; either form holds h = B A⁻¹ l with the gap's integral subtracted from the normal
/// part and that of where a step of a load history begins from the tangential one, `[n_multipliers]`, in m³.
#[derive(Debug, Clone, PartialEq)]
pub enum OperatorForm {
    /// S is applied through the factor.
    Implicit {
        /// h.
        rhs: Vec<f64>,
        /// What else holds where the body floats, for the loads of a solve ([`ContactSystem::balanced`]).
        rigid: Option<RigidEquilibrium>,
    },
    /// S and h as dense arrays, the same of rigid-body motions, and the contact compliance where friction follows the slip.
    Explicit(ExplicitDual),
}

impl OperatorForm {
    /// S is applied through the factor, beside h alone.
    #[must_use]
    pub fn implicit(rhs: Vec<f64>) -> Self {
        Self::Implicit { rhs, rigid: None }
    }
}

impl ContactSystem {
    /// From B and the displacement A⁻¹l in m of a factorised body; S stays implicit.
    pub(super) fn new(
        coupling: Coupling,
        unconstrained: &[f64],
        dofs: &DofMap,
        surface: &ContactSurface,
        interface: &Interface,
    ) -> Self {
        let mut contact = Self {
            coupling,
            unconstrained: Vec::new(),
            form: OperatorForm::implicit(Vec::new()),
        };
        contact.apply_loads(unconstrained, dofs, surface, interface);
        contact
    }

    /// The same with the balance of a body that floats, or whose supports are weak, and motions about the one that closes the gap;
    /// `None` where its supports hold it.
    #[must_use]
    pub fn balanced(
        &self,
        assembly: &Assembly,
        surface: &ContactSurface,
        interface: &Interface,
    ) -> Option<Self> {
        let mut rigid = RigidEquilibrium::new(assembly, &self.coupling, surface, interface)?;
        let distances = self.distances(&assembly.primal.dofs, surface, interface);
        // Coefficients that follow the slip read it from displacements, which have to be whole.
        if distances.iter().any(|d| *d != 0.0) && !interface.follows_slip() {
            rigid = rigid.about_closed_gap(&distances, &surface.pane_area);
        }
        let rhs = rigid.reference.as_ref().map(|reference| {
            let mut rhs = match self.unconstrained.is_empty() {
                true => self.coupling.integrate(&assembly.unconstrained()),
                false => self.unconstrained.clone(),
            };
            add_scaled(&mut rhs, -1.0, &reference.distances);
            rhs
        });
        let rhs = rhs.unwrap_or_else(|| self.dual_rhs().to_vec());
        let form = match &self.form {
            OperatorForm::Implicit { .. } => OperatorForm::Implicit {
                rhs,
                rigid: Some(rigid),
            },
            OperatorForm::Explicit(dual) => OperatorForm::Explicit(ExplicitDual {
                rhs,
                rigid: Some(rigid),
                ..dual.clone()
            }),
        };
        Some(Self {
            coupling: self.coupling.clone(),
            unconstrained: self.unconstrained.clone(),
            form,
        })
    }

    /// The equilibrium of the rigid-body motions of [`Self::balanced`]; `None` where supports hold the body.
    #[must_use]
    pub fn rigid(&self) -> Option<&RigidEquilibrium> {
        match &self.form {
            OperatorForm::Implicit { rigid, .. } => rigid.as_ref(),
            OperatorForm::Explicit(dual) => dual.rigid.as_ref(),
        }
    }

    /// Number of unknowns x: the multipliers λ, and the rigid motions α where the body floats.
    #[must_use]
    pub fn n_unknowns(&self) -> usize {
        self.layout().n_multipliers() + self.rigid().map_or(0, RigidEquilibrium::n_active)
    }

    /// λ and α of x.
    pub(crate) fn parts<'x>(&self, unknowns: &'x [f64]) -> (&'x [f64], &'x [f64]) {
        unknowns.split_at(self.layout().n_multipliers())
    }

    /// The order of the multipliers.
    #[must_use]
    pub fn layout(&self) -> MultiplierLayout {
        self.coupling.layout
    }

    /// h in m³, `[n_multipliers]`.
    #[must_use]
    pub fn dual_rhs(&self) -> &[f64] {
        match &self.form {
            OperatorForm::Implicit { rhs, .. } => rhs,
            OperatorForm::Explicit(dual) => &dual.rhs,
        }
    }

    /// Replaces h.
    pub fn set_dual_rhs(&mut self, next: Vec<f64>) {
        self.unconstrained.clear();
        match &mut self.form {
            OperatorForm::Implicit { rhs, .. } => *rhs = next,
            OperatorForm::Explicit(dual) => dual.rhs = next,
        }
    }

    /// The dense dual problem; `None` when S is applied through the factor.
    #[must_use]
    pub fn explicit(&self) -> Option<&ExplicitDual> {
        match &self.form {
            OperatorForm::Implicit { .. } => None,
            OperatorForm::Explicit(dual) => Some(dual),
        }
    }

    /// As [`Self::explicit`], to change.
    #[must_use]
    pub fn explicit_mut(&mut self) -> Option<&mut ExplicitDual> {
        match &mut self.form {
            OperatorForm::Implicit { .. } => None,
            OperatorForm::Explicit(dual) => Some(dual),
        }
    }

    /// Forms S, and the contact compliance where friction follows the slip, from the displacement A⁻¹l in m.
    pub(super) fn make_explicit(
        &mut self,
        assembly: &Assembly,
        unconstrained: &[f64],
        face: (&ContactSurface, &Interface),
        work: &Work,
    ) {
        let (coupling, rhs) = (&self.coupling, self.dual_rhs().to_vec());
        let dual = ExplicitDual::new(assembly, coupling, rhs, unconstrained, face, work);
        self.form = OperatorForm::Explicit(dual);
    }

    /// Drops a dense S: it is applied through the factor from now on.
    pub fn make_implicit(&mut self) {
        self.form = OperatorForm::implicit(self.dual_rhs().to_vec());
    }

    /// Recomputes h from the displacement A⁻¹l in m of the body without contact, and from the gap.
    pub(super) fn apply_loads(
        &mut self,
        unconstrained: &[f64],
        dofs: &DofMap,
        surface: &ContactSurface,
        interface: &Interface,
    ) {
        let integrals = self.coupling.integrate(unconstrained);
        self.set_dual_rhs(self.beyond(integrals.clone(), dofs, surface, interface));
        self.unconstrained = integrals;
    }

    /// B u with the gap's integral subtracted from the normal part, and in a later step of a load history that of u_tⁿ⁻¹ from
    /// the tangential part: −r of the displacement in m over the free degrees of freedom, `[n_multipliers]`, in m³; held contact
    /// nodes count where they are held.
    #[must_use]
    pub fn gap_residual(
        &self,
        displacement: &[f64],
        dofs: &DofMap,
        surface: &ContactSurface,
        interface: &Interface,
    ) -> Vec<f64> {
        let integrals = self.coupling.integrate(displacement);
        self.beyond(integrals, dofs, surface, interface)
    }

    /// What B u of a displacement is beyond the [distances](Self::distances), in m³.
    fn beyond(
        &self,
        mut integrals: Vec<f64>,
        dofs: &DofMap,
        surface: &ContactSurface,
        interface: &Interface,
    ) -> Vec<f64> {
        let distances = self.distances(dofs, surface, interface);
        add_scaled(&mut integrals, -1.0, &distances);
        integrals
    }

    /// The same of unknowns x = (λ, α) with the displacement A⁻¹(l − Bᵀλ) and its remainder, in twice the working precision.
    pub(crate) fn gap_residual_refined(
        &self,
        displacement: &Doubled,
        unknowns: &[f64],
        dofs: &DofMap,
        surface: &ContactSurface,
        interface: &Interface,
    ) -> Vec<f64> {
        let reference = self.rigid().and_then(|it| it.reference.as_ref());
        let mut distances = match reference {
            Some(reference) => reference.distances.clone(),
            None => self.distances(dofs, surface, interface),
        };
        if let Some(balance) = self.rigid() {
            let n = distances.len();
            let moved = balance.coupling.integrals_of(self.parts(unknowns).1, n);
            add_scaled(&mut distances, -1.0, &moved);
        }
        let transposed = &self.coupling.transposed;
        transposed.transposed_excess(displacement, &distances)
    }

    /// Whether λ = 0 and u = 0 solve the problem: without load or penetration, and without friction that needs no pressure and would resist
    /// slips since the last increment.
    pub(crate) fn is_unloaded(
        &self,
        primal: &PrimalSystem,
        surface: &ContactSurface,
        interface: &Interface,
    ) -> bool {
        if primal.load.iter().any(|force| *force != 0.0) {
            return false;
        }
        let distances = self.distances(&primal.dofs, surface, interface);
        let (normal, tangential) = distances.split_at(surface.n_panes());
        let resists = match interface.coulomb() {
            Some(law) => {
                let bounds = law.slip_bounds(&vec![0.0; surface.n_panes()]);
                bounds.iter().any(|bound| *bound > 0.0)
            }
            None => true,
        };
        let slips = tangential.iter().any(|slip| *slip != 0.0);
        normal.iter().all(|gap| *gap >= 0.0) && !(resists && slips)
    }

    /// What the free degrees of freedom have to close: ∫ gap over each pane and, tangentially, ∫ u_tⁿ⁻¹ of a load history, less B u
    /// of the held contact nodes, `[n_multipliers]`, in m³.
    pub(super) fn distances(
        &self,
        dofs: &DofMap,
        surface: &ContactSurface,
        interface: &Interface,
    ) -> Vec<f64> {
        let mut distances = interface.offsets(surface);
        let coupling = &self.coupling;
        let held = coupling.held_integrals(surface, &interface.frame, dofs);
        distances.resize(coupling.n_multipliers(), 0.0);
        add_scaled(&mut distances, -1.0, &held);
        distances
    }

    /// The displacement u = A⁻¹(l − Bᵀλ) over the free degrees of freedom in m; u = A_κ⁻¹(l − Bᵀλ) + Z α of x = (λ, α) where the
    /// body floats.
    #[must_use]
    pub fn displacement(&self, assembly: &Assembly, unknowns: &[f64]) -> Vec<f64> {
        let (multiplier, motion) = self.parts(unknowns);
        let mut displacement = assembly.solve(&self.forces(assembly, multiplier));
        self.add_motion(motion, &mut displacement);
        displacement
    }

    /// Adds (Z + Y) α of a body that floats.
    pub(crate) fn add_motion(&self, motion: &[f64], displacement: &mut [f64]) {
        if let Some(balance) = self.rigid() {
            balance.coupling.add_motion(motion, displacement);
        }
    }

    /// A⁻¹(l − Bᵀλ) by iterative refinement, from that of a multiplier nearby, to the share `target` of it.
    #[must_use]
    pub fn refined(
        &self,
        assembly: &Assembly,
        unknowns: &[f64],
        start: Option<&Doubled>,
        target: f64,
    ) -> Doubled {
        let (multiplier, _) = self.parts(unknowns);
        let forces = self.forces(assembly, multiplier);
        assembly.solve_refined(&forces, start, target)
    }

    /// l − Bᵀλ in N.
    fn forces(&self, assembly: &Assembly, multiplier: &[f64]) -> Vec<f64> {
        let mut forces = self.coupling.nodal_forces(multiplier);
        for (force, load) in forces.iter_mut().zip(&assembly.primal.load) {
            *force = load - *force;
        }
        forces
    }
}

/// The tangential displacement of the contact nodes, affine in λ: u_t = `slip_free` − H (λ − λ₀)
/// with the anchor λ₀ of the dual problem.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactCompliance {
    /// H = C A⁻¹ Bᵀ with the rows u_t1, u_t2 of contact node after contact node, column-major,
    /// `[2 n_contact_nodes, 3 n_panes]`, in m/Pa; shared as S is.
    pub matrix: Arc<Vec<f64>>,
    /// (u_t1, u_t2) of A⁻¹l, or of the displacement at the anchor, at the contact nodes, signed,
    /// `[n_contact_nodes]`, in m.
    pub slip_free: Vec<[f64; 2]>,
}

impl ContactCompliance {
    /// One column of H, `[2 n_contact_nodes]`.
    #[must_use]
    pub fn column(&self, j: usize) -> &[f64] {
        let rows = 2 * self.slip_free.len();
        &self.matrix[j * rows..(j + 1) * rows]
    }

    /// slip_free − H λ at the contact nodes, `[n_contact_nodes]`, in m.
    pub(super) fn tangential_displacement(&self, multiplier: &[f64]) -> Vec<[f64; 2]> {
        let mut slip = self.slip_free.concat();
        subtract_product(&self.matrix, multiplier, &mut slip);
        pairs(&slip)
    }
}

/// Cᵀ of C u = (u_t1, u_t2) node by node; columns of held degrees of freedom are empty.
pub(super) fn tangential_selection(
    surface: &ContactSurface,
    frame: &ContactFrame,
    dofs: &DofMap,
) -> CscMatrix {
    let mut transposed = CscMatrix::empty(dofs.n_free);
    for local in 0..surface.nodes.len() {
        for axis in frame.axes_at(local) {
            transposed.push_column(frame.terms(surface, dofs, local, *axis));
        }
    }
    transposed
}

/// (u_t1, u_t2) at the contact nodes of a displacement in m, held nodes as they are held.
pub(super) fn free_slip(
    displacement: &[f64],
    surface: &ContactSurface,
    frame: &ContactFrame,
    dofs: &DofMap,
) -> Vec<[f64; 2]> {
    let selection = tangential_selection(surface, frame, dofs);
    let mut slip = vec![0.0; selection.cols];
    selection.mul_transposed(displacement, &mut slip);
    let mut slip = pairs(&slip);
    if dofs.prescribed.is_some() {
        for (local, slip) in slip.iter_mut().enumerate() {
            let held = frame.tangential(local, frame.held(surface, dofs, local));
            *slip = [slip[0] + held[0], slip[1] + held[1]];
        }
    }
    slip
}

pub(super) fn pairs(flat: &[f64]) -> Vec<[f64; 2]> {
    flat.chunks_exact(2).map(|p| [p[0], p[1]]).collect()
}
