//! The stiffness of each pane while the others stay, that residuals are measured by.

use std::collections::{BTreeMap, BTreeSet};

use faer::Mat;
use nalgebra::{DMatrix, DVector};

use super::{ExplicitDual, PrimalSystem};
use crate::{
    contact::{Coupling, MultiplierLayout},
    linalg::{DenseCholesky, add_combination, dot},
};

/// The Cholesky factor of S, and from it the stiffness (S⁻¹)_ii of each pane while the others do
/// not move.
///
/// 1/S_ii is the stiffness while all others carry no further stress. For a body that can nearly
/// move as a whole it is that of this motion, smaller by orders of magnitude than what makes a pane
/// stick or slide, so residuals scaled by it look small whatever the panes do. (S⁻¹)_ii ≥ 1/S_ii
/// does not know rigid motions. A tangential pair has one stiffness, half the trace of its block of
/// S⁻¹, so that it does not depend on the choice of axes.
#[derive(Debug, Clone)]
pub struct LocalStiffness {
    /// ρ, `[n_multipliers]`, in Pa/m³; 0 where the row of S vanishes and no clamp drags its nodes along.
    pub stiffness: Vec<f64>,
    layout: MultiplierLayout,
    factor: ScaledFactor,
}

/// LLᵀ = Δ S Δ + shift for Δ = diag(1/√S_ii) over the components whose rows do not vanish.
#[derive(Debug, Clone)]
struct ScaledFactor {
    /// Those components, ascending.
    kept: Vec<usize>,
    /// 1/√S_ii of them.
    scale: Vec<f64>,
    /// `None` of numbers that are not finite.
    factor: Option<DenseCholesky>,
}

impl ScaledFactor {
    /// A third of n³ operations for n multipliers.
    fn new(dual: &ExplicitDual) -> Self {
        let kept = (0..dual.dimension()).filter(|&j| dual.diagonal(j) > 0.0);
        let kept: Vec<usize> = kept.collect();
        let scale = kept.iter().map(|&j| dual.diagonal(j).sqrt().recip());
        let scale: Vec<f64> = scale.collect();
        let entry = |i: usize, j: usize| scale[i] * dual.column(kept[j])[kept[i]] * scale[j];
        Self {
            factor: DenseCholesky::shifted(&Mat::from_fn(kept.len(), kept.len(), entry)),
            kept,
            scale,
        }
    }

    /// S⁻¹h in Pa for h in m³ with the components before one: all, or the normal ones. The others are zero.
    fn solve(&self, rhs: &[f64], end: usize) -> Vec<f64> {
        let count = self.kept.partition_point(|&j| j < end);
        let scaled = (0..count).map(|i| self.scale[i] * rhs[self.kept[i]]);
        let mut x: Vec<f64> = scaled.collect();
        match &self.factor {
            None => x.fill(f64::NAN),
            Some(factor) => factor.solve(&mut x),
        }
        let mut solution = vec![0.0; rhs.len()];
        for (i, x) in x.iter().enumerate() {
            solution[self.kept[i]] = self.scale[i] * x;
        }
        solution
    }
}

impl LocalStiffness {
    /// Factorises S: n³ operations for n multipliers, as one and a half steps of
    /// Newton's method.
    #[must_use]
    pub fn new(dual: &ExplicitDual) -> Self {
        let factor = ScaledFactor::new(dual);
        let mut stiffness = vec![0.0; dual.dimension()];
        let inverse = match &factor.factor {
            None => vec![f64::NAN; factor.kept.len()],
            Some(factor) => factor.inverse_diagonal(),
        };
        for ((&j, inverse), scale) in factor.kept.iter().zip(inverse).zip(&factor.scale) {
            stiffness[j] = inverse * scale * scale;
        }
        for pair in dual.layout.split_mut(&mut stiffness).1 {
            if pair[0] > 0.0 && pair[1] > 0.0 {
                *pair = [0.5 * (pair[0] + pair[1]); 2];
            }
        }
        friction_stiffness(&mut stiffness, dual.layout, &dual.rhs);
        Self {
            stiffness,
            layout: dual.layout,
            factor,
        }
    }

    /// The same where clamps drag contact nodes as another h of the same operator says, too.
    #[must_use]
    pub fn with_friction_stiffness(mut self, rhs: &[f64]) -> Self {
        if rhs.len() == self.stiffness.len() {
            friction_stiffness(&mut self.stiffness, self.layout, rhs);
        }
        self
    }

    /// The largest S_ii (S⁻¹)_ii ≥ 1: how many times further a pane moves with the whole body than
    /// against its neighbours.
    #[must_use]
    pub fn rigid_compliance_ratio(&self) -> f64 {
        let rows = self.factor.kept.iter().zip(&self.factor.scale);
        rows.map(|(&j, scale)| self.stiffness[j] / (scale * scale))
            .fold(1.0, f64::max)
    }

    /// S⁻¹h in Pa: the stresses of a face that is bonded to the foundation.
    #[must_use]
    pub fn bonded(&self, rhs: &[f64]) -> Vec<f64> {
        self.factor.solve(rhs, rhs.len())
    }

    /// S_νν⁻¹h_ν and no tangential stress, in Pa: a face that slides freely and does not lift off.
    #[must_use]
    pub fn bilateral_frictionless(&self, rhs: &[f64]) -> Vec<f64> {
        self.factor.solve(rhs, self.layout.n_panes())
    }

    /// The unknowns of a problem whose face is bonded to the foundation: [`Self::bonded`], in balance where the body floats.
    #[must_use]
    pub fn bonded_start(&self, dual: &ExplicitDual) -> Vec<f64> {
        balanced(dual, |rhs| self.bonded(rhs))
    }

    /// The unknowns of a problem whose face slides freely and does not lift off: [`Self::bilateral_frictionless`], as far in balance as can be
    /// where the body floats.
    pub(crate) fn bilateral_frictionless_start(&self, dual: &ExplicitDual) -> Vec<f64> {
        balanced(dual, |rhs| self.bilateral_frictionless(rhs))
    }
}

/// The unknowns of a linear face: λ = K h for K = S⁻¹ or its normal part; where the body floats, λ = K (h + G α) with the α that
/// balances the load, (GᵀK G + D) α = e − GᵀK h, as far as K and the supports resist the motions.
fn balanced(dual: &ExplicitDual, solve: impl Fn(&[f64]) -> Vec<f64>) -> Vec<f64> {
    let mut multiplier = solve(&dual.rhs);
    let Some(balance) = &dual.rigid else {
        return multiplier;
    };
    let n = balance.n_active();
    let (integrals, support) = (&balance.coupling.integrals, &balance.coupling.support);
    let held: Vec<Vec<f64>> = integrals.iter().map(|g| solve(g)).collect();
    let scale = (0..n).map(|p| {
        let size = dot(&integrals[p], &held[p]).abs() + support[p];
        if size == 0.0 {
            0.0
        } else {
            size.sqrt().recip()
        }
    });
    let scale: Vec<f64> = scale.collect();
    let stiffness = DMatrix::from_fn(n, n, |p, q| {
        let support = if p == q { support[p] } else { 0.0 };
        scale[p] * scale[q] * (dot(&integrals[p], &held[q]) + support)
    });
    let excess = balance.equilibrium_residual(&multiplier, &vec![0.0; n]);
    let excess = DVector::from_fn(n, |p, _| scale[p] * excess[p]);
    let motion = stiffness
        .svd(true, true)
        .solve(&excess, 1e-12)
        .unwrap_or_else(|_| DVector::zeros(n));
    let motion: Vec<f64> = motion.iter().zip(&scale).map(|(a, s)| a * s).collect();
    add_combination(&mut multiplier, &motion, &held);
    multiplier.extend(motion);
    multiplier
}

/// Gives tangential components whose rows of S vanish, but which clamps drag along the foundation, the stiffness of the
/// other component of their pair, or that of the normal one: friction acts there, and with ρ = 0 no map would see it.
pub(crate) fn friction_stiffness(stiffness: &mut [f64], layout: MultiplierLayout, rhs: &[f64]) {
    for pane in 0..layout.n_panes() {
        let Some(pair) = layout.tangential(pane) else {
            continue;
        };
        if pair.iter().any(|&j| stiffness[j] == 0.0 && rhs[j] != 0.0) {
            let across = pair.iter().fold(0.0_f64, |most, &j| most.max(stiffness[j]));
            let rho = if across > 0.0 {
                across
            } else {
                stiffness[layout.normal(pane)]
            };
            pair.into_iter().for_each(|j| stiffness[j] = rho);
        }
    }
}

/// An upper bound of the local stiffness (S⁻¹)_ii of every pane, within a small factor, in Pa/m³,
/// `[n_multipliers]`; 0 where a component moves nothing.
///
/// (S⁻¹)_ii is the least energy vᵀA v of a displacement with (B v)_i = 1 that moves no other pane,
/// so the displacement of a single node n that belongs to pane i alone bounds it: with the entries
/// b of (B)_i at that node v_n = b/|b|² and vᵀA v = bᵀA_nn b/|b|⁴. Panes of bricks, and nodes, have
/// such a node; where a pane has none, the nodes that it shares give a scale, though no bound. A
/// tangential pair takes the mean of its two.
#[must_use]
pub fn pane_stiffness(primal: &PrimalSystem, coupling: &Coupling) -> Vec<f64> {
    let node_of = nodes_of_freedom(primal);
    let columns = &coupling.transposed;
    // Tools, which all panes feel, do not move.
    let own_entries = |column: usize| {
        let entries = columns.entries(column);
        entries.filter(|(dof, _)| !primal.dofs.is_of_tool(*dof))
    };
    let mut panes_at: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for column in 0..columns.cols {
        for (dof, _) in own_entries(column) {
            let panes = panes_at.entry(node_of[dof]).or_default();
            panes.insert(coupling.layout.pane_of(column));
        }
    }
    let mut stiffness: Vec<f64> = (0..columns.cols)
        .map(|column| {
            let mut entries: BTreeMap<usize, Vec<(usize, f64)>> = BTreeMap::new();
            for entry in own_entries(column) {
                entries.entry(node_of[entry.0]).or_default().push(entry);
            }
            let least = |own: bool| {
                let nodes = entries.iter();
                nodes
                    .filter(|(node, _)| panes_at[*node].len() == 1 || !own)
                    .map(|(_, entries)| energy(primal, entries))
                    .fold(f64::INFINITY, f64::min)
            };
            [least(true), least(false)]
                .into_iter()
                .find(|least| least.is_finite())
                .unwrap_or(0.0)
        })
        .collect();
    for pair in coupling.layout.split_mut(&mut stiffness).1 {
        if pair[0] > 0.0 && pair[1] > 0.0 {
            *pair = [0.5 * (pair[0] + pair[1]); 2];
        }
    }
    stiffness
}

/// bᵀA_nn b / |b|⁴ for the entries b of a node.
fn energy(primal: &PrimalSystem, entries: &[(usize, f64)]) -> f64 {
    let square: f64 = entries.iter().map(|(_, b)| b * b).sum();
    let a = &primal.stiffness;
    let mut energy = 0.0;
    for (column, right) in entries {
        for (at, value) in a.entries(*column) {
            if let Some((_, left)) = entries.iter().find(|(row, _)| *row == at) {
                energy += left * value * right;
            }
        }
    }
    energy / square / square
}

/// The node of every free degree of freedom.
fn nodes_of_freedom(primal: &PrimalSystem) -> Vec<usize> {
    let mut nodes = vec![0; primal.dofs.n_free];
    for (node, dofs) in primal.dofs.dof.iter().enumerate() {
        for dof in dofs.iter().flatten() {
            nodes[*dof] = node;
        }
    }
    nodes
}
