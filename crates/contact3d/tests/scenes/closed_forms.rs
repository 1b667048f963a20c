//! Figures of the report that follow by hand: stress invariants, sums of loads, zones.

use std::path::Path;

use contact3d::{
    AssembledProblem, Problem,
    mesh::{MaterialNodes, Mesh},
    post::{ContactReport, LargestStress, PaneState, StressConcentration, Zone, von_mises},
    scene::{Method, PrecisionControl, Scene, SolveSettings},
};
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Voigt order: xx, yy, zz, yz, xz, xy.
fn voigt(s: &Matrix3<f64>) -> [f64; 6] {
    [s.m11, s.m22, s.m33, s.m23, s.m13, s.m12]
}

/// σ under tension, √3 τ under shear in every plane, 0 under pressure, and the same in every frame.
#[test]
fn von_mises_of_the_pure_states() {
    for axis in 0..3 {
        let mut tension = [0.0; 6];
        tension[axis] = -7e6;
        assert_eq!(von_mises(&tension), 7e6);
        let mut shear = [0.0; 6];
        shear[3 + axis] = -7e6;
        // A square, a product and a root: three roundings.
        assert!((von_mises(&shear) / (3.0_f64.sqrt() * 7e6) - 1.0).abs() < 1e-15);
    }
    assert_eq!(von_mises(&[5e6, 5e6, 5e6, 0.0, 0.0, 0.0]), 0.0);
    let stress = Matrix3::new(3.0, -1.0, 2.0, -1.0, 4.0, 0.5, 2.0, 0.5, -6.0);
    let rotation = Rotation3::new(Vector3::new(0.3, -1.1, 0.7));
    let turned = rotation * stress * rotation.inverse();
    // Some ten roundings of sums of squares up to 200.
    assert!((von_mises(&voigt(&turned)) / von_mises(&voigt(&stress)) - 1.0).abs() < 1e-14);
}

fn assembled(scene: Scene) -> AssembledProblem {
    let problem = Problem::new(scene).expect("a brick");
    problem.assemble().expect("a discrete problem")
}

fn report(text: &str, settings: Option<&SolveSettings>) -> ContactReport {
    let scene = Scene::parse("closed form", text).unwrap_or_else(|error| panic!("{error}"));
    let problem = assembled(scene);
    let settings = settings.unwrap_or(&problem.scene().solve);
    let solution = problem.solve(settings).expect("S is dense");
    problem.report(&solution).expect("finite loads")
}

fn close(found: [f64; 3], expected: [f64; 3]) {
    for (found, expected) in found.into_iter().zip(expected) {
        // Sums over some hundred tetrahedra or triangles.
        assert!(
            (found - expected).abs() <= 1e-12 * expected.abs(),
            "{found} instead of {expected}"
        );
    }
}

/// Forces (1 + x, 2 y, −3 z) per volume on the box (0, 3) × (0, 1) × (0, 2): their integrals are
/// 15, 6 and −18, those of x × f are ∫ (y f_z − z f_y) = −9 − 6, ∫ (z f_x − x f_z) = 15 + 27 and ∫
/// (x f_y − y f_x) = 9 − 7.5.
#[test]
fn body_forces_that_vary_have_their_sums_and_moments() {
    let report = report(
        "title = 'body force'
         body.brick = { size = [3.0, 1.0, 2.0], cells = [6, 2, 4] }
         material.isotropic = { young_modulus = 2e11, poisson_ratio = 0.3 }
         clamp = [{ face = 'x_min' }]
         body_force.value = ['1 + x', '2*y', '-3*z']",
        None,
    );
    close(report.resultants.applied_force, [15.0, 6.0, -18.0]);
    close(report.resultants.moments[1], [-15.0, 42.0, 1.5]);
}

/// A traction (2 z, y, 1 + y) and a pressure 2 y on x_max of the same box: the forces are
/// ∫ (2 z − 2 y, y, 1 + y) = (2, 1, 3), and at x = 3 the moments
/// ∫ (y + y² − y z, 2 z² − 2 y z − 3 − 3 y, 3 y − 2 y z + 2 y²) = (2, −17, 7)/3.
#[test]
fn tractions_that_vary_have_their_sums_and_moments() {
    let report = report(
        "title = 'tractions'
         body.brick = { size = [3.0, 1.0, 2.0], cells = [6, 2, 4] }
         material.isotropic = { young_modulus = 2e11, poisson_ratio = 0.3 }
         clamp = [{ face = 'x_min' }]
         traction = [{ face = 'x_max', value = ['2*z', 'y', '1 + y'] }]
         pressure = [{ face = 'x_max', value = '2*y' }]",
        None,
    );
    close(report.resultants.applied_force, [2.0, 1.0, 3.0]);
    close(
        report.resultants.moments[1],
        [2.0, -17.0, 7.0].map(|m| m / 3.0),
    );
}

/// The published stopping rule leaves slipping panes inside their ellipses by its own error; they
/// are slipping panes all the same, those of the exact answer.
#[test]
fn zones_do_not_depend_on_the_tolerance_of_the_method() {
    let text = include_str!("../../../../pipelines/hkl2011_table1.toml");
    let text = text.replace("48, 16, 16", "12, 4, 4").replace(
        "dual_operator = \"implicit\"",
        "dual_operator = \"explicit\"",
    );
    let exact = report(&text, Some(&SolveSettings::default()));
    let published = SolveSettings {
        method: Method::FixedPoint,
        precision: PrecisionControl::Adaptive,
        epsilon: Some(1e-4),
        ..SolveSettings::default()
    };
    let found = report(&text, Some(&published));
    let zones = |report: &ContactReport| -> Vec<Zone> {
        report.panes.iter().map(|pane| pane.zone).collect()
    };
    assert_eq!(zones(&found), zones(&exact));
    // Sticking panes are inside by 1 − ‖(t₁/a, t₂/b)‖, whatever their slip.
    let sticking = exact.panes.iter().filter(|pane| pane.zone == Zone::Stick);
    let sticking: Vec<_> = sticking.filter_map(|pane| pane.friction).collect();
    assert!(!sticking.is_empty());
    for pane in sticking {
        let [[a, b], [t1, t2]] = [pane.semi_axes, pane.stress];
        let inside = 1.0 - (t1 / a).hypot(t2 / b);
        assert!((pane.margin - inside).abs() < 1e-10, "{pane:?}");
    }
}

/// Σ |R| λ_ν, and Σ |R| λ_t along t₁ and along t₂.
#[test]
fn contact_forces_are_sums_over_panes() {
    let text =
        include_str!("../../../../pipelines/turning_frame.toml").replace("24, 8, 8", "12, 4, 4");
    let scene = Scene::parse("closed form", &text).expect("a pipeline");
    let problem = assembled(scene);
    let solution = problem.solve(&problem.scene().solve).expect("S is dense");
    let report = problem.report(&solution).expect("finite loads");
    let areas = &problem.mesh().contact.as_ref().expect("contact").pane_area;
    let (m, multiplier) = (areas.len(), &solution.multiplier);
    let sum = |at: &dyn Fn(usize) -> usize| -> f64 {
        areas
            .iter()
            .enumerate()
            .map(|(i, area)| area * multiplier[at(i)])
            .sum()
    };
    let forces = [sum(&|i| i), sum(&|i| m + 2 * i), sum(&|i| m + 2 * i + 1)];
    // By different amounts along the two axes, far beyond the rounding that is allowed below.
    assert!((forces[1] / forces[2] - 1.0).abs() > 1e-3, "{forces:?}");
    let contact = report.resultants.contact.expect("contact");
    let [first, second] = contact.tangential_force.expect("friction");
    close([contact.normal_force, first, second], forces);
}

/// The largest magnitude of every component of u, here of displacements that are mostly negative.
#[test]
fn largest_displacements_are_magnitudes() {
    let report = report(
        "title = 'pushed back'
         body.brick = { size = [3.0, 1.0, 2.0], cells = [6, 2, 4] }
         material.isotropic = { young_modulus = 2e11, poisson_ratio = 0.3 }
         clamp = [{ face = 'x_min' }]
         traction = [{ face = 'x_max', value = [-1e7, -2e6, -3e6] }]",
        None,
    );
    let lowest = [0, 1, 2].map(|c| {
        let components = report.displacement.iter().map(|u| u[c]);
        components.fold(0.0, f64::min)
    });
    assert_eq!(
        report.resultants.largest_displacement_along,
        lowest.map(|u: f64| -u)
    );
}

/// An open pane stays open with a pressure that is rounding, and is pressed with one that would close its gap.
#[test]
fn a_pressure_that_rounding_leaves_is_none() {
    let text = include_str!("../../../../pipelines/newton.toml").replace("48, 16, 16", "12, 4, 4");
    let problem = assembled(Scene::parse("newton", &text).expect("a scene"));
    let solution = problem.solve(&problem.scene().solve).expect("S is dense");
    let zone = |pane: usize, pressure: f64| {
        let mut changed = solution.clone();
        changed.multiplier[pane] = pressure;
        problem.report(&changed).expect("finite loads").panes[pane].zone
    };
    let report = problem.report(&solution).expect("finite loads");
    let lifts = |pane: &PaneState| pane.zone == Zone::Open && pane.gap > 0.0;
    let open = report.panes.iter().position(lifts);
    let open = open.expect("the pulled end lifts off");
    assert_eq!(zone(open, 1e-30), Zone::Open);
    assert_ne!(zone(open, 1e7), Zone::Open);
}

/// What a bar needs beside its shape and load: its end may move along y and z, and three components of two nodes hold the rest.
const SLIDING_END: &str = "
    material.isotropic = { young_modulus = 2e11, poisson_ratio = 0.3 }
    clamp = [{ face = 'x_min', components = ['x'] }, { box = [[0, 0, 0], [0, 0, 0]], components = ['y', 'z'] },
             { box = [[0, 1, 0], [0, 1, 0]], components = ['z'] }]";

/// The stress of a bar in tension is the traction, without an error. In bending it is σ = M y/I, here up to 5e5 Pa: quadratic tetrahedra have it
/// exactly, and the bar of linear ones holds the error and is no more than twelve times as wide.
#[test]
fn the_largest_stress_of_a_bar_is_that_of_a_beam() {
    let of_bar = |element: &str, cells: [usize; 3], traction: &str| {
        let text = format!(
            "title = 'bar'
             body = {{ element = '{element}', brick = {{ size = [4, 1, 1], cells = {cells:?} }} }}
             traction = [{{ face = 'x_max', value = ['{traction}', 0, 0] }}]
             {SLIDING_END}"
        );
        let largest = report(&text, None).largest_von_mises;
        assert_eq!(largest.concentration, None, "{largest:?}");
        largest
    };
    for (element, traction, stress) in [
        ("P1", "7e6", 7e6),
        ("P2", "7e6", 7e6),
        ("P2", "1e6*(y - 0.5)", 5e5),
    ] {
        let largest = of_bar(element, [4, 2, 2], traction);
        // Strains are differences of displacements, and forces are those of all steps from the clamp on.
        assert!((largest.value / stress - 1.0).abs() < 1e-10, "{largest:?}");
        assert!(largest.error < 1e-9 * stress, "{largest:?}");
    }
    for n in [2, 4, 8] {
        let largest = of_bar("P1", [4 * n, n, n], "1e6*(y - 0.5)");
        let error = (largest.value - 5e5).abs();
        assert!(
            (error..12.0 * error).contains(&largest.error),
            "{largest:?}"
        );
        assert!([0.0, 1.0].contains(&largest.at[1]), "{largest:?}");
    }
    // Twisted from both ends. One cell is as wrong as what is recovered from it, 12 × 6 × 6 cells say 1.52e6.
    let turned = |face: &str, sign: &str| {
        format!("{{ face = '{face}', value = [0, '{sign}1e6*(0.5 - z)', '{sign}1e6*(y - 0.5)'] }}")
    };
    let text = format!(
        "title = 'twisted'
         body = {{ element = 'P2', brick = {{ size = [2, 1, 1], cells = [2, 1, 1] }} }}
         material.isotropic = {{ young_modulus = 2e11, poisson_ratio = 0.3 }}
         clamp = [{{ box = [[0, 0, 0], [0, 0, 0]] }}, {{ box = [[2, 0, 0], [2, 0, 0]], components = ['y', 'z'] }},
                  {{ box = [[0, 1, 0], [0, 1, 0]], components = ['z'] }}]
         traction = [{}, {}]",
        turned("x_max", ""),
        turned("x_min", "-")
    );
    let twisted = report(&text, None).largest_von_mises;
    let range = twisted.value + 0.4 * twisted.error..twisted.value + twisted.error;
    assert!(range.contains(&1.52e6), "{twisted:?}");
}

/// Two materials side by side that are pulled by the same strain: at the nodes that both have each has its own stress, E ε.
#[test]
fn stresses_of_two_materials_are_not_mixed() {
    for element in ["P1", "P2"] {
        let text = format!(
            "title = 'layers'
             body = {{ element = '{element}', brick = {{ size = [2, 1, 1], cells = [4, 2, 4] }} }}
             material.isotropic = {{ young_modulus = 2e11, poisson_ratio = 0.0 }}
             region = [{{ part.box = [[0, 0, 0], [2, 1, 0.5]],
                         material.isotropic = {{ young_modulus = 7e10, poisson_ratio = 0.0 }} }}]
             clamp = [{{ face = 'x_min', components = ['x'] }}, {{ face = 'y_min', components = ['y'] }},
                      {{ face = 'z_min', components = ['z'] }},
                      {{ face = 'x_max', components = ['x'], value = ['2e-5', 0, 0] }}]"
        );
        let problem = assembled(Scene::parse("layers", &text).expect("a scene"));
        let solution = problem.solve(&problem.scene().solve).expect("a solve");
        let report = problem.report(&solution).expect("a report");
        let rows = MaterialNodes::new(problem.mesh());
        let regions = rows.regions().expect("two materials");
        // Once more the 5 × 3 nodes of the layer between them, or the 9 × 5 of quadratic tetrahedra.
        let both = if element == "P1" { 15 } else { 45 };
        assert_eq!(regions.len(), problem.mesh().coordinates.len() + both);
        for ([node, region], (stress, von_mises)) in regions
            .iter()
            .zip(report.nodal_stress.iter().zip(&report.von_mises))
        {
            let expected = [2e6, 7e5][*region];
            let z = problem.mesh().coordinates[*node][2];
            assert!(if *region == 0 { z >= 0.5 } else { z <= 0.5 });
            assert!(
                (stress[0] / expected - 1.0).abs() < 1e-11
                    && (von_mises / expected - 1.0).abs() < 1e-11
            );
        }
    }
}

/// Where the stress of the elastic body has no bound the report says why, and gives no error bar.
#[test]
fn concentrations_of_stress_have_their_names() {
    let brick = |size: &str, cells: &str, rest: &str| {
        let text = format!(
            "title = 'concentration'
             body.brick = {{ size = {size}, cells = {cells} }}
             {rest}"
        );
        report(&text, None).largest_von_mises
    };
    let steel = "material.isotropic = { young_modulus = 2e11, poisson_ratio = 0.3 }";
    let clamp = brick(
        "[3, 1, 1]",
        "[6, 4, 4]",
        &format!(
            "{steel}\nclamp = [{{ face = 'x_min' }}]\ntraction = [{{ face = 'x_max', value = [0, 0, -1e6] }}]"
        ),
    );
    let materials = brick(
        "[4, 1, 1]",
        "[8, 4, 4]",
        &format!(
            "traction = [{{ face = 'x_max', value = [1e6, 0, 0] }}]
             region = [{{ part.box = [[0, 0, 0], [2, 1, 1]],
                         material.isotropic = {{ young_modulus = 1e9, poisson_ratio = 0.45 }} }}]
             {SLIDING_END}"
        ),
    );
    let contact = brick(
        "[2, 2, 1]", "[16, 4, 8]",
        &format!(
            "{steel}
             clamp = [{{ face = 'y_min', components = ['y'] }}, {{ face = 'x_min', components = ['x'] }}]
             pressure = [{{ face = 'z_max', value = 1e6 }}]
             contact = {{ face = 'z_min', box = [[0.5, 0, 0], [1.5, 2, 0]] }}"
        ),
    );
    let scene = "title = 'foot'
         body.gmsh.file = 'foot_41.msh'
         material.isotropic = { young_modulus = 2e11, poisson_ratio = 0.3 }
         clamp = [{ face = 'contact' }]
         traction = [{ face = 'held end', value = [1e6, 0, 0] }]";
    let scene = Scene::parse("foot", scene).expect("a scene");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes");
    let mesh = Mesh::refined(&scene, &folder, &[]).expect("a mesh");
    let problem = Problem::on_mesh(scene, mesh)
        .and_then(Problem::assemble)
        .expect("a problem");
    let (_, foot) = problem
        .solve_and_report(&problem.scene().solve)
        .expect("a solve");
    let found: [(LargestStress, StressConcentration); 4] = [
        (clamp, StressConcentration::Clamp),
        (materials, StressConcentration::Materials),
        (contact, StressConcentration::Contact),
        (foot.largest_von_mises, StressConcentration::Notch),
    ];
    for (largest, expected) in found {
        assert_eq!(largest.concentration, Some(expected), "{largest:?}");
        assert_eq!(largest.error, f64::INFINITY);
    }
    // Pressed in the middle, pulled at the end: a rim below the largest stress is named where the next mesh may make it the largest.
    let pinched = |pressure: f64| {
        let bulge = format!("'{pressure:e}*exp(-((x - 1.2)/0.4)^2)'");
        let rest = format!(
            "{steel}\nclamp = [{{ face = 'x_min' }}]\ntraction = [{{ face = 'x_max', value = [1e8, 0, 0] }}]
             pressure = [{{ face = 'z_max', value = {bulge} }}, {{ face = 'z_min', value = {bulge} }}]"
        );
        brick("[2, 1, 1]", "[16, 8, 8]", &rest)
    };
    let [rim, middle] = [5e7, 1e8].map(pinched);
    assert_eq!(rim.concentration, Some(StressConcentration::Clamp));
    assert!(rim.at[0] > 1.0 && rim.limit[0] == 0.0, "{rim:?}");
    assert!(middle.concentration.is_none() && middle.error < 0.2 * middle.value);
}

/// A change of what is held makes stress unbounded where the body and its mirror image make an edge of more than 180°, and a load where it
/// jumps along the face. At an edge of 90° a normal or tangential clamp has a mirror image of 180°; a pressure may jump anywhere.
#[test]
fn what_changes_along_the_surface_concentrates_stress() {
    use StressConcentration::{Clamp, Shear, Springs};
    let largest = |cells: [usize; 3], rest: &str| {
        let text = format!(
            "title = 'change'
             body.brick = {{ size = [2, 2, 1], cells = {cells:?} }}
             material.isotropic = {{ young_modulus = 2e11, poisson_ratio = 0.3 }}
             {rest}"
        );
        report(&text, None).largest_von_mises
    };
    let strip = "box = [[0.5, 0, 0], [1.5, 2, 0]]";
    let top = "box = [[0.5, 0.5, 1], [1.5, 1.5, 1]]";
    let rests = "{ face = 'x_min', components = ['x'] }, { face = 'y_min', components = ['y'] }";
    let planes = format!("clamp = [{rests}, {{ face = 'z_min', components = ['z'] }}]");
    let pressed = "pressure = [{ face = 'z_max', value = 1e6 }]";
    let pulled = "traction = [{ face = 'x_max', value = ['1e6*(1 + y)', 0, 0] }]";
    let strip_held =
        format!("clamp = [{{ face = 'z_min', {strip}, components = ['z'] }}, {rests}]\n{pressed}");
    let on_springs = |stiffness: &str| {
        format!(
            "spring = [{{ face = 'z_min', {strip}, {stiffness} }}]\nclamp = [{rests}]\n{pressed}"
        )
    };
    let across = |components: &str| {
        let ends = "{ face = 'x_max', components = ['x'] }";
        format!(
            "clamp = [{{ face = 'x_min', components = {components} }}, {ends}]\npressure = [{{ face = 'z_max', value = '1e6*(1 + y)' }}]"
        )
    };
    let on_top = |load: &str| format!("{planes}\n{load}");
    let kinds = [
        (strip_held.clone(), Some(Clamp)),
        (across("['x', 'y', 'z']"), Some(Clamp)),
        (across("['y', 'z']"), None),
        (on_top(pulled), None),
        (on_springs("normal = 1e14"), Some(Springs)),
        (on_springs("normal = 1e9"), None),
        (
            on_top(&format!(
                "traction = [{{ face = 'z_max', {top}, value = [1e6, 0, 0] }}]"
            )),
            Some(Shear),
        ),
        (
            on_top(
                "force = [{ face = 'z_max', disc = { centre = [1, 1, 1], radius = 0.4 }, moment = [0, 0, 1e5] }]",
            ),
            Some(Shear),
        ),
        (
            on_top(&format!(
                "pressure = [{{ face = 'z_max', {top}, value = 1e6 }}]"
            )),
            None,
        ),
        (
            on_top(&format!(
                "traction = [{{ face = 'z_max', {top}, value = ['1e6*(1 - 4*(x - 1)^2)*(1 - 4*(y - 1)^2)', 0, 0] }}]"
            )),
            None,
        ),
    ];
    for (rest, expected) in kinds {
        let found = largest([4, 4, 2], &rest);
        assert_eq!(found.concentration, expected, "{rest} {found:?}");
        assert_eq!(found.error.is_infinite(), expected.is_some());
    }
    // Under a rigid flat strip pressure goes as the root of the distance from its edge: √2 with each halving, less what is smooth.
    let growth = largest([16, 4, 8], &strip_held).value / largest([8, 2, 4], &strip_held).value;
    assert!((1.25..1.5).contains(&growth), "{growth}");
}
