//! Bodies that only contact holds, against closed forms of statics.

mod equilibria;
mod limits;

use contact3d::{
    AssembledProblem, Problem,
    elasticity::BodyMotion,
    scene::{Scene, SolveSettings},
    solver::Solution,
};

/// Share of the limit by which loads stay below or go beyond it.
const NEAR: f64 = 1e-6;

/// A block 2 × 1 × h m of steel on its face z_min; `rest` says how it is loaded and slides.
fn block(size: [f64; 3], cells: [usize; 3], rest: &str) -> AssembledProblem {
    let text = format!(
        "title = 'block'
        [body.brick]
        size = {size:?}
        cells = {cells:?}
        [material.isotropic]
        young_modulus = 2.1e11
        poisson_ratio = 0.3
        {rest}"
    );
    let scene = Scene::parse("floating", &text).unwrap_or_else(|error| panic!("{error}"));
    Problem::new(scene)
        .and_then(|problem| problem.assemble())
        .unwrap_or_else(|error| panic!("{error}"))
}

fn solved(problem: &AssembledProblem) -> Solution {
    problem.solve(&SolveSettings::default()).expect("a solve")
}

/// Weight of 77 kN/m³ on a slope of tangent `slope` that falls towards x turned by `angle` towards y.
fn weight(slope: f64, angle: f64) -> String {
    let normal = 7.7e4 / slope.hypot(1.0);
    let (sin, cos) = angle.sin_cos();
    let along = normal * slope;
    format!(
        "[body_force]
        value = [{:e}, {:e}, {:e}]",
        along * cos,
        along * sin,
        -normal
    )
}

fn contact(multipliers: &str, friction: &str) -> String {
    format!(
        "[contact]
        face = 'z_min'
        multipliers = '{multipliers}'
        [friction]
        {friction}"
    )
}

/// The mechanism.
fn motion(problem: &AssembledProblem, solution: &Solution) -> BodyMotion {
    let rigid = solution.rigid.as_ref().expect("a floating body");
    let mechanism = rigid.mechanism.as_ref().expect("a motion");
    let mesh = problem.mesh();
    BodyMotion::fitted(&mesh.coordinates, &mesh.corner_volumes(), mechanism)
}

/// What a body in equilibrium must show, whatever it does.
fn assert_balanced(problem: &AssembledProblem, solution: &Solution) {
    assert!(solution.status.is_solved(), "{:?}", solution.status);
    let report = problem.report(solution).expect("a report");
    let resultants = &report.resultants;
    // Sums of some thousand forces, each with its rounding.
    assert!(resultants.force_imbalance < 1e-11, "{resultants:?}");
    assert!(resultants.moment_imbalance < 1e-11, "{resultants:?}");
    assert_eq!(resultants.clamp_force, [0.0; 3]);
    // The displacement of a face that sticks, against the compliance of a pane.
    assert!(
        report.certificate.worst() < 1e-7,
        "{:?}",
        report.certificate
    );
}
