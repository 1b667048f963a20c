//! What a solve says about the surroundings of its answer, against the full derivatives of the natural map and against closed forms.

use std::path::Path;

use contact3d::{
    Problem,
    scene::{Coefficient, Method, Scene, SceneFile},
    solver::{Linearisation, LocalMapping, Solution},
};

fn scene(name: &str, friction: Option<f64>) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines/hard");
    let mut file = SceneFile::read(&folder.join(name)).expect("a scene of the hard cases");
    if let Some(value) = friction {
        let law = file.scene.friction.as_mut().expect("friction");
        law.coefficient = Some(Coefficient::Constant(value));
        (law.coefficient_1, law.coefficient_2) = (None, None);
    }
    file.scene
}

/// The solution and the derivative of the natural map there, in full.
fn solved(scene: Scene) -> (Solution, Linearisation) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines/hard");
    let problem = Problem::in_folder(scene, &folder).expect("a problem");
    let problem = problem.assemble().expect("a factor");
    let solution = problem.solve(&problem.scene().solve).expect("a solve");
    let contact = problem.contact_side().expect("contact");
    let dual = problem.system.contact.as_ref().expect("contact");
    let dual = dual.explicit().expect("a dense operator");
    let full = Linearisation::new(dual, &contact.laws(), &solution.multiplier);
    (solution, full)
}

fn of_mapping(solution: &Solution) -> Option<LocalMapping> {
    solution.friction.as_ref()?.local_mapping
}

fn small_brick(friction: Option<f64>) -> Scene {
    let mut scene = scene("brick.toml", friction);
    scene.bodies = vec![contact3d::scene::Body::brick([3.0, 1.0, 1.0], [12, 4, 4])];
    scene
}

#[test]
fn the_coupled_rows_tell_what_the_full_derivatives_do() {
    let cases = [
        small_brick(None),
        small_brick(Some(0.3)),
        small_brick(Some(2.0)),
        small_brick(Some(1e6)),
        scene("one_node.toml", None),
        scene("two_nodes.toml", None),
    ];
    for scene in cases {
        let title = scene.title.clone();
        let (solution, full) = solved(scene);
        let local = of_mapping(&solution).expect("a solution with Coulomb friction");
        // Squarings of a dense matrix on one side, of a Hessenberg matrix that settles to 1e-8 on the other.
        let difference = (local.spectral_radius - full.contraction).abs();
        assert!(
            difference <= 1e-6 * (1e-6 + full.contraction),
            "{title:?}: {local:?} {full:?}"
        );
        assert_eq!(local.determinant_sign, full.determinant_sign, "{title:?}");
        // Both settle to 1e-8.
        let difference = (local.fold_distance - full.fold_distance).abs();
        assert!(difference <= 1e-6, "{title:?}: {local:?} {full:?}");
    }
}

/// One node under loads of its two tetrahedron faces.
fn loaded_node([first, last]: [f64; 2], friction: f64) -> Scene {
    let mut scene = scene("one_node.toml", Some(friction));
    scene.tractions[0].value = [first.into(), 0.0.into(), last.into()];
    scene
}

/// A node that slides so that friction presses it has λ_ν = h_ν/(S_νν − F |S_νt|), which runs to infinity at F* = S_νν/|S_νt|, where
/// Ψ' = F/F* is 1.
#[test]
fn the_distance_of_one_sliding_node_from_its_fold_is_that_of_its_coefficient() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines/hard");
    // S, and h of each load.
    let [(s, first), (_, last)] = [[1e-3, 0.0], [0.0, 1e-3]].map(|loads| {
        let problem = Problem::in_folder(loaded_node(loads, 1.0), &folder).expect("a problem");
        let problem = problem.assemble().expect("a factor");
        let dual = problem.system.contact.as_ref().expect("contact");
        let dual = dual.explicit().expect("a dense operator");
        let s = [0, 1].map(|i| [0, 1].map(|j| dual.column(j)[i]));
        (s, [dual.rhs[0], dual.rhs[1]])
    });
    let critical = s[0][0] / s[0][1].abs();
    let sign = -s[0][1].signum();
    for share in [0.5, 0.8, 0.95, 0.999] {
        // λ_ν = 1 Pa, and a slip of S_tt.
        let bound = sign * share * critical;
        let h = [
            s[0][0] + s[0][1] * bound,
            s[1][0] + s[1][1] * (bound + sign),
        ];
        let determinant = first[0] * last[1] - first[1] * last[0];
        let loads = [
            1e-3 * (h[0] * last[1] - h[1] * last[0]) / determinant,
            1e-3 * (first[0] * h[1] - first[1] * h[0]) / determinant,
        ];
        let (solution, full) = solved(loaded_node(loads, share * critical));
        // Rounding of h, times 1/(1 − F/F*).
        assert!((solution.multiplier[0] - 1.0).abs() < 1e-10, "{solution:?}");
        let local = of_mapping(&solution).expect("a solution");
        // A number near 1 by 2^22 squarings.
        for distance in [local.fold_distance, full.fold_distance] {
            assert!(
                (distance - (1.0 - share)).abs() < 1e-6,
                "{share}: {local:?}"
            );
        }
        assert_eq!(local.is_near_fold(), share > 0.9);
    }
}

#[test]
fn it_is_there_only_for_solutions_with_coulomb_friction_and_the_dense_operator() {
    let mut implicit = small_brick(Some(0.3));
    implicit.assemble.dual_operator = contact3d::scene::DualOperatorKind::Implicit;
    let problem = Problem::new(implicit).unwrap().assemble().unwrap();
    let settings = &problem.scene().solve;
    assert!(of_mapping(&problem.solve(settings).unwrap()).is_none());
    let mut unfinished = small_brick(Some(0.3));
    unfinished.solve.method = Method::FixedPoint;
    unfinished.solve.max_outer_steps = 1;
    let problem = Problem::new(unfinished).unwrap().assemble().unwrap();
    let settings = &problem.scene().solve;
    assert!(of_mapping(&problem.solve(settings).unwrap()).is_none());
    let mut frictionless = small_brick(None);
    frictionless.friction = None;
    let problem = Problem::new(frictionless).unwrap().assemble().unwrap();
    let settings = &problem.scene().solve;
    assert!(of_mapping(&problem.solve(settings).unwrap()).is_none());
}
