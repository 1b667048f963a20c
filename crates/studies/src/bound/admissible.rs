//! A displacement near u_h that penetrates nowhere, and what its contact conditions miss.

use contact3d::{
    contact::InterfaceFriction,
    elasticity::corner_strains,
    mesh::Mesh,
    post::{Solved, SolvedContact},
    reference::TRIANGLE_EDGES,
    scene::InvalidValue,
    solver::ContactSide,
};
use nalgebra::Vector6;

use super::{
    BoundParts,
    macro_stress::{Data, Target},
};

/// u_h − w, and the contact part of its gap of duality.
pub(super) struct Admissible {
    /// w in m, `[n_nodes]`.
    pub(super) lifting: Vec<[f64; 3]>,
    /// ∫ λ_ν (d − v_ν) in J.
    complementarity: f64,
    /// ∫ (g ‖F v_t‖ − λ_t·v_t) in J; `None` without friction.
    friction: Option<f64>,
}

impl Admissible {
    /// That of a solved problem; `None` without contact, and where equilibrium is no minimum of energy.
    ///
    /// # Errors
    /// [`InvalidValue`] where a clamp presses the body into the foundation.
    pub(super) fn new(solved: &Solved<'_>) -> Result<Option<Self>, InvalidValue> {
        let Some(contact) = &solved.contact else {
            return Ok(None);
        };
        if !super::scope::is_minimum(solved.scene) {
            return Ok(None);
        }
        let held = solved.mesh.held_nodes(solved.scene);
        let mut lifting = vec![[0.0; 3]; solved.mesh.coordinates.len()];
        let displacement = solved.system.dofs.to_nodes(&solved.solution.displacement);
        let faces: Vec<Triangle> = (0..contact.state.surface.facets.len())
            .map(|place| Triangle::new(solved, contact, &displacement, place))
            .collect();
        for face in &faces {
            let lifted = face.nodal(face.over.map(|c| c.max(0.0)));
            for (node, by) in face.nodes.iter().zip(lifted) {
                for c in (0..3).filter(|c| !held[*node][*c]) {
                    lifting[*node][c] = by * face.normal[c];
                }
            }
        }
        let mut found = Self {
            lifting,
            complementarity: 0.0,
            friction: contact.state.interface.has_friction().then_some(0.0),
        };
        for face in &faces {
            found.add(face)?;
        }
        Ok(Some(found))
    }

    /// Adds what a contact triangle misses.
    fn add(&mut self, face: &Triangle) -> Result<(), InvalidValue> {
        let lifted: Vec<f64> = face
            .nodes
            .iter()
            .map(|node| {
                (0..3)
                    .map(|c| self.lifting[*node][c] * face.normal[c])
                    .sum()
            })
            .collect();
        let lifted = face.coefficients(&lifted);
        let left: [f64; 6] = std::array::from_fn(|k| face.over[k] - lifted[k]);
        let size = face
            .over
            .iter()
            .chain(&face.size)
            .fold(0.0_f64, |most, c| most.max(c.abs()));
        // Smaller ones are rounding of a coefficient.
        if left.iter().any(|c| *c > 1e-10 * size) {
            return Err(super::scope::pressed_in());
        }
        self.complementarity -= face.pressure * face.mean(&left) * face.area;
        if let (Some(sum), Some(work)) = (&mut self.friction, face.missing_work) {
            *sum += work * face.area;
        }
        Ok(())
    }

    /// What contact adds to the bound of a strain by the data of a balanced stress, and the bound of the whole error, in √J; that of the
    /// error for given contact stresses is left zero.
    pub(super) fn bound<'t>(
        &self,
        mesh: &Mesh,
        strain: &[[Vector6<f64>; 4]],
        data: &[Data],
        target: impl Fn(&[[Vector6<f64>; 4]]) -> Target<'t>,
    ) -> BoundParts {
        let lifting = corner_strains(mesh, &self.lifting);
        let both = strain.iter().zip(&lifting);
        let lifted: Vec<[Vector6<f64>; 4]> = both
            .map(|(u, w)| std::array::from_fn(|k| u[k] - w[k]))
            .collect();
        let distance = target(&lifted).distance(data);
        let root = |energy: f64| (2.0 * energy.max(0.0)).sqrt();
        let (lifting, complementarity) = (target(&lifting).norm(), root(self.complementarity));
        let friction = self.friction.map(root);
        let by_friction = friction.unwrap_or(0.0);
        let gap = complementarity * complementarity + by_friction * by_friction;
        BoundParts {
            elements: 0.0,
            total: Some(lifting + (distance + gap).sqrt()),
            lifting: Some(lifting),
            complementarity: Some(complementarity),
            friction,
        }
    }
}

/// A contact triangle with the coefficients of its displacement in Bernstein's polynomials: no function exceeds the largest of its
/// coefficients.
struct Triangle {
    /// Mesh nodes: corners, then mid-edge nodes.
    nodes: Vec<usize>,
    normal: [f64; 3],
    /// m².
    area: f64,
    /// λ_ν in Pa.
    pressure: f64,
    /// Of u_ν − d in m; linear triangles have the three of the corners, and zeros.
    over: [f64; 6],
    /// Of u_ν in m.
    size: [f64; 6],
    /// The mean of g ‖F u_t‖ − λ_t·u_t in J/m², of which the first is at most that of its coefficients since norms are convex;
    /// `None` without friction.
    missing_work: Option<f64>,
}

impl Triangle {
    fn new(
        solved: &Solved<'_>,
        contact: &SolvedContact<'_>,
        displacement: &[[f64; 3]],
        place: usize,
    ) -> Self {
        let ContactSide { surface, interface } = contact.state;
        let facet = surface.facets[place];
        let nodes: Vec<usize> = solved.mesh.facet_nodes(facet).collect();
        let locals = contact.nodes_of(solved.mesh, place);
        let normal = interface.frame.normal_at(locals[0]);
        let pane = surface.facet_pane[place];
        let multiplier = &solved.solution.multiplier;
        let moved = |local: usize| displacement[surface.nodes[local]];
        let along = |local: &usize| interface.frame.normal_part(*local, moved(*local));
        let distance = |local: &usize| interface.gap.as_ref().map_or(0.0, |gap| gap[*local]);
        let mut face = Self {
            normal,
            area: solved.mesh.facet_area(facet),
            pressure: multiplier[pane],
            over: [0.0; 6],
            size: [0.0; 6],
            missing_work: None,
            nodes,
        };
        let over: Vec<f64> = locals
            .iter()
            .map(|local| along(local) - distance(local))
            .collect();
        face.over = face.coefficients(&over);
        let size: Vec<f64> = locals.iter().map(along).collect();
        face.size = face.coefficients(&size);
        let semi_axes = match &interface.friction {
            InterfaceFriction::Tresca(semi_axes) => semi_axes.get(pane),
            InterfaceFriction::Frictionless | InterfaceFriction::Coulomb(_) => None,
        };
        face.missing_work = semi_axes.map(|[a, b]| {
            let slips: Vec<[f64; 2]> = locals
                .iter()
                .map(|local| interface.frame.tangential(*local, moved(*local)))
                .collect();
            let of = |axis: usize| {
                let slips: Vec<f64> = slips.iter().map(|slip| slip[axis]).collect();
                face.coefficients(&slips)
            };
            let [first, second] = [of(0), of(1)];
            let stress = contact.coupling.layout.pair(multiplier, pane);
            let most = std::array::from_fn(|k| (a * first[k]).hypot(b * second[k]));
            let done = std::array::from_fn(|k| stress[0] * first[k] + stress[1] * second[k]);
            face.mean(&most) - face.mean(&done)
        });
        face
    }

    /// Bernstein coefficients from nodal values.
    fn coefficients(&self, nodal: &[f64]) -> [f64; 6] {
        std::array::from_fn(|k| match (k, nodal.len()) {
            (0..3, _) => nodal[k],
            (_, 3) => 0.0,
            _ => {
                let [a, b] = TRIANGLE_EDGES[k - 3];
                2.0 * nodal[k] - (nodal[a] + nodal[b]) / 2.0
            }
        })
    }

    /// Nodal values from Bernstein coefficients, in the order of the nodes.
    fn nodal(&self, coefficients: [f64; 6]) -> Vec<f64> {
        let value = |k: usize| match k.checked_sub(3) {
            None => coefficients[k],
            Some(e) => {
                let [a, b] = TRIANGLE_EDGES[e];
                coefficients[k] / 2.0 + (coefficients[a] + coefficients[b]) / 4.0
            }
        };
        (0..self.nodes.len()).map(value).collect()
    }

    /// The mean of a function with some coefficients over the triangle.
    fn mean(&self, coefficients: &[f64; 6]) -> f64 {
        let n = self.nodes.len();
        coefficients[..n].iter().sum::<f64>() / n as f64
    }
}
