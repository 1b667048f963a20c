//! Scenes in a mirror and with exchanged axes have the mirrored and exchanged solutions.

mod image;

use std::ops::Range;

use contact3d::{
    AssembledProblem, Problem,
    scene::{Brick, BrickFace, DualOperatorKind, Scene},
    solver::Status,
};

use image::{Kind, Symmetry};

/// Relative difference of the multipliers of a scene and those of its image, pane by pane where they come from.
fn difference(scene: &Scene, kind: Kind) -> f64 {
    let symmetry = Symmetry::new(kind, scene);
    let solved = |mut scene: Scene| {
        scene.assemble.dual_operator = DualOperatorKind::Explicit;
        let problem = Problem::new(scene).unwrap().assemble().unwrap();
        let solution = problem.solve(&problem.scene().solve).unwrap();
        assert_eq!(solution.status, Status::Converged);
        (problem, solution.multiplier)
    };
    let (own, multiplier) = solved(scene.clone());
    let (other, image) = solved(symmetry.apply(scene));
    let centres = |problem: &AssembledProblem| -> Vec<[f64; 3]> {
        let surface = problem.contact_side().expect("contact").surface;
        let panes = 0..surface.n_panes();
        let at = |pane: usize| {
            let mut centre = [0.0; 3];
            for (local, weight) in surface.pane_weights(pane) {
                let node = problem.mesh().coordinates[surface.nodes[local]];
                (0..3).for_each(|c| centre[c] += weight * node[c]);
            }
            centre
        };
        panes.map(at).collect()
    };
    let (from, to) = (centres(&own), centres(&other));
    let [state, image_state] = [&own, &other].map(|it| it.contact_side().expect("contact"));
    let layout = state.laws().layout;
    let nearest = |at: [f64; 3], among: Range<usize>| {
        let distance = |pane: &usize| -> f64 {
            let squares = (0..3).map(|c| (to[*pane][c] - at[c]).powi(2));
            squares.sum()
        };
        among
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .expect("a pane")
    };
    let (mut squares, mut size) = (0.0, 0.0);
    let mut compare = |own: f64, image: f64| {
        squares += (own - image).powi(2);
        size += own.powi(2);
    };
    for (pane, at) in from.iter().enumerate() {
        let face = state.surface.face_of_pane(pane);
        let partner = nearest(
            symmetry.image(*at),
            image_state.surface.faces[face].panes.clone(),
        );
        compare(
            multiplier[layout.normal(pane)],
            image[layout.normal(partner)],
        );
        if layout.tangential(pane).is_some() {
            let [first, second] = layout.pair(&image, partner);
            let [first, second, _] = symmetry.direction([first, second, 0.0]);
            let own = layout.pair(&multiplier, pane);
            compare(own[0], first);
            compare(own[1], second);
        }
    }
    (squares / size).sqrt()
}

/// Roundings of distances near 1 that are measured in displacements near 1e-2.
const ROUNDING: f64 = 1e-9;

fn check(name: &str, scene: &Scene, kinds: &[Kind]) {
    for kind in kinds {
        let difference = difference(scene, *kind);
        assert!(difference <= ROUNDING, "{name} {kind:?}: {difference:e}");
    }
}

const BOTH: [Kind; 2] = [Kind::Mirror, Kind::Exchange];

const FRICTION: &str = "[friction]\ncoefficient_1.constant = 0.3\ncoefficient_2.constant = 0.2\n";

/// Exchanged axes make y, not x, the axis that is projected on tangent planes, so friction is left out there.
#[test]
fn bodies_on_obstacles_have_images() {
    for (obstacle, friction, kinds) in [
        (
            "sphere = { centre = [0.6, 0.3, -1.0], radius = 1.0 }",
            FRICTION,
            &BOTH[..1],
        ),
        (
            "sphere = { centre = [0.6, 0.3, -1.0], radius = 1.0 }",
            "",
            &BOTH,
        ),
        (
            "cylinder = { point = [0.4, 0.1, -2.005], direction = [0.3, 1.0, 0.0], radius = 2.0 }",
            FRICTION,
            &BOTH[..1],
        ),
        (
            "half_space = { point = [0.0, 0.0, 0.0], normal = [0.001, 0.002, 1.0] }",
            "",
            &BOTH,
        ),
        (
            "height.value = '-0.01*(x - 0.3)^2 - 0.02*(y - 0.5)^2 - 0.001*x'",
            FRICTION,
            &BOTH[..1],
        ),
    ] {
        let text = format!(
            "title = 'symmetry'\n[body.brick]\nsize = [1.0, 0.75, 0.5]\ncells = [6, 4, 2]\n\
             [material.isotropic]\nyoung_modulus = 1.0\npoisson_ratio = 0.3\n\
             [[clamp]]\nface = 'z_max'\n[body_force]\nvalue = [0.04, 0.02, -1.0]\n\
             [contact]\nface = 'z_min'\nobstacle.{obstacle}\n{friction}"
        );
        let scene = Scene::parse("test", &text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        check(obstacle, &scene, kinds);
    }
}

/// Scenes of the program on small meshes: formulas, materials, regions, springs, faces beside each other, nodes.
#[test]
fn pipelines_have_images() {
    for (name, cells) in [
        ("expression_law", [6, 2, 2]),
        ("orthotropic_material", [6, 2, 2]),
        ("voigt_material", [6, 2, 2]),
        ("turning_frame", [6, 2, 2]),
        ("table_law", [6, 2, 2]),
        ("springs", [6, 2, 2]),
        ("nodal", [6, 2, 2]),
        ("tresca", [6, 2, 2]),
        ("gap", [6, 2, 2]),
        ("force_on_disc", [6, 4, 2]),
    ] {
        let path = format!("{}/../../pipelines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).expect("a pipeline");
        let mut scene = Scene::parse(name, &text).expect("a scene");
        scene.as_brick_mut().expect("a brick").cells = cells;
        let kinds = if name == "turning_frame" {
            &BOTH[..1]
        } else {
            &BOTH
        };
        check(name, &scene, kinds);
    }
}

/// The planes of an image are the images of the planes, and the solution goes with them.
#[test]
fn graded_cells_go_with_the_symmetry() {
    let text = include_str!("../../../../../pipelines/expression_law.toml");
    let mut scene = Scene::parse("expression_law.toml", text).expect("a pipeline");
    let given = vec![0.0, 0.125, 0.25, 0.875, 1.0];
    let brick = Brick::new([3.0, 1.0, 1.0], [6, 4, 2])
        .with_planes(1, given.clone())
        .with_grading(BrickFace::XMin, 2.0);
    scene.bodies = vec![brick.clone().into()];
    let image = |kind: Kind| {
        let image = Symmetry::new(kind, &scene).apply(&scene);
        image.as_brick().expect("a brick").clone()
    };
    let mirrored = image(Kind::Mirror);
    assert_eq!(mirrored.planes(1), [0.0, 0.125, 0.75, 0.875, 1.0]);
    assert_eq!(mirrored.planes(0), brick.planes(0));
    let exchanged = image(Kind::Exchange);
    assert_eq!(exchanged.planes(0), given);
    assert_eq!(exchanged.planes(1), brick.planes(0));
    check("graded", &scene, &BOTH);
}
