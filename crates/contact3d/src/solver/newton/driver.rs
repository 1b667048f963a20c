//! Newton's method on a dense contact problem: which start strategies apply, and how each is run.

use super::{
    FrictionGraph, NewtonSettings, NewtonSolution, local_newton, minimise_frozen,
    natural_map::NaturalMap, newton, proximal_point,
};
use crate::{
    dual::{ExplicitDual, LocalStiffness},
    scene::Method,
    solver::{
        FeasibleSet, NewtonStep, StartStrategy,
        conditions::Bound,
        convex::{ConvexProgram, InteriorPoint},
        tolerances::{LOOP_MAX_STEPS, NEWTON_MAX_STEPS, ZONES_TOLERANCE},
    },
};

/// How far an interior point leaves the active set undecided, as a share of the largest stress, before Newton's method is tried
/// from there: later levels resolve smaller stresses.
const COMPLEMENTARITY_LEVELS: [f64; 4] = [1e-3, 1e-5, 1e-7, 1e-9];

/// Ratio of the rigid compliance of a pane to its local one from which relaxation, which works pane by pane, comes behind the interior point: a sweep moves the
/// body by some thousandth of what it lacks.
const LARGE_RIGID_COMPLIANCE: f64 = 1e3;

/// Newton's method on a dense contact problem, with what strategies need.
#[derive(Clone, Copy)]
pub(in crate::solver) struct NewtonDriver<'a> {
    pub(in crate::solver) dual: &'a ExplicitDual,
    pub(in crate::solver) bound: Bound<'a>,
    pub(in crate::solver) local: &'a LocalStiffness,
    pub(in crate::solver) start: Option<&'a [f64]>,
}

impl<'a> NewtonDriver<'a> {
    pub(in crate::solver) fn new(
        dual: &'a ExplicitDual,
        local: &'a LocalStiffness,
        bound: Bound<'a>,
        start: Option<&'a [f64]>,
    ) -> Self {
        Self {
            dual,
            bound,
            local,
            start,
        }
    }

    /// The strategies that apply, in order.
    pub(in crate::solver) fn strategies(&self, method: Method) -> Vec<StartStrategy> {
        let mut strategies = StartStrategy::ALL.to_vec();
        let (large, slides) = (self.has_large_rigid_compliance(), self.slides_apart());
        let place = |it: &StartStrategy| match it {
            StartStrategy::Relaxed if large => (StartStrategy::InteriorPoint as usize, true),
            StartStrategy::Separated if slides => (StartStrategy::Relaxed as usize, true),
            _ => (*it as usize, false),
        };
        strategies.sort_by_key(place);
        strategies.retain(|strategy| self.applies(*strategy, method));
        strategies
    }

    fn applies(&self, strategy: StartStrategy, method: Method) -> bool {
        match strategy {
            StartStrategy::Relaxed
            | StartStrategy::BondedContact
            | StartStrategy::BilateralFrictionless
            | StartStrategy::ContactSprings => true,
            StartStrategy::Separated => self.separated().is_some(),
            StartStrategy::Warm => self.start.is_some() && self.has_large_rigid_compliance(),
            StartStrategy::ProximalPoint => self.dual.rigid.is_some(),
            StartStrategy::InteriorPoint => matches!(self.bound, Bound::Given(_)),
            StartStrategy::FrictionGraph => {
                matches!(self.bound, Bound::Coulomb(_, law) if law.depends_on_slip())
            }
            StartStrategy::SuccessiveApproximations => {
                matches!(self.bound, Bound::Coulomb(..)) && method != Method::Newton
            }
        }
    }

    /// Runs one strategy that applies; `observe` sees its steps, numbered from `done` on. Successive approximations are no start of
    /// Newton's method, and [`crate::solver::solve`] runs them.
    pub(in crate::solver) fn run(
        &self,
        strategy: StartStrategy,
        done: usize,
        mut observe: impl FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        let observe = &mut |k: usize, step: &NewtonStep| observe(done + k, step);
        let (dual, local) = (self.dual, self.local);
        match (strategy, self.bound) {
            (StartStrategy::Separated, _) => {
                let start = self.separated().unwrap_or_else(|| self.zero_or_start());
                self.from(start, observe)
            }
            (StartStrategy::Warm, _) => self.from(self.zero_or_start(), observe),
            (StartStrategy::Relaxed, _) => self.relaxed(observe),
            (StartStrategy::BondedContact, _) => self.from(local.bonded_start(dual), observe),
            (StartStrategy::BilateralFrictionless, _) => {
                self.from(local.bilateral_frictionless_start(dual), observe)
            }
            (StartStrategy::ProximalPoint, _) => proximal_point(self, observe),
            (StartStrategy::ContactSprings, _) => self.contact_springs(observe),
            (StartStrategy::InteriorPoint, Bound::Given(set)) => {
                self.interior_point(set, &settings_for(ZONES_TOLERANCE), observe)
            }
            (StartStrategy::FrictionGraph, Bound::Coulomb(laws, law)) => {
                let graph = FrictionGraph::new(dual, laws, law, local);
                graph.map_or_else(|| NewtonSolution::failed(dual), |it| it.solve(observe))
            }
            _ => NewtonSolution::failed(dual),
        }
    }

    /// Minimises over a frozen set from the start, in one step at least, so that a start within the
    /// tolerance is measured and not believed; where that fails, by the interior point method.
    pub(in crate::solver) fn minimise(
        &self,
        set: &FeasibleSet,
        settings: &NewtonSettings,
    ) -> NewtonSolution {
        let mut start = self.zero_or_start();
        let measured = NewtonSettings {
            least_steps: 1,
            ..*settings
        };
        let found = if self.dual.contact_springs.is_some() || self.has_large_rigid_compliance() {
            set.project(&mut start);
            local_newton(&self.map(), start, &measured.near_solution(), |_, _| {})
        } else {
            minimise_frozen(self.dual, set, &start, &measured, |_, _| {})
        };
        match found.stop.is_solution() {
            true => found,
            false => found.merged_with(self.interior_point(set, settings, &mut |_, _| {})),
        }
    }

    /// Newton's method from a start, measured by local stiffness.
    pub(in crate::solver) fn from(
        &self,
        start: Vec<f64>,
        observe: &mut dyn FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        let settings = settings_for(ZONES_TOLERANCE).near_solution();
        local_newton(&self.map(), start, &settings, observe)
    }

    /// On a problem with contact springs, from the starts that serve it.
    fn contact_springs(&self, observe: &mut dyn FnMut(usize, &NewtonStep)) -> NewtonSolution {
        // Zones along a beam follow each other, a pane or two a step.
        let settings = NewtonSettings {
            max_steps: LOOP_MAX_STEPS,
            stagnation_steps: NEWTON_MAX_STEPS,
            ..settings_for(ZONES_TOLERANCE)
        };
        let (dual, local) = (self.dual, self.local);
        let starts = [
            self.zero_or_start(),
            local.bonded_start(dual),
            local.bilateral_frictionless_start(dual),
        ];
        let mut found = NewtonSolution::failed(dual);
        for start in starts {
            let done = found.history.len();
            let observe = |k: usize, step: &_| observe(done + k, step);
            found = found.merged_with(local_newton(&self.map(), start, &settings, observe));
            if found.stop.is_solution() {
                break;
            }
        }
        found
    }

    /// The natural map measured by local stiffness.
    pub(in crate::solver) fn map(&self) -> NaturalMap<'a> {
        NaturalMap::with_steplengths(self.dual, self.bound, self.local.stiffness.clone())
    }

    /// ‖R‖ / ‖λ‖ at unknowns, measured by local stiffness.
    pub(in crate::solver) fn residual(&self, unknowns: &[f64]) -> f64 {
        let map = self.map();
        map.evaluate(unknowns).relative_to(map.size(unknowns))
    }

    /// No contact force, and the motions of a body that nothing presses.
    fn separated(&self) -> Option<Vec<f64>> {
        let motion = self.dual.rigid.as_ref()?.separated(&self.dual.rhs)?;
        let n = self.dual.dimension();
        Some(std::iter::repeat_n(0.0, n).chain(motion).collect())
    }

    /// Whether friction may hold the faces together that nothing presses, as a cone in its seat.
    fn slides_apart(&self) -> bool {
        let equilibrium = self.dual.rigid.as_ref();
        equilibrium.is_some_and(|it| matches!(it.separation_motion, Some((_, true))))
    }

    /// Whether the body moves as a rigid one much further than its panes do, in S or beside it.
    fn has_large_rigid_compliance(&self) -> bool {
        let equilibrium = self.dual.rigid.as_ref();
        self.local.rigid_compliance_ratio() > LARGE_RIGID_COMPLIANCE
            || equilibrium.is_some_and(|it| it.coupling.n_supported() > 0)
    }

    fn zero_or_start(&self) -> Vec<f64> {
        self.dual.unknowns(self.start.unwrap_or_default())
    }

    fn relaxed(&self, observe: &mut dyn FnMut(usize, &NewtonStep)) -> NewtonSolution {
        let settings = NewtonSettings {
            tolerance: ZONES_TOLERANCE,
            ..NewtonSettings::default()
        };
        match self.bound {
            Bound::Coulomb(laws, law) => {
                newton(self.dual, laws, law, self.start, &settings, observe)
            }
            Bound::Given(set) => {
                let start = self.zero_or_start();
                minimise_frozen(self.dual, set, &start, &settings, observe)
            }
        }
    }

    /// A convex problem by the interior point method and Newton's by turns.
    pub(in crate::solver) fn interior_point(
        &self,
        set: &FeasibleSet,
        settings: &NewtonSettings,
        observe: &mut dyn FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        if self.dual.contact_springs.is_some() {
            return NewtonSolution::failed(self.dual);
        }
        let dual = self.dual.clone().absolute();
        let program = ConvexProgram::of_dual(&dual, set, self.local);
        let map = self.map();
        let settings = settings.near_solution();
        let mut from = |start: Vec<f64>, done: usize| {
            local_newton(&map, start, &settings, |k, step| observe(done + k, step))
        };
        let Some(mut inside) = InteriorPoint::new(&program) else {
            return from(self.dual.unknowns(&[]), 0);
        };
        let mut found = NewtonSolution::failed(self.dual);
        for level in COMPLEMENTARITY_LEVELS {
            let is_decided = inside.run(level);
            let start = inside.unknowns(self.dual.dimension());
            let next = from(start, found.history.len());
            found = found.merged_with(next);
            if found.stop.is_solution() || !is_decided {
                break;
            }
        }
        found
    }
}

fn settings_for(tolerance: f64) -> NewtonSettings {
    NewtonSettings {
        tolerance,
        max_steps: NEWTON_MAX_STEPS,
        ..NewtonSettings::default()
    }
}
