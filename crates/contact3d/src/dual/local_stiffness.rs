//! The stiffness of the contact face's own panes, apart from the motion of the body as a whole.

use faer::{
    Mat, MatMut, MatRef, Par,
    dyn_stack::{MemBuffer, MemStack},
    linalg::{
        cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch},
        triangular_inverse::invert_lower_triangular,
        triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place},
    },
};

use nalgebra::{DMatrix, DVector};

use super::ExplicitDual;
use crate::{
    contact::MultiplierLayout,
    linalg::{add_scaled, dot, largest_eigenvalue},
};

/// How much is added to the diagonal of the scaled S when rounding has made it indefinite, in
/// units of n ε, and by which factor this grows until a factor exists.
const SHIFT: f64 = 1.0;
const SHIFT_GROWTH: f64 = 16.0;

/// The Cholesky factor of S.
#[derive(Debug, Clone)]
pub(super) struct DenseFactor {
    /// The components whose rows do not vanish, ascending.
    kept: Vec<usize>,
    /// 1/√S_ii of those.
    scale: Vec<f64>,
    /// L with LLᵀ = D S D + shift for D = diag(scale); its upper part means nothing.
    factor: Mat<f64>,
}

impl DenseFactor {
    /// A third of n³ operations for n multipliers.
    pub(super) fn new(dual: &ExplicitDual) -> Self {
        let (kept, scale, scaled) = unit_diagonal(dual);
        let factor = shifted_factor(&scaled);
        Self {
            kept,
            scale,
            factor,
        }
    }

    /// S⁻¹h in Pa for h in m³.
    pub(super) fn solve(&self, rhs: &[f64]) -> Vec<f64> {
        self.solve_first(rhs, self.kept.len())
    }

    /// Solves with the first `count` kept components; the others are zero.
    fn solve_first(&self, rhs: &[f64], count: usize) -> Vec<f64> {
        let mut x = Mat::from_fn(count, 1, |i, _| self.scale[i] * rhs[self.kept[i]]);
        let l = self.factor.as_ref().submatrix(0, 0, count, count);
        solve_lower_triangular_in_place(l, x.as_mut(), Par::Seq);
        solve_upper_triangular_in_place(l.transpose(), x.as_mut(), Par::Seq);
        let mut solution = vec![0.0; rhs.len()];
        for i in 0..count {
            solution[self.kept[i]] = self.scale[i] * x[(i, 0)];
        }
        solution
    }
}

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
    dense: DenseFactor,
}

impl LocalStiffness {
    /// Factorises S: n³ operations for n multipliers, as one and a half steps of
    /// Newton's method.
    #[must_use]
    pub fn new(dual: &ExplicitDual) -> Self {
        let dense = DenseFactor::new(dual);
        let mut stiffness = vec![0.0; dual.dimension()];
        let inverse = inverse_diagonal(&dense.factor);
        for ((&j, inverse), scale) in dense.kept.iter().zip(inverse).zip(&dense.scale) {
            stiffness[j] = inverse * scale * scale;
        }
        for pair in dual.layout.split_mut(&mut stiffness).1 {
            if pair[0] > 0.0 && pair[1] > 0.0 {
                *pair = [0.5 * (pair[0] + pair[1]); 2];
            }
        }
        drag(&mut stiffness, dual.layout, &dual.rhs);
        Self {
            stiffness,
            layout: dual.layout,
            dense,
        }
    }

    /// The same where clamps drag contact nodes as another h of the same operator says, too.
    #[must_use]
    pub(crate) fn dragged_by(mut self, rhs: &[f64]) -> Self {
        if rhs.len() == self.stiffness.len() {
            drag(&mut self.stiffness, self.layout, rhs);
        }
        self
    }

    /// The largest S_ii (S⁻¹)_ii ≥ 1: how many times further a pane moves with the whole body than
    /// against its neighbours.
    #[must_use]
    pub fn mobility(&self) -> f64 {
        let rows = self.dense.kept.iter().zip(&self.dense.scale);
        rows.map(|(&j, scale)| self.stiffness[j] / (scale * scale))
            .fold(1.0, f64::max)
    }

    /// S⁻¹h in Pa: the stresses of a face that is glued to the foundation.
    #[must_use]
    pub fn glued(&self, rhs: &[f64]) -> Vec<f64> {
        self.dense.solve(rhs)
    }

    /// S_νν⁻¹h_ν and no tangential stress, in Pa: a face that slides freely and does not lift off.
    #[must_use]
    pub fn pressed(&self, rhs: &[f64]) -> Vec<f64> {
        let normal = self.layout.n_panes();
        let count = self.dense.kept.partition_point(|&j| j < normal);
        self.dense.solve_first(rhs, count)
    }

    /// The unknowns of a problem whose face is glued to the foundation: [`Self::glued`], in balance where the body floats.
    pub(crate) fn glued_start(&self, dual: &ExplicitDual) -> Vec<f64> {
        balanced(dual, |rhs| self.glued(rhs))
    }

    /// The unknowns of a problem whose face slides freely and does not lift off: [`Self::pressed`], as far in balance as can be
    /// where the body floats.
    pub(crate) fn pressed_start(&self, dual: &ExplicitDual) -> Vec<f64> {
        balanced(dual, |rhs| self.pressed(rhs))
    }
}

/// The unknowns of a linear face: λ = K h for K = S⁻¹ or its normal part; where the body floats, λ = K (h + G α) with the α that
/// balances the load, GᵀK G α = e − GᵀK h, as far as K resists the motions.
fn balanced(dual: &ExplicitDual, solve: impl Fn(&[f64]) -> Vec<f64>) -> Vec<f64> {
    const UNRESISTED: f64 = 1e-12;
    let mut multiplier = solve(&dual.rhs);
    let Some(balance) = &dual.balance else {
        return multiplier;
    };
    let n = balance.n_felt();
    let held: Vec<Vec<f64>> = balance
        .coupling
        .integrals
        .iter()
        .map(|g| solve(g))
        .collect();
    let scale = |p: usize| dot(&balance.coupling.integrals[p], &held[p]).abs().sqrt();
    let scale: Vec<f64> = (0..n)
        .map(|p| match scale(p) {
            0.0 => 0.0,
            s => s.recip(),
        })
        .collect();
    let stiffness = DMatrix::from_fn(n, n, |p, q| {
        scale[p] * scale[q] * dot(&balance.coupling.integrals[p], &held[q])
    });
    let excess = balance.excess(&multiplier);
    let excess = DVector::from_fn(n, |p, _| scale[p] * excess[p]);
    let motion = stiffness
        .svd(true, true)
        .solve(&excess, UNRESISTED)
        .unwrap_or_else(|_| DVector::zeros(n));
    let motion: Vec<f64> = motion.iter().zip(&scale).map(|(a, s)| a * s).collect();
    for (held, by) in held.iter().zip(&motion) {
        add_scaled(&mut multiplier, *by, held);
    }
    multiplier.extend(motion);
    multiplier
}

/// Gives tangential components whose rows of S vanish, but which clamps drag along the foundation, the stiffness of the
/// other component of their pair, or that of the normal one: friction acts there, and with ρ = 0 no map would see it.
pub(crate) fn drag(stiffness: &mut [f64], layout: MultiplierLayout, rhs: &[f64]) {
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

/// The components whose rows of S do not vanish, 1/√S_ii of those, and D S D for D = diag(1/√S_ii).
fn unit_diagonal(dual: &ExplicitDual) -> (Vec<usize>, Vec<f64>, Mat<f64>) {
    let n = dual.dimension();
    let kept: Vec<usize> = (0..n).filter(|&j| dual.column(j)[j] > 0.0).collect();
    let scale: Vec<f64> = kept
        .iter()
        .map(|&j| dual.column(j)[j].sqrt().recip())
        .collect();
    let scaled = Mat::from_fn(kept.len(), kept.len(), |i, j| {
        scale[i] * dual.column(kept[j])[kept[i]] * scale[j]
    });
    (kept, scale, scaled)
}

/// The smallest eigenvalue of D S D, the dual operator scaled to a unit diagonal: how far
/// multipliers of one mesh are from having no effect. On meshes of one shape it does not fall with
/// their size when the multipliers are stable. By Lanczos' method to a few per cent, after a third of n³ operations for n
/// multipliers; 1 without panes.
#[must_use]
pub fn smallest_eigenvalue(dual: &ExplicitDual) -> f64 {
    let (kept, _, scaled) = unit_diagonal(dual);
    if kept.is_empty() {
        return 1.0;
    }
    let factor = shifted_factor(&scaled);
    let largest_of_inverse = largest_eigenvalue(kept.len(), |v| {
        let mut x = Mat::from_fn(v.len(), 1, |i, _| v[i]);
        solve_lower_triangular_in_place(factor.as_ref(), x.as_mut(), Par::Seq);
        solve_upper_triangular_in_place(factor.transpose(), x.as_mut(), Par::Seq);
        x.col_as_slice(0).to_vec()
    });
    largest_of_inverse.recip()
}

/// The Cholesky factor of a matrix with diagonal 1, shifted as little as it takes to have one.
fn shifted_factor(matrix: &Mat<f64>) -> Mat<f64> {
    let n = matrix.nrows();
    let mut memory = MemBuffer::new(cholesky_in_place_scratch::<f64>(
        n,
        Par::Seq,
        Default::default(),
    ));
    let mut shift = SHIFT * n as f64 * f64::EPSILON;
    loop {
        let mut factor = matrix.clone();
        for i in 0..n {
            factor[(i, i)] += shift;
        }
        let stack = MemStack::new(&mut memory);
        let done = cholesky_in_place(
            factor.as_mut(),
            Default::default(),
            Par::Seq,
            stack,
            Default::default(),
        );
        // Diagonally dominant from a shift of n on; a matrix that is not finite has no factor.
        if done.is_ok() || shift >= n as f64 {
            return factor;
        }
        shift *= SHIFT_GROWTH;
    }
}

/// The diagonal of (LLᵀ)⁻¹: squared lengths of the columns of L⁻¹.
fn inverse_diagonal(factor: &Mat<f64>) -> Vec<f64> {
    let n = factor.nrows();
    let mut inverse = Mat::<f64>::zeros(n, n);
    invert_lower_triangular(
        inverse.as_mut() as MatMut<'_, f64>,
        factor.as_ref() as MatRef<'_, f64>,
        Par::Seq,
    );
    (0..n)
        .map(|j| (j..n).map(|i| inverse[(i, j)].powi(2)).sum())
        .collect()
}
