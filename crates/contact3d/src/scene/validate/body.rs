//! Checks of the body.

use super::{brick_planes, positive, require};
use crate::scene::{Brick, BrickFace, Invalid, MOST_CELLS, MultiplierSpace, Scene, Shape, Written};

pub(super) fn check(scene: &Scene) -> Result<(), Invalid> {
    match &scene.body.shape {
        Shape::Brick(brick) => check_brick(brick, scene),
        Shape::Gmsh(gmsh) => require(
            positive(gmsh.unit),
            "body.gmsh.unit",
            &format!("a positive length [{}]", scene.units.length()),
            Written(&gmsh.unit),
            "give the length of the file's unit, 0.001 for a mesh in millimetres and a scene in metres",
        ),
    }
}

fn check_brick(brick: &Brick, scene: &Scene) -> Result<(), Invalid> {
    require(
        brick.size.iter().all(|&l| positive(l)),
        "body.brick.size",
        &format!("three positive lengths [{}]", scene.units.length()),
        Written(&brick.size),
        "give the edge lengths Lx, Ly, Lz",
    )?;
    let cell = [0, 1, 2].map(|axis| brick.size[axis] / brick.cells[axis].max(1) as f64);
    require(
        [brick.size, cell]
            .iter()
            .all(|edges| edges.iter().product::<f64>().is_normal()),
        "body.brick.size",
        "lengths [m] whose product, the volume, is between 1e-307 and 1e308, for a cell as well",
        Written(&brick.size),
        "choose a unit of length in which the body has a moderate size",
    )?;
    let panes = scene.contacts.iter();
    let panes = panes.filter(|contact| contact.multipliers == MultiplierSpace::Panes);
    let faces: Vec<BrickFace> = panes.filter_map(|c| BrickFace::named(&c.face)).collect();
    for (axis, &cells) in brick.cells.iter().enumerate() {
        let name = ["nx", "ny", "nz"][axis];
        let whole = cells.is_multiple_of(scene.body.element.cells_per_pane());
        let along = faces.iter().any(|face| face.axis() != axis);
        require(
            (1..=MOST_CELLS).contains(&cells) && (whole || !along),
            "body.brick.cells",
            &format!("{name} from 1 to {MOST_CELLS}, even along the contact face"),
            Written(&brick.cells),
            "a pane is 2 x 2 cells of the contact face, so both of its cell counts are even; nodal multipliers and body.element = \"P2\" take any",
        )?;
        let opposite = faces
            .iter()
            .any(|face| face.axis() == axis && face.is_max())
            && faces
                .iter()
                .any(|face| face.axis() != axis || !face.is_max());
        require(
            whole || !opposite,
            "body.brick.cells",
            &format!("{name} even between contact faces"),
            Written(&brick.cells),
            "the diagonals of the cells meet in the middle of a pane on both faces where an even number of cells lies between them",
        )?;
    }
    brick_planes::check(brick)
}
