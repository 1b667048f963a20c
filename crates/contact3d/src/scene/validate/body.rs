//! Checks of the body.

use std::cmp::Ordering::Less;

use super::{positive, require};
use crate::scene::{
    Brick, BrickFace, InvalidValue, MOST_CELLS, MultiplierSpace, Scene, Shape, Written, numbers,
};

/// The largest exponent: with it, two cells alone differ a billionfold.
const MOST_EXPONENT: f64 = 30.0;

/// Narrowest cell over the edge: planes are rounded to 2e-16 of it, so widths keep seven digits.
const NARROWEST: f64 = 1e-9;

/// Largest ratio of two edges of a cell. Its stiffness goes with the square, and a double has 16 digits.
const SLENDEREST: f64 = 1e8;

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

pub(super) fn check(scene: &Scene) -> Result<(), InvalidValue> {
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

fn check_brick(brick: &Brick, scene: &Scene) -> Result<(), InvalidValue> {
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
    check_planes(brick)
}

/// Checks graded cells and given planes of a brick with positive edges and a moderate number of cells.
fn check_planes(brick: &Brick) -> Result<(), InvalidValue> {
    for (face, name) in BrickFace::ALL.into_iter().zip(BrickFace::NAMES) {
        let exponent = brick.grading.towards(face);
        require(
            (1.0..=MOST_EXPONENT).contains(&exponent),
            format!("body.brick.grading.{name}"),
            &format!("an exponent from 1, for equal cells, to {MOST_EXPONENT}"),
            Written(&exponent),
            "the first of n cells has the share (1/n)^exponent of the edge; 1.5 and 2 are common",
        )?;
    }
    for axis in 0..3 {
        if let Some(given) = brick.coordinates.along(axis) {
            check_given(brick, axis, given)?;
        }
    }
    check_widths(brick)
}

fn check_given(brick: &Brick, axis: usize, given: &[f64]) -> Result<(), InvalidValue> {
    let (name, length, cells) = (AXES[axis], brick.size[axis], brick.cells[axis]);
    let key = || format!("body.brick.coordinates.{name}");
    let disorder = given
        .windows(2)
        .find(|pair| pair[0].partial_cmp(&pair[1]) != Some(Less));
    require(
        given.len() > 1 && disorder.is_none(),
        key(),
        "at least two coordinates, each greater than the one before",
        numbers(disorder.unwrap_or(given)),
        "give the coordinates of the planes between cells in increasing order, both faces among them",
    )?;
    require(
        (given[0], given[given.len() - 1]) == (0.0, length),
        key(),
        &format!(
            "coordinates from 0 to {}, the edge in body.brick.size",
            Written(&length)
        ),
        format!(
            "{} to {}",
            Written(&given[0]),
            Written(&given[given.len() - 1])
        ),
        "the brick starts at the origin; change body.brick.size or the coordinates",
    )?;
    let mut fitting = brick.cells;
    fitting[axis] = given.len() - 1;
    require(
        given.len() == cells + 1,
        key(),
        &format!(
            "{} coordinates for the {cells} cells along {name}",
            cells + 1
        ),
        given.len(),
        &format!(
            "set body.brick.cells to {}, or change the coordinates",
            Written(&fitting)
        ),
    )?;
    require(
        brick.grading.along(axis) == [1.0; 2],
        key(),
        &format!("either given coordinates or graded cells along {name}"),
        format!("both, exponents {}", numbers(&brick.grading.along(axis))),
        &format!(
            "leave one of body.brick.coordinates.{name} and the exponents of {name}_min and {name}_max in body.brick.grading"
        ),
    )
}

/// Refuses cells too thin to compute with.
fn check_widths(brick: &Brick) -> Result<(), InvalidValue> {
    if (0..3).all(|axis| brick.is_even(axis)) {
        return Ok(());
    }
    let widths = [0, 1, 2].map(|axis| extreme_widths(&brick.planes(axis)));
    for axis in (0..3).filter(|axis| !brick.is_even(*axis)) {
        let (name, [narrowest, _]) = (AXES[axis], widths[axis]);
        let (key, help) = match brick.coordinates.along(axis) {
            Some(_) => ("coordinates", "move planes apart"),
            None => ("grading", "choose smaller exponents or fewer cells"),
        };
        let key = || format!("body.brick.{key}.{}", steepest(brick, axis).unwrap_or(name));
        require(
            narrowest >= NARROWEST * brick.size[axis],
            key(),
            &format!("cells no narrower than {NARROWEST:e} of the edge"),
            format!("one of {:.1e} of it", narrowest / brick.size[axis]),
            help,
        )?;
        let others = (0..3).filter(|other| *other != axis);
        let longest = others.map(|other| widths[other][1]).fold(0.0, f64::max);
        require(
            longest <= SLENDEREST * narrowest,
            key(),
            &format!("cells whose edges differ at most {SLENDEREST:e} times"),
            format!("a cell of {longest:.1e} by {narrowest:.1e}"),
            help,
        )?;
    }
    let smallest: f64 = widths.iter().map(|[narrowest, _]| narrowest).product();
    require(
        smallest.is_normal(),
        "body.brick.size",
        "lengths [m] with which the volume of the smallest cell is at least 1e-307",
        Written(&brick.size),
        "choose a unit of length in which the body has a moderate size",
    )
}

/// Narrowest and widest cell between planes.
fn extreme_widths(planes: &[f64]) -> [f64; 2] {
    let widths = planes.windows(2).map(|pair| pair[1] - pair[0]);
    widths.fold([f64::INFINITY, 0.0], |[least, most], width| {
        [least.min(width), most.max(width)]
    })
}

/// The face of an axis towards which cells shrink most; `None` for given planes.
fn steepest(brick: &Brick, axis: usize) -> Option<&'static str> {
    let [lower, upper] = brick.grading.along(axis);
    let place = 2 * axis + usize::from(upper > lower);
    (lower.max(upper) > 1.0).then_some(BrickFace::NAMES[place])
}
