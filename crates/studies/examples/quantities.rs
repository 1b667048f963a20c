//! Estimated over true errors of forces, displacements, mean pressures and energies: adaptive levels judged by the last one.
//!
//! `cargo run --release -p contact3d-studies --example quantities -- 0.06 gap` refines until the energy norm errs by 6 %, for scenes
//! with "gap" in their name.

use std::{error::Error, path::Path};

use contact3d::{
    Problem,
    adaptation::adapted,
    mesh::Mesh,
    post::FunctionalEstimate,
    scene::{AdaptSettings, ElementOrder, FirstMesh, Functional, Scene, SceneFile},
};

/// Scenes of `pipelines/`, with the cells of the first mesh.
const PIPELINES: [&str; 13] = [
    "newton",
    "hkl2011_table2",
    "frictionless",
    "gap",
    "regions",
    "orthotropic_material",
    "tresca",
    "turning_frame",
    "elastic_only",
    "springs",
    "pressed",
    "nodal",
    "capped",
];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let goal = arguments.next().map_or(Ok(0.06), |text| text.parse())?;
    let wanted = arguments.next().unwrap_or_default();
    let orders = match arguments.next().as_deref() {
        Some("P1") => vec![ElementOrder::P1],
        Some("P2") => vec![ElementOrder::P2],
        _ => vec![ElementOrder::P2, ElementOrder::P1],
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines");
    for name in PIPELINES.iter().filter(|name| name.contains(&wanted)) {
        let scene = SceneFile::read(&folder.join(format!("{name}.toml")))?.scene;
        for element in &orders {
            measure(name, &scene, &folder, *element, goal)?;
        }
    }
    Ok(())
}

fn measure(
    name: &str,
    scene: &Scene,
    folder: &Path,
    element: ElementOrder,
    goal: f64,
) -> Result<(), Box<dyn Error>> {
    let mut scene = scene.clone();
    let goal = if element == ElementOrder::P1 {
        2.0 * goal
    } else {
        goal
    };
    scene.bodies[0].element = element;
    scene.solve = Default::default();
    scene.assemble = Default::default();
    if let Some(brick) = scene.as_brick_mut() {
        brick.cells = brick.cells.map(|n| 2.max(n / 8));
        brick.cells = brick.cells.map(|n| n + n % 2);
    }
    scene.adapt = Some(AdaptSettings {
        error: goal,
        of: None,
        start: FirstMesh::Scene,
    });
    let (last, levels) = adapted(scene.clone(), folder)?;
    let refinement = &levels.adaptation.refinement;
    let mut wanted: Vec<Option<Functional>> = vec![None];
    if let Some(corners) = mean_box(&last.report.functionals) {
        wanted.push(Some(Functional::MeanDisplacement {
            corners,
            component: contact3d::scene::Component::Z,
        }));
    }
    if !scene.contacts.is_empty() {
        let extent = last
            .problem
            .mesh()
            .coordinates
            .iter()
            .fold([0.0; 3], |most: [f64; 3], x| {
                std::array::from_fn(|c| most[c].max(x[c]))
            });
        wanted.push(Some(Functional::MeanPressure {
            corners: [
                [0.3 * extent[0], 0.2 * extent[1], -10.0 * extent[2]],
                [0.9 * extent[0], 0.9 * extent[1], 10.0 * extent[2]],
            ],
        }));
    }
    let mut levels: Vec<(usize, f64, Vec<FunctionalEstimate>)> = Vec::new();
    for level in 0..=refinement.len() {
        let mut cuts = refinement.clone();
        cuts.truncate(level);
        let mut all: Vec<FunctionalEstimate> = Vec::new();
        let mut size = (0, 0.0);
        for of in &wanted {
            scene.adapt = Some(AdaptSettings {
                error: goal,
                of: *of,
                start: FirstMesh::Scene,
            });
            let mesh = Mesh::refined(&scene, folder, &cuts)?;
            let problem = Problem::on_mesh(scene.clone(), mesh)?.assemble()?;
            let (_, report) = problem.solve_and_report(&scene.solve)?;
            size = (problem.n_free(), report.discretisation_error.relative());
            for found in report.functionals {
                if !all.iter().any(|known| known.functional == found.functional) {
                    all.push(found);
                }
            }
        }
        levels.push((size.0, size.1, all));
    }
    let reference = &levels[levels.len() - 1].2;
    for (n_free, error, found) in &levels {
        for it in found {
            let Some(best) = reference
                .iter()
                .find(|best| best.functional == it.functional)
            else {
                continue;
            };
            let truth = best.value - it.value;
            println!(
                "{name:<20} {element:?} {n_free:>7} {:>6.2} % {:<20} {:>14.7e} true {:>10.3e} ({:>8.4} %) estimated {:>10.3e}  effectivity {:>7.2}  kinks {}",
                100.0 * error,
                it.functional.word(),
                it.value,
                truth,
                100.0 * truth / best.value,
                it.signed_error,
                it.signed_error / truth,
                it.kinks,
            );
        }
    }
    Ok(())
}

fn mean_box(found: &[FunctionalEstimate]) -> Option<[[f64; 3]; 2]> {
    let peak = found
        .iter()
        .find(|it| it.functional == Functional::PeakDisplacement)?;
    peak.corners
}
