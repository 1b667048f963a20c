//! Bodies that no load presses onto their foundation.
//!
//! Where a free motion q separates every pane from the foundation, w_ν(q) < 0, slides none that has friction, and the load does not work in it, e·q = 0, the balance
//! of forces says Σ λ_ν·w_ν(q) = 0: nothing presses. How high the body floats is then free, so that S, G and the pressed panes do not determine it. It is
//! left as low as it can be.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::{
    RigidCoupling, RigidEquilibrium, motion_spaces::active, rigid_coupling::NULL_MODE_SHARE,
};
use crate::linalg::{add_scaled, dot, norm};

/// Share of the mean lift that every pane takes part in, at least.
const LIFTED: f64 = 1e-3;

/// The motion that comes nearest to a lift by one, of those that no support resists, the load does not drive and no friction feels;
/// `None` where it does not lift every pane.
pub(super) fn separation_motion(
    coupling: &RigidCoupling,
    resultant: &[f64],
    areas: &[f64],
) -> Option<Vec<f64>> {
    let n_supported = coupling.n_supported();
    let free = &coupling.integrals[n_supported..];
    let layout = coupling.layout;
    let rows = |range: Range<usize>, count: usize| {
        DMatrix::from_fn(count.max(free.len()), free.len(), |i, p| {
            let j = range.start + i;
            let weight = |j: usize| areas[layout.pane_of(j)].sqrt();
            if range.contains(&j) {
                free[p][j] / weight(j)
            } else {
                0.0
            }
        })
    };
    let (n, m) = (layout.n_panes(), layout.n_multipliers());
    let (raised, slid) = (-rows(0..n, n), rows(n..m, m - n));
    let undriven = orthogonal_to(&resultant[n_supported..]);
    if undriven.ncols() == 0 {
        return None;
    }
    let (_, undriven) = active(
        &slid,
        &undriven,
        NULL_MODE_SHARE * raised.amax().max(slid.amax()),
    );
    if undriven.ncols() == 0 {
        return None;
    }
    let raised = raised * &undriven;
    let wanted = DVector::from_fn(raised.nrows(), |i, _| {
        areas.get(i).map_or(0.0, |a| a.sqrt())
    });
    let svd = raised.clone().svd(true, true);
    let least = LIFTED * svd.singular_values.max();
    let weights = svd.solve(&wanted, least).ok()?;
    let lifts = &raised * &weights;
    let lifts_all = lifts
        .iter()
        .zip(areas)
        .all(|(by, area)| *by > LIFTED * area.sqrt());
    let motion = &undriven * weights;
    let resisted = std::iter::repeat_n(0.0, n_supported);
    lifts_all.then(|| resisted.chain(motion.iter().copied()).collect())
}

/// An orthonormal basis of the vectors orthogonal to one, as columns.
fn orthogonal_to(vector: &[f64]) -> DMatrix<f64> {
    let n = vector.len();
    let size = norm(vector);
    if size == 0.0 {
        return DMatrix::identity(n, n);
    }
    // The columns but one of the reflection that takes the vector to an axis.
    let axis = (0..n).max_by(|a, b| vector[*a].abs().total_cmp(&vector[*b].abs()));
    let axis = axis.expect("it is not empty");
    let mut normal = DVector::from_row_slice(vector) / size;
    normal[axis] += normal[axis].signum();
    let square = normal.norm_squared();
    let reflection = DMatrix::identity(n, n) - &normal * normal.transpose() * (2.0 / square);
    reflection.remove_column(axis)
}

impl RigidEquilibrium {
    /// The motions α of a body that nothing presses, without contact forces and as low as the right-hand side h of its face allows;
    /// `None` where the load presses it, or may.
    pub(crate) fn separated(&self, rhs: &[f64]) -> Option<Vec<f64>> {
        let separation = self.separation_motion.as_ref()?;
        let coupling = &self.coupling;
        let by_load = self.resultant.iter().zip(&coupling.support);
        let by_load = by_load.map(|(e, d)| if *d > 0.0 { e / d } else { 0.0 });
        let mut motion: Vec<f64> = by_load.collect();
        let normals = coupling.layout.normals();
        let lifts = coupling.integrals_of(separation, rhs.len());
        let moved = coupling.integrals_of(&motion, rhs.len());
        // r = −h − G α, of every pane.
        let heights = normals.map(|i| (rhs[i] + moved[i]) / -lifts[i]);
        let height = heights.fold(0.0, f64::max);
        // A millionth higher than needed, so that rounding presses no pane.
        add_scaled(&mut motion, height * (1.0 + 1e-6), separation);
        Some(motion)
    }

    /// D of a motion in the matrix of Newton's method, in N/m, where ρ measures the panes: where panes are lifted nothing else determines
    /// a free motion, which takes 1e-8 of their stiffness. The residual does not know of it.
    pub(crate) fn stiffness_of(&self, motion: usize, steplengths: &[f64]) -> f64 {
        let support = self.coupling.support[motion];
        if support > 0.0 || self.separation_motion.is_none() {
            return support;
        }
        let g = &self.coupling.integrals[motion];
        let moved: Vec<f64> = g.iter().zip(steplengths).map(|(g, rho)| g * rho).collect();
        1e-8 * dot(g, &moved)
    }
}
