//! Solutions at one value of the parameter, by deflated Newton's method from many starts, and the half paths that begin at solutions.

use super::{
    corrector::{Along, last_axis},
    equations::PieceEquations,
    kink::{HalfPath, REACHED},
    law_piece::LawPieces,
    point::FamilyMember,
};
use contact3d::{
    ProblemError,
    linalg::{DenseLu, difference, dot, norm},
    scene::InvalidValue,
    solver::{NaturalMap, Status},
};

/// Most steps from one start, and halvings of one step.
const MOST_STEPS: usize = 60;
const MOST_HALVINGS: usize = 8;

/// Multipliers this near, relative to Λ, are one.
pub(super) const SAME: f64 = 1e-6;

/// Operations that all starts may take, some ten seconds, and those that a step from a start takes beside n³ for n unknowns.
const SEARCH_OPERATIONS: f64 = 4e10;
const STEP_OPERATIONS: f64 = 1e5;

/// The least number of starts, whatever they cost, and how many there are before a search may end early.
const LEAST_STARTS: usize = 8;
const FIRST_STARTS: usize = 64;

impl PieceEquations<'_> {
    /// The solutions at s, beside known ones, to which Newton's method and the deflated one lead: from the face that is open, glued,
    /// pressed, and from states of panes at random, others in every round. Whether there are more is not known.
    pub(super) fn solutions_at(
        &self,
        s: f64,
        known: &[Vec<f64>],
        round: usize,
    ) -> Result<Vec<Vec<f64>>, ProblemError> {
        let member = self.family.member(s)?;
        let mut known: Vec<Vec<f64>> = known.iter().map(|point| self.multiplier(point)).collect();
        let mut reached = vec![0; known.len()];
        let n_known = known.len();
        let cost = MOST_STEPS as f64 * ((member.dual.dimension() as f64).powi(3) + STEP_OPERATIONS);
        let most = LEAST_STARTS.max((SEARCH_OPERATIONS / cost) as usize);
        let starts = Starts::new(&member, round);
        member.natural_map(|map| {
            for (number, start) in starts.take(most).enumerate() {
                for deflated in [false, true] {
                    let apart: &[Vec<f64>] = if deflated { &known } else { &[] };
                    let Some(multiplier) = self.newton(map, start.clone(), apart) else {
                        continue;
                    };
                    let near = |other: &Vec<f64>| {
                        norm(&difference(other, &multiplier)) <= SAME * self.stress
                    };
                    let place = known.iter().position(near).unwrap_or(known.len());
                    if place == known.len() {
                        known.push(multiplier);
                        reached.push(0);
                    }
                    reached[place] += usize::from(!deflated);
                }
                // A search ends once every solution was reached from this many starts. One that fewer starts lead to than any of those
                // found may still be missing.
                let is_usual = |count: &usize| *count >= 4;
                if number + 1 >= FIRST_STARTS && !known.is_empty() && reached.iter().all(is_usual) {
                    break;
                }
            }
        });
        let point = |multiplier: &Vec<f64>| {
            let scaled = multiplier.iter().map(|l| l / self.stress);
            scaled.chain([s]).collect()
        };
        Ok(known[n_known..].iter().map(point).collect())
    }

    /// Newton's method on the natural map, kept away from known solutions by deflation: M(λ) R(λ) with
    /// M = Π (Λ²/‖λ − λ_k‖² + 1) has the same other zeros, and its Newton step is the plain one times a number (P. Farrell, Á. Birkisson,
    /// S. Funke, SIAM J. Sci. Comput. 37 (2015) A2026).
    fn newton(
        &self,
        map: &NaturalMap<'_>,
        start: Vec<f64>,
        known: &[Vec<f64>],
    ) -> Option<Vec<f64>> {
        let factor = |multiplier: &[f64]| -> f64 {
            let terms = known.iter().map(|other| {
                let distance = norm(&difference(multiplier, other)) / self.stress;
                1.0 + distance.powi(-2)
            });
            terms.product()
        };
        let mut multiplier = start;
        let mut at = map.evaluate(&multiplier);
        for _ in 0..MOST_STEPS {
            // ‖R‖ / ‖λ‖ of a solution, measured by local stiffness.
            if at.norm == 0.0 || at.norm <= 1e-10 * norm(&multiplier) {
                return Some(multiplier);
            }
            let (step, _) = map.newton_step(&at)?;
            let along: f64 = known
                .iter()
                .map(|other| {
                    let offset = difference(&multiplier, other);
                    let square = dot(&offset, &offset) / self.stress.powi(2);
                    let forward = dot(&offset, &step) / self.stress.powi(2);
                    -2.0 * forward / (square * (1.0 + square))
                })
                .sum();
            let scale = (1.0 - along).recip();
            if !scale.is_finite() {
                return None;
            }
            let size = factor(&multiplier) * at.norm;
            let mut share = 1.0;
            for halving in 0..=MOST_HALVINGS {
                let moved = multiplier.iter().zip(&step);
                let next: Vec<f64> = moved.map(|(l, d)| l + share * scale * d).collect();
                let there = map.evaluate(&next);
                let falls = factor(&next) * there.norm < size;
                if falls || halving == MOST_HALVINGS {
                    (multiplier, at) = (next, there);
                    break;
                }
                share *= 0.5;
            }
            if !at.norm.is_finite() {
                return None;
            }
        }
        None
    }
}

/// Multipliers from which solutions are searched for: of a face that is open, glued, pressed, then of states of panes at random.
struct Starts<'a> {
    member: &'a FamilyMember,
    law: LawPieces<'a>,
    /// The largest displacement of a pane of the body without contact, in m.
    displacement: f64,
    random: PseudoRandom,
    number: usize,
}

/// Slips at random, as shares of the displacement without contact, in decades.
const SLIP_DECADES: [f64; 2] = [-2.5, 0.5];

impl<'a> Starts<'a> {
    fn new(member: &'a FamilyMember, round: usize) -> Self {
        let (dual, area) = (&member.dual, &member.surface().pane_area);
        let displacements = dual.rhs.iter().enumerate();
        let displacements = displacements.map(|(i, h)| h.abs() / area[dual.layout.pane_of(i)]);
        Self {
            member,
            law: LawPieces::new(member),
            displacement: displacements.fold(0.0, f64::max),
            random: PseudoRandom::new(round),
            number: 0,
        }
    }

    /// What the face carries where panes are open, stick, or slip by a given way: S λ = h − a u on the closed ones.
    fn at_random(&mut self) -> Vec<f64> {
        let member = self.member;
        let (dual, area) = (&member.dual, &member.surface().pane_area);
        let mut rhs = dual.rhs.clone();
        let mut closed = Vec::new();
        for pane in 0..dual.n_panes() {
            let state = self.random.below(3);
            let slip = self.slip();
            if state == 0 {
                continue;
            }
            closed.push(dual.layout.normal(pane));
            let Some(pair) = dual.layout.tangential(pane) else {
                continue;
            };
            closed.extend(pair);
            if state == 1 {
                pair.iter()
                    .zip(slip)
                    .for_each(|(&j, u)| rhs[j] -= area[pane] * u);
            }
        }
        closed.retain(|&j| dual.diagonal(j) > 0.0);
        let columns = closed
            .iter()
            .flat_map(|&j| closed.iter().map(move |&i| (i, j)));
        let matrix: Vec<f64> = columns.map(|(i, j)| dual.column(j)[i]).collect();
        let mut solved: Vec<f64> = closed.iter().map(|&j| rhs[j]).collect();
        if let Some(lu) = DenseLu::new(&matrix, closed.len()) {
            lu.solve(&mut solved);
        }
        let mut start = vec![0.0; dual.dimension()];
        closed
            .iter()
            .zip(solved)
            .for_each(|(&j, value)| start[j] = value);
        start
    }

    /// A slip in m: half of them of any size, the others on the segments of the law, which may be narrow.
    fn slip(&mut self) -> [f64; 2] {
        let along = self.random.direction();
        let [low, high] = SLIP_DECADES;
        let decade = low + (high - low) * self.random.share();
        if self.random.below(2) == 0 {
            return along.map(|e| self.displacement * 10_f64.powf(decade) * e);
        }
        let knots = self.law.knots_along();
        let sizes = knots.map(|knots| {
            let ends = [
                &[0.0],
                knots.as_slice(),
                &[self
                    .displacement
                    .max(2.0 * knots.last().copied().unwrap_or(0.0))],
            ]
            .concat();
            let segment = self.random.below(ends.len() as u64 - 1);
            let share = self.random.share();
            ends[segment] + share * (ends[segment + 1] - ends[segment])
        });
        if self.law.is_radial() {
            along.map(|e| sizes[0] * e)
        } else {
            [0, 1].map(|axis| sizes[axis].copysign(along[axis]))
        }
    }
}

impl Iterator for Starts<'_> {
    type Item = Vec<f64>;

    fn next(&mut self) -> Option<Vec<f64>> {
        let (dual, local) = (&self.member.dual, &self.member.local);
        self.number += 1;
        Some(match self.number {
            1 => vec![0.0; dual.dimension()],
            2 => local.bonded(&dual.rhs),
            3 => local.bilateral_frictionless(&dual.rhs),
            _ => self.at_random(),
        })
    }
}

/// Numbers without a pattern, the same on every machine: G. Marsaglia's xorshift, *J. Stat. Softw.* 8 (2003) 14.
struct PseudoRandom(u64);

impl PseudoRandom {
    fn new(round: usize) -> Self {
        Self(0x9E37_79B9_7F4A_7C15 ^ (round as u64) << 32)
    }

    fn below(&mut self, bound: u64) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from((self.0 >> 33) % bound).unwrap_or(0)
    }

    /// A number from 0 to 1.
    fn share(&mut self) -> f64 {
        self.below(1 << 30) as f64 / f64::from(1 << 30)
    }

    /// cos and sin of an angle, by arithmetic alone: the nearest point of the unit circle to one in the unit disk.
    fn direction(&mut self) -> [f64; 2] {
        loop {
            let [x, y] = [2.0 * self.share() - 1.0, 2.0 * self.share() - 1.0];
            let length = x.hypot(y);
            if length <= 1.0 && length > 0.1 {
                return [x / length, y / length];
            }
        }
    }
}

/// Places from which a path is followed both ways where the start of the range is no regular point.
const INSIDE: [f64; 3] = [1e-3, 1e-2, 0.1];

/// Half paths from the solver's answer at the start of the range, or, where no path can be told there, from one a little inside.
pub(super) fn solver_rays(equations: &PieceEquations<'_>) -> Result<Vec<HalfPath>, ProblemError> {
    let mut last = Status::Converged;
    for s in [0.0].into_iter().chain(INSIDE) {
        let family = equations.family;
        let problem = family.problem_at(family.range.value(s))?;
        let solution = problem.solve(&problem.scene().solve)?;
        last = solution.status;
        if !solution.status.is_solved() {
            continue;
        }
        let scaled = solution.multiplier.iter().map(|l| l / equations.stress);
        let point: Vec<f64> = scaled.chain([s]).collect();
        let rays = rays_from(equations, &point)?;
        if !rays.is_empty() {
            return Ok(rays);
        }
    }
    Err(InvalidValue {
        key: equations.family.range.key.clone(),
        expected: "a solution near the start of the range, from which a path leads".into(),
        found: format!("status {} there", last.word()),
        help: "begin at another value with --from".into(),
    }
    .into())
}

/// The half paths from a solution into the range: corrected on its piece, one at an end of the range, two inside.
pub(super) fn rays_from(
    equations: &PieceEquations<'_>,
    point: &[f64],
) -> Result<Vec<HalfPath>, ProblemError> {
    let s = point[point.len() - 1];
    let member = equations.family.member(s)?;
    let piece = equations.piece_of(&member, point);
    let up = last_axis(point.len());
    let fixed = Along::Plane(&up, s);
    let corrected = equations.correct(&piece, point.to_vec(), &up, fixed)?;
    let Some(state) = corrected else {
        return Ok(Vec::new());
    };
    let mut reached = state.distances(equations, &piece);
    reached.retain(|distance| distance.value <= REACHED);
    let inward = |rate: f64| rate > 0.0 && s < 1.0 || rate < 0.0 && s > 0.0;
    let mut rays = if reached.is_empty() {
        let mut rays = Vec::new();
        for forward in [true, false] {
            if let Some(mut state) = equations.state_at(&piece, &state.point, &up)? {
                if !forward {
                    state.turn();
                }
                rays.push(HalfPath {
                    state,
                    piece: piece.clone(),
                    is_inside: true,
                });
            }
        }
        rays
    } else {
        equations.rays(&piece, &state, &reached)?
    };
    rays.retain(|ray| inward(ray.state.parameter_rate()));
    Ok(rays)
}
