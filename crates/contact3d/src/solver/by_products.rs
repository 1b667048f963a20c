//! Newton's method on Coulomb's law where S is implicit: no matrix of the size of S, only products with it.
//!
//! R'(λ) d = −R(λ) is solved by GMRES to a share that shrinks with ‖R‖ (S. C. Eisenstat, H. F. Walker, *SIAM J. Sci. Comput.* 17 (1996)
//! 16), preconditioned from the right by [`TwoLevels`]. Each product takes one pair of substitutions with the factor of A, in its
//! precision: what it has wrong costs steps, for R is exact.
//!
//! R is measured with ρ = 1/S_ii, of which the aggregates give the part that a pane shares with others. Measured by its local stiffness, a
//! small error of the face as a whole hides the zones, and steps are cut short until nothing moves.

use super::{
    ContactBody, FrictionState, LOOP_MAX_STEPS, NewtonStep, PaneLaws, Progress, Solution, SolvedBy,
    Trace,
    accuracy::{DISPLACEMENT_TOLERANCE, GMRES_MAX_APPLICATIONS, GMRES_TOLERANCE},
    assessment::{Assessment, REFINEMENT_TARGET},
    conditions::{Bound, Conditions, Evaluation},
    inner::projected_gradient_steplength,
    newton::iteration::{
        NEWTON_BASIN, NewtonModel, NewtonSettings, NewtonStatus, ROUNDING_STALL_STEPS,
        STAGNATION_STEPS, StoppingRule, iterate,
    },
    problem::{ContactSolve, Exact},
    two_levels::{PaneLevels, TwoLevels},
};
use crate::{
    contact::CoulombLaw,
    dual::{ContactOperator, DualOperator},
    linalg::{Precision, add_scaled, gmres, norm},
};

/// The shares of −R that GMRES leaves. Less than the smallest is lost where the factor is in single precision.
const LARGEST_FORCING: f64 = 0.1;
const SMALLEST_FORCING: f64 = 0.01;

/// With this share of ρ = 1/S_ii the stresses of a start tell its zones, whatever its displacement. So does the first step from another
/// mesh, where the body as a whole is displaced further than zones differ.
const ZONE_STEPLENGTH: f64 = 1e-2;

/// With this share steps settle the zones of bodies that move so far as a whole that all their panes count as open.
const SHORT_STEPLENGTH: f64 = 0.1;

/// A Coulomb problem with an implicit S.
struct ProductNewton<'a> {
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

/// λ with its exact displacement and R.
struct Iterate {
    multiplier: Vec<f64>,
    exact: Exact,
    at: Evaluation,
}

impl NewtonModel for ProductNewton<'_> {
    type Iterate = Iterate;

    fn evaluation<'i>(&self, iterate: &'i Iterate) -> &'i Evaluation {
        &iterate.at
    }

    fn relative(&self, iterate: &Iterate) -> f64 {
        iterate.at.relative_to(norm(&iterate.multiplier))
    }

    fn direction(&mut self, from: &Iterate) -> Option<(Vec<f64>, usize)> {
        let smallest = match self.problem.body.precision() {
            Precision::Single => SMALLEST_FORCING,
            Precision::Double => GMRES_TOLERANCE,
        };
        // Eisenstat and Walker's second choice, with their factor.
        let share = self.last_norm.map_or(LARGEST_FORCING, |last| {
            let falls = from.at.norm / last;
            (0.9 * falls * falls).clamp(smallest, LARGEST_FORCING)
        });
        self.last_norm = Some(from.at.norm);
        let step = self.step(from, share);
        let n = step.len();
        Some((step, n))
    }

    fn moved(&mut self, from: &Iterate, direction: &[f64], share: f64) -> Iterate {
        let mut multiplier = from.multiplier.clone();
        add_scaled(&mut multiplier, share, direction);
        self.at(multiplier, Some(&from.exact))
    }
}

impl ContactSolve<'_> {
    /// The problem without a dense S: Coulomb's law by Newton's method, and where that has no solution, and for other laws, by gradients.
    pub(super) fn by_products(
        &self,
        bound: Bound<'_>,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Solution {
        let Some(law) = self.laws.coulomb() else {
            return self.convex_by_products(bound, observe);
        };
        let by_newton = self.newton_by_products(law, &self.pane_stiffness(), observe);
        by_newton.unwrap_or_else(|| self.by_gradients(bound, observe))
    }

    /// Coulomb's law by Newton's method with products of S alone, from the given start and from the face that slides freely; `None`
    /// where no start leads to a solution, and for a body that floats.
    fn newton_by_products(
        &self,
        law: &CoulombLaw,
        stiffness: &[f64],
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Option<Solution> {
        if self.dual.rigid().is_some() || self.start.checkpoint.is_some() {
            return None;
        }
        let (bound, layout) = (Bound::Coulomb(self.laws, law), self.dual.layout());
        let levels = PaneLevels::new(self.body.assembly, &self.dual.coupling, stiffness);
        let mut newton = ProductNewton {
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
            let pressed = newton.pressed();
            let start = newton.at(pressed.clone(), None);
            let found = newton.solve(start, observe);
            found.or_else(|| {
                newton.conditions.steplengths = stiffness.to_vec();
                let start = newton.at(pressed, None);
                newton.solve(start, observe)
            })
        })?;
        Some(newton.completed(solution, self.laws, law))
    }
}

/// A solution and what its error makes of it.
struct Found {
    iterate: Iterate,
    assessment: Assessment,
}

impl ProductNewton<'_> {
    /// Newton's method from a start to r_tol ε, and where the error is larger than ε still, to rounding, with residuals measured by local
    /// stiffness: 1/S_ii hides what panes feel of errors near rounding.
    fn solve(&mut self, start: Iterate, observe: &mut dyn FnMut(Progress<'_>)) -> Option<Found> {
        let settings = self.problem.settings;
        let n = start.multiplier.len() as f64;
        let (epsilon, attainable) = (settings.epsilon(), n * f64::EPSILON);
        let tolerance = (settings.r_tol * epsilon).max(attainable);
        let near = self.descend(start, tolerance, observe)?;
        let error = self.error(&near);
        let found = |iterate, error: f64| Found {
            iterate,
            assessment: Assessment::of_refined(error, epsilon, attainable),
        };
        if error <= epsilon.max(attainable) {
            return Some(found(near, error));
        }
        let whole = std::mem::replace(&mut self.conditions.steplengths, self.stiffness.to_vec());
        let start = self.at(near.multiplier.clone(), Some(&near.exact));
        let (iterate, error) = match self.descend(start, attainable, observe) {
            Some(nearer) => {
                let error = self.error(&nearer);
                (nearer, error)
            }
            None => (near, error),
        };
        self.conditions.steplengths = whole;
        (error <= REFINEMENT_TARGET).then(|| found(iterate, error))
    }

    /// Damped inexact Newton steps until ‖R‖ ≤ tolerance ‖λ‖ or rounding forbids it; `None` where the residual stalls before.
    fn descend(
        &mut self,
        start: Iterate,
        tolerance: f64,
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Option<Iterate> {
        self.last_norm = None;
        let done = self.history.len();
        let rule = StoppingRule {
            settings: NewtonSettings {
                tolerance,
                max_steps: LOOP_MAX_STEPS,
            },
            least_steps: 0,
            stagnation_steps: STAGNATION_STEPS,
            rounding_steps: ROUNDING_STALL_STEPS - 1,
        };
        let observe = |k: usize, step: &NewtonStep| observe(Progress::Newton(done + k, step));
        let found = iterate(self, start, &rule, observe);
        self.history.extend(found.history);
        let is_solution = matches!(
            found.status,
            NewtonStatus::Converged | NewtonStatus::RoundingLimit
        );
        is_solution.then_some(found.iterate)
    }

    /// From the answer of a similar problem: after a step whose zones its stresses tell, and, where that leads nowhere, with short
    /// steplengths until the zones are settled.
    fn solve_similar(
        &mut self,
        start: &[f64],
        observe: &mut dyn FnMut(Progress<'_>),
    ) -> Option<Found> {
        let near = self.at(start.to_vec(), None);
        if self.relative(&near) <= NEWTON_BASIN {
            return self.solve(near, observe);
        }
        let settled = self.with_steplengths(ZONE_STEPLENGTH, |newton| {
            let at = newton.at(start.to_vec(), None);
            let direction = newton.step(&at, SMALLEST_FORCING);
            let mut settled = at.multiplier;
            add_scaled(&mut settled, 1.0, &direction);
            settled
        });
        let settled = self.at(settled, None);
        let found = (self.relative(&settled) < 1.0).then(|| self.solve(settled, observe));
        found.flatten().or_else(|| {
            let near = self.with_steplengths(SHORT_STEPLENGTH, |newton| {
                let start = newton.at(start.to_vec(), None);
                newton.descend(start, NEWTON_BASIN, observe)
            })?;
            let near = self.at(near.multiplier, Some(&near.exact));
            self.solve(near, observe)
        })
    }

    /// With steplengths ρ that are multiplied by a share.
    fn with_steplengths<T>(&mut self, share: f64, run: impl FnOnce(&mut Self) -> T) -> T {
        let whole = self.conditions.steplengths.clone();
        self.conditions
            .steplengths
            .iter_mut()
            .for_each(|rho| *rho *= share);
        let value = run(self);
        self.conditions.steplengths = whole;
        value
    }

    /// λ with u = A⁻¹(l − Bᵀλ) and R to rounding, `near` those of another λ.
    fn at(&mut self, multiplier: Vec<f64>, near: Option<&Exact>) -> Iterate {
        let ContactSolve { body, dual, .. } = self.problem;
        let start = near.map(|exact| &exact.solved);
        let start = start.filter(|_| body.precision() == Precision::Single);
        let (exact, at) = body.residual_at(
            dual,
            &self.conditions,
            &multiplier,
            start,
            DISPLACEMENT_TOLERANCE,
        );
        self.applications += 1;
        Iterate {
            multiplier,
            exact,
            at,
        }
    }

    /// d with ‖R'(λ) d + R‖ ≤ share ‖R‖, or what the most products lead to.
    fn step(&mut self, from: &Iterate, share: f64) -> Vec<f64> {
        let n_nodes = self.problem.laws.average.rows;
        let levels = TwoLevels::at(&self.levels, &self.conditions, &from.at, n_nodes);
        let rhs: Vec<f64> = from.at.residual.iter().map(|r| -r).collect();
        let solved = gmres(&rhs, share, GMRES_MAX_APPLICATIONS, |v| {
            let v = levels.apply(v);
            let (gradient, slips) = change(self.problem, &self.reach, &v);
            self.applications += 1;
            self.conditions.derivative(&from.at, &v, &gradient, &slips)
        });
        levels.apply(&solved)
    }

    /// How far λ is from the solution: one more step, with the exact R.
    fn error(&mut self, answer: &Iterate) -> f64 {
        let way = self.step(answer, GMRES_TOLERANCE);
        let sizes = self.problem.sizes(&answer.multiplier, &answer.at);
        sizes.relative(self.problem.laws, &way)
    }

    /// S_νν⁻¹h_ν and no tangential stress, to the share that a first step leaves: a face that slides freely and does not lift off.
    fn pressed(&mut self) -> Vec<f64> {
        let dual = self.problem.dual;
        let normals = dual.layout().normals();
        let rho = &self.levels.steplengths;
        let levels = TwoLevels::pressed(&self.levels, dual.layout());
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

    /// The answer with what belongs to it.
    fn completed(self, found: Found, laws: &PaneLaws, law: &CoulombLaw) -> Solution {
        let Iterate {
            multiplier, exact, ..
        } = found.iterate;
        let displacement = exact.displacement;
        let slip = law.depends_on_slip().then(|| {
            let tangential = self.problem.body.tangential(&displacement);
            laws.slip.slip(&tangential)
        });
        let (normal, _) = laws.layout.split(&multiplier);
        let at_nodes = slip.as_deref().unwrap_or_default();
        let ContactSolve { body, dual, .. } = self.problem;
        let mut operator = ContactOperator::implicit(body.assembly, dual);
        let coulomb = laws.state(law, normal, |l| l.max(0.0), at_nodes);
        Solution {
            friction: Some(FrictionState {
                slip,
                coulomb,
                ..FrictionState::default()
            }),
            trace: Trace {
                steplength: projected_gradient_steplength(&mut operator),
                solved_by: SolvedBy::Newton,
                local_stiffness: self.stiffness.to_vec(),
                newton: self.history,
                applications: self.applications + operator.applications(),
                ..Trace::default()
            },
            displacement,
            multiplier,
            ..Solution::default()
        }
        .assessed(found.assessment)
    }
}

/// The supernodes between the contact nodes and the root of the elimination tree.
fn reach(body: &ContactBody<'_>) -> Vec<usize> {
    let dofs = &body.assembly.primal.dofs.dof;
    let nodes = body.face.surface.nodes.iter();
    let free = nodes.flat_map(|&node| dofs[node].into_iter().flatten());
    body.assembly.factor.structure().reach(free)
}

/// S v in m³ and the change of (u_t1, u_t2) at the contact nodes in m, in the precision of the factor.
fn change(
    problem: &ContactSolve<'_>,
    reach: &[usize],
    stresses: &[f64],
) -> (Vec<f64>, Vec<[f64; 2]>) {
    let ContactSolve { body, dual, .. } = problem;
    let mut moved = dual.coupling.nodal_forces(stresses);
    let factor = &body.assembly.factor;
    factor.solve_reached(reach, &mut moved);
    body.change(dual, moved, &[])
}
