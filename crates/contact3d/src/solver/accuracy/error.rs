//! The error of multipliers: one more step of Newton's method with exact residuals, and what it is measured against.

use crate::{
    dual::{PrimalSystem, RigidEquilibrium},
    linalg::{gmres, norm},
    solver::{
        PaneLaws, Solution,
        conditions::{Bound, Conditions, Evaluation},
        problem::ContactSolve,
    },
};

/// Contact forces below this share of the load are none: in sums of that many digits fewer than double precision has, rounding is seen.
const NEGLIGIBLE_STRESS: f64 = 1e-10;

/// Share of the residual that the linear system for an error or an adjoint may leave: estimated errors are good to a tenth at best.
pub(in crate::solver) const GMRES_TOLERANCE: f64 = 1e-4;

/// Most applications of A⁻¹ for that.
pub(in crate::solver) const GMRES_MAX_APPLICATIONS: usize = 300;

/// u is wanted with this share of rounding, so that the face's own displacement is left where the
/// body moves as a whole.
pub(in crate::solver) const DISPLACEMENT_TOLERANCE: f64 = 1e-4 * f64::EPSILON;

impl ContactSolve<'_> {
    /// The error of λ where S is not dense: the step d with R'(λ) d = −R(λ) of the natural map with
    /// exact residuals and local stiffness, by GMRES; each product costs one application of A⁻¹.
    pub(in crate::solver) fn error_by_products(
        &self,
        bound: Bound<'_>,
        solution: &Solution,
    ) -> f64 {
        let unknowns = &self.unknowns(solution);
        let mut steplengths = solution.trace.local_stiffness.clone();
        let balance = self.dual.rigid();
        steplengths.extend(balance.into_iter().flat_map(RigidEquilibrium::steplengths));
        let conditions = Conditions::new(bound, self.dual.layout(), steplengths);
        let (body, target) = (&self.body, DISPLACEMENT_TOLERANCE);
        let (_, here) = body.residual_at(self.dual, &conditions, unknowns, None, target);
        let (multiplier, _) = self.dual.parts(unknowns);
        // The motions count in units in which they cost as much as a stress.
        let size = steplength_of_motions(balance, &conditions.steplengths);
        let step = gmres(
            &here.residual,
            GMRES_TOLERANCE,
            GMRES_MAX_APPLICATIONS,
            |v| {
                let (stresses, motions) = self.dual.parts(v);
                let motion: Vec<f64> = motions.iter().zip(&size).map(|(v, s)| v * s).collect();
                let forces = self.dual.coupling.nodal_forces(stresses);
                let moved = self.body.assembly.solve(&forces);
                let (mut gradient, slips) = self.body.change(self.dual, moved, &motion);
                let carried = balance.map(|it| it.coupling.resultant_of(stresses, &motion));
                gradient.extend(carried.into_iter().flatten().map(|g| -g));
                conditions.derivative(&here, v, &gradient, &slips)
            },
        );
        let error = self.sizes(multiplier, &here).relative(self.laws, &step);
        error.max(self.motion_rounding(unknowns, &here, &solution.trace.local_stiffness))
    }

    /// The error of λ, relative as in [`MultiplierSizes`], that rounding of G α makes where weak springs hold the body; 0 elsewhere.
    ///
    /// Gaps and slips are known to ε/2 Σ |G α|. A pane that is pressed or sticks takes that as a stress by its local stiffness, an open
    /// one not at all, one that slides as the turn of its slip.
    pub(in crate::solver) fn motion_rounding(
        &self,
        unknowns: &[f64],
        here: &Evaluation,
        local_stiffness: &[f64],
    ) -> f64 {
        let balance = self.dual.rigid();
        let Some(balance) = balance.filter(|it| it.is_supported()) else {
            return 0.0;
        };
        let (multiplier, motion) = self.dual.parts(unknowns);
        let stress = |j: usize| {
            let terms = balance.coupling.integrals.iter().zip(motion);
            let moved: f64 = terms.map(|(g, by)| (g[j] * by).abs()).sum();
            0.5 * f64::EPSILON * local_stiffness[j] * moved
        };
        let layout = self.dual.layout();
        let mut change = vec![0.0; layout.n_multipliers()];
        for (pane, at) in here.panes.iter().enumerate() {
            if at.pressed {
                let normal = layout.normal(pane);
                change[normal] = stress(normal);
            }
            let Some(pair) = layout.tangential(pane) else {
                continue;
            };
            let by_point = at.ellipse.projection_derivative(at.trial).by_point;
            for (row, &j) in by_point.iter().zip(&pair) {
                let terms = row.iter().zip(&pair);
                change[j] = terms.map(|(by, &k)| (by * stress(k)).abs()).sum();
            }
        }
        self.sizes(multiplier, here).relative(self.laws, &change)
    }

    /// What an error of λ is measured against: its sizes, or that of the load where they are nothing beside it.
    ///
    /// Contact forces that vanish, as those of a face without a net force, are what rounding of the load leaves, and no digit of that
    /// means anything.
    pub(in crate::solver) fn sizes(
        &self,
        multiplier: &[f64],
        evaluation: &Evaluation,
    ) -> MultiplierSizes {
        let area: f64 = self.laws.area.iter().sum();
        let load = area.sqrt() * load_stress(&self.body.assembly.primal, area);
        let beside_load = |size| {
            if is_significant(size, load) {
                size
            } else {
                load
            }
        };
        let MultiplierSizes { normal, tangential } =
            MultiplierSizes::of(self.laws, multiplier, evaluation);
        MultiplierSizes {
            normal: beside_load(normal),
            tangential: beside_load(tangential),
        }
    }
}

/// Σ ‖lᵢ‖ over the nodes and the contact face's area in m²: the stress that the load is on it, in Pa.
pub(crate) fn load_stress(primal: &PrimalSystem, area: f64) -> f64 {
    let nodes = 0..primal.dofs.dof.len();
    let forces = nodes.map(|node| norm(&primal.dofs.change_at_node(node, &primal.load)));
    forces.sum::<f64>() / area
}

/// Whether stresses are more than what rounding of the load leaves.
pub(crate) fn is_significant(stress: f64, load: f64) -> bool {
    stress > NEGLIGIBLE_STRESS * load
}

/// For each rigid motion the α in m that moves the panes by as much as one Pa does, 1 / ‖ρ G‖, or takes as much force of its support.
fn steplength_of_motions(balance: Option<&RigidEquilibrium>, steplengths: &[f64]) -> Vec<f64> {
    let Some(balance) = balance else {
        return Vec::new();
    };
    let coupling = &balance.coupling;
    let motions = coupling.integrals.iter().zip(&coupling.support);
    motions
        .zip(balance.steplengths())
        .map(|((g, support), rho)| {
            let moved: Vec<f64> = g.iter().zip(steplengths).map(|(g, rho)| g * rho).collect();
            norm(&moved).max(rho * support).recip()
        })
        .collect()
}

/// The norms ‖λ_ν‖ and max(‖λ_t‖, ‖F λ_ν‖) of a multiplier over Γ_c, in Pa·m.
///
/// Areas weigh the panes, so that the size of a pane does not matter; the tangential stress is
/// compared with what friction could bear, so that a face that hardly holds anything is not asked
/// for digits of nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::solver) struct MultiplierSizes {
    normal: f64,
    tangential: f64,
}

impl MultiplierSizes {
    /// At λ, whose ellipses are those of `evaluation`.
    fn of(laws: &PaneLaws, multiplier: &[f64], evaluation: &Evaluation) -> Self {
        let [normal, tangential] = parts(laws, multiplier);
        let strengths = evaluation.panes.iter().zip(&laws.area);
        let strengths = strengths.map(|(pane, area)| {
            let [a, b] = pane.ellipse.semi_axes;
            area.sqrt() * a.max(b)
        });
        Self {
            normal,
            tangential: tangential.max(norm(&strengths.collect::<Vec<f64>>())),
        }
    }

    /// The larger of the relative normal and tangential sizes of a difference of multipliers; 0 for
    /// 0/0.
    pub(in crate::solver) fn relative(&self, laws: &PaneLaws, difference: &[f64]) -> f64 {
        let [normal, tangential] = parts(laws, difference);
        let ratio = |part: f64, whole: f64| if part == 0.0 { 0.0 } else { part / whole };
        let (normal, tangential) = (
            ratio(normal, self.normal),
            ratio(tangential, self.tangential),
        );
        if normal.is_nan() || tangential.is_nan() {
            f64::NAN
        } else {
            normal.max(tangential)
        }
    }
}

/// The size of (d₁/a, d₂/b) for the tangential part d of a difference of multipliers and the semi-axes
/// of the panes' ellipses, weighted by areas: (Σ |Rⁱ| |·|² / Σ |Rⁱ|)^½; panes without ellipses do not
/// count.
pub(in crate::solver) fn within_ellipses(
    laws: &PaneLaws,
    evaluation: &Evaluation,
    difference: &[f64],
) -> f64 {
    let areas = &laws.area;
    let (_, pairs) = laws.layout.split(difference);
    let terms = pairs.iter().zip(&evaluation.panes).zip(areas);
    let scaled = terms.flat_map(|((d, pane), area)| {
        let [a, b] = pane.ellipse.semi_axes;
        let part = |d: f64, axis: f64| {
            if axis > 0.0 {
                area.sqrt() * d / axis
            } else {
                0.0
            }
        };
        [part(d[0], a), part(d[1], b)]
    });
    norm(&scaled.collect::<Vec<f64>>()) / areas.iter().sum::<f64>().sqrt()
}

/// (Σ |Rⁱ| λ_ν²)^½ and (Σ |Rⁱ| |λ_t|²)^½.
fn parts(laws: &PaneLaws, multiplier: &[f64]) -> [f64; 2] {
    let areas = &laws.area;
    let (normal, tangential) = laws.layout.split(multiplier);
    let normal = normal.iter().zip(areas).map(|(l, a)| a.sqrt() * l);
    let pairs = tangential.iter().zip(areas);
    let tangential = pairs.flat_map(|(t, a)| [t[0], t[1]].map(|t| a.sqrt() * t));
    [
        norm(&normal.collect::<Vec<f64>>()),
        norm(&tangential.collect::<Vec<f64>>()),
    ]
}
