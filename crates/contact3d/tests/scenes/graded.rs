//! Bricks of graded cells and of given planes: what they hold exactly, and what they leave in a scene's text.

use std::path::Path;

use contact3d::{
    Problem,
    mesh::Mesh,
    post::ContactReport,
    scene::{Body, Brick, BrickFace, ElementOrder, Scene, SolveSettings, UnitChange},
};

fn scene(text: &str) -> Scene {
    Scene::parse("graded", text).unwrap_or_else(|error| panic!("{error}"))
}

/// Mesh and report of a scene, the answer to rounding.
fn solved(scene: Scene) -> (Mesh, ContactReport) {
    let mesh = Mesh::of_scene(&scene, Path::new("")).expect("a mesh");
    let assembled = Problem::new(scene)
        .and_then(|p| p.assemble())
        .expect("a problem");
    let solution = assembled.solve(&SolveSettings::default()).expect("a solve");
    assert!(solution.status.is_solved());
    (mesh, assembled.report(&solution).expect("a report"))
}

/// Bricks 2 × 1 × 1 graded towards one face, towards both, and with given planes.
fn bricks() -> [Brick; 2] {
    let brick = Brick::new([2.0, 1.0, 1.0], [4, 4, 2]);
    [
        brick
            .clone()
            .with_grading(BrickFace::XMin, 1.6)
            .with_grading(BrickFace::YMin, 1.3)
            .with_grading(BrickFace::YMax, 2.0)
            .with_grading(BrickFace::ZMin, 1.5),
        brick
            .with_planes(0, vec![0.0, 0.1, 0.4, 1.3, 2.0])
            .with_grading(BrickFace::ZMax, 3.0),
    ]
}

/// A block under a roof that a pressure of 2 on one side squeezes against rollers and a smooth foundation, with
/// E = 100 and ν = 0.25: σ_xx = −2, σ_yy = 0, and σ_zz = −0.5 since ε_zz = 0.
const PRESSED: &str = "title = 'pressed'
    [body.brick]
    size = [2.0, 1.0, 1.0]
    cells = [4, 4, 2]
    [material.isotropic]
    young_modulus = 100.0
    poisson_ratio = 0.25
    [[clamp]]
    face = 'x_min'
    components = ['x']
    [[clamp]]
    face = 'y_min'
    components = ['y']
    [[clamp]]
    face = 'z_max'
    components = ['z']
    [[pressure]]
    face = 'x_max'
    value = 2.0
    [contact]
    face = 'z_min'";

#[test]
fn constant_stresses_are_exact_on_graded_cells() {
    for element in [ElementOrder::P1, ElementOrder::P2] {
        for brick in bricks() {
            let mut scene = scene(PRESSED);
            scene.bodies = vec![Body::from(brick).with_element(element)];
            let (mesh, report) = solved(scene);
            for (x, u) in mesh.coordinates.iter().zip(&report.displacement) {
                let exact = [-0.01875 * x[0], 0.00625 * x[1], 0.0];
                // Roundings of displacements of 0.04 through matrices of condition below 1e4.
                assert!(
                    (0..3).all(|c| (u[c] - exact[c]).abs() < 1e-14),
                    "{x:?} {u:?}"
                );
            }
            for pane in &report.panes {
                // The same roundings through S.
                assert!((pane.normal_stress + 0.5).abs() < 1e-11);
            }
            // Nothing is left to estimate.
            assert!(report.discretisation_error.relative() < 1e-10);
        }
    }
}

/// u = (x², 0, 0) between rollers, with E = 1, ν = 0.25: λ = μ = 0.4, so f = −2.4 and σ_xx = 4.8 at x = 2.
#[test]
fn a_quadratic_displacement_is_exact_on_graded_cells() {
    let rollers: String = [
        ("x_min", "x"),
        ("y_min", "y"),
        ("y_max", "y"),
        ("z_min", "z"),
        ("z_max", "z"),
    ]
    .map(|(face, axis)| format!("[[clamp]]\nface = '{face}'\ncomponents = ['{axis}']\n"))
    .concat();
    let text = format!(
        "title = 'quadratic'
        [body.brick]
        size = [2.0, 1.0, 1.0]
        cells = [2, 1, 1]
        [material.isotropic]
        young_modulus = 1.0
        poisson_ratio = 0.25
        {rollers}
        [body_force]
        value = [-2.4, 0.0, 0.0]
        [[traction]]
        face = 'x_max'
        value = [4.8, 0.0, 0.0]"
    );
    for brick in bricks() {
        let mut scene = scene(&text);
        scene.bodies = vec![Body::from(brick).with_element(ElementOrder::P2)];
        let (mesh, report) = solved(scene);
        for (x, u) in mesh.coordinates.iter().zip(&report.displacement) {
            let exact = [x[0] * x[0], 0.0, 0.0];
            // Roundings of displacements up to 4 through a matrix of condition below 1e4.
            assert!(
                (0..3).all(|c| (u[c] - exact[c]).abs() < 1e-12),
                "{x:?} {u:?}"
            );
        }
    }
}

/// J and the estimated error of the published problem on 12 × 4 × 4 cells, which give as many unknowns
/// however they are graded. J falls towards −7,890 J or so: finer meshes of 24 × 8 × 8 cells give
/// −7,879.5 J if equal and −7,887.5 J if graded.
#[test]
fn graded_cells_bring_the_published_problem_nearer_to_its_limit() {
    const LIMIT: f64 = -7_890.0;
    let even = Brick::new([3.0, 1.0, 1.0], [12, 4, 4]);
    let faces = [
        BrickFace::XMin,
        BrickFace::XMax,
        BrickFace::ZMin,
        BrickFace::ZMax,
    ];
    let towards = faces.into_iter();
    let graded = towards.fold(even.clone(), |brick, face| brick.with_grading(face, 1.3));
    let [even, graded] = [even, graded].map(|brick| {
        let mut scene = scene(include_str!("../../../../pipelines/newton.toml"));
        scene.bodies = vec![Body::from(brick).with_element(ElementOrder::P2)];
        let (_, report) = solved(scene);
        let r = report.resultants;
        let distance = (r.strain_energy - r.load_work - LIMIT).abs();
        (
            report.displacement.len(),
            distance,
            report.discretisation_error.relative(),
        )
    });
    assert_eq!(graded.0, even.0);
    assert!(graded.1 < 0.3 * even.1, "{} {}", graded.1, even.1);
    assert!(graded.2 < 0.97 * even.2, "{} {}", graded.2, even.2);
}

/// Digests of scenes name cases and decide freshness, so what is not said leaves no trace.
#[test]
fn exponents_of_one_are_no_grading() {
    let plain = scene(PRESSED);
    let said = scene(&PRESSED.replace(
        "cells = [4, 4, 2]",
        "cells = [4, 4, 2]\ngrading = { x_min = 1.0, z_max = 1 }\ncoordinates = {}",
    ));
    assert_eq!(said.to_toml(), plain.to_toml());
    let mesh = |scene: &Scene| Mesh::of_scene(scene, Path::new("")).expect("a brick");
    assert_eq!(mesh(&said), mesh(&plain));
}

#[test]
fn a_graded_scene_returns_from_its_text() {
    for brick in bricks() {
        let mut scene = scene(PRESSED);
        scene.bodies = vec![brick.into()];
        let text = scene.to_toml().expect("no function");
        assert_eq!(Scene::parse("again", &text).expect("a scene"), scene);
    }
}

/// Another unit of length is another scene of the same problem.
#[test]
fn planes_are_scaled_with_the_body() {
    for brick in bricks() {
        let mut scene = scene(PRESSED);
        scene.bodies = vec![brick.clone().into()];
        let scaled = scene.in_units(UnitChange {
            length: 8.0,
            displacement: 1.0,
            stress: 1.0,
        });
        let scaled = scaled.as_brick().expect("a brick");
        for axis in 0..3 {
            let expected: Vec<f64> = brick.planes(axis).iter().map(|x| 8.0 * x).collect();
            assert_eq!(scaled.planes(axis), expected);
        }
    }
}
