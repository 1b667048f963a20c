//! Checks of the body, its materials and its regions.

use std::cmp::Ordering::Less;

use nalgebra::Vector3;

use super::require;
use crate::scene::{
    Body, Brick, BrickFace, Contact, InvalidValue, Material, MultiplierSpace, Orthotropic,
    POSITION, Part, Scene, Voigt, Written, numbers,
};

/// Narrowest cell over the edge: planes are rounded to 2e-16 of it, so widths keep seven digits.
const NARROWEST_CELL: f64 = 1e-9;

/// Largest ratio of two edges of a cell. Its stiffness goes with the square, and a double has 16 digits.
const MOST_SLENDER_CELL: f64 = 1e8;

/// Relative rounding allowed to hand-typed numbers: symmetry of C, right angles of axes.
const TYPED_DIGITS: f64 = 1e-6;

pub(super) fn check(scene: &Scene) -> Result<(), InvalidValue> {
    for (i, body) in scene.bodies.iter().enumerate() {
        let key = scene.body_key(i);
        require(
            body.brick.is_some() != body.gmsh.is_some(),
            key.as_str(),
            "exactly one of brick, gmsh",
            if body.brick.is_some() { "both" } else { "none" },
            "a body is a brick or comes from a mesh file",
        )?;
        if let Some(brick) = &body.brick {
            check_brick(brick, i, scene).map_err(|invalid| under(&key, invalid))?;
        }
    }
    match scene.bodies.as_slice() {
        [only] => check_only(only)?,
        _ => check_several(scene)?,
    }
    require(
        scene.material.is_some() || scene.bodies.iter().all(|body| body.material.is_some()),
        "material",
        "the elastic law of every body",
        "none",
        "such as material.isotropic = { young_modulus = 2.1e11, poisson_ratio = 0.3 }",
    )?;
    for (key, material) in scene.materials() {
        check_law(material, &key, scene)?;
    }
    for (i, region) in scene.regions.iter().enumerate() {
        check_part(&region.part, &format!("region.{i}.part"), scene)?;
    }
    Ok(())
}

/// What is wrong with a body, under its key in the scene.
fn under(key: &str, invalid: InvalidValue) -> InvalidValue {
    let rest = invalid.key.strip_prefix("body").map(str::to_owned);
    InvalidValue {
        key: rest.map_or(invalid.key, |rest| format!("{key}{rest}")),
        ..invalid
    }
}

/// Refuses what tells several bodies apart where there is one.
fn check_only(body: &Body) -> Result<(), InvalidValue> {
    require(
        body.origin == [0.0; 3],
        "body.origin",
        "no origin of the only body",
        Written(&body.origin),
        "places of loads, obstacles and boxes are relative to it: leave the key out",
    )?;
    require(
        body.material.is_none(),
        "body.material",
        "the table [material] for the only body",
        "a material of its own",
        "several bodies may differ; parts of one are [[region]]",
    )
}

/// What several bodies owe each other: names of their own, one element.
fn check_several(scene: &Scene) -> Result<(), InvalidValue> {
    require(
        !scene.bodies.is_empty(),
        "body",
        "at least one [[body]]",
        "none",
        "add [body] with brick or gmsh",
    )?;
    for (i, body) in scene.bodies.iter().enumerate() {
        let key = scene.body_key(i);
        let name = body.name.as_deref().unwrap_or_default();
        let is_word =
            !name.is_empty() && !name.contains(['.', ' ']) && !name.contains(char::is_control);
        require(
            is_word,
            format!("{key}.name"),
            "a name without dots and spaces for each of several bodies",
            Written(&name),
            "the faces of the body begin with it, such as pad.z_min",
        )?;
        let mut before = scene.bodies[..i].iter();
        require(
            before.all(|other| other.name != body.name),
            format!("{key}.name"),
            "a name that no other body has",
            Written(&name),
            "faces could not tell the two bodies apart",
        )?;
        require(
            body.element == scene.element(),
            format!("{key}.element"),
            "the same element in all bodies",
            Written(&body.element),
            "give every body the same body.element",
        )?;
    }
    Ok(())
}

fn check_brick(brick: &Brick, body: usize, scene: &Scene) -> Result<(), InvalidValue> {
    let cell = [0, 1, 2].map(|axis| brick.size[axis] / brick.cells[axis] as f64);
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
    // Which of two faces has panes is known with the mesh alone.
    let panes = panes.filter(|contact| contact.between.is_none());
    let own = |c: &Contact| {
        scene
            .brick_face(&c.face)
            .filter(|(it, _)| std::ptr::eq(*it, brick))
    };
    let faces: Vec<BrickFace> = panes.filter_map(|c| Some(own(c)?.1)).collect();
    for (axis, &cells) in brick.cells.iter().enumerate() {
        let name = ["nx", "ny", "nz"][axis];
        let whole = cells.is_multiple_of(scene.bodies[body].element.cells_per_pane());
        let along = faces.iter().any(|face| face.axis() != axis);
        require(
            whole || !along,
            "body.brick.cells",
            &format!("{name} even along the contact face"),
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
    for axis in 0..3 {
        if let Some(given) = brick.coordinates.along(axis) {
            check_given(brick, axis, given)?;
        }
    }
    check_widths(brick)
}

fn check_given(brick: &Brick, axis: usize, given: &[f64]) -> Result<(), InvalidValue> {
    let (name, length, cells) = (POSITION[axis], brick.size[axis], brick.cells[axis]);
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
        let (name, [narrowest, _]) = (POSITION[axis], widths[axis]);
        let (key, help) = match brick.coordinates.along(axis) {
            Some(_) => ("coordinates", "move planes apart"),
            None => ("grading", "choose smaller exponents or fewer cells"),
        };
        let key = || format!("body.brick.{key}.{}", steepest(brick, axis).unwrap_or(name));
        require(
            narrowest >= NARROWEST_CELL * brick.size[axis],
            key(),
            &format!("cells no narrower than {NARROWEST_CELL:e} of the edge"),
            format!("one of {:.1e} of it", narrowest / brick.size[axis]),
            help,
        )?;
        let others = (0..3).filter(|other| *other != axis);
        let longest = others.map(|other| widths[other][1]).fold(0.0, f64::max);
        require(
            longest <= MOST_SLENDER_CELL * narrowest,
            key(),
            &format!("cells whose edges differ at most {MOST_SLENDER_CELL:e} times"),
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
    (lower.max(upper) > 1.0).then(|| BrickFace::ALL[place].word())
}

fn check_part(part: &Part, key: &str, scene: &Scene) -> Result<(), InvalidValue> {
    match part {
        Part::Group(name) => require(
            scene.bodies.iter().any(|body| body.gmsh.is_some()),
            format!("{key}.group"),
            "a box, since a brick has no physical volumes",
            Written(name),
            "write box = [[x, y, z], [x, y, z]] with two opposite corners",
        ),
        Part::Box([low, high]) => require(
            (0..3).all(|c| low[c] < high[c]),
            format!("{key}.box"),
            &format!(
                "two corners [min, max], min below max in x, y and z [{}]",
                scene.units.length()
            ),
            Written(&[low, high]),
            "give the lower corner first",
        ),
    }
}

fn check_law(material: &Material, key: &str, scene: &Scene) -> Result<(), InvalidValue> {
    match material {
        Material::Isotropic(_) => Ok(()),
        Material::Orthotropic(constants) => {
            check_axes(constants, &format!("{key}.orthotropic"))?;
            check_definite(material, &format!("{key}.orthotropic"), scene)
        }
        Material::Voigt(voigt) => {
            check_symmetry(voigt, &format!("{key}.voigt"), scene)?;
            check_definite(material, &format!("{key}.voigt"), scene)
        }
    }
}

fn check_axes(material: &Orthotropic, key: &str) -> Result<(), InvalidValue> {
    let [first, second] = material.axes.map(Vector3::from);
    let right_angle = first.dot(&second).abs() <= TYPED_DIGITS * first.norm() * second.norm();
    require(
        first.norm() > 0.0 && second.norm() > 0.0 && right_angle,
        format!("{key}.axes"),
        "two orthogonal vectors of positive length",
        Written(&material.axes),
        "the third material axis is their cross product",
    )
}

fn check_symmetry(material: &Voigt, key: &str, scene: &Scene) -> Result<(), InvalidValue> {
    let c = &material.stiffness;
    let largest = c
        .iter()
        .flatten()
        .fold(0.0_f64, |most, v| most.max(v.abs()));
    let symmetric =
        (0..6).all(|i| (0..i).all(|j| (c[i][j] - c[j][i]).abs() <= TYPED_DIGITS * largest));
    require(
        largest > 0.0 && symmetric,
        format!("{key}.stiffness"),
        &format!(
            "a symmetric 6 x 6 matrix of finite numbers [{}]",
            scene.units.stress()
        ),
        Written(c),
        "rows and columns are xx, yy, zz, yz, xz, xy, with engineering shear strains",
    )
}

/// Refuses an elasticity tensor whose smallest eigenvalue is not positive beyond rounding.
fn check_definite(material: &Material, key: &str, scene: &Scene) -> Result<(), InvalidValue> {
    let eigenvalues = material.elasticity().map(|c| c.symmetric_eigenvalues());
    let definite =
        eigenvalues.is_some_and(|e| e.min() > 6.0 * f64::EPSILON * e.max() && e.max().is_finite());
    require(
        definite,
        key,
        "a positive definite elasticity tensor",
        eigenvalues.map_or("no inverse of the compliance".to_owned(), |e| {
            let (least, most) = (e.min(), e.max());
            format!(
                "eigenvalues from {least:.3e} to {most:.3e} {}",
                scene.units.stress()
            )
        }),
        "every strain must store energy: reduce the Poisson ratios (|nu_ij| < sqrt(E_i/E_j)) or the off-diagonal entries",
    )
}
