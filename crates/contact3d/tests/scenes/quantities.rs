//! Errors of forces, displacements, pressures and energies against finer, nested meshes, and meshes refined for a force.

use std::f64::consts::PI;
use std::path::Path;

use contact3d::{
    Problem,
    adaptation::{AdaptiveStatus, adapted},
    mesh::{Mesh, RefinedLevel},
    post::ContactReport,
    scene::{
        AdaptSettings, Body, Clamp, Component, Contact, ElementOrder, FirstMesh, Friction,
        Functional, Material, Scene,
    },
};

const PUBLISHED: &str = include_str!("../../../../pipelines/newton.toml");
const ELASTIC: &str = include_str!("../../../../pipelines/elastic_only.toml");

fn scene(text: &str, of: Functional, error: f64) -> Scene {
    let mut scene = Scene::parse("quantities", text).expect("a scene");
    scene.bodies[0].element = ElementOrder::P2;
    scene.as_brick_mut().expect("a brick").cells = [6, 2, 2];
    scene.assemble = Default::default();
    scene.solve = Default::default();
    scene.adapt = Some(AdaptSettings {
        error,
        of: Some(of),
        start: FirstMesh::Scene,
    });
    scene
}

fn report(scene: &Scene, cuts: &[RefinedLevel]) -> ContactReport {
    let mesh = Mesh::refined(scene, Path::new(""), cuts).expect("a mesh");
    let problem = Problem::on_mesh(scene.clone(), mesh).and_then(Problem::assemble);
    let problem = problem.expect("a problem");
    let (_, report) = problem.solve_and_report(&scene.solve).expect("a solve");
    report
}

/// The report on a mesh with some 64 times the cells.
fn on_finer_mesh(scene: &Scene) -> ContactReport {
    let mesh = Mesh::of_scene(scene, Path::new("")).expect("a mesh");
    report(scene, &[RefinedLevel::Cuts(vec![6; mesh.tetrahedra.len()])])
}

/// Error bars on a mesh against the quantity on one with some 64 times the cells. Where elements and contact err in opposite
/// directions, as in the normal force, only the bar is right, elsewhere the signed estimate too.
#[test]
fn error_bars_are_near_the_errors() {
    let mean_of_pressure = Functional::MeanPressure {
        corners: [[0.9, 0.2, -1.0], [2.7, 0.9, 1.0]],
    };
    let mean_of_displacement = Functional::MeanDisplacement {
        corners: [[2.5, 0.0, 0.0], [3.0, 1.0, 1.0]],
        component: Component::Z,
    };
    let forces = [Functional::NormalForce, Functional::TangentialForce];
    for (text, others, wanted) in [
        (
            ELASTIC,
            &[Functional::StrainEnergy][..],
            mean_of_displacement,
        ),
        (PUBLISHED, &forces, mean_of_pressure),
    ] {
        let scene = scene(text, wanted, 0.01);
        let [coarse, fine] = [report(&scene, &[]), on_finer_mesh(&scene)];
        for of in others.iter().copied().chain([wanted]) {
            let [coarse, fine] = [&coarse, &fine].map(|it| it.functional(of).expect("a quantity"));
            let error = fine.value - coarse.value;
            let [low, high] = coarse.range;
            let bar = 0.5 * (high - low);
            // Measured 0.9 to 2.2: bars hold what the local errors of so few tetrahedra are off by.
            assert!(
                (0.5..=2.5).contains(&(bar / error.abs())),
                "{} {bar:e} {error:e}",
                of.word()
            );
            assert!(bar > coarse.signed_error.abs());
            // Measured 0.75 to 1.07.
            let effectivity = coarse.signed_error / error;
            assert!(
                of == Functional::NormalForce || (0.5..=2.0).contains(&effectivity),
                "{} {effectivity}",
                of.word()
            );
        }
    }
}

/// Blocks that touch or are glued: signed estimates on a mesh against the quantities on one of half its size.
#[test]
fn quantities_of_several_bodies_have_errors() {
    let block = |name: &str, n: usize, z: f64| {
        let block = Body::brick([1.0; 3], [n; 3]).with_element(ElementOrder::P2);
        block.named(name).at([0.0, 0.0, z])
    };
    let on = |contact: &Contact, n: usize| {
        let material = Material::isotropic(1e9, 0.3);
        let moved = Clamp {
            value: [6e-3, 0.0, -1e-2].map(Into::into),
            ..Clamp::face("upper.z_max")
        };
        let scene = Scene::new(block("lower", 2 * n, 0.0), material)
            .with_body(block("upper", 3 * n, 1.0))
            .with_clamp(Clamp::face("lower.z_min"))
            .with_clamp(moved)
            .with_contact(contact.clone());
        let friction = (!contact.glued).then(|| Friction::coulomb(0.3));
        report(&Scene { friction, ..scene }, &[])
    };
    let touching = Contact::between("lower.z_max", "upper.z_min");
    let glued = Contact::glued("lower.z_max", "upper.z_min");
    for (contact, quantities) in [
        (
            touching,
            &[
                Functional::NormalForce,
                Functional::TangentialForce,
                Functional::StrainEnergy,
            ][..],
        ),
        (glued, &[Functional::StrainEnergy]),
    ] {
        let [coarse, fine] = [1, 2].map(|n| on(&contact, n));
        for &of in quantities {
            let [coarse, fine] = [&coarse, &fine].map(|it| it.functional(of).expect("one"));
            // Measured 1.4 to 1.5; the finer mesh has a third to a quarter of the error.
            let effectivity = coarse.signed_error / (fine.value - coarse.value);
            assert!(
                (0.8..2.0).contains(&effectivity),
                "{} {effectivity}",
                of.word()
            );
            let [low, high] = coarse.range;
            assert!((low..high).contains(&fine.value), "{}", of.word());
        }
    }
}

/// A mesh refined for the force meets its target, and the force is right by it against a finer mesh.
#[test]
fn meshes_follow_a_quantity() {
    let of = Functional::NormalForce;
    let scene = scene(PUBLISHED, of, 0.004);
    let (answer, levels) = adapted(scene.clone(), Path::new("")).expect("levels");
    assert_eq!(levels.status, AdaptiveStatus::Met);
    let force = answer.report.functional(of).expect("a force");
    assert!(force.relative() <= 0.004);
    assert_eq!(
        force.indicator.len(),
        answer.problem.mesh().tetrahedra.len()
    );
    let finer = on_finer_mesh(&scene);
    let finer = finer.functional(of).expect("a quantity");
    // Twice the target: an error bar is an estimate, and the finer mesh has one of its own.
    assert!((force.value / finer.value - 1.0).abs() < 0.008);
}

/// A block pressed on waves of a gap, whose coarsest mesh has eight panes, all of them closed.
const ON_WAVES: &str = "title = 'waves'
    [body.brick]
    size = [2.0, 1.0, 1.0]
    cells = [4, 2, 2]
    [material.isotropic]
    young_modulus = 2.1e11
    poisson_ratio = 0.3
    [[clamp]]
    face = 'x_min'
    [[pressure]]
    face = 'z_max'
    value = 3e7
    [contact]
    face = 'z_min'
    gap = '1e-5*(1 - cos(9*x)*cos(7*y))'
    [friction]
    coefficient.constant = 0.3";

/// Ranges of areas on coarse meshes hold the areas on meshes with 64 times the cells.
#[test]
fn ranges_of_areas_hold_those_of_finer_meshes() {
    let nodal = PUBLISHED.replace("[contact]", "[contact]\nmultipliers = 'nodal'");
    // Waves as long as a cell, of which its nodes see none.
    let short = "4e-5*(1 - sin(12.566370614359172*x)*sin(12.566370614359172*y))";
    let short = ON_WAVES.replace("1e-5*(1 - cos(9*x)*cos(7*y))", short);
    for (text, cells) in [
        (ON_WAVES, [4, 2, 2]),
        (&short, [4, 2, 2]),
        (PUBLISHED, [6, 2, 2]),
        (&nodal, [6, 2, 2]),
    ] {
        let mut scene = scene(text, Functional::ContactArea, 0.01);
        scene.as_brick_mut().expect("a brick").cells = cells;
        let (coarse, fine) = (report(&scene, &[]), on_finer_mesh(&scene));
        for of in [Functional::ContactArea, Functional::StickArea] {
            let fine = fine.functional(of).expect("an area").value;
            let coarse = coarse.functional(of).expect("an area");
            let [low, high] = coarse.range;
            assert!(low <= coarse.value && coarse.value <= high && high > low);
            // Areas of the finer mesh are known to about a hundredth of the face of 2 to 3 m².
            assert!(
                (low - 0.02..=high + 0.02).contains(&fine),
                "{coarse:?} {fine:e}"
            );
        }
    }
}

/// Waves a (1 − cos Kx) of two cells each close by the share σ under the pressure E* K a/2 sin²(πσ/2) (H. M. Westergaard 1939).
#[test]
fn waves_of_two_cells_close_as_in_closed_form() {
    let (modulus, number, depth) = (2.1e11 / (1.0 - 0.3 * 0.3), 6.0 * PI, 1e-5);
    // Of a smaller share nodes see too little of the waves. No range is wider than these parts of the face.
    let panes = [0.4, 0.6, 0.8].map(|share| (share, "panes", 0.45));
    let nodal = [0.6, 0.8].map(|share| (share, "nodal", 0.6));
    for (share, multipliers, widest) in panes.into_iter().chain(nodal) {
        let pressure = modulus * number * depth / 2.0 * (PI * share / 2.0_f64).sin().powi(2);
        let sides = ["x_min", "x_max", "y_min", "y_max"];
        let clamps = sides.map(|face| {
            let component = &face[..1];
            format!("[[clamp]]\nface = '{face}'\ncomponents = ['{component}']\n")
        });
        let text = format!(
            "title = 'waves'
            body = {{ element = 'P2', brick = {{ size = [2.0, 1.0, 1.0], cells = [12, 2, 2] }} }}
            material.isotropic = {{ young_modulus = 2.1e11, poisson_ratio = 0.3 }}
            pressure = [{{ face = 'z_max', value = {pressure:e} }}]
            contact = {{ face = 'z_min', multipliers = '{multipliers}', gap = '1e-5*(1 - cos(6*PI*x))' }}
            {}",
            clamps.concat()
        );
        let of = Functional::ContactArea;
        let found = report(&scene(&text, of, 0.1), &[]);
        let found = found.functional(of).expect("an area");
        // A face of 2 m². The stiffness of a patch is good to an eighth, by half of which edges move; the gap is linear on quarters of a cell.
        // Nodes are pressed in two places of a wave at most: what they say of its middle goes with the edges between them.
        let off = (found.value / 2.0 / share - 1.0).abs();
        assert!(multipliers == "nodal" || off < 0.12, "{found:?}");
        let [low, high] = found.range.map(|area| area / 2.0);
        assert!(
            low <= share && share <= high && high - low < widest,
            "{found:?}"
        );
    }
}

/// Eight panes tell no area, however sure their zones are.
#[test]
fn areas_are_not_accurate_on_a_few_panes() {
    let of = Functional::ContactArea;
    let mut scene = scene(ON_WAVES, of, 0.02);
    scene.as_brick_mut().expect("a brick").cells = [4, 2, 2];
    assert!(report(&scene, &[]).relative_error(Some(of)) >= Some(1.0));
    let (answer, levels) = adapted(scene.clone(), Path::new("")).expect("levels");
    assert_eq!(levels.status, AdaptiveStatus::Met);
    assert!(levels.adaptation.levels.len() > 1);
    let found = answer.report.functional(of).expect("an area");
    // 1.874 m² on a mesh of four times the cells along each edge.
    assert!((found.value / 1.874 - 1.0).abs() < 0.02, "{found:?}");
}

/// At the corners of a block that is clamped beside its contact the pressure has no limit: refinement says so. On a ball it has one, and
/// the error bar holds it.
#[test]
fn the_largest_pressure_is_told_where_it_has_a_limit() {
    let of = Functional::LargestPressure;
    let mut scene = scene(ON_WAVES, of, 0.03);
    scene.as_brick_mut().expect("a brick").cells = [4, 2, 2];
    let (_, levels) = adapted(scene, Path::new("")).expect("levels");
    assert_eq!(levels.status, AdaptiveStatus::Unbounded);
    let levels = &levels.adaptation.levels;
    let value = |level: usize| levels[level].value.expect("a pressure");
    assert!(value(levels.len() - 1) > 1.5 * value(0));

    let text = include_str!("../../../../pipelines/hertz_cylinder.toml");
    let cylinder = Scene::parse("cylinder", text).expect("a scene");
    let report = report(&cylinder, &[]);
    let peak = report.functional(of).expect("a largest pressure");
    // The largest pressure of a line contact; panes hold means, and the bar is of 2 % at least.
    let [low, high] = peak.range;
    assert!(
        low < peak.value && peak.value < high && high.is_finite(),
        "{peak:?}"
    );
    assert!(high - low < 0.5 * peak.value, "{peak:?}");
}

/// Contact without friction has no bound at an edge inside a plane, as of a punch, at the rim of a clamp beside it and where a load shears
/// the face beside it, on meshes of any size and with any multipliers; at the end of a block it has one, however steep the pressure is on a
/// coarse mesh, and so has a curve that ends before the edge.
#[test]
fn theory_tells_where_pressure_without_friction_has_no_bound() {
    let bar = |brick: &str, rest: &str| {
        let text = format!(
            "title = 'edges'
            body.brick = {{ {brick} }}
            material.isotropic = {{ young_modulus = 2e11, poisson_ratio = 0.3 }}
            {rest}"
        );
        let report = report(&Scene::parse("edges", &text).expect("a scene"), &[]);
        let peak = report.functional(Functional::LargestPressure);
        peak.expect("a largest pressure").error_bar()
    };
    let [coarse, fine] =
        [[8, 2, 4], [16, 2, 8]].map(|cells| format!("size = [2, 0.25, 1], cells = {cells:?}"));
    let pressed =
        "clamp = [{ face = 'y_min', components = ['y'] }, { face = 'y_max', components = ['y'] },
                 { face = 'x_min', components = ['x'] }]
        pressure = [{ face = 'z_max', value = 1e6 }]";
    let boxed = "box = [[0.5, 0, 0], [1.5, 0.25, 0]]";
    let punch = "gap = 'if(abs(x - 1) < 0.501, 0, 1e-3)'";
    let dip = "gap = '2e-6*(1 - exp(-25*(x - 2)^2))'";
    let curve = "gap = '3e-5*(x - 1)^2', box = [[0.5, 0, 0], [1.5, 0.25, 0]]";
    let block = "size = [1, 1, 0.5], cells = [8, 8, 4]";
    let rim = "clamp = [{ face = 'y_min' }]
        pressure = [{ face = 'x_max', value = 5e7 }, { face = 'z_max', value = 2e7 }]";
    let sheared =
        "clamp = [{ face = 'x_min', components = ['x'] }, { face = 'y_min', components = ['y'] }]
        pressure = [{ face = 'z_max', value = 3e7 }]
        traction = [{ face = 'x_max', value = [0, 0, -3e7] }]";
    for multipliers in ["panes", "nodal"] {
        let with = |scene: &str, contact: &str| {
            format!(
                "{scene}\ncontact = {{ face = 'z_min', multipliers = '{multipliers}', {contact} }}"
            )
        };
        let whole = "name = 'foot'";
        for (brick, scene, contact) in [
            (&fine[..], pressed, boxed),
            (&fine[..], pressed, punch),
            (block, rim, whole),
            (block, sheared, whole),
        ] {
            let scene = with(scene, contact);
            assert_eq!(bar(brick, &scene), f64::INFINITY, "{scene}");
        }
        for (brick, contact) in [(&coarse, dip), (&fine, dip), (&coarse, curve)] {
            assert!(bar(brick, &with(pressed, contact)).is_finite(), "{contact}");
        }
    }
}
