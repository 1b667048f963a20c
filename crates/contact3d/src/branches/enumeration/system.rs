//! The equations of one choice of states, over boxes of their unknowns.

use super::{
    closed::Closed,
    interval::{Interval, product},
    small_problem::{Affine, NodeSlip, SmallProblem},
    states::{Chart, State},
    straight_law::NodeLaw,
    varying::Varying,
};

/// What pressures may be.
const PUSHES: Interval = Interval::new(0.0, f64::INFINITY);

/// The equations of one choice of states.
///
/// A slipping pane has the unknowns s and, where it moves in a plane, t: its slip v = −r_t is s d(t), with d on a half circle. On closed
/// panes r is known then, and λ = S⁻¹(h + r) is linear in the slips; the equations are λ_t = λ_ν 𝓕²d/|𝓕d| on slipping panes.
pub(super) struct System<'p> {
    problem: &'p SmallProblem,
    states: Vec<State>,
    slipping: Vec<Slipping>,
    /// λ of all components, `[3m]`, by the slips.
    multiplier: Vec<Affine>,
    /// r_ν of all panes likewise.
    gap: Vec<Affine>,
    /// u_t at the contact nodes likewise.
    slips: Vec<[Affine; 2]>,
    /// Where all solutions lie.
    pub(super) whole: Vec<Interval>,
}

/// A slipping pane, and the places of its unknowns.
struct Slipping {
    pane: usize,
    chart: Chart,
    size: usize,
    angle: Option<usize>,
}

/// What a slipping pane does.
struct Slide {
    size: Varying,
    direction: [Varying; 2],
}

/// A box with the slips in it.
pub(super) struct Slides {
    of_panes: Vec<Slide>,
    /// v of the slipping panes.
    slips: Vec<Varying>,
}

impl<'p> System<'p> {
    /// The equations, and the box in which their solutions lie; `None` where S cannot be told to be positive definite.
    pub(super) fn new(problem: &'p SmallProblem, states: Vec<State>) -> Option<Self> {
        let moves = |j: &usize| problem.moves[*j];
        let of = |wanted: fn(State) -> bool| {
            let panes = states.iter().enumerate();
            panes.filter(move |(_, state)| wanted(**state))
        };
        let components: Vec<usize> = of(|s| s != State::Open)
            .flat_map(|(pane, _)| 3 * pane..3 * pane + 3)
            .filter(moves)
            .collect();
        let sliding: Vec<usize> = of(State::slips)
            .flat_map(|(pane, _)| [3 * pane + 1, 3 * pane + 2])
            .collect();
        let closed = Closed::new(problem, &components, &sliding)?;
        let with = |row: Affine, constant: Interval| Affine {
            constant: row.constant + constant,
            ..row
        };
        let unit = |i: usize| {
            move |j: usize| match i == j {
                true => Interval::ONE,
                false => Interval::ZERO,
            }
        };
        let n = problem.rhs.len();
        let gap = (0..n).step_by(3).map(|i| {
            let row = closed.applied(|j| problem.operator[i][j]);
            with(row, -problem.rhs[i])
        });
        let slip = |row: &Affine| with(closed.applied(|j| row.slope[j]), row.constant);
        let mut system = Self {
            slipping: Vec::new(),
            multiplier: (0..n).map(|i| closed.applied(unit(i))).collect(),
            gap: gap.collect(),
            slips: problem
                .slips
                .iter()
                .map(|at| at.rows.each_ref().map(slip))
                .collect(),
            whole: Vec::new(),
            problem,
            states,
        };
        system.place(&closed);
        Some(system)
    }

    /// Numbers the unknowns and bounds them.
    fn place(&mut self, closed: &Closed<'_>) {
        for (pane, state) in self.states.iter().enumerate() {
            let State::Slip(chart) = *state else {
                continue;
            };
            let [first, second] = [1, 2].map(|c| self.problem.operator[3 * pane + c][3 * pane + c]);
            let size = self.whole.len();
            self.whole
                .push(Interval::new(0.0, closed.most(first + second)));
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

    /// The slips in a box.
    pub(super) fn slides(&self, at: &[Interval]) -> Slides {
        let of_panes = self.slipping.iter().map(|pane| {
            let t = pane.angle.map_or(Interval::ZERO, |place| at[place]);
            let direction = pane.chart.direction(t);
            Slide {
                size: Varying::along(at[pane.size], pane.size, Interval::ONE),
                direction: [0, 1].map(|k| match pane.angle {
                    Some(place) => Varying::along(direction.along[k], place, direction.turning[k]),
                    None => Varying::constant(direction.along[k]),
                }),
            }
        });
        let of_panes: Vec<Slide> = of_panes.collect();
        let slips = of_panes
            .iter()
            .flat_map(|s| s.direction.map(|d| s.size * d));
        Slides {
            slips: slips.collect(),
            of_panes,
        }
    }

    /// λ of all components, `[3m]`.
    pub(super) fn multipliers(&self, slides: &Slides) -> Vec<Interval> {
        let rows = self.multiplier.iter();
        rows.map(|row| row.value(&slides.slips)).collect()
    }

    /// λ_t − λ_ν 𝓕²d/|𝓕d| of the slipping panes.
    pub(super) fn equations(&self, slides: &Slides) -> Vec<Varying> {
        let mut equations = vec![Varying::constant(Interval::ZERO); self.whole.len()];
        for (pane, slide) in self.slipping.iter().zip(&slides.of_panes) {
            let row = |c: usize| self.multiplier[3 * pane.pane + c].over(&slides.slips);
            let pressure = row(0);
            let share = self.share(pane.pane, slide, slides);
            let left = |k: usize| row(k + 1) - pressure * share[k];
            match pane.chart {
                Chart::Axis { axis, .. } => equations[pane.size] = left(axis),
                Chart::Half { .. } => {
                    let places = [Some(pane.size), pane.angle];
                    let places = places.into_iter().flatten().enumerate();
                    places.for_each(|(k, place)| equations[place] = left(k));
                }
            }
        }
        equations
    }

    /// λ_t over λ_ν of a slipping pane, 𝓕²d/|𝓕d|.
    fn share(&self, pane: usize, slide: &Slide, slides: &Slides) -> [Varying; 2] {
        let friction = self.friction(pane, slides);
        let times = |a: [Varying; 2]| [0, 1].map(|k| friction[k] * a[k]);
        match self.problem.is_isotropic() {
            true => times(slide.direction),
            // |d| = 1, so |𝓕d| lies between the coefficients.
            false => {
                let between = friction[0].value.hull(friction[1].value);
                times(Varying::unit(times(slide.direction), between))
            }
        }
    }

    /// 𝓕 of a pane, the inverse of the mean of F⁻¹ over its nodes.
    fn friction(&self, pane: usize, slides: &Slides) -> [Varying; 2] {
        let nodes = &self.problem.nodes[pane];
        let at = |node: usize| [0, 1].map(|k| self.coefficient(node, k, slides));
        if let [(node, _)] = nodes[..] {
            return at(node);
        }
        let zero = Varying::constant(Interval::ZERO);
        let mut mean = [zero; 2];
        for (node, weight) in nodes {
            let here = at(*node).map(|f| f.recip().times(Interval::point(*weight)));
            mean = [0, 1].map(|k| mean[k] + here[k]);
        }
        mean.map(Varying::recip)
    }

    /// F_k at a contact node of a closed pane.
    fn coefficient(&self, node: usize, k: usize, slides: &Slides) -> Varying {
        let (law, is_isotropic) = match &self.problem.laws[node] {
            NodeLaw::Isotropic(law) => (law, true),
            NodeLaw::Orthotropic(pair) => (&pair[k], false),
        };
        let zero = Varying::constant(Interval::ZERO);
        let slip = match self.problem.slips.get(node) {
            None => zero,
            Some(NodeSlip { own: None, .. }) => {
                let [first, second] = self.slips[node].each_ref().map(|u| u.over(&slides.slips));
                match is_isotropic {
                    true => first.hypot(second),
                    false => [first, second][k].abs(),
                }
            }
            Some(NodeSlip {
                own: Some((pane, ratio)),
                ..
            }) => {
                let place = self.slipping.iter().position(|at| at.pane == *pane);
                let size = place.map_or(zero, |place| match is_isotropic {
                    true => slides.of_panes[place].size,
                    false => slides.slips[2 * place + k].abs(),
                });
                size.times(*ratio)
            }
        };
        let (value, slope) = law.over(slip.value.abs());
        slip.through(value, slope)
    }

    /// A smaller box around the same solutions: stresses that follow from the slips push, and slips that follow from those stresses have
    /// their directions; `None` where there are none.
    pub(super) fn contracted(&self, mut at: Vec<Interval>) -> Option<Vec<Interval>> {
        let slides = self.slides(&at);
        let mut stress = self.multipliers(&slides);
        let mut shares = Vec::with_capacity(self.slipping.len());
        for (pane, slide) in self.slipping.iter().zip(&slides.of_panes) {
            let share = self.share(pane.pane, slide, &slides).map(|s| s.value);
            shares.push(share);
            stress[3 * pane.pane] = stress[3 * pane.pane].meet(PUSHES)?;
        }
        for (pane, share) in self.slipping.iter().zip(&shares) {
            let places = [0, 1, 2].map(|c| 3 * pane.pane + c);
            let row = &self.problem.operator[places[0]];
            let [own, first, second] = places.map(|j| row[j]);
            let others = (0..stress.len()).filter(|j| j / 3 != pane.pane);
            let others: Interval = others.map(|j| row[j] * stress[j]).sum();
            let mut pressure = stress[places[0]];
            let factor = own + first * share[0] + second * share[1];
            if let Some(found) = (self.problem.rhs[places[0]] - others).over(factor) {
                pressure = pressure.meet(found)?;
            }
            stress[places[0]] = pressure;
            for (place, share) in places[1..].iter().zip(share) {
                stress[*place] = stress[*place].meet(pressure * *share)?;
            }
        }
        for pane in &self.slipping {
            let slip = [1, 2].map(|c| {
                let i = 3 * pane.pane + c;
                self.problem.rhs[i] - product(&self.problem.operator[i], &stress)
            });
            let size = (slip[0].square() + slip[1].square()).sqrt();
            at[pane.size] = at[pane.size].meet(size)?;
            if let Some(place) = pane.angle {
                at[place] = pane.chart.narrowed(at[place], slip)?;
            }
        }
        Some(at)
    }

    /// The whole box, cut where the size of a slip reaches a knot of its law.
    pub(super) fn parts(&self) -> Vec<Vec<Interval>> {
        let mut parts = vec![self.whole.clone()];
        for slip in &self.problem.slips {
            let (Some((pane, ratio)), true) = (slip.own, self.problem.is_isotropic()) else {
                continue;
            };
            let Some(pane) = self.slipping.iter().find(|at| at.pane == pane) else {
                continue;
            };
            for knot in self.problem.laws[pane.pane].knots() {
                let size = knot / ratio.middle();
                let is_cut = |part: &Vec<Interval>| {
                    part[pane.size].low < size && size < part[pane.size].high
                };
                let beyond: Vec<_> = parts
                    .iter_mut()
                    .filter(|part| is_cut(part))
                    .map(|part| {
                        let mut beyond = part.clone();
                        beyond[pane.size].low = size;
                        part[pane.size].high = size;
                        beyond
                    })
                    .collect();
                parts.extend(beyond);
            }
        }
        parts
    }

    /// What is not negative in a solution: pressures, sizes of slips and room on half circles at slipping panes, pressures and room to the
    /// ellipse at sticking ones, closing of open ones.
    pub(super) fn signs(&self, at: &[Interval], slides: &Slides) -> Vec<Interval> {
        let mut signs = Vec::new();
        for pane in &self.slipping {
            signs.push(at[pane.size]);
            if let Some(place) = pane.angle {
                let t = at[place];
                signs.extend([Interval::ONE - t, Interval::ONE + t]);
            }
        }
        for (pane, state) in self.states.iter().enumerate() {
            let stress = |c: usize| self.multiplier[3 * pane + c].value(&slides.slips);
            match state {
                State::Slip(_) => signs.push(stress(0)),
                State::Open => signs.push(self.gap[pane].value(&slides.slips)),
                State::Stick => {
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
