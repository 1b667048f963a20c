//! GPCG on curved faces.

use super::{InnerOutcome, active_face::ActiveFace};
use crate::{
    dual::DualOperator,
    linalg::{add_scaled, difference, dot, norm},
    solver::{FeasibleSet, StepCounts, tolerances::rounding_of_products},
};

/// GPCG: minimises ½ λᵀSλ − λᵀh over bounds and ellipses by gradient projection and conjugate
/// gradients on faces (Moré and Toraldo, SIAM J. Optim. 1 (1991) 93), here on curved faces.
///
/// Spectral projected gradient steps (Birgin, Martínez and Raydan, SIAM J. Optim. 10 (2000) 1196)
/// find the face. When it stays, a Newton step on it is computed by conjugate gradients with the
/// Hessian of the energy along the face, which contains the curvature of the ellipses, and brought
/// back to the set by projection; it is taken only if the energy does not grow. So the theory of
/// the projected gradient method holds: the iterates converge to the minimiser from anywhere, and
/// where no block is weakly active, fast on its face.
///
/// In [`StepCounts`], `conjugate_gradient` are steps on faces, `expansion` trials of a step along a
/// face, `proportioning` projected gradient steps; each costs one application of S, the start
/// another.
#[derive(Debug, Clone, Copy)]
pub struct Gpcg {
    /// Steplength ᾱ ∈ (0, 2/‖S‖) that the reduced gradient is measured with, in Pa/m³.
    pub steplength: f64,
    /// Give up after this many applications of S.
    pub max_applications: usize,
}

/// Energies that a projected gradient step is compared with, as Birgin, Martínez and Raydan do; and steps after which a face is tried
/// although it still changes, for in fewer no energy is forgotten.
const DECREASE_WINDOW: usize = 10;

/// Share of the linear decrease that a step must reach below the largest of these energies, theirs too.
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// Largest spectral steplength in units of ᾱ: directions that S resists 10⁴ times less are left to Newton steps on the face.
const LONGEST_STEP: f64 = 1e4;

/// Loosest and tightest relative residual of a Newton step: half a digit while the face changes, three on one that stays, where the next
/// step finds what the curvature of the ellipses left out.
const FORCING: [f64; 2] = [0.3, 1e-3];

/// Lengths of a Newton step that are tried, one application of S each: a shorter one is no longer than projected gradient steps.
const TRIALS: [f64; 3] = [1.0, 0.25, 0.0625];

/// An admissible multiplier with its gradient r = Sλ − h.
struct MultiplierIterate {
    multiplier: Vec<f64>,
    gradient: Vec<f64>,
}

impl MultiplierIterate {
    /// q(other) − q(self), from the gradients: exact up to rounding of the difference itself.
    fn energy_change_to(&self, other: &Self) -> f64 {
        let points = self.multiplier.iter().zip(&other.multiplier);
        let gradients = self.gradient.iter().zip(&other.gradient);
        let terms = points.zip(gradients);
        terms.map(|((a, b), (r, s))| 0.5 * (b - a) * (r + s)).sum()
    }

    /// The rounding error of q: n ε_M Σ |λ_i r_i|.
    fn energy_rounding(&self) -> f64 {
        let terms = self.multiplier.iter().zip(&self.gradient);
        let size: f64 = terms.map(|(l, r)| (l * r).abs()).sum();
        rounding_of_products(self.multiplier.len()) * size
    }
}

/// The problem at hand and what was spent on it.
struct GradientSearch<'a> {
    solver: Gpcg,
    operator: &'a mut dyn DualOperator,
    set: &'a FeasibleSet,
    first_application: usize,
    steps: StepCounts,
    /// q of the last iterates minus q of the present one.
    energies: Vec<f64>,
}

impl Gpcg {
    /// Improves an admissible `multiplier` until ‖g̃‖ ≤ `tolerance` (m³), with the reduced gradient of KPRGP.
    pub fn minimise(
        &self,
        operator: &mut dyn DualOperator,
        set: &FeasibleSet,
        multiplier: &mut [f64],
        tolerance: f64,
    ) -> InnerOutcome {
        let mut search = GradientSearch {
            solver: *self,
            first_application: operator.applications(),
            operator,
            set,
            steps: StepCounts::default(),
            energies: vec![0.0],
        };
        let start = search.at(multiplier.to_vec());
        let (iterate, reduced_gradient) = search.descend(start, tolerance);
        multiplier.copy_from_slice(&iterate.multiplier);
        InnerOutcome {
            converged: reduced_gradient <= tolerance,
            reduced_gradient,
            steps: search.steps,
        }
    }
}

impl GradientSearch<'_> {
    /// Alternates projected gradient and face steps; returns the last iterate and its ‖g̃‖.
    fn descend(&mut self, start: MultiplierIterate, tolerance: f64) -> (MultiplierIterate, f64) {
        let mut current = start;
        let mut face = ActiveFace::new(self.set, &current.multiplier, &current.gradient);
        let mut steplength = self.solver.steplength;
        let mut since_face_step = 0;
        let mut last_gradient: Option<f64> = None;
        loop {
            let reduced = self.reduced_norm(&current);
            if reduced <= tolerance || !reduced.is_finite() || self.applications_left() == 0 {
                return (current, reduced);
            }
            (current, steplength) = self.projected_gradient_step(current, steplength);
            since_face_step += 1;
            let next_face = ActiveFace::new(self.set, &current.multiplier, &current.gradient);
            let settled = next_face.same_as(&face);
            face = next_face;
            if !settled && since_face_step < DECREASE_WINDOW {
                continue;
            }
            let gradient = face.coordinates(&current.gradient);
            let size = norm(&gradient);
            let forcing = match last_gradient {
                Some(last) if settled => (size / last).clamp(FORCING[1], FORCING[0]),
                _ => FORCING[0],
            };
            last_gradient = Some(size);
            // No Newton step need come far below the tolerance.
            let target = (forcing * size).max(0.5 * tolerance);
            if size <= target || !size.is_finite() {
                continue;
            }
            since_face_step = 0;
            if let Some(next) = self.face_step(&current, &face, &gradient, target) {
                self.record(current.energy_change_to(&next), false);
                current = next;
                face = ActiveFace::new(self.set, &current.multiplier, &current.gradient);
                steplength = self.solver.steplength;
            }
        }
    }

    /// λ' = P(λ − a r), or, where this gives too little, the minimum between λ and λ'; returns the
    /// spectral steplength sᵀs / sᵀSs of the step s = λ' − λ too.
    fn projected_gradient_step(
        &mut self,
        current: MultiplierIterate,
        steplength: f64,
    ) -> (MultiplierIterate, f64) {
        self.steps.proportioning += 1;
        let mut multiplier = current.multiplier.clone();
        add_scaled(&mut multiplier, -steplength, &current.gradient);
        self.set.project(&mut multiplier);
        let mut next = self.at(multiplier);
        let step = difference(&next.multiplier, &current.multiplier);
        let change_of_gradient = difference(&next.gradient, &current.gradient);
        let curvature = dot(&step, &change_of_gradient);
        let slope = dot(&step, &current.gradient);
        let mut change = current.energy_change_to(&next);
        let largest = self.energies.iter().fold(0.0_f64, |m, e| m.max(*e));
        if change > largest + SUFFICIENT_DECREASE * slope && curvature > 0.0 {
            let length = (-slope / curvature).clamp(0.0, 1.0);
            next = current;
            add_scaled(&mut next.multiplier, length, &step);
            add_scaled(&mut next.gradient, length, &change_of_gradient);
            change = length * (slope + 0.5 * length * curvature);
        }
        self.record(change, true);
        let spectral = dot(&step, &step) / curvature;
        let [least, most] = [1.0, LONGEST_STEP].map(|k| k * self.solver.steplength);
        let usable = spectral.is_finite() && spectral > 0.0;
        let steplength = if usable {
            spectral.clamp(least, most)
        } else {
            least
        };
        (next, steplength)
    }

    /// A Newton step on the face followed by projection, at the first length at which the energy
    /// does not grow; `None` if it grows at all of them.
    ///
    /// Where the change of energy is within its rounding, ‖g̃‖ must fall as well.
    fn face_step(
        &mut self,
        current: &MultiplierIterate,
        face: &ActiveFace,
        gradient: &[f64],
        target: f64,
    ) -> Option<MultiplierIterate> {
        let most_steps = self.applications_left();
        let direction = face.newton_direction(
            self.operator,
            gradient,
            self.solver.steplength,
            target,
            most_steps,
            &mut self.steps,
        );
        let reduced = self.reduced_norm(current);
        for length in TRIALS {
            if self.applications_left() == 0 {
                return None;
            }
            self.steps.expansion += 1;
            let mut multiplier = current.multiplier.clone();
            add_scaled(&mut multiplier, length, &direction);
            self.set.project(&mut multiplier);
            let next = self.at(multiplier);
            let change = current.energy_change_to(&next);
            let rounding = next.energy_rounding();
            let lower = change <= -rounding;
            if lower || (change <= rounding && self.reduced_norm(&next) < reduced) {
                return Some(next);
            }
        }
        None
    }

    /// Makes the present energy the zero of the record; a projected gradient step adds an entry, a
    /// face step replaces the last one.
    fn record(&mut self, change: f64, entry: bool) {
        if !entry {
            self.energies.pop();
        }
        for energy in &mut self.energies {
            *energy -= change;
        }
        self.energies.push(0.0);
        if self.energies.len() > DECREASE_WINDOW {
            self.energies.remove(0);
        }
    }

    fn at(&mut self, multiplier: Vec<f64>) -> MultiplierIterate {
        MultiplierIterate {
            gradient: self.operator.gradient(&multiplier),
            multiplier,
        }
    }

    /// ‖g̃‖; NaN when the gradient is not finite.
    fn reduced_norm(&self, iterate: &MultiplierIterate) -> f64 {
        if !iterate.gradient.iter().all(|r| r.is_finite()) {
            return f64::NAN;
        }
        let steplength = self.solver.steplength;
        let (multiplier, gradient) = (&iterate.multiplier, &iterate.gradient);
        let step = self
            .set
            .projected_step(multiplier, gradient, |_| steplength);
        norm(&step) / steplength
    }

    fn applications_left(&self) -> usize {
        let used = self.operator.applications() - self.first_application;
        self.solver.max_applications.saturating_sub(used)
    }
}
