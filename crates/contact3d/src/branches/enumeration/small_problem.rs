//! A contact problem of a few panes in intervals, without units.

use super::{
    super::family::power_of_two,
    interval::{Interval, product},
    straight_law::NodeLaw,
    varying::Varying,
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
    /// u_t at the contact nodes; empty for a law that does not follow it.
    pub(super) slips: Vec<NodeSlip>,
}

/// u_t at a contact node.
pub(super) struct NodeSlip {
    /// By λ of all components.
    pub(super) rows: [Affine; 2],
    /// (pane, u_t over the pane's slip −r_t) where these are one up to the uncertainty: at nodal multipliers.
    pub(super) own: Option<(usize, Interval)>,
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

    pub(super) fn value(&self, of: &[Varying]) -> Interval {
        let terms = self.slope.iter().zip(of);
        self.constant + terms.map(|(slope, x)| *slope * x.value).sum()
    }

    pub(super) fn over(&self, of: &[Varying]) -> Varying {
        let terms = self.slope.iter().zip(of);
        let sum = Varying::constant(self.constant);
        terms.fold(sum, |sum, (slope, x)| sum + x.times(*slope))
    }
}

/// Plain numbers of a problem: λ in Pa, r in m³, u_t in m.
pub(super) struct Numbers<'a> {
    /// S_ij.
    pub(super) operator: &'a dyn Fn(usize, usize) -> f64,
    pub(super) rhs: &'a dyn Fn(usize) -> f64,
    /// u_t without λ at a node along an axis, and by a component of λ.
    pub(super) slip_free: &'a dyn Fn(usize, usize) -> f64,
    pub(super) slip: &'a dyn Fn(usize, usize, usize) -> f64,
    pub(super) follows_slip: bool,
}

impl SmallProblem {
    /// The problem with what rounding may have changed; `None` where a pane does not move along its normal.
    pub(super) fn new(
        numbers: &Numbers<'_>,
        nodes: Vec<Vec<(usize, f64)>>,
        laws: Vec<NodeLaw>,
    ) -> Option<Self> {
        let panes = nodes.len();
        let n = 3 * panes;
        let diagonal: Vec<f64> = (0..n).map(|i| (numbers.operator)(i, i)).collect();
        let moves: Vec<bool> = diagonal.iter().map(|d| *d > 0.0).collect();
        if !(0..panes).all(|pane| moves[3 * pane]) {
            return None;
        }
        let scale: Vec<f64> = (0..panes)
            .map(|pane| power_of_two(diagonal[3 * pane].sqrt()))
            .collect();
        let scaled = |i: usize| (numbers.rhs)(i) / scale[i / 3];
        let load = (0..n).map(|i| scaled(i).abs()).fold(0.0, f64::max);
        let load = power_of_two(load);
        let root = |i: usize| diagonal[i].sqrt() / scale[i / 3];
        let entry = |i: usize, j: usize| {
            if !moves[i] || !moves[j] {
                return Interval::ZERO;
            }
            let [a, b] = [(i, j), (j, i)].map(|(i, j)| {
                let value = (numbers.operator)(i, j) / scale[i / 3] / scale[j / 3];
                Interval::around(value, UNCERTAIN * root(i) * root(j))
            });
            a.hull(b)
        };
        let stress: Vec<f64> = scale.iter().map(|scale| load / scale).collect();
        let mut problem = Self {
            operator: (0..n)
                .map(|i| (0..n).map(|j| entry(i, j)).collect())
                .collect(),
            rhs: (0..n)
                .map(|i| match moves[i] {
                    true => Interval::around(scaled(i) / load, UNCERTAIN),
                    false => Interval::ZERO,
                })
                .collect(),
            moves,
            stress,
            nodes,
            laws,
            slips: Vec::new(),
        };
        if numbers.follows_slip {
            let nodes = 0..problem.laws.len();
            problem.slips = nodes.map(|node| problem.slip(numbers, node)).collect();
        }
        Some(problem)
    }

    pub(super) fn n_panes(&self) -> usize {
        self.nodes.len()
    }

    fn slip(&self, numbers: &Numbers<'_>, node: usize) -> NodeSlip {
        let rows = [0, 1].map(|axis| {
            let row = (0..self.rhs.len()).map(|j| {
                let stress = self.stress[j / 3];
                -(numbers.slip)(node, axis, j) * stress
            });
            let row: Vec<f64> = row.collect();
            let free = (numbers.slip_free)(node, axis);
            let size = row.iter().fold(free.abs(), |size, v| size.max(v.abs()));
            let near = |value: f64| Interval::around(value, UNCERTAIN * size);
            Affine {
                constant: near(free),
                slope: row.into_iter().map(near).collect(),
            }
        });
        let has_node = |nodes: &Vec<(usize, f64)>| nodes.iter().any(|(other, _)| *other == node);
        let mut panes = (0..self.n_panes()).filter(|pane| has_node(&self.nodes[*pane]));
        let own = match (panes.next(), panes.next()) {
            (Some(pane), None) if self.nodes[pane].len() == 1 => self.ratio(&rows, pane),
            _ => None,
        };
        NodeSlip { rows, own }
    }

    /// The pane and k in u_t = −k r_t, if all that u_t depends on is k times what r_t does.
    fn ratio(&self, rows: &[Affine; 2], pane: usize) -> Option<(usize, Interval)> {
        let axes = [0, 1].map(|axis| (&rows[axis], 3 * pane + 1 + axis));
        let moving = axes.into_iter().find(|(_, i)| self.moves[*i])?;
        let own = -moving.0.slope[moving.1].over(self.operator[moving.1][moving.1])?;
        let ratio = Interval::point(own.middle());
        let is_own = |(row, i): (&Affine, usize)| {
            let terms = row.slope.iter().zip(&self.operator[i]);
            let mut terms = terms.map(|(u, r)| *u + ratio * *r);
            terms.all(Interval::has_zero) && (row.constant - ratio * self.rhs[i]).has_zero()
        };
        axes.into_iter().all(is_own).then_some((pane, ratio))
    }

    pub(super) fn is_isotropic(&self) -> bool {
        let mut laws = self.laws.iter();
        laws.all(|law| matches!(law, NodeLaw::Isotropic(_)))
    }
}
