//! Every pipeline in `pipelines/` runs to convergence at a coarse size.

mod support;

use std::path::Path;

use contact3d_pipe::{
    contact::Interface,
    dual::DualSystem,
    mesh::Mesh,
    post::{ContactReport, Solved, SolvedContact},
    scene::{Body, Brick, Scene},
    solver::{ContactState, Start, Status, solve},
    sweep::Plan,
};
use support::pipelines;

/// At most 12 cells along the longest edge of a brick, in proportion, and even.
fn coarsen(brick: &mut Brick) {
    let most = brick.cells.iter().copied().max().unwrap_or(1);
    for cells in &mut brick.cells {
        *cells = (*cells * 12 / most.max(12)).div_ceil(2) * 2;
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
    assert!(found >= 3);
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
    let mut scene = Scene::parse(&name, &text).unwrap_or_else(|e| panic!("{name}: {e}"));
    if let Body::Brick(brick) = &mut scene.body {
        coarsen(brick);
    }
    let mesh = Mesh::of_scene(&scene, &pipelines()).unwrap_or_else(|e| panic!("{name}: {e}"));
    let system = DualSystem::new(&scene, &mesh, 1).unwrap_or_else(|e| panic!("{name}: {e}"));
    let interface = Interface::new(&scene, &mesh).unwrap_or_else(|e| panic!("{name}: {e:?}"));
    let state = mesh.contact.as_ref().zip(interface.as_ref());
    let state = state.map(|(surface, interface)| ContactState { surface, interface });
    let solution = solve(
        &system,
        state.as_ref(),
        &scene.solve,
        Start::default(),
        &mut |_| {},
    )
    .expect("a dense operator");
    assert_eq!(solution.status, Status::Converged, "{name}");
    let solved = Solved {
        scene: &scene,
        mesh: &mesh,
        system: &system.assembly.primal,
        contact: system
            .contact
            .as_ref()
            .zip(state)
            .map(|(contact, state)| SolvedContact {
                coupling: &contact.coupling,
                state,
            }),
        solution: &solution,
    };
    let certificate = ContactReport::new(&solved)
        .expect("finite loads")
        .certificate;
    // ε bounds the change of λ, and the figures are a few times larger at most; a residual at
    // ε = 1e-12 is a few hundred roundings.
    assert!(
        certificate.worst() < 10.0 * scene.solve.epsilon(),
        "{name}: {certificate:?}"
    );
    // Equilibrium does not depend on ε: one backsolve with condition number near 1e4.
    assert!(certificate.equilibrium < 1e-12, "{name}: {certificate:?}");
}
