//! The linear systems of Newton's method.

use std::{borrow::Cow, ops::Range};

use faer::Mat;
use rayon::prelude::*;

use super::natural_map::NaturalMap;
use crate::{
    contact::change_of_slips,
    dual::RigidEquilibrium,
    linalg::DenseLu,
    solver::conditions::{Bound, Evaluation},
};

/// Columns that a thread fills at least.
const COLUMNS_PER_THREAD: usize = 64;

/// The part of the Newton equation R'(λ) d = −R that is not already solved.
///
/// Rows with d_i = −R_i alone (normal components of open panes, pairs whose ellipse is a point)
/// are eliminated. In the tangential rows the row of the pane's own normal component,
/// ρ_ν (S d)_ν = −R_ν, replaces dg = d_ν − ρ_ν (S d)_ν by d_ν + R_ν.
pub(super) struct NewtonSystem<'a> {
    pub(super) map: &'a NaturalMap<'a>,
    evaluation: &'a Evaluation,
    /// Unknown of every row, ascending.
    pub(super) coupled: Vec<usize>,
    pub(super) rows: Vec<PaneRows>,
    /// The rows of the balance where the body floats, the last ones.
    equilibrium_rows: Range<usize>,
}

/// The linearised rows of one pane.
pub(super) struct PaneRows {
    pub(super) pane: usize,
    pub(super) normal_row: Option<usize>,
    pub(super) pair: Option<PairRows>,
}

/// Linearised R_t = λ_t − P_{a,b}(z_t) of one pane.
pub(super) struct PairRows {
    /// Row of the first component; the second follows.
    pub(super) row: usize,
    /// The unknowns of the pair.
    pub(super) unknowns: [usize; 2],
    /// ∂P/∂z.
    pub(super) by_point: [[f64; 2]; 2],
    /// ∂P/∂z_ν along (a, b) = g / 𝓕⁻¹ with the slip bound g of the pressure z_ν.
    pub(super) by_bound: [f64; 2],
    /// −∂P/∂𝓕⁻¹; `None` when 𝓕 does not move with λ.
    by_inverse: Option<[[f64; 2]; 2]>,
}

impl NaturalMap<'_> {
    /// The Newton step d with R'(λ) d = −R and its number of coupled unknowns; `None` when R' is singular.
    #[must_use]
    pub fn newton_step(&self, evaluation: &Evaluation) -> Option<(Vec<f64>, usize)> {
        let mut step: Vec<f64> = evaluation.residual.iter().map(|r| -r).collect();
        if self.conditions.contact_springs.is_some() {
            let n = step.len();
            DenseLu::new(&self.full_derivative(evaluation), n)?.solve(&mut step);
            return step.iter().all(|v| v.is_finite()).then_some((step, n));
        }
        let system = NewtonSystem::new(self, evaluation);
        let n = system.coupled.len();
        let mut rhs = system.rhs(&step);
        DenseLu::of(system.matrix())?.solve(&mut rhs);
        for (&unknown, &value) in system.coupled.iter().zip(&rhs) {
            step[unknown] = value;
        }
        step.iter().all(|v| v.is_finite()).then_some((step, n))
    }

    /// R'(λ) in full, column-major, `[n_unknowns, n_unknowns]`, dimensionless; without contact springs.
    pub(in crate::solver) fn derivative(&self, evaluation: &Evaluation) -> Vec<f64> {
        let system = NewtonSystem::new(self, evaluation);
        let n = evaluation.residual.len();
        let mut matrix = vec![0.0; n * n];
        let mut rows = vec![0.0; system.coupled.len()];
        for (j, column) in matrix.chunks_exact_mut(n.max(1)).enumerate() {
            column[j] = 1.0;
            system.derivative_column(j, &mut rows);
            for (&unknown, &entry) in system.coupled.iter().zip(&rows) {
                column[unknown] = entry;
            }
        }
        matrix
    }

    /// The rows and columns of R'(λ) of the unknowns that are coupled, column-major, and these unknowns; every other
    /// unknown has the row d_i alone.
    pub(in crate::solver) fn coupled_derivative(
        &self,
        evaluation: &Evaluation,
    ) -> (Vec<usize>, Vec<f64>) {
        if self.conditions.contact_springs.is_some() {
            let all = 0..evaluation.residual.len();
            return (all.collect(), self.full_derivative(evaluation));
        }
        let system = NewtonSystem::new(self, evaluation);
        let n = system.coupled.len();
        let mut matrix = vec![0.0; n * n];
        let columns = matrix.par_chunks_exact_mut(n.max(1)).zip(&system.coupled);
        let columns = columns.with_min_len(COLUMNS_PER_THREAD);
        columns.for_each(|(column, &unknown)| {
            system.derivative_column(unknown, column);
        });
        (system.coupled, matrix)
    }

    /// R' with contact springs, in which every unknown is coupled, column-major.
    fn full_derivative(&self, evaluation: &Evaluation) -> Vec<f64> {
        let (dual, n) = (self.dual, evaluation.residual.len());
        let mut matrix = vec![0.0; n * n];
        let columns = matrix.par_chunks_exact_mut(n.max(1)).enumerate();
        columns.for_each(|(j, column)| {
            column[j] = 1.0;
            let compliance = dual
                .compliance
                .iter()
                .flat_map(|it| it.column(j).as_chunks().0);
            let slips: Vec<[f64; 2]> = compliance.map(|u: &[f64; 2]| u.map(|u| -u)).collect();
            let change = self
                .conditions
                .derivative(evaluation, column, dual.column(j), &slips);
            column.copy_from_slice(&change);
        });
        matrix
    }
}

impl<'a> NewtonSystem<'a> {
    fn new(map: &'a NaturalMap<'a>, evaluation: &'a Evaluation) -> Self {
        let layout = map.dual.layout;
        let panes = 0..layout.n_panes();
        let mut coupled: Vec<usize> = layout
            .normals()
            .filter(|&i| evaluation.panes[i].pressed)
            .collect();
        let mut rows: Vec<PaneRows> = panes
            .map(|pane| PaneRows {
                pane,
                normal_row: coupled.binary_search(&pane).ok(),
                pair: None,
            })
            .collect();
        for (pane, at) in evaluation.panes.iter().zip(&mut rows) {
            let Some(pair) = layout.tangential(at.pane) else {
                continue;
            };
            if pane.ellipse.semi_axes == [0.0; 2] {
                continue;
            }
            let derivative = pane.ellipse.projection_derivative(pane.trial);
            let by_axes = derivative.by_semi_axes;
            let moving = !evaluation.inverse_slope.is_empty() && by_axes != [[0.0; 2]; 2];
            at.pair = Some(PairRows {
                row: coupled.len(),
                unknowns: pair,
                by_point: derivative.by_point,
                by_bound: by_axes.map(|row| match map.conditions.bound {
                    Bound::Coulomb(..) => {
                        (row[0] / pane.inverse[0] + row[1] / pane.inverse[1]) * pane.bound_slope
                    }
                    Bound::Given(_) => 0.0,
                }),
                by_inverse: moving.then(|| {
                    by_axes.map(|row| {
                        std::array::from_fn(|k| {
                            row[k] * pane.ellipse.semi_axes[k] / pane.inverse[k]
                        })
                    })
                }),
            });
            coupled.extend(pair);
        }
        let n_contact = coupled.len();
        coupled.extend(layout.n_multipliers()..map.dual.n_unknowns());
        let equilibrium_rows = n_contact..coupled.len();
        rows.retain(|at| at.normal_row.is_some() || at.pair.is_some());
        Self {
            map,
            evaluation,
            coupled,
            rows,
            equilibrium_rows,
        }
    }

    /// −R without the columns of the eliminated unknowns, whose d_i = −R_i are in `step` already; tangential rows also lose what
    /// dg = d_ν + R_ν has of R_ν.
    fn rhs(&self, step: &[f64]) -> Vec<f64> {
        let residual = &self.evaluation.residual;
        let mut rhs: Vec<f64> = self.coupled.iter().map(|&i| -residual[i]).collect();
        for at in &self.rows {
            if let (Some(pair), Some(_)) = (&at.pair, at.normal_row) {
                for k in 0..2 {
                    rhs[pair.row + k] += pair.by_bound[k] * residual[at.pane];
                }
            }
        }
        let mut is_eliminated = vec![true; step.len()];
        self.coupled.iter().for_each(|&i| is_eliminated[i] = false);
        let mut column = vec![0.0; rhs.len()];
        for j in (0..step.len()).filter(|&j| is_eliminated[j] && step[j] != 0.0) {
            self.column(j, &mut column);
            for (rhs, entry) in rhs.iter_mut().zip(&column) {
                *rhs -= entry * step[j];
            }
        }
        rhs
    }

    /// The coefficients of all coupled unknowns.
    fn matrix(&self) -> Mat<f64> {
        let n = self.coupled.len();
        let mut matrix = Mat::zeros(n, n);
        let columns = matrix.par_col_iter_mut().zip(&self.coupled);
        let columns = columns.with_min_len(COLUMNS_PER_THREAD);
        columns.for_each(|(column, &unknown)| {
            let column = column.try_as_col_major_mut();
            let column = column.expect("columns of a matrix are contiguous");
            self.column(unknown, column.as_slice_mut());
        });
        matrix
    }

    /// The column of R'(λ), whose tangential rows have what the normal row took off those of the system.
    fn derivative_column(&self, j: usize, out: &mut [f64]) {
        self.column(j, out);
        for at in &self.rows {
            if let (Some(pair), Some(normal)) = (&at.pair, at.normal_row) {
                for k in 0..2 {
                    out[pair.row + k] += pair.by_bound[k] * out[normal];
                }
            }
        }
    }

    /// The coefficients of unknown j in all rows.
    fn column(&self, j: usize, out: &mut [f64]) {
        let (s, compliance) = self.responses(j);
        let slips = compliance.and_then(|c| self.slip_change(&c));
        let steplengths = &self.map.conditions.steplengths;
        for row in self.equilibrium_rows.clone() {
            out[row] = match self.rigid(j) {
                None => steplengths[self.coupled[row]] * -self.integrals(self.coupled[row])[j],
                Some(motion) if self.coupled[row] == j => {
                    steplengths[j] * -self.equilibrium().stiffness_of(motion, steplengths)
                }
                Some(_) => 0.0,
            };
        }
        for at in &self.rows {
            let normal = at.pane;
            if let Some(row) = at.normal_row {
                out[row] = steplengths[normal] * s[normal];
            }
            let Some(pair) = &at.pair else { continue };
            let [s1, s2] = pair.unknowns.map(|j| steplengths[j] * s[j]);
            let mut entry = pair.by_point.map(|p| p[0] * s1 + p[1] * s2);
            if j == normal && at.normal_row.is_some() {
                entry[0] -= pair.by_bound[0];
                entry[1] -= pair.by_bound[1];
            }
            if let Some(k) = pair.unknowns.iter().position(|unknown| *unknown == j) {
                entry[k] += 1.0;
                if steplengths[j] > 0.0 {
                    entry[0] -= pair.by_point[0][k];
                    entry[1] -= pair.by_point[1][k];
                }
            }
            if let Some(by_inverse) = &pair.by_inverse {
                let slips = slips.as_deref().unwrap_or_default();
                let conditions = &self.map.conditions;
                let change = conditions.inverse_change(self.evaluation, at.pane, slips);
                for (entry, by) in entry.iter_mut().zip(by_inverse) {
                    *entry -= by[0] * change[0] + by[1] * change[1];
                }
            }
            out[pair.row..pair.row + 2].copy_from_slice(&entry);
        }
    }

    /// The rigid motion of an unknown; `None` of a multiplier.
    fn rigid(&self, unknown: usize) -> Option<usize> {
        unknown.checked_sub(self.map.dual.dimension())
    }

    fn equilibrium(&self) -> &RigidEquilibrium {
        let equilibrium = self.map.dual.rigid.as_ref();
        equilibrium.expect("a rigid motion is an unknown")
    }

    /// G of the rigid motion of an unknown.
    fn integrals(&self, unknown: usize) -> &[f64] {
        &self.equilibrium().coupling.integrals[unknown - self.map.dual.dimension()]
    }

    /// ∂r/∂x_j, a column of S or of −G, and −∂u_t/∂x_j at the contact nodes, where they are held.
    fn responses(&self, unknown: usize) -> (Cow<'_, [f64]>, Option<Cow<'_, [f64]>>) {
        let dual = self.map.dual;
        let (Some(motion), Some(equilibrium)) = (self.rigid(unknown), &dual.rigid) else {
            let compliance = dual.compliance.as_ref();
            let slips = compliance.map(|c| Cow::Borrowed(c.column(unknown)));
            return (Cow::Borrowed(dual.column(unknown)), slips);
        };
        let opposite = |values: &[f64]| Cow::Owned(values.iter().map(|v| -v).collect());
        let slips = opposite(equilibrium.coupling.slip[motion].as_flattened());
        (opposite(self.integrals(unknown)), Some(slips))
    }

    /// −∂φ/∂x_j at the nodes for a column of the nodes' compliance; `None` where friction does not follow the slip.
    fn slip_change(&self, compliance: &[f64]) -> Option<Vec<[f64; 2]>> {
        let derivative = self.evaluation.slip_derivative.as_ref()?;
        let pair = |node| [compliance[2 * node], compliance[2 * node + 1]];
        Some(change_of_slips(derivative, pair))
    }
}
