//! Newton's method with coefficients of friction as unknowns, for laws that rise steeply with the slip.
//!
//! Where F rises by its whole height within a slip that is small beside those of the solution, Newton's step in λ jumps across the
//! rise, and successive approximations oscillate about it. A point of the graph of F is a better unknown than its slip. For c > 0
//! the resolvent Φ of the graph,
//!
//!   Φ(y) = F(s) for the s with F(s) + c s = y,   Φ' = F' / (F' + c) ∈ [0, 1) however steep F is,
//!
//! tells whether (s, f) lies on it: f = Φ(f + c s). So the coefficients f at the contact nodes are unknowns beside x = (λ, α):
//!
//!   R(x; f) = 0 with the ellipses that f makes,   f − Φ(f + c s(x)) = 0.
//!
//! The steplength c is 1/(C g): the slip of a node whose friction changes by f is C g f, with the node's compliance C and the pressure
//! g. A coefficient that lies where F is constant has Φ' = 0 and is eliminated; the others border the matrix of R.
//!
//! Where no start leads to the solution the law is stretched along the slip until it is as flat as the body is stiff, and the solutions
//! are followed back to the law itself ([`followed_from_stretched_law`]). There is no theorem behind either: laws on panes have no
//! potential. The augmented unknown is that of resolvent-based Newton methods for maximal monotone graphs (cf. M. Hintermüller,
//! K. Ito, K. Kunisch, *SIAM J. Optim.* 13 (2003) 865, for the graph of contact).

use super::{
    NewtonSettings, NewtonSolution,
    continuation::continuation,
    iteration::{NewtonModel, ROUNDING_STALL_STEPS, StoppingRule, iterate},
    natural_map::NaturalMap,
};
use crate::{
    contact::CoulombLaw,
    dual::{ExplicitDual, LocalStiffness},
    linalg::{DenseLu, norm},
    scene::FrictionLaw,
    solver::{
        NewtonStep, PaneLaws,
        conditions::{Bound, Evaluation},
        strategy::{NEWTON_MAX_STEPS, ZONES_FOUND},
    },
};

/// Factors of c that are tried, one start each: c → ∞ is Newton's method in λ alone.
const RESOLVENT_FACTORS: [f64; 6] = [1.0, 100.0, 0.1, 1e4, 0.01, 10.0];

/// ‖R‖ / ‖λ‖ that is asked for: slips are then known to a millionth of the narrowest rise met.
const GRAPH_TOLERANCE: f64 = 1e-12;

/// Least pressure at a node beside the mean one, so that c stays finite where the bonded face lifts off.
const LEAST_PRESSURE: f64 = 0.1;

/// Decades of slip below the largest free slip in which the range and the largest slope of a law are sampled, and samples in each.
const SAMPLED_DECADES: i32 = 14;
const SAMPLES_PER_DECADE: i32 = 16;

/// A law that reads the slip, its graph at the contact nodes, and the contact problem that it belongs to.
pub(in crate::solver) struct FrictionGraph<'a> {
    dual: &'a ExplicitDual,
    laws: &'a PaneLaws,
    steplengths: &'a [f64],
    coefficients: Vec<NodeCoefficient>,
    /// Pa for a unit of friction: the largest stress of the bonded face over the largest coefficient.
    scale: f64,
}

/// A coefficient of friction at a contact node.
struct NodeCoefficient {
    node: usize,
    /// The axis of its slip; `None` of an isotropic law, which reads |u_t|.
    axis: Option<usize>,
    /// c in 1/m.
    steplength: f64,
    /// Least and largest value of F.
    range: [f64; 2],
}

/// The slip of a coefficient and its derivative by (u_t1, u_t2) of the node.
#[derive(Clone, Copy)]
struct Slip {
    /// (|u_t1|, |u_t2|) in m.
    pair: [f64; 2],
    own: f64,
    by_displacement: [f64; 2],
}

/// x and f with their residuals.
struct GraphIterate {
    unknowns: Vec<f64>,
    coefficients: Vec<f64>,
    /// R, with the rows of the graph as stresses in its norm.
    evaluation: Evaluation,
    slips: Vec<Slip>,
    /// f − Φ(f + c s) and Φ'.
    graph: Vec<[f64; 2]>,
}

/// The graph of a law with a factor of the steplengths c.
struct GraphModel<'g> {
    graph: &'g FrictionGraph<'g>,
    law: &'g CoulombLaw,
    factor: f64,
    evaluations: usize,
}

impl GraphModel<'_> {
    fn at(&mut self, unknowns: Vec<f64>, coefficients: Vec<f64>) -> GraphIterate {
        self.evaluations += 1;
        self.graph
            .evaluate(self.law, self.factor, unknowns, coefficients)
    }
}

impl NewtonModel for GraphModel<'_> {
    type Iterate = GraphIterate;

    fn evaluation<'i>(&self, iterate: &'i GraphIterate) -> &'i Evaluation {
        &iterate.evaluation
    }

    fn relative(&self, iterate: &GraphIterate) -> f64 {
        let multiplier = self.graph.dual.multipliers(&iterate.unknowns);
        iterate.evaluation.relative_to(norm(multiplier))
    }

    fn direction(&mut self, from: &GraphIterate) -> Option<(Vec<f64>, usize)> {
        let direction = self.graph.direction(self.factor, from)?;
        let n = direction.len();
        Some((direction, n))
    }

    fn moved(&mut self, from: &GraphIterate, direction: &[f64], share: f64) -> GraphIterate {
        let moved = |from: &[f64], by: &[f64]| -> Vec<f64> {
            from.iter().zip(by).map(|(x, d)| x + share * d).collect()
        };
        let (direction, change) = direction.split_at(from.unknowns.len());
        let mut coefficients = moved(&from.coefficients, change);
        for (f, c) in coefficients.iter_mut().zip(&self.graph.coefficients) {
            *f = f.clamp(c.range[0], c.range[1]);
        }
        self.at(moved(&from.unknowns, direction), coefficients)
    }

    fn is_at_rounding(&self, best: &GraphIterate) -> bool {
        // Rounding of a steep law forbids less.
        self.relative(best) <= ZONES_FOUND
    }
}

impl<'a> FrictionGraph<'a> {
    /// Whether coefficients follow slips.
    pub(in crate::solver) fn applies(dual: &ExplicitDual, law: &CoulombLaw) -> bool {
        law.depends_on_slip() && dual.compliance.is_some()
    }

    /// `None` where the bonded face has no stress or a node no compliance, so that no c can be found.
    pub(in crate::solver) fn new(
        dual: &'a ExplicitDual,
        laws: &'a PaneLaws,
        law: &CoulombLaw,
        local: &'a LocalStiffness,
    ) -> Option<Self> {
        let compliance = dual.compliance.as_ref()?;
        let bonded = local.bonded_start(dual);
        let (normal, _) = dual.layout.split(dual.multipliers(&bonded));
        let pressed = normal.iter().take(law.n_panes()).map(|l| l.max(0.0));
        let pressure: Vec<f64> = pressed.collect();
        let least = LEAST_PRESSURE * pressure.iter().sum::<f64>() / pressure.len().max(1) as f64;
        // Means over the panes around each node.
        let mut weight = vec![0.0; law.n_nodes()];
        let (mut at_node, mut yields) = (weight.clone(), weight.clone());
        for (pane, g) in pressure.iter().enumerate() {
            let pair = dual.layout.tangential(pane)?;
            for (node, w) in laws.average.entries(pane) {
                let own = [0, 1].map(|k| compliance.column(pair[k])[2 * node + k]);
                weight[node] += w;
                at_node[node] += w * g;
                yields[node] += w * 0.5 * (own[0] + own[1]);
            }
        }
        let free = laws
            .slip
            .slip(&dual.tangential_displacement(&dual.unknowns(&[])));
        let largest = free.iter().flatten().fold(0.0_f64, |most, s| most.max(*s));
        let mut coefficients = Vec::new();
        for face in law.faces() {
            let axes: &[Option<usize>] = match face.law() {
                FrictionLaw::Isotropic(_) => &[None],
                FrictionLaw::Orthotropic(_) => &[Some(0), Some(1)],
            };
            for node in face.nodes() {
                let yields = yields[node] / weight[node];
                // A node that is held, or belongs to no pane, keeps its slip.
                if yields.is_nan() || yields <= 0.0 {
                    continue;
                }
                let g = (at_node[node] / weight[node]).max(least);
                for &axis in axes {
                    coefficients.push(NodeCoefficient {
                        node,
                        axis,
                        steplength: (yields * g).recip(),
                        range: sampled_range(law, node, axis, largest),
                    });
                }
            }
        }
        let most = coefficients
            .iter()
            .fold(0.0_f64, |most, c| most.max(c.range[1]));
        let scale = norm(dual.multipliers(&bonded)) / most;
        let finite = |c: &NodeCoefficient| c.steplength.is_finite() && c.steplength > 0.0;
        (scale.is_finite() && coefficients.iter().all(finite)).then_some(Self {
            dual,
            laws,
            steplengths: &local.stiffness,
            coefficients,
            scale,
        })
    }

    /// A solution from λ = 0 and the coefficients without slip, by the first steplength that leads to one; else along the stretched law.
    pub(in crate::solver) fn solve(
        &self,
        law: &CoulombLaw,
        observe: &mut dyn FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        let mut found = NewtonSolution::none(self.dual);
        let mut merge = |found: NewtonSolution, next: NewtonSolution| {
            let done = found.history.len();
            let steps = next.history.iter().enumerate();
            steps.for_each(|(k, step)| observe(done + k, step));
            found.merged_with(next)
        };
        for factor in RESOLVENT_FACTORS {
            let next = self.newton(law, factor, None);
            found = merge(found, next);
            if found.is_solution() {
                break;
            }
        }
        if !found.is_solution() {
            let next = self.followed_from_stretched_law(law);
            found = merge(found, next);
        }
        found.multiplier.truncate(self.dual.n_unknowns());
        found
    }

    /// Follows the solutions of the laws F(s/σ) from a σ with which no slope exceeds c to σ = 1, geometrically.
    fn followed_from_stretched_law(&self, law: &CoulombLaw) -> NewtonSolution {
        let steepest = |c: &NodeCoefficient| {
            let slopes =
                samples(self.largest_free_slip()).map(|s| slope(law, c, [0.0; 2], s).abs());
            slopes.fold(0.0, f64::max) / c.steplength
        };
        let stretch = self.coefficients.iter().map(steepest).fold(1.0, f64::max);
        continuation(&mut |_, _| {}, |share, start| {
            let law = law.stretched(stretch.powf(1.0 - share));
            self.newton(&law, 1.0, start)
        })
    }

    /// Slips without contact forces in m, those of held nodes whatever the forces.
    fn free_slips(&self) -> Vec<[f64; 2]> {
        let free = self.dual.unknowns(&[]);
        self.laws
            .slip
            .slip(&self.dual.tangential_displacement(&free))
    }

    fn largest_free_slip(&self) -> f64 {
        let free = self.free_slips();
        free.iter().flatten().fold(0.0, |most, s| most.max(*s))
    }

    /// Damped Newton steps for (x, f), from a start or from λ = 0; the multiplier of the result is (x, f).
    fn newton(&self, law: &CoulombLaw, factor: f64, start: Option<&[f64]>) -> NewtonSolution {
        let n = self.dual.n_unknowns();
        let (unknowns, coefficients) = match start {
            Some(start) => (start[..n].to_vec(), start[n..].to_vec()),
            None => {
                let at_rest = |c: &NodeCoefficient| value(law, c, [0.0; 2], 0.0);
                (
                    self.dual.unknowns(&[]),
                    self.coefficients.iter().map(at_rest).collect(),
                )
            }
        };
        let mut model = GraphModel {
            graph: self,
            law,
            factor,
            evaluations: 0,
        };
        let first = model.at(unknowns, coefficients);
        let rule = StoppingRule {
            settings: NewtonSettings {
                tolerance: GRAPH_TOLERANCE,
                max_steps: NEWTON_MAX_STEPS,
            },
            least_steps: 0,
            // Residuals may rise on the way across a rise of F.
            stagnation_steps: NEWTON_MAX_STEPS,
            rounding_steps: ROUNDING_STALL_STEPS - 1,
        };
        let found = iterate(&mut model, first, &rule, |_, _| {});
        let last = found.iterate;
        NewtonSolution {
            status: found.status,
            residual: model.relative(&last),
            multiplier: [last.unknowns, last.coefficients].concat(),
            history: found.history,
            evaluations: model.evaluations,
        }
    }

    fn evaluate(
        &self,
        law: &CoulombLaw,
        factor: f64,
        unknowns: Vec<f64>,
        coefficients: Vec<f64>,
    ) -> GraphIterate {
        let mut nodal = law.at_nodes(&self.free_slips());
        for (c, f) in self.coefficients.iter().zip(&coefficients) {
            c.axes().for_each(|k| nodal[c.node][k] = *f);
        }
        let inverse = |pane: usize| {
            let nodes = self.laws.average.entries(pane);
            nodes.fold([0.0; 2], |sum, (node, w)| {
                [0, 1].map(|k| sum[k] + w / nodal[node][k])
            })
        };
        let inverse = (0..law.n_panes()).map(inverse).collect();
        let map = NaturalMap::with_coefficients(
            self.dual,
            Bound::Coulomb(self.laws, law),
            self.steplengths.to_vec(),
            inverse,
        );
        let mut evaluation = map.evaluate(&unknowns);
        let slips = self.slips(&unknowns);
        let points = self.coefficients.iter().zip(&coefficients).zip(&slips);
        let graph: Vec<[f64; 2]> = points
            .map(|((c, f), slip)| {
                let steplength = factor * c.steplength;
                let [value, slope] =
                    Self::resolvent(law, c, slip.pair, steplength, f + steplength * slip.own);
                [f - value, slope]
            })
            .collect();
        let off = norm(
            &graph
                .iter()
                .map(|[r, _]| self.scale * r)
                .collect::<Vec<_>>(),
        );
        evaluation.norm = evaluation.norm.hypot(off);
        GraphIterate {
            unknowns,
            coefficients,
            evaluation,
            slips,
            graph,
        }
    }

    fn slips(&self, unknowns: &[f64]) -> Vec<Slip> {
        let displacement = self.dual.tangential_displacement(unknowns);
        let pairs = self.laws.slip.slip(&displacement);
        let signs = self.laws.slip.derivative(&displacement);
        let at = |c: &NodeCoefficient| {
            let (pair, sign) = (pairs[c.node], signs[c.node]);
            let (own, direction) = match c.axis {
                Some(axis) => (pair[axis], [0, 1].map(|k| f64::from(u8::from(k == axis)))),
                None => {
                    let own = pair[0].hypot(pair[1]);
                    (own, pair.map(|s| if own > 0.0 { s / own } else { 0.0 }))
                }
            };
            Slip {
                pair,
                own,
                by_displacement: [0, 1].map(|k| direction[k] * sign[k]),
            }
        };
        self.coefficients.iter().map(at).collect()
    }

    /// Changes of x and f, one behind the other, with R'd + ∂R/∂f δf = −R and (1 − Φ') δf − Φ' c δs = −(f − Φ).
    fn direction(&self, factor: f64, at: &GraphIterate) -> Option<Vec<f64>> {
        let n = at.unknowns.len();
        let bordering: Vec<usize> = (0..at.graph.len())
            .filter(|&k| at.graph[k][1] > 0.0)
            .collect();
        let size = n + bordering.len();
        let map = NaturalMap::with_coefficients(
            self.dual,
            Bound::Coulomb(self.laws, self.laws.coulomb()?),
            self.steplengths.to_vec(),
            Vec::new(),
        );
        let derivative = map.derivative(&at.evaluation);
        let mut matrix = vec![0.0; size * size];
        for (column, from) in matrix
            .chunks_exact_mut(size)
            .zip(derivative.chunks_exact(n))
        {
            column[..n].copy_from_slice(from);
        }
        let mut rhs: Vec<f64> = at.evaluation.residual.iter().map(|r| -r).collect();
        rhs.resize(size, 0.0);
        let by_coefficient = self.by_coefficients(at);
        let mut change: Vec<f64> = at.graph.iter().map(|[r, _]| -r).collect();
        for (k, column) in by_coefficient.iter().enumerate() {
            if at.graph[k][1] == 0.0 {
                column
                    .iter()
                    .for_each(|(row, by)| rhs[*row] -= by * change[k]);
            }
        }
        for (b, &k) in bordering.iter().enumerate() {
            let [residual, slope] = at.graph[k];
            for (row, by) in &by_coefficient[k] {
                matrix[(n + b) * size + row] = by / self.scale;
            }
            matrix[(n + b) * size + n + b] = 1.0 - slope;
            rhs[n + b] = -self.scale * residual;
            let (c, slip) = (&self.coefficients[k], &at.slips[k]);
            let by_slip = self.scale * slope * factor * c.steplength;
            for j in 0..n {
                matrix[j * size + n + b] = -by_slip * self.slip_change(c.node, slip, j);
            }
        }
        DenseLu::new(&matrix, size)?.solve(&mut rhs);
        for (b, &k) in bordering.iter().enumerate() {
            change[k] = rhs[n + b] / self.scale;
        }
        rhs.truncate(n);
        rhs.extend(change);
        rhs.iter().all(|v| v.is_finite()).then_some(rhs)
    }

    /// ∂R/∂f of each coefficient, the rows that are not zero.
    fn by_coefficients(&self, at: &GraphIterate) -> Vec<Vec<(usize, f64)>> {
        let mut columns = vec![Vec::new(); self.coefficients.len()];
        let mut of_node = vec![Vec::new(); self.laws.average.rows];
        for (k, c) in self.coefficients.iter().enumerate() {
            of_node[c.node].push(k);
        }
        for (i, pane) in at.evaluation.panes.iter().enumerate() {
            let Some(pair) = self.dual.layout.tangential(i) else {
                continue;
            };
            let by_axes = pane.ellipse.projection_derivative(pane.trial).by_semi_axes;
            for (node, weight) in self.laws.average.entries(i) {
                for &k in &of_node[node] {
                    let f = at.coefficients[k];
                    // a = g/q with q = Σ w/f: ∂a/∂f = a w / (q f²).
                    let grows = |axis: usize| {
                        pane.ellipse.semi_axes[axis] * weight / (pane.inverse[axis] * f * f)
                    };
                    let moved = [0, 1].map(|row| {
                        let axes = self.coefficients[k].axes();
                        -axes
                            .map(|axis| by_axes[row][axis] * grows(axis))
                            .sum::<f64>()
                    });
                    columns[k].extend(pair.into_iter().zip(moved));
                }
            }
        }
        columns
    }

    /// ∂s/∂x_j.
    fn slip_change(&self, node: usize, slip: &Slip, unknown: usize) -> f64 {
        let by = slip.by_displacement;
        match (
            unknown.checked_sub(self.dual.dimension()),
            &self.dual.rigid,
            &self.dual.compliance,
        ) {
            (None, _, Some(compliance)) => {
                let column = compliance.column(unknown);
                -(by[0] * column[2 * node] + by[1] * column[2 * node + 1])
            }
            (Some(motion), Some(balance), _) => {
                let moved = balance.coupling.slip[motion][node];
                by[0] * moved[0] + by[1] * moved[1]
            }
            _ => 0.0,
        }
    }

    /// Φ(y) and Φ'(y), by bisection: F(s) + c s − y rises where c > −F'.
    fn resolvent(
        law: &CoulombLaw,
        c: &NodeCoefficient,
        pair: [f64; 2],
        steplength: f64,
        y: f64,
    ) -> [f64; 2] {
        let at_rest = value(law, c, pair, 0.0);
        if y <= at_rest {
            return [at_rest, 0.0];
        }
        let (mut low, mut high) = (0.0, (y - c.range[0]) / steplength);
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if value(law, c, pair, middle) + steplength * middle < y {
                low = middle;
            } else {
                high = middle;
            }
        }
        let slope = slope(law, c, pair, high).max(0.0);
        // On a steep rise s has fewer digits than f, which is what is left of y.
        let value = (y - steplength * high).clamp(c.range[0], c.range[1]);
        [value, slope / (slope + steplength)]
    }
}

impl NodeCoefficient {
    fn axes(&self) -> impl Iterator<Item = usize> + use<> {
        self.axis.map_or(0..2, |axis| axis..axis + 1)
    }

    /// (|u_t1|, |u_t2|) with the own slip s.
    fn at(&self, pair: [f64; 2], s: f64) -> [f64; 2] {
        match self.axis {
            Some(axis) => [0, 1].map(|k| if k == axis { s } else { pair[k] }),
            None => match pair[0].hypot(pair[1]) {
                0.0 => [s, 0.0],
                own => pair.map(|p| s * (p / own)),
            },
        }
    }
}

/// F of a coefficient at the slip s of its own, others as they are.
fn value(law: &CoulombLaw, c: &NodeCoefficient, pair: [f64; 2], s: f64) -> f64 {
    law.evaluate(c.node, c.at(pair, s))[c.axis.unwrap_or(0)]
}

/// dF/ds.
fn slope(law: &CoulombLaw, c: &NodeCoefficient, pair: [f64; 2], s: f64) -> f64 {
    let at = c.at(pair, s);
    let row = law.derivative(c.node, at)[c.axis.unwrap_or(0)];
    match c.axis {
        Some(axis) => row[axis],
        None if s > 0.0 => (row[0] * at[0] + row[1] * at[1]) / s,
        None => row[0],
    }
}

/// Slips around the largest free one, from far below it to a decade above.
fn samples(largest: f64) -> impl Iterator<Item = f64> {
    (-SAMPLED_DECADES * SAMPLES_PER_DECADE..=SAMPLES_PER_DECADE)
        .map(move |k| largest * 10_f64.powf(f64::from(k) / f64::from(SAMPLES_PER_DECADE)))
}

fn sampled_range(law: &CoulombLaw, node: usize, axis: Option<usize>, largest: f64) -> [f64; 2] {
    let c = NodeCoefficient {
        node,
        axis,
        steplength: 0.0,
        range: [0.0; 2],
    };
    let values = std::iter::once(0.0)
        .chain(samples(largest))
        .map(|s| law.evaluate(node, c.at([0.0; 2], s))[axis.unwrap_or(0)]);
    values.fold([f64::INFINITY, 0.0], |[least, most], f| {
        [least.min(f), f64::max(most, f)]
    })
}
