//! Stresses at the nodes, the largest of them and how well it is known.
//!
//! Linear tetrahedra have one stress each, wrong by O(h) at their nodes; the recovered one is wrong by O(h²) where the solution is smooth.
//! Quadratic tetrahedra say at each node something else; their mean is taken, weighted by volume. Nothing is averaged across materials.
//!
//! The error bar of the largest stress is 1.5 times, of quadratic tetrahedra twice, the largest difference between the stress of a tetrahedron at its centre and the one
//! that its corners have there, over the tetrahedra around the node and around its neighbours; where such a difference reaches beyond the
//! largest stress, a node may have a larger one. Of 22 smooth solutions it was 1 to 12 times the error, and wider where the error was below
//! 1 %. On a few cells both stresses may be wrong alike by symmetry: the bar is no less than the share that the error in the energy norm is of
//! the solution, which is that of stresses on the whole.
//!
//! Where the stress of the elastic body has no bound ([`StressConcentration`]) it grows with every finer mesh, at the edge of a crack by √2,
//! at the rim of a clamp by 1.2 to 1.5 measured. A concentration is told from the stress on that makes it the largest of the next mesh.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::{
    ErrorEstimate, FunctionalEstimate, Solved, StressConcentration, concentration::JUMP,
    estimate::SolutionData, von_mises,
};
use crate::{
    mesh::{MaterialNodes, Mesh, tetrahedron_volume},
    scene::Functional,
};

/// The largest von Mises stress of a body.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LargestStress {
    /// Its value in Pa.
    pub value: f64,
    /// Its place in m.
    pub at: [f64; 3],
    /// The place in m of the concentration, or that its error bar is of, where the mesh has to be finer for a smaller one.
    pub limit: [f64; 3],
    /// Its error bar in Pa; infinite with a concentration of stress, and where the error of the mesh tells nothing of quantities.
    pub error: f64,
    /// Why it grows with every finer mesh; `None` where it has a limit.
    pub concentration: Option<StressConcentration>,
}

/// What the stress at a concentration is multiplied with by half the size of tetrahedra, at most.
const GROWTH: f64 = 1.5;

impl LargestStress {
    /// The largest of the von Mises stresses of all rows in Pa, for what is known of the solution and its largest pressure.
    ///
    /// It may be that of any place whose bar reaches beyond the largest one found, and where stress has no bound there, neither has the
    /// largest. Under the largest pressure it is at most about as large as that, and known no better.
    pub(super) fn new(
        solved: &Solved<'_>,
        known: &SolutionData<'_>,
        von_mises: &[f64],
        peak: Option<&FunctionalEstimate>,
    ) -> Self {
        let (nodes, concentrations) = (&known.recovery.nodes, known.concentrations);
        let rows = 0..von_mises.len();
        let Some(row) = rows
            .clone()
            .max_by(|a, b| von_mises[*a].total_cmp(&von_mises[*b]))
        else {
            return Self::default();
        };
        let near = around(solved.mesh, nodes, row).map(|row| nodes.nodes[row]);
        let near: BTreeSet<usize> = near.collect();
        let differences = differences(nodes, known.nodal_stress, &known.internal.stress);
        let reach = |n: usize| von_mises[n] + differences[n];
        let value = von_mises[row];
        let is_rival = |n: &usize| reach(*n).max(GROWTH * von_mises[*n]) > value;
        let mut rivals: Vec<usize> = rows.filter(is_rival).collect();
        rivals.sort_by(|a, b| von_mises[*b].total_cmp(&von_mises[*a]));
        let of_rival = |rival: &usize| {
            let node = nodes.nodes[*rival];
            Some((node, concentrations.at([node], node)?))
        };
        let place = |node: usize| solved.mesh.coordinates[node];
        let node = nodes.nodes[row];
        let at = place(node);
        let distance = |other: [f64; 3]| (Vector3::from(other) - Vector3::from(at)).norm();
        let size = near.iter().map(|&n| distance(place(n))).fold(0.0, f64::max);
        let at_edge = peak.filter(|it| it.error_bar().is_infinite() && it.value > value / 2.0);
        let at_edge = at_edge.and_then(FunctionalEstimate::middle);
        let of_edge = |at: [f64; 3]| (at, StressConcentration::Contact);
        let at_row = concentrations.at(near, node).map(|it| (at, it));
        let beside = at_edge.filter(|edge| distance(*edge) <= size);
        let found = at_row.or(beside.map(|_| of_edge(at)));
        let of_rivals = || rivals.iter().find_map(of_rival);
        let found = found.or_else(|| of_rivals().map(|(node, it)| (place(node), it)));
        // Nothing concentrates a stress that is the same everywhere.
        let least = von_mises.iter().copied().fold(value, f64::min);
        let found = found.filter(|_| least < (1.0 - JUMP) * value);
        let found = found.or(at_edge.map(of_edge));
        let pressed = peak.filter(|it| it.range[1].is_finite());
        let pressed = pressed.and_then(|it| {
            let most = largest_under(it, (solved.mesh, nodes), von_mises)?;
            Some((most, it.middle()?))
        });
        let limits = rivals.iter().map(|&n| (reach(n), place(nodes.nodes[n])));
        let times = if solved.mesh.mid_edges.is_some() {
            2.0
        } else {
            1.5
        };
        let own = (value + times * differences[row], at);
        let larger =
            |most: (f64, [f64; 3]), it: (f64, [f64; 3])| if it.0 > most.0 { it } else { most };
        let (most, limit) = limits.chain(pressed).fold(own, larger);
        Self {
            value,
            at,
            limit: found.map_or(limit, |(place, _)| place),
            error: found.map_or(most - value, |_| f64::INFINITY),
            concentration: found.map(|(_, what)| what),
        }
    }

    /// The stress as a quantity that the mesh is refined for. What an error e of the displacement in a tetrahedron makes of a stress at a
    /// distance r goes as ‖e‖ √V / r³ by the kernel of elasticity, and no nearer than the size of the tetrahedron.
    pub(super) fn quantity(&self, mesh: &Mesh, energy: &ErrorEstimate) -> FunctionalEstimate {
        let share = |(corners, error): (&[usize; 4], &f64)| {
            let corners = mesh.corners(corners);
            let volume = tetrahedron_volume(&corners);
            let centre = corners.map(Vector3::from).iter().sum::<Vector3<f64>>() / 4.0;
            let distance = (centre - Vector3::from(self.limit)).norm();
            error * volume.sqrt() / distance.powi(3).max(volume)
        };
        let tetrahedra = mesh.tetrahedra.iter().zip(&energy.indicator);
        let most = self.value + self.error;
        FunctionalEstimate {
            functional: Functional::LargestVonMises,
            value: self.value,
            signed_error: self.error,
            range: [(self.value - self.error).max(0.0), most],
            corners: Some([self.at; 2]),
            kinks: 0,
            indicator: tetrahedra.map(share).collect(),
        }
    }
}

/// The largest difference in Pa around each row and its neighbours, `[n_material_nodes]`.
fn differences(nodes: &MaterialNodes, stress: &[[f64; 6]], centres: &[[f64; 6]]) -> Vec<f64> {
    let corners = |t: usize| &nodes.of_tetrahedron(t)[..4];
    let differences = centres.iter().enumerate().map(|(t, centre)| {
        von_mises(&std::array::from_fn(|c| {
            let sum: f64 = corners(t).iter().map(|&row| stress[row][c]).sum();
            centre[c] - sum / 4.0
        }))
    });
    let mut of_tetrahedra: Vec<f64> = differences.collect();
    let mut of_rows = vec![0.0; stress.len()];
    // Around the node, then around its neighbours.
    for _ in 0..2 {
        of_rows.fill(0.0_f64);
        for (t, difference) in of_tetrahedra.iter().enumerate() {
            for &row in nodes.of_tetrahedron(t) {
                of_rows[row] = of_rows[row].max(*difference);
            }
        }
        for (t, difference) in of_tetrahedra.iter_mut().enumerate() {
            *difference = corners(t)
                .iter()
                .fold(0.0, |most, &row| most.max(of_rows[row]));
        }
    }
    of_rows
}

/// How large von Mises stresses in Pa may be under the largest pressure: as large as that, and not further above those found there than
/// that is above the pressure found.
fn largest_under(
    peak: &FunctionalEstimate,
    (mesh, nodes): (&Mesh, &MaterialNodes),
    von_mises: &[f64],
) -> Option<f64> {
    let middle = Vector3::from(peak.middle()?);
    let distance = |row: usize| (Vector3::from(mesh.coordinates[nodes.nodes[row]]) - middle).norm();
    let nearest = (0..von_mises.len()).min_by(|a, b| distance(*a).total_cmp(&distance(*b)))?;
    let around = around(mesh, nodes, nearest);
    let found = around.fold(0.0_f64, |most, row| most.max(von_mises[row]));
    let most = peak.range[1];
    Some(most.min(found + most - peak.value))
}

/// The rows of the corners of the tetrahedra around a row, some of them repeatedly, and the row.
fn around(mesh: &Mesh, nodes: &MaterialNodes, row: usize) -> impl Iterator<Item = usize> {
    let tetrahedra = (0..mesh.tetrahedra.len()).map(|t| nodes.of_tetrahedron(t));
    let around = tetrahedra.filter(move |rows| rows.contains(&row));
    around.flat_map(|rows| &rows[..4]).copied().chain([row])
}
