//! Estimated over true errors: for every scene the meshes of all sequences, judged by an adaptive quadratic reference.
//!
//! `cargo run --release -p contact3d-studies --example effectivity -- 10 0.05 gap` gives each sequence 10 s and ends it at an
//! estimated error of 5 %, for scenes with "gap" in their name; without a name for all of them.

use std::{error::Error, path::Path};

use contact3d::scene::{Friction, Scene, SceneFile};
use studies::accuracy::{AccuracySettings, MeshSequences};

/// Scenes of `pipelines/`.
const PIPELINES: [&str; 9] = [
    "hkl2011_table1",
    "hkl2011_table2",
    "frictionless",
    "gap",
    "regions",
    "orthotropic_material",
    "tresca",
    "turning_frame",
    "gmsh_foot",
];

/// Coefficient of friction of a foundation that hardly lets anything slip.
const NEARLY_RIGID: f64 = 1e6;

fn scenes(folder: &Path) -> Result<Vec<(&'static str, Scene)>, Box<dyn Error>> {
    let mut scenes = Vec::new();
    for name in PIPELINES {
        scenes.push((
            name,
            SceneFile::read(&folder.join(format!("{name}.toml")))?.scene,
        ));
    }
    let rigid = scenes[0]
        .1
        .clone()
        .with_friction(Friction::coulomb(NEARLY_RIGID));
    scenes.push(("nearly_rigid_friction", rigid));
    Ok(scenes)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let budget = arguments.next().map_or(Ok(10.0), |text| text.parse())?;
    let goal = arguments.next().map_or(Ok(0.05), |text| text.parse())?;
    let wanted = arguments.next().unwrap_or_default();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines");
    let settings = AccuracySettings {
        budget,
        coarsest: 2,
        ..AccuracySettings::default()
    };
    println!(
        "scene                  sequence     unknowns  seconds  estimated      true  effectivity"
    );
    for (name, scene) in scenes(&folder)? {
        if !name.contains(&wanted) {
            continue;
        }
        let sequences = MeshSequences::measure(&scene, &folder, goal, &settings, &mut |_| {})?;
        for sequence in &sequences.sequences {
            for level in &sequence.levels {
                let [error, effectivity] = [level.error.map(|e| 100.0 * e), level.effectivity()]
                    .map(|known| known.map_or_else(|| "-".into(), |value| format!("{value:.2}")));
                println!(
                    "{name:<22} {:<12} {:>8} {:>8.2} {:>8.2} % {:>8.2} % {error:>7} % {effectivity:>12}  {}",
                    sequence.kind.words(),
                    level.n_free,
                    level.cost.seconds,
                    100.0 * level.estimated_error,
                    100.0 * level.contact_error,
                    level.status.word(),
                );
            }
        }
        let reference = &sequences.reference;
        println!(
            "{name:<22} reference    {:>8} {:>8.2} {:>8.2} %: J = {:.8e}",
            reference.level.n_free,
            reference.level.cost.seconds,
            100.0 * reference.level.estimated_error,
            reference.potential_energy,
        );
        println!("{name:<22} {}", sequences.advice());
    }
    Ok(())
}
