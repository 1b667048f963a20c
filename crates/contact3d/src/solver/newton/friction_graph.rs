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
//! Where no start leads to the solution the rises of F are widened to the largest slip, and the solutions are followed back to the law
//! itself ([`FrictionGraph::followed_from_wide_rises`]). There is no theorem behind either: laws on panes have no potential. The
//! augmented unknown is that of resolvent-based Newton methods for maximal monotone graphs (cf. M. Hintermüller, K. Ito, K. Kunisch,
//! *SIAM J. Optim.* 13 (2003) 865, for the graph of contact).

use super::{
    NewtonSettings, NewtonSolution,
    coefficient::NodeCoefficient,
    iteration::{Iterate, NewtonModel, iterate},
    natural_map::NaturalMap,
};
use crate::{
    contact::{CoulombLaw, LawBounds, slip_signs, slips},
    dual::{ExplicitDual, LocalStiffness},
    linalg::{DenseLu, norm},
    scene::FrictionLaw,
    solver::{
        NewtonStep, PaneLaws,
        conditions::Bound,
        tolerances::{NEWTON_MAX_STEPS, ROUNDING_STALL_STEPS, ZONES_TOLERANCE},
    },
};

/// Factors of c that are tried, one start each, from the scale of the nodes' own slips to others far from those that failed: c → ∞ is
/// Newton's method in λ alone.
const RESOLVENT_FACTORS: [f64; 6] = [1.0, 100.0, 0.1, 1e4, 0.01, 10.0];

/// ‖R‖ / ‖λ‖ that is asked for: slips are then known to a millionth of the narrowest rise met.
const GRAPH_TOLERANCE: f64 = 1e-12;

/// Least pressure at a node beside the mean one, so that c stays finite where the bonded face lifts off.
const LEAST_PRESSURE: f64 = 0.1;

/// Slips of a solution over the largest of those without contact forces, at most: extremes of F are looked for up to there.
const SLIP_MARGIN: f64 = 10.0;

/// Decades that rises of F are narrowed along the path to the law itself: on from there a rise is as steep as rounding of slips allows.
const NARROWED_DECADES: f64 = 10.0;

/// Smallest step in τ along the path: 0.02 decades.
const SMALLEST_PATH_STEP: f64 = 1.0 / 512.0;

/// A law that reads the slip, its graph at the contact nodes, and the contact problem that it belongs to.
pub(in crate::solver) struct FrictionGraph<'a> {
    dual: &'a ExplicitDual,
    laws: &'a PaneLaws,
    law: &'a CoulombLaw,
    steplengths: &'a [f64],
    coefficients: Vec<NodeCoefficient>,
    /// Pa for a unit of friction: the largest stress of the bonded face over the largest coefficient.
    scale: f64,
    /// Slips without contact forces in m, those of held nodes whatever the forces.
    free_slips: Vec<[f64; 2]>,
    largest_free_slip: f64,
    /// What the steplengths c of the coefficients are multiplied with.
    factor: f64,
    /// Slip in m by which the whole rise of F is wider than that of the law.
    rise: f64,
    evaluations: usize,
}

/// The slip of a coefficient and its derivative by (u_t1, u_t2) of the node.
#[derive(Clone, Copy)]
struct Slip {
    /// (|u_t1|, |u_t2|) in m.
    pair: [f64; 2],
    own: f64,
    by_displacement: [f64; 2],
}

/// x and f with the residual of the graph.
pub(in crate::solver) struct GraphPoint {
    unknowns: Vec<f64>,
    coefficients: Vec<f64>,
    slips: Vec<Slip>,
    /// f − Φ(f + c s) and Φ'.
    graph: Vec<[f64; 2]>,
}

impl NewtonModel for FrictionGraph<'_> {
    type Point = GraphPoint;

    /// Changes of x and f, one behind the other, with R'd + ∂R/∂f δf = −R and (1 − Φ') δf − Φ' c δs = −(f − Φ).
    fn direction(&mut self, from: &Iterate<GraphPoint>) -> Option<(Vec<f64>, usize)> {
        let (at, evaluation) = (&from.point, &from.evaluation);
        let n = at.unknowns.len();
        let by_coefficient = self.by_coefficients(from);
        let mut rhs: Vec<f64> = evaluation.residual.iter().map(|r| -r).collect();
        let mut change: Vec<f64> = at.graph.iter().map(|[r, _]| -r).collect();
        let is_eliminated = |k: &usize| at.graph[*k][1] == 0.0;
        for k in (0..change.len()).filter(is_eliminated) {
            let column = by_coefficient[k].iter();
            column.for_each(|(row, by)| rhs[*row] -= by * change[k]);
        }
        let bordering: Vec<usize> = (0..change.len()).filter(|k| !is_eliminated(k)).collect();
        rhs.extend(bordering.iter().map(|&k| -self.scale * at.graph[k][0]));
        let matrix = self.bordered_matrix(from, &bordering, &by_coefficient);
        DenseLu::new(&matrix, rhs.len())?.solve(&mut rhs);
        for (b, &k) in bordering.iter().enumerate() {
            change[k] = rhs[n + b] / self.scale;
        }
        rhs.truncate(n);
        rhs.extend(change);
        let size = rhs.len();
        rhs.iter().all(|v| v.is_finite()).then_some((rhs, size))
    }

    fn trial(
        &mut self,
        from: &Iterate<GraphPoint>,
        direction: &[f64],
        length: f64,
    ) -> Iterate<GraphPoint> {
        let from = &from.point;
        let shifted = |from: &[f64], by: &[f64]| -> Vec<f64> {
            from.iter().zip(by).map(|(x, d)| x + length * d).collect()
        };
        let (direction, change) = direction.split_at(from.unknowns.len());
        let mut coefficients = shifted(&from.coefficients, change);
        for (f, c) in coefficients.iter_mut().zip(&self.coefficients) {
            *f = f.clamp(c.range[0], c.range[1]);
        }
        self.evaluate(shifted(&from.unknowns, direction), coefficients)
    }

    fn is_at_rounding(&self, best: &Iterate<GraphPoint>) -> bool {
        // Rounding of a steep law forbids less.
        best.relative() <= ZONES_TOLERANCE
    }
}

impl<'a> FrictionGraph<'a> {
    /// `None` where the bonded face has no stress or a node no compliance, so that no c can be found.
    pub(in crate::solver) fn new(
        dual: &'a ExplicitDual,
        laws: &'a PaneLaws,
        law: &'a CoulombLaw,
        local: &'a LocalStiffness,
    ) -> Option<Self> {
        let bonded = local.bonded_start(dual);
        let bonded = dual.multipliers(&bonded);
        let nodal_steplengths = steplengths_of_nodes(dual, laws, law, bonded)?;
        let unloaded = dual.tangential_displacement(&dual.unknowns(&[]));
        let free_slips = slips(laws.previous.as_ref(), &unloaded);
        let all = free_slips.iter().flatten();
        let largest_free_slip = all.fold(0.0_f64, |most, s| most.max(*s));
        let mut coefficients = Vec::new();
        for face in law.faces() {
            let axes: &[Option<usize>] = match &face.law {
                FrictionLaw::Isotropic(_) => &[None],
                FrictionLaw::Orthotropic(_) => &[Some(0), Some(1)],
            };
            let bounds = LawBounds::new(face, SLIP_MARGIN * largest_free_slip);
            let range = [bounds.smallest, bounds.largest].map(|extreme| extreme.value);
            for node in face.nodes() {
                let Some(steplength) = nodal_steplengths[node] else {
                    continue;
                };
                coefficients.extend(axes.iter().map(|&axis| NodeCoefficient {
                    node,
                    axis,
                    steplength,
                    range,
                }));
            }
        }
        let largest = coefficients.iter().map(|c| c.range[1]);
        let scale = norm(bonded) / largest.fold(0.0, f64::max);
        let finite = |c: &NodeCoefficient| c.steplength.is_finite() && c.steplength > 0.0;
        (scale.is_finite() && coefficients.iter().all(finite)).then_some(Self {
            dual,
            laws,
            law,
            steplengths: &local.stiffness,
            coefficients,
            scale,
            free_slips,
            largest_free_slip,
            factor: 1.0,
            rise: 0.0,
            evaluations: 0,
        })
    }

    /// A solution from λ = 0 and the coefficients without slip, by the first steplength that leads to one; else from wide rises of F.
    pub(in crate::solver) fn solve(
        mut self,
        observe: &mut dyn FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        let mut found = NewtonSolution::failed(self.dual);
        for factor in RESOLVENT_FACTORS.into_iter().map(Some).chain([None]) {
            let next = match factor {
                Some(factor) => self.newton(factor, 0.0, None),
                None => self.followed_from_wide_rises(),
            };
            let done = found.history.len();
            let steps = next.history.iter().enumerate();
            steps.for_each(|(k, step)| observe(done + k, step));
            found = found.merged_with(next);
            if found.stop.is_solution() {
                break;
            }
        }
        found.unknowns.truncate(self.dual.n_unknowns());
        found
    }

    /// The solution of the same problem written about unknowns near to it, from these.
    pub(in crate::solver) fn solve_near(
        mut self,
        dual: &'a ExplicitDual,
        unknowns: &[f64],
    ) -> NewtonSolution {
        self.dual = dual;
        let slips = self.slips(unknowns);
        let coefficients = self.coefficients.iter().zip(&slips);
        let coefficients = coefficients.map(|(c, slip)| c.value(self.law, slip.pair, slip.own));
        let start: Vec<f64> = unknowns.iter().copied().chain(coefficients).collect();
        let mut found = self.newton(1.0, 0.0, Some(&start));
        found.unknowns.truncate(dual.n_unknowns());
        found
    }

    /// Follows the solutions from rises of F at τ = 0 that are as wide as the largest free slip to those of the law at τ = 1, narrowed
    /// geometrically, each from the one before, by steps in τ that double after a success and halve after a failure.
    ///
    /// The path may end before τ = 1 where solutions vanish in pairs; the reason to stop is then that of the last failure.
    fn followed_from_wide_rises(&mut self) -> NewtonSolution {
        let mut solve = |tau: f64, start: Option<&[f64]>| {
            let rise = match tau < 1.0 {
                true => self.largest_free_slip * 10_f64.powf(-NARROWED_DECADES * tau),
                false => 0.0,
            };
            self.newton(1.0, rise, start)
        };
        let mut last = solve(0.0, None);
        let (mut tau, mut step) = (0.0, 0.25);
        while tau < 1.0 && last.stop.is_solution() {
            let target = f64::min(tau + step, 1.0);
            let found = solve(target, Some(&last.unknowns));
            if found.stop.is_solution() {
                (last, tau) = (last.merged_with(found), target);
                step *= 2.0;
                continue;
            }
            last.evaluations += found.evaluations;
            last.history.extend(found.history);
            if step <= SMALLEST_PATH_STEP {
                last.stop = found.stop;
                break;
            }
            step /= 2.0;
        }
        last
    }

    /// Damped Newton steps for (x, f) with a factor of c and wider rises, from a start or from λ = 0; the multiplier of the result is
    /// (x, f).
    fn newton(&mut self, factor: f64, rise: f64, start: Option<&[f64]>) -> NewtonSolution {
        (self.factor, self.rise, self.evaluations) = (factor, rise, 0);
        let n = self.dual.n_unknowns();
        let (unknowns, coefficients) = match start {
            Some(start) => (start[..n].to_vec(), start[n..].to_vec()),
            None => {
                let at_rest = |c: &NodeCoefficient| c.value(self.law, [0.0; 2], 0.0);
                let coefficients = self.coefficients.iter().map(at_rest).collect();
                (self.dual.unknowns(&[]), coefficients)
            }
        };
        let first = self.evaluate(unknowns, coefficients);
        let settings = NewtonSettings {
            tolerance: GRAPH_TOLERANCE,
            max_steps: NEWTON_MAX_STEPS,
            // A solution nearby is measured, and not believed.
            least_steps: usize::from(start.is_some()),
            // Residuals may rise on the way across a rise of F.
            stagnation_steps: NEWTON_MAX_STEPS,
            // What it finds is refined.
            rounding_steps: ROUNDING_STALL_STEPS - 1,
        };
        let (stop, reached, history) = iterate(self, first, &settings, |_, _| {});
        NewtonSolution {
            stop,
            residual: reached.relative(),
            unknowns: [reached.point.unknowns, reached.point.coefficients].concat(),
            history,
            evaluations: self.evaluations,
        }
    }

    /// R at x with the ellipses that f makes, and the residual of the graph, whose rows count as stresses in the norm.
    fn evaluate(&mut self, unknowns: Vec<f64>, coefficients: Vec<f64>) -> Iterate<GraphPoint> {
        self.evaluations += 1;
        let mut evaluation = self
            .map(self.pane_inverse(&coefficients))
            .evaluate(&unknowns);
        let slips = self.slips(&unknowns);
        let points = self.coefficients.iter().zip(&coefficients).zip(&slips);
        let graph = points.map(|((c, f), slip)| {
            let steplength = self.factor * c.steplength;
            let argument = f + steplength * slip.own;
            let [value, slope] = c.resolvent(self.law, steplength, self.rise, slip.pair, argument);
            [f - value, slope]
        });
        let graph: Vec<[f64; 2]> = graph.collect();
        let stresses: Vec<f64> = graph.iter().map(|[r, _]| self.scale * r).collect();
        evaluation.norm = evaluation.norm.hypot(norm(&stresses));
        Iterate {
            size: norm(self.dual.multipliers(&unknowns)),
            evaluation,
            point: GraphPoint {
                unknowns,
                coefficients,
                slips,
                graph,
            },
        }
    }

    /// 𝓕⁻¹ = Σ w/f on the panes, with the law's own value at nodes that keep their slip, `[n_friction_panes]`.
    fn pane_inverse(&self, coefficients: &[f64]) -> Vec<[f64; 2]> {
        let mut nodal = self.law.at_nodes(&self.free_slips);
        for (c, f) in self.coefficients.iter().zip(coefficients) {
            c.axes().for_each(|k| nodal[c.node][k] = *f);
        }
        let inverse = |pane: usize| {
            let nodes = self.laws.average.entries(pane);
            nodes.fold([0.0; 2], |sum, (node, w)| {
                [0, 1].map(|k| sum[k] + w / nodal[node][k])
            })
        };
        (0..self.law.n_panes()).map(inverse).collect()
    }

    /// R' bordered by ∂R/∂f and by the rows of the graph, both as stresses, column-major; only coefficients with Φ' > 0 are in it.
    fn bordered_matrix(
        &self,
        Iterate {
            point, evaluation, ..
        }: &Iterate<GraphPoint>,
        bordering: &[usize],
        by_coefficient: &[Vec<(usize, f64)>],
    ) -> Vec<f64> {
        let n = point.unknowns.len();
        let size = n + bordering.len();
        let derivative = self.map(Vec::new()).derivative(evaluation);
        let mut matrix = vec![0.0; size * size];
        let columns = matrix.chunks_exact_mut(size);
        for (column, from) in columns.zip(derivative.chunks_exact(n)) {
            column[..n].copy_from_slice(from);
        }
        for (b, &k) in bordering.iter().enumerate() {
            let (c, slip, [_, slope]) = (&self.coefficients[k], &point.slips[k], point.graph[k]);
            for (row, by) in &by_coefficient[k] {
                matrix[(n + b) * size + row] = by / self.scale;
            }
            matrix[(n + b) * size + n + b] = 1.0 - slope;
            let by_slip = self.scale * slope * self.factor * c.steplength;
            for j in 0..n {
                matrix[j * size + n + b] = -by_slip * self.slip_change(c.node, slip, j);
            }
        }
        matrix
    }

    /// The natural map with given 𝓕⁻¹ on the panes.
    fn map(&self, inverse: Vec<[f64; 2]>) -> NaturalMap<'_> {
        let bound = Bound::Coulomb(self.laws, self.law);
        let mut map = NaturalMap::with_steplengths(self.dual, bound, self.steplengths.to_vec());
        map.conditions.constant_inverse = Some(inverse);
        map
    }

    /// The slips of the coefficients at x.
    fn slips(&self, unknowns: &[f64]) -> Vec<Slip> {
        let displacement = self.dual.tangential_displacement(unknowns);
        let pairs = slips(self.laws.previous.as_ref(), &displacement);
        let signs = slip_signs(self.laws.previous.as_ref(), &displacement);
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

    /// ∂R/∂f of each coefficient, the rows that are not zero.
    fn by_coefficients(&self, at: &Iterate<GraphPoint>) -> Vec<Vec<(usize, f64)>> {
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
                    let f = at.point.coefficients[k];
                    // a = g/q with q = Σ w/f: ∂a/∂f = a w / (q f²).
                    let grows = |axis: usize| {
                        pane.ellipse.semi_axes[axis] * weight / (pane.inverse[axis] * f * f)
                    };
                    let changes = [0, 1].map(|row| {
                        let axes = self.coefficients[k].axes();
                        -axes
                            .map(|axis| by_axes[row][axis] * grows(axis))
                            .sum::<f64>()
                    });
                    columns[k].extend(pair.into_iter().zip(changes));
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
            (Some(motion), Some(equilibrium), _) => {
                let slip = equilibrium.coupling.slip[motion][node];
                by[0] * slip[0] + by[1] * slip[1]
            }
            _ => 0.0,
        }
    }
}

/// c = 1/(C g) of every contact node in 1/m, with the means of compliance and pressure of the bonded face over the panes around it; `None`
/// of a node that is held, or belongs to no pane, and keeps its slip.
fn steplengths_of_nodes(
    dual: &ExplicitDual,
    laws: &PaneLaws,
    law: &CoulombLaw,
    bonded: &[f64],
) -> Option<Vec<Option<f64>>> {
    let compliance = dual.compliance.as_ref()?;
    let (normal, _) = dual.layout.split(bonded);
    let pressed = normal.iter().take(law.n_panes()).map(|l| l.max(0.0));
    let pressure: Vec<f64> = pressed.collect();
    let least = LEAST_PRESSURE * pressure.iter().sum::<f64>() / pressure.len().max(1) as f64;
    // Weights, and sums of pressure and compliance with these.
    let mut sums = vec![[0.0; 3]; law.n_nodes()];
    for (pane, g) in pressure.iter().enumerate() {
        let pair = dual.layout.tangential(pane)?;
        for (node, w) in laws.average.entries(pane) {
            let own = [0, 1].map(|k| compliance.column(pair[k])[2 * node + k]);
            let terms = [w, w * g, w * 0.5 * (own[0] + own[1])];
            sums[node]
                .iter_mut()
                .zip(terms)
                .for_each(|(sum, t)| *sum += t);
        }
    }
    let steplength = |[weight, pressure, compliance]: [f64; 3]| {
        let (pressure, compliance) = (pressure / weight, compliance / weight);
        (compliance > 0.0).then(|| (compliance * pressure.max(least)).recip())
    };
    Some(sums.into_iter().map(steplength).collect())
}
