//! The body behind a contact problem: what its operator and the laws of its panes are made of, and what rounding leaves out of them.
//!
//! The solvers know matrices, panes and laws; here alone they meet a mesh.

use crate::{
    contact::{Interface, MultiplierLayout, nodal_tangential, nodal_tangential_change},
    dual::{Assembly, ContactSystem, ExplicitDual, Moved},
    linalg::{Doubled, Precision, Workspace},
    mesh::ContactSurface,
    solver::PaneLaws,
};

/// Γ_c and what a scene asks of it.
#[derive(Debug, Clone, Copy)]
pub struct ContactState<'a> {
    /// Γ_c and its panes.
    pub surface: &'a ContactSurface,
    /// Its frame, gap and friction law.
    pub interface: &'a Interface,
}

/// A factorised body and its contact face.
#[derive(Debug, Clone, Copy)]
pub struct ContactBody<'a> {
    /// A and its factor.
    pub assembly: &'a Assembly,
    /// Γ_c.
    pub face: ContactState<'a>,
}

/// What belongs to some unknowns, to rounding.
pub(super) struct Exact {
    /// A⁻¹(l − Bᵀλ) in m, u of a body that supports hold.
    pub(super) solved: Doubled,
    /// u.
    pub(super) moved: Moved,
    /// B u − gap in m³, `[n_multipliers]`.
    pub(super) closing: Vec<f64>,
}

impl ContactState<'_> {
    /// Number of panes m.
    #[must_use]
    pub fn n_panes(&self) -> usize {
        self.surface.n_panes()
    }

    /// The panes and their laws, for one solve.
    #[must_use]
    pub fn laws(&self) -> PaneLaws {
        PaneLaws::new(
            MultiplierLayout::new(self.n_panes(), self.interface.n_friction_panes()),
            self.surface.pane_area.clone(),
            self.surface.pane_average.clone(),
            self.interface.friction.clone(),
            self.interface.slip.clone(),
        )
    }
}

impl ContactBody<'_> {
    /// Precision of the factor.
    pub(super) fn precision(&self) -> Precision {
        self.assembly.factor.precision()
    }

    /// (u_t1, u_t2) at the contact nodes of a displacement over the free degrees of freedom in m.
    pub(super) fn tangential(&self, displacement: &[f64]) -> Vec<[f64; 2]> {
        let (surface, frame) = (self.face.surface, &self.face.interface.frame);
        nodal_tangential(surface, frame, &self.assembly.primal.dofs, displacement)
    }

    /// A⁻¹(l − Bᵀλ) to the share `target`, from that of unknowns nearby, with u, and B u − gap in twice the working precision.
    pub(super) fn exact(
        &self,
        dual: &ContactSystem,
        unknowns: &[f64],
        start: Option<&Doubled>,
        target: f64,
    ) -> Exact {
        let solved = dual.refined(self.assembly, unknowns, start, target);
        let (surface, interface) = (self.face.surface, self.face.interface);
        let dofs = &self.assembly.primal.dofs;
        Exact {
            closing: dual.closing_refined(&solved, unknowns, dofs, surface, interface),
            moved: dual.moved(unknowns, solved.value.clone()),
            solved,
        }
    }

    /// The dense dual problem written about unknowns.
    pub(super) fn about(
        &self,
        dual: &ExplicitDual,
        unknowns: &[f64],
        exact: &Exact,
    ) -> ExplicitDual {
        let (surface, frame) = (self.face.surface, &self.face.interface.frame);
        let dofs = &self.assembly.primal.dofs;
        let closing = exact.closing.clone();
        dual.anchored(
            unknowns,
            &exact.moved.displacement,
            closing,
            surface,
            frame,
            dofs,
        )
    }

    /// S v − G α in m³ and the change of (u_t1, u_t2) at the contact nodes in m, for changes v of the multipliers and α of the
    /// motions.
    pub(super) fn change(
        &self,
        dual: &ContactSystem,
        stresses: &[f64],
        motion: &[f64],
        work: &mut Workspace,
    ) -> (Vec<f64>, Vec<[f64; 2]>) {
        let forces = dual.coupling.nodal_forces(stresses);
        let mut moved = self.assembly.solve(&forces, work);
        if let Some(balance) = &dual.balance {
            let back: Vec<f64> = motion.iter().map(|a| -a).collect();
            balance.coupling.add_motion(&back, &mut moved);
        }
        let (surface, frame) = (self.face.surface, &self.face.interface.frame);
        let dofs = &self.assembly.primal.dofs;
        let slips = nodal_tangential_change(surface, frame, dofs, &moved);
        let slips = slips.iter().map(|u| u.map(|u| -u)).collect();
        (dual.coupling.integrate(&moved), slips)
    }
}
