//! The rigid motion that the load drives most and contact opposes least.

use nalgebra::{DMatrix, DVector};

use crate::{contact::MultiplierLayout, dual::Balance};

/// Contact forces beyond this many times the load count as none, over the least coefficient of friction below one: a load along a
/// face takes as much pressure.
const LARGEST_FORCE: f64 = 1e4;

/// Work left over, relative to the work of the load in a motion of unit size, from which a motion is unopposed; a push that
/// exceeds a friction of F = 1e-3 by 1e-6 leaves more, and rounding less.
const LEFT_OVER: f64 = 1e-10;

/// Share of the work left over to which a motion is the one with the most of it.
const NEARLY: f64 = 1e-3;

/// Factor of the barrier's weight from one centre to the next, and most steps to a centre.
const NEXT_WEIGHT: f64 = 0.2;
const MOST_STEPS: usize = 60;

/// Half the squared Newton decrement at which a centre is found.
const CENTRED: f64 = 1e-9;

/// What a pane can oppose a motion with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PaneTerm {
    /// Pressure alone.
    Pressure,
    /// Pressure, and friction up to F₁, F₂ times the pressure.
    Cone([f64; 2]),
    /// Pressure, and friction up to the semi-axes in Pa.
    Bounded([f64; 2]),
}

/// Maximise e·y − M s − Σ |Rⁱ| ‖(a w_t1, b w_t2)‖ over motions |y| ≤ 1 and slack s ≥ 0 under w_ν + ‖F w_t‖ ≤ s on every pane, for a
/// load of unit size.
///
/// Motions are measured by what they do to the contact face (root mean square), so y has no unit. M bounds the contact force, and
/// gives the program an interior. In at most seven unknowns, a barrier method costs a few hundred passes over the panes.
pub(super) struct MotionProgram {
    /// e over its length.
    load: DVector<f64>,
    panes: Vec<Pane>,
    /// Felt motions of y, after those that supports resist.
    basis: DMatrix<f64>,
    n_resisted: usize,
    /// M.
    largest_force: f64,
}

struct Pane {
    /// Mean normal displacement.
    normal: DVector<f64>,
    friction: Opposition,
}

enum Opposition {
    None,
    /// F w_t, in the cone with w_ν.
    Cone([DVector<f64>; 2]),
    /// |Rⁱ| (a w_t1, b w_t2) over the length of e: its length is work.
    Work([DVector<f64>; 2]),
}

/// A value of the barrier function with its derivatives in (y, s).
struct Barrier {
    value: f64,
    gradient: DVector<f64>,
    hessian: DMatrix<f64>,
}

impl MotionProgram {
    /// The program of a balance; `None` where the load needs no contact force.
    pub(super) fn new(
        balance: &Balance,
        areas: &[f64],
        layout: MultiplierLayout,
        terms: Vec<PaneTerm>,
    ) -> Option<Self> {
        let n_resisted = balance.coupling.n_resisted();
        let integrals = &balance.coupling.integrals[n_resisted..];
        let n = integrals.len();
        let area: f64 = areas.iter().sum();
        let gram = DMatrix::from_fn(n, n, |p, q| {
            let terms = integrals[p].iter().zip(&integrals[q]).enumerate();
            let sum: f64 = terms
                .map(|(j, (a, b))| a * b / areas[layout.pane_of(j)])
                .sum();
            sum / area
        });
        // Columns scaled to one first: modes may differ in size.
        let scale = gram.diagonal().map(|d| d.sqrt().recip());
        let scaled = DMatrix::from_fn(n, n, |p, q| gram[(p, q)] * scale[p] * scale[q]);
        let root = scaled.cholesky()?.l().transpose().try_inverse()?;
        let basis = DMatrix::from_fn(n, n, |p, q| scale[p] * root[(p, q)]);
        let resultant = DVector::from_row_slice(&balance.resultant[n_resisted..]);
        let load = basis.transpose() * resultant;
        let size = load.norm();
        if n == 0 || size == 0.0 {
            return None;
        }
        let mean = |j: usize, factor: f64| {
            let row = DVector::from_fn(n, |p, _| integrals[p][j]);
            basis.transpose() * row * (factor / areas[layout.pane_of(j)])
        };
        let coefficients = terms.iter().flat_map(|term| match term {
            PaneTerm::Cone(f) => *f,
            PaneTerm::Pressure | PaneTerm::Bounded(_) => [1.0; 2],
        });
        let largest_force = LARGEST_FORCE / coefficients.fold(1.0, f64::min);
        let pane = |(i, term): (usize, PaneTerm)| Pane {
            normal: mean(layout.normal(i), 1.0),
            friction: match (term, layout.tangential(i)) {
                (PaneTerm::Pressure, _) | (_, None) => Opposition::None,
                (PaneTerm::Cone(f), Some([a, b])) => {
                    Opposition::Cone([mean(a, f[0]), mean(b, f[1])])
                }
                (PaneTerm::Bounded(axes), Some([a, b])) => {
                    let by = areas[i] / size;
                    Opposition::Work([mean(a, axes[0] * by), mean(b, axes[1] * by)])
                }
            },
        };
        let panes = terms.into_iter().enumerate().map(pane).collect();
        Some(Self {
            load: load / size,
            panes,
            basis,
            n_resisted,
            largest_force,
        })
    }

    /// The felt motion of unit size in which most work of the load is left over; `None` where contact opposes all.
    pub(super) fn unopposed(&self) -> Option<Vec<f64>> {
        let n = self.load.len();
        let mut at = DVector::zeros(n + 1);
        at[n] = 1.0;
        let terms = 2.0 * self.panes.len() as f64 + 3.0;
        let mut weight = self.largest_force;
        loop {
            self.centre(&mut at, weight);
            let motion = at.rows(0, n).into_owned();
            let left_over = self.left_over(&motion);
            // To the optimum.
            let gap = terms * weight;
            if gap < (NEARLY * left_over).max(0.1 * LEFT_OVER) {
                let motion = (&self.basis * motion).insert_rows(0, self.n_resisted, 0.0);
                return (left_over > LEFT_OVER).then(|| motion.iter().copied().collect());
            }
            weight *= NEXT_WEIGHT;
        }
    }

    /// The work of the load that contact forces up to M do not oppose.
    fn left_over(&self, motion: &DVector<f64>) -> f64 {
        let mut slack = 0.0_f64;
        let mut work = 0.0;
        for pane in &self.panes {
            let normal = pane.normal.dot(motion);
            let length = |rows: &[DVector<f64>; 2]| rows[0].dot(motion).hypot(rows[1].dot(motion));
            match &pane.friction {
                Opposition::None => slack = slack.max(normal),
                Opposition::Cone(rows) => slack = slack.max(normal + length(rows)),
                Opposition::Work(rows) => {
                    slack = slack.max(normal);
                    work += length(rows);
                }
            }
        }
        self.load.dot(motion) - self.largest_force * slack - work
    }

    /// Newton's method to the centre of a weight, from a point within.
    fn centre(&self, at: &mut DVector<f64>, weight: f64) {
        let Some(mut here) = self.barrier(at, weight) else {
            return;
        };
        for _ in 0..MOST_STEPS {
            let Some(factor) = scaled_cholesky(&here.hessian) else {
                return;
            };
            let step = -factor(&here.gradient);
            let decrement = -here.gradient.dot(&step);
            if decrement.is_nan() || decrement <= 2.0 * CENTRED {
                return;
            }
            let mut share = 1.0;
            loop {
                let next = &*at + &step * share;
                if let Some(there) = self.barrier(&next, weight)
                    && there.value <= here.value - 0.1 * share * decrement
                {
                    *at = next;
                    here = there;
                    break;
                }
                share *= 0.5;
                if share < 1e-10 {
                    return;
                }
            }
        }
    }

    /// The objective over the weight plus the barriers; `None` outside.
    fn barrier(&self, at: &DVector<f64>, weight: f64) -> Option<Barrier> {
        let n = self.load.len();
        let y = at.rows(0, n);
        let s = at[n];
        let ball = 1.0 - y.norm_squared();
        if ball <= 0.0 || s <= 0.0 {
            return None;
        }
        let mut out = Barrier {
            value: (self.largest_force * s - self.load.dot(&y)) / weight - ball.ln() - s.ln(),
            gradient: DVector::zeros(n + 1),
            hessian: DMatrix::zeros(n + 1, n + 1),
        };
        for p in 0..n {
            out.gradient[p] = -self.load[p] / weight + 2.0 * y[p] / ball;
            for q in 0..n {
                out.hessian[(p, q)] = 4.0 * y[p] * y[q] / (ball * ball);
            }
            out.hessian[(p, p)] += 2.0 / ball;
        }
        out.gradient[n] = self.largest_force / weight - 1.0 / s;
        out.hessian[(n, n)] = 1.0 / (s * s);
        for pane in &self.panes {
            pane.add(&y.into_owned(), s, weight, &mut out)?;
        }
        Some(out)
    }
}

impl Pane {
    fn add(&self, y: &DVector<f64>, s: f64, weight: f64, out: &mut Barrier) -> Option<()> {
        let n = y.len();
        let distance = s - self.normal.dot(y);
        match &self.friction {
            Opposition::None | Opposition::Work(_) => {
                if distance <= 0.0 {
                    return None;
                }
                let row = self.distance_row(n);
                out.value -= distance.ln();
                out.gradient.axpy(-1.0 / distance, &row, 1.0);
                out.hessian
                    .ger(1.0 / (distance * distance), &row, &row, 1.0);
            }
            Opposition::Cone(rows) => {
                let slide = [rows[0].dot(y), rows[1].dot(y)];
                let length = slide[0].hypot(slide[1]);
                let square = (distance - length) * (distance + length);
                if distance <= 0.0 || square <= 0.0 {
                    return None;
                }
                // −ln(d² − |v|²): gradient −2 (d d′ − v·v′)/q, Hessian 4 c cᵀ/q² − 2 (d′d′ᵀ − v′v′ᵀ)/q with c = d d′ − v·v′.
                let row = self.distance_row(n);
                let mut along = &row * distance;
                let wide = rows.each_ref().map(|r| r.clone().insert_row(n, 0.0));
                for (wide, slide) in wide.iter().zip(slide) {
                    along.axpy(-slide, wide, 1.0);
                }
                out.value -= square.ln();
                out.gradient.axpy(-2.0 / square, &along, 1.0);
                out.hessian
                    .ger(4.0 / (square * square), &along, &along, 1.0);
                out.hessian.ger(-2.0 / square, &row, &row, 1.0);
                for wide in &wide {
                    out.hessian.ger(2.0 / square, wide, wide, 1.0);
                }
            }
        }
        if let Opposition::Work(rows) = &self.friction {
            // The least of τ/w − ln(τ² − |v|²) over τ > |v|: τ = w + √(w² + |v|²).
            let wide = rows.each_ref().map(|r| r.clone().insert_row(n, 0.0));
            let slide = [rows[0].dot(y), rows[1].dot(y)];
            let square = slide[0].powi(2) + slide[1].powi(2);
            let root = (weight * weight + square).sqrt();
            let bound = weight + root;
            // τ² − |v|² = 2 w τ.
            out.value += bound / weight - (2.0 * weight * bound).ln();
            let along = &wide[0] * slide[0] + &wide[1] * slide[1];
            out.gradient.axpy(1.0 / (weight * bound), &along, 1.0);
            for wide in &wide {
                out.hessian.ger(1.0 / (weight * bound), wide, wide, 1.0);
            }
            let turn = -1.0 / (weight * bound * bound * root);
            out.hessian.ger(turn, &along, &along, 1.0);
        }
        Some(())
    }

    /// ∂(s − w_ν)/∂(y, s).
    fn distance_row(&self, n: usize) -> DVector<f64> {
        let mut row = -self.normal.clone().insert_row(n, 0.0);
        row[n] = 1.0;
        row
    }
}

/// Solves with a positive definite matrix whose rows differ in size.
fn scaled_cholesky(
    matrix: &DMatrix<f64>,
) -> Option<impl Fn(&DVector<f64>) -> DVector<f64> + use<>> {
    let scale = matrix.diagonal().map(|d| d.sqrt().recip());
    let n = scale.len();
    let scaled = DMatrix::from_fn(n, n, |p, q| matrix[(p, q)] * scale[p] * scale[q]);
    let factor = scaled.cholesky()?;
    Some(move |rhs: &DVector<f64>| {
        let solved = factor.solve(&rhs.component_mul(&scale));
        solved.component_mul(&scale)
    })
}
