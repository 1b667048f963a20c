//! Enclosures against plain numbers, and one node against its closed form.

use super::{
    interval::Interval,
    search::search,
    small_problem::{NodeLaw, SmallProblem, StraightLines},
    states::{Chart, PaneCase, choices},
    system::System,
};

fn own_node(pane: usize) -> Vec<(usize, f64)> {
    vec![(pane, 1.0)]
}

/// Both nodes under each of two panes.
fn shared_nodes(pane: usize) -> Vec<(usize, f64)> {
    vec![(pane, 0.7), (1 - pane, 0.3)]
}

const SLIDES: PaneCase = PaneCase::Slip(Chart::Half { negative: false });

/// Panes of area 1 with one law, S = 1 with 0.3 and −0.2 beside the diagonal, or as given.
fn problem(
    operator: &dyn Fn(usize, usize) -> f64,
    rhs: &[f64],
    law: &NodeLaw,
    follows_slip: bool,
    weights: &dyn Fn(usize) -> Vec<(usize, f64)>,
) -> SmallProblem {
    let panes = rhs.len() / 3;
    let followed = if follows_slip { panes } else { 0 };
    let slips = (0..followed).map(|node| {
        [1, 2].map(|c| {
            let i = 3 * node + c;
            (rhs[i], (0..rhs.len()).map(|j| operator(i, j)).collect())
        })
    });
    let slips: Vec<_> = slips.collect();
    let nodes = (0..panes).map(weights).collect();
    let laws = vec![law.clone(); panes];
    SmallProblem::new(operator, rhs, &slips, nodes, laws).expect("panes that move")
}

fn coupled(i: usize, j: usize) -> f64 {
    match i.abs_diff(j) {
        0 => 1.0,
        1 => 0.3,
        2 => -0.2,
        _ => 0.0,
    }
}

fn lines(knots: &[(f64, f64)]) -> StraightLines {
    StraightLines::new(knots.iter().copied())
}

#[test]
fn results_of_operations_lie_in_their_intervals() {
    let (a, b) = (Interval::new(-0.7, 0.3), Interval::new(0.1, 1.9));
    for k in 1..10_u8 {
        let share = f64::from(k) / 10.0;
        let (x, y) = (a.low + share * a.width(), b.low + (1.0 - share) * b.width());
        let all = [
            (a + b, x + y),
            (a - b, x - y),
            (a * b, x * y),
            (a.square(), x * x),
            (b.sqrt(), y.sqrt()),
            (b.recip(), y.recip()),
            (a.over(b).expect("no zero"), x / y),
        ];
        let holds = |(i, value): &(Interval, f64)| Interval::point(*value).is_inside(*i);
        assert!(all.iter().all(holds), "{all:?}");
    }
    assert_eq!(b.over(a), None);
}

/// A proof of uniqueness rests on the derivatives: secants between two points of a box lie in them.
#[test]
fn derivatives_hold_the_secants_of_the_equations() {
    let ramp = lines(&[(0.0, 1.5), (0.2, 1.5), (0.9, 0.4)]);
    let other = lines(&[(0.0, 0.7), (0.1, 0.9), (1.4, 0.3)]);
    let isotropic = NodeLaw::Isotropic(ramp.clone());
    let orthotropic = NodeLaw::Orthotropic([ramp, other]);
    let weights = [own_node as fn(usize) -> _, shared_nodes];
    let kinds = [&isotropic, &orthotropic].into_iter();
    let kinds = kinds.flat_map(|law| weights.map(|weights| (law, weights)));
    let kinds = kinds.flat_map(|(law, weights)| [false, true].map(|f| (law, weights, f)));
    for (law, weights, follows_slip) in kinds {
        let rhs = [0.4, 1.0, -0.5, 0.2, -0.8, 0.6];
        let problem = problem(&coupled, &rhs, law, follows_slip, &weights);
        let system = System::new(&problem, vec![SLIDES, SLIDES]).expect("definite");
        let n = system.whole.len();
        let value = |at: &[Interval]| system.equations(&system.slides(at));
        let start: Vec<f64> = system.whole.iter().map(|x| x.middle()).collect();
        for j in 0..n {
            let step = 0.3 * system.whole[j].width();
            let mut at: Vec<Interval> = start.iter().map(|x| Interval::point(*x)).collect();
            let here = value(&at);
            at[j] = Interval::point(start[j] + step);
            let there = value(&at);
            at[j] = Interval::new(start[j], start[j] + step);
            let over = value(&at);
            for i in 0..n {
                let secant = (there[i].value.middle() - here[i].value.middle()) / step;
                // What S is uncertain by, over a step.
                let near = Interval::around(secant, 1e-10);
                assert!(near.meet(over[i].slope[j]).is_some(), "{i} {j}");
            }
        }
    }
}

/// S_νν = S_tt = 1, S_νt = 0.6, h = (−0.2, −1): the sticking node has |λ_t| = 2.2 λ_ν, and three solutions exist from F = 2.2 on.
#[test]
fn one_node_has_its_three_solutions() {
    let operator = |i: usize, j: usize| match (i, j) {
        (0, 1) | (1, 0) => 0.6,
        _ if i == j => 1.0,
        _ => 0.0,
    };
    let rhs = [-0.2, -1.0, 0.0];
    let born = (-1.0 + 0.6 * 0.2_f64).abs() / (-0.2 + 0.6);
    for (friction, count) in [(0.99 * born, 1), (1.01 * born, 3)] {
        let law = NodeLaw::Isotropic(lines(&[(0.0, friction)]));
        let problem = problem(&operator, &rhs, &law, false, &own_node);
        let both = [false, true].map(|negative| PaneCase::Slip(Chart::Half { negative }));
        let states = [vec![PaneCase::Open, PaneCase::Stick, both[0], both[1]]];
        let found: usize = choices(&states)
            .map(|states| {
                let outcome = search(&System::new(&problem, states).expect("definite"), 10_000);
                assert_eq!(outcome.undecided, None);
                outcome.solutions.len()
            })
            .sum();
        assert_eq!(found, count, "F = {friction}");
    }
}
