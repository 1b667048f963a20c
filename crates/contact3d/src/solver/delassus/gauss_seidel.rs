//! Nonlinear Gauss–Seidel: every contact in turn is solved exactly, with the forces of the others as they are.
//!
//! (F. Jourdan, P. Alart, M. Jean, *Comput. Methods Appl. Mech. Eng.* 155 (1998) 31.) Each sweep costs one product with W and needs no
//! factor, so it is the quickest way where few bodies carry many contacts. Nothing proves that it converges, and where forces
//! have a long way to go from contact to contact it takes very many sweeps: so its progress is watched.

use nalgebra::{Matrix3, Vector3};

use super::{
    Candidate,
    scaled::{MatrixForm, Scaled},
};
use crate::contact::MultiplierLayout;

/// Sweeps between two looks at the error.
const SWEEPS: usize = 10;

/// Most sweeps that may be needed at the rate so far, where the matrix is dense: Newton's method takes no longer than so many
/// products; and where it is sparse.
const MOST_DENSE: f64 = 200.0;
const MOST_SPARSE: f64 = 2000.0;

/// Most sweeps where nothing else is tried.
const MOST_ALONE: usize = 20_000;

/// Sweeps from zero forces until the error is within the tolerance: as long as it will be soon or, `alone`, all that there are.
pub(super) fn solve(
    scaled: &Scaled<'_>,
    form: MatrixForm,
    tolerance: f64,
    alone: bool,
) -> Candidate {
    let mut found = Candidate::zero(scaled);
    let contacts = contacts(scaled);
    let most = match form {
        MatrixForm::Dense => MOST_DENSE,
        MatrixForm::Sparse => MOST_SPARSE,
    };
    let mut error = f64::INFINITY;
    while error > tolerance {
        let mut state = State {
            scaled,
            velocity: velocity(scaled, &found.multiplier),
            multiplier: found.multiplier,
        };
        for _ in 0..SWEEPS {
            contacts.iter().for_each(|contact| state.relax(contact));
        }
        found.multiplier = state.multiplier;
        found.outer_steps += SWEEPS;
        found.applications += SWEEPS + 1;
        let next = scaled.worst_error(&found.multiplier);
        // The first sweeps find which contacts carry.
        let is_first = error == f64::INFINITY;
        let blocks = (tolerance / next).ln() / (next / error).ln();
        let needed = found.outer_steps as f64 + SWEEPS as f64 * blocks;
        let will_end = if alone {
            next.is_finite() && found.outer_steps < MOST_ALONE
        } else {
            next < error && (is_first || needed <= most)
        };
        if next > tolerance && !will_end {
            break;
        }
        error = next;
    }
    found
}

/// A contact: its places among the components, and its block of W.
struct Contact {
    normal: usize,
    pair: Option<[usize; 2]>,
    block: Matrix3<f64>,
}

fn contacts(scaled: &Scaled<'_>) -> Vec<Contact> {
    let layout: MultiplierLayout = scaled.layout;
    let contact = |pane: usize| {
        let normal = layout.normal(pane);
        let pair = layout.tangential(pane);
        let places = pair.map(|[first, second]| [normal, first, second]);
        Contact {
            normal,
            pair,
            block: places.map_or_else(Matrix3::zeros, |places| {
                Matrix3::from_fn(|i, j| entry(scaled, places[i], places[j]))
            }),
        }
    };
    (0..layout.n_panes()).map(contact).collect()
}

fn entry(scaled: &Scaled<'_>, row: usize, column: usize) -> f64 {
    let (rows, values) = scaled.operator.column(column);
    rows.binary_search(&row).map_or(0.0, |at| values[at])
}

/// W' λ + q'.
fn velocity(scaled: &Scaled<'_>, multiplier: &[f64]) -> Vec<f64> {
    let mut velocity = vec![0.0; multiplier.len()];
    scaled.operator.mul_transposed(multiplier, &mut velocity);
    for (u, h) in velocity.iter_mut().zip(&scaled.rhs) {
        *u -= h;
    }
    velocity
}

/// Forces and the velocities that belong to them.
struct State<'a> {
    scaled: &'a Scaled<'a>,
    multiplier: Vec<f64>,
    velocity: Vec<f64>,
}

impl State<'_> {
    /// Changes a component of the forces.
    fn set(&mut self, place: usize, value: f64) {
        let change = value - self.multiplier[place];
        if change == 0.0 {
            return;
        }
        self.multiplier[place] = value;
        let (rows, values) = self.scaled.operator.column(place);
        for (&row, entry) in rows.iter().zip(values) {
            self.velocity[row] += change * entry;
        }
    }

    /// Solves one contact.
    fn relax(&mut self, contact: &Contact) {
        let normal = contact.normal;
        let Some([first, second]) = contact.pair else {
            let diagonal = self.scaled.operator.diagonal(normal);
            let free = self.velocity[normal] - diagonal * self.multiplier[normal];
            let force = if diagonal > 0.0 {
                -free / diagonal
            } else {
                0.0
            };
            return self.set(normal, force.max(0.0));
        };
        let places = [normal, first, second];
        let force = Vector3::from(places.map(|place| self.multiplier[place]));
        let velocity = Vector3::from(places.map(|place| self.velocity[place]));
        let solved = solved(&contact.block, velocity - contact.block * force);
        for (place, value) in places.into_iter().zip(&solved) {
            self.set(place, *value);
        }
    }
}

/// Halvings of the interval of α, and growths of its end: all digits of a number.
const MOST_STEPS: usize = 200;

/// r with u = W r + q for one contact with the cone ‖r_T‖ ≤ r_N.
///
/// It is zero where q_N ≥ 0, sticks where −W⁻¹q lies in the cone, and slides else: u_T = −α r_T makes r(α) = −(W + α diag(0, 1, 1))⁻¹q, and
/// ‖r_T(α)‖ − r_N(α) has a zero, since it is positive for α = 0 and negative for large α.
fn solved(block: &Matrix3<f64>, free: Vector3<f64>) -> Vector3<f64> {
    if free[0] >= 0.0 {
        return Vector3::zeros();
    }
    let sliding = Matrix3::from_diagonal(&Vector3::new(0.0, 1.0, 1.0));
    let force = |alpha: f64| Some(-((block + sliding * alpha).try_inverse()? * free));
    let excess = |r: &Vector3<f64>| r[1].hypot(r[2]) - r[0];
    if let Some(stick) = force(0.0).filter(|stick| excess(stick) <= 0.0) {
        return stick;
    }
    let is_inside = |alpha: f64| force(alpha).is_some_and(|r| excess(&r) <= 0.0);
    let (mut low, mut high) = (0.0, block.trace());
    let mut steps = 0..MOST_STEPS;
    while !is_inside(high) {
        low = high;
        high *= 4.0;
        if steps.next().is_none() {
            return Vector3::zeros();
        }
    }
    for _ in steps {
        let middle = f64::midpoint(low, high);
        if middle <= low || middle >= high {
            break;
        }
        if is_inside(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    let Some(mut slip) = force(high) else {
        return Vector3::zeros();
    };
    let share = slip[0] / slip[1].hypot(slip[2]);
    slip[1] *= share;
    slip[2] *= share;
    slip
}
