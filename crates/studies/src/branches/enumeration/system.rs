//! The equations of one choice of states, over boxes of their unknowns, and what closed panes carry.

use super::{
    interval::{Interval, IntervalFunction, product},
    search::solve,
    small_problem::{Affine, NodeLaw, SmallProblem},
    states::{Chart, PaneCase},
};

/// What pressures may be.
const PUSHES: Interval = Interval::new(0.0, f64::INFINITY);

/// What a slipping pane has as unknowns beside the place t on its half circle d, and what all else is linear in: its sources.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Unknowns {
    /// λ_ν, where 𝓕 is known: λ_t = λ_ν 𝓕d. The equations are r_ν = 0 and r_t ∥ 𝓕⁻¹d, and λ are the sources.
    Pressures,
    /// The size s of its slip v = −r_t = s d, from which 𝓕 follows. The equations are λ_t = λ_ν 𝓕²d/|𝓕d|, and (0, v) are the sources.
    Slips,
}

/// The equations of one choice of states.
pub(super) struct System<'p> {
    problem: &'p SmallProblem,
    unknowns: Unknowns,
    states: Vec<PaneCase>,
    slipping: Vec<Slipping>,
    /// λ of all components, `[3m]`, by the sources.
    multiplier: Vec<Affine>,
    /// r_ν of all panes likewise.
    gap: Vec<Affine>,
    /// u_t at the contact nodes likewise.
    slips: Vec<[Affine; 2]>,
    /// r by λ of slipping panes, `[3m]`.
    gradient: Vec<Affine>,
    /// Where all solutions lie.
    pub(super) whole: Vec<Interval>,
}

/// A slipping pane, and the places of its unknowns.
struct Slipping {
    pane: usize,
    chart: Chart,
    /// Of its pressure or size of slip.
    size: usize,
    angle: Option<usize>,
}

/// What a slipping pane does.
struct Slide {
    size: IntervalFunction,
    direction: [IntervalFunction; 2],
}

/// A box with the sources in it.
pub(super) struct Slides {
    of_panes: Vec<Slide>,
    /// Three for each slipping pane.
    sources: Vec<IntervalFunction>,
}

impl<'p> System<'p> {
    /// The equations, and the box in which their solutions lie; `None` where S cannot be told to be positive definite.
    pub(super) fn new(problem: &'p SmallProblem, states: Vec<PaneCase>) -> Option<Self> {
        let components = |wanted: fn(PaneCase) -> bool| {
            let panes = states.iter().enumerate();
            let panes = panes.filter(move |(_, state)| wanted(**state));
            panes.flat_map(|(pane, _)| 3 * pane..3 * pane + 3)
        };
        let moves = |j: &usize| problem.moves[*j];
        let stuck: Vec<usize> = components(|s| s == PaneCase::Stick).filter(moves).collect();
        let closed: Vec<usize> = components(|s| s != PaneCase::Open).filter(moves).collect();
        let sliding: Vec<usize> = components(PaneCase::slips).collect();
        let s = |i: usize, j: usize| problem.operator[i][j];
        // λ = S⁻¹(h − v) on all closed components, by the slips v of some.
        let by_slips = Carried::new(problem, &closed, &sliding, &[], |i, j| unit(i)(j))?;
        // λ = S⁻¹(h − S λ) on sticking components, by λ of sliding ones.
        let by_stresses = Carried::new(problem, &stuck, &sliding, &sliding, s)?;
        let (unknowns, carried) = if problem.slips.is_empty() {
            (Unknowns::Pressures, &by_stresses)
        } else {
            (Unknowns::Slips, &by_slips)
        };
        let with = |row: Affine, constant: Interval| Affine {
            constant: row.constant + constant,
            ..row
        };
        let gradient = |i: usize, carried: &Carried<'_>| {
            let row = carried.applied(|j| problem.operator[i][j]);
            with(row, -problem.rhs[i])
        };
        let slip = |row: &Affine| with(carried.applied(|j| row.slope[j]), row.constant);
        let n = problem.rhs.len();
        let slips = problem.slips.iter();
        let mut system = Self {
            slipping: Vec::new(),
            multiplier: (0..n).map(|i| carried.applied(unit(i))).collect(),
            gap: (0..n).step_by(3).map(|i| gradient(i, carried)).collect(),
            slips: slips.map(|pair| pair.each_ref().map(slip)).collect(),
            gradient: (0..n).map(|i| gradient(i, &by_stresses)).collect(),
            whole: Vec::new(),
            problem,
            unknowns,
            states,
        };
        system.place(&by_slips);
        Some(system)
    }

    /// Numbers the unknowns and bounds them: λᵀr ≤ 0, so λᵀSλ and rᵀS⁻¹r are no larger than hᵀS⁻¹h, λ_j² than (S⁻¹)_jj hᵀS⁻¹h, and r_j²
    /// than S_jj hᵀS⁻¹h.
    fn place(&mut self, by_slips: &Carried<'_>) {
        let energy = by_slips.applied(|j| self.problem.rhs[j]).constant;
        for (pane, state) in self.states.iter().enumerate() {
            let PaneCase::Slip(chart) = *state else {
                continue;
            };
            let own = |i: usize| self.problem.operator[i][i];
            let factor = match self.unknowns {
                Unknowns::Pressures => {
                    -by_slips.applied(unit(3 * pane)).slope[3 * self.slipping.len()]
                }
                Unknowns::Slips => own(3 * pane + 1) + own(3 * pane + 2),
            };
            let size = self.whole.len();
            let most = (factor * energy).sqrt().high;
            self.whole.push(Interval::new(0.0, most));
            let angle = chart.has_angle().then_some(self.whole.len());
            self.whole.extend(angle.map(|_| Interval::new(-1.0, 1.0)));
            self.slipping.push(Slipping {
                pane,
                chart,
                size,
                angle,
            });
        }
    }

    /// The sources in a box.
    pub(super) fn slides(&self, at: &[Interval]) -> Slides {
        let of_panes = self.slipping.iter().map(|pane| {
            let t = pane.angle.map_or(Interval::ZERO, |place| at[place]);
            let [along, turning] = pane.chart.direction(t);
            Slide {
                size: IntervalFunction::along(at[pane.size], pane.size, Interval::ONE),
                direction: [0, 1].map(|k| match pane.angle {
                    Some(place) => IntervalFunction::along(along[k], place, turning[k]),
                    None => IntervalFunction::constant(along[k]),
                }),
            }
        });
        let mut slides = Slides {
            of_panes: of_panes.collect(),
            sources: Vec::new(),
        };
        let sources = self.slipping.iter().zip(&slides.of_panes);
        let sources = sources.flat_map(|(pane, slide)| {
            let (normal, [first, second]) = match self.unknowns {
                Unknowns::Pressures => (slide.size, self.share(pane.pane, slide, &slides)),
                Unknowns::Slips => (IntervalFunction::constant(Interval::ZERO), slide.direction),
            };
            [normal, slide.size * first, slide.size * second]
        });
        slides.sources = sources.collect();
        slides
    }

    /// λ of all components, `[3m]`.
    pub(super) fn multipliers(&self, slides: &Slides) -> Vec<Interval> {
        let rows = self.multiplier.iter();
        rows.map(|row| row.value(&slides.sources)).collect()
    }

    /// The left-hand sides.
    pub(super) fn equations(&self, slides: &Slides) -> Vec<IntervalFunction> {
        let mut equations = vec![IntervalFunction::constant(Interval::ZERO); self.whole.len()];
        for (pane, slide) in self.slipping.iter().zip(&slides.of_panes) {
            let over = |rows: &[Affine], c: usize| rows[3 * pane.pane + c].over(&slides.sources);
            let left = match self.unknowns {
                Unknowns::Pressures => {
                    let [f1, f2] = self.friction(pane.pane, slides);
                    let [d1, d2] = slide.direction;
                    let [normal, first, second] = [0, 1, 2].map(|c| over(&self.gradient, c));
                    [normal, f2 * d1 * second - f1 * d2 * first]
                }
                Unknowns::Slips => {
                    let share = self.share(pane.pane, slide, slides);
                    let [normal, first, second] = [0, 1, 2].map(|c| over(&self.multiplier, c));
                    [first - normal * share[0], second - normal * share[1]]
                }
            };
            equations[pane.size] = match (self.unknowns, pane.chart) {
                (Unknowns::Slips, Chart::Axis { axis, .. }) => left[axis],
                _ => left[0],
            };
            if let Some(place) = pane.angle {
                equations[place] = left[1];
            }
        }
        equations
    }

    /// λ_t over λ_ν of a slipping pane.
    fn share(&self, pane: usize, slide: &Slide, slides: &Slides) -> [IntervalFunction; 2] {
        let friction = self.friction(pane, slides);
        let times = |a: [IntervalFunction; 2]| [0, 1].map(|k| friction[k] * a[k]);
        if self.unknowns == Unknowns::Pressures || self.problem.is_isotropic() {
            return times(slide.direction);
        }
        // |d| = 1, so |𝓕d| lies between the coefficients.
        let between = friction[0].value.hull(friction[1].value);
        times(IntervalFunction::unit(times(slide.direction), between))
    }

    /// 𝓕 of a pane, the inverse of the mean of F⁻¹ over its nodes.
    fn friction(&self, pane: usize, slides: &Slides) -> [IntervalFunction; 2] {
        let nodes = &self.problem.nodes[pane];
        let at = |node: usize| [0, 1].map(|k| self.coefficient(node, k, slides));
        if let [(node, _)] = nodes[..] {
            return at(node);
        }
        let term = |(node, weight): &(usize, f64), k: usize| {
            at(*node)[k].recip().times(Interval::point(*weight))
        };
        [0, 1].map(|k| {
            let mean: IntervalFunction = nodes.iter().map(|node| term(node, k)).sum();
            mean.recip()
        })
    }

    /// F_k at a contact node of a closed pane.
    fn coefficient(&self, node: usize, k: usize, slides: &Slides) -> IntervalFunction {
        let (law, is_isotropic) = match &self.problem.laws[node] {
            NodeLaw::Isotropic(law) => (law, true),
            NodeLaw::Orthotropic(pair) => (&pair[k], false),
        };
        let slip = self.slips.get(node).map(|pair| {
            let [first, second] = pair.each_ref().map(|u| u.over(&slides.sources));
            if is_isotropic {
                first.hypot(second)
            } else {
                [first, second][k].abs()
            }
        });
        let slip = slip.unwrap_or(IntervalFunction::constant(Interval::ZERO));
        let (value, slope) = law.over(slip.value.abs());
        slip.through(value, slope)
    }

    /// A smaller box around the same solutions: stresses that follow from the sources push, and slips that follow from those stresses have
    /// their directions; `None` where there are none.
    pub(super) fn contracted(&self, mut at: Vec<Interval>) -> Option<Vec<Interval>> {
        let slides = self.slides(&at);
        let stress = self.stress(&slides)?;
        for (i, (pane, slide)) in self.slipping.iter().zip(&slides.of_panes).enumerate() {
            let slip = [1, 2].map(|c| -self.gradient[3 * pane.pane + c].at(&stress));
            let (size, along) = match self.unknowns {
                Unknowns::Pressures => {
                    let friction = self.friction(pane.pane, &slides);
                    (stress[3 * i], [0, 1].map(|k| friction[k].value * slip[k]))
                }
                Unknowns::Slips => ((slip[0].square() + slip[1].square()).sqrt(), slip),
            };
            at[pane.size] = slide.size.value.meet(size)?;
            if let Some(place) = pane.angle {
                at[place] = pane.chart.narrowed(at[place], along)?;
            }
        }
        Some(at)
    }

    /// λ of the slipping panes, with pressures from r_ν = 0, one pane after the other; `None` where there is none.
    fn stress(&self, slides: &Slides) -> Option<Vec<Interval>> {
        let panes = || self.slipping.iter().zip(&slides.of_panes);
        let rows = panes().flat_map(|(pane, _)| &self.multiplier[3 * pane.pane..3 * pane.pane + 3]);
        let mut stress: Vec<_> = rows.map(|row| row.value(&slides.sources)).collect();
        let shares = panes().map(|(pane, slide)| self.share(pane.pane, slide, slides));
        let shares: Vec<_> = shares.map(|share| share.map(|s| s.value)).collect();
        for i in 0..shares.len() {
            stress[3 * i] = stress[3 * i].meet(PUSHES)?;
        }
        for (i, pane) in self.slipping.iter().enumerate() {
            let row = &self.gradient[3 * pane.pane];
            let (mut known, mut own) = (row.constant, Interval::ZERO);
            for (k, share) in shares.iter().enumerate() {
                let by = &row.slope[3 * k..3 * k + 3];
                let factor = by[0] + by[1] * share[0] + by[2] * share[1];
                if k == i {
                    own = factor;
                } else {
                    let stress = &stress[3 * k..3 * k + 3];
                    known = known + product(by, stress).meet(factor * stress[0])?;
                }
            }
            if let Some(found) = (-known).over(own) {
                stress[3 * i] = stress[3 * i].meet(found)?;
            }
            for k in [0, 1] {
                let place = 3 * i + 1 + k;
                stress[place] = stress[place].meet(stress[3 * i] * shares[i][k])?;
            }
        }
        Some(stress)
    }

    /// What is not negative in a solution: pressures, slips against the stress and room on half circles at slipping panes, pressures and
    /// room to the ellipse at sticking ones, closing of open ones.
    pub(super) fn signs(&self, at: &[Interval], slides: &Slides) -> Vec<Interval> {
        let mut signs = Vec::new();
        let value = |row: &Affine| row.value(&slides.sources);
        for (pane, slide) in self.slipping.iter().zip(&slides.of_panes) {
            signs.push(at[pane.size]);
            signs.push(match self.unknowns {
                Unknowns::Pressures => {
                    let [f1, f2] = self.friction(pane.pane, slides).map(|f| f.value);
                    let [d1, d2] = slide.direction.map(|d| d.value);
                    let [first, second] = [1, 2].map(|c| value(&self.gradient[3 * pane.pane + c]));
                    -(d1 * f2 * first + d2 * f1 * second)
                }
                Unknowns::Slips => value(&self.multiplier[3 * pane.pane]),
            });
            if let Some(place) = pane.angle {
                let t = at[place];
                signs.extend([Interval::ONE - t, Interval::ONE + t]);
            }
        }
        for (pane, state) in self.states.iter().enumerate() {
            let stress = |c: usize| value(&self.multiplier[3 * pane + c]);
            match state {
                PaneCase::Slip(_) => {}
                PaneCase::Open => signs.push(value(&self.gap[pane])),
                PaneCase::Stick => {
                    let friction = self.friction(pane, slides);
                    let share = |k: usize| (stress(k + 1) * friction[k].value.recip()).square();
                    signs.push(stress(0));
                    signs.push(stress(0).square() - share(0) - share(1));
                }
            }
        }
        signs
    }
}

/// λ of some components from r there and sources: r of slipping panes, or their λ.
struct Carried<'a> {
    components: &'a [usize],
    /// The components whose λ are the sources, if they are.
    given: &'a [usize],
    /// S⁻¹h on the components, then S⁻¹ times the column of each source.
    solved: Vec<Vec<Interval>>,
}

impl<'a> Carried<'a> {
    /// From the matrix of the components and the columns of the sources; `None` where S cannot be told to be positive definite.
    fn new(
        problem: &SmallProblem,
        components: &'a [usize],
        sources: &[usize],
        given: &'a [usize],
        entry: impl Fn(usize, usize) -> Interval,
    ) -> Option<Self> {
        let of = |entry: &dyn Fn(usize) -> Interval| components.iter().map(|i| entry(*i)).collect();
        let matrix = components.iter().map(|i| of(&|j| problem.operator[*i][j]));
        let columns = sources.iter().map(|j| of(&|i| entry(i, *j)));
        let columns = std::iter::once(of(&|i| problem.rhs[i])).chain(columns);
        Some(Self {
            components,
            given,
            solved: solve(matrix.collect(), columns.collect())?,
        })
    }

    /// Σ a_j λ_j by the sources.
    fn applied(&self, row: impl Fn(usize) -> Interval) -> Affine {
        let here: Vec<Interval> = self.components.iter().map(|j| row(*j)).collect();
        let columns = self.solved[1..].iter().enumerate();
        let slope = columns.map(|(k, column)| {
            let own = self.given.get(k).map_or(Interval::ZERO, |j| row(*j));
            own - product(&here, column)
        });
        Affine {
            constant: product(&here, &self.solved[0]),
            slope: slope.collect(),
        }
    }
}

/// The row that takes component i.
fn unit(i: usize) -> impl Fn(usize) -> Interval {
    move |j| {
        if i == j {
            Interval::ONE
        } else {
            Interval::ZERO
        }
    }
}
