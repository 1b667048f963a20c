//! The equations of one choice of states, over boxes of their unknowns.

use super::{
    eliminated::{Eliminated, largest_multipliers},
    interval::{Interval, product},
    small_problem::{Affine, SmallProblem},
    states::{Chart, State},
};

/// The equations of one choice of states.
///
/// Sticking and open panes are eliminated. A slipping pane has the unknowns λ_ν, the place t on its half circle and, where the law
/// follows the slip, 𝓕, with λ_t = λ_ν 𝓕 e(t); and the equations r_ν = 0, r_t ∥ 𝓕⁻¹e(t), 𝓕 = that of the slips. With e and 𝓕
/// given they are linear.
pub(super) struct System<'p> {
    pub(super) problem: &'p SmallProblem,
    states: Vec<State>,
    pub(super) slipping: Vec<Slipping>,
    /// λ of all components, `[3m]`, by the λ of slipping panes.
    multiplier: Vec<Affine>,
    /// r likewise.
    gradient: Vec<Affine>,
    /// u_t at the contact nodes likewise.
    slips: Vec<[Affine; 2]>,
    /// Where all solutions lie.
    pub(super) whole: Vec<Interval>,
}

/// A slipping pane, and the places of its unknowns.
pub(super) struct Slipping {
    pub(super) pane: usize,
    pub(super) chart: Chart,
    pub(super) pressure: usize,
    pub(super) angle: Option<usize>,
    friction: [Friction; 2],
}

/// 𝓕_k of a slipping pane.
#[derive(Clone, Copy)]
enum Friction {
    Known(Interval),
    Unknown(usize),
}

/// What a slipping pane does.
pub(super) struct Sliding {
    pub(super) pressure: Interval,
    pub(super) friction: [Interval; 2],
    along: [Interval; 2],
    turning: [Interval; 2],
}

/// How λ of one slipping pane moves with an unknown, and the direction across its slip.
#[derive(Clone)]
struct Motion {
    pane: usize,
    stress: [Interval; 3],
    across: [Interval; 2],
}

impl<'p> System<'p> {
    /// The equations, and the box in which their solutions lie; `None` where S cannot be told to be positive definite.
    pub(super) fn new(problem: &'p SmallProblem, states: Vec<State>) -> Option<Self> {
        let components = |wanted: fn(State) -> bool| {
            let panes = states.iter().enumerate();
            let panes = panes.filter(move |(_, state)| wanted(**state));
            panes.flat_map(|(pane, _)| 3 * pane..3 * pane + 3)
        };
        let moves = |j: &usize| problem.moves[*j];
        let stuck: Vec<usize> = components(|s| s == State::Stick).filter(moves).collect();
        let closed: Vec<usize> = components(|s| s != State::Open).filter(moves).collect();
        let sliding: Vec<usize> = components(State::slips).collect();
        let eliminated = Eliminated::new(problem, &stuck, &sliding)?;
        let with = |row: Affine, constant: Interval| Affine {
            constant: row.constant + constant,
            ..row
        };
        let gradient = problem.operator.iter().zip(&problem.rhs);
        let slip = |slip: &Affine| with(eliminated.applied(|j| slip.slope[j]), slip.constant);
        let slips = problem.slips.iter();
        let mut system = Self {
            problem,
            slipping: Vec::new(),
            multiplier: (0..problem.rhs.len())
                .map(|j| eliminated.multiplier(j))
                .collect(),
            gradient: gradient
                .map(|(row, h)| with(eliminated.applied(|j| row[j]), -*h))
                .collect(),
            slips: slips.map(|pair| pair.each_ref().map(slip)).collect(),
            whole: Vec::new(),
            states,
        };
        system.place(&largest_multipliers(problem, &closed)?);
        Some(system)
    }

    /// Numbers the unknowns and bounds them.
    fn place(&mut self, largest: &[f64]) {
        let anything: Vec<Interval> = largest.iter().map(|l| Interval::new(-l, *l)).collect();
        let problem = self.problem;
        let slip = |node: usize| match problem.slips.get(node) {
            Some(pair) => pair.each_ref().map(|slip| slip.at(&anything)),
            None => [Interval::ZERO; 2],
        };
        for (pane, state) in self.states.iter().enumerate() {
            let State::Slip(chart) = *state else {
                continue;
            };
            let pressure = self.whole.len();
            self.whole.push(Interval::new(0.0, largest[3 * pane]));
            let angle = chart.has_angle().then_some(self.whole.len());
            self.whole.extend(angle.map(|_| Interval::new(-1.0, 1.0)));
            let [first, second] = problem.friction(pane, slip).value;
            let place = self.whole.len();
            let friction = if !problem.follows_slip() {
                [first, second].map(Friction::Known)
            } else if problem.is_isotropic() {
                self.whole.push(first);
                [Friction::Unknown(place); 2]
            } else {
                self.whole.extend([first, second]);
                [0, 1].map(|k| Friction::Unknown(place + k))
            };
            self.slipping.push(Slipping {
                pane,
                chart,
                pressure,
                angle,
                friction,
            });
        }
    }

    pub(super) fn sliding(&self, at: &[Interval]) -> Vec<Sliding> {
        let panes = self.slipping.iter().map(|pane| {
            let t = pane.angle.map_or(Interval::ZERO, |place| at[place]);
            let direction = pane.chart.direction(t);
            Sliding {
                pressure: at[pane.pressure],
                friction: pane.friction_in(at),
                along: direction.along,
                turning: direction.turning,
            }
        });
        panes.collect()
    }

    /// λ of the slipping panes.
    pub(super) fn carried(sliding: &[Sliding]) -> Vec<Interval> {
        let panes = sliding.iter().flat_map(|pane| {
            let [first, second] = pane.shares();
            [pane.pressure, pane.pressure * first, pane.pressure * second]
        });
        panes.collect()
    }

    pub(super) fn slips_at(&self, carried: &[Interval]) -> impl Fn(usize) -> [Interval; 2] {
        move |node| match self.slips.get(node) {
            Some(pair) => pair.each_ref().map(|slip| slip.at(carried)),
            None => [Interval::ZERO; 2],
        }
    }

    pub(super) fn gradient_of(&self, pane: usize) -> [&Affine; 3] {
        [0, 1, 2].map(|c| &self.gradient[3 * pane + c])
    }

    /// λ of all components, `[3m]`.
    pub(super) fn multipliers(&self, at: &[Interval]) -> Vec<Interval> {
        let carried = Self::carried(&self.sliding(at));
        self.multiplier.iter().map(|row| row.at(&carried)).collect()
    }

    /// The left-hand sides.
    pub(super) fn residual(&self, at: &[Interval]) -> Vec<Interval> {
        let sliding = self.sliding(at);
        let carried = Self::carried(&sliding);
        let slips = self.slips_at(&carried);
        let mut residual = vec![Interval::ZERO; at.len()];
        for (pane, here) in self.slipping.iter().zip(&sliding) {
            let [normal, first, second] = self.gradient_of(pane.pane).map(|row| row.at(&carried));
            residual[pane.pressure] = normal;
            if let Some(place) = pane.angle {
                let [across, along] = here.across();
                residual[place] = across * first + along * second;
            }
            if self.problem.follows_slip() {
                let found = self.problem.friction(pane.pane, &slips).value;
                for (k, place) in pane.unknown_friction() {
                    residual[place] = at[place] - found[k];
                }
            }
        }
        residual
    }

    /// Their derivatives, row by row.
    pub(super) fn derivative(&self, at: &[Interval]) -> Vec<Vec<Interval>> {
        let sliding = self.sliding(at);
        let carried = Self::carried(&sliding);
        let slips = self.slips_at(&carried);
        let mut matrix = vec![vec![Interval::ZERO; at.len()]; at.len()];
        let motions = self.motions(&sliding, at.len());
        for (i, (pane, here)) in self.slipping.iter().zip(&sliding).enumerate() {
            let rows = self.gradient_of(pane.pane);
            let [first, second] = [rows[1].at(&carried), rows[2].at(&carried)];
            let [across, along] = here.across();
            let follows = self.problem.follows_slip();
            let friction = follows.then(|| self.problem.friction(pane.pane, &slips));
            for (place, motion) in motions.iter().enumerate() {
                let moved = |row: &Affine| product(&row.slope[3 * motion.pane..], &motion.stress);
                matrix[pane.pressure][place] = moved(rows[0]);
                if let Some(row) = pane.angle {
                    let mut entry = across * moved(rows[1]) + along * moved(rows[2]);
                    if motion.pane == i {
                        entry = entry + motion.across[0] * first + motion.across[1] * second;
                    }
                    matrix[row][place] = entry;
                }
                for (k, row) in pane.unknown_friction() {
                    let slopes = friction.iter().flat_map(|found| &found.slope);
                    let change = slopes.map(|(node, slope)| {
                        let [first, second] = self.slips[*node].each_ref().map(moved);
                        slope[k][0] * first + slope[k][1] * second
                    });
                    let own = if row == place {
                        Interval::ONE
                    } else {
                        Interval::ZERO
                    };
                    matrix[row][place] = own - change.sum();
                }
            }
        }
        matrix
    }

    fn motions(&self, sliding: &[Sliding], unknowns: usize) -> Vec<Motion> {
        let still = Motion {
            pane: 0,
            stress: [Interval::ZERO; 3],
            across: [Interval::ZERO; 2],
        };
        let mut motions = vec![still; unknowns];
        for (i, (pane, here)) in self.slipping.iter().zip(sliding).enumerate() {
            let [f1, f2] = here.friction;
            let [e1, e2] = here.along;
            let pressure = &mut motions[pane.pressure];
            (pressure.pane, pressure.stress) = (i, [Interval::ONE, f1 * e1, f2 * e2]);
            if let Some(place) = pane.angle {
                let [t1, t2] = here.turning;
                let p = here.pressure;
                motions[place] = Motion {
                    pane: i,
                    stress: [Interval::ZERO, p * (f1 * t1), p * (f2 * t2)],
                    across: [-(f1 * t2), f2 * t1],
                };
            }
            for (k, friction) in pane.friction.iter().enumerate() {
                if let Friction::Unknown(place) = *friction {
                    let motion = &mut motions[place];
                    motion.pane = i;
                    motion.stress[k + 1] = here.pressure * here.along[k];
                    motion.across[k] = if k == 0 { -e2 } else { e1 };
                }
            }
        }
        motions
    }

    /// What is not negative in a solution: pressures, slips against the stress and room on half circles at slipping panes, pressures and room to the ellipse at sticking ones, closing of open ones.
    pub(super) fn signs(&self, at: &[Interval]) -> Vec<Interval> {
        let sliding = self.sliding(at);
        let carried = Self::carried(&sliding);
        let slips = self.slips_at(&carried);
        let mut signs = Vec::new();
        for (pane, here) in self.slipping.iter().zip(&sliding) {
            let [_, first, second] = self.gradient_of(pane.pane).map(|row| row.at(&carried));
            let [f1, f2] = here.friction;
            let [e1, e2] = here.along;
            signs.push(here.pressure);
            signs.push(-(e1 * f2 * first + e2 * f1 * second));
            if let Some(place) = pane.angle {
                let t = at[place];
                signs.extend([Interval::ONE - t, Interval::ONE + t]);
            }
        }
        for (pane, state) in self.states.iter().enumerate() {
            match state {
                State::Slip(_) => {}
                State::Open => signs.push(self.gradient[3 * pane].at(&carried)),
                State::Stick => {
                    let stress = [0, 1, 2].map(|c| self.multiplier[3 * pane + c].at(&carried));
                    let friction = self.problem.friction(pane, &slips).value;
                    let share = |k: usize| (stress[k + 1] * friction[k].recip()).square();
                    signs.push(stress[0]);
                    signs.push(stress[0].square() - share(0) - share(1));
                }
            }
        }
        signs
    }
}

impl Sliding {
    /// λ_t over λ_ν, 𝓕 e.
    pub(super) fn shares(&self) -> [Interval; 2] {
        [0, 1].map(|k| self.friction[k] * self.along[k])
    }

    /// The normal of 𝓕⁻¹e, times f₁ f₂.
    fn across(&self) -> [Interval; 2] {
        let [f1, f2] = self.friction;
        [-(self.along[1] * f1), self.along[0] * f2]
    }
}

impl Slipping {
    pub(super) fn friction_in(&self, at: &[Interval]) -> [Interval; 2] {
        self.friction.map(|friction| match friction {
            Friction::Known(value) => value,
            Friction::Unknown(place) => at[place],
        })
    }

    /// The axes whose 𝓕_k is an unknown, one for both where they share it, and its place.
    pub(super) fn unknown_friction(&self) -> impl Iterator<Item = (usize, usize)> {
        let places = self.friction.map(|friction| match friction {
            Friction::Known(_) => None,
            Friction::Unknown(place) => Some(place),
        });
        let second = places[1].filter(|place| Some(*place) != places[0]);
        let places = [places[0], second].into_iter().enumerate();
        places.filter_map(|(k, place)| Some((k, place?)))
    }
}
