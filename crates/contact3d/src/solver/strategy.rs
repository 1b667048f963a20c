//! The strategies that lead Newton's method to a solution, in the order in which they are tried.
//!
//! Newton's method converges from the right contact zones; a strategy is a way to find these. [`StartStrategy::ALL`] is the policy: each
//! entry says when it applies, what it does and why it is there. What each did in the campaigns of random scenes is in
//! `docs/explanation/strategies.md`. The loop over them is [`super::solve`].

use super::{
    FeasibleSet, NewtonStep, PaneLaws,
    conditions::Bound,
    convex::{ConvexProgram, InteriorPoint},
    newton::{
        FrictionGraph, NewtonSettings, NewtonSolution, continuation, iteration::NEWTON_BASIN,
        minimise_frozen_in, natural_map::NaturalMap, newton, newton_from, proximal_point,
    },
};
use crate::{
    contact::CoulombLaw,
    dual::{ExplicitDual, LocalStiffness},
};

/// ‖R‖ / ‖λ‖ at which the zones are found; iterative refinement does the rest.
pub(in crate::solver) const ZONES_FOUND: f64 = 1e-8;

/// Most steps of Newton's method from one start: of the friction graph those that lead to a solution take a median of 13, refinement one or
/// two, more where the exact residual moves panes between zones.
pub(in crate::solver) const NEWTON_MAX_STEPS: usize = 40;

/// Steps in ρ from 1/S_ii to the local stiffness.
const STEPLENGTH_STEPS: i32 = 8;

/// How far an interior point leaves the active set undecided, as a share of the largest stress, before Newton's method is tried
/// from there: further on, small stresses are told from none.
const COMPLEMENTARITY_LEVELS: [f64; 4] = [1e-3, 1e-5, 1e-7, 1e-9];

/// Ratio of the rigid compliance of a pane to its local one from which relaxation, which works pane by pane, comes last.
const LARGE_RIGID_COMPLIANCE: f64 = 1e3;

/// The coefficient F₀ of the easiest law of [`StartStrategy::FrictionContinuation`]: contact with little friction is nearly that
/// without, which is convex.
const REFERENCE_COEFFICIENT: f64 = 0.1;

/// Where Newton's method begins, or how it comes nearer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StartStrategy {
    /// From the face that is separated from its foundation, where the load drives no motion that presses a pane: rigid motions are then
    /// free, and no other start has all panes open.
    Separated,
    /// From the multipliers of a similar problem, on a body whose rigid compliance is large; others begin there by relaxation.
    Warm,
    /// From given multipliers or zero, with sweeps of nonlinear Gauss–Seidel around every step (C. Gräser, R. Kornhuber, *J. Comput.
    /// Math.* 27 (2009) 1): errors of single panes vanish in the sweeps, errors over many panes in the step. First where it works
    /// best, last on bodies with a large rigid compliance, which sweeps cannot move.
    Relaxed,
    /// From the bonded face, λ = S⁻¹h: every pane pressed and sticking.
    BondedContact,
    /// From the face without friction that cannot lift off, λ_ν = S_νν⁻¹h_ν: every pane pressed and sliding.
    BilateralFrictionless,
    /// By the proximal point method on rigid motions, where contact holds the body (R. T. Rockafellar, *SIAM J. Control Optim.* 14
    /// (1976) 877): panes that open may leave a motion free, and the matrix of Newton's method singular.
    ProximalPoint,
    /// From points inside the admissible set of a convex problem (S. Mehrotra, *SIAM J. Optim.* 2 (1992) 575): the only start that
    /// always leads to the solution, whatever the condition of S.
    InteriorPoint,
    /// Along natural maps whose steplengths go from 1/S_ii to the local stiffness, each solved from the one before: the first moves
    /// the body, the last sees its panes.
    SteplengthContinuation,
    /// Along the laws F₀^(1−τ) F^τ from little friction to that of the scene, for coefficients that are large or fall with the slip.
    FrictionContinuation,
    /// With coefficients of friction as unknowns, for coefficients that rise steeply with the slip.
    FrictionGraph,
    /// By successive approximations (HKL Algorithm 4.1): a fixed point that attracts is found from afar.
    SuccessiveApproximations,
}

impl StartStrategy {
    /// All of them, in the order in which they are tried; [`Self::Relaxed`] moves behind the others where the rigid compliance is large.
    pub const ALL: [Self; 11] = [
        Self::Separated,
        Self::Warm,
        Self::Relaxed,
        Self::BondedContact,
        Self::BilateralFrictionless,
        Self::ProximalPoint,
        Self::InteriorPoint,
        Self::SteplengthContinuation,
        Self::FrictionContinuation,
        Self::FrictionGraph,
        Self::SuccessiveApproximations,
    ];

    /// The strategy as programs see it.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Separated => "separated",
            Self::Warm => "warm",
            Self::Relaxed => "relaxed",
            Self::BondedContact => "bonded_contact",
            Self::BilateralFrictionless => "bilateral_frictionless",
            Self::ProximalPoint => "proximal_point",
            Self::InteriorPoint => "interior_point",
            Self::SteplengthContinuation => "steplength_continuation",
            Self::FrictionContinuation => "friction_continuation",
            Self::FrictionGraph => "friction_graph",
            Self::SuccessiveApproximations => "successive_approximations",
        }
    }
}

/// Newton's method on a dense contact problem, with what strategies need.
pub(in crate::solver) struct NewtonDriver<'a> {
    pub(in crate::solver) dual: &'a ExplicitDual,
    pub(in crate::solver) bound: Bound<'a>,
    pub(in crate::solver) local: &'a LocalStiffness,
    pub(in crate::solver) start: Option<&'a [f64]>,
}

impl<'a> NewtonDriver<'a> {
    /// The strategies that apply, in order.
    pub(in crate::solver) fn strategies(&self) -> Vec<StartStrategy> {
        let mut strategies = StartStrategy::ALL.to_vec();
        if self.has_large_rigid_compliance() {
            let relaxed = strategies
                .iter()
                .position(|it| *it == StartStrategy::Relaxed);
            let behind = strategies
                .iter()
                .position(|it| *it == StartStrategy::FrictionContinuation);
            if let (Some(from), Some(to)) = (relaxed, behind) {
                strategies[from..=to].rotate_left(1);
            }
        }
        strategies.retain(|strategy| self.applies(*strategy));
        strategies
    }

    fn applies(&self, strategy: StartStrategy) -> bool {
        let is_coulomb = matches!(self.bound, Bound::Coulomb(..));
        match strategy {
            StartStrategy::Separated => self.separated().is_some(),
            StartStrategy::Warm => self.start.is_some() && self.has_large_rigid_compliance(),
            StartStrategy::ProximalPoint => self.dual.rigid.is_some(),
            StartStrategy::InteriorPoint => !is_coulomb,
            StartStrategy::FrictionContinuation | StartStrategy::SuccessiveApproximations => {
                is_coulomb
            }
            StartStrategy::FrictionGraph => match self.bound {
                Bound::Coulomb(_, law) => FrictionGraph::applies(self.dual, law),
                Bound::Frozen(_) => false,
            },
            StartStrategy::Relaxed
            | StartStrategy::BondedContact
            | StartStrategy::BilateralFrictionless
            | StartStrategy::SteplengthContinuation => true,
        }
    }

    /// Runs one strategy; `observe` sees its steps, numbered from `done` on. Successive approximations are no start of Newton's method,
    /// and [`super::solve`] runs them.
    pub(in crate::solver) fn run(
        &self,
        strategy: StartStrategy,
        done: usize,
        mut observe: impl FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        let mut observe = |k: usize, step: &NewtonStep| observe(done + k, step);
        match (strategy, self.bound) {
            (StartStrategy::Separated, _) => {
                let start = self.separated().unwrap_or_else(|| self.zero_or_start());
                self.from(start, &mut observe)
            }
            (StartStrategy::Warm, _) => self.from(self.zero_or_start(), &mut observe),
            (StartStrategy::BondedContact, _) => {
                self.from(self.local.bonded_start(self.dual), &mut observe)
            }
            (StartStrategy::BilateralFrictionless, _) => self.from(
                self.local.bilateral_frictionless_start(self.dual),
                &mut observe,
            ),
            (StartStrategy::ProximalPoint, _) => proximal_point(self, &mut observe),
            (StartStrategy::SteplengthContinuation, _) => {
                self.steplength_continuation(&mut observe)
            }
            (StartStrategy::InteriorPoint, Bound::Frozen(set)) => {
                self.interior_point(set, &to(ZONES_FOUND), &mut observe)
            }
            (StartStrategy::FrictionContinuation, Bound::Coulomb(laws, law)) => {
                self.friction_continuation(laws, law, &mut observe)
            }
            (StartStrategy::FrictionGraph, Bound::Coulomb(_, law)) => match self.graph() {
                Some(graph) => graph.solve(law, &mut observe),
                None => self.relaxed(&mut observe),
            },
            (StartStrategy::Relaxed, _)
            | (StartStrategy::SuccessiveApproximations, _)
            | (StartStrategy::InteriorPoint, Bound::Coulomb(..))
            | (
                StartStrategy::FrictionContinuation | StartStrategy::FrictionGraph,
                Bound::Frozen(_),
            ) => self.relaxed(&mut observe),
        }
    }

    /// Minimises over a frozen set from the start, in one step at least, so that a start within the
    /// tolerance is measured and not believed.
    pub(in crate::solver) fn minimise(
        &self,
        set: &FeasibleSet<'_>,
        settings: &NewtonSettings,
    ) -> NewtonSolution {
        let start = self.zero_or_start();
        let mut found = if self.has_large_rigid_compliance() {
            let mut first = start.clone();
            set.project(&mut first);
            newton_from(&self.map(), first, settings, 1, |_, _| {})
        } else {
            minimise_frozen_in(self.dual, set, &start, settings, 1, |_, _| {})
        };
        for strategy in self.strategies() {
            if found.is_solution() {
                break;
            }
            let near = self.run(strategy, 0, |_, _| {});
            let start = near.multiplier.clone();
            let next = newton_from(&self.map(), start, settings, 1, |_, _| {});
            found = found.merged_with(near).merged_with(next);
        }
        found
    }

    /// Newton's method from a start, measured by local stiffness.
    pub(in crate::solver) fn from(
        &self,
        start: Vec<f64>,
        observe: &mut dyn FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        newton_from(&self.map(), start, &to(ZONES_FOUND), 0, observe)
    }

    /// The natural map measured by local stiffness.
    pub(in crate::solver) fn map(&self) -> NaturalMap<'a> {
        self.map_of(self.bound)
    }

    fn map_of(&self, bound: Bound<'a>) -> NaturalMap<'a> {
        NaturalMap::with_steplengths(self.dual, bound, self.local.stiffness.clone())
    }

    /// No contact force, and the motions of a body that nothing presses.
    fn separated(&self) -> Option<Vec<f64>> {
        let motion = self.dual.rigid.as_ref()?.separated(&self.dual.rhs)?;
        let n = self.dual.dimension();
        Some(std::iter::repeat_n(0.0, n).chain(motion).collect())
    }

    fn graph(&self) -> Option<FrictionGraph<'a>> {
        match self.bound {
            Bound::Coulomb(laws, law) => FrictionGraph::new(self.dual, laws, law, self.local),
            Bound::Frozen(_) => None,
        }
    }

    /// Whether the body moves as a rigid one much further than its panes do, in S or beside it.
    fn has_large_rigid_compliance(&self) -> bool {
        let balance = self.dual.rigid.as_ref();
        self.local.rigid_compliance_ratio() > LARGE_RIGID_COMPLIANCE
            || balance.is_some_and(|it| it.coupling.n_supported() > 0)
    }

    fn zero_or_start(&self) -> Vec<f64> {
        self.dual.unknowns(self.start.unwrap_or_default())
    }

    fn relaxed(&self, observe: &mut dyn FnMut(usize, &NewtonStep)) -> NewtonSolution {
        let settings = NewtonSettings {
            tolerance: ZONES_FOUND,
            ..NewtonSettings::default()
        };
        match self.bound {
            Bound::Coulomb(laws, law) => {
                newton(self.dual, laws, law, self.start, &settings, observe)
            }
            Bound::Frozen(set) => {
                let start = self.zero_or_start();
                minimise_frozen_in(self.dual, set, &start, &settings, 0, observe)
            }
        }
    }

    /// A convex problem by the interior point method and Newton's by turns.
    pub(in crate::solver) fn interior_point(
        &self,
        set: &FeasibleSet<'_>,
        settings: &NewtonSettings,
        observe: &mut dyn FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        let dual = self.dual.clone().absolute();
        let program = ConvexProgram::of_dual(&dual, set, self.local);
        let map = self.map();
        let mut from = |start: Vec<f64>, done: usize| {
            newton_from(&map, start, settings, 0, |k, step| observe(done + k, step))
        };
        let Some(mut inside) = InteriorPoint::new(&program) else {
            return from(self.dual.unknowns(&[]), 0);
        };
        let mut found: Option<NewtonSolution> = None;
        for share in COMPLEMENTARITY_LEVELS {
            let is_decided = inside.run(share);
            let mut history = found.take().map_or_else(Vec::new, |before| before.history);
            let start = inside.unknowns(self.dual.dimension());
            let next = from(start, history.len());
            history.extend(next.history);
            let next = NewtonSolution { history, ..next };
            let ends = next.is_solution() || !is_decided;
            found = Some(next);
            if ends {
                break;
            }
        }
        let mut found = found.expect("there is always a level");
        found.evaluations += inside.steps;
        found
    }

    fn steplength_continuation(
        &self,
        observe: &mut dyn FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        let first = NaturalMap::new(self.dual, self.bound)
            .conditions
            .steplengths;
        let mut found = NewtonSolution::none(self.dual);
        for step in 0..=STEPLENGTH_STEPS {
            let share = f64::from(step) / f64::from(STEPLENGTH_STEPS);
            let ends = first.iter().zip(&self.local.stiffness);
            // Powers of their ratio alone, which has no unit: the bits are those of any unit that differs by powers of two.
            let steplengths = ends
                .map(|(a, b)| match b {
                    0.0 => 0.0,
                    b => b * (a / b).powf(1.0 - share),
                })
                .collect();
            let map = NaturalMap::with_steplengths(self.dual, self.bound, steplengths);
            let tolerance = if step < STEPLENGTH_STEPS {
                NEWTON_BASIN
            } else {
                ZONES_FOUND
            };
            let done = found.history.len();
            let start = found.multiplier.clone();
            let next = newton_from(&map, start, &to(tolerance), 0, |k, step| {
                observe(done + k, step);
            });
            found = found.merged_with(next);
        }
        found
    }

    fn friction_continuation(
        &self,
        laws: &'a PaneLaws,
        law: &CoulombLaw,
        observe: &mut dyn FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        let by_local_stiffness = self.has_large_rigid_compliance();
        continuation(observe, |share, start| {
            let law = law.relaxed(REFERENCE_COEFFICIENT, share);
            if !by_local_stiffness {
                return newton(self.dual, laws, &law, start, &to(ZONES_FOUND), |_, _| {});
            }
            let start = match start {
                Some(start) => start.to_vec(),
                None => self.local.bilateral_frictionless_start(self.dual),
            };
            let steplengths = self.local.stiffness.clone();
            let bound = Bound::Coulomb(laws, &law);
            let map = NaturalMap::with_steplengths(self.dual, bound, steplengths);
            newton_from(&map, start, &to(ZONES_FOUND), 0, |_, _| {})
        })
    }
}

fn to(tolerance: f64) -> NewtonSettings {
    NewtonSettings {
        tolerance,
        max_steps: NEWTON_MAX_STEPS,
    }
}
