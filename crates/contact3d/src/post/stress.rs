//! Stresses at the nodes, the largest of them and how well it is known.
//!
//! Linear tetrahedra have one stress each, wrong by O(h) at their nodes; the recovered one is wrong by O(h²) where the solution is smooth.
//! Quadratic tetrahedra say at each node something else; their mean is taken, weighted by volume. Nothing is averaged across materials.
//!
//! The error bar of the largest stress is 1.5 times the largest difference between the stress of a tetrahedron at its centre and the one
//! that its corners have there, over the tetrahedra around the node and around its neighbours. Of 18 smooth solutions it was 1.2 to 12 times
//! the error, and wider where the error was below 1 %. At a notch, at the rim of a clamp, at the edge of a punch and where two materials meet
//! at the surface the stress of the elastic body has no bound ([`StressConcentration`]): there it grows with every finer mesh.

use std::collections::BTreeSet;

use nalgebra::{Vector3, Vector6};
use rayon::prelude::*;

use super::{PaneState, Solved, areas, peak, recovery::RecoveredStress, von_mises};
use crate::{
    elasticity::InternalForces,
    mesh::{MaterialNodes, Mesh, tetrahedron_volume},
    reference::TETRAHEDRON_EDGES,
    scene::Clamp,
};

/// Stresses at the nodes of each material.
pub(super) struct NodalStress {
    /// The rows.
    pub(super) nodes: MaterialNodes,
    /// Voigt stress of each row in Pa, `[n_material_nodes]`.
    pub(super) stress: Vec<[f64; 6]>,
}

/// The largest von Mises stress of a body.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LargestStress {
    /// Its value in Pa.
    pub value: f64,
    /// Its place in m.
    pub at: [f64; 3],
    /// Its error bar in Pa; infinite at a concentration of stress.
    pub error: f64,
    /// Why it grows with every finer mesh; `None` where it has a limit.
    pub concentration: Option<StressConcentration>,
}

/// Where the stress of an elastic body has no bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StressConcentration {
    /// A re-entrant edge.
    Notch,
    /// The rim of a clamp.
    Clamp,
    /// Two materials meet at the surface.
    Materials,
    /// The edge of a punch.
    Contact,
}

impl StressConcentration {
    /// What is there, as a word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Notch => "notch",
            Self::Clamp => "clamp",
            Self::Materials => "materials",
            Self::Contact => "contact",
        }
    }
}

/// The least turn of the surface in degrees that is taken for a notch: a round hole is drawn with more than nine sides.
const NOTCH: f64 = 40.0;

impl NodalStress {
    /// The stresses of a displacement, from those of the tetrahedra.
    pub(super) fn new(mesh: &Mesh, internal: &InternalForces) -> Self {
        let nodes = MaterialNodes::new(mesh);
        let stress = if mesh.mid_edges.is_some() {
            averaged(mesh, &nodes, &internal.corner_stress)
        } else {
            let stresses = [&internal.stress[..]];
            let recovered = RecoveredStress::new(mesh, &nodes, &stresses);
            let rows = (0..nodes.nodes.len()).into_par_iter();
            rows.map(|row| recovered.at(row)[0].into()).collect()
        };
        Self { nodes, stress }
    }

    /// The largest of the von Mises stresses of all rows in Pa, for stresses at the centres of tetrahedra in Pa and panes with their stiffness in
    /// Pa/m.
    pub(super) fn largest(
        &self,
        solved: &Solved<'_>,
        von_mises: &[f64],
        centres: &[[f64; 6]],
        panes: (&[PaneState], &[f64]),
    ) -> LargestStress {
        let rows = 0..von_mises.len();
        let Some(row) = rows.max_by(|a, b| von_mises[*a].total_cmp(&von_mises[*b])) else {
            return LargestStress::default();
        };
        let corners = |t: usize| &self.nodes.of_tetrahedron(t)[..4];
        let tetrahedra = 0..solved.mesh.tetrahedra.len();
        let around = tetrahedra.filter(|&t| self.nodes.of_tetrahedron(t).contains(&row));
        let near: BTreeSet<usize> = around.flat_map(corners).copied().chain([row]).collect();
        let concentration = self.concentration(solved, row, &near, panes);
        LargestStress {
            value: von_mises[row],
            at: solved.mesh.coordinates[self.nodes.nodes[row]],
            error: match concentration {
                None => self.error_among(centres, &near),
                Some(_) => f64::INFINITY,
            },
            concentration,
        }
    }

    /// What concentrates stress at a row, or near it: of linear tetrahedra the largest stress is often one behind the edge.
    fn concentration(
        &self,
        solved: &Solved<'_>,
        row: usize,
        near: &BTreeSet<usize>,
        panes: (&[PaneState], &[f64]),
    ) -> Option<StressConcentration> {
        let (mesh, node) = (solved.mesh, self.nodes.nodes[row]);
        let nodes: BTreeSet<usize> = near.iter().map(|&row| self.nodes.nodes[row]).collect();
        let is_near = |&facet: &usize| mesh.facets[facet].iter().any(|n| nodes.contains(n));
        let facets: Vec<usize> = (0..mesh.facets.len()).filter(is_near).collect();
        let facets_at = |node: usize| -> Vec<usize> {
            let has_node = |facet: &usize| mesh.facet_nodes(*facet).any(|other| other == node);
            facets.iter().copied().filter(has_node).collect()
        };
        let materials = self.nodes.nodes.iter().filter(|n| **n == node).count();
        if materials > 1 && !facets_at(node).is_empty() {
            Some(StressConcentration::Materials)
        } else if has_rim_of_clamp(solved, &nodes, &facets_at) {
            Some(StressConcentration::Clamp)
        } else if nodes.iter().any(|&node| is_notch(mesh, &facets_at(node))) {
            Some(StressConcentration::Notch)
        } else {
            has_edge_of_punch(solved, &facets, panes).then_some(StressConcentration::Contact)
        }
    }

    /// The error bar in Pa of stresses among some rows.
    fn error_among(&self, centres: &[[f64; 6]], near: &BTreeSet<usize>) -> f64 {
        let differences = centres.iter().enumerate().map(|(t, centre)| {
            let corners = &self.nodes.of_tetrahedron(t)[..4];
            if !corners.iter().any(|row| near.contains(row)) {
                return 0.0;
            }
            von_mises(&std::array::from_fn(|c| {
                let sum: f64 = corners.iter().map(|&row| self.stress[row][c]).sum();
                centre[c] - sum / 4.0
            }))
        });
        1.5 * differences.fold(0.0, f64::max)
    }
}

/// Means of the stresses of quadratic tetrahedra at their nodes, which are linear between the corners.
fn averaged(mesh: &Mesh, nodes: &MaterialNodes, corner_stress: &[[[f64; 6]; 4]]) -> Vec<[f64; 6]> {
    let mut sums = vec![(Vector6::zeros(), 0.0); nodes.nodes.len()];
    for (t, corners) in corner_stress.iter().enumerate() {
        let volume = tetrahedron_volume(&mesh.corners(&mesh.tetrahedra[t]));
        let corners = corners.map(Vector6::from);
        let middles = TETRAHEDRON_EDGES.map(|[a, b]| (corners[a] + corners[b]) / 2.0);
        for (&row, stress) in nodes
            .of_tetrahedron(t)
            .iter()
            .zip(corners.into_iter().chain(middles))
        {
            sums[row].0 += stress * volume;
            sums[row].1 += volume;
        }
    }
    let means = sums.into_iter().map(|(sum, volume)| (sum / volume).into());
    means.collect()
}

/// Whether clamps of one face or box hold all components of one of some nodes that a free boundary triangle has. Clamps that hold a body along a
/// normal, as symmetry does, concentrate nothing, and their triangles are not free.
fn has_rim_of_clamp(
    solved: &Solved<'_>,
    nodes: &BTreeSet<usize>,
    facets_at: &dyn Fn(usize) -> Vec<usize>,
) -> bool {
    let (mesh, clamps) = (solved.mesh, &solved.scene.clamps);
    let held = mesh.held_by(clamps);
    let is_free = |&facet: &usize| {
        let is_held = |c: usize| mesh.facet_nodes(facet).all(|node| held[node][c]);
        !(0..3).any(is_held)
    };
    let is_edge = |node: &&usize| facets_at(**node).iter().any(is_free);
    let edge: Vec<&usize> = nodes.iter().filter(is_edge).collect();
    let is_same = |a: &Clamp, b: &Clamp| a.face == b.face && a.corners == b.corners;
    clamps.iter().any(|clamp| {
        let together = clamps.iter().filter(|other| is_same(clamp, other));
        let held = mesh.held_by(&together.cloned().collect::<Vec<_>>());
        edge.iter().any(|&&node| held[node] == [true; 3])
    })
}

/// Whether two boundary triangles that share an edge enclose a notch: the second lies outside of the plane of the first, by an angle.
fn is_notch(mesh: &Mesh, facets: &[usize]) -> bool {
    let corners = |facet: usize| mesh.corners(&mesh.facets[facet]).map(Vector3::from);
    let normal = |facet: usize| {
        let [a, b, c] = corners(facet);
        (b - a).cross(&(c - a)).normalize()
    };
    let encloses = |[first, second]: [usize; 2]| {
        let [a, b] = [first, second].map(|facet| mesh.facets[facet]);
        let middle = corners(second).iter().sum::<Vector3<f64>>() / 3.0;
        a.iter().filter(|node| b.contains(node)).count() == 2
            && normal(first).angle(&normal(second)) >= NOTCH.to_radians()
            && normal(first).dot(&(middle - corners(first)[0])) > 0.0
    };
    let mut pairs = facets.iter().flat_map(|a| facets.iter().map(|b| [*a, *b]));
    pairs.any(encloses)
}

/// Whether some boundary triangles have more than half of a largest pressure that grows with every finer mesh.
fn has_edge_of_punch(
    solved: &Solved<'_>,
    facets: &[usize],
    (panes, stiffness): (&[PaneState], &[f64]),
) -> bool {
    let Some(contact) = &solved.contact else {
        return false;
    };
    let places = contact.state.surface.facets.iter().enumerate();
    let touching = places.filter(|(_, facet)| facets.contains(facet));
    let pressures = touching
        .flat_map(|(place, _)| areas::panes_of(solved, contact, place))
        .map(|pane| -panes[pane].normal_stress);
    let pressure = pressures.fold(0.0, f64::max);
    pressure > 0.0
        && peak::largest_pressure(solved, panes, stiffness)
            .is_some_and(|peak| peak.error_bar().is_infinite() && pressure > peak.value / 2.0)
}
