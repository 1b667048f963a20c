//! The error of a solution: its distance to the solution that refined residuals lead to, and what it is measured against.

mod refinement;

pub(in crate::solver) use refinement::Refined;

use crate::{
    dual::{PrimalSystem, RigidEquilibrium},
    linalg::{gmres, larger, norm, ratio},
    solver::{
        PaneLaws,
        conditions::{Bound, Conditions, Evaluation},
        problem::ContactSolve,
        tolerances::{DISPLACEMENT_TOLERANCE, GMRES_MAX_APPLICATIONS, GMRES_TOLERANCE},
    },
};

/// Contact forces below this share of the load are none: in sums of that many digits fewer than double precision has, rounding is seen.
const NEGLIGIBLE_STRESS: f64 = 1e-10;

impl ContactSolve<'_> {
    /// The error of λ where S is not dense: the step d with R'(λ) d = −R(λ) of the natural map with
    /// refined residuals and local stiffness, by GMRES; each product costs one application of A⁻¹.
    pub(in crate::solver) fn error_by_products(
        &self,
        bound: Bound<'_>,
        unknowns: &[f64],
        local_stiffness: &[f64],
    ) -> f64 {
        let mut steplengths = local_stiffness.to_vec();
        let equilibrium = self.dual.rigid();
        steplengths.extend(
            equilibrium
                .into_iter()
                .flat_map(RigidEquilibrium::steplengths),
        );
        let conditions = Conditions::new(bound, self.dual.layout(), steplengths);
        let target = DISPLACEMENT_TOLERANCE;
        let (_, here) = self.residual_at(&conditions, unknowns, None, target);
        let (multiplier, _) = self.dual.parts(unknowns);
        // The motions count in units in which they cost as much as a stress.
        let size = steplength_of_motions(equilibrium, &conditions.steplengths);
        let step = gmres(
            &here.residual,
            GMRES_TOLERANCE,
            GMRES_MAX_APPLICATIONS,
            |v| {
                let (stresses, motions) = self.dual.parts(v);
                let motion: Vec<f64> = motions.iter().zip(&size).map(|(v, s)| v * s).collect();
                let forces = self.dual.coupling.nodal_forces(stresses);
                let response = self.body.assembly.solve(&forces);
                let (mut gradient, slips) = self.change(response, &motion);
                let carried = equilibrium.map(|it| it.coupling.resultant_of(stresses, &motion));
                gradient.extend(carried.into_iter().flatten().map(|g| -g));
                conditions.derivative(&here, v, &gradient, &slips)
            },
        );
        // No step for a residual: it is no number, or the derivative has no inverse.
        let is_solved = step.iter().any(|it| *it != 0.0) || here.norm == 0.0;
        let error = match is_solved {
            true => self.relative(&step, multiplier, &here),
            false => f64::NAN,
        };
        larger(
            error,
            self.motion_rounding(unknowns, &here, local_stiffness),
        )
    }

    /// The error of λ, relative as in [`Self::relative`], that rounding of G α makes where weak springs hold the body; 0 elsewhere.
    ///
    /// Gaps and slips are known to ε_M/2 Σ |G α| at best, while a stall of Newton's method is rounding up to some times that
    /// ([`NaturalMap::rounding`](crate::solver::NaturalMap)). A pane that is pressed or sticks takes that as a stress by its local stiffness, an open
    /// one not at all, one that slides as the turn of its slip.
    pub(in crate::solver) fn motion_rounding(
        &self,
        unknowns: &[f64],
        here: &Evaluation,
        local_stiffness: &[f64],
    ) -> f64 {
        let equilibrium = self.dual.rigid();
        let Some(equilibrium) = equilibrium.filter(|it| it.is_supported()) else {
            return 0.0;
        };
        let (multiplier, motion) = self.dual.parts(unknowns);
        let stress = |j: usize| {
            0.5 * f64::EPSILON * local_stiffness[j] * equilibrium.size_of_motion(j, motion)
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
        self.relative(&change, multiplier, here)
    }

    /// The size of a difference of multipliers beside that of λ: the larger of its ‖·_ν‖ over ‖λ_ν‖ and its ‖·_t‖ over
    /// max(‖λ_t‖, ‖F λ_ν‖), or over the largest of these and the load where they are nothing beside it; 0 for 0/0. Areas weigh the panes,
    /// so that the size of a pane does not matter.
    ///
    /// Tangential stresses are compared with what friction could bear, so that a face that hardly holds anything is not asked for digits of
    /// nothing. Contact forces that vanish, as those of a face without a net force, are what rounding of the load leaves, and no digit of
    /// that means anything.
    pub(in crate::solver) fn relative(
        &self,
        difference: &[f64],
        multiplier: &[f64],
        evaluation: &Evaluation,
    ) -> f64 {
        let areas = &self.laws.area;
        let area: f64 = areas.iter().sum();
        let load = area.sqrt() * load_stress(&self.body.assembly.primal, area);
        let [normal, tangential] = parts(self.laws, multiplier);
        let bounds = evaluation.panes.iter().zip(areas).map(|(pane, area)| {
            let [a, b] = pane.ellipse.semi_axes;
            area.sqrt() * a.max(b)
        });
        let tangential = tangential.max(norm(&bounds.collect::<Vec<f64>>()));
        let most = load.max(normal).max(tangential);
        let sizes = [normal, tangential].map(|size| match is_significant(size, most) {
            true => size,
            false => most,
        });
        let [normal, tangential] = parts(self.laws, difference);
        let relative = [ratio(normal, sizes[0]), ratio(tangential, sizes[1])];
        larger(relative[0], relative[1])
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
fn steplength_of_motions(equilibrium: Option<&RigidEquilibrium>, steplengths: &[f64]) -> Vec<f64> {
    let Some(equilibrium) = equilibrium else {
        return Vec::new();
    };
    let coupling = &equilibrium.coupling;
    let motions = coupling.integrals.iter().zip(&coupling.support);
    motions
        .zip(equilibrium.steplengths())
        .map(|((g, support), rho)| {
            let stresses: Vec<f64> = g.iter().zip(steplengths).map(|(g, rho)| g * rho).collect();
            norm(&stresses).max(rho * support).recip()
        })
        .collect()
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
