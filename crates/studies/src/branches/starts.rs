//! Half paths that begin at a solution.

use super::{
    corrector::Along,
    equations::PieceEquations,
    kink::{HalfPath, REACHED},
};
use contact3d::{
    ProblemError,
    scene::Invalid,
    solver::{Solution, Status},
};

/// Places from which a path is followed both ways where the start of the range is no regular point.
const INSIDE: [f64; 3] = [1e-3, 1e-2, 0.1];

/// Half paths from the solver's answer at the start of the range, or, where no path can be told there, from one a little inside.
pub(super) fn solver_rays(equations: &PieceEquations<'_>) -> Result<Vec<HalfPath>, ProblemError> {
    let mut last = Status::Converged;
    for s in [0.0].into_iter().chain(INSIDE) {
        let solution = solved(equations, s)?;
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
    Err(Invalid {
        key: equations.family.range().key.clone(),
        expected: "a solution near the start of the range, from which a path leads".into(),
        found: format!("status {} there", last.word()),
        help: "begin at another value with --from".into(),
    }
    .into())
}

fn solved(equations: &PieceEquations<'_>, s: f64) -> Result<Solution, ProblemError> {
    let problem = equations.family.problem(s)?;
    problem.solve(&problem.scene().solve)
}

/// The half paths from a solution into the range: corrected on its piece, one at an end of the range, two inside.
pub(super) fn rays_from(
    equations: &PieceEquations<'_>,
    point: &[f64],
) -> Result<Vec<HalfPath>, ProblemError> {
    let last = point.len() - 1;
    let s = point[last];
    let member = equations.family.member(s)?;
    let piece = equations.piece_of(&member, point);
    let mut up = vec![0.0; point.len()];
    up[last] = 1.0;
    let fixed = Along::Plane(&up, s);
    let corrected = equations.correct(&piece, point.to_vec(), &up, fixed)?;
    let Some(state) = corrected else {
        return Ok(Vec::new());
    };
    let distances = state.distances(equations, &piece);
    let reached: Vec<_> = distances
        .into_iter()
        .filter(|d| d.value <= REACHED)
        .collect();
    let inward = |rate: f64| rate > 0.0 && s < 1.0 || rate < 0.0 && s > 0.0;
    let mut rays = if reached.is_empty() {
        let mut rays = Vec::new();
        for forward in [true, false] {
            if let Some(mut state) = equations.state_at(&piece, &state.point, &up)? {
                if !forward {
                    state.turn();
                }
                let piece = piece.clone();
                rays.push(HalfPath {
                    state,
                    piece,
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
