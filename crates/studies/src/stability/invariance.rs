//! The solutions of other descriptions of the same problem, among them one with its nodes in another order.

use std::{ops::Range, path::Path};

use super::explicit_problem::ExplicitProblem;
use crate::StudyStep;
use crate::shared::greatest_common_divisor;
use contact3d::{
    ProblemError,
    linalg::CscMatrix,
    mesh::{BodyRange, ContactSurface, GluedNode, Mesh, MidEdgeNodes, Opposite},
    scene::{Scene, UnitChange},
    solver::{Linearisation, Solution, Status},
};

units::worded! {
    /// A change of the description that leaves the problem as it is.
    pub enum Invariance {
        /// Units that differ by powers of two: every rounding is the same, so are all bits.
        BinaryUnits = "binary_units",
        /// Millimetres and newtons per square millimetre for metres and pascals.
        DecimalUnits = "decimal_units",
        /// Loads, gap and the slips of the law times 2⁻³⁰: all bits stay. Not against an obstacle, whose distance is part of
        /// the geometry.
        LoadScaling = "load_scaling",
        /// Scattered node numbers.
        Renumbering = "renumbering",
        /// Another number of threads: all bits stay.
        Threads = "threads",
    }
}

/// Two to this power scales the loads.
const LOAD_POWER: i32 = -30;

impl Invariance {
    /// Whether not even a bit may change.
    #[must_use]
    pub fn is_exact(self) -> bool {
        matches!(self, Self::BinaryUnits | Self::LoadScaling | Self::Threads)
    }

    /// The other units; `None` where numbers stay what they are.
    fn unit_change(self) -> Option<UnitChange> {
        let two = |power: i32| 2_f64.powi(power);
        let [length, displacement, stress] = match self {
            Self::BinaryUnits => [two(10), two(10), two(-20)],
            Self::DecimalUnits => [1e3, 1e3, 1e-6],
            Self::LoadScaling => [1.0, two(LOAD_POWER), two(LOAD_POWER)],
            Self::Renumbering | Self::Threads => return None,
        };
        Some(UnitChange {
            length,
            displacement,
            stress,
        })
    }

    /// Whether a scene has the other description: distances from an obstacle, or between bodies, scale as coordinates do.
    fn applies(self, scene: &Scene) -> bool {
        let mut contacts = scene.contacts.iter();
        let is_level = contacts.all(|contact| contact.obstacle.is_none()) && !scene.bodies_touch();
        self != Self::LoadScaling || is_level
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
    observe: &mut dyn FnMut(StudyStep),
) -> Result<Vec<InvarianceResult>, ProblemError> {
    let mut results = Vec::new();
    for invariance in Invariance::ALL {
        observe(StudyStep::Begin(invariance.word().replace('_', " ")));
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
    if !invariance.applies(scene) {
        return Ok(None);
    }
    let cuts = problem.refinement.clone();
    if let Some(units) = invariance.unit_change() {
        let other = ExplicitProblem::refined(scene.in_units(units), folder, cuts)?;
        let solution = other.assembled.solve(&scene.solve)?;
        let stresses = solution.multiplier.iter();
        let multiplier = stresses.map(|l| l / units.stress).collect();
        return Ok(Some((solution.status, multiplier)));
    }
    if invariance == Invariance::Renumbering {
        let other = ExplicitProblem::on_mesh(scene.clone(), renumbered(problem.assembled.mesh()))?;
        let solution = other.assembled.solve(&scene.solve)?;
        return Ok(Some((solution.status, solution.multiplier)));
    }
    let other_count = match rayon::current_num_threads() {
        1 => 3,
        _ => 1,
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(other_count);
    let Ok(pool) = pool.build() else {
        return Ok(None);
    };
    let solution = pool.install(|| -> Result<Solution, ProblemError> {
        let other = ExplicitProblem::refined(scene.clone(), folder, cuts)?;
        other.assembled.solve(&scene.solve)
    })?;
    Ok(Some((solution.status, solution.multiplier)))
}

/// The mesh with scattered node numbers and its tetrahedra in reverse; panes keep their numbers.
pub(super) fn renumbered(mesh: &Mesh) -> Mesh {
    let (ranges, n_tetrahedra) = (mesh.body_ranges(), mesh.tetrahedra.len());
    let of_body = |nodes: &Range<usize>| scattered(nodes.len()).into_iter();
    let new = ranges.iter().map(|body| &body.nodes);
    let new: Vec<usize> = new
        .flat_map(|nodes| of_body(nodes).map(|node| nodes.start + node))
        .collect();
    let mut coordinates = mesh.coordinates.clone();
    for (old, place) in mesh.coordinates.iter().zip(&new) {
        coordinates[*place] = *old;
    }
    Mesh {
        coordinates,
        tetrahedra: renamed(mesh.tetrahedra.iter().rev(), &new),
        tetrahedron_region: mesh.tetrahedron_region.iter().rev().copied().collect(),
        facets: renamed(mesh.facets.iter(), &new),
        facet_face: mesh.facet_face.clone(),
        face_names: mesh.face_names.clone(),
        mid_edges: mesh.mid_edges.as_ref().map(|middles| MidEdgeNodes {
            tetrahedra: renamed(middles.tetrahedra.iter().rev(), &new),
            facets: renamed(middles.facets.iter(), &new),
        }),
        bodies: mesh
            .bodies
            .iter()
            .map(|body| BodyRange {
                tetrahedra: n_tetrahedra - body.tetrahedra.end
                    ..n_tetrahedra - body.tetrahedra.start,
                ..body.clone()
            })
            .collect(),
        obstacles: mesh.obstacles.clone(),
        glued: mesh.glued.iter().map(|own| follower(own, &new)).collect(),
        joint_gap: mesh.joint_gap.clone(),
        joint_cover: mesh.joint_cover.clone(),
        contact: mesh.contact.as_ref().map(|own| reordered(own, &new)),
    }
}

fn follower(glued: &GluedNode, new: &[usize]) -> GluedNode {
    let shares = glued.shares.iter();
    GluedNode {
        node: new[glued.node],
        entry: glued.entry,
        axes: glued.axes,
        shares: shares.map(|(node, share)| (new[*node], *share)).collect(),
    }
}

/// Simplices with the new numbers of their nodes.
fn renamed<'a, const K: usize>(
    simplices: impl Iterator<Item = &'a [usize; K]>,
    new: &[usize],
) -> Vec<[usize; K]> {
    simplices.map(|nodes| nodes.map(|n| new[n])).collect()
}

/// A permutation of 0…n−1 without order.
fn scattered(n: usize) -> Vec<usize> {
    // A stride near the golden section of any number scatters neighbours far apart.
    let first = ((n as f64 * 0.618_033_988_749_895) as usize).max(1);
    let stride = (first..).find(|&stride| greatest_common_divisor(n, stride) == 1);
    (0..n).map(|i| i * stride.unwrap_or(1) % n).collect()
}

fn reordered(surface: &ContactSurface, new: &[usize]) -> ContactSurface {
    let mut order: Vec<usize> = (0..surface.nodes.len()).collect();
    for face in &surface.faces {
        order[face.nodes.clone()].sort_by_key(|&local| new[surface.nodes[local]]);
    }
    let mut place = vec![0; order.len()];
    for (next, &local) in order.iter().enumerate() {
        place[local] = next;
    }
    let columns = (0..surface.n_panes()).map(|pane| {
        let weights = surface.pane_weights(pane);
        weights
            .map(|(local, weight)| (place[local], weight))
            .collect()
    });
    let sorted = columns.map(|mut column: Vec<_>| {
        column.sort_by_key(|(local, _)| *local);
        column
    });
    ContactSurface {
        normals: match surface.normals.as_slice() {
            [everywhere] => vec![*everywhere],
            each => order.iter().map(|&local| each[local]).collect(),
        },
        clearance: match surface.clearance.as_slice() {
            [] => Vec::new(),
            each => order.iter().map(|&local| each[local]).collect(),
        },
        nodes: order.iter().map(|&n| new[surface.nodes[n]]).collect(),
        opposite: surface.opposite.as_ref().map(|own| {
            let points = order.iter().map(|&local| {
                let nodes = own.at_node(local);
                let mut nodes: Vec<_> = nodes.map(|(node, share)| (new[node], share)).collect();
                nodes.sort_by_key(|(node, _)| *node);
                nodes
            });
            let renamed = |entries: &Vec<(usize, usize, f64)>| {
                let entries = entries.iter();
                entries
                    .map(|(local, node, value)| (place[*local], new[*node], *value))
                    .collect()
            };
            Opposite {
                points: CscMatrix::of_columns(own.points.rows, points),
                products: own.products.iter().map(renamed).collect(),
            }
        }),
        pane_average: CscMatrix::of_columns(surface.pane_average.rows, sorted),
        ..surface.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::scattered;

    #[test]
    fn scattered_numbers_are_a_permutation() {
        for n in 1..60 {
            let mut numbers = scattered(n);
            assert!(n < 4 || numbers[1] > 1, "{n}");
            numbers.sort_unstable();
            assert_eq!(numbers, (0..n).collect::<Vec<_>>());
        }
    }
}
