//! The answers to other descriptions of the same problem.

use std::{fmt, ops::Range, path::Path};

use super::{Symmetry, UnitChange, explicit_problem::ExplicitProblem, symmetry::renumbered};
use contact3d::{
    ProblemError,
    scene::Scene,
    solver::{Linearisation, Solution, Status},
};

/// A change of the description that leaves the problem as it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Invariance {
    /// Units that differ by powers of two: every rounding is the same, so are all bits.
    BinaryUnits,
    /// Millimetres and newtons per square millimetre for metres and pascals.
    DecimalUnits,
    /// Loads, gap and the slips of the law times 2⁻³⁰: all bits stay. Not against an obstacle, whose distance is part of
    /// the geometry.
    LoadScaling,
    /// Scattered node numbers.
    Renumbering,
    /// Another number of threads: all bits stay.
    Threads,
    /// y → L_y − y.
    Mirror,
    /// x ↔ y.
    Exchange,
}

/// Two to this power scales the loads.
const LOAD_POWER: i32 = -30;

impl Invariance {
    /// All changes.
    pub const ALL: [Self; 7] = [
        Self::BinaryUnits,
        Self::DecimalUnits,
        Self::LoadScaling,
        Self::Renumbering,
        Self::Threads,
        Self::Mirror,
        Self::Exchange,
    ];

    /// Whether not even a bit may change.
    #[must_use]
    pub fn is_exact(self) -> bool {
        matches!(self, Self::BinaryUnits | Self::LoadScaling | Self::Threads)
    }

    /// The name of its column.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::BinaryUnits => "binary_units",
            Self::DecimalUnits => "decimal_units",
            Self::LoadScaling => "load_scaling",
            Self::Renumbering => "renumbering",
            Self::Threads => "threads",
            Self::Mirror => "mirror",
            Self::Exchange => "exchange",
        }
    }

    fn scaling(self) -> Option<UnitChange> {
        let two = |power: i32| 2_f64.powi(power);
        match self {
            Self::BinaryUnits => Some(UnitChange {
                length: two(10),
                displacement: two(10),
                stress: two(-20),
            }),
            Self::DecimalUnits => Some(UnitChange {
                length: 1e3,
                displacement: 1e3,
                stress: 1e-6,
            }),
            Self::LoadScaling => Some(UnitChange {
                length: 1.0,
                displacement: two(LOAD_POWER),
                stress: two(LOAD_POWER),
            }),
            _ => None,
        }
    }

    fn symmetry(self) -> Option<Symmetry> {
        match self {
            Self::Mirror => Some(Symmetry::Mirror),
            Self::Exchange => Some(Symmetry::Exchange),
            _ => None,
        }
    }
}

impl fmt::Display for Invariance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BinaryUnits => "units by powers of two",
            Self::DecimalUnits => "decimal units",
            Self::LoadScaling => "scaled loads",
            Self::Renumbering => "renumbered nodes",
            Self::Threads => "other threads",
            Self::Mirror => "mirror",
            Self::Exchange => "exchanged axes",
        })
    }
}

/// What a change did to the answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InvarianceResult {
    /// The change.
    pub invariance: Invariance,
    /// How the changed problem ended.
    pub status: Status,
    /// ‖λ' − λ‖ / ‖λ‖ for the multipliers λ' of the changed problem, changed back; where λ vanishes,
    /// over the stresses that would push the free body back.
    pub difference: f64,
    /// ‖R(λ')‖ / ‖λ'‖ in the problem as it was described first.
    pub residual: f64,
}

/// Solves the problem in every other description that it has.
pub(super) fn compare(
    problem: &ExplicitProblem,
    folder: &Path,
    answer: &Solution,
) -> Result<Vec<InvarianceResult>, ProblemError> {
    let mut results = Vec::new();
    for invariance in Invariance::ALL {
        if let Some((status, multiplier)) = changed(problem, folder, invariance)? {
            results.push(InvarianceResult {
                invariance,
                status,
                difference: problem.distance(&multiplier, &answer.multiplier),
                residual: Linearisation::residual_of(
                    problem.dual(),
                    &problem.contact().laws(),
                    &problem.unknowns(&multiplier, answer),
                ),
            });
        }
    }
    Ok(results)
}

/// The answer to the changed problem, changed back; `None` where the change does not apply.
fn changed(
    problem: &ExplicitProblem,
    folder: &Path,
    invariance: Invariance,
) -> Result<Option<(Status, Vec<f64>)>, ProblemError> {
    let scene = &problem.scene;
    if let Some(scaling) = invariance.scaling() {
        let mut contacts = scene.contacts.iter();
        let has_obstacle = contacts.any(|contact| contact.obstacle.is_some());
        if has_obstacle && !scaling.is_similarity() {
            return Ok(None);
        }
        let (scaled, cuts) = (scaling.apply(scene)?, problem.refinement.clone());
        let other = ExplicitProblem::refined(scaled, folder, cuts)?;
        let solution = other.assembled.solve(&scene.solve)?;
        let multiplier = solution.multiplier.iter().map(|l| l / scaling.stress);
        return Ok(Some((solution.status, multiplier.collect())));
    }
    if let Some(symmetry) = invariance.symmetry() {
        // The tetrahedra of an image are numbered otherwise, so cuts have no image.
        let image = symmetry.apply(scene)?;
        let Some(image) = image.filter(|_| problem.refinement.is_empty()) else {
            return Ok(None);
        };
        let other = ExplicitProblem::new(image, folder)?;
        let solution = other.assembled.solve(&scene.solve)?;
        let multiplier = seen_back(problem, &other, symmetry, &solution.multiplier);
        return Ok(multiplier.map(|multiplier| (solution.status, multiplier)));
    }
    if invariance == Invariance::Renumbering {
        let other = ExplicitProblem::on_mesh(scene.clone(), renumbered(problem.assembled.mesh()))?;
        let solution = other.assembled.solve(&scene.solve)?;
        return Ok(Some((solution.status, solution.multiplier)));
    }
    let other_count = if rayon::current_num_threads() == 1 {
        3
    } else {
        1
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(other_count);
    let Ok(pool) = pool.build() else {
        return Ok(None);
    };
    let solution = pool.install(|| -> Result<Solution, ProblemError> {
        let cuts = problem.refinement.clone();
        let other = ExplicitProblem::refined(scene.clone(), folder, cuts)?;
        other.assembled.solve(&scene.solve)
    })?;
    Ok(Some((solution.status, solution.multiplier)))
}

/// Multipliers of an image, pane by pane where they come from; `None` if a pane has no partner.
fn seen_back(
    problem: &ExplicitProblem,
    image: &ExplicitProblem,
    symmetry: Symmetry,
    multiplier: &[f64],
) -> Option<Vec<f64>> {
    let width = width_of(problem.assembled.scene())?;
    let layout = problem.dual().layout;
    let m = layout.n_panes();
    let images: Vec<[f64; 3]> = (0..m)
        .map(|pane| symmetry.point(centre(image, pane), width))
        .collect();
    // Faces with and without friction keep their order, and so do the faces of either kind.
    let nearest = |at: [f64; 3], among: Range<usize>| {
        let distance = |b: &[f64; 3]| -> f64 { (0..3).map(|c| (at[c] - b[c]).powi(2)).sum() };
        among.min_by(|&i, &j| distance(&images[i]).total_cmp(&distance(&images[j])))
    };
    let (own, other) = (problem.surface(), image.surface());
    let mut back = vec![0.0; multiplier.len()];
    for pane in 0..m {
        let face = other.faces.get(own.face_of_pane(pane))?;
        let partner = nearest(centre(problem, pane), face.panes.clone())?;
        back[layout.normal(pane)] = multiplier[layout.normal(partner)];
        if layout.tangential(pane).is_some() {
            let pair = symmetry.tangential(layout.pair(multiplier, partner));
            layout.split_mut(&mut back).1[pane] = pair;
        }
    }
    Some(back)
}

fn width_of(scene: &Scene) -> Option<f64> {
    Some(scene.body.as_brick()?.size[1])
}

/// The weighted mean of a pane's nodes.
fn centre(problem: &ExplicitProblem, pane: usize) -> [f64; 3] {
    let surface = problem.surface();
    let mut centre = [0.0; 3];
    for (local, weight) in surface.pane_weights(pane) {
        let at = problem.assembled.mesh().coordinates[surface.nodes[local]];
        for c in 0..3 {
            centre[c] += weight * at[c];
        }
    }
    centre
}
