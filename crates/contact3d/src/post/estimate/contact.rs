//! What the conditions of contact and friction are violated by inside panes.

use super::{Field, SolutionData, boundary::multipliers_between_nodes};
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
    /// What they gain with the pressure.
    axes_by_pressure: [f64; 2],
    /// Q_λ over the area of the pane, along ν, t₁, t₂; zero for the solution itself.
    wanted: [f64; 3],
}

impl Law {
    /// The sum with a multiple of another one.
    fn plus(self, by: f64, other: Self) -> Self {
        fn sum<const K: usize>(a: [f64; K], by: f64, b: [f64; K]) -> [f64; K] {
            std::array::from_fn(|c| a[c] + b[c] * by)
        }
        Self {
            stress: sum(self.stress, by, other.stress),
            stiffness: sum(self.stiffness, by, other.stiffness),
            semi_axes: sum(self.semi_axes, by, other.semi_axes),
            axes_by_pressure: sum(self.axes_by_pressure, by, other.axes_by_pressure),
            wanted: sum(self.wanted, by, other.wanted),
        }
    }

    /// δλ in Pa for a displacement (u_ν − d, u_t1, u_t2) in m, with semi-axes that follow the pressure.
    fn change(&self, at: [f64; 3]) -> [f64; 3] {
        let [normal, tangential] = self.stiffness;
        let [pressure, first, second] = self.stress;
        let pressed = (pressure + normal * at[0]).max(0.0) - pressure;
        let ellipse = Ellipse {
            semi_axes: [0, 1]
                .map(|k| (self.semi_axes[k] + self.axes_by_pressure[k] * pressed).max(0.0)),
        };
        let found = ellipse.project([first + tangential * at[1], second + tangential * at[2]]);
        [pressed, found[0] - first, found[1] - second]
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
    (0..surface.facets.len())
        .map(|place| {
            let mut sum = [0.0; 3];
            visit(solved, contact, &laws, place, |point, law, weight| {
                let energies = law.energies(point.value(&moved));
                for (sum, energy) in sum.iter_mut().zip(energies) {
                    *sum += weight * energy;
                }
            });
            sum
        })
        .collect()
}

/// The local errors of solution and adjoint behind a contact triangle at a point in barycentric coordinates of the tetrahedron.
pub(super) type LocalErrors<'a> = dyn Fn(usize, &[f64; 4]) -> [[f64; 3]; 2] + 'a;

/// −∫ (z − q)·δλ over each contact triangle, `[n_contact_facets]`: what the contact conditions that are violated inside panes
/// make of a functional with an adjoint z and derivative Q_λ = ∫ q; `errors` are the local ones of solution and adjoint behind a contact
/// triangle, in the global axes, which are added to u and to z.
pub(super) fn weighted(
    solved: &Solved<'_>,
    contact: &SolvedContact<'_>,
    known: &SolutionData<'_>,
    adjoint: &Field<'_>,
    errors: &LocalErrors<'_>,
) -> Vec<f64> {
    let (mesh, surface) = (solved.mesh, contact.state.surface);
    let layout = contact.coupling.layout;
    let law = |pane: usize| {
        let density = |j: usize| adjoint.by_multiplier[j] / surface.pane_area[pane];
        let pair = layout.tangential(pane);
        let [first, second] = pair.map_or([0.0; 2], |pair| pair.map(density));
        Law {
            wanted: [density(pane), first, second],
            ..law_of(contact, solved, known, pane)
        }
    };
    let laws: Vec<Law> = (0..surface.n_panes()).map(law).collect();
    let moved = displacements(contact, known);
    let frame = &contact.state.interface.frame;
    let in_frame = |local: usize, vector: [f64; 3]| {
        let [first, second] = frame.tangential(local, vector);
        [frame.normal_part(local, vector), first, second]
    };
    let nodes = surface.nodes.iter().enumerate();
    let nodal: Vec<[f64; 3]> = nodes
        .map(|(local, &node)| in_frame(local, adjoint.displacement[node]))
        .collect();
    let behind = mesh.behind_contact();
    let sum3 = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] { std::array::from_fn(|c| a[c] + b[c]) };
    (0..surface.facets.len())
        .map(|place| {
            let mut sum = 0.0;
            let facet = mesh.facets[surface.facets[place]];
            let tetrahedron = mesh.tetrahedra[behind[place]];
            visit(solved, contact, &laws, place, |point, law, weight| {
                let at = tetrahedron.map(|node| {
                    let corner = facet.iter().position(|n| *n == node);
                    corner.map_or(0.0, |corner| point.share[corner])
                });
                let [own, of_adjoint] = errors(place, &at).map(|e| in_frame(point.nodes[0], e));
                let z = sum3(point.value(&nodal), of_adjoint);
                let change = law.change(sum3(point.value(&moved), own));
                let wanted = match &adjoint.over {
                    None => law.wanted,
                    Some(part) => {
                        let place = quadrature::point(&mesh.corners(&facet), &point.share);
                        [part.density(place), 0.0, 0.0]
                    }
                };
                for c in 0..3 {
                    sum -= weight * (z[c] - wanted[c]) * change[c];
                }
            });
            sum
        })
        .collect()
}

/// A point of integration on a contact triangle.
struct FacePoint<'a> {
    /// Contact nodes of the triangle.
    nodes: &'a [usize],
    /// Their shape functions here.
    shape: Vec<f64>,
    /// Its barycentric coordinates.
    share: [f64; 3],
}

impl FacePoint<'_> {
    fn value(&self, nodal: &[[f64; 3]]) -> [f64; 3] {
        std::array::from_fn(|c| {
            let terms = self.nodes.iter().zip(&self.shape);
            terms.map(|(&n, w)| w * nodal[n][c]).sum()
        })
    }
}

/// Visits the points of integration of a contact triangle with the law there and their weight in m².
fn visit(
    solved: &Solved<'_>,
    contact: &SolvedContact<'_>,
    laws: &[Law],
    place: usize,
    mut visited: impl FnMut(FacePoint<'_>, Law, f64),
) {
    let surface = contact.state.surface;
    let (face, facet) = (surface.face_of_facet(place), surface.facets[place]);
    let nodes: Vec<usize> = solved
        .mesh
        .facet_nodes(facet)
        .filter_map(|node| surface.contact_node(face, node))
        .collect();
    let area = solved.mesh.facet_area(facet);
    for (share, weight) in quadrature::triangle() {
        let shape = match solved.mesh.mid_edges {
            None => share.to_vec(),
            Some(_) => quadratic_triangle(&share).to_vec(),
        };
        let law = match surface.pane_of_facet(place) {
            Some(pane) => laws[pane],
            None => between_nodes(solved.mesh, contact, laws, place, share),
        };
        let nodes = &nodes;
        let point = FacePoint {
            nodes,
            shape,
            share,
        };
        visited(point, law, weight * area);
    }
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
        axes_by_pressure: axes_by_pressure(contact, known, pane, multiplier[pane]),
        wanted: [0.0; 3],
    }
}

/// What the semi-axes of a pane gain with its pressure: F dg/dλ_ν.
fn axes_by_pressure(
    contact: &SolvedContact<'_>,
    known: &SolutionData<'_>,
    pane: usize,
    pressure: f64,
) -> [f64; 2] {
    let friction = known.panes[pane].friction;
    let coulomb = friction.and_then(|friction| friction.coulomb);
    let law = contact.state.interface.coulomb();
    law.zip(coulomb).map_or([0.0; 2], |(law, here)| {
        let slope = law.slip_bound_slope(pane, pressure);
        here.coefficients.map(|f| f * slope)
    })
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
            sum.plus(weight, laws[pane])
        })
}
