//! Contact with rigid obstacles against the closed forms of Hertz (K. L. Johnson, *Contact Mechanics*, Cambridge 1985,
//! §4.2): peak pressure, size of the contact and approach, with the orders in which the errors fall.
//!
//! The blocks are held at the top and sag under body forces by a known δ: uniaxial strain between rollers, which keeps
//! the lower face flat. That is the same as an obstacle pressed δ deep into the block.

use std::path::Path;

use contact3d::{
    AssembledProblem, Problem,
    post::ContactReport,
    scene::{Scene, SolveSettings},
};

const YOUNG: f64 = 1.0;
const POISSON: f64 = 0.3;

/// E* = E/(1 − ν²) of a body against a rigid one.
const E_STAR: f64 = YOUNG / (1.0 - POISSON * POISSON);

/// The modulus of uniaxial strain.
const UNIAXIAL: f64 = YOUNG * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));

/// Contact radius, or half width, that the approaches are made for, over the edge of the block, which is 1.
const RADIUS: f64 = 0.05;

/// Planes that shrink towards 0: x = sinh(5 i/n)/sinh(5).
fn planes(n: usize) -> String {
    let at = |i: usize| match i == n {
        true => 1.0,
        false => (5.0 * i as f64 / n as f64).sinh() / 5.0_f64.sinh(),
    };
    let planes: Vec<String> = (0..=n).map(|i| format!("{:?}", at(i))).collect();
    format!("[{}]", planes.join(", "))
}

struct Solved {
    problem: AssembledProblem,
    report: ContactReport,
}

impl Solved {
    fn new(text: &str) -> Self {
        let scene = Scene::parse("hertz", text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let problem = Problem::in_folder(scene, Path::new(env!("CARGO_MANIFEST_DIR")))
            .and_then(Problem::assemble)
            .unwrap_or_else(|error| panic!("{error}"));
        let solution = problem.solve(&SolveSettings::default()).expect("a solve");
        assert!(solution.status.is_solved());
        let report = problem.report(&solution).expect("a report");
        assert!(report.certificate.worst() < 1e-9, "{:?}", report.certificate);
        Self { problem, report }
    }

    /// Force of the obstacle on the body.
    fn force(&self) -> [f64; 3] {
        self.report.resultants.contact.expect("contact").contact_force
    }

    /// ∫ p w dA over ∫ p dA for a function w of the place.
    fn pressure_mean(&self, weight: impl Fn([f64; 3]) -> f64) -> f64 {
        let mesh = self.problem.mesh();
        let surface = mesh.contact.as_ref().expect("contact");
        let mut sums = [0.0; 2];
        for (pane, state) in self.report.panes.iter().enumerate() {
            let mean: f64 = surface
                .pane_weights(pane)
                .map(|(node, share)| share * weight(mesh.coordinates[surface.nodes[node]]))
                .sum();
            let force = -state.normal_stress * surface.pane_area[pane];
            sums = [sums[0] + force * mean, sums[1] + force];
        }
        sums[0] / sums[1]
    }

    fn peak(&self) -> f64 {
        self.report.resultants.contact.expect("contact").largest_pressure
    }

    /// u_z at a corner of the mesh.
    fn lift(&self, at: [f64; 3]) -> f64 {
        let nodes = self.problem.mesh().coordinates.iter();
        let distance = |x: &[f64; 3]| -> f64 { (0..3).map(|c| (x[c] - at[c]).powi(2)).sum() };
        let nearest = nodes
            .enumerate()
            .min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)))
            .expect("nodes");
        self.report.displacement[nearest.0][2]
    }
}

/// A quarter of a block, or a slice of one cell, pressed δ deep on an obstacle below the origin.
fn block(n: usize, slice: Option<f64>, delta: f64, contact: &str) -> String {
    let (width, cells, planes_y) = match slice {
        None => (1.0, n, format!("coordinates.y = {}\n", planes(n))),
        Some(width) => (width, 1, String::new()),
    };
    let rollers: String = [("x_min", "x"), ("x_max", "x"), ("y_min", "y"), ("y_max", "y"), ("z_max", "z")]
        .map(|(face, along)| format!("[[clamp]]\nface = '{face}'\ncomponents = ['{along}']\n"))
        .concat();
    format!(
        "title = 'hertz'\n[body]\nelement = 'P2'\n[body.brick]\nsize = [1.0, {width:?}, 1.0]\ncells = [{n}, {cells}, {n}]\n\
         coordinates.x = {0}\n{planes_y}coordinates.z = {0}\n\
         [material.isotropic]\nyoung_modulus = {YOUNG:?}\npoisson_ratio = {POISSON:?}\n{rollers}\
         [body_force]\nvalue = [0.0, 0.0, {1:?}]\n[contact]\nface = 'z_min'\n{contact}",
        planes(n),
        -2.0 * UNIAXIAL * delta
    )
}

/// Relative errors of p₀, a and the approach against a point of the surface 3a away, for a sphere of this radius.
fn sphere_errors(n: usize, multipliers: &str) -> [f64; 3] {
    let radius = 2.0;
    let contact = format!(
        "multipliers = '{multipliers}'\n[contact.obstacle.sphere]\ncentre = [0.0, 0.0, {:?}]\nradius = {radius:?}\n",
        -radius
    );
    let solved = Solved::new(&block(n, None, RADIUS * RADIUS / radius, &contact));
    let force = 4.0 * solved.force()[2];
    let a = (3.0 * force * radius / (4.0 * E_STAR)).cbrt();
    let peak = 3.0 * force / (2.0 * std::f64::consts::PI * a * a);
    // ∫ p r² / ∫ p = 2a²/5 for p = p₀ √(1 − r²/a²).
    let found = (2.5 * solved.pressure_mean(|x| x[0] * x[0] + x[1] * x[1])).sqrt();
    // Beyond the contact (Johnson (3.42a)).
    let i = (1..n).find(|i| (5.0 * *i as f64 / n as f64).sinh() / 5.0_f64.sinh() > 3.0 * a);
    let far = (5.0 * i.expect("a plane") as f64 / n as f64).sinh() / 5.0_f64.sinh();
    let outside = |r: f64| {
        let angle = (2.0 * a * a - r * r) * (a / r).asin();
        peak / (2.0 * a * E_STAR) * (angle + r * a * (1.0 - a * a / (r * r)).sqrt())
    };
    let approach = a * a / radius - outside(far);
    let moved = solved.lift([0.0; 3]) - solved.lift([far, 0.0, 0.0]);
    [solved.peak() / peak - 1.0, found / a - 1.0, moved / approach - 1.0]
}

/// Relative errors of p₀ and b for a cylinder along y.
fn cylinder_errors(n: usize, multipliers: &str) -> [f64; 2] {
    let (radius, width) = (2.0, 0.1);
    let contact = format!(
        "multipliers = '{multipliers}'\n[contact.obstacle.cylinder]\npoint = [0.0, 0.0, {:?}]\ndirection = [0.0, 1.0, 0.0]\n\
         radius = {radius:?}\n",
        -radius
    );
    let solved = Solved::new(&block(n, Some(width), 2.5 * RADIUS * RADIUS / radius, &contact));
    let force = 2.0 * solved.force()[2] / width;
    let b = (4.0 * force * radius / (std::f64::consts::PI * E_STAR)).sqrt();
    let peak = 2.0 * force / (std::f64::consts::PI * b);
    // ∫ p x² / ∫ p = b²/4.
    let found = (4.0 * solved.pressure_mean(|x| x[0] * x[0])).sqrt();
    [solved.peak() / peak - 1.0, found / b - 1.0]
}

#[test]
#[ignore = "figures for the page"]
fn table() {
    for multipliers in ["panes", "nodal"] {
        for n in [5, 10, 15, 20] {
            println!("sphere {multipliers} {n} {:?}", sphere_errors(n, multipliers));
        }
        for n in [10, 20, 40, 80] {
            println!("cylinder {multipliers} {n} {:?}", cylinder_errors(n, multipliers));
        }
    }
}
