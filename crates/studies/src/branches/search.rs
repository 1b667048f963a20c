//! Solutions at one value of the parameter, by deflated Newton's method from many starts, and the half paths that begin at solutions.

use super::{
    corrector::{Along, last_axis},
    enumeration::{Certificate, Undecided, enumerated},
    equations::PieceEquations,
    kink::{HalfPath, REACHED},
    point::FamilyMember,
};
use contact3d::{
    ProblemError,
    linalg::{difference, dot, norm},
    scene::InvalidValue,
    solver::{NaturalMap, Status},
};

/// ‖R‖ / ‖λ‖ of a solution, measured by local stiffness.
const SOLVED: f64 = 1e-10;

/// Most steps from one start, and halvings of one step.
const MOST_STEPS: usize = 60;
const MOST_HALVINGS: usize = 8;

/// Multipliers this near, relative to Λ, are one.
pub(super) const SAME: f64 = 1e-6;

/// Operations that all starts may take, as dense factorisations of n³ operations with `MOST_STEPS` each; and the least and
/// largest number of starts.
const OPERATIONS: f64 = 4e10;
const STARTS: [f64; 2] = [6.0, 256.0];

impl PieceEquations<'_> {
    /// The solutions at s, beside known ones: all of them where the states can be enumerated, else those that deflated Newton's
    /// method finds from the face that is open, glued, pressed, and from scattered zones and directions, others in every round. With the
    /// proof that they are all.
    pub(super) fn solutions_at(
        &self,
        s: f64,
        known: &[Vec<f64>],
        round: usize,
    ) -> Result<(Vec<Vec<f64>>, Certificate), ProblemError> {
        let member = self.family.member(s)?;
        let point = |multiplier: &[f64]| {
            let scaled = multiplier.iter().map(|l| l / self.stress);
            scaled.chain([s]).collect::<Vec<f64>>()
        };
        let all = enumerated(&member);
        let (multipliers, certificate) = all.unwrap_or((Vec::new(), Err(Undecided::NotCovered)));
        let mut found: Vec<Vec<f64>> = multipliers.iter().map(|one| point(one)).collect();
        if certificate.is_ok() {
            return Ok((found, certificate));
        }
        let mut known: Vec<Vec<f64>> = known.iter().map(|point| self.multiplier(point)).collect();
        known.extend(multipliers);
        let starts = scattered_starts(&member, round);
        member.natural_map(|map| {
            let both = |start: Vec<f64>| [(false, start.clone()), (true, start)];
            for (deflated, start) in starts.flat_map(both) {
                let apart: &[Vec<f64>] = if deflated { &known } else { &[] };
                let Some(multiplier) = self.newton(map, start, apart) else {
                    continue;
                };
                let near =
                    |other: &Vec<f64>| norm(&difference(other, &multiplier)) <= SAME * self.stress;
                if !known.iter().any(near) {
                    found.push(point(&multiplier));
                    known.push(multiplier);
                }
            }
        });
        Ok((found, certificate))
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
            if at.norm == 0.0 || at.norm <= SOLVED * norm(&multiplier) {
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

/// Multipliers of a face that is open, glued, pressed, and in scattered zones and directions.
fn scattered_starts(member: &FamilyMember, round: usize) -> impl Iterator<Item = Vec<f64>> + '_ {
    let (dual, layout) = (&member.dual, member.dual.layout);
    let n = dual.dimension();
    let glued = member.local.glued(&dual.rhs);
    let count = OPERATIONS / (MOST_STEPS as f64 * (n as f64).powi(3));
    let mut scatter = PseudoRandom::new(round);
    (0..count.clamp(STARTS[0], STARTS[1]) as usize).map(move |k| {
        let mut start = glued.clone();
        match k {
            0 => start.fill(0.0),
            1 => {}
            2 => start = member.local.pressed(&dual.rhs),
            _ => {
                for pane in 0..layout.n_panes() {
                    let open = scatter.below(3) == 0;
                    let normal = layout.normal(pane);
                    start[normal] = if open { 0.0 } else { start[normal].abs() };
                    if let Some([first, second]) = layout.tangential(pane) {
                        let [cos, sin] = scatter.turn();
                        let share = if open {
                            0.0
                        } else {
                            [0.0, 1.0, 1.0, 0.2][scatter.below(4)]
                        };
                        let (a, b) = (share * start[first], share * start[second]);
                        start[first] = cos * a - sin * b;
                        start[second] = sin * a + cos * b;
                    }
                }
            }
        }
        start
    })
}

/// Numbers without a pattern, the same on every machine.
struct PseudoRandom(u64);

impl PseudoRandom {
    fn new(round: usize) -> Self {
        Self(0x9E37_79B9_7F4A_7C15 ^ (round as u64) << 32)
    }

    /// cos and sin of an angle; mostly none, half a turn, or anything.
    fn turn(&mut self) -> [f64; 2] {
        let tangent = self.below(1 << 20) as f64 / f64::from(1 << 20);
        let over = (1.0 + tangent * tangent).recip();
        let (cos, sin) = ((1.0 - tangent * tangent) * over, 2.0 * tangent * over);
        match self.below(6) {
            0 => [1.0, 0.0],
            1 => [-1.0, 0.0],
            2 => [cos, sin],
            3 => [cos, -sin],
            4 => [-cos, sin],
            _ => [-cos, -sin],
        }
    }

    fn below(&mut self, bound: u64) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from((self.0 >> 33) % bound).unwrap_or(0)
    }
}

/// Places from which a path is followed both ways where the start of the range is no regular point.
const INSIDE: [f64; 3] = [1e-3, 1e-2, 0.1];

/// Half paths from the solver's answer at the start of the range, or, where no path can be told there, from one a little inside.
pub(super) fn solver_rays(equations: &PieceEquations<'_>) -> Result<Vec<HalfPath>, ProblemError> {
    let mut last = Status::Converged;
    for s in [0.0].into_iter().chain(INSIDE) {
        let family = equations.family;
        let problem = family.problem_at(family.range().value(s))?;
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
        key: equations.family.range().key.clone(),
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
