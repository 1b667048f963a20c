//! The discrete contact problem: dual operator, laws of the panes, and the body behind them.
//!
//! The solvers know matrices, panes and laws; here alone they meet a mesh.

use std::borrow::Cow;

use thiserror::Error;

use super::{
    NewtonStep, OuterStep, Solution,
    conditions::{Conditions, Evaluation},
};
use crate::{
    contact::{Interface, MultiplierLayout},
    dual::{Assembly, ContactSystem, DualSystem},
    linalg::{Doubled, Precision},
    mesh::ContactSurface,
    scene::SolveSettings,
    solver::PaneLaws,
};

/// The discrete contact problem of a scene and its assembly, made once and borrowed by all that solves or examines it.
///
/// With the stiffness A of a body, the loads l and the integrals B of displacements over panes, u = A⁻¹(l − Bᵀλ) is the displacement under
/// contact stresses λ = (λ_ν, λ_t). Where only contact or weak springs hold the body, A stands for A_κ, which is invertible, and
/// rigid-body motions, the columns of Z, are added, u = A⁻¹(l − Bᵀλ) + Z α. With S = B A⁻¹ Bᵀ, h = B A⁻¹ l − gap and G = B Z,
///
///   r = S λ − G α − h = gap − B u,      Gᵀλ + D α = e,
///
/// where D is the stiffness of weak springs in these motions, 0 without, and e the resultant of the loads: the second equation, the
/// equilibrium of rigid-body motions ([`crate::dual::RigidEquilibrium`]), is there if the motions are.
///
/// On each pane λ_ν ≥ 0, r_ν ≥ 0, λ_ν r_ν = 0 (Signorini), and λ_t is the point of the ellipse ‖𝓕⁻¹λ_t‖ ≤ g that does most work against
/// the slip. Frictionless contact has g = 0; Tresca's law a given g, and then λ minimises ½ λᵀSλ − λᵀh over the ellipses; Coulomb's
/// law g = λ_ν and 𝓕 = 𝓕(u_t), which is a fixed point of such minimisations. `conditions.rs` has the natural map R, whose roots
/// are the solutions.
pub struct ContactProblem<'a> {
    /// S, h and the equilibrium of rigid-body motions.
    pub(super) dual: Cow<'a, ContactSystem>,
    pub(super) laws: PaneLaws,
    pub(super) body: ContactBody<'a>,
    /// Makes the same with contact springs in A.
    pub(super) system: &'a DualSystem,
}

impl<'a> ContactProblem<'a> {
    /// `None` where the assembly has no contact face.
    #[must_use]
    pub fn new(system: &'a DualSystem, face: ContactSide<'a>) -> Option<Self> {
        let (assembly, dual) = (&system.assembly, system.contact.as_ref()?);
        let balanced = dual.balanced(assembly, face.surface, face.interface);
        Some(Self {
            dual: balanced.map_or(Cow::Borrowed(dual), Cow::Owned),
            laws: face.laws(),
            body: ContactBody { assembly, face },
            system,
        })
    }
}

/// One solve of a contact problem: the problem, the settings, and where it begins.
#[derive(Clone, Copy)]
pub(super) struct ContactSolve<'a> {
    /// S and h, and the equilibrium of rigid-body motions.
    pub(super) dual: &'a ContactSystem,
    pub(super) laws: &'a PaneLaws,
    /// Where residuals in twice the working precision come from.
    pub(super) body: ContactBody<'a>,
    /// Makes the same problem with contact springs in A.
    pub(super) system: &'a DualSystem,
    pub(super) settings: &'a SolveSettings,
    pub(super) start: Start<'a>,
}

impl ContactSolve<'_> {
    /// The multipliers of a solution, with the rigid motions of a body that floats.
    pub(super) fn unknowns(&self, solution: &Solution) -> Vec<f64> {
        let mut unknowns = solution.multiplier.clone();
        unknowns.extend(solution.rigid.iter().flat_map(|rigid| &rigid.motion));
        unknowns.resize(self.dual.n_unknowns(), 0.0);
        unknowns
    }

    /// A⁻¹(l − Bᵀλ) to the share `target`, from that of unknowns nearby, with u, and B u − gap in twice the working precision.
    pub(super) fn state_at(
        &self,
        unknowns: &[f64],
        start: Option<&Doubled>,
        target: f64,
    ) -> RefinedState {
        let ContactBody { assembly, face } = self.body;
        let (surface, interface, dofs) = (face.surface, face.interface, &assembly.primal.dofs);
        let solved = self.dual.refined(assembly, unknowns, start, target);
        let mut displacement = solved.value.clone();
        let (_, motion) = self.dual.parts(unknowns);
        self.dual.add_motion(motion, &mut displacement);
        let gap_residual = self
            .dual
            .gap_residual_refined(&solved, unknowns, dofs, surface, interface);
        RefinedState {
            unknowns: unknowns.to_vec(),
            gap_residual,
            displacement,
            solved,
        }
    }

    /// R at unknowns, with the displacement of [`Self::state_at`].
    pub(super) fn residual_at(
        &self,
        conditions: &Conditions<'_>,
        unknowns: &[f64],
        start: Option<&Doubled>,
        target: f64,
    ) -> (RefinedState, Evaluation) {
        let state = self.state_at(unknowns, start, target);
        let (displacement, gap_residual) = (&state.displacement, &state.gap_residual);
        let body = &self.body;
        let here = body.conditions_at(self.dual, conditions, unknowns, displacement, gap_residual);
        (state, here)
    }

    /// S v − G α in m³ and the change of (u_t1, u_t2) at the contact nodes in m, for a change v of the multipliers that moves the
    /// body by −`response` and α of the motions.
    pub(super) fn change(
        &self,
        mut response: Vec<f64>,
        motion: &[f64],
    ) -> (Vec<f64>, Vec<[f64; 2]>) {
        if let Some(equilibrium) = self.dual.rigid() {
            let back: Vec<f64> = motion.iter().map(|a| -a).collect();
            equilibrium.coupling.add_motion(&back, &mut response);
        }
        let ContactBody { assembly, face } = self.body;
        let (frame, dofs) = (&face.interface.frame, &assembly.primal.dofs);
        let slips = frame.nodal_tangential(face.surface, dofs, |row| {
            dofs.change_at_node(row, &response)
        });
        let slips = slips.iter().map(|u| u.map(|u| -u)).collect();
        (self.dual.coupling.integrate(&response), slips)
    }
}

/// What an observer of a solve sees.
#[derive(Debug, Clone, Copy)]
pub enum Progress<'a> {
    /// Step k of successive approximations.
    Outer(usize, &'a OuterStep),
    /// Successive approximations between two steps.
    Between(&'a OuterState),
    /// Step k of Newton's method.
    Newton(usize, &'a NewtonStep),
}

/// Where a solve begins; λ = 0 by default. What does not fit the number of multipliers is left out.
#[derive(Debug, Clone, Copy, Default)]
pub struct Start<'a> {
    /// The multipliers of a similar problem, `[n_multipliers]`, in Pa.
    pub multiplier: Option<&'a [f64]>,
    /// Successive approximations go on from here.
    pub checkpoint: Option<&'a OuterState>,
}

impl<'a> Start<'a> {
    /// From multipliers, `[n_multipliers]`, in Pa.
    pub(crate) fn at(multiplier: &'a [f64]) -> Self {
        Self {
            multiplier: Some(multiplier),
            checkpoint: None,
        }
    }
}

/// Successive approximations between two steps: all that the next step depends on, so that a solve
/// that goes on from here gives the same bits.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct OuterState {
    /// λ, `[n_multipliers]`, in Pa.
    pub multiplier: Vec<f64>,
    /// φ at the contact nodes in m; `None` unless friction follows the slip.
    pub slip: Option<Vec<[f64; 2]>>,
    /// Tolerance of the last inner problem.
    pub tolerance: f64,
    /// Steplength ᾱ, in Pa/m³.
    pub steplength: f64,
    /// The steps done.
    pub history: Vec<OuterStep>,
    /// Evaluations of the friction law so far.
    pub law_evaluations: usize,
}

/// A method that needs what the assembled problem does not hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error(
    "{0} needs the explicit dual operator, but /assemble holds the implicit one; \
     set assemble.dual_operator = \"explicit\" (`assemble --set assemble.dual_operator=\"explicit\"`), or solve.method = \"auto\""
)]
pub struct NeedsExplicit(pub(super) &'static str);

/// Γ_c and what a scene asks of it.
#[derive(Debug, Clone, Copy)]
pub struct ContactSide<'a> {
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
    pub face: ContactSide<'a>,
}

/// Unknowns with their displacement in twice the working precision.
pub(super) struct RefinedState {
    /// λ in Pa and the rigid motions, `[n_unknowns]`.
    pub(super) unknowns: Vec<f64>,
    /// A⁻¹(l − Bᵀλ) in m, u of a body that supports hold.
    pub(super) solved: Doubled,
    /// u.
    pub(super) displacement: Vec<f64>,
    /// B u − gap in m³, `[n_multipliers]`.
    pub(super) gap_residual: Vec<f64>,
}

impl ContactSide<'_> {
    /// Number of panes m.
    #[must_use]
    pub fn n_panes(&self) -> usize {
        self.surface.n_panes()
    }

    /// The panes and their laws, for one solve.
    #[must_use]
    pub fn laws(&self) -> PaneLaws {
        PaneLaws {
            layout: MultiplierLayout::new(self.n_panes(), self.interface.n_friction_panes()),
            area: self.surface.pane_area.clone(),
            average: self.surface.pane_average.clone(),
            friction: self.interface.friction.clone(),
            previous: self.interface.previous.clone(),
        }
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
        let dofs = &self.assembly.primal.dofs;
        frame.nodal_tangential(surface, dofs, |row| dofs.at_node(row, displacement))
    }

    /// R at unknowns with their displacement u in m and B u − gap in m³.
    pub(super) fn conditions_at(
        &self,
        dual: &ContactSystem,
        conditions: &Conditions<'_>,
        unknowns: &[f64],
        displacement: &[f64],
        gap_residual: &[f64],
    ) -> Evaluation {
        let mut gradient: Vec<f64> = gap_residual.iter().map(|c| -c).collect();
        if let Some(equilibrium) = dual.rigid() {
            let (multiplier, motion) = dual.parts(unknowns);
            gradient.extend(equilibrium.equilibrium_residual(multiplier, motion));
        }
        conditions.evaluate(unknowns, &gradient, &self.tangential(displacement))
    }
}
