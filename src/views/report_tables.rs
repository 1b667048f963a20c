//! The tables of a report.

use contact3d::{
    history::StepRecord,
    mesh::Mesh,
    post::{ContactReport, SourceForce, Zone},
    scene::{FrictionModel, ModelFeatures, MultiplierSpace, Obstacle, Scene, shown},
    solver::Solution,
};
use plots::html::Table;
use runfile::{Reader, StoreError};
use units::{Dimension, Units};

use super::motion::{motion_words, neutral_words};
use super::{ESTIMATE_OF_REST, fold_words, radius_words, sign_words};
use crate::pipeline::{Freshness, StageState};

type Pair = (String, String);

fn pair(name: &str, value: impl ToString) -> Pair {
    (name.to_owned(), value.to_string())
}

fn yes_or_no(value: bool) -> &'static str {
    if value { "yes" } else { "no" }
}

/// What the scene calls for.
pub(super) fn features(scene: &Scene) -> Table {
    let features = ModelFeatures::of(scene);
    let mut pairs = vec![
        pair(
            "clamps with a prescribed displacement",
            features.prescribed_displacements,
        ),
        pair("springs", features.springs),
        pair("body force", yes_or_no(features.body_force)),
        pair("regions of other material", features.regions),
        pair("anisotropic material", yes_or_no(features.anisotropy)),
    ];
    if features.contact.is_empty() {
        pairs.push(pair("contact", "none"));
    }
    for face in &features.contact {
        let on = match features.contact.len() {
            1 => String::new(),
            _ => format!(" on {}", shown(&face.name)),
        };
        let named = |name: &str, value: &str| pair(&format!("{name}{on}"), value);
        pairs.extend([
            named("friction", &friction_words(&face.friction)),
            named(
                "obstacle",
                face.obstacle.as_ref().map_or("none", Obstacle::word),
            ),
            named("initial gap", yes_or_no(face.gap.is_some())),
            named("frame turns with the place", yes_or_no(face.turning_frame)),
            named(
                "multipliers",
                match face.space {
                    MultiplierSpace::Panes => "constant on panes",
                    MultiplierSpace::Nodal => "at nodes",
                },
            ),
        ]);
    }
    Table::of_pairs(pairs)
}

/// What happens on each of several contact faces; `None` for one.
pub(super) fn faces(scene: &Scene, report: &ContactReport) -> Option<Table> {
    let (force, stress) = (scene.units.force(), scene.units.stress());
    let rows = report.faces.iter().zip(ModelFeatures::of(scene).contact);
    let rows: Vec<Vec<String>> = rows
        .map(|(face, has)| {
            let contact = &face.contact;
            let numbers = |values: &[f64]| {
                let texts: Vec<String> = values.iter().map(|v| format!("{v:.6e}")).collect();
                texts.join(", ")
            };
            vec![
                shown(&has.name),
                face.zone_counts.map(|count| count.to_string()).join(", "),
                numbers(&[contact.normal_force]),
                contact.tangential_force.map_or("-".into(), |t| numbers(&t)),
                numbers(&contact.contact_force),
                numbers(&[contact.largest_pressure]),
            ]
        })
        .collect();
    let head = [
        "contact face".to_owned(),
        "open, stick, slip".to_owned(),
        format!("normal force [{force}]"),
        format!("tangential along t1, t2 [{force}]"),
        format!("force on the body x, y, z [{force}]"),
        format!("largest pressure [{stress}]"),
    ];
    (!rows.is_empty()).then(|| Table {
        caption: "Contact faces".into(),
        head: head.to_vec(),
        rows,
    })
}

fn friction_words(friction: &FrictionModel) -> String {
    let Some((name, coefficients)) = friction.name().zip(friction.coefficients()) else {
        return "none".into();
    };
    let mut words = format!("{name}, {}", coefficients.shape());
    if coefficients.depends_on_slip() {
        words += ", follows the slip";
    }
    if coefficients.depends_on_place() {
        words += ", varies with the place";
    }
    words
}

/// The increments of a load history.
pub(super) fn increments(scene: &Scene, records: &[StepRecord]) -> Table {
    let (force, energy) = (scene.units.force(), scene.units.energy());
    let head = [
        "step".to_owned(),
        "increment".to_owned(),
        "time [s]".to_owned(),
        "status".to_owned(),
        "open, stick, slip".to_owned(),
        format!("normal force [{force}]"),
        format!("tangential forces [{force}]"),
        format!("work of the loads [{energy}]"),
        format!("strain energy [{energy}]"),
        format!("dissipated [{energy}]"),
        format!("missing [{energy}]"),
    ];
    let rows = records.iter().map(|record| {
        let title = scene.step_title(record.increment.step);
        let [normal, first, second] = record.multiplier_force;
        let zones = record.zone_counts().map(|count| count.to_string());
        let energies = &record.energies;
        vec![
            shown(&title),
            record.increment.number.to_string(),
            record.increment.time.to_string(),
            record.status.word().to_owned(),
            zones.join(", "),
            format!("{normal:.5e}"),
            format!("{first:.5e}, {second:.5e}"),
            format!("{:.4e}", energies.load_work),
            format!("{:.4e}", energies.strain),
            format!("{:.4e}", energies.dissipation),
            format!("{:.1e}", energies.imbalance),
        ]
    });
    Table {
        caption: "Increments".to_owned(),
        head: head.to_vec(),
        rows: rows.collect(),
    }
}

/// The main figures of a solution.
pub(super) fn results(
    units: Units,
    mesh: &Mesh,
    solution: &Solution,
    report: &ContactReport,
) -> Table {
    let (length, force) = (units.length(), units.force());
    let r = &report.resultants;
    let vector = |v: &[f64]| {
        let texts: Vec<String> = v.iter().map(|v| format!("{v:.6e}")).collect();
        texts.join(", ")
    };
    let mut pairs = vec![
        pair("status", solution.status.word()),
        pair("accuracy", format!("{:.1e}", solution.accuracy)),
        pair("nodes", mesh.coordinates.len()),
        pair("tetrahedra", mesh.tetrahedra.len()),
        pair("unknowns", solution.displacement.len()),
        pair("multipliers", solution.multiplier.len()),
        pair("outer steps", solution.history.len()),
        pair("Newton steps", solution.newton.len()),
        pair("applications n_A", solution.applications),
    ];
    if let Some(local) = &solution.local_mapping {
        pairs.push(pair("spectral radius of Ψ'", radius_words(local)));
        pairs.extend(sign_words(local).map(|words| pair("sign of det R'", words)));
        pairs.extend(fold_words(local).map(|words| pair("distance from a fold", words)));
    }
    if let Some(contact) = &r.contact {
        pairs.extend([
            pair("open panes", report.count(Zone::Open)),
            pair("sticking panes", report.count(Zone::Stick)),
            pair("slipping panes", report.count(Zone::Slip)),
            pair(
                &format!("normal contact force [{force}]"),
                format!("{:.9e}", contact.normal_force),
            ),
            pair(
                &format!("largest pressure [{}]", units.stress()),
                format!("{:.9e}", contact.largest_pressure),
            ),
        ]);
        if let Some(tangential) = contact.tangential_force {
            let name = format!("tangential multiplier force [{force}]");
            pairs.push(pair(&name, vector(&tangential)));
        }
    }
    let motions = motion_words(units, mesh, solution, report).into_iter();
    let motions = motions.chain(neutral_words(units, mesh, solution));
    pairs.extend(motions.map(|(name, words)| pair(name, words)));
    pairs.extend([
        pair(
            &format!("strain energy [{}]", units.energy()),
            format!("{:.9e}", r.strain_energy),
        ),
        pair(
            &format!("largest displacement x, y, z [{length}]"),
            vector(&r.largest_displacement),
        ),
        pair(
            "discretisation error (energy norm, estimated)",
            match report.discretisation_error.displacement {
                0.0 => ESTIMATE_OF_REST.to_owned(),
                _ => format!("{:.1e}", report.discretisation_error.relative()),
            },
        ),
        pair("force imbalance", format!("{:.1e}", r.force_imbalance)),
        pair("moment imbalance", format!("{:.1e}", r.moment_imbalance)),
    ]);
    Table::of_pairs(pairs)
}

/// The forces on the body and their moments about the origin of coordinates, by their sources.
pub(super) fn forces(units: Units, report: &ContactReport) -> Table {
    let moment = units.word(Dimension::MOMENT);
    let mut head = vec!["source".to_owned(), "face".to_owned()];
    let columns = [("force", units.force()), ("moment", moment.as_str())];
    for (name, unit) in columns {
        head.extend(["x", "y", "z"].map(|axis| format!("{name} {axis} [{unit}]")));
    }
    let row = |row: &SourceForce| {
        let figures = row.force.iter().chain(&row.moment);
        let mut cells = vec![row.source.clone(), row.face.clone()];
        cells.extend(figures.map(|figure| format!("{figure:.6e}")));
        cells
    };
    Table {
        caption: "Forces on the body and their moments about the origin".into(),
        head,
        rows: report.forces.iter().map(row).collect(),
    }
}

/// How well the discrete problem is satisfied.
pub(super) fn certificate(report: &ContactReport) -> Table {
    let figures = report.certificate.figures().into_iter();
    Table::of_pairs(figures.map(|(name, v)| pair(&name.replace('_', " "), format!("{v:.1e}"))))
}

/// State, seconds and size of each stage.
pub(super) fn timings(reader: &Reader, states: &[StageState]) -> Result<Table, StoreError> {
    let mut rows = Vec::new();
    for state in states {
        let word = match (state.freshness.word(), &state.freshness) {
            (word, Freshness::Stale(why) | Freshness::Damaged(why)) => format!("{word}: {why}"),
            (word, _) => word.to_owned(),
        };
        let mut row = vec![state.stage.word().to_owned(), word];
        match &state.stored {
            None => row.extend(["-"; 4].map(str::to_owned)),
            Some(stored) => row.extend([
                format!("{:.3}", stored.record.seconds),
                stored.record.threads.to_string(),
                format!(
                    "{:.3}",
                    reader.group_bytes(state.stage.group())? as f64 / 1e6
                ),
                stored.record.date.clone(),
            ]),
        }
        rows.push(row);
    }
    Ok(Table {
        caption: String::new(),
        head: ["stage", "state", "seconds", "threads", "MB", "date"]
            .map(str::to_owned)
            .into(),
        rows,
    })
}
