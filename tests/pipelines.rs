//! Every pipeline in `pipelines/` runs to convergence at a coarse size.

mod support;

use contact3d_pipe::{
    scene::{Body, Scene},
    solver::Status,
};
use support::{Problem, pipelines};

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
        let problem = Problem::new(&scene);
        let solution = problem.solve(&scene);
        assert_eq!(solution.status, Status::Converged, "{name}");
        let certificate = problem.report(&scene, &solution).certificate;
        // ε = 1e-4 bounds the change of λ; the figures are of that size, a few times larger at most.
        assert!(certificate.worst() < 1e-3, "{name}: {certificate:?}");
        // Equilibrium does not depend on ε: one backsolve with condition number near 1e4.
        assert!(certificate.equilibrium < 1e-12, "{name}: {certificate:?}");
    }
    assert!(found >= 2);
}
