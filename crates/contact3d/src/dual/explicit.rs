//! The dual problem as arrays.

use std::{borrow::Cow, sync::Arc};

use super::{
    Assembly, ContactCompliance, ContactSystem, RigidEquilibrium,
    contact::{free_slip, pairs, tangential_selection},
    dense::{correct, subtract_product, symmetric_product},
};
use crate::{
    contact::{ContactFrame, Coupling, Interface, MultiplierLayout},
    elasticity::DofMap,
    linalg::{
        CholeskyFactor, CscMatrix, Factor, Precision, Scalar, Work, add_scaled, difference,
        power_of_two_near_largest,
    },
    mesh::ContactSurface,
};

/// The dual problem as arrays: S, h and, where friction follows the slip, the compliance of
/// the contact nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct ExplicitDual {
    /// S = B A⁻¹ Bᵀ, exactly symmetric, column-major, `[n_multipliers, n_multipliers]`, in m³/Pa; shared by problems that differ in
    /// their loads.
    pub operator: Arc<Vec<f64>>,
    /// h = B A⁻¹ l with the gap's integral subtracted, `[n_multipliers]`, in m³; −r(λ₀) where the
    /// problem is written about an anchor λ₀.
    pub rhs: Vec<f64>,
    /// x₀, λ₀ in Pa and where the body floats α₀ in m, where the problem is written about an anchor; `None` for zero.
    pub anchor: Option<Vec<f64>>,
    /// The order of the multipliers.
    pub layout: MultiplierLayout,
    /// The compliance of the contact nodes; `None` where no friction law asks for slip.
    pub compliance: Option<ContactCompliance>,
    /// What else holds where the body floats or its supports are weak: its unknowns x are then (λ, α), r = S λ − G α − h and
    /// Gᵀλ + D α = e; `None` where supports hold it, and x = λ.
    pub rigid: Option<RigidEquilibrium>,
    /// σ of contact springs in A, `[n_multipliers]`, in Pa/m³, where S, H and h are those with the springs: its unknowns are then
    /// μ = λ + σ r. `None` for x = λ.
    pub contact_springs: Option<Arc<Vec<f64>>>,
}

impl ExplicitDual {
    /// Forms S and H in the precision of the factor by forward solves W = L⁻¹PBᵀ on the supernodes B reaches, S = WᵀW, beside a given h
    /// in m³; the free slip is that of the displacement A⁻¹l in m. `work` is told of the operations.
    #[must_use]
    pub fn new(
        assembly: &Assembly,
        coupling: &Coupling,
        rhs: Vec<f64>,
        unconstrained: &[f64],
        (surface, interface): (&ContactSurface, &Interface),
        work: &Work,
    ) -> Self {
        let (frame, dofs) = (&interface.frame, &assembly.primal.dofs);
        let follows_slip = interface.follows_slip();
        let selection = follows_slip.then(|| tangential_selection(surface, frame, dofs));
        let (operator, matrix) = corrected(assembly, coupling, selection.as_ref(), work);
        let compliance = matrix.map(|matrix| ContactCompliance {
            matrix: Arc::new(matrix),
            slip_free: free_slip(unconstrained, surface, frame, dofs),
        });
        Self {
            compliance,
            ..Self::without_compliance(operator, rhs, coupling)
        }
    }

    fn without_compliance(operator: Vec<f64>, rhs: Vec<f64>, coupling: &Coupling) -> Self {
        Self {
            operator: Arc::new(operator),
            rhs,
            anchor: None,
            layout: coupling.layout,
            compliance: None,
            rigid: None,
            contact_springs: None,
        }
    }

    /// S and h of a body that supports hold, with tangential pairs on all panes, with friction or not, and no contact compliance.
    #[must_use]
    pub fn everywhere(
        assembly: &Assembly,
        surface: &ContactSurface,
        interface: &Interface,
    ) -> Self {
        let dofs = &assembly.primal.dofs;
        let coupling = interface.coupling_everywhere(surface, dofs);
        let unconstrained = assembly.unconstrained();
        let system = ContactSystem::new(coupling, &unconstrained, dofs, surface, interface);
        let (operator, _) = corrected(assembly, &system.coupling, None, &Work::default());
        Self::without_compliance(operator, system.dual_rhs().to_vec(), &system.coupling)
    }

    /// The same problem written about λ₀ with its exact displacement u₀ in m: r = S (λ − λ₀) − c for
    /// c = B u₀ − gap in m³, u_t = C u₀ − H (λ − λ₀).
    ///
    /// Near λ₀ the rounding of S, H and h then counts only in proportion to λ − λ₀ (iterative
    /// refinement); what cancels in S λ − h, the rigid motion of a body that nearly floats, cancelled
    /// in c already.
    pub(crate) fn about(
        &self,
        multiplier: &[f64],
        displacement: &[f64],
        gap_residual: Vec<f64>,
        surface: &ContactSurface,
        frame: &ContactFrame,
        dofs: &DofMap,
    ) -> Self {
        let (stresses, motion) = (self.multipliers(multiplier), self.motion(multiplier));
        let mut anchored = Self {
            operator: self.operator.clone(),
            rhs: gap_residual,
            anchor: Some(multiplier.to_vec()),
            layout: self.layout,
            compliance: self.compliance.clone(),
            rigid: self.rigid.as_ref().map(|it| it.about(stresses, motion)),
            contact_springs: self.contact_springs.clone(),
        };
        anchored.apply_loads(displacement, surface, frame, dofs);
        anchored
    }

    /// The same problem written about zero: h = S λ₀ + c, free slip C u₀ + H λ₀. Where S is not exact, its solution is
    /// off by what S is wrong as a share of the way from λ₀.
    pub(crate) fn absolute(self) -> Self {
        let Some(anchor) = &self.anchor else {
            return self;
        };
        let mut rhs = self.apply(self.multipliers(anchor));
        add_scaled(&mut rhs, 1.0, &self.rhs);
        let motion = self.motion(anchor);
        if let Some(balance) = &self.rigid {
            let moved = balance.coupling.integrals_of(motion, rhs.len());
            add_scaled(&mut rhs, -1.0, &moved);
        }
        let compliance = self.compliance.as_ref().map(|compliance| {
            let mut slip = compliance.slip_free.concat();
            let opposite: Vec<f64> = self.multipliers(anchor).iter().map(|l| -l).collect();
            subtract_product(&compliance.matrix, &opposite, &mut slip);
            let mut slip_free = pairs(&slip);
            let back: Vec<f64> = motion.iter().map(|a| -a).collect();
            self.add_rigid_slip(&back, &mut slip_free);
            ContactCompliance {
                matrix: Arc::clone(&compliance.matrix),
                slip_free,
            }
        });
        let balance = self.rigid.as_ref();
        let balance = balance.map(|it| it.absolute(self.multipliers(anchor), motion));
        Self {
            rhs,
            anchor: None,
            compliance,
            rigid: balance,
            ..self
        }
    }

    /// Recomputes the free slip, where it is held, from the displacement A⁻¹l or that at the anchor in m.
    pub(super) fn apply_loads(
        &mut self,
        displacement: &[f64],
        surface: &ContactSurface,
        frame: &ContactFrame,
        dofs: &DofMap,
    ) {
        if let Some(compliance) = &mut self.compliance {
            compliance.slip_free = free_slip(displacement, surface, frame, dofs);
        }
    }

    /// Number of multipliers: 3m, or m without friction.
    #[must_use]
    pub fn dimension(&self) -> usize {
        self.layout.n_multipliers()
    }

    /// Number of panes m.
    #[must_use]
    pub fn n_panes(&self) -> usize {
        self.layout.n_panes()
    }

    /// The relative rounding error n ε_M of S λ, below which no residual is worth reducing.
    #[must_use]
    pub fn rounding(&self) -> f64 {
        self.dimension() as f64 * f64::EPSILON
    }

    /// One column (or row) of S.
    #[must_use]
    pub fn column(&self, j: usize) -> &[f64] {
        &self.operator[j * self.dimension()..(j + 1) * self.dimension()]
    }

    /// S_jj.
    #[must_use]
    pub fn diagonal(&self, j: usize) -> f64 {
        self.column(j)[j]
    }

    /// Number of unknowns x: the multipliers, and the rigid motions where the body floats.
    #[must_use]
    pub fn n_unknowns(&self) -> usize {
        self.dimension() + self.rigid.as_ref().map_or(0, RigidEquilibrium::n_active)
    }

    /// The same with the force −k (α − α₀) on each rigid motion, for k in N/m and α₀ in m beside the anchor, `[n_active]`.
    pub(crate) fn with_proximal_term(&self, stiffness: &[f64], centre: &[f64]) -> Self {
        let balance = self.rigid.as_ref();
        Self {
            rigid: balance.map(|it| it.with_proximal_term(stiffness, centre)),
            ..self.clone()
        }
    }

    /// λ of x.
    #[must_use]
    pub fn multipliers<'x>(&self, unknowns: &'x [f64]) -> &'x [f64] {
        &unknowns[..self.dimension()]
    }

    /// λ in Pa: the multipliers of x, or μ − σ r with contact springs.
    pub(crate) fn stresses<'x>(&self, unknowns: &'x [f64]) -> Cow<'x, [f64]> {
        let multipliers = self.multipliers(unknowns);
        let Some(springs) = &self.contact_springs else {
            return multipliers.into();
        };
        let gradient = self.gradient(unknowns);
        stresses_between(multipliers, springs, &gradient).into()
    }

    /// α of x, in m.
    pub(crate) fn motion<'x>(&self, unknowns: &'x [f64]) -> &'x [f64] {
        &unknowns[self.dimension()..]
    }

    /// x of λ, with α = 0 where λ comes without it.
    pub(crate) fn unknowns(&self, multiplier: &[f64]) -> Vec<f64> {
        let mut unknowns = multiplier.to_vec();
        unknowns.resize(self.n_unknowns(), 0.0);
        unknowns
    }

    /// r = S λ − h in m³ at x; where the body floats, r = S λ − G α − h and then e − Gᵀλ − D α in N.
    #[must_use]
    pub fn gradient(&self, unknowns: &[f64]) -> Vec<f64> {
        let x = &self.beyond_anchor(unknowns);
        let multiplier = self.multipliers(x);
        let mut gradient = self.apply(multiplier);
        if let Some(balance) = &self.rigid {
            let moved = balance
                .coupling
                .integrals_of(self.motion(x), gradient.len());
            add_scaled(&mut gradient, -1.0, &moved);
        }
        add_scaled(&mut gradient, -1.0, &self.rhs);
        if let Some(balance) = &self.rigid {
            gradient.extend(balance.equilibrium_residual(multiplier, self.motion(x)));
        }
        gradient
    }

    /// Signed (u_t1, u_t2) at the contact nodes, `[n_contact_nodes]`, in m; empty without compliance.
    #[must_use]
    pub fn tangential_displacement(&self, unknowns: &[f64]) -> Vec<[f64; 2]> {
        let Some(compliance) = &self.compliance else {
            return Vec::new();
        };
        let x = &self.beyond_anchor(unknowns);
        let mut slip = compliance.tangential_displacement(self.multipliers(x));
        self.add_rigid_slip(self.motion(x), &mut slip);
        slip
    }

    /// x − x₀ about an anchor.
    fn beyond_anchor<'x>(&self, unknowns: &'x [f64]) -> Cow<'x, [f64]> {
        match &self.anchor {
            Some(anchor) => difference(unknowns, anchor).into(),
            None => unknowns.into(),
        }
    }

    fn add_rigid_slip(&self, motion: &[f64], slip: &mut [[f64; 2]]) {
        if let Some(balance) = &self.rigid {
            balance.coupling.add_slip(motion, slip);
        }
    }

    /// S λ in m³.
    #[must_use]
    pub fn apply(&self, multiplier: &[f64]) -> Vec<f64> {
        symmetric_product(&self.operator, multiplier)
    }
}

/// λ = μ − σ r of contact springs, or its change.
pub(crate) fn stresses_between(unknowns: &[f64], springs: &[f64], gradient: &[f64]) -> Vec<f64> {
    let mut stresses = unknowns.to_vec();
    for ((stress, spring), r) in stresses.iter_mut().zip(springs).zip(gradient) {
        *stress -= spring * r;
    }
    stresses
}

/// S, and H where a selection Cᵀ is given; those of a factor in single precision with the modes of the body as a whole in double.
fn corrected(
    assembly: &Assembly,
    coupling: &Coupling,
    selection: Option<&CscMatrix>,
    work: &Work,
) -> (Vec<f64>, Option<Vec<f64>>) {
    let (mut operator, mut matrix) = formed(&assembly.factor, coupling, selection, work);
    if assembly.factor.precision() == Precision::Double {
        return (operator, matrix);
    }
    let compliance = matrix.as_mut();
    correct(assembly, coupling, selection, &mut operator, compliance);
    (rounded(operator), matrix.map(rounded))
}

/// S, and H where a selection Cᵀ is given, in the precision of the factor.
pub(super) fn formed(
    factor: &Factor,
    coupling: &Coupling,
    selection: Option<&CscMatrix>,
    work: &Work,
) -> (Vec<f64>, Option<Vec<f64>>) {
    match factor {
        Factor::Double(factor) => formed_here(factor, coupling, selection, work),
        Factor::Single(factor) => formed_here(factor, coupling, selection, work),
        Factor::Remote(factor) => factor.formed(&coupling.transposed, selection),
    }
}

/// With a factor on this machine; panes are measured in a power of two near the largest entry of B, since squares of areas leave the
/// range of single precision early.
fn formed_here<T: Scalar>(
    factor: &CholeskyFactor<T>,
    coupling: &Coupling,
    selection: Option<&CscMatrix>,
    work: &Work,
) -> (Vec<f64>, Option<Vec<f64>>) {
    let mut rows = coupling.transposed.transpose();
    let unit = power_of_two_near_largest(&rows.data).unwrap_or(1.0);
    rows.data.iter_mut().for_each(|value| *value /= unit);
    let half_solved = factor.forward_rows(&rows, work);
    let mut matrix = selection.map(|selection| half_solved.compliance(&selection.transpose()));
    let mut operator = half_solved.gram();
    matrix.iter_mut().flatten().for_each(|value| *value *= unit);
    operator.iter_mut().for_each(|value| *value *= unit * unit);
    (operator, matrix)
}

/// Rounded to 24 bits beside the largest entry, whatever the units: what a file in single precision gives back, where its range
/// holds the entries.
fn rounded(mut matrix: Vec<f64>) -> Vec<f64> {
    if let Some(scale) = power_of_two_near_largest(&matrix) {
        matrix
            .iter_mut()
            .for_each(|value| *value = f64::from((*value / scale) as f32) * scale);
    }
    matrix
}
