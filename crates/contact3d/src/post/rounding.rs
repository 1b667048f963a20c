//! What rounding alone makes of the residuals of an answer.

use super::{ContactReport, PaneState, Solved, largest, resultants::NodalForces};
use crate::linalg::{FEW_ROUNDINGS, dot, norm};

/// Size of the residuals at the best double λ and u: 16 ε_M times how much larger the terms are than what their sum is measured
/// against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rounding {
    /// Of the equilibrium: ‖|A||u| + |Bᵀ||λ| + |l|‖ / ‖l‖.
    pub equilibrium: f64,
    /// Of contact stresses: what rounding of λ and u moves the panes, |S||λ| + |R| max |u|, times local stiffness over the largest.
    pub stress: f64,
    /// Of the works of contact: the same motion times stresses over Σ λ²/ρ.
    pub work: f64,
}

/// What a residual is measured against.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Measure {
    /// Forces on the body, whose displacement is solved to rounding whatever λ is.
    Balance,
    /// Contact stresses.
    Stress,
    /// Works of contact.
    Work,
}

impl Rounding {
    /// Of a solved problem with its [`terms`], its panes and their local stiffness; `moved` is |S||λ| in m³, `[n_multipliers]`, empty
    /// where u was solved with exact residuals.
    pub(super) fn new(
        solved: &Solved<'_>,
        terms: &[f64],
        panes: &[PaneState],
        stiffness: &[f64],
        moved: &[f64],
    ) -> Self {
        let [stress, work] = of_contact(solved, panes, stiffness, moved);
        let equilibrium = ratio(norm(terms), driving_force(solved));
        Self {
            equilibrium: FEW_ROUNDINGS * f64::EPSILON * equilibrium,
            stress: FEW_ROUNDINGS * f64::EPSILON * stress,
            work: FEW_ROUNDINGS * f64::EPSILON * work,
        }
    }

    /// As [`Self::new`], with the local stiffness of the solved problem.
    pub(crate) fn of_answer(solved: &Solved<'_>, report: &ContactReport, moved: &[f64]) -> Self {
        let contact = solved.contact.as_ref();
        let stiffness = contact.map_or_else(Vec::new, |contact| contact.local_stiffness(solved));
        let terms = terms(solved);
        Self::new(solved, &terms, &report.panes, &stiffness, moved)
    }

    /// How many times further than by its own compliance a pane moves with the body, at least one: a relative error of λ is so many
    /// times larger in the residuals of stresses and of works.
    pub(crate) fn rigid_compliance_ratio(&self) -> f64 {
        let share = self.stress.max(self.work) / (FEW_ROUNDINGS * f64::EPSILON);
        share.max(1.0)
    }

    /// Of a residual.
    pub(super) fn of(&self, measure: Measure) -> f64 {
        match measure {
            Measure::Balance => self.equilibrium,
            Measure::Stress => self.stress,
            Measure::Work => self.work,
        }
    }

    /// The largest.
    #[must_use]
    pub fn worst(&self) -> f64 {
        self.equilibrium.max(self.stress).max(self.work)
    }
}

/// ‖l‖ in N; ‖Bᵀλ‖ where only tools drive the body.
pub(super) fn driving_force(solved: &Solved<'_>) -> f64 {
    let load = norm(&solved.system.load);
    match &solved.contact {
        Some(contact) if load == 0.0 => {
            norm(&contact.coupling.nodal_forces(&solved.solution.multiplier))
        }
        _ => load,
    }
}

/// |A||u| + |Bᵀ||λ| + |l| in N, `[n_free]`: what cancels in the equilibrium.
pub(super) fn terms(solved: &Solved<'_>) -> Vec<f64> {
    let solution = solved.solution;
    let (u, lambda) = (&*solution.displacement, &*solution.multiplier);
    let mut forces: Vec<f64> = solved.system.load.iter().map(|l| l.abs()).collect();
    let coupling = solved.contact.map(|contact| &contact.coupling.transposed);
    let terms = [(Some(&*solved.system.stiffness), u), (coupling, lambda)];
    for (matrix, x) in terms {
        let Some(matrix) = matrix else { continue };
        for (j, x) in x.iter().enumerate() {
            let (rows, values) = matrix.column(j);
            for (&row, value) in rows.iter().zip(values) {
                forces[row] += (value * x).abs();
            }
        }
    }
    forces
}

/// What rounding alone makes of u·A u in J, from the [`terms`] of the equilibrium; that of a body that floats is the work of its forces.
pub(super) fn of_energy(
    solved: &Solved<'_>,
    terms: &[f64],
    displacement: &[[f64; 3]],
    forces: &NodalForces,
) -> f64 {
    let size = |values: &[f64]| values.iter().map(|v| v.abs()).collect::<Vec<_>>();
    let works = if solved.system.rigid_modes.is_some() {
        let u = size(displacement.as_flattened());
        let parts = [&forces.applied, &forces.contact].into_iter();
        let parts = parts.chain(&forces.tools);
        parts.map(|f| dot(&size(f.as_flattened()), &u)).sum()
    } else {
        dot(terms, &size(&solved.solution.displacement))
    };
    FEW_ROUNDINGS * f64::EPSILON * works
}

/// Of stresses and of works; 0 where nothing is loaded.
fn of_contact(
    solved: &Solved<'_>,
    panes: &[PaneState],
    stiffness: &[f64],
    moved: &[f64],
) -> [f64; 2] {
    let Some(contact) = &solved.contact else {
        return [0.0; 2];
    };
    let area = &contact.state.surface.pane_area;
    let layout = contact.coupling.layout;
    let lambda = &solved.solution.multiplier;
    let largest = largest(solved.solution.displacement.iter().copied());
    let rounded =
        |j: usize| moved.get(j).copied().unwrap_or(0.0) + area[layout.pane_of(j)] * largest;
    let strength = |j: usize| match panes[layout.pane_of(j)].friction {
        Some(friction) if layout.tangentials().contains(&j) => {
            friction.semi_axes[0].max(friction.semi_axes[1])
        }
        _ => lambda[j].abs(),
    };
    let parts = [layout.normals(), layout.tangentials()];
    let by_stress = parts.clone().map(|part| {
        let pushed = part.clone().map(|j| stiffness[j] * rounded(j));
        let borne = part.map(|j| strength(j).max(lambda[j].abs()));
        ratio(pushed.fold(0.0, f64::max), borne.fold(0.0, f64::max))
    });
    let by_work = parts.map(|part| {
        let loaded = part.filter(|&j| stiffness[j] > 0.0);
        let works = loaded.map(|j| [strength(j) * rounded(j), lambda[j].powi(2) / stiffness[j]]);
        let [rounding, own] = works.fold([0.0; 2], |sum, w| [sum[0] + w[0], sum[1] + w[1]]);
        ratio(rounding, own)
    });
    [by_stress[0].max(by_stress[1]), by_work[0].max(by_work[1])]
}

/// The quotient, and 0 over 0.
fn ratio(part: f64, whole: f64) -> f64 {
    if whole == 0.0 { 0.0 } else { part / whole }
}
