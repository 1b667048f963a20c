//! The mesh that refining starts from, where a scene leaves it open.

use super::{Brick, Contact, ElementOrder, FirstMesh, Scene};

impl Scene {
    /// The scene with the mesh that refining starts from. Where it asks for an error, starts coarse, and every coarse mesh shows
    /// all that it says, a brick gets as few cells as keep their shape: two along its shortest edge, four with panes of 2 × 2 cells.
    ///
    /// What is chosen stands in the scene (`adapt.start = "scene"`), so choosing again changes nothing.
    #[must_use]
    pub fn with_first_mesh(mut self) -> Self {
        let leaves_open = self.leaves_mesh_open();
        let element = self.body.element;
        let Some(adapt) = &mut self.adapt else {
            return self;
        };
        if std::mem::replace(&mut adapt.start, FirstMesh::Scene) == FirstMesh::Coarse
            && leaves_open
            && let Some(brick) = self.body.as_brick_mut()
        {
            brick.cells = fewest_cells(brick, element);
        }
        self
    }

    /// Whether equal cells of any size show all that the scene says.
    fn leaves_mesh_open(&self) -> bool {
        let is_whole_and_flat = |face: &Contact| face.obstacle.is_none() && face.corners.is_none();
        let has_equal_cells = |brick: &Brick| (0..3).all(|axis| brick.is_even(axis));
        self.body.as_brick().is_some_and(has_equal_cells)
            && self.contacts.iter().all(is_whole_and_flat)
            && self.regions.is_empty()
            && !self.clamps.iter().any(|clamp| clamp.corners.is_some())
            && !self.depends_on_place()
    }
}

/// The fewest cells of the shape that those of a brick have, `[nx, ny, nz]`: whole panes along every edge.
fn fewest_cells(brick: &Brick, element: ElementOrder) -> [usize; 3] {
    let pane = element.cells_per_pane();
    let shortest = brick.cells.into_iter().min().unwrap_or(1);
    let factor = shortest as f64 / (2 * pane) as f64;
    if factor <= 1.0 {
        return brick.cells;
    }
    // A count divided by what makes the smallest one 2 panes.
    let panes = |cells: usize| (cells as f64 / (factor * pane as f64)).round() as usize;
    brick.cells.map(|cells| pane * panes(cells))
}
