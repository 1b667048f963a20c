//! The Newton–Krylov method on Coulomb's law where S is implicit: no matrix of the size of S, only products with it.
//!
//! Its starts, in order: the multipliers of a similar problem, as they are if they solve this one to a thousandth, else after a step whose
//! zones their stresses tell, and with short steplengths; then the face that slides freely and cannot lift off, with ρ = 1/S_ii and with local stiffness.
//!
//! R'(λ) d = −R(λ) is solved by GMRES to a forcing term that shrinks with ‖R‖ (S. C. Eisenstat, H. F. Walker, *SIAM J. Sci. Comput.* 17 (1996)
//! 16), preconditioned from the right by [`TwoLevels`]. Each product takes one pair of substitutions with the factor of A, in its
//! precision: what it has wrong costs steps, for R is refined.
//!
//! R is measured with ρ = 1/S_ii ([`Conditions`]), of which the aggregates give the part that a pane has in common with others: by local
//! stiffness a small error common to all panes hides the zones, and steps are cut short until nothing changes.

use super::{
    ContactBody, FrictionState, NewtonStep, Progress, Solution, SolvedBy, Trace,
    assessment::Assessment,
    conditions::{Bound, Conditions},
    inner::projected_gradient_steplength,
    newton::iteration::{Iterate, NewtonModel, NewtonSettings, iterate},
    problem::{ContactSolve, RefinedState},
    tolerances::{
        DISPLACEMENT_TOLERANCE, GMRES_MAX_APPLICATIONS, GMRES_TOLERANCE, LOOP_MAX_STEPS,
        REFINEMENT_TARGET, ROUNDING_STALL_STEPS, rounding_of_products,
    },
    two_levels::{PaneLevels, TwoLevels},
};
use crate::{
    contact::{CoulombLaw, slips},
    dual::{ContactOperator, DualOperator},
    linalg::{Precision, add_scaled, gmres, norm},
};

/// Forcing terms: what GMRES leaves of −R, relative to it. Less than the smallest is lost where the factor is in single precision.
const LARGEST_FORCING: f64 = 0.1;
const SMALLEST_FORCING: f64 = 0.01;

/// The relative residual at which zones are settled: a similar problem's solution within it is a start as it is, and steps with short
/// steplengths go no further.
const NEWTON_BASIN: f64 = 1e-3;

/// With ρ = 1/S_ii times this the zones follow from the stresses of a start, whatever its displacement: from another mesh the rigid motion
/// of the body differs by more than what decides about zones.
const ZONE_STEPLENGTH: f64 = 1e-2;

/// With ρ times this steps settle the zones of bodies whose rigid motion is so large that all panes count as open; a tenth is between the
/// last two.
const SHORT_STEPLENGTH: f64 = 0.1;

/// A Coulomb problem with an implicit S.
struct NewtonKrylov<'a> {
    problem: &'a ContactSolve<'a>,
    conditions: Conditions<'a>,
    levels: PaneLevels,
    /// The stiffness of a pane against its neighbours in Pa/m³, 0 where it moves nothing, `[n_multipliers]`.
    stiffness: &'a [f64],
    /// The supernodes that forces at contact nodes reach.
    reach: Vec<usize>,
    history: Vec<NewtonStep>,
    applications: usize,
    /// ‖R‖ where the last step began.
    last_norm: Option<f64>,
}

impl NewtonModel for NewtonKrylov<'_> {
    type Point = RefinedState;

    fn direction(&mut self, from: &Iterate<RefinedState>) -> Option<(Vec<f64>, usize)> {
        let smallest = match self.problem.body.precision() {
            Precision::Single => SMALLEST_FORCING,
            Precision::Double => GMRES_TOLERANCE,
        };
        // Eisenstat and Walker's second choice, with their factor.
        let forcing = self.last_norm.map_or(LARGEST_FORCING, |last| {
            let falls = from.evaluation.norm / last;
            (0.9 * falls * falls).clamp(smallest, LARGEST_FORCING)
        });
        self.last_norm = Some(from.evaluation.norm);
        let step = self.step(from, forcing);
        let n = step.len();
        Some((step, n))
    }

    fn trial(
        &mut self,
        from: &Iterate<RefinedState>,
        direction: &[f64],
        length: f64,
    ) -> Iterate<RefinedState> {
        let mut multiplier = from.point.unknowns.clone();
        add_scaled(&mut multiplier, length, direction);
        self.at(&multiplier, Some(&from.point))
    }
}

impl ContactSolve<'_> {
    /// Coulomb's law by Newton's method with products of S alone.
    ///
    /// # Errors
    /// What was tried where no start leads to a solution; nothing is for a body that floats, and where Algorithm 4.1 goes on from a
    /// checkpoint.
    pub(super) fn by_newton_krylov(
        &self,
        law: &CoulombLaw,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Result<Solution, Trace> {
        if self.dual.rigid().is_some() || self.start.checkpoint.is_some() {
            return Err(Trace::default());
        }
        let (bound, layout) = (Bound::Coulomb(self.laws, law), self.dual.layout());
        let stiffness = &self.pane_stiffness();
        let levels = PaneLevels::new(self.body.assembly, &self.dual.coupling, stiffness);
        let mut newton = NewtonKrylov {
            problem: self,
            conditions: Conditions::new(bound, layout, levels.steplengths.clone()),
            levels,
            stiffness,
            reach: reach(&self.body),
            history: Vec::new(),
            applications: 0,
            last_norm: None,
        };
        let warm = self.start.multiplier.map(<[f64]>::to_vec);
        let similar = warm.and_then(|start| newton.solve_similar(&start, observe));
        let solution = similar.or_else(|| {
            let start = newton.bilateral_frictionless();
            let steplengths = [newton.levels.steplengths.clone(), stiffness.clone()];
            steplengths.into_iter().find_map(|steplengths| {
                newton.conditions.steplengths = steplengths;
                let start = newton.at(&start, None);
                newton.solve(start, observe)
            })
        });
        match solution {
            Some(solution) => Ok(newton.into_solution(solution, law)),
            None => Err(Trace {
                newton: newton.history,
                applications: newton.applications,
                ..Trace::default()
            }),
        }
    }
}

impl NewtonKrylov<'_> {
    /// The rounding of S λ.
    fn attainable(&self) -> f64 {
        rounding_of_products(self.stiffness.len())
    }

    /// A solution with its error: by Newton's method from a start to r_tol ε, and where the error is larger than ε still, to rounding, with
    /// residuals measured by local stiffness.
    fn solve(
        &mut self,
        start: Iterate<RefinedState>,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Option<(Iterate<RefinedState>, f64)> {
        let settings = self.problem.settings;
        let (epsilon, attainable) = (settings.epsilon(), self.attainable());
        let tolerance = (settings.r_tol * epsilon).max(attainable);
        let near = self.descend(start, tolerance, observe)?;
        let error = self.error(&near);
        if error <= epsilon.max(attainable) {
            return Some((near, error));
        }
        let shared = std::mem::replace(&mut self.conditions.steplengths, self.stiffness.to_vec());
        let start = self.at(&near.point.unknowns, Some(&near.point));
        let (iterate, error) = match self.descend(start, attainable, observe) {
            Some(nearer) => match self.error(&nearer) {
                next if next < error => (nearer, next),
                _ => (near, error),
            },
            None => (near, error),
        };
        self.conditions.steplengths = shared;
        (error <= REFINEMENT_TARGET).then_some((iterate, error))
    }

    /// Damped inexact Newton steps until ‖R‖ ≤ tolerance ‖λ‖ or rounding forbids it; `None` where the residual stalls before.
    fn descend(
        &mut self,
        start: Iterate<RefinedState>,
        tolerance: f64,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Option<Iterate<RefinedState>> {
        self.last_norm = None;
        let done = self.history.len();
        let settings = NewtonSettings {
            tolerance,
            max_steps: LOOP_MAX_STEPS,
            rounding_steps: ROUNDING_STALL_STEPS - 1,
            ..NewtonSettings::default()
        };
        let observe = |k: usize, step: &NewtonStep| observe(Progress::Newton(done + k, step));
        let (stop, reached, history) = iterate(self, start, &settings, observe);
        self.history.extend(history);
        stop.is_solution().then_some(reached)
    }

    /// From the solution of a similar problem: after a step whose zones its stresses tell, and, where that leads nowhere, with short
    /// steplengths until the zones are settled.
    fn solve_similar(
        &mut self,
        start: &[f64],
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Option<(Iterate<RefinedState>, f64)> {
        let near = self.at(start, None);
        if near.relative() <= NEWTON_BASIN {
            return self.solve(near, observe);
        }
        self.scale_steplengths(ZONE_STEPLENGTH);
        let at = self.at(start, None);
        let direction = self.step(&at, SMALLEST_FORCING);
        let mut settled = start.to_vec();
        add_scaled(&mut settled, 1.0, &direction);
        self.scale_steplengths(1.0);
        let settled = self.at(&settled, None);
        let found = (settled.relative() < 1.0).then(|| self.solve(settled, observe));
        found.flatten().or_else(|| {
            self.scale_steplengths(SHORT_STEPLENGTH);
            let start = self.at(start, None);
            let near = self.descend(start, NEWTON_BASIN, observe);
            self.scale_steplengths(1.0);
            let near = near?.point;
            let near = self.at(&near.unknowns, Some(&near));
            self.solve(near, observe)
        })
    }

    /// ρ = 1/S_ii times a factor.
    fn scale_steplengths(&mut self, factor: f64) {
        let scaled = self.levels.steplengths.iter().map(|rho| rho * factor);
        self.conditions.steplengths = scaled.collect();
    }

    /// λ with u = A⁻¹(l − Bᵀλ) and R to rounding, `near` those of another λ.
    fn at(&mut self, multiplier: &[f64], near: Option<&RefinedState>) -> Iterate<RefinedState> {
        let start = near.map(|state| &state.solved);
        let (conditions, target) = (&self.conditions, DISPLACEMENT_TOLERANCE);
        let (point, evaluation) = self
            .problem
            .residual_at(conditions, multiplier, start, target);
        self.applications += 1;
        Iterate {
            size: norm(multiplier),
            point,
            evaluation,
        }
    }

    /// d with ‖R'(λ) d + R‖ ≤ forcing ‖R‖, or what the most products lead to.
    fn step(&mut self, from: &Iterate<RefinedState>, forcing: f64) -> Vec<f64> {
        let n_nodes = self.problem.laws.average.rows;
        let levels = TwoLevels::at(&self.levels, &self.conditions, &from.evaluation, n_nodes);
        let rhs: Vec<f64> = from.evaluation.residual.iter().map(|r| -r).collect();
        let solved = gmres(&rhs, forcing, GMRES_MAX_APPLICATIONS, |v| {
            let v = levels.apply(v);
            let (gradient, slips) = change(self.problem, &self.reach, &v);
            self.applications += 1;
            self.conditions
                .derivative(&from.evaluation, &v, &gradient, &slips)
        });
        levels.apply(&solved)
    }

    /// How far λ is from the solution: one more step, with the refined R.
    fn error(&mut self, near: &Iterate<RefinedState>) -> f64 {
        let step = self.step(near, GMRES_TOLERANCE);
        let (multiplier, here) = (&near.point.unknowns, &near.evaluation);
        // No step for a residual is no error of zero.
        match step.iter().any(|it| *it != 0.0) || here.norm == 0.0 {
            true => self.problem.relative(&step, multiplier, here),
            false => f64::NAN,
        }
    }

    /// S_νν⁻¹h_ν and no tangential stress, to the forcing term of a first step: a face that slides freely and does not lift off.
    fn bilateral_frictionless(&mut self) -> Vec<f64> {
        let dual = self.problem.dual;
        let normals = dual.layout().normals();
        let rho = &self.levels.steplengths;
        let levels = TwoLevels::bilateral_frictionless(&self.levels, dual.layout());
        let scaled = |gradient: &[f64]| -> Vec<f64> {
            let mut scaled = vec![0.0; rho.len()];
            normals
                .clone()
                .for_each(|i| scaled[i] = rho[i] * gradient[i]);
            scaled
        };
        let rhs = scaled(dual.dual_rhs());
        let solved = gmres(&rhs, LARGEST_FORCING, GMRES_MAX_APPLICATIONS, |v| {
            let mut stresses = levels.apply(v);
            stresses[normals.end..].fill(0.0);
            self.applications += 1;
            scaled(&change(self.problem, &self.reach, &stresses).0)
        });
        let mut start = levels.apply(&solved);
        start[normals.end..].fill(0.0);
        start
    }

    /// The solution with what belongs to it.
    fn into_solution(
        self,
        (found, error): (Iterate<RefinedState>, f64),
        law: &CoulombLaw,
    ) -> Solution {
        let laws = self.problem.laws;
        let epsilon = self.problem.settings.epsilon();
        let assessment = Assessment::of_refined(error, epsilon, self.attainable());
        let RefinedState {
            unknowns: multiplier,
            displacement,
            ..
        } = found.point;
        let slip = law.depends_on_slip().then(|| {
            let tangential = self.problem.body.tangential(&displacement);
            slips(laws.previous.as_ref(), &tangential)
        });
        let (normal, _) = laws.layout.split(&multiplier);
        let at_nodes = slip.as_deref().unwrap_or_default();
        let ContactSolve { body, dual, .. } = self.problem;
        let mut operator = ContactOperator::implicit(body.assembly, dual);
        let coulomb = laws.state(law, normal, at_nodes);
        let trace = Trace {
            steplength: projected_gradient_steplength(&mut operator),
            solved_by: SolvedBy::Newton,
            local_stiffness: self.stiffness.to_vec(),
            newton: self.history,
            applications: self.applications + operator.applications(),
            ..Trace::default()
        };
        Solution {
            friction: Some(FrictionState {
                slip,
                coulomb,
                ..FrictionState::default()
            }),
            ..assessment.solution(multiplier, displacement, trace)
        }
    }
}

/// The supernodes between the contact nodes and the root of the elimination tree.
fn reach(body: &ContactBody<'_>) -> Vec<usize> {
    let dofs = &body.assembly.primal.dofs;
    let nodes = body.face.surface.nodes_of_both_sides();
    let rows = nodes.chain(dofs.n_nodes..dofs.dof.len());
    let free = rows.flat_map(|row| dofs.terms(row, [1.0; 3]).map(|(dof, _)| dof));
    body.assembly.factor.structure().reach(free)
}

/// S v in m³, `[n_multipliers]`, and the change of (u_t1, u_t2) at the contact nodes in m, `[n_contact_nodes]`, for a change v of the
/// multipliers in Pa: one pair of substitutions, in the precision of the factor.
fn change(
    problem: &ContactSolve<'_>,
    reach: &[usize],
    stresses: &[f64],
) -> (Vec<f64>, Vec<[f64; 2]>) {
    let ContactSolve { body, dual, .. } = problem;
    let mut response = dual.coupling.nodal_forces(stresses);
    let factor = &body.assembly.factor;
    factor.solve_reached(reach, &mut response);
    problem.change(response, &[])
}
