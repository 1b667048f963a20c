//! Moved clamps and springs in the studies: nested and adaptive meshes, paths, stability.

use std::path::Path;

use contact3d::{
    adaptation::{AdaptiveStatus, adapted},
    scene::{AdaptSettings, FirstMesh, Scene},
    solver::Status,
};
use studies::{
    accuracy::{AccuracySettings, DiscretisationStudy},
    branches::{Branches, Family, ParameterRange},
};

use super::support::Case;

const SUPPORTS: &str = "title = 'supports'
[body]
element = 'ELEMENT'
[body.brick]
size = [1.2, 0.8, 0.6]
cells = [6, 4, 4]
[material.isotropic]
young_modulus = 2e11
poisson_ratio = 0.3
[[clamp]]
face = 'z_max'
value = [3e-6, '1e-6*x', '-1e-5*(1 + 0.2*x)']
[[spring]]
face = 'x_min'
normal = 1e12
tangential = 3e11
[[traction]]
face = 'x_max'
value = [4e7, 2e7, 0.0]
";

const CONTACT: &str = "[contact]
face = 'z_min'
gap = '4e-6*x'
[friction]
coefficient.ramp = { initial = 0.4, residual = 0.2, onset = 1e-6, rate = 3e4 }
";

fn scene(element: &str, contact: &str) -> Scene {
    let text = format!("{}{contact}", SUPPORTS.replace("ELEMENT", element));
    Scene::parse("supports", &text).unwrap_or_else(|error| panic!("{error}"))
}

/// ‖u_h − u_f‖² = 2 (J(u_h) − J(u_f)) on nested meshes whose fields agree where they are held: two routes to the same figure.
#[test]
fn nested_meshes_obey_galerkins_identity() {
    for element in ["P1", "P2"] {
        let settings = AccuracySettings {
            coarsest: Some(1),
            finest: Some(if element == "P1" { 8 } else { 4 }),
            ..AccuracySettings::default()
        };
        let study = DiscretisationStudy::measure(
            &scene(element, ""),
            Path::new(""),
            &settings,
            &mut |_| {},
        );
        let levels = study.unwrap().levels;
        assert!(levels.len() >= 2, "{}", levels.len());
        let finest = levels.last().unwrap();
        let energy = Case::new({
            let mut fine = scene(element, "");
            fine.as_brick_mut().unwrap().cells = finest.cells.unwrap();
            fine
        });
        let size = 2.0 * energy.report().resultants.strain_energy;
        for level in &levels[..levels.len() - 1] {
            let by_energies = 2.0 * (level.potential_energy - finest.potential_energy) / size;
            let by_distance = level.energy_difference.powi(2);
            // Energies agree to rounding, some 1e-12 of them, and differ by 1e-4 or more.
            assert!(
                (by_energies / by_distance - 1.0).abs() < 1e-7,
                "{element}: {by_energies:e} {by_distance:e}"
            );
            assert!(by_distance > 1e-5, "{by_distance:e}");
        }
    }
}

#[test]
fn adaptive_meshes_reach_a_target() {
    for (element, target) in [("P1", 0.25), ("P2", 0.06)] {
        let mut scene = scene(element, CONTACT);
        scene.adapt = Some(AdaptSettings {
            start: FirstMesh::Scene,
            error: target,
            of: None,
        });
        let (found, levels) = adapted(scene, Path::new("")).unwrap();
        assert_eq!(levels.status, AdaptiveStatus::Met, "{element}");
        assert!(
            levels.adaptation.levels.len() > 1,
            "the first mesh is too coarse"
        );
        assert!(found.report.discretisation_error.relative() <= target);
        assert!(found.report.certificate.worst() < 1e-9);
        // Held nodes of all levels are where their clamp puts them.
        let mesh = found.problem.mesh();
        let top = mesh.coordinates.iter().zip(&found.report.displacement);
        for (x, u) in top.filter(|(x, _)| x[2] == 0.6) {
            assert_eq!(u[0], 3e-6);
            assert!((u[2] + 1e-5 * (1.0 + 0.2 * x[0])).abs() < 1e-20);
        }
    }
}

/// A clamp's value as the parameter of a path: every point is a solution of its own scene.
#[test]
fn paths_in_a_prescribed_displacement_consist_of_solutions() {
    let base = scene("P1", CONTACT);
    let at = |value: f64| {
        let mut changed = base.clone();
        changed.as_brick_mut().unwrap().cells = [6, 2, 2];
        changed.clamps[0].value = [value.into(), 0.0.into(), (-1e-5).into()];
        Ok(changed)
    };
    let range = ParameterRange {
        key: "clamp.0.value.0".into(),
        from: 0.0,
        to: 1e-5,
    };
    let family = Family::new(range, &at, Path::new("")).unwrap();
    let branches = Branches::follow(&family, false, &mut |_, _| {}).unwrap();
    let points: Vec<_> = branches
        .paths
        .iter()
        .flat_map(|path| &path.points)
        .collect();
    assert!(points.len() >= 5, "{}", points.len());
    let every_third = points.iter().step_by(3);
    for point in every_third {
        assert!(point.residual < 1e-10, "{point:?}");
        let case = Case::new(at(point.parameter).unwrap());
        assert_eq!(case.solution.status, Status::Converged);
        let force = case.report().resultants.contact.unwrap();
        // The path is corrected to rounding, the solve to 1e-12.
        let found = point.normal_force / force.normal_force - 1.0;
        assert!(found.abs() < 1e-9, "{found:e} at {}", point.parameter);
    }
}
