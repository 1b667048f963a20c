//! Sequences of small scenes, and advice read off made-up ones.

use std::path::Path;

use contact3d::{scene::Scene, solver::Status};
use studies::accuracy::{
    AccuracySettings, Cost, MeshSequence, MeshSequences, SequenceAdvice, SequenceKind,
    SequenceLevel,
};

fn level(error: Option<f64>, estimated_error: f64, seconds: f64) -> SequenceLevel {
    SequenceLevel {
        status: Status::Converged,
        estimated_error,
        error,
        cost: Cost {
            seconds,
            ..Cost::default()
        },
        ..SequenceLevel::default()
    }
}

#[test]
fn seconds_to_an_error_lie_on_straight_lines_of_logarithms() {
    // Four times the seconds halve the error.
    let levels = [(0.08, 1.0), (0.04, 4.0), (0.02, 16.0)];
    let sequence = MeshSequence {
        kind: SequenceKind::LinearUniform,
        levels: levels
            .map(|(error, seconds)| level(Some(error), 0.5, seconds))
            .to_vec(),
    };
    let found = |target: f64| sequence.seconds_to(target);
    // Logarithms of numbers of size 1, rounded to 1e-16.
    assert!((found(0.04 / 2_f64.sqrt()).expect("reached") / 8.0 - 1.0).abs() < 1e-13);
    assert!((found(0.02).expect("reached") / 16.0 - 1.0).abs() < 1e-13);
    assert_eq!(found(0.1), Some(1.0));
    assert_eq!(found(0.019), None);
}

#[test]
fn advice_names_the_cheapest_sequence_of_the_targets_that_were_reached() {
    let sequence = |kind, levels: &[SequenceLevel]| MeshSequence {
        kind,
        levels: levels.to_vec(),
    };
    let sequences = [
        sequence(SequenceKind::LinearUniform, &[level(Some(0.04), 0.9, 2.0)]),
        // Its estimate counts where nothing better is known.
        sequence(
            SequenceKind::QuadraticAdaptive,
            &[level(Some(0.05), 0.9, 3.0), level(None, 0.02, 9.0)],
        ),
        sequence(SequenceKind::LinearAdaptive, &[]),
    ];
    let advice = SequenceAdvice::new(&sequences);
    let kinds = advice.cheapest.map(|found| found.map(|(kind, _)| kind));
    assert_eq!(
        kinds,
        [
            Some(SequenceKind::LinearUniform),
            Some(SequenceKind::LinearUniform),
            Some(SequenceKind::QuadraticAdaptive),
            None,
            None
        ]
    );
    assert_eq!(
        advice.to_string(),
        "10 %: P1 uniform, 2.00 s; 5 %: P1 uniform, 2.00 s; 2 %: P2 adaptive, 9.00 s"
    );
}

fn scene(pipeline: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines");
    let text = std::fs::read_to_string(folder.join(pipeline)).expect("a pipeline");
    Scene::parse(pipeline, &text).expect("a scene")
}

fn measure(scene: &Scene, folder: &Path, goal: f64, budget: f64, coarsest: usize) -> MeshSequences {
    let settings = AccuracySettings {
        budget,
        coarsest,
        ..AccuracySettings::default()
    };
    MeshSequences::measure(scene, folder, goal, &settings, &mut |_| {}).expect("sequences")
}

/// A goal so coarse that every sequence meets it on a small mesh: no clock has a say.
#[test]
fn every_sequence_ends_at_its_goal_and_is_judged() {
    const GOAL: f64 = 0.2;
    let scene = scene("newton.toml");
    let sequences = measure(&scene, Path::new(""), GOAL, 1e3, 2);
    let kinds: Vec<SequenceKind> = sequences
        .sequences
        .iter()
        .map(|sequence| sequence.kind)
        .collect();
    assert_eq!(kinds, SequenceKind::ALL);
    for sequence in &sequences.sequences {
        let (last, before) = sequence.levels.split_last().expect("levels");
        assert!(last.estimated_error <= GOAL, "{:?}", sequence.kind);
        assert!(before.iter().all(|level| level.estimated_error > GOAL));
        for level in &sequence.levels {
            assert!(level.status.is_solved() && level.contact_error < level.estimated_error);
            // The aim of the estimate.
            let effectivity = level.effectivity().expect("a true error");
            assert!(
                (0.7..1.5).contains(&effectivity),
                "{:?} {level:?}",
                sequence.kind
            );
        }
        assert!(sequence.levels.is_sorted_by_key(|level| level.n_free));
        use SequenceKind::{LinearAdaptive, QuadraticAdaptive, QuadraticGradedAdaptive};
        if [LinearAdaptive, QuadraticAdaptive, QuadraticGradedAdaptive].contains(&sequence.kind) {
            let seconds = |level: &SequenceLevel| level.cost.seconds;
            assert!(sequence.levels.is_sorted_by(|a, b| seconds(a) < seconds(b)));
        }
    }
    let levels = sequences
        .sequences
        .iter()
        .flat_map(|sequence| &sequence.levels);
    let smallest = levels
        .map(|level| level.estimated_error)
        .fold(f64::INFINITY, f64::min);
    // A quarter of the smallest error that it judges is wanted.
    assert!(sequences.reference.level.estimated_error <= 0.25 * smallest);
}

/// A budget of nothing leaves the first mesh of each sequence, which nothing finer can judge.
#[test]
fn without_a_budget_there_is_one_mesh_and_no_true_error() {
    let scene = scene("newton.toml");
    let sequences = measure(&scene, Path::new(""), 0.01, 0.0, 4);
    for sequence in &sequences.sequences {
        assert_eq!(sequence.levels.len(), 1);
        assert!(sequence.levels[0].error.is_none_or(|error| error > 0.05));
    }
    let best = &sequences.sequences[5].levels[0];
    assert_eq!(
        sequences.reference.level.estimated_error,
        best.estimated_error
    );
}

/// Second-order tetrahedra are no linear ones.
#[test]
fn a_file_of_quadratic_tetrahedra_has_no_linear_sequences() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../contact3d/tests/meshes");
    let scene = Scene::parse(
        "post",
        "title = 'post'
        [body]
        element = 'P2'
        [body.gmsh]
        file = 'post_order2_41.msh'
        [material.isotropic]
        young_modulus = 1e3
        poisson_ratio = 0.3
        [[clamp]]
        face = 'top'
        [body_force]
        value = [0.0, 0.0, -1.0]
        [contact]
        face = 'foot'",
    )
    .expect("a scene");
    let sequences = measure(&scene, &folder, 0.2, 1e3, 2);
    let lengths = sequences
        .sequences
        .iter()
        .map(|sequence| sequence.levels.is_empty());
    assert_eq!(
        lengths.collect::<Vec<_>>(),
        [true, false, true, true, false, true]
    );
    assert!(
        sequences.sequences[4]
            .levels
            .iter()
            .all(|level| level.error.is_some())
    );
}
