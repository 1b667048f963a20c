//! What the solution means: zones, stresses, resultants, energies, and a certificate.

mod certificate;
mod resultants;
mod zones;

pub use certificate::Certificate;
pub use resultants::{Resultants, Vector, von_mises};
pub use zones::{PaneState, Zone, pane_states};

use crate::{
    contact::{FrictionField, nodal_slip},
    dual::PrimalSystem,
    elasticity::internal_forces,
    mesh::Mesh,
    scene::Scene,
    solver::Solution,
};

/// A solved problem, as post-processing needs it: no factor, no dual operator.
#[derive(Debug, Clone, Copy)]
pub struct Solved<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The mesh.
    pub mesh: &'a Mesh,
    /// A, l and B.
    pub system: &'a PrimalSystem,
    /// λ, u and the friction they were found with.
    pub solution: &'a Solution,
}

/// Everything the post stage reports.
#[derive(Debug, Clone)]
pub struct ContactReport {
    /// State of each pane, `[n_panes]`.
    pub panes: Vec<PaneState>,
    /// (F₁, F₂) at the contact nodes for the slip of the solution.
    pub friction: FrictionField,
    /// Nodal displacement, `[n_nodes]`, in m.
    pub displacement: Vec<[f64; 3]>,
    /// Voigt stress (xx, yy, zz, yz, xz, xy) of each tetrahedron in Pa.
    pub stress: Vec<[f64; 6]>,
    /// Von Mises stress of each tetrahedron in Pa.
    pub von_mises: Vec<f64>,
    /// Forces, moments and energies of the whole body.
    pub resultants: Resultants,
    /// How well the discrete problem is satisfied.
    pub certificate: Certificate,
}

impl ContactReport {
    /// Evaluates a solved problem.
    #[must_use]
    pub fn new(solved: &Solved<'_>) -> Self {
        let surface = &solved.mesh.contact;
        let frame = solved.scene.contact.frame();
        let dofs = &solved.system.dofs;
        let slip = nodal_slip(surface, &frame, dofs, &solved.solution.displacement);
        let friction = FrictionField::new(&solved.scene.friction, surface, &slip);
        let panes = pane_states(solved, &friction);
        let displacement = dofs.to_nodes(&solved.solution.displacement);
        let elasticity = solved.scene.material.elasticity();
        let (forces, stress) = internal_forces(solved.mesh, &elasticity, &displacement);
        Self {
            resultants: Resultants::new(solved, &frame, &displacement, &forces),
            certificate: Certificate::new(solved, &friction, &panes),
            von_mises: stress.iter().map(von_mises).collect(),
            stress,
            panes,
            friction,
            displacement,
        }
    }

    /// Number of panes in a zone.
    #[must_use]
    pub fn count(&self, zone: Zone) -> usize {
        self.panes.iter().filter(|pane| pane.zone == zone).count()
    }
}
