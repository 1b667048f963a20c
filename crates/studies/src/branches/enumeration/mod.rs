//! All solutions of a contact problem of a few panes, with the proof that there are no others.
//!
//! A solution has a state of every pane: open, stick, or slip in one of two half circles of directions (one of two directions where the
//! pane moves along one axis). For each choice of states the equations are solved in intervals that hold S, h and the law with
//! what rounding may have changed: boxes of pressures, or of sizes of slips where the law follows those, and of directions of slips are
//! cut until each part has no solution, since an equation or an inequality fails all over it, or exactly one, by a theorem on Newton's method in intervals (R. E. Moore,
//! R. B. Kearfott, M. J. Cloud, *Introduction to Interval Analysis*, SIAM 2009, ch. 8). No start is guessed, so nothing can be missed.

mod interval;
mod search;
mod small_problem;
mod states;
mod system;
#[cfg(test)]
mod tests;

use std::fmt;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use self::{
    interval::Interval,
    search::{StateSolutions, search},
    small_problem::{NodeLaw, SmallProblem, StraightLines, UNCERTAIN},
    states::{Chart, PaneCase, choices},
    system::System,
};
use super::point::FamilyMember;
use contact3d::{
    contact::SlipOperator,
    scene::{Coefficient, FrictionLaw},
};

/// Most panes, and most of them with an angle of slip: 4^m choices of states, boxes of two or more sides for each angle.
const MOST_PANES: usize = 6;
const MOST_ANGLES: usize = 3;

/// Most boxes for one choice of states, some seconds of work; where few choices need more, this many of them get up to the second
/// number, some minutes.
const FIRST_BOXES: usize = 400_000;
const MOST_BOXES: usize = 2_000_000;
const MOST_LONG_CHOICES: usize = 4;

/// The proof that the solutions at one value of the parameter are all. It holds for every problem whose S, h and slips differ from those
/// computed by a share of `uncertainty`, in arithmetic that is rounded outwards.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct CompletenessProof {
    /// How many solutions there are.
    pub solutions: usize,
    /// Choices of states that were tried.
    pub states: usize,
    /// Boxes that were shown to have no solution or exactly one.
    pub boxes: usize,
    /// The least of what is left, in any solution, of an inequality of its states, without unit.
    pub margin: f64,
    /// The least |det| of the equations of slipping panes at a solution, over the product of the lengths of their rows.
    pub determinant: f64,
    /// The width of the widest interval in which a multiplier of a solution lies, over the largest multiplier.
    pub width: f64,
    /// What S, h and slips may be wrong by, as a share of their size.
    pub uncertainty: f64,
}

/// Why there is no proof that the solutions at one value of the parameter are all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Undecided {
    /// Nobody asked for all solutions.
    NotAsked,
    /// States were not enumerated: there are too many panes, or a law that is capped or not made of straight lines.
    NotCovered,
    /// They were, and a solution lies at the end of its states, at a kink.
    AtEndOfStates,
    /// They were, and a box too narrow to be cut has a solution that is not regular, or several.
    Irregular,
    /// They were, with so many boxes that some were left.
    TooManyBoxes,
}

impl fmt::Display for Undecided {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let enumerated = "states were enumerated, without a proof: ";
        match self {
            Self::NotAsked => f.write_str("those on the paths; --all searches for others"),
            Self::NotCovered => write!(
                f,
                "states were not enumerated, which takes at most {MOST_PANES} panes, {MOST_ANGLES} of them with slips in a plane, and a law of straight lines without a cap"
            ),
            Self::AtEndOfStates => write!(
                f,
                "{enumerated}a solution lies at the end of its states, at a kink; move the end of the range a little with --from or --to"
            ),
            Self::Irregular => write!(
                f,
                "{enumerated}a solution is not regular or two are too near to be told apart; move the end of the range a little with --from or --to"
            ),
            Self::TooManyBoxes => write!(
                f,
                "{enumerated}a choice of states takes more than {MOST_BOXES} boxes"
            ),
        }
    }
}

/// The proof that solutions are all, or why there is none.
pub(super) type Certificate = Result<CompletenessProof, Undecided>;

/// All solutions of a problem with few panes, under uncapped laws that are constant or made of straight lines, as λ in Pa; `None` for
/// other problems.
pub(super) fn enumerated(member: &FamilyMember) -> Option<(Vec<Vec<f64>>, Certificate)> {
    let problem = small_problem(member)?;
    let moves = |pane: usize| [1, 2].map(|c| problem.moves[3 * pane + c]);
    let panes = 0..problem.n_panes();
    let angles = panes.clone().filter(|pane| moves(*pane) == [true; 2]);
    if angles.count() > MOST_ANGLES {
        return None;
    }
    let of_panes = panes.map(|pane| {
        let slips = Chart::of(moves(pane)).into_iter().map(PaneCase::Slip);
        let still = [PaneCase::Open, PaneCase::Stick].into_iter();
        still.chain(slips).collect()
    });
    let of_panes: Vec<Vec<PaneCase>> = of_panes.collect();
    let all: Vec<Vec<PaneCase>> = choices(&of_panes).collect();
    let searched = |states: &[PaneCase], most_boxes| match System::new(&problem, states.to_vec()) {
        Some(system) => search(&system, most_boxes),
        None => StateSolutions {
            undecided: Some(Undecided::Irregular),
            ..StateSolutions::default()
        },
    };
    let mut outcomes: Vec<StateSolutions> = all
        .par_iter()
        .map(|states| searched(states, FIRST_BOXES))
        .collect();
    let is_long = |outcome: &StateSolutions| outcome.undecided == Some(Undecided::TooManyBoxes);
    if outcomes.iter().filter(|outcome| is_long(outcome)).count() <= MOST_LONG_CHOICES {
        let pairs = outcomes.par_iter_mut().zip(&all);
        pairs
            .filter(|(outcome, _)| is_long(outcome))
            .for_each(|(outcome, states)| *outcome = searched(states, MOST_BOXES));
    }
    Some(gathered(&problem, member, &outcomes))
}

fn gathered(
    problem: &SmallProblem,
    member: &FamilyMember,
    outcomes: &[StateSolutions],
) -> (Vec<Vec<f64>>, Certificate) {
    let solutions = outcomes.iter().flat_map(|outcome| &outcome.solutions);
    let certain: Vec<_> = solutions.filter(|solution| solution.margin > 0.0).collect();
    let sizes = |of: fn(Interval) -> f64| {
        let all = certain.iter().flat_map(|solution| &solution.multiplier);
        all.fold(0.0, |most, x| f64::max(most, of(*x)))
    };
    let largest = sizes(Interval::size).max(f64::MIN_POSITIVE);
    let least = |of: &dyn Fn(&search::ProvedSolution) -> f64| {
        let all = certain.iter().map(|solution| of(solution));
        all.fold(f64::INFINITY, f64::min)
    };
    let undecided = outcomes.iter().filter_map(|outcome| outcome.undecided);
    let undecided = undecided.max();
    let order = components(member);
    let multipliers = certain.iter().map(|solution| {
        let mut multiplier = vec![0.0; member.dual.dimension()];
        for (i, value) in solution.multiplier.iter().enumerate() {
            multiplier[order[i]] = problem.stress[i / 3] * value.middle();
        }
        multiplier
    });
    let certificate = undecided.map_or(Ok(()), Err).map(|()| CompletenessProof {
        solutions: certain.len(),
        states: outcomes.len(),
        boxes: outcomes.iter().map(|outcome| outcome.boxes).sum(),
        margin: least(&|solution| solution.margin),
        determinant: least(&|solution| solution.determinant),
        width: sizes(Interval::width) / largest,
        uncertainty: UNCERTAIN,
    });
    (multipliers.collect(), certificate)
}

/// Where ν, t1, t2 of pane after pane are among the multipliers.
fn components(member: &FamilyMember) -> Vec<usize> {
    let layout = member.dual.layout;
    let panes = (0..layout.n_panes()).flat_map(|pane| {
        let pair = layout.tangential(pane).into_iter().flatten();
        std::iter::once(layout.normal(pane)).chain(pair)
    });
    panes.collect()
}

fn small_problem(member: &FamilyMember) -> Option<SmallProblem> {
    let (dual, law, surface) = (&member.dual, member.law(), member.surface());
    let layout = dual.layout;
    let panes = layout.n_panes();
    let is_capped = law.slip_bound(0, f64::INFINITY).is_finite();
    if panes > MOST_PANES || layout.n_pairs() < panes || is_capped {
        return None;
    }
    let compliance = dual.compliance.as_ref().filter(|_| law.depends_on_slip());
    let is_nodal = matches!(member.interface.slip.operator, SlipOperator::Lagrange);
    if law.depends_on_slip() && !(is_nodal && compliance.is_some()) {
        return None;
    }
    let order = components(member);
    let slips = compliance.iter().flat_map(|compliance| {
        let nodes = compliance.slip_free.iter().enumerate();
        nodes.map(|(node, free)| {
            [0, 1].map(|axis| {
                let by = order.iter().map(|&j| compliance.column(j)[2 * node + axis]);
                (free[axis], by.collect())
            })
        })
    });
    let slips: Vec<[(f64, Vec<f64>); 2]> = slips.collect();
    let laws = (0..surface.nodes.len()).map(|node| node_law(member, node));
    let nodes = (0..panes).map(|pane| surface.pane_weights(pane).collect());
    let rhs: Vec<f64> = order.iter().map(|&i| dual.rhs[i]).collect();
    SmallProblem::new(
        &|i, j| dual.column(order[j])[order[i]],
        &rhs,
        &slips,
        nodes.collect(),
        laws.collect::<Option<_>>()?,
    )
}

/// The law at a contact node; `None` where it is not made of straight lines.
fn node_law(member: &FamilyMember, node: usize) -> Option<NodeLaw> {
    let law = member.law();
    let lines = |coefficient: &Coefficient, axis: usize| {
        let value = |slip: f64| {
            let mut pair = [0.0; 2];
            pair[axis] = slip;
            (slip, law.evaluate(node, pair)[axis])
        };
        let mut knots = match coefficient {
            Coefficient::Ramp(_) | Coefficient::Table(_) => coefficient.kinks(0)[0].clone(),
            other if !other.depends_on_slip() => Vec::new(),
            _ => return None,
        };
        knots.retain(|knot| *knot > 0.0);
        knots.dedup();
        Some(StraightLines::new(
            std::iter::once(0.0).chain(knots).map(value),
        ))
    };
    match law.only().law() {
        FrictionLaw::Isotropic(one) => Some(NodeLaw::Isotropic(lines(one, 0)?)),
        FrictionLaw::Orthotropic(pair) => Some(NodeLaw::Orthotropic([
            lines(&pair[0], 0)?,
            lines(&pair[1], 1)?,
        ])),
    }
}
