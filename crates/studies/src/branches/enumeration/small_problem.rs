//! A problem of few nodes in intervals, with laws that are linear by pieces.

use super::{
    super::family::power_of_two,
    interval::{Interval, IntervalFunction, product},
};

/// What S, h and the slips may be wrong by, as a share of √(S_ii S_jj) and of the largest h: rounding of assembly and factor. All
/// problems so near have the same number of solutions.
pub(super) const UNCERTAIN: f64 = 1.0 / (1_u64 << 40) as f64;

/// A contact problem of m panes, each with the components ν, t1, t2: r = S λ − h.
///
/// Rows and columns of a pane are scaled by one power of two, so that ellipses stay what they are, and λ and r by another.
pub(super) struct SmallProblem {
    /// `[3m][3m]`.
    pub(super) operator: Vec<Vec<Interval>>,
    /// `[3m]`.
    pub(super) rhs: Vec<Interval>,
    /// Whether a component moves at all, `[3m]`.
    pub(super) moves: Vec<bool>,
    /// λ over its number here in Pa, `[m]`.
    pub(super) stress: Vec<f64>,
    /// (contact node, weight) of each pane.
    pub(super) nodes: Vec<Vec<(usize, f64)>>,
    /// `[n_contact_nodes]`.
    pub(super) laws: Vec<NodeLaw>,
    /// u_t at the contact nodes: a constant less a row times λ; empty for a law that does not follow it.
    pub(super) slips: Vec<[Affine; 2]>,
}

/// A constant and a linear function of some unknowns.
#[derive(Debug, Clone)]
pub(super) struct Affine {
    pub(super) constant: Interval,
    pub(super) slope: Vec<Interval>,
}

impl Affine {
    pub(super) fn at(&self, of: &[Interval]) -> Interval {
        self.constant + product(&self.slope, of)
    }

    pub(super) fn value(&self, of: &[IntervalFunction]) -> Interval {
        let terms = self.slope.iter().zip(of);
        self.constant + terms.map(|(slope, x)| *slope * x.value).sum()
    }

    pub(super) fn over(&self, of: &[IntervalFunction]) -> IntervalFunction {
        let terms = self.slope.iter().zip(of);
        let terms = terms.map(|(slope, x)| x.times(*slope));
        IntervalFunction::constant(self.constant) + terms.sum()
    }
}

impl SmallProblem {
    /// The problem with what rounding may have changed, from S, h and, for a law that follows it, u_t at each node along both axes: without
    /// λ, and how much each component of λ takes from it; λ in Pa, r in m³, u_t in m. `None` where a pane does not move along its normal.
    pub(super) fn new(
        operator: &dyn Fn(usize, usize) -> f64,
        rhs: &[f64],
        slips: &[[(f64, Vec<f64>); 2]],
        nodes: Vec<Vec<(usize, f64)>>,
        laws: Vec<NodeLaw>,
    ) -> Option<Self> {
        let panes = nodes.len();
        let n = 3 * panes;
        let diagonal: Vec<f64> = (0..n).map(|i| operator(i, i)).collect();
        let moves: Vec<bool> = diagonal.iter().map(|d| *d > 0.0).collect();
        if !(0..panes).all(|pane| moves[3 * pane]) {
            return None;
        }
        let normals = diagonal.iter().step_by(3);
        let scale: Vec<f64> = normals.map(|d| power_of_two(d.sqrt())).collect();
        let scaled = |i: usize| rhs[i] / scale[i / 3];
        let load = (0..n).map(|i| scaled(i).abs()).fold(0.0, f64::max);
        let load = power_of_two(load);
        let root = |i: usize| diagonal[i].sqrt() / scale[i / 3];
        let entry = |i: usize, j: usize| {
            if !moves[i] || !moves[j] {
                return Interval::ZERO;
            }
            // Both halves of S, which differ by rounding.
            let [a, b] = [(i, j), (j, i)].map(|(i, j)| {
                let value = operator(i, j) / scale[i / 3] / scale[j / 3];
                Interval::around(value, UNCERTAIN * root(i) * root(j))
            });
            a.hull(b)
        };
        let stress: Vec<f64> = scale.iter().map(|scale| load / scale).collect();
        let slip = |(free, by): &(f64, Vec<f64>)| {
            let row = by.iter().enumerate().map(|(j, by)| -by * stress[j / 3]);
            let row: Vec<f64> = row.collect();
            let size = row.iter().fold(free.abs(), |size, v| size.max(v.abs()));
            let near = |value: f64| Interval::around(value, UNCERTAIN * size);
            Affine {
                constant: near(*free),
                slope: row.into_iter().map(near).collect(),
            }
        };
        let slips = slips.iter().map(|pair| pair.each_ref().map(slip));
        let slips = slips.collect();
        let row = |i: usize| (0..n).map(|j| entry(i, j)).collect();
        let rhs = |i: usize| {
            if moves[i] {
                Interval::around(scaled(i) / load, UNCERTAIN)
            } else {
                Interval::ZERO
            }
        };
        Some(Self {
            operator: (0..n).map(row).collect(),
            rhs: (0..n).map(rhs).collect(),
            moves,
            stress,
            nodes,
            laws,
            slips,
        })
    }

    pub(super) fn n_panes(&self) -> usize {
        self.nodes.len()
    }

    pub(super) fn is_isotropic(&self) -> bool {
        let mut laws = self.laws.iter();
        laws.all(|law| matches!(law, NodeLaw::Isotropic(_)))
    }
}

/// Rounding of the values of a law at its knots, of which the evaluations make a few.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// A coefficient over its own slip: straight lines between knots, the last one constant without end.
#[derive(Debug, Clone)]
pub(super) struct StraightLines {
    knots: Vec<(f64, Interval)>,
}

/// The coefficients at one contact node.
#[derive(Debug, Clone)]
pub(super) enum NodeLaw {
    /// F(|u_t|).
    Isotropic(StraightLines),
    /// F₁(|u_t1|), F₂(|u_t2|).
    Orthotropic([StraightLines; 2]),
}

impl StraightLines {
    /// From the slips at the knots, zero first, and the values there.
    pub(super) fn new(knots: impl Iterator<Item = (f64, f64)>) -> Self {
        let rounded = |value: f64| Interval::around(value, ROUNDING * value.abs());
        Self {
            knots: knots.map(|(slip, value)| (slip, rounded(value))).collect(),
        }
    }

    /// The values and the slopes on all lines that an interval of slips reaches.
    pub(super) fn over(&self, slip: Interval) -> (Interval, Interval) {
        let before = |slip: f64| self.knots.partition_point(|(knot, _)| *knot <= slip);
        let reached = before(slip.low).saturating_sub(1)..before(slip.high).max(1);
        let lines = reached.map(|line| {
            let (start, from) = self.knots[line];
            let Some((end, to)) = self.knots.get(line + 1) else {
                return (from, Interval::ZERO);
            };
            let length = Interval::point(*end) - Interval::point(start);
            let slope = (*to - from) * length.recip();
            let inside = Interval::new(slip.low.max(start), slip.high.min(*end));
            (from + slope * (inside - Interval::point(start)), slope)
        });
        let all = lines.reduce(|a, b| (a.0.hull(b.0), a.1.hull(b.1)));
        all.expect("every slip is on a line")
    }
}
