//! The dual operators: of a body that its supports hold, through the factor or as a dense matrix, and of one that floats.

use nalgebra::{DMatrix, DVector};

use super::{
    Assembly, ContactSystem, DualOperator, ExplicitDual, PrimalOperator, RigidEquilibrium,
};
use crate::linalg::{Factor, add_combination, add_scaled, dot, largest_eigenvalue};

/// S, and the displacements of the body behind it.
///
/// Without a dense matrix S is applied as the paper does: one pair of sparse triangular solves with the factor of A each time. B
/// touches contact nodes only, so the solves visit just the supernodes between those nodes and the root of the elimination tree;
/// the numbers are those of full solves. Through a factor in single precision each application takes
/// conjugate gradients over the whole body.
pub struct ContactOperator<'a> {
    /// A dense S and its h; `None` where S is applied through the factor.
    dual: Option<&'a ExplicitDual>,
    assembly: &'a Assembly,
    contact: &'a ContactSystem,
    /// The supernodes that contact forces reach, without a dense S.
    reach: Vec<usize>,
    applications: usize,
}

impl<'a> ContactOperator<'a> {
    /// S through the factor of A.
    #[must_use]
    pub fn implicit(assembly: &'a Assembly, contact: &'a ContactSystem) -> Self {
        let touched = contact.coupling.transposed.indices.iter().copied();
        Self {
            dual: None,
            assembly,
            contact,
            reach: assembly.factor.structure().reach(touched),
            applications: 0,
        }
    }

    /// A dense S; the factor that it came from is used only for the displacement.
    #[must_use]
    pub fn explicit(
        dual: &'a ExplicitDual,
        assembly: &'a Assembly,
        contact: &'a ContactSystem,
    ) -> Self {
        Self {
            dual: Some(dual),
            assembly,
            contact,
            reach: Vec::new(),
            applications: 0,
        }
    }
}

impl DualOperator for ContactOperator<'_> {
    fn dimension(&self) -> usize {
        self.contact.layout().n_multipliers()
    }

    fn rhs(&self) -> &[f64] {
        self.dual
            .map_or_else(|| self.contact.dual_rhs(), |dual| &dual.rhs)
    }

    fn apply(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.applications += 1;
        if let Some(dual) = self.dual {
            return dual.apply(multiplier);
        }
        let coupling = &self.contact.coupling;
        let mut moved = coupling.nodal_forces(multiplier);
        match &*self.assembly.factor {
            Factor::Double(factor) => factor.solve_reached(&self.reach, &mut moved),
            Factor::Single(_) | Factor::Remote(_) => moved = self.assembly.solve(&moved),
        }
        coupling.integrate(&moved)
    }

    fn applications(&self) -> usize {
        self.applications
    }
}

impl PrimalOperator for ContactOperator<'_> {
    fn to_primal(&mut self, multiplier: &[f64]) -> Vec<f64> {
        self.applications += 1;
        self.contact.displacement(self.assembly, multiplier)
    }

    fn tangential_displacement(&mut self, multiplier: &[f64]) -> Option<Vec<[f64; 2]>> {
        let dual = self.dual.filter(|dual| dual.compliance.is_some())?;
        Some(dual.tangential_displacement(multiplier))
    }
}

/// S' = P S P + c Q for the projector Q on the range of G = B Z, P = 1 − Q and c = ‖P S P‖: the operator of the augmented
/// Lagrangian.
///
/// For multipliers in balance, Gᵀλ = e, the minimisers of ½ λᵀS'λ − λᵀh' with h' = P (h − S λ_e) + c λ_e and λ_e = G (GᵀG)⁻¹e are those
/// of ½ λᵀSλ − λᵀh; but the springs of A_κ, which S contains and which the answer does not depend on, are gone from S'. It is
/// conditioned as that of a body that is held. The multiplier y of the balance adds Q-parts to h'; S'λ − h' = S λ − h − G α for the
/// motion α with G α = y + Q (S λ − h).
///
/// Motions that weak supports resist take no part in that: their α = D⁻¹(e − Gᵀλ) is eliminated, and S stands for S + G D⁻¹Gᵀ, h for
/// h + G D⁻¹e.
///
/// Sources: C. Farhat, F.-X. Roux, *Int. J. Numer. Meth. Engng* 32 (1991) 1205, for the projector; Z. Dostál, *Optimal Quadratic
/// Programming Algorithms*, Springer 2009, ch. 8, for the augmented Lagrangian with ϱ = ‖A‖.
pub struct BalancedOperator<'a> {
    base: Box<dyn PrimalOperator + 'a>,
    pub(crate) rigid: &'a RigidEquilibrium,
    /// h + G D⁻¹e.
    supported_rhs: Vec<f64>,
    /// Orthonormal columns that span the range of G of the free motions, `[n_free][n_multipliers]`.
    range: Vec<Vec<f64>>,
    /// T with G = range · T.
    triangle: DMatrix<f64>,
    /// c in m³/Pa.
    penalty: f64,
    /// T⁻ᵀ e: what rangeᵀ λ shall be.
    wanted: DVector<f64>,
    /// y in m³ in the basis `range`.
    shift: DVector<f64>,
    /// P (h − S λ_e) + c λ_e.
    rhs_at_rest: Vec<f64>,
    /// The same with y.
    rhs: Vec<f64>,
}

impl<'a> BalancedOperator<'a> {
    /// Projects an operator; some tens of applications for ‖P S P‖.
    #[must_use]
    pub fn new(base: Box<dyn PrimalOperator + 'a>, rigid: &'a RigidEquilibrium) -> Self {
        let n_supported = rigid.coupling.n_supported();
        let integrals = &rigid.coupling.integrals[n_supported..];
        let n = integrals.len();
        let g = DMatrix::from_fn(base.dimension(), n, |j, p| integrals[p][j]);
        let qr = g.qr();
        let (q, triangle) = (qr.q(), qr.r());
        let range: Vec<Vec<f64>> = (0..n)
            .map(|p| q.column(p).iter().copied().collect())
            .collect();
        let resultant = DVector::from_row_slice(&rigid.resultant[n_supported..]);
        let mut supported_rhs = base.rhs().to_vec();
        for (g, e, support) in resisted(rigid) {
            add_scaled(&mut supported_rhs, e / support, g);
        }
        let wanted = solved(triangle.transpose(), resultant);
        let mut operator = Self {
            base,
            rigid,
            supported_rhs,
            range,
            triangle,
            penalty: 0.0,
            wanted,
            shift: DVector::zeros(n),
            rhs_at_rest: Vec::new(),
            rhs: Vec::new(),
        };
        let dimension = operator.base.dimension();
        operator.penalty = largest_eigenvalue(dimension, |v| operator.apply(v));
        let balanced = operator.in_range(&operator.wanted.clone());
        let mut rhs = operator.supported(&balanced);
        for (r, h) in rhs.iter_mut().zip(&operator.supported_rhs) {
            *r = h - *r;
        }
        operator.project(&mut rhs);
        add_scaled(&mut rhs, operator.penalty, &balanced);
        operator.rhs.clone_from(&rhs);
        operator.rhs_at_rest = rhs;
        operator
    }

    /// (S + G D⁻¹Gᵀ) λ.
    fn supported(&mut self, multiplier: &[f64]) -> Vec<f64> {
        let mut product = self.base.apply(multiplier);
        for (g, _, support) in resisted(self.rigid) {
            add_scaled(&mut product, dot(g, multiplier) / support, g);
        }
        product
    }

    /// The combination of the basis of the range.
    fn in_range(&self, coefficients: &DVector<f64>) -> Vec<f64> {
        let mut sum = vec![0.0; self.base.dimension()];
        add_combination(&mut sum, coefficients.as_slice(), &self.range);
        sum
    }

    fn coefficients(&self, vector: &[f64]) -> DVector<f64> {
        DVector::from_iterator(self.range.len(), self.range.iter().map(|q| dot(q, vector)))
    }

    /// P; what it takes away, as coefficients.
    fn project(&self, vector: &mut [f64]) -> DVector<f64> {
        let coefficients = self.coefficients(vector);
        add_combination(vector, (-&coefficients).as_slice(), &self.range);
        coefficients
    }

    /// Q (S λ − h) as coefficients.
    fn gradient_in_range(&mut self, multiplier: &[f64]) -> DVector<f64> {
        let mut gradient = self.supported(multiplier);
        add_scaled(&mut gradient, -1.0, &self.supported_rhs);
        self.coefficients(&gradient)
    }

    fn shift_to(&mut self, shift: DVector<f64>) {
        self.rhs.clone_from(&self.rhs_at_rest);
        add_combination(&mut self.rhs, shift.as_slice(), &self.range);
        self.shift = shift;
    }

    /// The rigid motions α in m that belong to a multiplier.
    pub fn motion(&mut self, multiplier: &[f64]) -> Vec<f64> {
        let moved = &self.shift.clone() + self.gradient_in_range(multiplier);
        let free = solved(self.triangle.clone(), moved);
        let resisted = resisted(self.rigid);
        let resisted = resisted.map(|(g, e, support)| (e - dot(g, multiplier)) / support);
        resisted.chain(free.iter().copied()).collect()
    }

    /// Takes the motions α for those of a multiplier.
    pub fn set_motion(&mut self, multiplier: &[f64], motion: &[f64]) {
        let free = &motion[self.rigid.coupling.n_supported()..];
        let moved = &self.triangle * DVector::from_row_slice(free);
        let gradient = self.gradient_in_range(multiplier);
        self.shift_to(moved - gradient);
    }

    /// Multipliers in balance that do not pull, where successive approximations can begin: without pressure there is no friction to
    /// balance a load with.
    #[must_use]
    pub fn balanced_start(&self) -> Vec<f64> {
        let mut start = self.in_range(&self.wanted);
        let (normal, _) = self.rigid.coupling.layout.split_mut(&mut start);
        normal.iter_mut().for_each(|l| *l = l.max(0.0));
        start
    }

    /// One step of the method of multipliers for the balance, from a multiplier.
    pub fn rebalance(&mut self, multiplier: &[f64]) {
        let missing = &self.wanted - self.coefficients(multiplier);
        self.shift_to(&self.shift + missing * self.penalty);
    }
}

impl DualOperator for BalancedOperator<'_> {
    fn dimension(&self) -> usize {
        self.base.dimension()
    }

    fn rhs(&self) -> &[f64] {
        &self.rhs
    }

    fn apply(&mut self, multiplier: &[f64]) -> Vec<f64> {
        let mut along = multiplier.to_vec();
        let carried = self.project(&mut along);
        let mut product = self.supported(&along);
        self.project(&mut product);
        add_combination(
            &mut product,
            (carried * self.penalty).as_slice(),
            &self.range,
        );
        product
    }

    fn applications(&self) -> usize {
        self.base.applications()
    }
}

impl PrimalOperator for BalancedOperator<'_> {
    fn to_primal(&mut self, multiplier: &[f64]) -> Vec<f64> {
        let motion = self.motion(multiplier);
        let mut displacement = self.base.to_primal(multiplier);
        self.rigid.coupling.add_motion(&motion, &mut displacement);
        displacement
    }

    fn tangential_displacement(&mut self, multiplier: &[f64]) -> Option<Vec<[f64; 2]>> {
        let mut slip = self.base.tangential_displacement(multiplier)?;
        let motion = self.motion(multiplier);
        self.rigid.coupling.add_slip(&motion, &mut slip);
        Some(slip)
    }
}

/// The solution of a square system; zero where it is singular, and none without unknowns, where supports resist all motions.
fn solved(matrix: DMatrix<f64>, rhs: DVector<f64>) -> DVector<f64> {
    if rhs.is_empty() {
        return rhs;
    }
    let n = rhs.len();
    matrix.lu().solve(&rhs).unwrap_or_else(|| DVector::zeros(n))
}

/// G, e and D of each motion that supports resist.
fn resisted(balance: &RigidEquilibrium) -> impl Iterator<Item = (&Vec<f64>, f64, f64)> {
    let coupling = &balance.coupling;
    let motions = coupling
        .integrals
        .iter()
        .zip(&balance.resultant)
        .zip(&coupling.support);
    let motions = motions.take(coupling.n_supported());
    motions.map(|((g, e), support)| (g, *e, *support))
}
