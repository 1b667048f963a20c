//! Glued faces: fields that both meshes hold exactly, one block in the place of several, bodies that float together, and refusals.

use std::path::Path;

use contact3d::{
    AssembledProblem, Problem,
    adaptation::{AdaptiveStatus, adapted},
    post::{ContactReport, StressConcentration},
    scene::{
        AdaptSettings, Body, Clamp, Component, Contact, ElementOrder, FirstMesh, Friction,
        Material, MultiplierSpace, Pressure, Quantity, Scene, Traction,
    },
};

const MODULUS: f64 = 1e9;
const POISSON: f64 = 0.3;
const PRESSURE: f64 = 1e6;

/// A constant stress over [`PRESSURE`].
const STRESS: [[f64; 3]; 3] = [[2.0, -0.4, 0.7], [-0.4, 1.0, 0.3], [0.7, 0.3, -1.5]];

/// The sides of a block, each with its axis and the sign of its normal.
const SIDES: [(&str, usize, f64); 6] = [
    ("x_min", 0, -1.0),
    ("x_max", 0, 1.0),
    ("y_min", 1, -1.0),
    ("y_max", 1, 1.0),
    ("z_min", 2, -1.0),
    ("z_max", 2, 1.0),
];

/// The strain of that stress.
fn strain() -> [[f64; 3]; 3] {
    let trace: f64 = (0..3).map(|c| STRESS[c][c]).sum();
    [0, 1, 2].map(|i| {
        [0, 1, 2].map(|j| {
            let volume = if i == j { POISSON * trace } else { 0.0 };
            ((1.0 + POISSON) * STRESS[i][j] - volume) * PRESSURE / MODULUS
        })
    })
}

fn exact(x: [f64; 3]) -> [f64; 3] {
    strain().map(|row| (0..3).map(|j| row[j] * x[j]).sum())
}

/// A clamp that moves a face as that strain does.
fn strained(face: &str) -> Clamp {
    let formula = |[a, b, c]: [f64; 3]| {
        Quantity::formula(&format!("({a:e})*x + ({b:e})*y + ({c:e})*z")).expect("a formula")
    };
    Clamp {
        value: strain().map(formula),
        ..Clamp::face(face)
    }
}

fn material() -> Material {
    Material::isotropic(MODULUS, POISSON)
}

/// A block of some height on a unit square from z on.
fn block(cells: [usize; 3], element: ElementOrder, [z, height]: [f64; 2]) -> Body {
    Body::brick([1.0, 1.0, height], cells)
        .with_element(element)
        .at([0.0, 0.0, z])
}

/// Two blocks of so many cells along each edge, a little apart, whose faces are glued.
fn stack([lower, upper]: [usize; 2], element: ElementOrder, apart: f64) -> Scene {
    let lower = block([lower; 3], element, [0.0, 1.0]);
    let upper = block([upper; 3], element, [1.0 + apart, 1.0]);
    Scene::new(lower.named("lower"), material())
        .with_body(upper.named("upper"))
        .with_contact(Contact::glued("lower.z_max", "upper.z_min"))
}

fn solved(scene: &Scene) -> (AssembledProblem, ContactReport) {
    let problem = Problem::new(scene.clone()).and_then(Problem::assemble);
    let problem = problem.unwrap_or_else(|error| panic!("{error}"));
    let solution = problem.solve(&scene.solve).expect("a solution");
    assert!(solution.status.is_solved(), "{:?}", solution.status);
    let report = problem.report(&solution).expect("finite loads");
    (problem, report)
}

/// The largest difference from a displacement over some size.
fn farthest(
    (problem, report): &(AssembledProblem, ContactReport),
    exact: impl Fn([f64; 3]) -> [f64; 3],
    size: f64,
) -> f64 {
    let nodes = problem.mesh().coordinates.iter().zip(&report.displacement);
    let off = nodes.flat_map(|(x, u)| {
        let exact = exact(*x);
        [0, 1, 2].map(|c| (u[c] - exact[c]).abs() / size)
    });
    off.fold(0.0, f64::max)
}

fn energy((_, report): &(AssembledProblem, ContactReport)) -> f64 {
    report.resultants.strain_energy
}

/// Constant stress with shears on the joint is a field of both meshes, whichever nodes follow, and where a gap was closed.
#[test]
fn constant_stress_passes_between_meshes_that_do_not_match() {
    let (p1, p2) = (ElementOrder::P1, ElementOrder::P2);
    let (lower, upper) = ("lower.z_max", "upper.z_min");
    for (element, cells, side, apart) in [
        (p1, [2, 3], lower, 0.0),
        (p1, [2, 3], upper, 0.05),
        (p1, [3, 1], upper, 0.0),
        (p2, [2, 3], upper, 0.05),
        (p2, [3, 1], lower, 0.0),
    ] {
        let mut scene = stack(cells, element, apart);
        scene.contacts[0].panes_on = Some(side.into());
        for body in ["lower", "upper"] {
            for (face, axis, sign) in SIDES.into_iter().filter(|side| side.1 < 2) {
                let value = STRESS.map(|row| sign * PRESSURE * row[axis]);
                scene = scene.with_traction(Traction::on(format!("{body}.{face}"), value));
            }
        }
        let top = STRESS.map(|row| PRESSURE * row[2]);
        let scene = scene.with_clamp(strained("lower.z_min"));
        let solution = solved(&scene.with_traction(Traction::on("upper.z_max", top)));
        // 6e-14 with linear elements and 7e-13 with quadratic ones measured.
        let off = farthest(&solution, exact, 2.0 * PRESSURE / MODULUS);
        assert!(off < 1e-10, "{element:?} {cells:?} {side}: {off}");
        let report = &solution.1;
        assert!(report.resultants.force_imbalance < 1e-12);
        assert!(report.resultants.moment_imbalance < 1e-12);
        // What passes the joint balances, so that nothing is left to estimate.
        assert!(report.discretisation_error.relative() < 1e-6);
        let joint = report.forces.iter().filter(|row| row.source == "contact");
        for row in joint {
            let sign = if row.face == upper { -1.0 } else { 1.0 };
            let differs = |c: usize| (row.force[c] - sign * top[c]).abs() > 1e-9 * PRESSURE;
            assert!(!(0..3).any(differs), "{row:?}");
        }
    }
}

/// A bar that is clamped at one end and bent at the other.
fn bent(scene: Scene, [base, top]: [&str; 2]) -> Scene {
    let moved = Clamp {
        value: [1e-3, 0.0, -2e-4].map(Into::into),
        ..Clamp::face(top)
    };
    scene.with_clamp(Clamp::face(base)).with_clamp(moved)
}

/// Where meshes match, glued blocks are one; elsewhere they approach it, and the estimate tells by how much.
#[test]
fn glued_blocks_are_one_in_the_limit() {
    let (p1, p2) = (ElementOrder::P1, ElementOrder::P2);
    let whole = |element, n: usize| {
        let block = block([n, n, 2 * n], element, [0.0, 2.0]);
        solved(&bent(Scene::new(block, material()), ["z_min", "z_max"]))
    };
    let ends = ["lower.z_min", "upper.z_max"];
    let parts = |element, cells| solved(&bent(stack(cells, element, 0.0), ends));
    for element in [p1, p2] {
        let same = energy(&parts(element, [2, 2])) / energy(&whole(element, 2)) - 1.0;
        assert!(same.abs() < 1e-12, "{same}");
    }
    // The energy of a displaced bar is larger than the exact one by ‖u_h − u‖².
    let exact = energy(&whole(p2, 5));
    let error = |found: &(AssembledProblem, ContactReport)| (1.0 - exact / energy(found)).sqrt();
    for element in [p1, p2] {
        let found = parts(element, [2, 3]);
        let [coarse, fine] = [2, 3].map(|n| error(&whole(element, n)));
        assert!((fine..coarse).contains(&error(&found)), "{element:?}");
        // 1.05 and 1.2 measured, as in the bar of one block.
        let effectivity = found.1.discretisation_error.relative() / error(&found);
        assert!(
            (0.8..1.4).contains(&effectivity),
            "{element:?} {effectivity}"
        );
    }
}

/// Two glued blocks that only contact holds are one body that floats on a third, with friction beside the joint.
#[test]
fn glued_bodies_float_together() {
    let element = ElementOrder::P1;
    let mut scene = stack([4, 3], element, 0.0)
        .with_body(block([2; 3], element, [-1.0, 1.0]).named("base"))
        .with_contact(Contact::between("base.z_max", "lower.z_min"))
        .with_friction(Friction::coulomb(0.3))
        .with_pressure(Pressure::on("upper.z_max", PRESSURE));
    for axis in [Component::X, Component::Y, Component::Z] {
        let face = format!("base.{}_min", axis.word());
        scene = scene.with_clamp(Clamp::face(face).along(&[axis]));
    }
    let solution = solved(&scene);
    let modes = solution.0.system.assembly.primal.rigid_modes.as_ref();
    assert_eq!(modes.map(|modes| modes.n_modes()), Some(6));
    let strain = PRESSURE / MODULUS;
    let exact = |[x, y, z]: [f64; 3]| [POISSON * x, POISSON * y, -z - 1.0].map(|u| u * strain);
    let off = farthest(&solution, exact, strain);
    assert!(off < 1e-10, "{off}");
    let report = &solution.1;
    let forces = report
        .forces
        .iter()
        .filter(|row| row.source.starts_with("contact"));
    let forces: Vec<(&str, f64)> = forces.map(|row| (&*row.face, row.force[2])).collect();
    assert_eq!(forces.len(), 4, "{forces:?}");
    assert!(
        forces
            .iter()
            .all(|(_, force)| (force.abs() / PRESSURE - 1.0).abs() < 1e-10)
    );
    assert!(report.certificate.worst() < 1e-9);
    scene.contacts.pop();
    scene.friction = None;
    let free = refusal(scene);
    assert!(
        free.contains("of the body lower with upper: free: translation along x"),
        "{free}"
    );
}

/// Nodes on rollers follow along the other axes alone.
#[test]
fn clamped_components_stay() {
    let mut scene = stack([2, 3], ElementOrder::P2, 0.0)
        .with_clamp(Clamp::face("lower.z_min").along(&[Component::Z]))
        .with_pressure(Pressure::on("upper.z_max", PRESSURE));
    for body in ["lower", "upper"] {
        for axis in [Component::X, Component::Y] {
            let face = format!("{body}.{}_min", axis.word());
            scene = scene.with_clamp(Clamp::face(face).along(&[axis]));
        }
    }
    let solution = solved(&scene);
    let strain = PRESSURE / MODULUS;
    let exact = |[x, y, z]: [f64; 3]| [POISSON * x, POISSON * y, -z].map(|u| u * strain);
    let off = farthest(&solution, exact, strain);
    assert!(off < 1e-10, "{off}");
    assert!(solution.1.resultants.force_imbalance < 1e-12);
    // Shear moves what they hold.
    let mut sheared = stack([2, 3], ElementOrder::P1, 0.0).with_clamp(strained("lower.z_min"));
    for (body, (face, axis, sign)) in ["lower", "upper"]
        .into_iter()
        .flat_map(|body| SIDES.map(|side| (body, side)))
        .filter(|(_, (_, axis, _))| *axis < 2)
    {
        let face = format!("{body}.{face}");
        if face.ends_with("x_min") {
            let mut roller = strained(&face).along(&[Component::X]);
            roller.value[1..].fill(0.0.into());
            sheared = sheared.with_clamp(roller);
        }
        let value = STRESS.map(|row| sign * PRESSURE * row[axis]);
        sheared = sheared.with_traction(Traction::on(face, value));
    }
    let top = STRESS.map(|row| PRESSURE * row[2]);
    let sheared = solved(&sheared.with_traction(Traction::on("upper.z_max", top)));
    let off = farthest(&sheared, self::exact, 2.0 * PRESSURE / MODULUS);
    assert!(off < 1e-10, "{off}");
}

/// The pairs of faces in a ring of four blocks around the line x = y = 1.
const RING: [[&str; 2]; 4] = [
    ["a.x_max", "b.x_min"],
    ["b.y_max", "c.y_min"],
    ["c.x_min", "d.x_max"],
    ["d.y_min", "a.y_max"],
];

/// The face of each of these pairs whose nodes follow: by default, each block the next one, and two blocks a third one, which leaves the
/// fourth one without nodes to follow on the line.
const DEFAULT: [usize; 4] = [2; 4];
const CIRCLE: [usize; 4] = [0; 4];
const THIRD: [usize; 4] = [1, 0, 1, 0];

/// Its name, origin, size and cells.
type Block = (&'static str, [[f64; 3]; 2], [usize; 3]);

/// Blocks and pairs of their faces that are glued.
fn glued_blocks(element: ElementOrder, blocks: &[Block], pairs: &[[&str; 2]]) -> Scene {
    let bodies = blocks.iter().map(|(name, [origin, size], cells)| {
        let brick = Body::brick(*size, *cells).with_element(element);
        brick.named(*name).at(*origin)
    });
    let bodies: Vec<Body> = bodies.collect();
    let first = Scene::new(bodies[0].clone(), material());
    let scene = bodies.into_iter().skip(1).fold(first, Scene::with_body);
    let joints = pairs.iter().map(|[a, b]| Contact::glued(*a, *b));
    joints.fold(scene, Scene::with_contact)
}

fn ring(element: ElementOrder, cells: [usize; 4], follows: [usize; 4]) -> Scene {
    let origins = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let block = |k: usize| {
        let [x, y] = origins[k];
        (
            ["a", "b", "c", "d"][k],
            [[x, y, 0.0], [1.0; 3]],
            [cells[k]; 3],
        )
    };
    let mut scene = glued_blocks(element, &[0, 1, 2, 3].map(block), &RING);
    for (side, joint) in follows.into_iter().zip(&mut scene.contacts) {
        joint.panes_on = joint
            .between
            .as_ref()
            .and_then(|pair| pair.get(side).cloned());
    }
    scene
}

/// Three blocks on each other beside a column, of which the one in the middle has one cell across.
fn column() -> Scene {
    let blocks = [
        ("a", [[0.0, 0.0, 0.0], [2.0, 1.0, 1.0]], [4, 2, 2]),
        ("b", [[2.0, 0.0, 0.0], [1.0, 1.0, 3.0]], [2, 2, 6]),
        ("c", [[0.0, 0.0, 2.0], [2.0, 1.0, 1.0]], [4, 2, 2]),
        ("e", [[0.0, 0.0, 1.0], [2.0, 1.0, 1.0]], [4, 2, 1]),
    ];
    let pairs = [
        ["e.z_min", "a.z_max"],
        ["e.z_max", "c.z_min"],
        ["a.x_max", "b.x_min"],
        ["c.x_max", "b.x_min"],
        ["e.x_max", "b.x_min"],
    ];
    glued_blocks(ElementOrder::P1, &blocks, &pairs)
}

/// Four blocks around a fifth one, with so many cells along a length of 1, and in that one.
fn pinwheel(n: usize, inner: usize) -> Scene {
    let blocks = [
        ("a", [[0.0, 0.0, 0.0], [2.0, 1.0, 1.0]], [2 * n, n, n]),
        ("b", [[2.0, 0.0, 0.0], [1.0, 1.0, 2.0]], [n, n, 2 * n]),
        ("c", [[1.0, 0.0, 2.0], [2.0, 1.0, 1.0]], [2 * n, n, n]),
        ("d", [[0.0, 0.0, 1.0], [1.0, 1.0, 2.0]], [n, n, 2 * n]),
        ("e", [[1.0, 0.0, 1.0], [1.0, 1.0, 1.0]], [inner; 3]),
    ];
    let pairs = [
        ["a.x_max", "b.x_min"],
        ["b.z_max", "c.z_min"],
        ["c.x_min", "d.x_max"],
        ["d.z_min", "a.z_max"],
        ["e.z_min", "a.z_max"],
        ["e.x_max", "b.x_min"],
        ["e.z_max", "c.z_min"],
        ["e.x_min", "d.x_max"],
    ];
    glued_blocks(ElementOrder::P1, &blocks, &pairs)
}

/// The same whose inner block, with nodes at its corners alone, follows all others.
fn starved() -> Scene {
    let mut scene = pinwheel(2, 1);
    for joint in &mut scene.contacts[4..] {
        joint.panes_on = joint.between.as_ref().map(|pair| pair[0].clone());
    }
    scene
}

/// A cube cut into six blocks, of which one is a single cell between four others.
fn cut() -> Scene {
    let blocks = [
        ("a", [[0.5, 0.47, 0.0], [0.25, 0.53, 0.5]], [3, 4, 4]),
        ("e", [[0.75, 0.0, 0.0], [0.25, 1.0, 1.0]], [3, 4, 1]),
        ("f", [[0.5, 0.47, 0.5], [0.25, 0.53, 0.5]], [1; 3]),
        ("b", [[0.0, 0.0, 0.0], [0.5, 1.0, 0.5]], [3, 2, 3]),
        ("c", [[0.5, 0.0, 0.0], [0.25, 0.47, 1.0]], [2, 2, 4]),
        ("d", [[0.0, 0.0, 0.5], [0.5, 1.0, 0.5]], [1, 1, 3]),
    ];
    let pairs = [
        ["f.z_min", "a.z_max"],
        ["b.z_max", "d.z_min"],
        ["c.x_max", "e.x_min"],
        ["d.x_max", "f.x_min"],
        ["e.x_min", "f.x_max"],
        ["a.x_min", "b.x_max"],
        ["a.y_min", "c.y_max"],
        ["f.y_min", "c.y_max"],
        ["c.x_min", "b.x_max"],
        ["d.x_max", "c.x_min"],
        ["a.x_max", "e.x_min"],
    ];
    glued_blocks(ElementOrder::P1, &blocks, &pairs)
}

/// The pairs of faces in a wall of four blocks, two on two others, whose joints are not above each other.
const WALL: [[&str; 2]; 5] = [
    ["a.x_max", "b.x_min"],
    ["c.x_max", "d.x_min"],
    ["a.z_max", "c.z_min"],
    ["b.z_max", "c.z_min"],
    ["b.z_max", "d.z_min"],
];

fn wall(pairs: &[[&str; 2]]) -> Scene {
    let block =
        |name, [x, z]: [f64; 2], length, n| (name, [[x, 0.0, z], [length, 1.0, 1.0]], [n, 2, n]);
    let blocks = [
        block("a", [0.0, 0.0], 1.3, 2),
        block("b", [1.3, 0.0], 1.7, 4),
        block("c", [0.0, 1.0], 1.7, 3),
        block("d", [1.7, 1.0], 1.3, 4),
    ];
    glued_blocks(ElementOrder::P1, &blocks, pairs)
}

/// Joints that meet at a line carry constant stress past it, whichever nodes follow, and where a body has one cell between them or none is left
/// to follow.
#[test]
fn joints_may_meet() {
    let (p1, p2) = (ElementOrder::P1, ElementOrder::P2);
    for (case, scene) in [
        ring(p1, [3, 2, 3, 4], CIRCLE),
        ring(p1, [2, 3, 1, 2], THIRD),
        ring(p2, [2, 1, 2, 1], THIRD),
        ring(p2, [1, 2, 1, 2], CIRCLE),
        column(),
        pinwheel(2, 1),
        starved(),
        cut(),
        wall(&WALL),
    ]
    .into_iter()
    .enumerate()
    {
        let pairs = scene.contacts.iter().flat_map(|joint| joint.faces());
        let glued: Vec<String> = pairs.map(ToString::to_string).collect();
        let bodies: Vec<String> = (0..scene.bodies.len())
            .map(|k| scene.body_name(k))
            .collect();
        let mut scene = scene;
        let faces = bodies.iter().flat_map(|body| {
            SIDES.map(|(face, axis, sign)| (format!("{body}.{face}"), axis, sign))
        });
        for (face, axis, sign) in faces.filter(|(face, ..)| !glued.contains(face)) {
            scene = match &*face {
                "a.z_min" => scene.with_clamp(strained(&face)),
                _ => scene.with_traction(Traction::on(
                    face,
                    STRESS.map(|row| sign * PRESSURE * row[axis]),
                )),
            };
        }
        let solution = solved(&scene);
        let off = farthest(&solution, exact, 3.0 * PRESSURE / MODULUS);
        assert!(off < 1e-10, "{case}: {off}");
        assert!(solution.1.resultants.force_imbalance < 1e-12);
        assert!(solution.1.resultants.moment_imbalance < 1e-12);
    }
}

/// Joints do not depend on their order in the scene.
#[test]
fn joints_have_no_order() {
    let energy_of = |pairs: &[[&str; 2]]| {
        let scene = wall(pairs).with_clamp(Clamp::face("a.x_min"));
        energy(&solved(
            &scene.with_pressure(Pressure::on("d.z_max", PRESSURE)),
        ))
    };
    let first = energy_of(&WALL);
    for order in 0..24 {
        let mut left = WALL.to_vec();
        let [i, j, k] = [order % 4, order / 4 % 3, order / 12];
        let mut pairs: Vec<[&str; 2]> = [i, j, k].map(|place| left.remove(place)).to_vec();
        pairs.extend(left);
        // Sums in another order.
        let same = energy_of(&pairs) / first - 1.0;
        assert!(same.abs() < 1e-12, "{pairs:?}: {same}");
    }
}

/// A ring of blocks whose meshes match is one block, on its line too.
#[test]
fn rings_of_joints_close() {
    let moved = |face: &str| Clamp {
        value: [1e-3, -2e-4, 5e-4].map(Into::into),
        ..Clamp::face(face)
    };
    for element in [ElementOrder::P1, ElementOrder::P2] {
        let whole = Body::brick([2.0, 2.0, 1.0], [4, 4, 2]).with_element(element);
        let whole = Scene::new(whole, material()).with_clamp(Clamp::face("x_min"));
        let whole = energy(&solved(&whole.with_clamp(moved("x_max"))));
        for follows in [DEFAULT, CIRCLE, THIRD] {
            let mut parts = ring(element, [2; 4], follows);
            for (held, face) in [("a.x_min", "b.x_max"), ("d.x_min", "c.x_max")] {
                parts = parts.with_clamp(Clamp::face(held)).with_clamp(moved(face));
            }
            let same = energy(&solved(&parts)) / whole - 1.0;
            assert!(same.abs() < 1e-12, "{element:?} {follows:?}: {same}");
        }
    }
    let whole = Scene::new(Body::brick([3.0, 1.0, 3.0], [6, 2, 6]), material());
    let whole = whole
        .with_clamp(Clamp::face("x_min"))
        .with_clamp(moved("x_max"));
    let mut parts = pinwheel(2, 2);
    for (held, face) in [("a.x_min", "b.x_max"), ("d.x_min", "c.x_max")] {
        parts = parts.with_clamp(Clamp::face(held)).with_clamp(moved(face));
    }
    let same = energy(&solved(&parts)) / energy(&solved(&whole)) - 1.0;
    assert!(same.abs() < 1e-12, "{same}");
}

/// Levels cut both bodies and glue them anew.
#[test]
fn glued_bodies_are_refined() {
    let mut scene = bent(
        stack([2, 3], ElementOrder::P1, 0.0),
        ["lower.z_min", "upper.z_max"],
    );
    scene.adapt = Some(AdaptSettings {
        error: 0.35,
        start: FirstMesh::Scene,
        of: None,
    });
    let (answer, levels) = adapted(scene, Path::new("")).expect("levels");
    assert_eq!(levels.status, AdaptiveStatus::Met);
    let mesh = answer.problem.mesh();
    assert!(mesh.tetrahedra.len() > 2 * 175 && !mesh.glued.is_empty());
    assert!(answer.report.resultants.force_imbalance < 1e-12);
}

/// A post on a plate makes a notch around its foot, where stress grows with every mesh; blocks whose sides go on make none, unless they
/// differ.
#[test]
fn the_border_of_a_joint_may_be_a_notch() {
    let post = Body::brick([1.0; 3], [4; 3])
        .named("post")
        .at([1.0, 1.0, 1.0]);
    let plate = Body::brick([3.0, 3.0, 1.0], [6, 6, 2]).named("plate");
    let bent = Scene::new(plate, material())
        .with_body(post)
        .with_clamp(Clamp::face("plate.z_min"))
        .with_traction(Traction::on("post.z_max", [PRESSURE, 0.0, 0.0]))
        .with_contact(Contact::glued("post.z_min", "plate.z_max"));
    let largest = |scene: &Scene| solved(scene).1.largest_von_mises;
    let notch = largest(&bent);
    assert_eq!(notch.concentration, Some(StressConcentration::Notch));
    assert_eq!(notch.error, f64::INFINITY);
    let pressed = |scene: Scene| {
        let scene = scene.with_pressure(Pressure::on("upper.z_max", PRESSURE));
        scene
            .with_clamp(Clamp::face("lower.z_min").along(&[Component::Z]))
            .with_clamp(Clamp::face("lower.x_min").along(&[Component::X]))
            .with_clamp(Clamp::face("lower.y_min").along(&[Component::Y]))
    };
    let even = largest(&pressed(stack([2, 3], ElementOrder::P1, 0.0)));
    assert_eq!(even.concentration, None);
    // Rollers that end at a joint end on a flat side.
    let pulled = |held: &[&str]| {
        let scene = stack([2, 3], ElementOrder::P1, 0.0)
            .with_traction(Traction::on("upper.x_max", [PRESSURE, 0.0, 0.0]))
            .with_clamp(Clamp::face("lower.z_min").along(&[Component::Z]))
            .with_clamp(Clamp::face("lower.y_min").along(&[Component::Y]));
        let clamps = held
            .iter()
            .map(|face| Clamp::face(*face).along(&[Component::X]));
        largest(&clamps.fold(scene, Scene::with_clamp)).concentration
    };
    let rim = Some(StressConcentration::Clamp);
    assert_eq!(pulled(&["lower.x_min"]), rim);
    assert_eq!(pulled(&["lower.x_min", "upper.x_min"]), None);
    let mut stiff = stack([2, 3], ElementOrder::P1, 0.0);
    stiff.bodies[0].material = Some(Material::isotropic(20.0 * MODULUS, 0.0));
    let uneven = largest(&pressed(stiff));
    assert_eq!(uneven.concentration, Some(StressConcentration::Materials));
}

/// A gap that is closed, and a joint on a part of one triangle, are told; what triangles leave of a curved face is not.
#[test]
fn gaps_and_narrow_joints_are_told() {
    let told = |scene: Scene| -> Vec<String> {
        let problem = Problem::new(scene.with_clamp(Clamp::face("lower.z_min")));
        let warnings = problem.expect("a problem").warnings().into_iter();
        warnings.map(|warning| warning.to_string()).collect()
    };
    let p1 = ElementOrder::P1;
    assert_eq!(told(stack([2, 3], p1, 0.0)), [""; 0]);
    let apart = told(stack([2, 3], p1, 0.01));
    assert!(
        apart[0].starts_with("contact.between: the glued faces are up to 10 mm apart"),
        "{apart:?}"
    );
    let inside = told(stack([2, 3], p1, -0.01));
    assert!(inside[0].contains("overlap by up to 10 mm"), "{inside:?}");
    let rib = Body::brick([0.2, 1.0, 1.0], [1, 4, 4]).named("rib");
    let narrow = |cells: usize| {
        let lower = block([cells; 3], p1, [0.0, 1.0]).named("lower");
        Scene::new(lower, material())
            .with_body(rib.clone().at([0.3, 0.0, 1.0]))
            .with_contact(Contact::glued("lower.z_max", "rib.z_min"))
    };
    let coarse = told(narrow(2));
    assert!(
        coarse[0].starts_with(
            "contact.between: the joint covers 64 % of a triangle of lower.z_max at most"
        ),
        "{coarse:?}"
    );
    assert_eq!(told(narrow(10)), [""; 0]);
}

fn refusal(scene: Scene) -> String {
    let problem = Problem::new(scene).and_then(Problem::assemble);
    problem.expect_err("no problem").to_string()
}

#[test]
fn what_no_joint_is_is_refused() {
    let held = |change: &dyn Fn(&mut Scene)| {
        let scene = stack([2, 2], ElementOrder::P1, 0.0);
        let mut scene = scene.with_clamp(Clamp::face("lower.z_min"));
        change(&mut scene);
        refusal(scene)
    };
    let by_law = held(&|it| it.contacts[0].friction = Some(Friction::coulomb(0.3)));
    assert!(
        by_law.starts_with("contact.friction: expected no friction beside glued"),
        "{by_law}"
    );
    let by_common = held(&|it| it.friction = Some(Friction::coulomb(0.3)));
    assert!(
        by_common.starts_with("friction: expected a [contact] table that is not glued"),
        "{by_common}"
    );
    let far = held(&|it| it.bodies[1].origin[2] += 0.2);
    assert!(
        far.contains("up to 1.768e-1 m apart, a quarter of an edge"),
        "{far}"
    );
    let aside = held(&|it| it.bodies[1].origin[0] += 2.0);
    assert!(
        aside.contains("expected faces that look at each other"),
        "{aside}"
    );
    let twice = held(&|it| {
        it.contacts
            .push(Contact::between("upper.z_min", "lower.z_max"))
    });
    assert!(
        twice.contains("expected faces that are glued, or that touch"),
        "{twice}"
    );
    let on_foundation = held(&|it| it.contacts.push(Contact::on("upper.z_min")));
    assert!(
        on_foundation.starts_with("contact.1.face: expected a face, or a part"),
        "{on_foundation}"
    );
    let torn = held(&|it| {
        let at = |x: f64, face: &str| Clamp {
            value: [
                x.into(),
                Quantity::formula("z").expect("a formula"),
                0.0.into(),
            ],
            ..Clamp::face(face).along(&[Component::X, Component::Y])
        };
        let clamps = [at(0.0, "lower.x_min"), at(1e-3, "upper.x_min")];
        it.clamps.extend(clamps);
    });
    assert!(
        torn.contains("which clamp.1 says of the displacement along x at x, y, z = 0.0, 0.0, 1.0 on the other one of the glued faces lower.z_max and upper.z_min, found 0.001"),
        "{torn}"
    );
    let nodal = held(&|it| {
        let faces = ["lower.x_min", "upper.x_min"];
        it.contacts.extend(faces.map(|face| Contact {
            multipliers: MultiplierSpace::Nodal,
            ..Contact::on(face)
        }));
    });
    assert!(
        nodal.contains("multipliers: expected nodes that follow no others"),
        "{nodal}"
    );
    let loose = refusal(stack([2, 2], ElementOrder::P1, 0.0));
    assert!(loose.starts_with("clamp: expected at least one"), "{loose}");
}
