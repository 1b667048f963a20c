//! Every pipeline in `pipelines/` runs to convergence at a coarse size.

use std::path::Path;

use crate::support::{Case, pipelines};
use contact3d::{
    scene::{Brick, GivenPlanes, Method, Scene},
    solver::Status,
};
use contact3d_pipe::Plan;

/// At most 12 cells along the longest edge of a brick, in proportion, and even; single layers stay, and bricks between given planes.
fn coarsen(brick: &mut Brick) {
    if brick.coordinates != GivenPlanes::default() {
        return;
    }
    let most = brick.cells.iter().copied().max().unwrap_or(1);
    for cells in brick.cells.iter_mut().filter(|cells| **cells > 1) {
        *cells = (*cells * 12 / most.max(12)).max(1).div_ceil(2) * 2;
    }
}

#[test]
fn every_pipeline_converges_with_a_clean_certificate() {
    let mut found = 0;
    for entry in std::fs::read_dir(pipelines()).expect("pipelines folder") {
        let path = entry.expect("directory entry").path();
        let name = entry_name(&path);
        if !name.ends_with(".toml") || name.starts_with("sweep_") {
            continue;
        }
        found += 1;
        check(&path);
    }
    assert!(found >= 20);
}

fn entry_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

#[test]
fn the_sweep_over_friction_has_at_least_60_cases() {
    let plan = Plan::read(&pipelines().join("sweep_friction.toml"));
    let plan = plan.unwrap_or_else(|e| panic!("{e}"));
    assert!(plan.cases.len() >= 60);
}

fn check(path: &Path) {
    let name = path.display().to_string();
    let text = std::fs::read_to_string(path).expect("readable pipeline");
    let mut lines = text.lines();
    for start in ["# Shows: ", "# Expect: "] {
        let line = lines.next().unwrap_or_default();
        assert!(line.starts_with(start), "{name} does not say {start}");
    }
    let mut scene = Scene::parse(&name, &text).unwrap_or_else(|e| panic!("{name}: {e}"));
    if let Some(brick) = scene.as_brick_mut() {
        coarsen(brick);
    }
    let case = Case::try_new(scene, &pipelines()).unwrap_or_else(|e| panic!("{name}: {e}"));
    // The published stopping rule at ε = 1e-4 leaves up to a per cent or so, and says it.
    let published = case.scene().solve.method == Method::FixedPoint;
    let (expected, accuracy) = if published {
        (Status::ReducedAccuracy, 2e-2)
    } else {
        (Status::Converged, case.scene().solve.epsilon())
    };
    assert_eq!(case.solution.status, expected, "{name}");
    assert!(case.solution.accuracy <= accuracy, "{name}");
    let certificate = case.report().certificate;
    // A figure is the error of one pane over the largest stress, the accuracy a mean over the face; a
    // residual at ε = 1e-12 is a few hundred roundings.
    assert!(
        certificate.worst() < 10.0 * case.solution.accuracy.max(case.scene().solve.epsilon()),
        "{name}: {certificate:?}"
    );
    // Equilibrium does not depend on ε: one backsolve with condition number near 1e4, 1e6 where
    // stiffnesses differ a hundredfold.
    assert!(certificate.equilibrium < 1e-11, "{name}: {certificate:?}");
}
