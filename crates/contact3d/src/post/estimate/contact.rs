//! What the conditions of contact and friction are violated by inside panes.

use super::{SolutionData, boundary::multipliers_between_nodes};
use crate::{
    mesh::Mesh,
    post::{Solved, SolvedContact},
    reference::{quadrature, shape::quadratic_triangle},
    solver::Ellipse,
};

/// A multiplier with its law at a point of the contact face.
#[derive(Clone, Copy, Default)]
struct Law {
    /// λ_ν, λ_t1, λ_t2 in Pa.
    stress: [f64; 3],
    /// Local stiffness, normal and tangential, in Pa/m.
    stiffness: [f64; 2],
    /// Semi-axes of friction in Pa.
    semi_axes: [f64; 2],
}

impl Law {
    fn scaled(self, by: f64) -> Self {
        Self {
            stress: self.stress.map(|v| v * by),
            stiffness: self.stiffness.map(|v| v * by),
            semi_axes: self.semi_axes.map(|v| v * by),
        }
    }

    fn plus(self, other: Self) -> Self {
        let sum2 = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        Self {
            stress: std::array::from_fn(|c| self.stress[c] + other.stress[c]),
            stiffness: sum2(self.stiffness, other.stiffness),
            semi_axes: sum2(self.semi_axes, other.semi_axes),
        }
    }

    /// δλ²/k in J/m² of penetration, complementarity and friction for a displacement (u_ν − d, u_t1,
    /// u_t2) in m.
    fn energies(&self, at: [f64; 3]) -> [f64; 3] {
        let [normal, tangential] = self.stiffness;
        let pressure = self.stress[0];
        let change = (pressure + normal * at[0]).max(0.0) - pressure;
        let energy = if normal > 0.0 {
            change * change / normal
        } else {
            0.0
        };
        let [penetration, complementarity] = if at[0] > 0.0 {
            [energy, 0.0]
        } else {
            [0.0, energy]
        };
        let friction = if tangential > 0.0 {
            let shear = [self.stress[1], self.stress[2]];
            let trial = [0, 1].map(|c| shear[c] + tangential * at[c + 1]);
            let ellipse = Ellipse {
                semi_axes: self.semi_axes,
            };
            let found = ellipse.project(trial);
            ((found[0] - shear[0]).powi(2) + (found[1] - shear[1]).powi(2)) / tangential
        } else {
            0.0
        };
        [penetration, complementarity, friction]
    }
}

/// The energies in J of penetration, complementarity and friction of each contact triangle,
/// `[n_contact_facets]`.
pub(super) fn residuals(
    solved: &Solved<'_>,
    contact: &SolvedContact<'_>,
    known: &SolutionData<'_>,
) -> Vec<[f64; 3]> {
    let surface = contact.state.surface;
    let laws: Vec<Law> = (0..surface.n_panes())
        .map(|pane| law_of(contact, solved, known, pane))
        .collect();
    let moved = displacements(contact, known);
    let facets = surface.facets.iter().enumerate();
    facets
        .map(|(place, &facet)| {
            let face = surface.face_of_facet(place);
            let local: Vec<usize> = solved
                .mesh
                .facet_nodes(facet)
                .filter_map(|node| surface.contact_node(face, node))
                .collect();
            let area = solved.mesh.facet_area(facet);
            let mut sum = [0.0; 3];
            for (share, weight) in quadrature::triangle() {
                let shape = match solved.mesh.mid_edges {
                    None => share.to_vec(),
                    Some(_) => quadratic_triangle(&share).to_vec(),
                };
                let at = std::array::from_fn(|c| {
                    local
                        .iter()
                        .zip(&shape)
                        .map(|(&n, w)| w * moved[n][c])
                        .sum()
                });
                let law = match surface.pane_of_facet(place) {
                    Some(pane) => laws[pane],
                    None => between_nodes(solved.mesh, contact, &laws, place, share),
                };
                let energies = law.energies(at);
                for (sum, energy) in sum.iter_mut().zip(energies) {
                    *sum += weight * area * energy;
                }
            }
            sum
        })
        .collect()
}

/// The multiplier of a pane, its local stiffness and its ellipse.
fn law_of(
    contact: &SolvedContact<'_>,
    solved: &Solved<'_>,
    known: &SolutionData<'_>,
    pane: usize,
) -> Law {
    let layout = contact.coupling.layout;
    let multiplier = &solved.solution.multiplier;
    let area = contact.state.surface.pane_area[pane];
    let pair = layout.tangential(pane);
    let shear = pair.map_or([0.0; 2], |pair| pair.map(|j| multiplier[j]));
    Law {
        stress: [multiplier[pane], shear[0], shear[1]],
        stiffness: [
            known.stiffness[pane] * area,
            pair.map_or(0.0, |[j, _]| known.stiffness[j] * area),
        ],
        semi_axes: known.panes[pane].friction.map_or([0.0; 2], |f| f.semi_axes),
    }
}

/// (u_ν − d, u_t1, u_t2) at the contact nodes in m, `[n_contact_nodes]`; tangential ones since the step began.
fn displacements(contact: &SolvedContact<'_>, known: &SolutionData<'_>) -> Vec<[f64; 3]> {
    let surface = contact.state.surface;
    let interface = contact.state.interface;
    let nodes = surface.nodes.iter().enumerate();
    nodes
        .map(|(local, &node)| {
            let u = known.displacement[node];
            let outward = interface.frame.normal_at(local);
            let normal: f64 = (0..3).map(|c| u[c] * outward[c]).sum();
            let gap = interface.gap.as_ref().map_or(0.0, |gap| gap[local]);
            let [first, second] = interface.frame.tangential(local, u);
            let from = interface.slip_origin(local);
            [normal - gap, first - from[0], second - from[1]]
        })
        .collect()
}

/// The law between nodal multipliers: linear on the triangle; nodes without a multiplier, whose
/// displacement is held, have a law of zero.
fn between_nodes(
    mesh: &Mesh,
    contact: &SolvedContact<'_>,
    laws: &[Law],
    place: usize,
    share: [f64; 3],
) -> Law {
    let parts = multipliers_between_nodes(mesh, contact, place, share);
    parts
        .into_iter()
        .fold(Law::default(), |sum, (pane, weight)| {
            sum.plus(laws[pane].scaled(weight))
        })
}
