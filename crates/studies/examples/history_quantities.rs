//! Error bars of load histories, which do not see what an increment inherits: coarse adaptive meshes judged by a fine one.
//!
//! `cargo run --release -p contact3d-studies --example history_quantities -- 0.04` refines the reference until the energy norm errs by 4 %.

use std::{error::Error, path::Path};

use contact3d::{
    SolvedProblem,
    adaptation::adapted,
    history::{HistoryErrors, StepRecord},
    scene::{AdaptSettings, ElementOrder, FirstMesh, Functional, Scene, SceneFile, Step},
};

/// Targets of the meshes that are judged.
const TARGETS: [f64; 2] = [0.15, 0.08];

const QUANTITIES: [Functional; 3] = [
    Functional::NormalForce,
    Functional::TangentialForce,
    Functional::StrainEnergy,
];

fn main() -> Result<(), Box<dyn Error>> {
    let goal = std::env::args().nth(1);
    let goal: f64 = goal.map_or(Ok(0.04), |text| text.parse())?;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines");
    let read = |name: &str| SceneFile::read(&folder.join(format!("{name}.toml")));
    let pulled = read("history")?.scene;
    let mut smooth = pulled.clone();
    smooth.friction = None;
    let mut published = read("newton")?.scene;
    published.steps = vec![Step::new("load").in_increments(6)];
    let scenes = [
        ("history", pulled),
        ("history_wear", read("history_wear")?.scene),
        ("newton in 6 increments", published),
        ("history without friction", smooth),
    ];
    for (name, scene) in scenes {
        let best = refined(&scene, goal)?;
        println!("{name}: reference {}", size(&best));
        for target in TARGETS {
            let found = refined(&scene, target)?;
            println!("  {}", size(&found));
            for of in QUANTITIES {
                judge(of, &found.records, &best.records);
            }
            let taken = |all: &SolvedProblem| -> f64 {
                let records = all.records.iter();
                records.map(|record| record.energies.dissipation).sum()
            };
            let (own, true_one) = (taken(&found), taken(&best));
            if true_one > 0.0 {
                let off = 100.0 * (own / true_one - 1.0);
                println!("    dissipation in all off by {off:.2} %");
            }
        }
    }
    Ok(())
}

fn refined(scene: &Scene, error: f64) -> Result<SolvedProblem, Box<dyn Error>> {
    let mut scene = scene.clone();
    scene.bodies[0].element = ElementOrder::P2;
    scene.solve = Default::default();
    scene.adapt = Some(AdaptSettings {
        error,
        of: None,
        start: FirstMesh::Coarse,
    });
    Ok(adapted(scene, Path::new(""))?.0)
}

fn size(of: &SolvedProblem) -> String {
    let errors = HistoryErrors::new(&of.records, None);
    let error = errors.map_or(f64::NAN, |errors| errors.largest());
    format!(
        "{} unknowns, error about {:.1} %",
        of.problem.n_free(),
        100.0 * error
    )
}

/// Prints how many errors are within their bars; a force that a symmetry makes zero, up to rounding, has neither.
fn judge(of: Functional, found: &[StepRecord], best: &[StepRecord]) {
    let largest = best
        .iter()
        .filter_map(|record| Some(record.quantity(of)?.value.abs()));
    let largest = largest.fold(0.0, f64::max);
    let pairs = found.iter().zip(best);
    let shares = pairs.filter_map(|(found, best)| {
        let (found, best) = (found.quantity(of)?, best.quantity(of)?);
        let bar = found.relative() * found.value.abs();
        (found.value.abs() > 1e-9 * largest).then(|| (best.value - found.value).abs() / bar)
    });
    let shares: Vec<f64> = shares.collect();
    let within = |times: f64| shares.iter().filter(|share| **share <= times).count();
    println!(
        "    {:<17} {:>3} of {:>3} within their bars, {:>3} within twice",
        of.word(),
        within(1.0),
        shares.len(),
        within(2.0)
    );
}
