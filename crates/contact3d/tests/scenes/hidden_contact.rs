//! Contact between the points where a coarse mesh measures it: a ball in the middle of a face that hardly deforms, or not at all.

use std::path::Path;

use contact3d::{
    AssembledProblem, Problem,
    adaptation::{AdaptiveStatus, adapted},
    history::HistoryErrors,
    post::{ContactReport, Zone},
    scene::{AdaptSettings, ElementOrder, Functional, MultiplierSpace, Scene},
};

/// A block that a clamp moves onto a ball by 1 mm, with its weight.
const PRESSED: &str = "title = 'ball'
    [body.brick]
    size = [1.0, 1.0, 1.0]
    cells = [2, 2, 2]
    [material.isotropic]
    young_modulus = 2.1e11
    poisson_ratio = 0.3
    [[clamp]]
    face = 'z_max'
    value = [0.0, 0.0, -1e-3]
    [contact]
    face = 'z_min'
    [contact.obstacle.sphere]
    centre = [0.37, 0.39, -1.0]
    radius = 1.0
    [body_force]
    value = [0.0, 0.0, -7.7e4]";

/// ‖u‖_A in √J under the ball of 1 m, and under one of 50 mm: roots of twice the strain energies 3893 and 886 J of meshes with an
/// estimated error of 5 %.
const NORMS: [f64; 2] = [88.2, 42.1];

fn scene(small: bool, element: ElementOrder, space: MultiplierSpace) -> Scene {
    let mut text = PRESSED.to_owned();
    if small {
        text = text.replace("-1.0]\n    radius = 1.0", "-0.05]\n    radius = 0.05");
    }
    let mut scene = Scene::parse("ball", &text).expect("a scene");
    scene.bodies[0].element = element;
    scene.contacts[0].multipliers = space;
    scene
}

fn report(scene: Scene) -> ContactReport {
    let assembled = Problem::new(scene).and_then(|problem| problem.assemble());
    report_of(&assembled.expect("a problem"))
}

fn report_of(assembled: &AssembledProblem) -> ContactReport {
    let solution = assembled.solve(&assembled.scene().solve).expect("a solve");
    assembled.report(&solution).expect("a report")
}

/// The estimate of a mesh that misses the contact is near the true error, which is all of ‖u‖_A, and it has no quantities with bars.
#[test]
fn contact_that_no_point_of_a_coarse_mesh_sees_is_in_the_estimate() {
    for small in [false, true] {
        for element in [ElementOrder::P1, ElementOrder::P2] {
            for space in [MultiplierSpace::Panes, MultiplierSpace::Nodal] {
                let report = report(scene(small, element, space));
                let case = format!("small {small}, {element:?}, {space:?}");
                let is_open = |zone| zone == Zone::Open;
                assert!(report.panes.iter().all(|p| is_open(p.zone)), "{case}");
                let estimate = report.discretisation_error.total() / NORMS[usize::from(small)];
                // A scaling of Hertz's contact, on meshes that are 10 to 50 times wider than the contact.
                assert!((0.25..4.0).contains(&estimate), "{case}: {estimate}");
                assert!(report.functionals.is_empty());
            }
        }
    }
}

/// Without the weight nothing is deformed, and all of the solution is missed.
#[test]
fn a_body_at_rest_with_the_obstacle_inside_has_an_error_of_100_per_cent() {
    let mut resting = scene(true, ElementOrder::P1, MultiplierSpace::Panes);
    resting.body_force = None;
    let report = report(resting.clone());
    assert_eq!(report.discretisation_error.relative(), 1.0);
    assert_eq!(
        report.relative_error(Some(Functional::NormalForce)),
        Some(1.0)
    );
    // A foundation that the face only reaches is not missed.
    let apart = PRESSED
        .replace("-1e-3", "0.0")
        .replace("[body_force]\n    value = [0.0, 0.0, -7.7e4]", "");
    let apart = Scene::parse("apart", &apart).expect("a scene");
    assert_eq!(self::report(apart).discretisation_error.relative(), 0.0);
}

/// Levels go on until the contact is found, for any goal and in a load history, and come to one force.
#[test]
fn refining_finds_the_contact() {
    let adapt = |of: Option<Functional>, history: bool| {
        let mut scene = scene(true, ElementOrder::P2, MultiplierSpace::Panes);
        if history {
            let text = format!("{PRESSED}\n[[step]]\nincrements = 2");
            scene.steps = Scene::parse("steps", &text).expect("a scene").steps;
        }
        scene.adapt = Some(AdaptSettings {
            error: if of.is_some() { 0.03 } else { 0.3 },
            start: Default::default(),
            of,
        });
        let (done, levels) = adapted(scene, Path::new("")).expect("levels");
        assert_eq!(levels.status, AdaptiveStatus::Met, "{of:?}");
        assert_eq!(done.records.is_empty(), !history);
        if history {
            let errors = HistoryErrors::new(&done.records, None).expect("estimates");
            assert!(errors.largest() <= 0.3);
        }
        done.report
            .resultants
            .contact
            .expect("contact")
            .normal_force
    };
    let forces = [
        adapt(None, false),
        adapt(Some(Functional::NormalForce), false),
        adapt(Some(Functional::PeakDisplacement), false),
        adapt(None, true),
    ];
    for force in forces {
        // 2.2e6 N at an error of 5 %; a displacement within 3 % of 1 mm says no more than that there is contact.
        assert!((1.5e6..2.9e6).contains(&force), "{forces:?}");
    }
}

/// Shallow contact between nodes, an eighth of a cell wide: the estimate sees it.
#[test]
fn shallow_contact_between_the_nodes_is_seen() {
    let shallow = PRESSED
        .replace("cells = [2, 2, 2]", "cells = [4, 4, 4]")
        .replace("-1e-3", "-6e-5")
        .replace("-7.7e4", "-7.7e-4");
    let near = |centre: &str| {
        let text = shallow.replace(
            "[0.37, 0.39, -1.0]\n    radius = 1.0",
            &format!("{centre}\n    radius = 2.0"),
        );
        let mut scene = Scene::parse("shallow", &text).expect("a scene");
        scene.bodies[0].element = ElementOrder::P2;
        report(scene).discretisation_error.relative()
    };
    for centre in [
        "[0.21, 0.33, -2.0]",
        "[0.55, 0.70, -2.0]",
        "[0.37, 0.61, -2.0]",
    ] {
        assert!(near(centre) >= 1.0, "{centre}: {}", near(centre));
    }
    // Out of reach by as much.
    assert!(near("[0.21, 0.33, -2.00012]") < 0.5);
}

/// A pin in a bore of the same radius, with the digits of a mesh file and sides that are not quite round, has no contact to miss at rest.
#[test]
fn a_pin_at_rest_in_its_bore_has_no_error() {
    let text = "title = 'pin'
        [body]
        element = 'P2'
        [body.gmsh]
        file = 'post_order2_41.msh'
        [material.isotropic]
        young_modulus = 1e9
        poisson_ratio = 0.3
        [[clamp]]
        face = 'top'
        [contact]
        face = 'side'
        [contact.obstacle.cylinder]
        point = [0.0, 0.0, 0.0]
        direction = [0.0, 0.0, 1.0]
        radius = 1.0
        side = 'inside'";
    let scene = Scene::parse("pin", text).expect("a scene");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes");
    let assembled = Problem::in_folder(scene, &folder).and_then(|problem| problem.assemble());
    let report = report_of(&assembled.expect("a problem"));
    assert_eq!(report.discretisation_error.relative(), 0.0);
}
