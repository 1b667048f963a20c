//! A bound of the discretisation error that needs no finer mesh and no constant.
//!
//! Let σ balance the loads and the contact stresses λ_h at every point. For the body under λ_h (W. Prager, J. L. Synge, Quart. Appl.
//! Math. 5 (1947) 241)
//!
//! ‖u − u_h‖_A ≤ ‖σ − C ε(u_h)‖, the norm of stresses in the compliance C⁻¹.
//!
//! Without friction and with a given slip bound g, equilibrium is a minimum of energy. Then, for any displacement v that penetrates
//! nowhere, the gap of duality bounds the error of the contact stresses too:
//!
//! ‖u − v‖² ≤ ‖σ − C ε(v)‖² + 2 ∫ λ_ν (d − v_ν) + 2 ∫ (g ‖F v_t‖ − λ_t·v_t), and v = u_h − w, where w lifts what penetrates.
//!
//! σ is made in three steps: forces of the sides of tetrahedra in balance (`equilibration`), which come closer to C ε (`descent`), and
//! the stress inside tetrahedra that belongs to them (`macro_stress`). No integral is approximated, but equilibrium holds to rounding.

mod admissible;
mod descent;
mod equilibration;
mod macro_stress;
mod scope;
mod sides;

use contact3d::{
    elasticity::{MaterialField, corner_strains},
    post::{LoadedBoundary, Solved},
    scene::InvalidValue,
};
use nalgebra::{Vector3, Vector6};

use admissible::Admissible;
use descent::Descent;
use equilibration::Balanced;
use macro_stress::{MacroElement, Target};
use sides::{MeshSides, Side, SideForces};

/// A bound of the distance of a discrete solution from the exact one, in the energy norm ‖v‖_A = √a(v, v), √J.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorBound {
    /// The bound and its parts in √J.
    pub parts: BoundParts,
    /// ‖u_h‖_A.
    pub displacement: f64,
    /// The balanced forces between tetrahedra that prove the bound.
    pub forces: Vec<SideForce>,
}

/// A bound and its parts. What contact adds is `None` without contact, and where equilibrium is no minimum of energy: friction that
/// follows the pressure, slip bounds and gaps that are formulas.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BoundParts {
    /// Bound of the error for the contact stresses as they are.
    pub elements: f64,
    /// Bound of the whole error; `None` where only that for given contact stresses is known.
    pub total: Option<f64>,
    /// ‖w‖_A of the displacement that lifts what penetrates inside panes.
    pub lifting: Option<f64>,
    /// √(2 ∫ λ_ν (d − v_ν)): pressure across a gap.
    pub complementarity: Option<f64>,
    /// √(2 ∫ (g ‖F v_t‖ − λ_t·v_t)): slip that friction does not oppose; `None` without friction.
    pub friction: Option<f64>,
}

/// The balanced traction of a side of a tetrahedron, linear on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SideForce {
    /// Corners, increasing.
    pub nodes: [usize; 3],
    /// The tetrahedron that it acts on; its opposite acts on the one on the other side.
    pub tetrahedron: usize,
    /// ∫ λ_a σν in N of its three corners.
    pub force: [[f64; 3]; 3],
}

impl ErrorBound {
    /// Bounds the error of an answer.
    ///
    /// # Errors
    /// [`InvalidValue`] for scenes whose loads or supports no stress of this kind can balance.
    pub fn new(solved: &Solved<'_>) -> Result<Self, InvalidValue> {
        scope::check(solved)?;
        let (scene, mesh) = (solved.scene, solved.mesh);
        let material = MaterialField::new(scene, mesh);
        let displacement = solved.system.dofs.to_nodes(&solved.solution.displacement);
        let strain = corner_strains(mesh, &displacement);
        let stress: Vec<[Vector6<f64>; 4]> = strain
            .iter()
            .enumerate()
            .map(|(t, strain)| strain.map(|it| material.tensor(t) * it))
            .collect();
        let sides = MeshSides::new(mesh);
        let (traction, is_free) = boundary_loads(solved, &sides);
        let body_force = scene.body_force.as_ref().map_or(Vector3::zeros(), |force| {
            Vector3::from(std::array::from_fn(|c| force.value[c].at([0.0; 3])))
        });
        let balanced = Balanced {
            mesh,
            sides: &sides,
            stress: &stress,
            body_force,
            traction: &traction,
            is_free: &is_free,
        };
        let mut forces = balanced.forces().ok_or_else(|| scope::unbalanced(solved))?;
        let compliances = material.compliances();
        let elements: Vec<MacroElement> = mesh
            .tetrahedra
            .iter()
            .enumerate()
            .map(|(t, corners)| {
                MacroElement::new(&mesh.corners(corners), &compliances[material.region(t)])
            })
            .collect();
        let target = |strain: &[[Vector6<f64>; 4]]| Target::new(&elements, &material, strain);
        let own = target(&strain);
        let descent = Descent {
            mesh,
            sides: &sides,
            elements: &elements,
            target: &own,
            body_force,
            is_free: &is_free,
        };
        let data = descent.improve(&mut forces);
        let bound = own.distance(&data).sqrt();
        let admissible = Admissible::new(solved)?;
        let without_contact = BoundParts {
            elements: bound,
            total: solved.contact.is_none().then_some(bound),
            ..BoundParts::default()
        };
        Ok(Self {
            parts: admissible.map_or(without_contact, |it| BoundParts {
                elements: bound,
                ..it.bound(mesh, &strain, &data, target)
            }),
            displacement: own.norm(),
            forces: shown(&sides, &forces),
        })
    }

    /// Bound and parts over ‖u_h‖_A; 0 for a body that is not strained.
    #[must_use]
    pub fn relative(&self) -> BoundParts {
        let share = |bound: f64| match bound {
            0.0 => 0.0,
            bound => bound / self.displacement,
        };
        BoundParts {
            elements: share(self.parts.elements),
            total: self.parts.total.map(share),
            lifting: self.parts.lifting.map(share),
            complementarity: self.parts.complementarity.map(share),
            friction: self.parts.friction.map(share),
        }
    }
}

/// Of each side, `[n_sides]`, the traction in Pa that loads it, zero inside the body, and the components whose traction is unknown.
fn boundary_loads(solved: &Solved<'_>, sides: &MeshSides) -> (Vec<Vector3<f64>>, Vec<[bool; 3]>) {
    let boundary = LoadedBoundary::new(solved);
    let of_side = |side: &Side| match side.facet {
        None => (Vector3::zeros(), [true; 3]),
        Some(facet) => {
            let normal = side.area.normalize();
            // Loads are constant on a side.
            let at = solved.mesh.coordinates[side.nodes[0]];
            let traction = boundary.traction_of_solution(facet, at, &normal);
            (traction, boundary.held[facet])
        }
    };
    sides.sides.iter().map(of_side).unzip()
}

fn shown(sides: &MeshSides, forces: &SideForces) -> Vec<SideForce> {
    let sides = sides.sides.iter().zip(forces);
    sides
        .map(|(side, force)| SideForce {
            nodes: side.nodes,
            tetrahedron: side.inside,
            force: force.map(Into::into),
        })
        .collect()
}
