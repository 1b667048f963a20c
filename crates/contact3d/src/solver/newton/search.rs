//! Newton's method from several starts, by continuation and with relaxed steps where plain ones fail.

use super::{
    NewtonSettings, NewtonSolution,
    continuation::{continuation, softened},
    minimise_frozen_in,
    natural_map::NaturalMap,
    newton, newton_from,
};
use crate::{
    contact::CoulombLaw,
    dual::{ExplicitDual, LocalStiffness},
    solver::{
        FeasibleSet, NewtonStep, PaneLaws,
        conditions::Bound,
        convex::{ConvexProgram, InteriorPoint},
    },
};

/// ‖R‖ / ‖λ‖ at which a search has found the zones; what follows refines the answer.
const FOUND: f64 = 1e-8;

/// Most steps of Newton's method from one start.
const MOST_STEPS: usize = 40;

/// Steps in ρ from 1/S_ii to the local stiffness, and how far each is solved.
const PATH_STEPS: i32 = 8;
const ON_PATH: f64 = 1e-3;

/// How far an interior point leaves the active set undecided, as a share of the largest stress, before Newton's method is tried
/// from there: further on, small stresses are told from none.
const UNDECIDED: [f64; 4] = [1e-3, 1e-5, 1e-7, 1e-9];

/// Where the body moves this many times further as a whole than a pane against its neighbours, the
/// local starts come first: relaxation, which works pane by pane, cannot move the whole.
const MOBILE: f64 = 1e3;

/// One way to a solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::solver) enum Way {
    /// From a given multiplier, measured by local stiffness.
    Warm,
    /// Relaxed steps from a given multiplier or zero, measured by 1/S_ii.
    Relaxed,
    /// From the face glued to its foundation, S⁻¹h, measured by local stiffness.
    Glued,
    /// From the face that slides freely and does not lift off, measured by local stiffness.
    Pressed,
    /// From points inside the admissible set that come closer and closer to the solution of a convex problem
    /// ([`InteriorPoint`]), measured by local stiffness: the way that always ends.
    Convex,
    /// From zero along maps between 1/S_ii and local stiffness, each from the solution before.
    Path,
    /// From an easier law ([`continuation`]).
    Eased,
    /// From the face that floats above its foundation, where no load presses the body ([`Balance::lifted`]), measured by local stiffness.
    Lifted,
    /// From softer and softer springs in place of the contact that holds a body ([`softened`]).
    Softened,
}

/// A contact problem and its local stiffness.
pub(in crate::solver) struct Search<'a> {
    pub(in crate::solver) dual: &'a ExplicitDual,
    pub(in crate::solver) bound: Bound<'a>,
    pub(in crate::solver) local: &'a LocalStiffness,
    pub(in crate::solver) start: Option<&'a [f64]>,
}

impl<'a> Search<'a> {
    /// The ways for this problem in the order in which they should be tried.
    pub(in crate::solver) fn ways(&self) -> Vec<Way> {
        let warm = self.start.map(|_| Way::Warm);
        let mobile = self.is_mobile();
        let ways = if mobile {
            [
                Way::Glued,
                Way::Pressed,
                Way::Convex,
                Way::Path,
                Way::Eased,
                Way::Relaxed,
            ]
        } else {
            [
                Way::Relaxed,
                Way::Glued,
                Way::Pressed,
                Way::Convex,
                Way::Path,
                Way::Eased,
            ]
        };
        let is_open = |way: &Way| match (way, self.bound) {
            (Way::Eased, Bound::Frozen(_)) | (Way::Convex, Bound::Coulomb(..)) => false,
            _ => true,
        };
        let warm = warm.filter(|_| mobile).into_iter();
        let softened = self.dual.balance.as_ref().map(|_| Way::Softened);
        let lifted = self.lifted().map(|_| Way::Lifted).into_iter();
        let ways = lifted.chain(warm).chain(ways).chain(softened);
        ways.filter(is_open).collect()
    }

    /// No contact force, and the motions of a body that nothing presses.
    fn lifted(&self) -> Option<Vec<f64>> {
        let motion = self.dual.balance.as_ref()?.lifted(&self.dual.rhs)?;
        let n = self.dual.dimension();
        Some(std::iter::repeat_n(0.0, n).chain(motion).collect())
    }

    /// Whether the body moves as a whole much further than its panes do, in S or beside it.
    fn is_mobile(&self) -> bool {
        let balance = self.dual.balance.as_ref();
        self.local.mobility() > MOBILE || balance.is_some_and(|it| it.coupling.n_resisted() > 0)
    }

    /// Goes one way; `observe` sees the steps, numbered from `done` on.
    pub(in crate::solver) fn go(
        &self,
        way: Way,
        done: usize,
        mut observe: impl FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        let mut observe = |k: usize, step: &NewtonStep| observe(done + k, step);
        match way {
            Way::Warm => self.from(self.zero_or_start(), &mut observe),
            Way::Glued => self.from(self.local.glued_start(self.dual), &mut observe),
            Way::Pressed => self.from(self.local.pressed_start(self.dual), &mut observe),
            Way::Lifted => {
                let start = self.lifted().unwrap_or_else(|| self.zero_or_start());
                self.from(start, &mut observe)
            }
            Way::Path => self.path(&mut observe),
            Way::Relaxed => self.relaxed(&mut observe),
            Way::Convex => match self.bound {
                Bound::Coulomb(..) => self.relaxed(&mut observe),
                Bound::Frozen(set) => self.convex(set, &to(FOUND), &mut observe),
            },
            Way::Eased => match self.bound {
                Bound::Coulomb(laws, law) => self.eased(laws, law, &mut observe),
                Bound::Frozen(_) => self.relaxed(&mut observe),
            },
            Way::Softened => softened(self, &mut observe),
        }
    }

    /// The first solution of all ways but springs.
    pub(super) fn first(&self) -> NewtonSolution {
        let ways = self.ways().into_iter().filter(|way| *way != Way::Softened);
        let mut found = self.relaxed(&mut |_, _| {});
        for way in ways.filter(|way| *way != Way::Relaxed) {
            if found.is_solution() {
                break;
            }
            found = self.go(way, 0, |_, _| {});
        }
        found
    }

    /// Minimises over a frozen set from the start, in one step at least, so that a start within the
    /// tolerance is measured and not believed.
    pub(in crate::solver) fn minimise(
        &self,
        set: &FeasibleSet<'_>,
        settings: &NewtonSettings,
    ) -> NewtonSolution {
        let start = self.zero_or_start();
        let mut found = if self.is_mobile() {
            let mut first = start.clone();
            set.project(&mut first);
            newton_from(&self.map(self.bound), first, settings, 1, |_, _| {})
        } else {
            minimise_frozen_in(self.dual, set, &start, settings, 1, |_, _| {})
        };
        for way in self.ways() {
            if found.is_solution() {
                break;
            }
            let near = self.go(way, 0, |_, _| {});
            let start = near.multiplier.clone();
            let next = newton_from(&self.map(self.bound), start, settings, 1, |_, _| {});
            found = found.followed_by(near).followed_by(next);
        }
        found
    }

    /// The natural map measured by local stiffness.
    fn map(&self, bound: Bound<'a>) -> NaturalMap<'a> {
        NaturalMap::with_steplengths(self.dual, bound, self.local.stiffness.clone())
    }

    fn zero_or_start(&self) -> Vec<f64> {
        self.dual.unknowns(self.start.unwrap_or_default())
    }

    pub(super) fn from(
        &self,
        start: Vec<f64>,
        observe: &mut dyn FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        newton_from(&self.map(self.bound), start, &to(FOUND), 0, observe)
    }

    pub(super) fn relaxed(&self, observe: &mut dyn FnMut(usize, &NewtonStep)) -> NewtonSolution {
        let settings = NewtonSettings {
            tolerance: FOUND,
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
    pub(in crate::solver) fn convex(
        &self,
        set: &FeasibleSet<'_>,
        settings: &NewtonSettings,
        observe: &mut dyn FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        let dual = self.dual.clone().without_anchor();
        let program = ConvexProgram::of_dual(&dual, set, self.local);
        let map = self.map(self.bound);
        let mut from = |start: Vec<f64>, done: usize| {
            newton_from(&map, start, settings, 0, |k, step| observe(done + k, step))
        };
        let Some(mut inside) = InteriorPoint::new(&program) else {
            return from(self.dual.unknowns(&[]), 0);
        };
        let mut found: Option<NewtonSolution> = None;
        for share in UNDECIDED {
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
        let mut found = found.expect("there is always a share");
        found.evaluations += inside.steps;
        found
    }

    fn path(&self, observe: &mut dyn FnMut(usize, &NewtonStep)) -> NewtonSolution {
        let first = NaturalMap::new(self.dual, self.bound)
            .conditions
            .steplengths;
        let mut found = NewtonSolution::none(self.dual);
        for step in 0..=PATH_STEPS {
            let share = f64::from(step) / f64::from(PATH_STEPS);
            let ends = first.iter().zip(&self.local.stiffness);
            // Powers of their ratio alone, which has no unit: the bits are those of any unit that differs by powers of two.
            let steplengths = ends
                .map(|(a, b)| match b {
                    0.0 => 0.0,
                    b => b * (a / b).powf(1.0 - share),
                })
                .collect();
            let map = NaturalMap::with_steplengths(self.dual, self.bound, steplengths);
            let tolerance = if step < PATH_STEPS { ON_PATH } else { FOUND };
            let done = found.history.len();
            let start = found.multiplier.clone();
            let next = newton_from(&map, start, &to(tolerance), 0, |k, step| {
                observe(done + k, step);
            });
            found = found.followed_by(next);
        }
        found
    }

    fn eased(
        &self,
        laws: &'a PaneLaws,
        law: &CoulombLaw,
        observe: &mut dyn FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        let mobile = self.is_mobile();
        continuation(law, observe, |law, start| {
            if !mobile {
                return newton(self.dual, laws, law, start, &to(FOUND), |_, _| {});
            }
            let start = match start {
                Some(start) => start.to_vec(),
                None => self.local.pressed_start(self.dual),
            };
            let steplengths = self.local.stiffness.clone();
            let bound = Bound::Coulomb(laws, law);
            let map = NaturalMap::with_steplengths(self.dual, bound, steplengths);
            newton_from(&map, start, &to(FOUND), 0, |_, _| {})
        })
    }
}

fn to(tolerance: f64) -> NewtonSettings {
    NewtonSettings {
        tolerance,
        max_steps: MOST_STEPS,
    }
}
