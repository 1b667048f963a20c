//! Quadratic tetrahedra: polynomials they hold exactly, orders of convergence, published-problem figures
//! of another implementation, and panes that keep S regular.

use std::path::Path;

use contact3d::{
    Problem,
    mesh::Mesh,
    post::ContactReport,
    scene::{ElementOrder, Scene, SolveSettings},
};
use nalgebra::Vector3;

fn scene(text: &str) -> Scene {
    Scene::parse("quadratic", text).unwrap_or_else(|error| panic!("{error}"))
}

/// Mesh and report of a scene.
fn solved(text: &str) -> (Mesh, ContactReport) {
    let scene = scene(text);
    let mesh = Mesh::of_scene(&scene, Path::new("")).expect("a mesh");
    let assembled = Problem::new(scene)
        .and_then(|p| p.assemble())
        .expect("a problem");
    let solution = assembled.solve(&SolveSettings::default()).expect("a solve");
    assert!(solution.status.is_solved());
    (mesh, assembled.report(&solution).expect("a report"))
}

/// u = (x², 0, 0) between rollers, with E = 1, ν = 0.25: λ = μ = 0.4, σ_xx = 2.4 x, σ_yy = σ_zz = 0.8 x.
#[test]
fn a_quadratic_displacement_is_exact() {
    let (mesh, report) = solved(
        "title = 'quadratic'
        body = { element = 'P2', brick = { size = [2.0, 1.0, 1.0], cells = [2, 1, 1] } }
        material.isotropic = { young_modulus = 1.0, poisson_ratio = 0.25 }
        clamp = [{ face = 'x_min', components = ['x'] },
                 { face = 'y_min', components = ['y'] }, { face = 'y_max', components = ['y'] },
                 { face = 'z_min', components = ['z'] }, { face = 'z_max', components = ['z'] }]
        body_force.value = [-2.4, 0.0, 0.0]
        traction = [{ face = 'x_max', value = [4.8, 0.0, 0.0] }]",
    );
    for (x, u) in mesh.coordinates.iter().zip(&report.displacement) {
        let exact = [x[0] * x[0], 0.0, 0.0];
        // Roundings of displacements up to 4 through a matrix of condition below 1e4.
        assert!(
            (0..3).all(|c| (u[c] - exact[c]).abs() < 1e-12),
            "{x:?} {u:?}"
        );
    }
    for (x, stress) in mesh.coordinates.iter().zip(&report.nodal_stress) {
        let exact = [2.4 * x[0], 0.8 * x[0], 0.8 * x[0], 0.0, 0.0, 0.0];
        // The same roundings times slopes of 1/h.
        assert!((0..6).all(|c| (stress[c] - exact[c]).abs() < 1e-11));
    }
    // Nothing is left to estimate: cubic polynomials see roundings alone.
    assert!(report.discretisation_error.relative() < 1e-11);
}

/// Errors in L² over ‖u‖ and in the gradient over ‖∇u‖ for u = s(x) s(y) s(z) (1, 2, −1) in the unit
/// cube, s = sin π, at the midpoints and centroids of tetrahedra cut eightfold.
fn manufactured(element: &str, n: usize) -> [f64; 2] {
    // f = −μ Δu − (λ + μ) ∇(∇·u) with E = 1, ν = 0.25, so λ = μ = 0.4: 1.2 π² u − 0.8 ∇(∇·u).
    let s = |v: &str| format!("sin(3.141592653589793*{v})");
    let c = |v: &str| format!("cos(3.141592653589793*{v})");
    let bump = format!("{}*{}*{}", s("x"), s("y"), s("z"));
    let mixed = |a: &str, b: &str, rest: &str| format!("{}*{}*{}", c(a), c(b), s(rest));
    let [xy, xz, yz] = [
        mixed("x", "y", "z"),
        mixed("x", "z", "y"),
        mixed("y", "z", "x"),
    ];
    let pi2 = std::f64::consts::PI.powi(2);
    let force = [
        format!("{pi2}*((1.2+0.8)*{bump} - 0.8*(2*{xy} - {xz}))"),
        format!("{pi2}*((2.4+1.6)*{bump} - 0.8*({xy} - {yz}))"),
        format!("{pi2}*((-1.2-0.8)*{bump} - 0.8*({xz} + 2*{yz}))"),
    ];
    let clamps: String = ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"]
        .map(|face| format!("[[clamp]]\nface = '{face}'\n"))
        .concat();
    let (mesh, report) = solved(&format!(
        "title = 'manufactured'
        [body]
        element = '{element}'
        [body.brick]
        size = [1.0, 1.0, 1.0]
        cells = [{n}, {n}, {n}]
        [material.isotropic]
        young_modulus = 1.0
        poisson_ratio = 0.25
        {clamps}
        [body_force]
        value = ['{}', '{}', '{}']",
        force[0], force[1], force[2]
    ));
    let exact = |x: &Vector3<f64>| {
        let bump: f64 = x.iter().map(|v| (std::f64::consts::PI * v).sin()).product();
        Vector3::new(1.0, 2.0, -1.0) * bump
    };
    let mut sums = [0.0; 4];
    for t in 0..mesh.tetrahedra.len() {
        let nodes: Vec<usize> = mesh.tetrahedron_nodes(t).collect();
        let corners = mesh.corners(&mesh.tetrahedra[t]).map(Vector3::from);
        let at =
            |weights: [f64; 4]| -> Vector3<f64> { (0..4).map(|k| corners[k] * weights[k]).sum() };
        let edges = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];
        let value = |w: [f64; 4]| -> Vector3<f64> {
            let shape: Vec<f64> = match nodes.len() {
                4 => w.to_vec(),
                _ => {
                    let corner = w.iter().map(|l| l * (2.0 * l - 1.0));
                    corner
                        .chain(edges.map(|[a, b]| 4.0 * w[a] * w[b]))
                        .collect()
                }
            };
            let terms = nodes.iter().zip(&shape);
            terms
                .map(|(n, w)| Vector3::from(report.displacement[*n]) * *w)
                .sum()
        };
        let volume = contact3d::mesh::tetrahedron_volume(&mesh.corners(&mesh.tetrahedra[t]));
        // Points that no symmetry of the solution favours, and central differences between them.
        for k in 0..4 {
            let mut w = [0.138_196_601_125_010_5; 4];
            w[k] = 0.585_410_196_624_968_5;
            let error = value(w) - exact(&at(w));
            sums[0] += volume * error.norm_squared();
            sums[1] += volume * exact(&at(w)).norm_squared();
            for axis in 1..4 {
                const STEP: f64 = 1e-4;
                let moved = |by: f64| {
                    let mut w = w;
                    w[axis] += by;
                    w[0] -= by;
                    w
                };
                let slope = |of: &dyn Fn([f64; 4]) -> Vector3<f64>| {
                    (of(moved(STEP)) - of(moved(-STEP))) / (2.0 * STEP)
                };
                let length = (corners[axis] - corners[0]).norm();
                let [found, wanted] =
                    [slope(&value), slope(&|w| exact(&at(w)))].map(|s| s / length);
                sums[2] += volume * (found - wanted).norm_squared();
                sums[3] += volume * wanted.norm_squared();
            }
        }
    }
    [(sums[0] / sums[1]).sqrt(), (sums[2] / sums[3]).sqrt()]
}

#[test]
fn smooth_solutions_converge_with_the_orders_of_the_element() {
    for (element, cells, orders) in [("P1", [4, 8], [2.0, 1.0]), ("P2", [3, 6], [3.0, 2.0])] {
        let [coarse, fine] = cells.map(|n| manufactured(element, n));
        for ((coarse, fine), order) in coarse.iter().zip(fine).zip(orders) {
            let found = (coarse / fine).log2();
            // The next term of the error is a few per cent on these meshes.
            assert!(
                (found - order).abs() < 0.2,
                "{element}: order {found:.2}, expected {order}"
            );
        }
    }
}

const PUBLISHED: &str = include_str!("../../../../pipelines/newton.toml");

fn published(element: ElementOrder, n_div: usize) -> Scene {
    let mut scene = scene(PUBLISHED);
    scene.bodies[0].element = element;
    scene.as_brick_mut().expect("a brick").cells = [3 * n_div, n_div, n_div];
    scene
}

/// J of a prototype in Python with its own elements, panes and Newton's method.
#[test]
fn energies_of_the_published_problem_agree_with_another_implementation() {
    for (n_div, energy) in [(2, -7_845.876), (4, -7_847.356)] {
        let scene = published(ElementOrder::P2, n_div);
        let assembled = Problem::new(scene)
            .and_then(|p| p.assemble())
            .expect("a problem");
        let solution = assembled.solve(&SolveSettings::default()).expect("a solve");
        let report = assembled.report(&solution).expect("a report");
        let r = report.resultants;
        // Half a unit of the last digit known.
        assert!((r.strain_energy - r.load_work - energy).abs() <= 5e-4);
        assert!(report.certificate.worst() < 1e-12);
    }
}

/// A round post of height 0.5 with ν = 0 between rollers, hung from its top over a smooth foundation, under
/// its weight 1 per volume: u_z = (z² − z/2)/(2E), so half the weight presses the foot.
///
/// Quadratic sides through points of a cylinder are upright only to a thousandth of their curvature, so σ_zz
/// finds a little of them to act on.
#[test]
fn a_post_with_curved_sides_stands_on_half_its_weight() {
    const UPRIGHT: f64 = 1e-3;
    const YOUNG: f64 = 1e3;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes");
    for file in ["post_order2_41.msh", "post_order2_22.msh"] {
        let path = folder.join(file);
        let (mesh, report) = solved(&format!(
            "title = 'post'
            [body]
            element = 'P2'
            [body.gmsh]
            file = '{}'
            [material.isotropic]
            young_modulus = {YOUNG:?}
            poisson_ratio = 0.0
            [[clamp]]
            face = 'side'
            components = ['x', 'y']
            [[clamp]]
            face = 'top'
            components = ['z']
            [body_force]
            value = [0.0, 0.0, -1.0]
            [contact]
            face = 'foot'",
            path.display()
        ));
        assert!(report.panes.len() > 3);
        for pane in &report.panes {
            let relative = pane.normal_stress / -0.25 - 1.0;
            assert!(relative.abs() < UPRIGHT, "{relative}");
        }
        for (x, u) in mesh.coordinates.iter().zip(&report.displacement) {
            let exact = (x[2] * x[2] - 0.5 * x[2]) / (2.0 * YOUNG);
            let largest = 1.0 / 16.0 / (2.0 * YOUNG);
            assert!((u[2] - exact).abs() < UPRIGHT * largest, "{x:?} {u:?}");
        }
        // Sides of half a radius: quadratic arcs are off a circle by less than a thousandth.
        let force = report.resultants.contact.expect("contact").normal_force;
        let relative = force / (0.25 * std::f64::consts::PI) - 1.0;
        assert!(relative.abs() < 1e-3, "{relative}");
        assert!(report.resultants.force_imbalance < 1e-12);
        let weight = report.resultants.applied_force[2] / (-0.5 * std::f64::consts::PI);
        assert!((weight - 1.0).abs() < 1e-3);
    }
}
