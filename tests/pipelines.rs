//! Every pipeline in `pipelines/` runs to convergence at a coarse size.

mod support;

use contact3d_pipe::{
    dual::DualSystem,
    mesh::Mesh,
    post::{ContactReport, Solved},
    scene::{Body, Scene},
    solver::{ContactState, Status, solve},
};
use support::pipelines;

#[test]
fn every_pipeline_converges_with_a_clean_certificate() {
    let mut found = 0;
    for entry in std::fs::read_dir(pipelines()).expect("pipelines folder") {
        let path = entry.expect("directory entry").path();
        if path.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        found += 1;
        let name = path.display().to_string();
        let text = std::fs::read_to_string(&path).expect("readable pipeline");
        let mut scene = Scene::parse(&name, &text).unwrap_or_else(|e| panic!("{name}: {e}"));
        let Body::Brick(brick) = &mut scene.body;
        brick.cells = [12, 4, 4];
        let mesh = Mesh::of_scene(&scene);
        let system = DualSystem::new(&scene, &mesh, 1).expect("positive definite stiffness");
        let frame = scene.contact.frame();
        let contact = ContactState {
            surface: &mesh.contact,
            frame: &frame,
            law: &scene.friction,
        };
        let solution = solve(&system, &contact, &scene.solve, &mut |_| {}).expect("dense S");
        assert_eq!(solution.status, Status::Converged, "{name}");
        let solved = Solved {
            scene: &scene,
            mesh: &mesh,
            system: &system.assembly.primal,
            solution: &solution,
        };
        let certificate = ContactReport::new(&solved).certificate;
        // ε bounds the change of λ, and the figures are a few times larger at most; a residual at
        // ε = 1e-12 is a few hundred roundings.
        assert!(
            certificate.worst() < 10.0 * scene.solve.epsilon(),
            "{name}: {certificate:?}"
        );
        // Equilibrium does not depend on ε: one backsolve with condition number near 1e4.
        assert!(certificate.equilibrium < 1e-12, "{name}: {certificate:?}");
    }
    assert!(found >= 3);
}
