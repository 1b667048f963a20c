//! All solutions of small planar problems with constant coefficients, state by state.

use faer::{Mat, prelude::Solve};

use super::member::Member;

/// Most panes whose 4^m states are tried.
const MOST_PANES: usize = 6;

/// Inequalities hold to this, relative to stresses or displacements: rounding of small systems.
const SLACK: f64 = 1e-10;

/// What a pane does in a planar problem.
#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Open,
    Stick,
    /// The tangential stress is F λ_ν with this sign.
    Slip(i8),
}

const STATES: [State; 4] = [State::Open, State::Stick, State::Slip(1), State::Slip(-1)];

/// All solutions of a problem whose panes move in a plane, under a law that does not follow the slip: each of the 4^m states is a
/// linear system, and a solution where its inequalities hold. `None` where the problem is not of that kind, or too large.
///
/// Planar means that one component of every tangential pair is held: its row of S vanishes.
pub(super) fn planar_solutions(member: &Member) -> Option<Vec<Vec<f64>>> {
    let layout = member.dual.layout;
    let panes = layout.n_panes();
    let law = member.law();
    let is_capped = law.slip_bound(0, f64::INFINITY).is_finite();
    if panes > MOST_PANES || law.depends_on_slip() || is_capped {
        return None;
    }
    let moves = |j: usize| member.dual.column(j)[j] > 0.0;
    let axis = |pane: usize| {
        let pair = layout.tangential(pane)?;
        match pair.map(moves) {
            [true, false] => Some((pair[0], 0)),
            [false, true] => Some((pair[1], 1)),
            _ => None,
        }
    };
    let axes: Vec<(usize, usize)> = (0..panes).map(axis).collect::<Option<_>>()?;
    if !layout.normals().all(moves) {
        return None;
    }
    let nodal = law.at_nodes(&[]);
    let friction: Vec<f64> = (0..panes)
        .map(|pane| {
            let weights = member.surface().pane_weights(pane);
            let inverse: f64 = weights.map(|(node, w)| w / nodal[node][axes[pane].1]).sum();
            inverse.recip()
        })
        .collect();
    let states = (0..4_usize.pow(panes as u32)).map(|code| {
        let mut code = code;
        let digits = (0..panes).map(|_| {
            let digit = code % 4;
            code /= 4;
            STATES[digit]
        });
        digits.collect::<Vec<State>>()
    });
    let mut found: Vec<Vec<f64>> = Vec::new();
    for states in states {
        let Some(multiplier) = solution_of(member, &states, &axes, &friction) else {
            continue;
        };
        let size = crate::linalg::norm(&multiplier);
        let same = |known: &Vec<f64>| {
            crate::linalg::norm(&crate::linalg::difference(known, &multiplier)) <= 1e-8 * size
        };
        if !found.iter().any(same) {
            found.push(multiplier);
        }
    }
    Some(found)
}

/// The multipliers of one choice of states; `None` where its system is singular or its inequalities do not hold.
fn solution_of(
    member: &Member,
    states: &[State],
    axes: &[(usize, usize)],
    friction: &[f64],
) -> Option<Vec<f64>> {
    let dual = &member.dual;
    let m = states.len();
    let unknowns: Vec<usize> = (0..m).chain(axes.iter().map(|(j, _)| *j)).collect();
    let rho = member.steplengths();
    let mut matrix = Mat::from_fn(2 * m, 2 * m, |i, j| {
        rho[unknowns[i]] * dual.column(unknowns[j])[unknowns[i]]
    });
    let mut rhs = Mat::from_fn(2 * m, 1, |i, _| rho[unknowns[i]] * dual.rhs[unknowns[i]]);
    let mut replace = |row: usize, entries: &[(usize, f64)]| {
        (0..2 * m).for_each(|j| matrix[(row, j)] = 0.0);
        entries
            .iter()
            .for_each(|(j, value)| matrix[(row, *j)] = *value);
        rhs[(row, 0)] = 0.0;
    };
    for (pane, state) in states.iter().enumerate() {
        match state {
            State::Open => {
                replace(pane, &[(pane, 1.0)]);
                replace(m + pane, &[(m + pane, 1.0)]);
            }
            State::Stick => {}
            State::Slip(sign) => {
                let slope = -f64::from(*sign) * friction[pane];
                replace(m + pane, &[(m + pane, 1.0), (pane, slope)]);
            }
        }
    }
    matrix.partial_piv_lu().solve_in_place(rhs.as_mut());
    let mut multiplier = vec![0.0; dual.dimension()];
    for (row, j) in unknowns.iter().enumerate() {
        multiplier[*j] = rhs[(row, 0)];
    }
    if !multiplier.iter().all(|l| l.is_finite()) {
        return None;
    }
    let gradient = dual.gradient(&multiplier);
    let largest = |values: &[f64]| values.iter().fold(0.0, |m, v| f64::max(m, v.abs()));
    let slack = SLACK * largest(&multiplier);
    let way = SLACK * largest(&dual.rhs);
    let holds = |(pane, state): (usize, &State)| {
        let (normal, tangential) = (multiplier[pane], multiplier[axes[pane].0]);
        let moved = -gradient[axes[pane].0];
        match state {
            State::Open => gradient[pane] >= -way,
            State::Stick => normal >= -slack && tangential.abs() <= friction[pane] * normal + slack,
            State::Slip(sign) => normal >= -slack && f64::from(*sign) * moved >= -way,
        }
    };
    states.iter().enumerate().all(holds).then_some(multiplier)
}
