//! The meshes that refining starts from, where a scene leaves them open.

use super::{AdaptSettings, Brick, BrickFace, Contact, ElementOrder, FirstMesh, Scene};

impl Scene {
    /// The scene with the mesh that refining starts from: where it [leaves its mesh open](Self::leaves_mesh_open), a brick gets as
    /// few cells as keep their shape: two along its shortest edge, four with panes of 2 × 2 cells.
    ///
    /// What is chosen stands in the scene, so choosing again changes nothing.
    #[must_use]
    pub fn with_first_mesh(mut self) -> Self {
        let element = self.body.element;
        if self.leaves_mesh_open()
            && let Some(brick) = self.body.as_brick_mut()
        {
            brick.cells = fewest_cells(brick, element);
        }
        self
    }

    /// The scene with other cells of its brick, which shrink towards the faces of clamps, loads and contact: at their edges
    /// stresses are singular or jump.
    #[must_use]
    pub fn with_graded_cells(mut self, cells: [usize; 3]) -> Self {
        let faces = self.named_faces().into_iter();
        let faces = faces.filter_map(|(_, name)| BrickFace::named(&name));
        if let Some(brick) = self.body.as_brick_mut() {
            let equal = Brick::new(brick.size, cells);
            // On the published problem at 24 × 8 × 8 cells the exponent 1.5 leaves 2.8 % of estimated error where equal cells
            // leave 4.1 %, and 2 as much as they.
            let towards = |brick: Brick, face| brick.with_grading(face, 1.5);
            *brick = faces.fold(equal, towards);
        }
        self
    }

    /// Whether the scene asks for an error, starts coarse, and equal cells of any size show all that it says.
    #[must_use]
    pub fn leaves_mesh_open(&self) -> bool {
        let starts_coarse = |adapt: AdaptSettings| adapt.start == FirstMesh::Coarse;
        self.adapt.is_some_and(starts_coarse) && self.is_shown_by_any_cells()
    }

    /// Whether equal cells of any size show all that the scene says.
    fn is_shown_by_any_cells(&self) -> bool {
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
