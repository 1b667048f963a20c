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
    coefficient::{NodeCoefficient, ResolventForm},
    iteration::{NewtonModel, StoppingRule, iterate},
    natural_map::NaturalMap,
};
use crate::{
    contact::{CoulombLaw, LawBounds, slip_signs, slips},
    dual::{ExplicitDual, LocalStiffness},
    linalg::{DenseLu, norm},
    scene::FrictionLaw,
    solver::{
        NewtonStep, PaneLaws,
        conditions::{Bound, Evaluation},
        tolerances::{NEWTON_MAX_STEPS, ROUNDING_STALL_STEPS, ZONES_FOUND},
    },
};

/// Factors of c that are tried, one start each: c → ∞ is Newton's method in λ alone.
const RESOLVENT_FACTORS: [f64; 6] = [1.0, 100.0, 0.1, 1e4, 0.01, 10.0];

/// ‖R‖ / ‖λ‖ that is asked for: slips are then known to a millionth of the narrowest rise met.
const GRAPH_TOLERANCE: f64 = 1e-12;

/// Least pressure at a node beside the mean one, so that c stays finite where the bonded face lifts off.
const LEAST_PRESSURE: f64 = 0.1;

/// Slips of a solution over the largest of those without contact forces, at most.
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

/// The graph of a law with a form of its resolvents.
struct GraphModel<'g> {
    graph: &'g FrictionGraph<'g>,
    form: ResolventForm,
    evaluations: usize,
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
        let direction = self.step(from)?;
        let n = direction.len();
        Some((direction, n))
    }

    fn trial(&mut self, from: &GraphIterate, direction: &[f64], length: f64) -> GraphIterate {
        let shifted = |from: &[f64], by: &[f64]| -> Vec<f64> {
            from.iter().zip(by).map(|(x, d)| x + length * d).collect()
        };
        let (direction, change) = direction.split_at(from.unknowns.len());
        let mut coefficients = shifted(&from.coefficients, change);
        for (f, c) in coefficients.iter_mut().zip(&self.graph.coefficients) {
            *f = f.clamp(c.range[0], c.range[1]);
        }
        self.evaluate(shifted(&from.unknowns, direction), coefficients)
    }

    fn is_at_rounding(&self, best: &GraphIterate) -> bool {
        // Rounding of a steep law forbids less.
        self.relative(best) <= ZONES_FOUND
    }
}

impl GraphModel<'_> {
    fn evaluate(&mut self, unknowns: Vec<f64>, coefficients: Vec<f64>) -> GraphIterate {
        self.evaluations += 1;
        let (graph, form) = (self.graph, self.form);
        let mut nodal = graph.law.at_nodes(&graph.free_slips);
        for (c, f) in graph.coefficients.iter().zip(&coefficients) {
            c.axes().for_each(|k| nodal[c.node][k] = *f);
        }
        let inverse = |pane: usize| {
            let nodes = graph.laws.average.entries(pane);
            nodes.fold([0.0; 2], |sum, (node, w)| {
                [0, 1].map(|k| sum[k] + w / nodal[node][k])
            })
        };
        let inverse = (0..graph.law.n_panes()).map(inverse).collect();
        let map = graph.map(inverse);
        let mut evaluation = map.evaluate(&unknowns);
        let slips = graph.slips(&unknowns);
        let points = graph.coefficients.iter().zip(&coefficients).zip(&slips);
        let residuals: Vec<[f64; 2]> = points
            .map(|((c, f), slip)| {
                let argument = f + form.factor * c.steplength * slip.own;
                let [value, slope] = c.resolvent(graph.law, form, slip.pair, argument);
                [f - value, slope]
            })
            .collect();
        let graph_norm = norm(
            &residuals
                .iter()
                .map(|[r, _]| graph.scale * r)
                .collect::<Vec<_>>(),
        );
        evaluation.norm = evaluation.norm.hypot(graph_norm);
        GraphIterate {
            unknowns,
            coefficients,
            evaluation,
            slips,
            graph: residuals,
        }
    }

    /// Changes of x and f, one behind the other, with R'd + ∂R/∂f δf = −R and (1 − Φ') δf − Φ' c δs = −(f − Φ).
    fn step(&self, at: &GraphIterate) -> Option<Vec<f64>> {
        let (graph, form) = (self.graph, self.form);
        let n = at.unknowns.len();
        let bordering: Vec<usize> = (0..at.graph.len())
            .filter(|&k| at.graph[k][1] > 0.0)
            .collect();
        let size = n + bordering.len();
        let map = graph.map(Vec::new());
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
        let by_coefficient = graph.by_coefficients(at);
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
                matrix[(n + b) * size + row] = by / graph.scale;
            }
            matrix[(n + b) * size + n + b] = 1.0 - slope;
            rhs[n + b] = -graph.scale * residual;
            let (c, slip) = (&graph.coefficients[k], &at.slips[k]);
            let by_slip = graph.scale * slope * form.factor * c.steplength;
            for j in 0..n {
                matrix[j * size + n + b] = -by_slip * graph.slip_change(c.node, slip, j);
            }
        }
        DenseLu::new(&matrix, size)?.solve(&mut rhs);
        for (b, &k) in bordering.iter().enumerate() {
            change[k] = rhs[n + b] / graph.scale;
        }
        rhs.truncate(n);
        rhs.extend(change);
        rhs.iter().all(|v| v.is_finite()).then_some(rhs)
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
        let compliance = dual.compliance.as_ref()?;
        let bonded = local.bonded_start(dual);
        let (normal, _) = dual.layout.split(dual.multipliers(&bonded));
        let pressed = normal.iter().take(law.n_panes()).map(|l| l.max(0.0));
        let pressure: Vec<f64> = pressed.collect();
        let least = LEAST_PRESSURE * pressure.iter().sum::<f64>() / pressure.len().max(1) as f64;
        // Means over the panes around each node.
        let mut weight = vec![0.0; law.n_nodes()];
        let (mut at_node, mut compliance_at) = (weight.clone(), weight.clone());
        for (pane, g) in pressure.iter().enumerate() {
            let pair = dual.layout.tangential(pane)?;
            for (node, w) in laws.average.entries(pane) {
                let own = [0, 1].map(|k| compliance.column(pair[k])[2 * node + k]);
                weight[node] += w;
                at_node[node] += w * g;
                compliance_at[node] += w * 0.5 * (own[0] + own[1]);
            }
        }
        let unloaded = dual.tangential_displacement(&dual.unknowns(&[]));
        let free_slips = slips(laws.previous.as_ref(), &unloaded);
        let largest_free_slip = free_slips
            .iter()
            .flatten()
            .fold(0.0_f64, |most, s| most.max(*s));
        let mut coefficients = Vec::new();
        for face in law.faces() {
            let axes: &[Option<usize>] = match face.law() {
                FrictionLaw::Isotropic(_) => &[None],
                FrictionLaw::Orthotropic(_) => &[Some(0), Some(1)],
            };
            let bounds = LawBounds::new(face, SLIP_MARGIN * largest_free_slip);
            let range = [bounds.smallest, bounds.largest].map(|extreme| extreme.value);
            for node in face.nodes() {
                let compliance_at = compliance_at[node] / weight[node];
                // A node that is held, or belongs to no pane, keeps its slip.
                if compliance_at.is_nan() || compliance_at <= 0.0 {
                    continue;
                }
                let g = (at_node[node] / weight[node]).max(least);
                for &axis in axes {
                    coefficients.push(NodeCoefficient {
                        node,
                        axis,
                        steplength: (compliance_at * g).recip(),
                        range,
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
            law,
            steplengths: &local.stiffness,
            coefficients,
            scale,
            free_slips,
            largest_free_slip,
        })
    }

    /// A solution from λ = 0 and the coefficients without slip, by the first steplength that leads to one; else from wide rises of F.
    pub(in crate::solver) fn solve(
        &self,
        observe: &mut dyn FnMut(usize, &NewtonStep),
    ) -> NewtonSolution {
        let from_rest = |factor| self.newton(ResolventForm { factor, rise: 0.0 }, None);
        let tries = RESOLVENT_FACTORS.into_iter().map(from_rest);
        let mut found = NewtonSolution::not_found(self.dual);
        for next in tries.chain(std::iter::once_with(|| self.followed_from_wide_rises())) {
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

    /// Follows the solutions from rises of F at τ = 0 that are as wide as the largest free slip to those of the law at τ = 1, narrowed
    /// geometrically, each from the one before, by steps in τ that double after a success and halve after a failure.
    ///
    /// The path may end before τ = 1 where solutions vanish in pairs; the reason to stop is then that of the last failure.
    fn followed_from_wide_rises(&self) -> NewtonSolution {
        let solve = |tau: f64, start: Option<&[f64]>| {
            let rise = match tau < 1.0 {
                true => self.largest_free_slip * 10_f64.powf(-NARROWED_DECADES * tau),
                false => 0.0,
            };
            self.newton(ResolventForm { factor: 1.0, rise }, start)
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

    /// Damped Newton steps for (x, f), from a start or from λ = 0; the multiplier of the result is (x, f).
    fn newton(&self, form: ResolventForm, start: Option<&[f64]>) -> NewtonSolution {
        let n = self.dual.n_unknowns();
        let (unknowns, coefficients) = match start {
            Some(start) => (start[..n].to_vec(), start[n..].to_vec()),
            None => {
                let at_rest = |c: &NodeCoefficient| c.value(self.law, [0.0; 2], 0.0);
                (
                    self.dual.unknowns(&[]),
                    self.coefficients.iter().map(at_rest).collect(),
                )
            }
        };
        let mut model = GraphModel {
            graph: self,
            form,
            evaluations: 0,
        };
        let first = model.evaluate(unknowns, coefficients);
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
            stop: found.stop,
            residual: model.relative(&last),
            unknowns: [last.unknowns, last.coefficients].concat(),
            history: found.history,
            evaluations: model.evaluations,
        }
    }

    /// The natural map with given 𝓕⁻¹ on the panes.
    fn map(&self, inverse: Vec<[f64; 2]>) -> NaturalMap<'_> {
        let bound = Bound::Coulomb(self.laws, self.law);
        let mut map = NaturalMap::with_steplengths(self.dual, bound, self.steplengths.to_vec());
        map.conditions.fix_coefficients(inverse);
        map
    }

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
