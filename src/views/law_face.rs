//! The contact face with the coefficients of friction at one state of slip, drawn without stresses.

use contact3d::{
    contact::{ContactFrame, FrictionField},
    mesh::{ContactSurface, Mesh},
};
use plots::{ContactPicture, DrawnFriction, DrawnSupport, DrawnZone, FrictionKind};
use units::Units;

use super::contact_cells::ContactCells;

/// A contact face with the coefficients of friction of one state of slip, and no stresses.
pub(super) struct LawFace {
    number: usize,
    cells: ContactCells,
    displacement: Vec<[f64; 3]>,
    friction: Vec<DrawnFriction>,
    normal_stress: Vec<f64>,
}

impl LawFace {
    /// The face with a number in the order of the multipliers.
    pub(super) fn new(
        mesh: &Mesh,
        surface: &ContactSurface,
        number: usize,
        field: &FrictionField,
    ) -> Self {
        let face = &surface.faces[number];
        let cells = ContactCells::new(mesh, Some((surface, face)));
        let panes: Vec<[f64; 2]> = face.panes.clone().map(|i| field.pane(i)).collect();
        let friction = cells.of_cells(&panes, &unloaded([f64::NAN; 2]), |f| unloaded(*f));
        Self {
            number,
            displacement: vec![[0.0; 3]; cells.coordinates.len()],
            normal_stress: vec![0.0; friction.len()],
            friction,
            cells,
        }
    }

    /// The face as the figures take it.
    pub(super) fn picture<'a>(
        &'a self,
        title: &'a str,
        units: Units,
        frame: &ContactFrame,
    ) -> ContactPicture<'a> {
        let reference = frame.references[self.number];
        let [axis_1, axis_2] = reference.axes;
        ContactPicture {
            title,
            units,
            coordinates: &self.cells.coordinates,
            displacement: &self.displacement,
            boundary_triangles: &[],
            boundary_face: &[],
            contact_triangles: &self.cells.triangles,
            contact_triangle_pane: &self.cells.pane,
            normal: reference.normal,
            support: DrawnSupport::Plane,
            axis_1,
            axis_2,
            normal_stress: &self.normal_stress,
            friction: Some((FrictionKind::OverPressure, &self.friction)),
        }
    }
}

/// Coefficients without stresses.
fn unloaded(coefficients: [f64; 2]) -> DrawnFriction {
    DrawnFriction {
        scaled_tangential: 0.0,
        semi_axes: coefficients,
        stress: [0.0; 2],
        turn: 0.0,
        zone: DrawnZone::Open,
    }
}
