//! What successive approximations really do: their rate, the set they stay in, and quotients of the mapping.

use super::{
    bound::{NormConstants, Radii},
    contraction::LocalContraction,
    level::TheoryProblem,
    trace::norm_by,
};
use contact3d::{
    contact::FrictionField,
    linalg::{difference, norm},
    solver::{CoulombState, NewtonStatus, PaneLaws, evaluate_mapping_at},
};

/// Size of the disturbance of the solution whose growth is observed, relative to it: rounding is 1e-5 of it. Kinks of steep laws may lie
/// within a nanometre of the slip, and a larger disturbance would be seen across them.
const DISTURBANCE: f64 = 1e-8;

/// Steps whose geometric mean is a rate, blocks of them at least and at most, and how far the logarithms of single factors may
/// be from their mean in the last, and the mean of the last from that of a block half as far. Mirror-image panes make pairs of eigenvalues
/// a few per cent apart, of which the smaller one may show for a hundred steps, with a drift as small as this. Pairs of complex eigenvalues keep them apart; half of 300 steps leaves less than a per cent
/// of that.
const BLOCK: usize = 10;
const LEAST_BLOCKS: usize = 10;
const MOST_BLOCKS: usize = 30;
const STEADY: f64 = 1e-3;
const DRIFT: f64 = 1e-4;

/// A disturbance that shrinks faster than this leaves only rounding.
const VANISHED: f64 = 1e-4;

/// Steps of Algorithm 4.1 from zero with exact inner problems, and the change at which it ends.
const MOST_STEPS: usize = 200;
const CONVERGED: f64 = 1e-11;

/// Pairs of states whose images are compared, over so many decades of distance and of size.
const PAIRS: usize = 24;
const DECADES: f64 = 4.0;

/// What was observed of Ψ on one mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Observed {
    /// Geometric mean of the last ten factors by which a small disturbance of the solution shrinks in each application of Ψ
    /// with exact inner problems; of the last half of 300 where these do not settle.
    pub rate: f64,
    /// Applications of Ψ that it took to settle.
    pub rate_steps: usize,
    /// Steps of Algorithm 4.1 from zero, with exact inner problems, to a change of 1e-11; `None` where 200 do not suffice.
    pub steps_from_zero: Option<usize>,
    /// The largest ‖φ‖/R₁ and ‖λ_ν‖_*/R₂ of all values of Ψ, for each norm of displacements: HKL Lemma 3.3 says at most 1.
    pub lemma: Vec<[f64; 2]>,
    /// The largest quotient ‖Ψ(x) − Ψ(y)‖/‖x − y‖ of sampled pairs in 𝒞(R₁, R₂), in the weighted norm that suits Ψ′ at the
    /// solution ([`super::PartNorms::weight`]), for each norm of displacements.
    pub quotient: Vec<f64>,
    /// Values of Ψ that were checked, and those whose inner problem was not solved.
    pub evaluations: usize,
    /// Frozen problems without an accurate solution; they are left out.
    pub unsolved: usize,
}

/// Ψ on one mesh.
struct Mapping<'a> {
    problem: &'a TheoryProblem,
    laws: PaneLaws,
    radii: Vec<Radii>,
    /// Weights of the slip beside the pressure.
    weights: Vec<f64>,
}

/// A point (φ, λ_ν) of Y^h × Y^h × L^H.
#[derive(Clone)]
struct MappingPoint {
    slip: Vec<[f64; 2]>,
    pressure: Vec<f64>,
}

impl TheoryProblem {
    /// Observes Ψ around a solution, from zero, and at sampled states.
    pub(super) fn observe(
        &self,
        norms: &[NormConstants],
        local: Option<&LocalContraction>,
        solution: &[f64],
    ) -> Observed {
        let mapping = Mapping {
            problem: self,
            laws: self.contact().laws(),
            radii: norms.iter().map(|norm| norm.radii).collect(),
            weights: match local {
                None => vec![0.0; norms.len()],
                Some(local) => local.parts.iter().map(|parts| parts.weight()).collect(),
            },
        };
        let mut observed = Observed {
            lemma: vec![[0.0; 2]; norms.len()],
            quotient: vec![0.0; norms.len()],
            ..Observed::default()
        };
        mapping.start_at_zero(&mut observed);
        mapping.disturb(solution, &mut observed);
        mapping.sample(solution, &mut observed);
        observed
    }
}

impl Mapping<'_> {
    /// Ψ at a state, from a multiplier nearby; notes what Lemma 3.3 says of it.
    fn image(&self, at: &MappingPoint, near: &[f64], observed: &mut Observed) -> Option<Vec<f64>> {
        let (problem, law) = (self.problem, self.problem.law());
        let state = CoulombState {
            slip_bound: law.slip_bounds(&at.pressure, |l| l.max(0.0)),
            friction: FrictionField::new(law, &self.laws.average, &at.slip),
        };
        let (dual, local) = (problem.dual(), &problem.local);
        let value = evaluate_mapping_at(dual, local, &self.laws, &state, near);
        if !matches!(
            value.status,
            NewtonStatus::Converged | NewtonStatus::RoundingLimit
        ) {
            observed.unsolved += 1;
            return None;
        }
        observed.evaluations += 1;
        let image = self.state(&value.multiplier);
        for (k, radii) in self.radii.iter().enumerate() {
            let [slip, pressure] = self.norms_of(k, &image);
            let lemma = &mut observed.lemma[k];
            *lemma = [
                lemma[0].max(slip / radii.slip),
                lemma[1].max(pressure / radii.pressure),
            ];
        }
        Some(value.multiplier)
    }

    /// (φ, λ_ν) of a multiplier.
    fn state(&self, multiplier: &[f64]) -> MappingPoint {
        let tangential = self.problem.tangential(multiplier);
        MappingPoint {
            slip: self.laws.slip.operator.slip(&tangential),
            pressure: multiplier[..self.problem.rows.len()].to_vec(),
        }
    }

    /// ‖φ‖_0 and ‖λ_ν‖_*.
    fn norms_of(&self, norm: usize, state: &MappingPoint) -> [f64; 2] {
        let (problem, mass) = (self.problem, &self.problem.forms.mass);
        [
            problem.face.norm_of_pair(mass, &state.slip),
            norm_by(&problem.pressure[norm].0, &state.pressure),
        ]
    }

    /// Algorithm 4.1 with exact inner problems.
    fn start_at_zero(&self, observed: &mut Observed) {
        let mut multiplier = vec![0.0; self.problem.dual().dimension()];
        let mut state = MappingPoint {
            slip: vec![[0.0; 2]; self.problem.face.points.len()],
            pressure: vec![0.0; self.problem.rows.len()],
        };
        for step in 1..=MOST_STEPS {
            let Some(next) = self.image(&state, &multiplier, observed) else {
                return;
            };
            let change = norm(&difference(&next, &multiplier));
            state = self.state(&next);
            multiplier = next;
            if change <= CONVERGED * norm(&multiplier) {
                observed.steps_from_zero = Some(step);
                return;
            }
        }
    }

    /// The rate at which a disturbance shrinks.
    fn disturb(&self, solution: &[f64], observed: &mut Observed) {
        let size = DISTURBANCE * norm(solution);
        let mut random = Random::new(1);
        let first = solution.iter().map(|l| l * random.signed());
        let mut direction: Vec<f64> = first.collect();
        let mut logarithms: Vec<f64> = Vec::new();
        for block in 1..=MOST_BLOCKS {
            for _ in 0..BLOCK {
                let length = norm(&direction);
                let pairs = solution.iter().zip(&direction);
                let disturbed: Vec<f64> = pairs.map(|(l, d)| l + size * d / length).collect();
                let Some(image) = self.image(&self.state(&disturbed), solution, observed) else {
                    return;
                };
                direction = difference(&image, solution);
                let factor = norm(&direction) / size;
                observed.rate_steps += 1;
                if factor < VANISHED {
                    observed.rate = factor;
                    return;
                }
                logarithms.push(factor.ln());
            }
            let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
            let done = logarithms.len();
            let last = mean(&logarithms[done - BLOCK..]);
            let steady = |factor: &f64| (factor - last).abs() < STEADY;
            if block >= LEAST_BLOCKS
                && (last - mean(&logarithms[done / 2 - BLOCK..done / 2])).abs() < DRIFT
                && logarithms[done - BLOCK..].iter().all(steady)
            {
                observed.rate = last.exp();
                return;
            }
            observed.rate = mean(&logarithms[done / 2..]).exp();
        }
    }

    /// Quotients of pairs in the smallest of the sets 𝒞(R₁, R₂), from the size of the solution up to that of the set.
    fn sample(&self, solution: &[f64], observed: &mut Observed) {
        let mut random = Random::new(2);
        let centre = self.state(solution);
        let [slip, pressure] = self.norms_of(0, &centre);
        let room = self.radii.iter().enumerate().map(|(k, radii)| {
            let [_, own] = self.norms_of(k, &centre);
            (radii.slip / slip.max(f64::MIN_POSITIVE))
                .min(radii.pressure / own.max(f64::MIN_POSITIVE))
        });
        let room = room.fold(f64::INFINITY, f64::min);
        if !(room.is_finite() && pressure > 0.0) {
            return;
        }
        for _ in 0..PAIRS {
            let size = room.powf(random.share() - 0.5).min(room);
            let first = random.around(&centre, size, 1.0);
            let spread = 10f64.powf(-DECADES * random.share());
            let second = random.around(&first, 1.0, spread);
            let images = [&first, &second].map(|state| self.image(state, solution, observed));
            let [Some(one), Some(two)] = images else {
                continue;
            };
            let apart = between(&first, &second);
            let images_apart = between(&self.state(&one), &self.state(&two));
            for k in 0..self.radii.len() {
                let [before, after] = [&apart, &images_apart].map(|difference| {
                    let [slip, pressure] = self.norms_of(k, difference);
                    self.weights[k] * slip + pressure
                });
                if before > 0.0 {
                    observed.quotient[k] = observed.quotient[k].max(after / before);
                }
            }
        }
    }
}

fn between(first: &MappingPoint, second: &MappingPoint) -> MappingPoint {
    let slips = first.slip.iter().zip(&second.slip);
    MappingPoint {
        slip: slips.map(|(a, b)| [a[0] - b[0], a[1] - b[1]]).collect(),
        pressure: difference(&first.pressure, &second.pressure),
    }
}

/// Numbers that look random and are the same on every machine (G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014: SplitMix64).
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// In [0, 1).
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// In [−1, 1).
    fn signed(&mut self) -> f64 {
        2.0 * self.share() - 1.0
    }

    /// A state of `size` times another, each value moved by up to `spread` of the largest one and kept non-negative.
    fn around(&mut self, centre: &MappingPoint, size: f64, spread: f64) -> MappingPoint {
        let largest_slip = centre.slip.iter().flatten().copied().fold(0.0, f64::max);
        let largest = centre.pressure.iter().copied().fold(0.0, f64::max);
        let mut moved = |value: f64, scale: f64| {
            (size * (value + 0.5 * spread * scale * self.signed())).max(0.0)
        };
        let slips = centre.slip.iter();
        MappingPoint {
            slip: slips.map(|u| u.map(|v| moved(v, largest_slip))).collect(),
            pressure: centre.pressure.iter().map(|v| moved(*v, largest)).collect(),
        }
    }
}
