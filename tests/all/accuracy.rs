//! The studies of accuracy on small scenes, against identities that hold without them.

use std::{path::Path, sync::LazyLock};

use crate::support::{hkl_scene, refine};
use contact3d::{
    ProblemError,
    scene::{ElementOrder, Scene},
    solver::Status,
};
use studies::accuracy::{Accuracy, AccuracySettings, RunMethod, RunOperator};

const SETTINGS: AccuracySettings = AccuracySettings {
    // Ten times what the five cheapest runs of each method take, since which fit depends on what else the machine does.
    budget: Some(120.0),
    coarsest: Some(2),
    finest: Some(8),
    unknowns: None,
};

fn measure(scene: &Scene, settings: &AccuracySettings) -> Result<Accuracy, ProblemError> {
    Accuracy::measure(scene, Path::new(""), settings, &mut |_| {})
}

/// The studies of the published problem, measured once for the tests that read them.
static PUBLISHED: LazyLock<Accuracy> =
    LazyLock::new(|| measure(&hkl_scene(1, 4), &SETTINGS).expect("a brick"));

/// Without contact the problem is linear and the spaces are nested, so Galerkin's orthogonality
/// ties the energy norm of each difference to energies alone: ‖u_h − u_f‖² = 2 (J_h − J_f).
#[test]
fn energy_norms_of_differences_are_differences_of_energies_in_a_linear_problem() {
    let mut scene = hkl_scene(1, 4);
    scene.contacts.clear();
    scene.friction = None;
    let accuracy = measure(&scene, &SETTINGS).expect("a brick");
    assert!(accuracy.algebraic.is_none());
    let study = accuracy.discretisation;
    let levels = &study.levels;
    let n_div = [2, 4, 8].map(|n| Some([3 * n, n, n]));
    assert!(levels.iter().map(|level| level.cells).eq(n_div));
    let finest = levels[2].potential_energy;
    for level in levels {
        // J = −½‖u‖² in a linear problem.
        let expected = (2.0 * (level.potential_energy - finest) / (-2.0 * finest)).sqrt();
        // The square root of a difference of energies rounded to 1e-13.
        assert!((level.energy_difference - expected).abs() < 1e-6);
    }
    // For such spaces the two orders differ by the factor 2 of the square.
    let [norm, energy] = [&study.energy_norm, &study.potential_energy]
        .map(|trend| trend.orders[2].expect("convergence"));
    assert!((energy - 2.0 * norm).abs() < 1e-6);
    // P1 elements reach 1 on smooth solutions and no more; the clamped edges take some of it.
    assert!((0.3..1.05).contains(&norm), "{norm}");
}

#[test]
fn every_method_approaches_the_reference_as_epsilon_falls() {
    let study = PUBLISHED.algebraic.as_ref().expect("contact");
    assert!(matches!(
        study.reference_status,
        Status::Converged | Status::MachinePrecision
    ));
    let series = study.series();
    assert_eq!(series.len(), 5);
    for entries in series {
        let name = format!("{:?}, {:?}", entries[0].method, entries[0].operator);
        let ran: Vec<_> = entries
            .iter()
            .filter_map(|entry| Some((entry.epsilon, entry.result?)))
            .filter(|(_, result)| result.status.is_solved())
            .collect();
        assert!(ran.len() >= 5, "{name}");
        for (epsilon, result) in &ran {
            // ε bounds the last change; the distance to the fixed point is that over one minus
            // the contraction factor, which is near 0.9 here at worst.
            assert!(
                result.multiplier_error <= 50.0 * epsilon,
                "{name}, {epsilon}"
            );
            // S is bounded by its norm, so u is no farther off than λ by the same measure.
            assert!(result.energy_error <= 2.0 * result.multiplier_error + 1e-13);
            assert!(result.applications > 0 && result.cost.seconds > 0.0);
        }
        let errors = [ran[0].1.energy_error, ran[ran.len() - 1].1.energy_error];
        assert!(errors[1] < 1e-2 * errors[0], "{name}: {errors:?}");
    }
    let both = [RunOperator::Explicit, RunOperator::Implicit].map(|operator| {
        let entry = study.entries.iter().find(|entry| {
            entry.method == RunMethod::FixedPrecision
                && entry.operator == operator
                && entry.epsilon == 1e-4
        });
        entry.and_then(|entry| entry.result).expect("a cheap entry")
    });
    // Both operators are the same map: errors agree up to rounding in a thousand steps.
    assert!((both[0].energy_error / both[1].energy_error - 1.0).abs() < 1e-6);
}

#[test]
fn the_advice_has_numbers_in_it() {
    let advice = PUBLISHED.advice(ElementOrder::P1);
    let error = advice.discretisation_error.expect("an order");
    // A coarse mesh of linear elements: between a few per cent and all.
    assert!(
        advice.mesh.energy_error == Some(error) && (0.05..0.9).contains(&error),
        "{error}"
    );
    let finer = advice.finer.expect("a finer mesh");
    assert_eq!(finer.cells, Some([24, 8, 8]));
    assert!(finer.energy_error.expect("an order") < error);
    let epsilon = advice.sufficient_epsilon.expect("strict entries suffice");
    let entries = &PUBLISHED.algebraic.as_ref().expect("contact").entries;
    for entry in entries.iter().filter(|entry| entry.epsilon <= epsilon) {
        for result in entry
            .result
            .iter()
            .filter(|r| r.status == Status::Converged)
        {
            assert!(result.energy_error <= 0.1 * error);
        }
    }
    let text = advice.to_string();
    for part in [
        "12 x 4 x 4 cells".to_owned(),
        format!("{:.0} %", 100.0 * error),
        format!("{epsilon:.0e}"),
        format!("{:.1} times", finer.cost.seconds / advice.mesh.cost.seconds),
    ] {
        assert!(text.contains(&part), "{part} not in {text}");
    }
}

#[test]
fn what_the_budget_does_not_cover_is_left_out_and_said() {
    let settings = AccuracySettings {
        budget: Some(1e-9),
        ..SETTINGS
    };
    let accuracy = measure(&hkl_scene(1, 4), &settings).expect("a brick");
    for entries in accuracy.algebraic.expect("contact").series() {
        assert!(entries[0].result.is_some());
        assert!(entries[1..].iter().all(|entry| entry.result.is_none()));
    }
}

#[test]
fn a_finest_mesh_that_does_not_nest_the_scenes_is_refused() {
    let mut scene = hkl_scene(1, 4);
    refine(&mut scene, [12, 4, 4]);
    let settings = AccuracySettings {
        finest: Some(6),
        ..SETTINGS
    };
    let error = measure(&scene, &settings).expect_err("6 is no multiple of 4");
    assert!(error.to_string().contains("a multiple of 4"), "{error}");
}
